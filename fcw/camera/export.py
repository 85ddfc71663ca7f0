"""A calibration in the forms that robotics tools read.

Both hold the intrinsics; camera_info also has the rotation to the straight picture (`fcw.camera.straight`)
and the straight camera, as ROS's rectification has them. Height, pitch and uncertainty have no place in them.
"""

from dataclasses import replace
from typing import Literal, get_args

import numpy as np
import yaml

from fcw.camera.calibration import Calibration
from fcw.camera.lens.model import Lens
from fcw.camera.straight import straight_column, turn
from fcw.errors import UserError

ExportFormat = Literal["camera_info", "kalibr"]
EXPORT_FORMATS: tuple[str, ...] = get_args(ExportFormat)
GRID = 25
MOST_OFF_PX = 4.0
"""Anywhere in the picture. Lenses of chessboards with a fifth coefficient are met to one or two in the
corners, where no board was; another kind of lens is missed by far more."""


def export_text(calibration: Calibration, file_format: ExportFormat) -> str:
    """The text of a file in one of the formats.

    Raises:
        UserError: the format has no place for the lens.
    """
    return camera_info_text(calibration) if file_format == "camera_info" else kalibr_text(calibration)


def camera_info_text(calibration: Calibration, camera_name: str = "fcw") -> str:
    """A YAML file of ROS's camera_info_manager (camera_calibration_parsers)."""
    straight = calibration.camera
    across, down, column, row = _intrinsics(calibration)
    model, coefficients = "plumb_bob", [0.0] * 5
    if calibration.lens is not None:
        coefficients = list(calibration.lens.coefficients)
        model = "equidistant" if calibration.lens.model == "equidistant" else "plumb_bob"
        if len(coefficients) == 8:
            model = "rational_polynomial"
        elif model == "plumb_bob":
            coefficients += [0.0] * (5 - len(coefficients))
    focal = straight.focal_y_px
    document = {
        "image_width": calibration.image_size.width,
        "image_height": calibration.image_size.height,
        "camera_name": camera_name,
        "camera_matrix": _matrix(3, 3, [across, 0.0, column, 0.0, down, row, 0.0, 0.0, 1.0]),
        "distortion_model": model,
        "distortion_coefficients": _matrix(1, len(coefficients), coefficients),
        "rectification_matrix": _matrix(
            3, 3, turn(straight.pitch_rad, calibration.orientation).ravel().tolist()
        ),
        "projection_matrix": _matrix(
            3,
            4,
            [
                *(focal, 0.0, straight.principal_column_px, 0.0),
                *(0.0, focal, straight.principal_row_px, 0.0),
                *(0.0, 0.0, 1.0, 0.0),
            ],
        ),
    }
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def kalibr_text(calibration: Calibration, topic: str = "/camera/image") -> str:
    """A camchain YAML file of Kalibr with one camera.

    Raises:
        UserError: Kalibr's models have no lens that bends the picture as this one does.
    """
    size, lens = calibration.image_size, calibration.lens
    if lens is not None and lens.model == "radtan":
        lens = _with_four_coefficients(lens)
    document = {
        "cam0": {
            "camera_model": "pinhole",
            "intrinsics": list(_intrinsics(calibration)),
            "distortion_model": "radtan" if lens is None else lens.model,
            "distortion_coeffs": [0.0] * 4 if lens is None else list(lens.coefficients),
            "resolution": [size.width, size.height],
            "rostopic": topic,
        }
    }
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def _with_four_coefficients(lens: Lens) -> Lens:
    """The lens by k1, k2, p1 and p2 alone, which make up for the terms that Kalibr has no place for.

    Raises:
        UserError: they cannot.
    """
    if not any(lens.coefficients[4:]):
        return replace(lens, coefficients=lens.coefficients[:4])
    size = lens.image_size
    across, down = (np.linspace(0, length - 1, GRID) for length in (size.width, size.height))
    places_px = np.column_stack([grid.ravel() for grid in np.meshgrid(across, down)])
    rays = lens.undistorted(places_px)
    x, y = rays.T
    squared, product = x**2 + y**2, 2 * x * y
    # Where a ray shows is linear in the four (Brown 1971).
    by = np.array(
        (
            (x * squared, x * squared**2, product, squared + 2 * x**2),
            (y * squared, y * squared**2, squared + 2 * y**2, product),
        )
    )
    focal_px = np.array((lens.focal_x_px, lens.focal_y_px))
    bent_px = places_px - np.array((lens.column_px, lens.row_px)) - rays * focal_px
    slopes = np.concatenate(np.swapaxes(by, 1, 2) * focal_px[:, None, None])
    fitted = np.linalg.lstsq(slopes, bent_px.T.ravel(), rcond=None)[0]
    nearest = replace(lens, coefficients=tuple(fitted.tolist()))
    off_px = float(np.linalg.norm(nearest.distorted(rays) - places_px, axis=1).max())
    if not off_px <= MOST_OFF_PX:
        raise UserError(
            f"Kalibr: its model of this lens has four coefficients, which miss it by up to {off_px:.0f} px; "
            "export camera_info, which holds all of them"
        )
    return nearest


def _intrinsics(calibration: Calibration) -> tuple[float, float, float, float]:
    """Focal lengths across and down, column and row of the axis, of the picture as it is."""
    lens, camera = calibration.lens, calibration.camera
    if lens is not None:
        return lens.focal_x_px, lens.focal_y_px, lens.column_px, lens.row_px
    shift_px = straight_column(camera, calibration.orientation) - camera.principal_column_px
    return (
        camera.focal_y_px,
        camera.focal_y_px,
        camera.principal_column_px - shift_px,
        camera.principal_row_px,
    )


def _matrix(rows: int, columns: int, data: list[float]) -> dict[str, object]:
    return {"rows": rows, "cols": columns, "data": data}
