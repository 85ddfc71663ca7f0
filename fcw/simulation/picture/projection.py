"""Pixels of points in space, through the ground-plane camera while it pitches and bounces."""

import numpy as np

from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera


def dynamic_camera(
    camera: GroundPlaneCamera, pitch_deviation_rad: float = 0.0, bounce_m: float = 0.0
) -> GroundPlaneCamera:
    """The camera as it stands at one instant; its `horizon_row_px` is that instant's true horizon."""
    return GroundPlaneCamera(
        camera.pitch_rad + pitch_deviation_rad,
        camera.focal_y_px,
        camera.principal_row_px,
        camera.height_m + bounce_m,
        camera.principal_column_px,
    )


def project(
    points_m: FloatArray,
    camera: GroundPlaneCamera,
    pitch_deviation_rad: float = 0.0,
    bounce_m: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Columns and rows of points.

    Args:
        points_m: (..., 3) in the own vehicle's ISO 8855 axes: x forward, y left, z up, from the road below
            the camera.
        camera: as calibrated.
        pitch_deviation_rad: added to its pitch, positive downwards.
        bounce_m: added to its height.

    Returns:
        u and v, each (...,); nan for points beside or behind the camera.
    """
    now = dynamic_camera(camera, pitch_deviation_rad, bounce_m)
    forward, left, up = np.moveaxis(np.asarray(points_m, np.float64), -1, 0)
    below = now.height_m - up
    cosine, sine = np.cos(now.pitch_rad), np.sin(now.pitch_rad)
    depth = forward * cosine + below * sine
    depth = np.where(depth > 0, depth, np.nan)
    u = now.principal_column_px - now.focal_y_px * left / depth
    v = now.principal_row_px + now.focal_y_px * (below * cosine - forward * sine) / depth
    return u, v
