"""Own speed by the road as a whole, on roads that have no corner to follow."""

import itertools
import math

import numpy as np
import pytest
from road_pictures import HEIGHT, WIDTH, Pose, Road, camera

from fcw.box import Box
from fcw.camera.calibration import Calibration, Gaussian
from fcw.frame import ImageSize
from fcw.motion.estimator import MotionEstimator
from fcw.motion.flow.road_plane import RoadPlane
from fcw.motion.settings import MotionSettings

SIZE = ImageSize(WIDTH, HEIGHT)
RATE_HZ = 10
POINTS_TELL_NOTHING = math.inf
BELOW = round(camera().horizon_row_px) + 8


def estimator(pitch_sigma_deg=0.4, **settings):
    wanted = MotionSettings(
        first_evidence=POINTS_TELL_NOTHING,
        calibration_pitch_sigma_rad=math.radians(pitch_sigma_deg),
        **settings,
    )
    return MotionEstimator(Calibration.from_camera(camera(), SIZE), wanted)


def drive(own, speeds_mps, yaw_rate_radps=0.0, change=lambda picture: None, rate_hz=RATE_HZ):
    """Along a road of faint patches under noise; a speed for each picture."""
    road, rng, way_m, states = Road(), np.random.default_rng(3), 0.0, []
    for frame, speed_mps in enumerate(speeds_mps):
        way_m += speed_mps / rate_hz
        heading_rad = yaw_rate_radps * frame / rate_hz
        side_m = 0.0 if not yaw_rate_radps else speed_mps / yaw_rate_radps * (1 - math.cos(heading_rad))
        picture = road.picture(Pose(way_m, side_m, heading_rad)).astype(np.float32)
        picture[BELOW:] = 100 + 0.25 * (picture[BELOW:] - 110)
        picture += 1.5 * rng.standard_normal((HEIGHT, WIDTH, 1), np.float32)
        change(picture)
        states.append(own.update(round(frame / rate_hz * 1e9), np.clip(picture, 0, 255).astype("u1")))
    return states


@pytest.mark.parametrize("speed_mps", [6.0, 14.0, 28.0])
def test_the_road_tells_the_speed_within_two_seconds(speed_mps):
    states = drive(estimator(), [speed_mps] * 25)
    assert states[9].speed_mps is None
    known = [state.speed_mps for state in states[20:]]
    assert known == pytest.approx([speed_mps] * 5, rel=0.05)


def test_fast_pictures_tell_a_fast_speed():
    states = drive(estimator(), [38.0] * 60, rate_hz=30)
    assert states[-1].speed_mps == pytest.approx(38.0, rel=0.05)


@pytest.mark.parametrize("yaw_rate_radps", [-0.1, 0.1])
def test_a_turn_changes_nothing(yaw_rate_radps):
    states = drive(estimator(), [12.0] * 25, yaw_rate_radps)
    assert states[-1].speed_mps == pytest.approx(12.0, rel=0.06)


def test_braking_is_followed():
    speeds_mps = [20.0] * 25 + [20.0 - 0.3 * step for step in range(30)]
    states = drive(estimator(), speeds_mps)
    for state, speed_mps in zip(states[25:], speeds_mps[25:], strict=True):
        if state.speed_mps is not None:
            assert abs(state.speed_mps - speed_mps) < 2 * state.speed_sigma_mps
    assert sum(state.speed_mps is not None for state in states[25:]) > 15


@pytest.mark.parametrize(("braking_mps2", "most_sigmas"), [(5.0, 2.0), (8.0, 3.0)])
def test_of_a_road_that_vanishes_while_we_brake_the_speed_is_known_no_better_than_it_is(
    braking_mps2, most_sigmas
):
    pictures = itertools.count()

    def vanish(picture):
        if next(pictures) > 28:
            picture[:] = 110 + 0.02 * (picture - 110)

    speeds_mps = [20.0] * 25 + [20.0 - braking_mps2 * step / RATE_HZ for step in range(1, 24)]
    for state, speed_mps in zip(drive(estimator(), speeds_mps, change=vanish), speeds_mps, strict=True):
        if state.speed_mps is not None:
            assert state.speed_mps - speed_mps < most_sigmas * state.speed_sigma_mps


@pytest.mark.slow
@pytest.mark.parametrize("rate_hz", [10, 20])
def test_braking_is_followed_within_a_fifth_of_a_second_at_every_rate(rate_hz):
    braking_mps2, steady, braking = 3.0, round(2.5 * rate_hz), 3 * rate_hz
    speeds_mps = [20.0] * steady + [20.0 - braking_mps2 * step / rate_hz for step in range(1, braking + 1)]
    states = drive(estimator(), speeds_mps, rate_hz=rate_hz)
    late_mps = [
        state.speed_mps - speed_mps
        for state, speed_mps in zip(states[steady:], speeds_mps[steady:], strict=True)
        if state.speed_mps is not None
    ]
    assert len(late_mps) > braking / 2
    assert np.mean(late_mps) < 0.2 * braking_mps2


def test_what_stands_in_the_picture_is_no_road():
    def bonnet(picture):
        rows = picture[HEIGHT * 3 // 4 :]
        rows[:] = (
            np.random.default_rng(7)
            .integers(60, 160, (len(rows) // 6 + 1, WIDTH // 8, 1))
            .repeat(6, axis=0)
            .repeat(8, axis=1)[: len(rows)]
        )

    states = drive(estimator(), [14.0] * 30, change=bonnet)
    assert states[-1].speed_mps == pytest.approx(14.0, rel=0.06)


def blocks_that_stand_for_a_moment():
    """Stronger than the road, and other ones every 0.4 s, so that they are not learnt to stand."""
    rng, pictures = np.random.default_rng(11), itertools.count()
    blocks = np.empty((HEIGHT // 6 + 1, WIDTH // 8 + 1, 1))

    def change(picture):
        if next(pictures) % 4 == 0:
            blocks[:] = rng.normal(0, 6, blocks.shape)
        picture[BELOW:] += blocks.repeat(6, axis=0).repeat(8, axis=1)[BELOW:HEIGHT, :WIDTH]

    return change


@pytest.mark.parametrize("speed_mps", [14.0, 28.0])
def test_what_stands_for_a_moment_hides_no_road(speed_mps):
    states = drive(estimator(), [speed_mps] * 40, change=blocks_that_stand_for_a_moment())
    assert states[-1].speed_mps == pytest.approx(speed_mps, rel=0.06)


def test_what_stands_for_a_moment_drives_no_standing_car():
    states = drive(estimator(), [0.0] * 40, change=blocks_that_stand_for_a_moment())
    assert {state.speed_mps for state in states} == {None}


def test_a_standing_car_has_no_speed_by_the_road():
    assert {state.speed_mps for state in drive(estimator(), [0.0] * 30)} == {None}


def test_noise_and_solid_lines_tell_no_speed():
    rng = np.random.default_rng(5)

    def plain(picture):
        picture[BELOW:] = 100 + rng.normal(0, 1.5, picture[BELOW:].shape)
        picture[BELOW:, WIDTH // 2 - 60 : WIDTH // 2 - 50] += 60

    assert {state.speed_mps for state in drive(estimator(), [14.0] * 40, change=plain)} == {None}


def test_a_vehicle_ahead_is_no_road():
    """Its rear fills the strip but for a metre on each side, and stays; another one has left the picture."""
    box = Box(230, BELOW - 30, 180, HEIGHT - BELOW)

    def rear(picture):
        picture[round(box.y) : round(box.bottom), round(box.x) : round(box.right)] = 40

    own, road, rng = estimator(), Road(), np.random.default_rng(3)
    for frame in range(30):
        picture = road.picture(Pose(1.2 * frame)).astype(float)
        picture[BELOW:] = 100 + 0.25 * (picture[BELOW:] - 110)
        picture += rng.normal(0, 1.5, picture.shape)
        rear(picture)
        pixels = np.clip(picture, 0, 255).astype("u1")
        own.update(round(frame / RATE_HZ * 1e9), pixels, (box, Box(-300, -300, 200, 200)))
    assert own.state.speed_mps == pytest.approx(12.0, rel=0.06)


def test_what_was_told_last_decays():
    own = estimator()
    before = drive(own, [14.0] * 25)[-1]
    black = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    states = [own.update(round((2.5 + step / RATE_HZ) * 1e9), black) for step in range(30)]
    assert states[3].speed_mps == pytest.approx(before.speed_mps, rel=0.02)
    assert states[3].speed_sigma_mps > before.speed_sigma_mps
    assert states[-1].speed_mps is None


def test_where_the_camera_looks_is_part_of_the_interval():
    """A degree of pitch is a quarter of the speed: nothing is known where it may be that much."""
    sure, unsure = (drive(estimator(deg, asks_direction=False), [14.0] * 25)[-1] for deg in (0.2, 1.5))
    assert sure.speed_sigma_mps < 0.1 * 14
    assert unsure.speed_mps is None


def test_neither_the_mount_nor_the_calibrations_scale_is_judged_by_it():
    with_road, without = (drive(estimator(asks_direction=False), [v] * 25)[-1] for v in (14.0, 0.0))
    assert with_road.speed_mps is not None
    assert with_road.picture_speed_mps is None
    assert with_road.mount == without.mount


def speeds_where_the_road_tells(by_road, monkeypatch):
    """On a road whose points tell 5 m/s."""
    monkeypatch.setattr(RoadPlane, "speed_mps", lambda *_: by_road)
    own, road, speeds_mps = MotionEstimator(Calibration.from_camera(camera(), SIZE)), Road(), []
    for frame in range(20):
        picture = road.picture(Pose(5.0 * frame / RATE_HZ))
        speeds_mps.append(own.update(round(frame / RATE_HZ * 1e9), picture).speed_mps)
    return speeds_mps


def test_points_that_were_just_found_wait_for_a_second_where_the_road_contradicts_them(monkeypatch):
    speeds_mps = speeds_where_the_road_tells(Gaussian(16.0, 1.0), monkeypatch)
    assert speeds_mps[:10] == [16.0] * 10
    assert speeds_mps[16:] == pytest.approx([5.0] * 4, rel=0.03)


def test_points_that_were_just_found_count_at_once_where_the_road_agrees(monkeypatch):
    speeds_mps = speeds_where_the_road_tells(Gaussian(5.7, 0.5), monkeypatch)
    assert speeds_mps[0] == 5.7
    assert speeds_mps[4:] == pytest.approx([5.0] * 16, rel=0.05)


def test_nobody_is_fast_right_after_standing(monkeypatch):
    """As the road seemed to be where a bus crossed right before a car that stood (one clip)."""
    own, rng = MotionEstimator(Calibration.from_camera(camera(), SIZE)), np.random.default_rng(3)
    standing = Road().picture(Pose(0.0)).astype(float)
    monkeypatch.setattr(RoadPlane, "speed_mps", lambda *_: None)
    for frame in range(30):
        picture = np.clip(standing + rng.normal(0, 1.0, standing.shape), 0, 255).astype("u1")
        own.update(round(frame / RATE_HZ * 1e9), picture)
    assert own.state.speed_mps == pytest.approx(0.0, abs=0.1)
    monkeypatch.setattr(RoadPlane, "speed_mps", lambda *_: Gaussian(30.0, 3.0))
    speeds_mps = [
        own.update(round((3 + frame / RATE_HZ) * 1e9), rng.integers(0, 255, standing.shape, "u1")).speed_mps
        for frame in range(60)
    ]
    assert 30.0 not in speeds_mps[:30]
    assert speeds_mps[-1] == 30.0
