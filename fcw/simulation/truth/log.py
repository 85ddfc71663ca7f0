"""The truth of a drive as a drive log, for every program that opens such logs."""

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from fcw.camera.calibration import Calibration
from fcw.files import whole_file
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth, warning_is_due
from fcw.sources import open_source
from fcw.tracking.types import SeenBy, Track
from fcw.versions import versions
from fcw.warning.driver import RULE_BRAKING_DUE
from fcw.warning.types import WarningLevel, WarningState

TRUTH_DETECTOR = "truth"
SEEN_FRACTION = 0.3
"""A vehicle less visible than this is in the truth log as one that is followed without being seen."""


def write_truth_log(path: Path, video: Path, calibration: Calibration, frames: Sequence[FrameTruth]) -> None:
    """Write the truth with the video.

    The vehicles ahead stand in it as tracks without uncertainty; the warning is raised while the driver
    of the default policy (1.2 s, 0.4 g) must be warned.
    """
    source = open_source(video)
    ids = {name: k for k, name in enumerate(sorted({v.name for frame in frames for v in frame.vehicles}), 1)}
    header = DriveHeader(
        source=source.name,
        image_size=source.image_size,
        frame_rate_hz=source.frame_rate_hz,
        calibration=calibration,
        relays_video=source.relays_video,
        detector=TRUTH_DETECTOR,
        model_sha256="",
        versions=versions(),
    )
    with whole_file(path) as partial, closing(McapSink(partial)) as sink:
        sink.open(header)
        for frame, truth in zip(source.frames(), frames, strict=True):
            sink.write(truth_result(frame.index, frame.time_ns, truth, ids), frame.packets)


def truth_result(index: int, time_ns: int, truth: FrameTruth, ids: dict[str, int]) -> FrameResult:
    """The truth of a frame in the shape of a result of the pipeline."""
    lead = truth.lead
    due = lead is not None and warning_is_due(lead)
    lead_id = None if lead is None else ids[lead.name]
    state = WarningState(WarningLevel.NONE)
    if due:
        assert lead is not None
        state = WarningState(WarningLevel.WARNING, lead_id, RULE_BRAKING_DUE, lead.ttc_s)
    tracks = tuple(sorted((_track(v, ids) for v in truth.vehicles), key=lambda track: track.track_id))
    return FrameResult(index, time_ns, (), tracks, lead_id, state, truth.ego_speed_mps)


def _track(vehicle: VehicleTruth, ids: dict[str, int]) -> Track:
    return Track(
        track_id=ids[vehicle.name],
        box=vehicle.box,
        score=vehicle.visible_fraction,
        distance_m=vehicle.distance_m,
        distance_low_m=vehicle.distance_m,
        distance_high_m=vehicle.distance_m,
        lateral_m=vehicle.lateral_m,
        closing_speed_mps=vehicle.closing_speed_mps,
        closing_speed_sigma_mps=0.0,
        ttc_s=vehicle.ttc_s,
        age_s=0.0,
        seen_by=SeenBy.COASTING if vehicle.visible_fraction < SEEN_FRACTION else SeenBy.DETECTOR,
        in_path=vehicle.in_path,
    )
