"""Number plates as rulers: exact ones give the camera's height, and intervals hold the truth."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fcw.camera.calibration import Gaussian, NumberPlate, Priors
from fcw.camera.file import calibration_text, parse_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.plates import OVERHANG_M, PLATE_SIGMA_M, check_plate
from fcw.camera.joint.solve import calibrate_jointly
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
REAL = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
ANY_HEIGHT = Gaussian(1.5, 0.5)
EU_M = 0.52


def seen(camera: GroundPlaneCamera, ahead_m: float, left_m: float, up_m: float) -> tuple[float, float]:
    """Column and row of a point: the pinhole written out, depth along the axis and height below it."""
    down_m, cosine, sine = camera.height_m - up_m, math.cos(camera.pitch_rad), math.sin(camera.pitch_rad)
    depth_m, below_m = ahead_m * cosine + down_m * sine, down_m * cosine - ahead_m * sine
    return (
        camera.principal_column_px - camera.focal_y_px * left_m / depth_m,
        camera.principal_row_px + camera.focal_y_px * below_m / depth_m,
    )


def plate(
    camera: GroundPlaneCamera,
    rear_m: float,
    left_m: float = 0.0,
    overhang_m: float = OVERHANG_M.value,
    up_m=0.8,
) -> NumberPlate:
    """Of a car whose rear face is there."""
    ends = [seen(camera, rear_m, left_m + side * EU_M / 2, up_m) for side in (1, -1)]
    tyre = seen(camera, rear_m + overhang_m, left_m + 0.7, 0.0)
    return NumberPlate((*ends, tyre), Gaussian(EU_M, PLATE_SIGMA_M))


def test_two_plates_and_the_lens_give_height_and_horizon():
    """Exact ones; the lens is known, as a plate's distance is its width times the focal length."""
    plates = (plate(REAL, 7.0), plate(REAL, 11.0, 3.0), plate(REAL, 25.0, -2.0))
    view_rad = 2 * math.atan(640 / 1000)
    known = Known(
        Evidence(plates=plates),
        SIZE,
        ANY_HEIGHT,
        click_sigma_px=0.05,
        priors=Priors(Gaussian(view_rad, 1e-4)),
    )
    calibration = calibrate_jointly(known)
    assert calibration.camera.height_m == pytest.approx(1.3, abs=0.05)
    assert calibration.horizon_row_px == pytest.approx(REAL.horizon_row_px, abs=4)
    low_m, high_m = calibration.distance_interval(REAL.row_at(20.0))
    assert low_m < 20 < high_m
    assert parse_calibration(calibration_text(calibration), "x") == calibration


@pytest.mark.parametrize("pitch_deg", [-5.0, 0.0, 6.0, 12.0])
@pytest.mark.parametrize("size", [SIZE, ImageSize(1080, 1920)])
def test_plates_show_where_a_camera_looks_however_it_is_pitched(pitch_deg, size):
    """Where the usual horizon is below a tyre, its plate alone would leave it there."""
    focal_px = max(size.width, size.height) / 2 / math.tan(math.radians(35))
    camera = GroundPlaneCamera(
        math.radians(pitch_deg), focal_px, (size.height - 1) / 2, 1.3, (size.width - 1) / 2
    )
    plates = tuple(
        plate(camera, rear_m, left_m) for rear_m, left_m in ((6.0, 0.0), (12.0, 2.0), (22.0, -2.0))
    )
    view = Gaussian(2 * math.atan(size.width / 2 / focal_px), math.radians(1))
    calibration = calibrate_jointly(Known(Evidence(plates=plates), size, ANY_HEIGHT, priors=Priors(view)))
    assert calibration.horizon_row_px == pytest.approx(camera.horizon_row_px, abs=0.02 * focal_px)
    assert calibration.camera.height_m == pytest.approx(1.3, abs=0.15)


@pytest.mark.slow
def test_intervals_of_plates_hold_the_truth_as_often_as_they_say():
    """150 cameras drawn from what is believed; three binomial sigmas of 68 % are 11 %."""
    rng, inside, count = np.random.default_rng(4), 0, 150
    for _ in range(count):
        view_rad = math.radians(np.clip(rng.normal(66, 12), 40, 100))
        camera = GroundPlaneCamera(
            math.atan(rng.normal(0.05, 0.06)),
            640 / math.tan(view_rad / 2),
            359.5 + 21.6 * rng.standard_normal(),
            1.3 * math.exp(0.2 * rng.standard_normal()),
            639.5,
        )
        plates = []
        for rear_m in rng.uniform(6, 25, 4):
            overhang_m = OVERHANG_M.value + OVERHANG_M.sigma * rng.standard_normal()
            exact = plate(camera, float(rear_m), rng.uniform(-3, 3), overhang_m, rng.uniform(0.5, 1.0))
            places = np.array(exact.places_px) + rng.standard_normal((3, 2))
            width_m = Gaussian(EU_M + PLATE_SIGMA_M * rng.standard_normal(), PLATE_SIGMA_M)
            plates.append(NumberPlate(tuple((float(u), float(v)) for u, v in places), width_m))
        priors = Priors(Gaussian(view_rad + math.radians(6) * rng.standard_normal(), math.radians(6)))
        height_m = Gaussian(1.3, 0.3)
        known = Known(Evidence(plates=tuple(plates)), SIZE, height_m, priors=priors)
        low_m, high_m = calibrate_jointly(known).distance_interval(camera.row_at(20.0))
        inside += low_m <= 20.0 <= high_m
    assert inside / count == pytest.approx(0.68, abs=0.11)


def test_which_end_is_clicked_first_does_not_matter():
    one = plate(REAL, 8.0)
    turned = replace(one, places_px=(one.places_px[1], one.places_px[0], one.places_px[2]))
    cameras = [
        calibrate_jointly(Known(Evidence(plates=(first, plate(REAL, 15.0))), SIZE, ANY_HEIGHT)).camera
        for first in (one, turned)
    ]
    assert cameras[0] == cameras[1]


PLACES = ((600.0, 400.0), (640.0, 401.0), (610.0, 440.0))


@pytest.mark.parametrize(
    ("places_px", "width_m", "message"),
    [
        (PLACES[:2], 0.52, "2 places, expected two ends and where a tyre stands"),
        ((*PLACES[:2], (610.0, 390.0)), 0.52, "meets the road at row 390, above the plate at row 401"),
        ((PLACES[0], (602.0, 400.0), PLACES[2]), 0.52, "it is 2.0 px wide"),
        ((PLACES[0], PLACES[1], (610.0, 9999.0)), 0.52, "far outside the picture of 1280x720"),
        (PLACES, 5.2, r"width 5.2 ± 0.004 m: expected 0.1 to 1 m"),
    ],
)
def test_places_and_widths_of_no_plate_are_refused(places_px, width_m, message):
    with pytest.raises(UserError, match=message):
        check_plate(NumberPlate(places_px, Gaussian(width_m, 0.004)), SIZE)
