"""Own motion against pictures of a road whose geometry is exact."""

import math

import cv2
import numpy as np
import pytest
from road_pictures import HEIGHT, WIDTH, Pose, Road, camera

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.frame import ImageSize
from fcw.motion.bend.turn import turn_of
from fcw.motion.estimator import MotionEstimator
from fcw.motion.settings import MotionSettings
from fcw.motion.state import SpeedSource

SIZE = ImageSize(WIDTH, HEIGHT)
STEP_S = 0.1


def estimator(pitch_deg=2.0, height_m=1.3):
    return MotionEstimator(Calibration.from_camera(camera(pitch_deg, height_m), SIZE))


def drive(estimator, speed_mps, frames, yaw_rate_radps=0.0, seed=0, boxes=(), change=None, **view):
    """Drive at a constant speed and yaw rate; the camera sits above the point that goes along the arc."""
    road, states = Road(seed), []
    for frame in range(frames):
        heading = yaw_rate_radps * frame * STEP_S
        way = speed_mps * frame * STEP_S
        if yaw_rate_radps:
            radius = speed_mps / yaw_rate_radps
            pose = Pose(radius * math.sin(heading), radius * (1 - math.cos(heading)), heading)
        else:
            pose = Pose(way)
        picture = road.picture(pose, **view)
        if change is not None:
            change(frame, picture)
        states.append(estimator.update(round(frame * STEP_S * 1e9), picture, boxes))
    return states


@pytest.mark.parametrize("speed_mps", [4.0, 12.0])
def test_speed_is_that_of_the_road_in_units_of_the_height(speed_mps):
    last = drive(estimator(), speed_mps, 12)[-1]
    assert last.speed_source is SpeedSource.PICTURE
    assert last.speed_mps == pytest.approx(speed_mps, rel=0.03)
    assert abs(last.yaw_rate_radps) < math.radians(0.3)


@pytest.mark.parametrize("speed_mps", [20.0, 36.0])
def test_a_road_that_grows_by_half_between_two_pictures_is_followed_as_far_as_it_goes(speed_mps):
    assert drive(estimator(), speed_mps, 12)[-1].speed_mps == pytest.approx(speed_mps, rel=0.015)


@pytest.mark.slow
def test_scale_and_height_are_one():
    right, high = (drive(estimator(height_m=height_m), 10.0, 12)[-1] for height_m in (1.3, 1.3 * 1.03))
    assert high.speed_mps == pytest.approx(right.speed_mps * 1.03, rel=0.005)


def test_standing_is_a_speed_of_nothing():
    last = drive(estimator(), 0.0, 8)[-1]
    assert last.speed_mps == pytest.approx(0.0, abs=0.1)
    assert last.speed_sigma_mps < 0.3


def test_who_reverses_does_not_stand():
    own, road = estimator(), Road()
    ways_m = np.cumsum([0.0] * 10 + [-0.05 * step for step in range(4)] + [-0.2] * 16)
    states = [
        own.update(round(frame * STEP_S * 1e9), road.picture(Pose(way_m)))
        for frame, way_m in enumerate(ways_m)
    ]
    assert states[9].speed_mps == pytest.approx(0.0, abs=0.1)
    assert {state.speed_mps for state in states[16:]} == {None}


@pytest.mark.parametrize("sigma", [2.0, 2.5])
def test_noise_tells_no_speed_though_each_that_is_supposed_explains_it(sigma):
    own, rng = estimator(), np.random.default_rng(4)
    for frame in range(15):
        noise = np.round(rng.normal(128, sigma, (HEIGHT, WIDTH, 1))).astype(np.uint8)
        assert own.update(round(frame * STEP_S * 1e9), np.repeat(noise, 3, axis=2)).speed_mps is None


def test_a_turn_to_the_left_is_positive():
    last = drive(estimator(), 8.0, 12, yaw_rate_radps=0.1)[-1]
    assert last.yaw_rate_radps == pytest.approx(0.1, abs=math.radians(0.3))
    assert last.speed_mps == pytest.approx(8.0, rel=0.04)


@pytest.mark.slow
@pytest.mark.parametrize("off_deg", [-1.0, 1.0])
def test_a_pitch_that_the_calibration_has_wrong_is_found(off_deg):
    last = drive(estimator(pitch_deg=2.0 + off_deg), 10.0, 60)[-1]
    assert math.degrees(last.mount.pitch_rad) == pytest.approx(2.0, abs=0.2)
    assert last.speed_mps == pytest.approx(10.0, rel=0.04)


@pytest.mark.slow
def test_yaw_and_roll_of_the_mount_are_found():
    last = drive(estimator(), 10.0, 60, yaw_deg=3.0, roll_deg=1.5)[-1]
    assert math.degrees(last.mount.yaw_rad) == pytest.approx(3.0, abs=0.2)
    assert math.degrees(last.mount.roll_rad) == pytest.approx(1.5, abs=0.4)
    assert abs(last.mount.yaw_rad - math.radians(3.0)) < 4 * last.mount.yaw_sigma_rad


def test_a_drive_is_never_sure_of_the_roll():
    """A kerb along the right edge of the lane looks like a tilted road for as long as it is there."""
    mount = drive(estimator(), 10.0, 20)[-1].mount
    assert mount.roll_sigma_rad > math.radians(2.0)
    assert mount.pitch_sigma_rad < math.radians(0.5)


def test_black_pictures_say_nothing_and_the_last_value_decays():
    own = estimator()
    before = drive(own, 10.0, 12)[-1]
    black = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    states = [own.update(round((1.2 + k * STEP_S) * 1e9), black) for k in range(60)]
    assert states[2].speed_mps == pytest.approx(before.speed_mps, rel=0.1)
    assert states[2].speed_sigma_mps > before.speed_sigma_mps
    # How we turn is soon anything, long before the speed is.
    assert states[4].speed_mps is not None
    assert turn_of(states[0]) is not None
    assert turn_of(states[4]) is None
    assert states[-1].speed_mps is None
    assert states[-1].yaw_rate_radps is None
    assert states[-1].speed_source is SpeedSource.UNKNOWN
    assert states[-1].mount is not None


@pytest.mark.slow
@pytest.mark.parametrize(("driven_s", "believed"), [(0.8, False), (2.5, True)])
def test_the_mount_is_believed_after_a_second_of_one_speed(driven_s, believed):
    """Then pictures tell nothing any more: what less than a second of them taught is forgotten."""
    own = estimator(pitch_deg=3.0)
    states = drive(own, 10.0, round(driven_s / STEP_S), roll_deg=1.5)
    black = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    states += [own.update(round((driven_s + k * STEP_S) * 1e9), black) for k in range(60)]
    assert states[7].speed_mps is not None
    assert [math.degrees(state.mount.pitch_rad) for state in states[:8]] == pytest.approx([3.0] * 8)
    turned_deg = math.degrees(states[-1].mount.pitch_rad) - 3.0, math.degrees(states[-1].mount.roll_rad)
    if believed:
        assert turned_deg[0] < -0.4
        assert turned_deg[1] > 0.5
    else:
        assert turned_deg == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_vehicle_that_stays_ahead_does_not_stop_us():
    def lead(_, picture):
        rng = np.random.default_rng(5)
        picture[150:250, 250:400] = rng.integers(0, 255, (100, 150, 1), dtype=np.uint8)

    boxes = (Box(250, 150, 150, 100),)
    last = drive(estimator(), 10.0, 12, boxes=boxes, change=lead)[-1]
    assert last.speed_mps == pytest.approx(10.0, rel=0.05)


@pytest.mark.parametrize("rate_hz", [10, 15])
def test_a_picture_that_was_lost_does_not_make_us_fast(rate_hz):
    """At its place stands the next one: for a step we seem to go twice as far."""
    own, road, speeds = estimator(), Road(), []
    for frame in range(24):
        taken = frame if frame < 14 else frame + 1
        picture = road.picture(Pose(10.0 * taken / rate_hz))
        speeds.append(own.update(round(frame / rate_hz * 1e9), picture).speed_mps)
    assert speeds[13:] == pytest.approx([10.0] * 11, rel=0.05)


def test_two_pictures_alone_tell_no_speed():
    def snow(frame, picture):
        if frame not in seen:
            picture[:] = np.random.default_rng(frame).integers(0, 255, picture.shape, dtype=np.uint8)

    seen = {4, 5}  # when a speed is looked for
    assert {state.speed_mps for state in drive(estimator(), 10.0, 8, change=snow)} == {None}
    seen = {4, 5, 6, 7}
    speeds = [state.speed_mps for state in drive(estimator(), 10.0, 8, change=snow)]
    assert speeds[:7] == [None] * 7
    assert speeds[7] == pytest.approx(10.0, rel=0.05)


@pytest.mark.slow
def test_pictures_faster_than_needed_are_left_out():
    own, road = estimator(), Road()
    seen = []
    for frame in range(60):
        own.update(round(frame / 60 * 1e9), road.picture(Pose(10.0 * frame / 60)))
        assert own.picture is not None
        seen.append(own.picture.time_ns)
    assert len(set(seen)) <= 22
    assert own.state.speed_mps == pytest.approx(10.0, rel=0.04)


def dashboard(_, picture):
    """The lower third of the picture, and the clutter on it."""
    first = HEIGHT * 2 // 3
    rng = np.random.default_rng(11)
    coarse = rng.integers(20, 200, ((HEIGHT - first) // 8, WIDTH // 8), dtype=np.uint8)
    picture[first:] = np.kron(coarse, np.ones((8, 8), np.uint8))[:, :, None]


@pytest.mark.slow
@pytest.mark.parametrize("speed_mps", [5.0, 14.0])
def test_a_dashboard_in_the_picture_does_not_make_us_stand(speed_mps):
    last = drive(estimator(), speed_mps, 40, change=dashboard)[-1]
    assert last.speed_mps == pytest.approx(speed_mps, rel=0.25)


def glossy_bonnet(frame, picture):
    """The near road up to 8 m, and on it the sky line that it mirrors: a pixel higher in each picture."""
    first = HEIGHT - 100
    rng = np.random.default_rng(12)
    coarse = rng.integers(20, 200, (HEIGHT // 8, WIDTH // 8), dtype=np.uint8)
    mirrored = np.kron(coarse, np.ones((8, 8), np.uint8))[frame : frame + HEIGHT - first, :WIDTH]
    picture[first:] = mirrored[:, :, None]


@pytest.mark.slow
@pytest.mark.parametrize("speed_mps", [10.0, 14.0])
def test_a_bonnet_that_mirrors_the_world_does_not_hide_the_speed(speed_mps):
    told = [state.speed_mps for state in drive(estimator(), speed_mps, 40, change=glossy_bonnet)[10:]]
    assert None not in told
    assert np.median(np.array(told, float)) == pytest.approx(speed_mps, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(("stands_part", "mirrored_px"), [(0.5, 1), (0.7, 1), (0.7, 3)])
def test_who_brakes_behind_a_bonnet_of_which_half_stands_is_not_lost(stands_part, mirrored_px):
    """Its own marks shine through what it mirrors, which goes so many pixels in each picture."""
    own, road, rng = estimator(), Road(), np.random.default_rng(12)
    marks, mirrored = (
        np.kron(rng.integers(20, 200, (13, WIDTH // 8), dtype=np.uint8), np.ones((8, 8))) for _ in range(2)
    )
    speeds_mps = np.clip(12.0 - 6.0 * STEP_S * (np.arange(60) - 15), 3.0, 12.0)
    told = []
    for frame, way_m in enumerate(np.cumsum(speeds_mps * STEP_S)):
        picture = road.picture(Pose(way_m))
        shown = stands_part * marks + (1 - stands_part) * np.roll(mirrored, mirrored_px * frame, axis=0)
        picture[-100:] = shown[:100, :, None]
        told.append(own.update(round(frame * STEP_S * 1e9), picture).speed_mps)
    assert None not in told[8:]
    assert np.array(told[8:], float) == pytest.approx(speeds_mps[8:], abs=0.9)
    assert np.array(told[35:], float) == pytest.approx(speeds_mps[35:], rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("times", [2, 4])
def test_repeated_pictures_do_not_make_us_stand(times):
    """A video of 30 pictures a second made from one of 15 or 7.5, encoded again."""
    own, road, rng, speeds = estimator(), Road(), np.random.default_rng(1), []
    for frame in range(90):
        noise = rng.random((HEIGHT, WIDTH, 1)) < 0.1
        picture = road.picture(Pose(6.0 * (frame // times * times) / 30)) | noise
        speeds.append(own.update(round(frame / 30 * 1e9), picture.astype(np.uint8)).speed_mps)
    assert speeds[-1] == pytest.approx(6.0, rel=0.05)
    assert all(speed is None or speed > 5.0 for speed in speeds[45:])


@pytest.mark.slow
def test_an_even_speed_is_even_in_a_video_that_repeats_every_fifth_picture():
    """Of 30 pictures a second, made from one of 25: new pictures are shown 33 or 67 ms apart."""
    own, road, rng, speeds = estimator(), Road(), np.random.default_rng(1), []
    for frame in range(90):
        noise = rng.random((HEIGHT, WIDTH, 1)) < 0.1
        picture = road.picture(Pose(12.0 * (frame * 25 // 30) / 25)) | noise
        speeds.append(own.update(round(frame / 30 * 1e9), picture.astype(np.uint8)).speed_mps)
    assert speeds[45:] == pytest.approx([12.0] * 45, rel=0.06)


def on_a_plain_road(solid_m, dashed_m, frames=40, noise=1.0, speed_mps=12.0):
    """Speeds found on a road of one grey with lines at these lateral places; between them is noise alone."""
    own, road, rng, speeds = estimator(), Road(), np.random.default_rng(2), []
    for frame in range(frames):
        x_m = speed_mps * frame * STEP_S
        picture = road.picture(Pose(x_m))
        plain = np.full_like(picture, 90)
        for y_m in solid_m:
            paint(plain, y_m, 4.0, 200.0)
        for start_m in np.arange(-x_m % 8.0 - 8.0, 60.0, 8.0):
            for y_m in dashed_m:
                paint(plain, y_m, start_m, start_m + 2.0)
        below = round(camera().horizon_row_px) + 8
        picture[below:] = np.clip(plain[below:] + rng.normal(0, noise, plain[below:].shape), 0, 255)
        speeds.append(own.update(round(frame * STEP_S * 1e9), picture).speed_mps)
    return speeds


@pytest.mark.slow
def test_solid_lines_and_noise_tell_no_speed():
    assert on_a_plain_road((-5.4, -1.8, 1.8), ()) == [None] * 40


@pytest.mark.slow
def test_solid_lines_do_not_make_us_slow():
    known = [speed_mps for speed_mps in on_a_plain_road((-5.4, 5.4), (-1.8, 1.8)) if speed_mps is not None]
    assert len(known) > 20
    assert known == pytest.approx([12.0] * len(known), rel=0.05)


def hills_alone(_, picture):
    """A road of one grey, and haze before what is far: the hills to both sides are left."""
    picture[round(camera().horizon_row_px) + 8 :] = 90
    picture[:, WIDTH // 2 - 80 : WIDTH // 2 + 80] = 90


@pytest.mark.slow
@pytest.mark.parametrize("off_deg", [-2.0, 2.0])
def test_a_plain_road_tells_where_the_camera_looks_though_not_how_fast_we_are(off_deg):
    wide = MotionSettings(calibration_pitch_sigma_rad=math.radians(2.0))
    own = MotionEstimator(Calibration.from_camera(camera(2.0 + off_deg), SIZE), wide)
    states = drive(own, 12.0, 60, change=hills_alone)
    assert all(state.speed_mps is None for state in states)
    pitch_deg, sigma_deg = (
        math.degrees(angle) for angle in (states[-1].mount.pitch_rad, states[-1].mount.pitch_sigma_rad)
    )
    assert sigma_deg < 1.3
    assert pitch_deg == pytest.approx(2.0, abs=1.1)
    assert pitch_deg == pytest.approx(2.0, abs=2 * sigma_deg)


@pytest.mark.parametrize("yaw_rate_radps", [-0.05, 0.0, 0.05])
def test_a_plain_road_tells_how_we_turn_though_not_how_fast_we_are(yaw_rate_radps):
    states = drive(estimator(), 12.0, 12, yaw_rate_radps, change=hills_alone)
    assert all(state.speed_mps is None for state in states)
    turns = [state.yaw_rate_radps for state in states[4:]]
    assert turns == pytest.approx([yaw_rate_radps] * 8, abs=math.radians(0.3))
    assert all(state.yaw_rate_sigma_radps < math.radians(0.6) for state in states[4:])


def test_where_nothing_is_seen_nobody_knows_how_we_turn():
    own = estimator()
    for frame in range(4):
        blank = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
        assert own.update(round(frame * STEP_S * 1e9), blank).yaw_rate_radps is None


@pytest.mark.slow
def test_what_stands_tells_nothing_of_the_camera():
    last = drive(estimator(pitch_deg=3.0), 0.0, 30, change=hills_alone)[-1]
    assert math.degrees(last.mount.pitch_rad) == pytest.approx(3.0)


def paint(picture, y_m, from_m, to_m):
    """A white line on the road, 15 cm wide, between two distances; y to the left."""
    ways = np.geomspace(max(from_m, 3.0), max(to_m, 3.0), 40)
    view = camera()
    sides = [
        np.column_stack((view.column_at(np.full(40, -y_m + side), ways), view.row_at(ways)))
        for side in (-0.075, 0.075)
    ]
    polygon = np.vstack((sides[0], sides[1][::-1]))
    cv2.fillPoly(picture, [np.round(polygon * 16).astype(np.int32)], (220, 220, 220), cv2.LINE_AA, shift=4)


def test_no_speed_is_found_to_which_nobody_could_have_braked():
    """What goes by at 16 m/s, and in the next picture at 4: points that agree by chance."""
    own, road, way_m = estimator(), Road(), 0.0
    for frame in range(40):
        way_m += (16.0 if frame < 15 else 4.0) * STEP_S
        speed_mps = own.update(round(frame * STEP_S * 1e9), road.picture(Pose(way_m))).speed_mps
        least_mps = 16.0 - 10.0 * max(frame - 15, 0) * STEP_S - 2.0
        assert speed_mps is None or speed_mps > least_mps or least_mps < 4.0
    assert own.state.speed_mps == pytest.approx(4.0, rel=0.05)
