"""Made drives written as rerun recordings, and the rows that are read back."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import pyarrow as pa
from rerun.chunk import RrdReader

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize, VideoPacket
from fcw.logs.records import DriveHeader, FrameResult
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.rerun import blueprint as scene
from fcw_viz.rerun.log import RerunSink

CAMERA = GroundPlaneCamera(
    pitch_rad=0.05, focal_y_px=900.0, principal_row_px=350.0, height_m=1.3, principal_column_px=630.0
)
CALIBRATION = Calibration.from_camera(CAMERA, ImageSize(1280, 720), reference_offset_m=1.9)
HEADER = DriveHeader(
    source="drive.mp4",
    image_size=CALIBRATION.image_size,
    frame_rate_hz=29.97,
    calibration=CALIBRATION,
    relays_video=True,
    detector="acf",
    model_sha256="ab" * 32,
    versions={"fcw": "0.1.0", "numpy": "2.3"},
)
TRACK = Track(
    track_id=7,
    box=Box(x=100.0, y=200.0, w=90.0, h=60.0),
    score=4.5,
    distance_m=20.0,
    distance_low_m=19.0,
    distance_high_m=22.0,
    lateral_m=0.5,
    closing_speed_mps=8.0,
    closing_speed_sigma_mps=0.5,
    ttc_s=2.5,
    age_s=1.0,
    seen_by=SeenBy.DETECTOR,
    in_path=True,
)
CAUTION = WarningState(WarningLevel.CAUTION, track_id=7, rule="ttc", ttc_s=2.5)
QUIET = WarningState(WarningLevel.NONE)
NTSC_FRAME_NS = Fraction(1001 * 10**9, 30000)


def ntsc_time_ns(index: int) -> int:
    """Times that no binary fraction of a second meets."""
    return round(index * NTSC_FRAME_NS)


def result(index: int, tracks: Sequence[Track] = (), warning: WarningState = QUIET) -> FrameResult:
    return FrameResult(
        index=index,
        time_ns=ntsc_time_ns(index),
        detections=tuple(Detection(track.box, track.score) for track in tracks),
        tracks=tuple(tracks),
        lead_id=tracks[0].track_id if tracks else None,
        warning=warning,
        ego_speed_mps=None,
    )


def packet(index: int, shown: bool = True) -> VideoPacket:
    return VideoPacket(f"picture {index}".encode(), ntsc_time_ns(index), keyframe=index == 0, shown=shown)


def write_drive(path: Path, results: Sequence[FrameResult], header: DriveHeader = HEADER) -> Path:
    sink = RerunSink(path)
    sink.open(header)
    for each in results:
        sink.write(each, [packet(each.index)])
    sink.close()
    return path


def rows(path: Path, entity: str) -> Iterator[dict[str, object]]:
    """Rows of an entity in the file's order; time lines as whole numbers, components as lists."""
    for chunk in RrdReader(path).stream().filter(content=f"/{entity}"):
        batch = chunk.to_record_batch()
        names = [name for name in batch.schema.names if not name.startswith("rerun.")]
        columns = {
            name: column.cast(pa.int64()) if pa.types.is_duration(column.type) else column
            for name in names
            for column in (batch.column(name),)
        }
        yield from pa.table(columns).to_pylist()


def only_row(path: Path, entity: str) -> dict[str, object]:
    (row,) = rows(path, entity)
    return row


def values(row: dict[str, object], archetype: str) -> dict[str, object]:
    """The struct of numbers that a row has for its one vehicle, frame or packet."""
    (struct,) = row[f"{archetype}:values"]  # pyright: ignore[reportGeneralTypeIssues]
    return struct


def video_samples(path: Path) -> list[dict[str, object]]:
    """All rows of the video but its static one."""
    return [row for row in rows(path, scene.VIDEO) if "VideoStream:sample" in row]


def entities(path: Path) -> set[str]:
    return {str(chunk.entity_path).lstrip("/") for chunk in RrdReader(path).stream()}
