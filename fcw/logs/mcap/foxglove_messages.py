"""A drive as Foxglove's messages: camera, annotations of the picture, the road from above, and the log.

Coordinate frames: `ego` is ISO 8855 (x forward, y left, z up) on the road below the calibration's reference
point, so that a vehicle's x is its distance. `camera` is the optical frame (x right, y down, z forward).
"""

import math

from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.ImageAnnotations_pb2 import ImageAnnotations
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.Point2_pb2 import Point2
from foxglove_schemas_protobuf.PointsAnnotation_pb2 import PointsAnnotation
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TextAnnotation_pb2 import TextAnnotation
from foxglove_schemas_protobuf.TextPrimitive_pb2 import TextPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp

from fcw.camera.calibration import Calibration
from fcw.frame import ImageSize
from fcw.logs.overlay import (
    OWN_CAR_SIZE_M,
    PIXEL_CENTRE_PX,
    ROW_COLOR,
    VEHICLE_LENGTH_M,
    OverlayBox,
    OverlayRow,
    Rgb,
    overlay_boxes,
    rear_size_m,
)
from fcw.logs.records import FrameResult
from fcw.tracking.types import Track
from fcw.units import NS_PER_S
from fcw.warning.describe import describe
from fcw.warning.types import WarningLevel

EGO_FRAME = "ego"
CAMERA_FRAME = "camera"
EGO_COLOR: Rgb = (70, 110, 160)
FONT_PART = 1 / 36
"""Font size as a fraction of the picture's height."""
THIN_LINE_PX, LINE_PX, LEAD_LINE_PX = 1.0, 2.0, 3.0
SCENE_FONT_PX = 14.0
STEPS_PER_PX, STEPS_PER_M = 16, 1024
"""Resolution of coordinates. More digits could not be seen, and would not compress."""
_LOG_LEVELS = {
    WarningLevel.NONE: Log.INFO,
    WarningLevel.ADVISORY: Log.INFO,
    WarningLevel.CAUTION: Log.WARNING,
    WarningLevel.WARNING: Log.ERROR,
}
_NO_ROTATION = Quaternion(x=0, y=0, z=0, w=1)


def timestamp(time_ns: int) -> Timestamp:
    """A time, at least 0, as a protobuf timestamp."""
    return Timestamp(seconds=time_ns // NS_PER_S, nanos=time_ns % NS_PER_S)


def video_message(data: bytes, stamp: Timestamp) -> CompressedVideo:
    """One H.264 access unit."""
    return CompressedVideo(timestamp=stamp, frame_id=CAMERA_FRAME, data=data, format="h264")


def calibration_message(calibration: Calibration, stamp: Timestamp) -> CameraCalibration:
    """The camera as a pinhole without distortion."""
    camera = calibration.camera
    focal, column, row = camera.focal_y_px, camera.principal_column_px, camera.principal_row_px
    return CameraCalibration(
        timestamp=stamp,
        frame_id=CAMERA_FRAME,
        width=calibration.image_size.width,
        height=calibration.image_size.height,
        distortion_model="plumb_bob",
        D=[0.0] * 5,
        K=[focal, 0, column, 0, focal, row, 0, 0, 1],
        R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
        P=[focal, 0, column, 0, 0, focal, row, 0, 0, 0, 1, 0],
    )


def transforms_message(calibration: Calibration, pitch_rad: float, stamp: Timestamp) -> FrameTransforms:
    """Position of the camera on the vehicle, and its present pitch."""
    # The rotation of a level camera, (-1/2, 1/2, -1/2, 1/2), followed by the pitch about the camera's x.
    half = pitch_rad / 2
    even, odd = (math.cos(half) + math.sin(half)) / 2, (math.cos(half) - math.sin(half)) / 2
    mount = FrameTransform(
        timestamp=stamp,
        parent_frame_id=EGO_FRAME,
        child_frame_id=CAMERA_FRAME,
        translation=Vector3(x=-calibration.reference_offset_m, y=0, z=calibration.camera.height_m),
        rotation=Quaternion(x=-even, y=even, z=-odd, w=odd),
    )
    return FrameTransforms(transforms=[mount])


def annotations_message(
    result: FrameResult, rows: tuple[OverlayRow, ...], image_size: ImageSize, imperial: bool, stamp: Timestamp
) -> ImageAnnotations:
    """Boxes with their labels, and the distance rows."""
    font_px = image_size.height * FONT_PART
    boxes = overlay_boxes(result, imperial)
    return ImageAnnotations(
        points=[*(_box_outline(box, stamp) for box in boxes), _row_lines(rows, image_size.width, stamp)],
        texts=[
            *(_text(box.box.x, box.box.y, box.label, box.color, font_px, stamp) for box in boxes if box.told),
            *(
                _text(image_size.width * row.label_part, row.row_px, row.label, ROW_COLOR, font_px, stamp)
                for row in rows
            ),
        ],
    )


def scene_message(
    result: FrameResult, calibration: Calibration, imperial: bool, stamp: Timestamp
) -> SceneUpdate:
    """The vehicles and our own car on the road; each message replaces the previous one."""
    drawn = [
        (track, overlay)
        for track, overlay in zip(result.tracks, overlay_boxes(result, imperial), strict=True)
        if math.isfinite(track.distance_m) and math.isfinite(track.lateral_m)
    ]
    vehicles = SceneEntity(
        timestamp=stamp,
        frame_id=EGO_FRAME,
        id="vehicles",
        cubes=[_vehicle_cube(track, overlay, calibration) for track, overlay in drawn],
        texts=[
            TextPrimitive(
                pose=_pose(track.distance_m, track.lateral_m, OWN_CAR_SIZE_M[2] + 1),
                billboard=True,
                font_size=SCENE_FONT_PX,
                scale_invariant=True,
                color=_color(overlay.color),
                text=f"{track.track_id}: {overlay.label}",
            )
            for track, overlay in drawn
            if overlay.told
        ],
    )
    length, _, height = OWN_CAR_SIZE_M
    ego = SceneEntity(
        timestamp=stamp,
        frame_id=EGO_FRAME,
        id="ego",
        cubes=[
            CubePrimitive(
                pose=_pose(-length / 2, 0, height / 2), size=_vector(*OWN_CAR_SIZE_M), color=_color(EGO_COLOR)
            )
        ],
    )
    return SceneUpdate(entities=[vehicles, ego])


def log_message(result: FrameResult, imperial: bool, stamp: Timestamp) -> Log:
    """The warning and its reason in words."""
    warning = result.warning
    return Log(
        timestamp=stamp,
        level=_LOG_LEVELS[warning.level],
        message=describe(result.told_warning, imperial),
        name="fcw",
    )


def _box_outline(overlay: OverlayBox, stamp: Timestamp) -> PointsAnnotation:
    box = overlay.box
    return PointsAnnotation(
        timestamp=stamp,
        type=PointsAnnotation.LINE_LOOP,
        points=[
            _point(box.x, box.y),
            _point(box.right, box.y),
            _point(box.right, box.bottom),
            _point(box.x, box.bottom),
        ],
        outline_color=_color(overlay.color),
        thickness=LEAD_LINE_PX if overlay.is_lead else LINE_PX if overlay.told else THIN_LINE_PX,
    )


def _row_lines(rows: tuple[OverlayRow, ...], width_px: int, stamp: Timestamp) -> PointsAnnotation:
    return PointsAnnotation(
        timestamp=stamp,
        type=PointsAnnotation.LINE_LIST,
        points=[
            _point(column, row.row_px)
            for row in rows
            for column in (-PIXEL_CENTRE_PX, width_px - PIXEL_CENTRE_PX)
        ],
        outline_color=_color(ROW_COLOR),
        thickness=1.0,
    )


def _text(x: float, y: float, text: str, color: Rgb, font_px: float, stamp: Timestamp) -> TextAnnotation:
    return TextAnnotation(
        timestamp=stamp,
        position=_point(x, y),
        text=text,
        font_size=font_px,
        text_color=_color(color),
        background_color=Color(r=0, g=0, b=0, a=0.5),
    )


def _vehicle_cube(track: Track, overlay: OverlayBox, calibration: Calibration) -> CubePrimitive:
    """A cube whose rear has the width and height of the box at its distance."""
    width_m, height_m = rear_size_m(track, calibration)
    return CubePrimitive(
        pose=_pose(track.distance_m + VEHICLE_LENGTH_M / 2, track.lateral_m, height_m / 2),
        size=_vector(VEHICLE_LENGTH_M, width_m, height_m),
        color=_color(overlay.color),
    )


def _pose(x: float, y: float, z: float) -> Pose:
    return Pose(position=_vector(x, y, z), orientation=_NO_ROTATION)


def _vector(x: float, y: float, z: float) -> Vector3:
    return Vector3(x=_drawn(x, STEPS_PER_M), y=_drawn(y, STEPS_PER_M), z=_drawn(z, STEPS_PER_M))


def _point(column_px: float, row_px: float) -> Point2:
    return Point2(
        x=_drawn(column_px + PIXEL_CENTRE_PX, STEPS_PER_PX), y=_drawn(row_px + PIXEL_CENTRE_PX, STEPS_PER_PX)
    )


def _drawn(value: float, steps: int) -> float:
    in_steps = value * steps
    return round(in_steps) / steps if math.isfinite(in_steps) else value


def _color(color: Rgb) -> Color:
    red, green, blue = color
    return Color(r=red / 255, g=green / 255, b=blue / 255, a=1.0)
