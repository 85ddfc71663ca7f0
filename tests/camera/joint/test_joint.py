"""One fit of points, lines, horizon, dashes and vehicles: the whole orientation, and honest intervals."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, Priors
from fcw.camera.file import calibration_text, parse_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence, Ruler
from fcw.camera.joint.fit import JointFit
from fcw.camera.joint.known import Known
from fcw.camera.joint.lines import line_misfits
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.joint.unknowns import YAW
from fcw.camera.lens.model import Lens
from fcw.camera.plausibility import FindingKind, plausibility, vehicle_finding
from fcw.camera.prior_sigmas import USUAL_TANGENT, USUAL_TANGENT_SIGMA
from fcw.camera.straight import Orientation, Straightening, straight_column
from fcw.camera.uncertainty import camera_sigmas
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
REAL = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
TURNED = Orientation(math.radians(3), math.radians(2))
WIDE = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (-0.25, 0.06, 0.0, 0.0), SIZE)
HEIGHT = Gaussian(1.3, 0.013)
LEVEL_LINES = (((300.0, 700.0), (600.0, 350.0)), ((980.0, 700.0), (680.0, 350.0)))


def way(orientation: Orientation, lens: Lens | None = None) -> Straightening:
    column_px = straight_column(REAL, orientation)
    straight = GroundPlaneCamera(
        REAL.pitch_rad, REAL.focal_y_px, REAL.principal_row_px, REAL.height_m, column_px
    )
    return Straightening(straight, orientation, lens, SIZE)


def shown(there: Straightening, lateral_m: float, distance_m: float) -> np.ndarray:
    """Column and row in the picture of a point of the road."""
    camera = there.camera
    place = [camera.column_at(lateral_m, distance_m), camera.row_at(distance_m)]
    return there.to_picture(np.array([place]))[0]


def clicked(
    there: Straightening, rng: np.random.Generator, lateral_m: float, distance_m: float
) -> tuple[float, float]:
    column_px, row_px = shown(there, lateral_m, distance_m) + rng.normal(0, 1, 2)
    return float(column_px), float(row_px)


def lines_of(there: Straightening, rng: np.random.Generator, *laterals_m: float):
    return tuple(
        (clicked(there, rng, lateral_m, 7.0), clicked(there, rng, lateral_m, 45.0))
        for lateral_m in laterals_m
    )


def where(calibration: Calibration, place_px: np.ndarray) -> tuple[float, float]:
    """Distance and lateral position that a calibration gives a place in the picture."""
    straightening = calibration.straightening
    column_px, row_px = place_px if straightening is None else straightening.to_straight(place_px[None])[0]
    return calibration.distance_at(float(row_px)), calibration.lateral_at(float(column_px), float(row_px))


@pytest.mark.parametrize("lens", [None, WIDE])
@pytest.mark.parametrize("seed", range(4))
def test_yaw_and_roll_come_back_with_the_path_in_its_lane(lens, seed):
    """Yaw 3 degrees, roll 2 degrees, k1 -0.25; marks and lane lines clicked to a pixel."""
    there, rng = way(TURNED, lens), np.random.default_rng(seed)
    points = []
    for distance_m in (6.0, 16.6, 31.6):
        for lateral_m in (-1.7, 1.7):
            column_px, row_px = clicked(there, rng, lateral_m, distance_m)
            points.append(GroundPoint(distance_m, row_px, column_px))
    evidence = Evidence(points=tuple(points), lines=lines_of(there, rng, 1.8, -1.8))
    calibration = calibrate_jointly(Known(evidence, SIZE, HEIGHT, lens=lens))
    turned = calibration.orientation
    assert math.degrees(turned.yaw_rad) == pytest.approx(3, abs=0.3)
    assert math.degrees(turned.roll_rad) == pytest.approx(2, abs=0.3)
    assert math.degrees(turned.roll_sigma_rad) < 0.3
    distance_m, lateral_m = where(calibration, shown(there, 0.0, 40.0))
    assert distance_m == pytest.approx(40, rel=0.03)
    assert lateral_m == pytest.approx(0, abs=0.3)
    assert FindingKind.ROLL in {finding.kind for finding in plausibility(calibration)}


def test_whole_orientation_and_lens_survive_the_file():
    there, rng = way(TURNED, WIDE), np.random.default_rng(1)
    points = tuple(
        GroundPoint(d, *reversed(clicked(there, rng, y, d)))
        for d, y in ((6.0, 1.0), (15.0, -1.0), (30.0, 1.0))
    )
    evidence = Evidence(points=points, lines=lines_of(there, rng, 1.8, -1.8))
    calibration = calibrate_jointly(Known(evidence, SIZE, HEIGHT, lens=WIDE))
    assert parse_calibration(calibration_text(calibration), "x") == calibration
    straight = calibration.straight()
    assert straight.straightening is None
    assert straight.distance_at(400.0) == calibration.distance_at(400.0)
    half = calibration.for_image_size(ImageSize(640, 360))
    place = shown(there, 1.0, 20.0)
    assert where(half, (place + 0.5) / 2 - 0.5) == pytest.approx(
        where(calibration, place), rel=1e-3, abs=1e-3
    )


def covered(calibrations: list[Calibration], place_px: np.ndarray, distance_m: float) -> float:
    """Part of calibrations whose interval at a place of the picture has the true distance."""
    inside = 0
    for calibration in calibrations:
        straightening = calibration.straightening
        row_px = place_px[1] if straightening is None else straightening.to_straight(place_px[None])[0, 1]
        low_m, high_m = calibration.distance_interval(float(row_px))
        inside += low_m <= distance_m <= high_m
    return inside / len(calibrations)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["dashes", "lane width", "vehicles"])
def test_ways_without_taped_points_hold_their_intervals(kind):
    """100 cameras drawn from what is believed of them: three binomial sigmas of 68 % are 14 %."""
    global REAL
    rng = np.random.default_rng(7)
    before, found, places = REAL, [], []
    try:
        for _ in range(100):
            view_rad = math.radians(np.clip(rng.normal(70, 20), 35, 120))
            REAL = GroundPlaneCamera(  # pyright: ignore[reportConstantRedefinition]
                rng.normal(0.05, 0.04),
                640 / math.tan(view_rad / 2),
                359.5 + 21.6 * rng.standard_normal(),
                1.3,
                639.5,
            )
            there = way(Orientation())
            height = Gaussian(1.3 * (1 + 0.02 * rng.standard_normal()), 0.026)
            evidence = evidence_of(kind, there, rng, math.radians(0.25) * rng.standard_normal())
            found.append(calibrate_jointly(Known(evidence, SIZE, height)))
            places.append(shown(there, 0.0, 30.0))
    finally:
        REAL = before  # pyright: ignore[reportConstantRedefinition]
    inside = [covered([one], place, 30.0) for one, place in zip(found, places, strict=True)]
    assert np.mean(inside) == pytest.approx(0.68, abs=0.14)


@pytest.mark.slow
@pytest.mark.parametrize("yaw_deg", [0.0, 5.0])
def test_marks_to_the_sides_hold_their_intervals_in_a_large_picture(yaw_deg):
    """150 cameras of 3840x2160 pictures, of which a click is exact and each mark is laid to a quarter of 1 %.

    The yaw is not known: of a camera that looks ahead the intervals are too wide, by no more than that.
    """
    rng, size, inside = np.random.default_rng(5), ImageSize(3840, 2160), []
    while len(inside) < 150:
        view_rad = math.radians(np.clip(rng.normal(75, 15), 45, 110))
        real = GroundPlaneCamera(
            math.atan(USUAL_TANGENT + 0.06 * rng.standard_normal()),
            1920 / math.tan(view_rad / 2),
            1079.5 + 0.03 * 2160 * rng.standard_normal(),
            1.3,
            1919.5,
        )
        turned = Orientation(*(math.radians(deg) * rng.standard_normal() for deg in (yaw_deg, 1.5)))
        straight = replace(real, principal_column_px=straight_column(real, turned))
        there = Straightening(straight, turned, None, size)
        tape = 1 + 0.01 * rng.standard_normal()
        places = [
            shown(there, lateral_m, distance_m * tape * (1 + 0.0025 * rng.standard_normal()))
            for distance_m in (4.5, 6.0, 8.0, 12.0)
            for lateral_m in (rng.uniform(-2, 2),)
        ]
        if not all(0 <= row < 2160 and 0 <= column < 3840 for column, row in places):
            continue
        points = tuple(
            GroundPoint(distance_m, *reversed((place + rng.normal(0, 1, 2)).tolist()))
            for distance_m, place in zip((4.5, 6.0, 8.0, 12.0), places, strict=True)
        )
        calibration = calibrate_jointly(Known(Evidence(points=points), size, HEIGHT))
        inside.append(covered([calibration], shown(there, 0.0, 20.0), 20.0))
    assert 0.57 < np.mean(inside) < (0.79 if yaw_deg else 0.9)


def evidence_of(
    kind: str, there: Straightening, rng: np.random.Generator, slope_rad: float = 0.0
) -> Evidence:
    lines = lines_of(there, rng, 1.85, -1.85)
    if kind == "dashes":
        period_m, first_m = 12.0 * (1 + 0.01 * rng.standard_normal()), rng.uniform(7, 14)
        dashes = tuple(
            GroundPoint(12.0 * k, clicked(there, rng, 1.85, first_m + period_m * k)[1]) for k in range(4)
        )
        return Evidence(points=dashes, first_unknown=True, lines=lines, period_sigma_m=0.12)
    if kind == "lane width":
        return Evidence(lines=lines, lane_width_m=Gaussian(3.7 * (1 + 0.03 * rng.standard_normal()), 0.11))
    fleet = 1 + 0.04 * rng.standard_normal()
    rulers = []
    for distance_m in rng.uniform(10, 50, 12):
        width_m = 1.8 * fleet * (1 + 0.06 * rng.standard_normal())
        _, row_px = clicked(there, rng, 0.0, distance_m)
        camera = there.camera
        depth_m = distance_m * math.cos(camera.pitch_rad) + camera.height_m * math.sin(camera.pitch_rad)
        width_px = camera.focal_y_px * width_m / depth_m
        rulers.append(
            Ruler(640.0, row_px + there.camera.focal_y_px * slope_rad, width_px, Gaussian(1.8, 0.108), 1.0)
        )
    return Evidence(rulers=tuple(rulers), lines=lines)


@pytest.mark.parametrize("lateral_m", [0.3, 1.8, 5.4])
@pytest.mark.parametrize("distances_m", [(8.0, 40.0), (8.0, 12.0), (5.0, 7.0)])
def test_a_line_misses_the_way_ahead_by_a_sigma_of_its_clicks(lateral_m, distances_m):
    """Four coordinates of a pixel each; 4,000 draws tell a standard deviation to 1.1 %."""
    rng = np.random.default_rng(3)
    ends = np.array([(REAL.column_at(lateral_m, d), REAL.row_at(d)) for d in distances_m])
    drawn = [line_misfits(ends + rng.normal(0, 1, (2, 2)), REAL, 1.0, None) for _ in range(4000)]
    assert np.std(drawn) == pytest.approx(1.0, abs=0.045)


def test_vehicles_of_a_width_that_none_has_are_told():
    there, rng = way(Orientation()), np.random.default_rng(3)
    rulers = evidence_of("vehicles", there, rng).rulers
    right = Calibration.from_camera(there.camera, SIZE)
    assert vehicle_finding(right, rulers) is None
    low = Calibration.from_camera(replace(there.camera, height_m=0.9), SIZE)
    finding = vehicle_finding(low, rulers)
    assert finding is not None
    assert finding.kind is FindingKind.VEHICLES
    assert re.search(r"would be 1\.[123]\d m wide", finding.text)
    assert vehicle_finding(right, ()) is None


def test_dashes_tell_their_first_distance():
    there = way(Orientation())
    dashes = tuple(GroundPoint(12.0 * k, float(shown(there, 0, 9.0 + 12.0 * k)[1])) for k in range(4))
    calibration = calibrate_jointly(Known(Evidence(points=dashes, first_unknown=True), SIZE, HEIGHT))
    assert calibration.points[0].distance_m == pytest.approx(9.0, rel=0.1)
    low_m, high_m = calibration.distance_interval(calibration.row_at(30.0))
    assert low_m < 30 < high_m


@pytest.mark.parametrize(
    ("evidence", "priors", "lens"),
    [
        (Evidence(), Priors(), None),
        (Evidence(), Priors(), WIDE),
        (Evidence(), Priors(Gaussian(1.1, 0.05), Gaussian(360.0, 5.0)), None),
        (Evidence(scale_px_m=Gaussian(1300.0, 50.0)), Priors(Gaussian(1.1, 0.05)), None),
    ],
)
def test_nothing_known_of_the_road_is_refused(evidence, priors, lens):
    """However well the lens and the speed are known: 20 m could be 7 m, or the sky."""
    with pytest.raises(UserError, match="nothing tells where the road lies"):
        calibrate_jointly(Known(evidence, SIZE, HEIGHT, priors=priors, lens=lens))


@pytest.mark.parametrize(
    ("evidence", "message"),
    [
        (Evidence(horizon=((430.0, 100.0), (432.0, 1100.0))), "rolled by .* columns come before rows"),
        (
            Evidence(points=(GroundPoint(0.1, 1300.0),), horizon=((100.0, 700.0), (1100.0, 700.0))),
            "point 0.1:1300: it would lie behind the camera",
        ),
    ],
)
def test_a_camera_that_no_file_could_hold_is_refused(evidence, message):
    with pytest.raises(UserError, match=message):
        calibrate_jointly(Known(evidence, SIZE, HEIGHT, priors=Priors(Gaussian(1.1, 0.05))))


def test_a_camera_that_has_an_edge_behind_it_is_no_end_of_the_fit():
    edge = ((100.0, 400.0), (300.0, 410.0), (500.0, 440.0), (700.0, 480.0), (900.0, 520.0))
    fit = JointFit(Known(Evidence(lines=LEVEL_LINES, edges=(edge,)), SIZE, HEIGHT))
    x, _ = fit.solve()
    x[YAW] = math.radians(100)
    assert np.isfinite(fit.residuals(x)).all()


def test_a_rough_camera_of_nothing_known_looks_a_little_down_and_says_how_little_that_tells():
    calibration = calibrate_jointly(Known(Evidence(), SIZE, HEIGHT, rough=True))
    assert math.tan(calibration.camera.pitch_rad) == pytest.approx(USUAL_TANGENT, abs=1e-3)
    usual_px = USUAL_TANGENT_SIGMA * calibration.camera.focal_y_px
    assert camera_sigmas(calibration).horizon_row_px == pytest.approx(usual_px, rel=0.3)
    low_m, high_m = calibration.distance_interval(calibration.row_at(20.0))
    assert low_m < 11
    assert high_m == math.inf


def rulers_of(camera: GroundPlaneCamera, places: list[tuple[float, float]], width_m: float = 1.8):
    """Boxes of vehicles at (distance, lateral), with the side that those beside us show."""
    rulers = []
    for distance_m, lateral_m in places:
        near, far = (camera.ground_box(d, lateral_m, width_m, 1.5) for d in (distance_m, distance_m + 4.2))
        left, right = min(near.x, far.x), max(near.right, far.right)
        rulers.append(Ruler((left + right) / 2, near.bottom, right - left, Gaussian(1.8, 0.16), 2.0))
    return tuple(rulers)


def test_vehicles_above_the_usual_horizon_show_that_the_camera_looks_down():
    """A telephone on a dashboard that looks 13 degrees down: all vehicles stand in the upper half."""
    camera = GroundPlaneCamera(math.radians(13), 560.0, 269.5, 1.3, 479.5)
    rulers = rulers_of(camera, [(9.0, 1.0), (9.5, -0.5), (14.0, 0.5), (22.0, -1.0)])
    found = calibrate_jointly(Known(Evidence(rulers=rulers), ImageSize(960, 540), HEIGHT))
    assert found.horizon_row_px == pytest.approx(camera.horizon_row_px, abs=12)


def test_false_boxes_on_the_own_bonnet_do_not_outweigh_as_many_vehicles():
    """As on a clip that ends with a crash: the two boxes would be 0.5 m wide, or the vehicles in the sky."""
    camera = GroundPlaneCamera(0.0, 493.0, 185.0, HEIGHT.value, 319.5)
    bonnet = tuple(Ruler(column_px, 330.0, 60.0, Gaussian(1.8, 0.16), 1.0) for column_px in (260.0, 345.0))
    rulers = rulers_of(camera, [(10.0, 0.5), (18.0, 1.0)]) + bonnet
    found = calibrate_jointly(Known(Evidence(rulers=rulers), ImageSize(640, 360), HEIGHT))
    assert found.horizon_row_px == pytest.approx(camera.horizon_row_px, abs=8.0)


@given(
    st.lists(st.tuples(st.floats(100, 1180), st.floats(150, 700), st.floats(30, 400)), min_size=1, max_size=3)
)
def test_boxes_that_are_no_vehicles_hardly_move_the_horizon(strays):
    """Houses, reflections and signs, of any size anywhere, among six vehicles: half a degree at most."""
    camera = GroundPlaneCamera(0.03, 1000.0, 359.5, HEIGHT.value, 639.5)
    places = [(12.0, 0.5), (15.0, -0.5), (20.0, 0.0), (26.0, 1.0), (35.0, 0.0), (50.0, -1.0)]
    rulers = rulers_of(camera, places)
    rulers += tuple(
        Ruler(column_px, row_px, width_px, Gaussian(1.8, 0.16), 2.0) for column_px, row_px, width_px in strays
    )
    found = calibrate_jointly(Known(Evidence(rulers=rulers), SIZE, HEIGHT))
    assert found.horizon_row_px == pytest.approx(camera.horizon_row_px, abs=1000.0 * math.radians(0.5))


def test_many_vehicles_tell_the_horizon_no_better_than_roads_are_level():
    """Forty in a row stand on one road, which may fall or rise by 0.25 degrees."""
    camera = GroundPlaneCamera(0.03, 1000.0, 359.5, HEIGHT.value, 639.5)
    for count in (10, 40):
        rulers = rulers_of(camera, [(d, 0.0) for d in np.linspace(15.0, 60.0, count).tolist()])
        found = calibrate_jointly(Known(Evidence(rulers=rulers), SIZE, HEIGHT))
        assert found.horizon_row_px == pytest.approx(camera.horizon_row_px, abs=3.0)
        least_px = 1000.0 * math.radians(0.25)
        assert least_px * 0.9 < camera_sigmas(found).horizon_row_px < least_px * 2.0


def test_wide_boxes_of_neighbours_do_not_make_a_lens_of_any_width():
    """Widths and rows hold nothing of the focal length, so the belief in it stays: 66 degrees."""
    camera = GroundPlaneCamera(0.02, 590.0, 239.5, 1.3, 426.5)
    places = [(d, side) for d in (8.0, 11.0, 15.0, 20.0, 27.0, 35.0) for side in (-3.6, 3.4, 0.2)]
    rulers = rulers_of(camera, places, width_m=2.2)
    travel = Gaussian(426.5, 4.0), Gaussian(camera.horizon_row_px, 3.0)
    found = calibrate_jointly(Known(Evidence(rulers=rulers, travel_px=travel), ImageSize(854, 480), HEIGHT))
    view_deg = math.degrees(2 * math.atan(427 / found.camera.focal_y_px))
    assert view_deg == pytest.approx(66, abs=5)


def test_a_focal_length_by_turns_narrows_distances_and_moves_them_with_it():
    travel = (Gaussian(639.5, 3.0), Gaussian(309.5, 3.0))
    known = Known(Evidence(travel_px=travel), SIZE, HEIGHT)
    told = replace(known, evidence=replace(known.evidence, focal_px=Gaussian(560.0, 56.0)))
    rough, turned = calibrate_jointly(known), calibrate_jointly(told)
    assert turned.camera.focal_y_px == pytest.approx(560.0, rel=0.1)
    assert turned.camera.focal_y_px > 560.0  # what is usual pulls a little
    low_m, high_m = turned.distance_interval(turned.row_at(20.0))
    rough_low_m, rough_high_m = rough.distance_interval(rough.row_at(20.0))
    assert high_m - low_m < 0.5 * (rough_high_m - rough_low_m)


def test_a_known_lens_is_not_moved_by_what_turns_tell():
    lens = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (0.0,) * 4, SIZE)
    evidence = Evidence(
        travel_px=(Gaussian(639.5, 3.0), Gaussian(309.5, 3.0)), focal_px=Gaussian(500.0, 20.0)
    )
    found = calibrate_jointly(Known(evidence, SIZE, HEIGHT, lens=lens))
    assert found.camera.focal_y_px == pytest.approx(1000.0, rel=1e-4)


def test_a_fit_that_runs_away_in_height_is_no_camera_and_no_fault():
    """The axis far below the picture, and two marks at one distance in places far apart."""
    points = (GroundPoint(26.0, 7.9, 41.0), GroundPoint(0.3, 47.5, 63.5), GroundPoint(0.3, 3.6, 24.7))
    known = Known(
        Evidence(points), ImageSize(64, 48), Gaussian(1.3, 0.5), priors=Priors(None, Gaussian(94300.0, 1.44))
    )
    with pytest.raises(UserError):
        calibrate_jointly(known)
