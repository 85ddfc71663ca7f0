"""What stays the same during a drive in its rerun recording, and what does where nobody moves the camera."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import astuple

import numpy as np
import pyarrow as pa
import rerun as rr
from numpy.typing import NDArray

import fcw_viz.rerun.blueprint as scene
from fcw.camera.calibration import Calibration
from fcw.camera.file import calibration_text
from fcw.logs.overlay import (
    LEVEL_COLORS,
    OTHER_TRACK_COLOR,
    OWN_CAR_SIZE_M,
    PIXEL_CENTRE_PX,
    ROW_COLOR,
    ROW_DISTANCES_M,
    Rgb,
    overlay_rows,
)
from fcw.logs.records import DriveHeader
from fcw.tracking.lead import Corridor
from fcw.units import distance_text
from fcw.warning.types import WarningLevel
from fcw_viz.rerun.columns import Columns

PATH_COLOR: Rgb = (70, 110, 160)
LINE_HALF_LENGTH_M = 12.0
"""Of the lines across the road at fixed distances: their words stand clear of three lanes to either side."""
FRUSTUM_M = 2.0
"""Depth at which the picture stands before the camera in the ground view."""


def log_static_scene(recording: rr.RecordingStream, header: DriveHeader) -> None:
    """Log all that stays the same during a drive.

    Args:
        recording: the open recording.
        header: of the drive.
    """
    _log_texts(recording, header)
    _log_camera(recording, header.calibration)
    _log_road(recording, header)
    _log_styles(recording)


def camera_axes(pitch_rad: float) -> NDArray[np.float64]:
    """(3, 3) rotation whose columns are the camera's right, down and forward in vehicle axes."""
    sine, cosine = math.sin(pitch_rad), math.cos(pitch_rad)
    return np.array([[0.0, -sine, cosine], [-1.0, 0.0, 0.0], [0.0, -cosine, -sine]])


def _log_camera(recording: rr.RecordingStream, calibration: Calibration) -> None:
    camera = calibration.camera
    recording.log(scene.EGO, rr.ViewCoordinates.FLU, static=True, strict=True)
    recording.log(
        scene.IMAGE,
        rr.Pinhole(
            focal_length=camera.focal_y_px,
            principal_point=(
                camera.principal_column_px + PIXEL_CENTRE_PX,
                camera.principal_row_px + PIXEL_CENTRE_PX,
            ),
            resolution=astuple(calibration.image_size),
            camera_xyz=rr.ViewCoordinates.RDF,
            image_plane_distance=FRUSTUM_M,
        ),
        static=True,
        strict=True,
    )
    recording.log(scene.VIDEO, rr.VideoStream(codec=rr.VideoCodec.H264), static=True, strict=True)


def _log_road(recording: rr.RecordingStream, header: DriveHeader) -> None:
    recording.log(
        scene.EGO_BODY,
        rr.Boxes3D(
            centers=[(-OWN_CAR_SIZE_M[0] / 2, 0.0, OWN_CAR_SIZE_M[2] / 2)],
            sizes=[OWN_CAR_SIZE_M],
            colors=[PATH_COLOR],
        ),
        static=True,
        strict=True,
    )
    far_m = ROW_DISTANCES_M[-1]
    half_width_m = Corridor().leave_m
    recording.log(
        scene.PATH,
        rr.LineStrips3D(
            [[(0.0, side, 0.0), (far_m, side, 0.0)] for side in (-half_width_m, half_width_m)],
            colors=[PATH_COLOR],
            radii=rr.Radius.ui_points(1.5),
        ),
        static=True,
        strict=True,
    )
    recording.log(
        scene.DISTANCES,
        rr.LineStrips3D(
            [[(d, LINE_HALF_LENGTH_M, 0.0), (d, -LINE_HALF_LENGTH_M, 0.0)] for d in ROW_DISTANCES_M],
            colors=[ROW_COLOR],
            radii=rr.Radius.ui_points(0.5),
        ),
        rr.Points3D(
            [(d, -LINE_HALF_LENGTH_M, 0.0) for d in ROW_DISTANCES_M],
            labels=[distance_text(d, header.imperial) for d in ROW_DISTANCES_M],
            colors=[ROW_COLOR],
            radii=rr.Radius.ui_points(0.0),
            show_labels=True,
        ),
        static=True,
        strict=True,
    )


def look_columns(pitches_rad: Sequence[float], header: DriveHeader) -> Iterator[tuple[str, Columns]]:
    """Where the camera looks, and at which rows the distances are then: entity paths with their columns.

    Args:
        pitches_rad: of the camera, one for each row of the columns.
        header: of the drive.
    """
    calibration, width = header.calibration, header.image_size.width
    position_m = (-calibration.reference_offset_m, 0.0, calibration.camera.height_m)
    yield (
        scene.CAMERA,
        [
            *rr.Transform3D.columns(
                translation=[position_m] * len(pitches_rad),
                mat3x3=[camera_axes(pitch_rad) for pitch_rad in pitches_rad],
            )
        ],
    )
    looks = [overlay_rows(calibration, header.imperial, pitch_rad) for pitch_rad in pitches_rad]
    rows, counts = [row for look in looks for row in look], [len(look) for look in looks]
    heights = [row.row_px + PIXEL_CENTRE_PX for row in rows]
    lines = rr.LineStrips2D.columns(strips=[[(0.0, height), (width, height)] for height in heights])
    words = rr.Points2D.columns(
        positions=[(width * row.label_part, height) for row, height in zip(rows, heights, strict=True)],
        labels=[row.label for row in rows],
    )
    yield scene.IMAGE_ROWS, [*lines.partition(counts), *words.partition(counts)]


def _log_styles(recording: rr.RecordingStream) -> None:
    recording.log(
        scene.IMAGE_ROWS,
        rr.LineStrips2D.from_fields(colors=[ROW_COLOR], radii=rr.Radius.ui_points(0.5)),
        rr.Points2D.from_fields(colors=[ROW_COLOR], radii=rr.Radius.ui_points(0.0), show_labels=True),
        static=True,
        strict=True,
    )
    lead, bound = LEVEL_COLORS[WarningLevel.NONE], OTHER_TRACK_COLOR
    for path, names in (
        (scene.PLOT_DISTANCE, ("distance", "16th percentile", "84th percentile")),
        (scene.PLOT_SPEED, ("closing speed", "less one sigma", "plus one sigma")),
    ):
        lines = rr.SeriesLines(colors=[lead, bound, bound], widths=[2.0, 0.7, 0.7], names=names)
        recording.log(path, lines, static=True, strict=True)
    recording.log(
        scene.PLOT_TTC, rr.SeriesLines(colors=[lead], widths=[2.0], names=["TTC"]), static=True, strict=True
    )
    recording.log(
        scene.LEVEL,
        rr.StateConfiguration(
            values=[level.name.lower() for level in LEVEL_COLORS],
            colors=list(LEVEL_COLORS.values()),
        ),
        static=True,
        strict=True,
    )


def _log_texts(recording: rr.RecordingStream, header: DriveHeader) -> None:
    recording.send_recording_name(header.source)
    text = calibration_text(header.calibration)
    facts = {
        "source": header.source,
        "image_size": str(header.image_size),
        "frame_rate_hz": f"{header.frame_rate_hz:g}",
        "video": "relayed" if header.relays_video else "encoded anew",
        "detector": header.detector,
        "model_sha256": header.model_sha256,
        **{f"version of {name}": version for name, version in header.versions.items()},
    }
    table = "\n".join(f"| {name} | {value} |" for name, value in facts.items())
    recording.log(
        scene.DRIVE,
        rr.TextDocument(
            f"| | |\n| --- | --- |\n{table}\n\n```yaml\n{text}```\n", media_type=rr.MediaType.MARKDOWN
        ),
        static=True,
        strict=True,
    )
    structs = pa.array([facts])
    recording.send_property(
        "drive", rr.DynamicArchetype("fcw.Drive", components={"facts": structs, "calibration": text})
    )
