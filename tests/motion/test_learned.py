"""What a drive taught of the mount, as a calibration of the pictures that the camera takes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.lens.model import Lens
from fcw.camera.solve import calibrate
from fcw.camera.straight import Orientation, straight_column, turn
from fcw.camera.uncertainty import camera_sigmas
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.motion.learned import calibration_of_mount
from fcw.motion.state import Mount

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.03, 1000.0, 359.5, 1.3, 639.5)
LENS = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (-0.25, 0.06, 0.0, 0.0, 0.0), SIZE)
SURE_RAD = math.radians(0.01)


def clicked(*distances_m: float, camera: GroundPlaneCamera = CAMERA) -> Calibration:
    """Of the straight pictures of a drive."""
    points = [GroundPoint(d, camera.row_at(d)) for d in distances_m]
    return calibrate(points, SIZE, camera.height_m).straight()


def mount_of(pitch_rad: float, yaw_rad: float = 0.0, roll_rad: float = 0.0, sigma_rad=SURE_RAD) -> Mount:
    return Mount(
        pitch_rad=pitch_rad,
        yaw_rad=yaw_rad,
        roll_rad=roll_rad,
        pitch_sigma_rad=sigma_rad,
        yaw_sigma_rad=sigma_rad,
        roll_sigma_rad=sigma_rad,
    )


def to_level(pitch_rad: float, orientation: Orientation) -> np.ndarray:
    """(3, 3) from the axes of a camera to level ones along the vehicle."""
    return Rotation.from_euler("x", -pitch_rad).as_matrix() @ turn(pitch_rad, orientation)


@pytest.mark.parametrize("lens", [None, LENS])
@pytest.mark.parametrize(
    ("pitch", "yaw", "roll"), [(1.5, 3.0, 0.0), (3.0, 4.0, 2.0), (-2.0, -6.0, -3.0), (2.0, 2.0, 0.0)]
)
def test_the_file_puts_the_road_where_the_camera_shows_it(pitch, yaw, roll, lens):
    """A camera was calibrated to look 2 degrees down and left and to be level, which it is not."""
    was = Orientation(math.radians(2.0), 0.0)
    camera = replace(CAMERA, pitch_rad=math.radians(2.0))
    camera = replace(camera, principal_column_px=straight_column(camera, was))
    taken = replace(Calibration.from_camera(camera, SIZE), orientation=was, lens=lens)
    true_rad = math.radians(pitch), Orientation(math.radians(yaw), math.radians(roll))
    real = to_level(*true_rad)
    straight = Rotation.from_matrix(real @ turn(camera.pitch_rad, was).T)
    # Intrinsic turns about y, x and z; about x a camera looks up, about y to the right.
    right_rad, up_rad, roll_rad = straight.as_euler("YXZ")
    mount = mount_of(-up_rad, -right_rad, roll_rad)
    learned = calibration_of_mount(taken.straight(), mount, "drive").calibration
    assert learned.lens == lens
    for ahead_m, left_m in ((8.0, 2.0), (15.0, -3.0), (30.0, 0.0), (50.0, 5.0)):
        x, y, z = real.T @ np.array((-left_m, camera.height_m, ahead_m))
        slope = np.array([[x / z, y / z]])
        seen = 1000.0 * slope + (639.5, 359.5) if lens is None else lens.distorted(slope)
        column_px, row_px = learned.straight_place(*seen[0])
        assert learned.distance_at(row_px) == pytest.approx(ahead_m, rel=0.01)
        assert learned.lateral_at(column_px, row_px) == pytest.approx(left_m, abs=0.01 * ahead_m)


def test_yaw_and_roll_are_as_well_known_as_the_drive_tells_them():
    turned = calibration_of_mount(clicked(6, 15, 30), mount_of(0.03, 0.05, -0.02), "drive").calibration
    orientation = turned.orientation
    assert (orientation.yaw_rad, orientation.roll_rad) == pytest.approx((0.05, -0.02), abs=2e-4)
    # No drive tells them better than to a tenth of a degree.
    assert orientation.yaw_sigma_rad == pytest.approx(math.radians(0.1), rel=0.02)
    assert orientation.roll_sigma_rad == pytest.approx(math.radians(0.1), rel=0.02)
    untold = calibration_of_mount(
        clicked(6, 15, 30), Mount(pitch_rad=0.03, yaw_sigma_rad=0.03, roll_sigma_rad=0.017), "drive"
    ).calibration.orientation
    assert (untold.yaw_rad, untold.roll_rad) == (0.0, 0.0)
    assert untold.yaw_sigma_rad == pytest.approx(math.radians(5.0))


def test_a_mount_that_was_moved_has_the_pitch_of_the_drive_and_the_lens_of_the_calibration():
    calibration = clicked(6, 15, 30)
    learned = calibration_of_mount(calibration, mount_of(0.06), "drive")
    again = learned.calibration
    assert learned.moved
    assert again.camera.pitch_rad == pytest.approx(0.06, abs=1e-4)
    assert again.camera.focal_y_px == calibration.camera.focal_y_px
    before, after = camera_sigmas(calibration), camera_sigmas(again)
    assert after.focal_y_px == pytest.approx(before.focal_y_px)
    assert after.principal_row_px == pytest.approx(before.principal_row_px)
    low_m, high_m = again.distance_interval(again.row_at(30.0))
    assert 28.4 < low_m < 29.2
    assert 30.8 < high_m < 31.9
    # 0.1 degrees of a focal length of 1000 px.
    assert after.horizon_row_px == pytest.approx(1.75, rel=0.01)


@pytest.mark.parametrize("distances_m", [(4, 5, 7), (5, 10, 20), (6, 15, 40)])
@pytest.mark.parametrize("sigma_deg", [0.05, 0.15, 0.3])
def test_a_drive_that_agrees_makes_no_distance_less_sure(distances_m, sigma_deg):
    calibration = clicked(*distances_m)
    mount = mount_of(calibration.camera.pitch_rad, sigma_rad=math.radians(sigma_deg))
    learned = calibration_of_mount(calibration, mount, "drive")
    assert not learned.moved
    for distance_m in (5.0, 10.0, 30.0, 80.0):
        low_m, high_m = calibration.distance_interval(calibration.row_at(distance_m))
        now = learned.calibration
        now_low_m, now_high_m = now.distance_interval(now.row_at(distance_m))
        assert now_low_m >= low_m - 0.01 * distance_m
        assert now_high_m <= high_m + 0.01 * distance_m


def test_three_near_clicks_and_a_drive_give_far_distances():
    """By 4, 5 and 7 m alone 40 m may be anything; the horizon of a drive is what they lack."""
    calibration = clicked(4, 5, 7)
    mount = mount_of(calibration.camera.pitch_rad, sigma_rad=math.radians(0.05))
    now = calibration_of_mount(calibration, mount, "drive").calibration
    low_m, high_m = calibration.distance_interval(calibration.row_at(40.0))
    now_low_m, now_high_m = now.distance_interval(now.row_at(40.0))
    assert now_high_m - now_low_m < (high_m - low_m) / 2


def test_an_uncertain_lens_does_not_become_an_uncertain_horizon():
    """A focal length known to a quarter moves near rows much and far ones little, and says so afterwards."""
    below_px = CAMERA.row_at(np.array((5.0, 10.0, 20.0))) - CAMERA.horizon_row_px
    rows = np.outer(below_px, below_px) * 0.25**2 + 1.0
    calibration = replace(
        Calibration.from_camera(CAMERA, SIZE), covariance=tuple(map(tuple, rows.tolist()))
    ).straight()
    learned = calibration_of_mount(calibration, mount_of(0.03), "drive").calibration
    for distance_m in (10.0, 30.0, 80.0):
        high_m = learned.distance_interval(learned.row_at(distance_m))[1]
        assert high_m < 1.6 * distance_m


def test_a_drive_that_taught_nothing_and_a_log_that_does_not_say_enough_are_refused():
    black = mount_of(0.03, sigma_rad=math.radians(0.7))
    with pytest.raises(
        UserError, match=r"^night: the drive tells too little about the camera's pitch \(known to 0.70"
    ):
        calibration_of_mount(clicked(6, 15, 30), black, "night")
    with pytest.raises(UserError, match=r"^old: this log, of an older version, does not say whether"):
        calibration_of_mount(replace(clicked(6, 15, 30), undone=None), mount_of(0.03), "old")
