"""The calibrations of the real drives."""

import pytest

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.plausibility import plausibility
from fcw.camera.solve import calibrate, exact_solution
from fcw.frame import ImageSize


def real_calibrations(data_dir) -> dict[str, Calibration]:
    """By clip, from lines of clip, size, height, three points and how far to believe them."""
    calibrations = {}
    for line in (data_dir / "calibrations.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        clip, size, height_m, *points, _ = line.split()
        calibrations[clip] = calibrate(
            [GroundPoint(*map(float, point.split(":"))) for point in points],
            ImageSize(*map(int, size.split("x"))),
            float(height_m),
        )
    return calibrations


def test_every_real_drive_has_a_plausible_camera(data_dir):
    calibrations = real_calibrations(data_dir)
    assert len(calibrations) >= 14
    for clip, calibration in calibrations.items():
        assert plausibility(calibration) == (), clip


def test_kitti_comes_out_with_its_published_intrinsics(data_dir):
    """P2 of the tracking benchmark: f = 721.5 px, v0 = 172.9, the camera level within half a degree."""
    exact = exact_solution(real_calibrations(data_dir)["kitti_sfnd3d"])
    assert exact is not None
    camera = exact.camera
    assert camera.focal_y_px == pytest.approx(721.5, rel=0.01)
    assert camera.principal_row_px == pytest.approx(172.9, abs=1.5)
    assert abs(camera.pitch_rad) < 0.01
