"""A batch of frames as the columns of a rerun recording, one set for each entity."""

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pyarrow as pa
import rerun as rr
from numpy.typing import NDArray

import fcw_viz.rerun.blueprint as scene
from fcw.box import Box
from fcw.frame import VideoPacket
from fcw.logs.overlay import (
    LEVEL_COLORS,
    PIXEL_CENTRE_PX,
    VEHICLE_LENGTH_M,
    Rgb,
    overlay_boxes,
    rear_size_m,
)
from fcw.logs.records import DriveHeader, FrameResult
from fcw.tracking.types import Track
from fcw.units import FEET_PER_METRE, MPH_PER_MPS
from fcw.warning.describe import describe
from fcw.warning.types import WarningLevel

Columns = list[rr.ComponentColumn]

UNBOUNDED_M = 200.0
"""Where the interval of a distance without an upper end is drawn to."""
LEAD_WIDTH = rr.Radius.ui_points(1.5)
OTHER_WIDTH = rr.Radius.ui_points(0.75)
UNTOLD_WIDTH = rr.Radius.ui_points(0.5)
TEXT_LOG_LEVELS = {
    WarningLevel.NONE: rr.TextLogLevel.INFO,
    WarningLevel.ADVISORY: rr.TextLogLevel.INFO,
    WarningLevel.CAUTION: rr.TextLogLevel.WARN,
    WarningLevel.WARNING: rr.TextLogLevel.ERROR,
}
CALENDAR_NS = 10 * 365 * 86_400 * 1_000_000_000
"""Ten years: no drive lasts so long, and no log was stamped before 1980."""
NO_VALUES = (math.nan, math.nan, math.nan)


def is_calendar_time(time_ns: int) -> bool:
    """Whether a drive's first time counts from 1970, as recorders stamp, and not from its own beginning."""
    return time_ns >= CALENDAR_NS


def time_columns(
    times_ns: Sequence[int], indexes: Sequence[int] | None = None, calendar: bool = False
) -> list[rr.TimeColumn]:
    """The time lines of some rows.

    Args:
        times_ns: on the source's clock.
        indexes: of the frames; without them the rows have no place on the frame time line.
        calendar: the clock counts from 1970, and is shown as day and hour.
    """
    clock_ns = np.array(times_ns, np.int64)
    columns = [
        rr.TimeColumn(scene.TIME_TIMELINE, timestamp=clock_ns.astype("datetime64[ns]"))
        if calendar
        else rr.TimeColumn(scene.TIME_TIMELINE, duration=clock_ns.astype("timedelta64[ns]"))
    ]
    return columns if indexes is None else [rr.TimeColumn(scene.FRAME_TIMELINE, sequence=indexes), *columns]


def video_columns(packets: Sequence[VideoPacket]) -> Columns:
    """Video samples, and of each one whether it is a keyframe and whether its picture belongs to the drive.

    rerun's own `is_keyframe` is left out: it may mark keyframes but not deny them, and the viewer finds them.
    """
    marks = _values(
        "fcw.Packet",
        keyframe=pa.array([packet.keyframe for packet in packets], pa.bool_()),
        shown=pa.array([packet.shown for packet in packets], pa.bool_()),
    )
    return [*rr.VideoStream.columns(sample=[packet.data for packet in packets]), *marks]


def result_columns(results: Sequence[FrameResult], header: DriveHeader) -> Iterator[tuple[str, Columns]]:
    """Entity paths with their columns, one row for each frame.

    Args:
        results: consecutive frames.
        header: of the drive.
    """
    yield scene.FRAMES, list(_frames(results))
    yield scene.IMAGE_DETECTIONS, _detections(results)
    yield from _vehicles(results, header)
    yield from _plots(results, header.imperial)


def level_columns(results: Sequence[FrameResult]) -> Columns:
    """The warning level as a state, by name."""
    return list(rr.StateChange.columns(state=[result.warning.level.name.lower() for result in results]))


def log_columns(results: Sequence[FrameResult], imperial: bool) -> Columns:
    """The warning and its reason in words."""
    levels = [result.warning.level for result in results]
    return list(
        rr.TextLog.columns(
            text=[_words(result, imperial) for result in results],
            level=[TEXT_LOG_LEVELS[level] for level in levels],
        )
    )


def _words(result: FrameResult, imperial: bool) -> str:
    return describe(result.told_warning, imperial)


def _motion(name: str) -> Callable[[FrameResult], float | None]:
    return lambda result: None if result.own_motion is None else getattr(result.own_motion, name)


def _mount(name: str) -> Callable[[FrameResult], float | None]:
    return lambda result: (
        None
        if result.own_motion is None or result.own_motion.mount is None
        else getattr(result.own_motion.mount, name)
    )


def _path(name: str) -> Callable[[FrameResult], float | None]:
    return lambda result: None if result.own_path is None else getattr(result.own_path, name)


OWN_VALUES = (
    ("ego_speed_sigma_mps", _motion("speed_sigma_mps")),
    ("yaw_rate_radps", _motion("yaw_rate_radps")),
    ("camera_yaw_rad", _mount("yaw_rad")),
    ("camera_pitch_rad", _mount("pitch_rad")),
    ("camera_roll_rad", _mount("roll_rad")),
    ("path_curvature_per_m", _path("curvature_per_m")),
    ("path_offset_m", _path("offset_m")),
    ("path_heading_rad", _path("heading_rad")),
)


def _frames(results: Sequence[FrameResult]) -> rr.ComponentColumnList:
    warnings = [result.told_warning for result in results]
    return _values(
        "fcw.Frame",
        index=pa.array([result.index for result in results], pa.int64()),
        time_ns=pa.array([result.time_ns for result in results], pa.int64()),
        searched=pa.array([result.searched for result in results], pa.bool_()),
        lead_id=pa.array([result.lead_id for result in results], pa.int64()),
        ego_speed_mps=pa.array([result.ego_speed_mps for result in results], pa.float64()),
        **{name: pa.array([value(result) for result in results], pa.float64()) for name, value in OWN_VALUES},
        warning_level=pa.array([warning.level.name.lower() for warning in warnings], pa.string()),
        warning_track_id=pa.array([warning.track_id for warning in warnings], pa.int64()),
        rule=pa.array([warning.rule for warning in warnings], pa.string()),
        ttc_s=pa.array([warning.ttc_s for warning in warnings], pa.float64()),
        required_deceleration_mps2=pa.array(
            [warning.required_deceleration_mps2 for warning in warnings], pa.float64()
        ),
        headway_s=pa.array([warning.headway_s for warning in warnings], pa.float64()),
        **{
            f"warning_{name}": pa.array([getattr(warning, name) for warning in warnings], pa.float64())
            for name in (
                "distance_m",
                "distance_low_m",
                "distance_high_m",
                "closing_speed_mps",
                "overlap_m",
                "collision_probability",
                "needed_distance_m",
            )
        },
        warning_assumes=pa.array([warning.assumes for warning in warnings], pa.string()),
        warning_extrapolated=pa.array([warning.extrapolated for warning in warnings], pa.bool_()),
    )


def _detections(results: Sequence[FrameResult]) -> Columns:
    detections = [detection for result in results for detection in result.detections]
    counts = [len(result.detections) for result in results]
    centers, half_sizes = _boxes([detection.box for detection in detections])
    boxes = rr.Boxes2D.columns(centers=centers, half_sizes=half_sizes)
    scores = pa.array([detection.score for detection in detections], pa.float32())
    return [*boxes.partition(counts), *_values("fcw.Detection", score=scores).partition(counts)]


def _vehicles(results: Sequence[FrameResult], header: DriveHeader) -> Iterator[tuple[str, Columns]]:
    """The tracks in the picture and on the road, and the intervals of their distances."""
    tracks = [track for result in results for track in result.tracks]
    drawn = [box for result in results for box in overlay_boxes(result, header.imperial)]
    counts = [len(result.tracks) for result in results]
    labels = [box.label for box in drawn]
    colors = _packed_colors([box.color for box in drawn])
    radii = np.array(
        [LEAD_WIDTH if box.is_lead else OTHER_WIDTH if box.told else UNTOLD_WIDTH for box in drawn],
        np.float32,
    )

    centers, half_sizes = _boxes([box.box for box in drawn])
    boxes = rr.Boxes2D.columns(
        centers=centers, half_sizes=half_sizes, labels=labels, colors=colors, radii=radii
    )
    yield scene.IMAGE_VEHICLES, [*boxes.partition(counts), *_track_values(tracks).partition(counts)]

    sizes = np.array(
        [(VEHICLE_LENGTH_M, *rear_size_m(track, header.calibration)) for track in tracks], np.float32
    ).reshape(-1, 3)
    rears = np.array([(t.distance_m, t.lateral_m, 0.0) for t in tracks], np.float32).reshape(-1, 3)
    boxes = rr.Boxes3D.columns(
        centers=rears + sizes * np.array((0.5, 0.0, 0.5), np.float32),
        half_sizes=sizes / 2,
        labels=labels,
        colors=colors,
        radii=radii,
    )
    yield scene.VEHICLES, [*boxes.partition(counts), *_lead_intervals(results)]


def _lead_intervals(results: Sequence[FrameResult]) -> rr.ComponentColumnList:
    """The interval of the lead's distance as a line along the road; others' would crowd it."""
    leads = [result.lead for result in results]
    ends = [
        (
            (lead.distance_low_m, lead.lateral_m, 0.0),
            (min(lead.distance_high_m, UNBOUNDED_M), lead.lateral_m, 0.0),
        )
        for lead in leads
        if lead is not None
    ]
    colors = [LEVEL_COLORS[result.warning.level] for result in results if result.lead is not None]
    strips = rr.LineStrips3D.columns(
        strips=np.array(ends, np.float32).reshape(-1, 2, 3), colors=_packed_colors(colors)
    )
    return strips.partition([int(lead is not None) for lead in leads])


def _track_values(tracks: Sequence[Track]) -> rr.ComponentColumnList:
    """What people look for on hovering over a box; float32 is enough to look at."""
    single = {
        name: pa.array([getattr(track, name) for track in tracks], pa.float32())
        for name in (
            "distance_m",
            "distance_low_m",
            "distance_high_m",
            "closing_speed_mps",
            "ttc_s",
        )
    }
    return _values(
        "fcw.Track",
        track_id=pa.array([track.track_id for track in tracks], pa.int32()),
        seen_by=pa.array([track.seen_by.value for track in tracks], pa.string()),
        coasting=pa.array([track.coasting for track in tracks], pa.bool_()),
        in_path=pa.array([track.in_path for track in tracks], pa.bool_()),
        **single,
    )


def _plots(results: Sequence[FrameResult], imperial: bool) -> Iterator[tuple[str, Columns]]:
    """The warned vehicle over time, else the lead; NaN, which breaks a line, where there is neither."""
    length, speed = (FEET_PER_METRE, MPH_PER_MPS) if imperial else (1.0, 1.0)
    distances, speeds, ttcs = [], [], []
    for result in results:
        warning, vehicle = result.told_warning, result.warned or result.lead
        if warning.extrapolated and warning.distance_m is not None:
            distances.append((warning.distance_m, warning.distance_low_m, _finite(warning.distance_high_m)))
            speeds.append((warning.closing_speed_mps, math.nan, math.nan))
            ttcs.append(math.nan if warning.ttc_s is None else warning.ttc_s)
        elif vehicle is None:
            distances.append(NO_VALUES)
            speeds.append(NO_VALUES)
            ttcs.append(math.nan)
        else:
            closing, sigma = vehicle.closing_speed_mps, vehicle.closing_speed_sigma_mps
            distances.append((vehicle.distance_m, vehicle.distance_low_m, _finite(vehicle.distance_high_m)))
            speeds.append((closing, closing - sigma, closing + sigma))
            ttcs.append(math.nan if vehicle.ttc_s is None else vehicle.ttc_s)
    yield scene.PLOT_DISTANCE, list(rr.Scalars.columns(scalars=np.array(distances) * length))
    yield scene.PLOT_SPEED, list(rr.Scalars.columns(scalars=np.array(speeds) * speed))
    yield scene.PLOT_TTC, list(rr.Scalars.columns(scalars=np.array(ttcs)))


def _finite(value: float | None) -> float:
    return value if value is not None and math.isfinite(value) else math.nan


def _boxes(boxes: Sequence[Box]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres and half sizes, each (N, 2), in rerun's pixel coordinates."""
    corners = np.array([(box.x, box.y) for box in boxes], np.float64).reshape(-1, 2)
    half_sizes = np.array([(box.w / 2, box.h / 2) for box in boxes], np.float64).reshape(-1, 2)
    return corners + half_sizes + PIXEL_CENTRE_PX, half_sizes


def _values(archetype: str, **fields: pa.Array) -> rr.ComponentColumnList:
    """Numbers and words as one column of structs: each column of a file costs a kilobyte in its footer."""
    structs = pa.StructArray.from_arrays(list(fields.values()), names=list(fields))
    return rr.DynamicArchetype.columns(archetype, drop_untyped_nones=False, components={"values": structs})


def _packed_colors(colors: Sequence[Rgb]) -> NDArray[np.uint32]:
    """Opaque colours as rerun packs them: 0xRRGGBBAA."""
    return np.array([r << 24 | g << 16 | b << 8 | 0xFF for r, g, b in colors], np.uint32)
