"""From clicked points to a calibration: the exact three-point solution, and least squares with priors."""

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, Priors, matrix3
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.errors import UserError
from fcw.sources.frame import ImageSize


def exact_camera(
    distances_m: np.ndarray, rows_px: np.ndarray, height_m: float, principal_column_px: float
) -> GroundPlaneCamera:
    """The camera through three points: the linear system A + B d - C v = v d, closed form.

    Args:
        distances_m: (3,) from the camera.
        rows_px: (3,).
        height_m: camera height; it only splits the row map into pitch, focal length and principal row.
        principal_column_px: column of the optical axis.
    """
    # Differences against the first point remove A and keep the digits.
    d, v = distances_m[1:] - distances_m[0], rows_px[1:] - rows_px[0]
    # v_i d_i - v_0 d_0 = B (d_i - d_0) - C (v_i - v_0), rows counted from v_0.
    horizon, pole = np.linalg.solve(np.column_stack((d, -v)), v * distances_m[1:])
    scale = -horizon * (distances_m[0] + pole)
    tangent = pole / height_m
    focal = scale / (height_m * (1 + tangent**2))
    horizon_row = rows_px[0] + horizon
    return GroundPlaneCamera(
        float(np.arctan(tangent)),
        float(focal),
        float(horizon_row + focal * tangent),
        height_m,
        principal_column_px,
    )


def calibrate(
    points: tuple[GroundPoint, ...],
    image_size: ImageSize,
    height_m: float,
    reference_offset_m: float = 0.0,
    row_sigma_px: float = 1.0,
    field_of_view: Gaussian | None = None,
    principal_row: Gaussian | None = None,
    horizon_row: Gaussian | None = None,
) -> Calibration:
    """Calibrate from points of the road at known distances."""
    if len(points) != 3 or Priors(field_of_view, principal_row, horizon_row).count:
        raise UserError(f"{len(points)} points given, expected three")
    points = tuple(points)
    distances_m = np.array([point.distance_m for point in points]) + reference_offset_m
    rows_px = np.array([point.row_px for point in points])
    camera = exact_camera(distances_m, rows_px, height_m, (image_size.width - 1) / 2)
    order = np.argsort(distances_m)
    residuals = rows_px - camera.row_at(distances_m)
    near, middle, far = (float(d) for d in distances_m[order])
    return Calibration(
        camera,
        image_size,
        points,
        row_sigma_px,
        (near, middle, far),
        matrix3(row_sigma_px**2 * np.eye(3)),
        reference_offset_m,
        residuals_px=tuple(float(r) for r in residuals),
    )
