"""A calibration in the forms that robotics tools read. Both hold the intrinsics of a lens without distortion;
height, pitch and uncertainty have no place in them.
"""

from typing import Literal, get_args

import yaml

from fcw.camera.calibration import Calibration

ExportFormat = Literal["camera_info", "kalibr"]
EXPORT_FORMATS: tuple[str, ...] = get_args(ExportFormat)


def export_text(calibration: Calibration, file_format: ExportFormat) -> str:
    """The text of a file in one of the formats."""
    return camera_info_text(calibration) if file_format == "camera_info" else kalibr_text(calibration)


def camera_info_text(calibration: Calibration, camera_name: str = "fcw") -> str:
    """A YAML file of ROS's camera_info_manager (camera_calibration_parsers)."""
    camera = calibration.camera
    focal, column, row = camera.focal_y_px, camera.principal_column_px, camera.principal_row_px
    document = {
        "image_width": calibration.image_size.width,
        "image_height": calibration.image_size.height,
        "camera_name": camera_name,
        "camera_matrix": _matrix(3, 3, [focal, 0.0, column, 0.0, focal, row, 0.0, 0.0, 1.0]),
        "distortion_model": "plumb_bob",
        "distortion_coefficients": _matrix(1, 5, [0.0] * 5),
        "rectification_matrix": _matrix(3, 3, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
        "projection_matrix": _matrix(
            3, 4, [focal, 0.0, column, 0.0, 0.0, focal, row, 0.0, 0.0, 0.0, 1.0, 0.0]
        ),
    }
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def kalibr_text(calibration: Calibration, topic: str = "/camera/image") -> str:
    """A camchain YAML file of Kalibr with one camera."""
    camera, size = calibration.camera, calibration.image_size
    document = {
        "cam0": {
            "camera_model": "pinhole",
            "intrinsics": [
                camera.focal_y_px,
                camera.focal_y_px,
                camera.principal_column_px,
                camera.principal_row_px,
            ],
            "distortion_model": "radtan",
            "distortion_coeffs": [0.0] * 4,
            "resolution": [size.width, size.height],
            "rostopic": topic,
        }
    }
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def _matrix(rows: int, columns: int, data: list[float]) -> dict[str, object]:
    return {"rows": rows, "cols": columns, "data": data}
