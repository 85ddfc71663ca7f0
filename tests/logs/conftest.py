"""A header, and frame results of any content."""

import pytest
from hypothesis import strategies as st

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize, VideoPacket
from fcw.logs.records import DriveHeader, FrameResult
from fcw.motion.state import Mount, OwnMotion, OwnPath, SpeedSource
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState

numbers = st.floats(allow_nan=False)
identities = st.integers(1, 2**53)
boxes = st.builds(Box, numbers, numbers, numbers, numbers)
tracks = st.builds(
    Track,
    track_id=identities,
    box=boxes,
    score=numbers,
    distance_m=numbers,
    distance_low_m=numbers,
    distance_high_m=numbers,
    lateral_m=numbers,
    closing_speed_mps=numbers,
    closing_speed_sigma_mps=numbers,
    ttc_s=st.none() | numbers,
    age_s=numbers,
    seen_by=st.sampled_from(SeenBy),
    in_path=st.booleans(),
    closing_acceleration_mps2=numbers,
    closing_acceleration_sigma_mps2=numbers,
    lateral_speed_mps=numbers,
    width_m=numbers,
    lateral_sigma_m=numbers,
    lateral_speed_sigma_mps=numbers,
    lateral_slowing_mps2=numbers,
    lateral_speed_by_bearing_mps=st.none() | numbers,
    lateral_speed_by_bearing_sigma_mps=numbers,
    doubtful=st.booleans(),
    found_part=numbers,
)
warning_states = st.builds(
    WarningState,
    level=st.sampled_from(WarningLevel),
    track_id=st.none() | identities,
    rule=st.text(max_size=12),
    ttc_s=st.none() | numbers,
    required_deceleration_mps2=st.none() | numbers,
    headway_s=st.none() | numbers,
    distance_m=st.none() | numbers,
    distance_low_m=st.none() | numbers,
    distance_high_m=st.none() | numbers,
    closing_speed_mps=st.none() | numbers,
    overlap_m=st.none() | numbers,
    collision_probability=st.none() | numbers,
    needed_distance_m=st.none() | numbers,
    assumes=st.text(max_size=12),
    extrapolated=st.booleans(),
)
mounts = st.builds(
    Mount,
    pitch_rad=numbers,
    yaw_rad=numbers,
    roll_rad=numbers,
    pitch_sigma_rad=numbers,
    yaw_sigma_rad=numbers,
    roll_sigma_rad=numbers,
)
own_motions = st.builds(
    OwnMotion,
    speed_mps=st.none() | numbers,
    speed_sigma_mps=st.none() | numbers,
    speed_source=st.sampled_from(SpeedSource),
    yaw_rate_radps=st.none() | numbers,
    yaw_rate_sigma_radps=st.none() | numbers,
    mount=st.none() | mounts,
    picture_speed_mps=st.none() | numbers,
)
own_paths = st.builds(
    OwnPath,
    offset_m=numbers,
    heading_rad=numbers,
    curvature_per_m=numbers,
    offset_sigma_m=numbers,
    heading_sigma_rad=numbers,
    curvature_sigma_per_m=numbers,
    lane_width_m=st.none() | numbers,
)
frame_results = st.builds(
    FrameResult,
    index=st.integers(0, 2**40),
    time_ns=st.integers(-(2**62), 2**62),
    detections=st.lists(st.builds(Detection, boxes, numbers), max_size=3).map(tuple),
    tracks=st.lists(tracks, max_size=4).map(tuple),
    lead_id=st.none() | identities,
    warning=warning_states,
    ego_speed_mps=st.none() | numbers,
    notes=st.lists(st.text(max_size=12), max_size=2).map(tuple),
    own_motion=st.none() | own_motions,
    own_path=st.none() | own_paths,
    searched=st.booleans(),
    repeated=st.booleans(),
)


@pytest.fixture(scope="session")
def any_frame_result() -> st.SearchStrategy[FrameResult]:
    """Frame results of any content but NaN, which equals nothing."""
    return frame_results


@pytest.fixture(scope="session")
def header() -> DriveHeader:
    """A camera 1.4 m high that looks 2 degrees down, 1.7 m behind the bumper."""
    size = ImageSize(1280, 720)
    camera = GroundPlaneCamera(0.035, 1000.0, 355.0, 1.4, 644.0)
    return DriveHeader(
        source="drive.mp4",
        image_size=size,
        frame_rate_hz=30000 / 1001,
        calibration=Calibration.from_camera(camera, size, reference_offset_m=1.7),
        relays_video=True,
        detector="acf",
        model_sha256="ab" * 32,
        versions={"fcw": "0.1.0", "numpy": "2.4"},
        imperial=False,
    )


def lead_result(index: int, time_ns: int, level: WarningLevel = WarningLevel.NONE) -> FrameResult:
    """A frame with two vehicles, the second of them the lead."""
    box = Box(600.0, 380.0, 80.0, 60.0)
    other = Track(
        1, Box(100, 390, 50, 40), 4.0, 30.0, 28.0, 33.0, 5.0, -1.0, 0.5, None, 2.0, SeenBy.DETECTOR, False
    )
    lead = Track(7, box, 9.5, 20.0, 19.0, 21.2, 0.25, 8.0, 0.4, 2.5, 3.0, SeenBy.DETECTOR, True)
    state = (
        WarningState(level) if level == WarningLevel.NONE else WarningState(level, 7, "ttc", 2.5, 3.2, None)
    )
    return FrameResult(index, time_ns, (Detection(box, 9.5),), (other, lead), 7, state, 22.0)


@pytest.fixture(scope="session")
def short_drive() -> list[tuple[FrameResult, tuple[VideoPacket, ...]]]:
    """Ten seconds at 10 frames a second; two packets before time 0 feed the decoder; levels rise and fall."""
    levels = [WarningLevel.NONE] * 20 + [WarningLevel.CAUTION] * 30 + [WarningLevel.WARNING] * 10
    levels += [WarningLevel.NONE] * 40
    drive: list[tuple[FrameResult, tuple[VideoPacket, ...]]] = []
    for i, level in enumerate(levels):
        time_ns = i * 100_000_000
        own = VideoPacket(b"picture %d" % i, time_ns, i % 10 == 0, shown=True)
        before = tuple(
            VideoPacket(b"feed %d" % k, k * 100_000_000, k == -2, shown=False) for k in (-2, -1) if i == 0
        )
        drive.append((lead_result(i, time_ns, level), (*before, own)))
    return drive
