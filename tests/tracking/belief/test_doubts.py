"""What is believed at once, what must earn it, and that no ghost hides a vehicle."""

import cv2
import numpy as np
import pytest

from fcw.box import Box, shared_area
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.threat.of_tracker import threats_of
from fcw.tracking.belief.still_picture import StillPicture
from fcw.tracking.tracker import Tracker
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel

CALIBRATION = Calibration.from_camera(
    GroundPlaneCamera(0.03, 740.0, 359.5, 1.3, 639.5), ImageSize(1280, 720), reference_offset_m=1.5
)
FRAME_NS = 33_333_333
OWN_MPS = 20.0
WORLD = np.random.default_rng(8).integers(0, 256, (720, 1280, 3), np.uint8)
OTHER = np.random.default_rng(9).integers(0, 256, (900, 1280, 3), np.uint8)


def seen(distance_m, lateral_m=0.0, noise_px=0.0, rng=None):
    """The box of a car, cut at the picture's border; None where nothing of it is in the picture."""
    box = CALIBRATION.ground_box(distance_m, lateral_m, 1.75, 1.5)
    off = np.zeros(4) if rng is None else rng.normal(0, noise_px, 4)
    left, right = max(box.x + off[0], 0.0), min(box.right + off[1], 1279.0)
    top, bottom = max(box.y + off[2], 0.0), min(box.bottom + off[3], 719.0)
    return Detection(Box(left, top, right - left, bottom - top), 9.0) if right - left > 20 else None


def drive(detections_at, seconds, own_mps: float | None = OWN_MPS, image_at=None):
    """Time, tracks, lead and level of every frame."""
    tracker, policy, ego = Tracker(CALIBRATION), make_policy(), assumed_ego(own_mps)
    for k in range(round(seconds * 30)):
        time_s = k * FRAME_NS / 1e9
        found = [one for one in detections_at(time_s) if one is not None]
        image = None if image_at is None else image_at(time_s)
        tracks = tracker.update(k * FRAME_NS, found, ego, image)
        state = policy.update(k * FRAME_NS, threats_of(tracker, tracks, ego), own_mps)
        yield time_s, tracks, tracker.lead_id, state


@pytest.mark.parametrize("seed", range(5))
def test_a_ghost_of_three_seconds_at_3_m_never_hides_the_lead_and_is_not_warned_of(seed):
    rng = np.random.default_rng(seed)

    def detections(time_s):
        ghost = seen(3.0, 0.0, 3.0, rng) if 2 <= time_s < 5 else None
        return seen(30.0, 0.0, 2.0, rng), ghost

    frames = list(drive(detections, 7))
    leads = {lead for time_s, _, lead, _ in frames if time_s > 0.5}
    assert leads == {1}
    assert max(state.level for *_, state in frames) == WarningLevel.NONE


def test_what_fills_the_picture_from_one_moment_to_the_next_is_not_warned_of():
    """The whole road at night was boxed for a while, and its box grew."""

    def detections(time_s):
        return [ghost_at(time_s)] if 2 <= time_s < 8 else []

    def ghost_at(time_s):
        width_px = min(700.0 + 500.0 * (time_s - 2), 1000.0)
        return Detection(Box(640.0 - width_px / 2, 210.0, width_px, 450.0), 9.0)

    frames = list(drive(detections, 9, own_mps=None))
    assert any(tracks for _, tracks, _, _ in frames)
    assert all(lead is None for _, _, lead, _ in frames)
    assert max(state.level for *_, state in frames) == WarningLevel.NONE


def test_a_lead_that_comes_to_fill_the_picture_is_believed_all_the_way():
    frames = list(drive(lambda time_s: [seen(max(25.0 - 7.0 * time_s, 0.5))], 4, own_mps=None))
    widest = max(track.box.w for _, tracks, _, _ in frames for track in tracks)
    assert widest > 0.6 * 1280
    assert not any(track.doubtful for _, tracks, _, _ in frames for track in tracks)
    assert max(state.level for *_, state in frames) == WarningLevel.WARNING


def test_what_is_behind_a_ghost_is_still_warned_of():
    def detections(time_s):
        return seen(max(60 - 12 * time_s, 6.0)), seen(3.0) if time_s > 1.5 else None

    warned = [state.track_id for *_, state in drive(detections, 4.4) if state.level == WarningLevel.WARNING]
    assert set(warned) == {1}


@pytest.mark.parametrize(("from_m", "rate_mps"), [(9.0, -3.5), (-9.0, 3.5)])
def test_a_cut_in_from_the_side_is_believed_within_0_3_s(from_m, rate_mps):
    def detections(time_s):
        beside = seen(8.0, from_m + rate_mps * (time_s - 2)) if time_s >= 2 else None
        return seen(40.0), beside

    first_s = believed_s = None
    for time_s, tracks, _, _ in drive(detections, 4):
        near = [track for track in tracks if track.distance_m < 20]
        if first_s is None and seen(8.0, from_m + rate_mps * (time_s - 2)) and time_s >= 2:
            first_s = time_s
        if believed_s is None and near and not near[0].doubtful:
            believed_s = time_s
    assert first_s is not None
    assert believed_s is not None
    assert believed_s - first_s <= 0.3


def test_a_car_uncovered_by_the_one_ahead_is_believed_as_soon_as_it_is_confirmed():
    def detections(time_s):
        lead = seen(12.0, 2.0 * max(time_s - 2, 0.0))
        return lead, seen(22.0) if time_s > 2.7 else None

    frames = drive(detections, 3.2)
    assert any(
        not track.doubtful
        for time_s, tracks, *_ in frames
        for track in tracks
        if time_s < 2.9 and track.track_id > 1
    )


def test_a_near_vehicle_found_late_is_believed_once_it_comes_nearer_for_a_while():
    def detections(time_s):
        return (seen(18 - 6 * (time_s - 2)) if time_s >= 2 else None,)

    doubts = {
        round(time_s - 2, 1): tracks[0].doubtful for time_s, tracks, *_ in drive(detections, 3.4) if tracks
    }
    assert doubts[0.3]
    assert not doubts[0.9]


def test_what_is_found_once_in_a_while_near_us_is_not_believed_because_it_seems_to_move():
    def detections(time_s):
        since = round((time_s - 2) * 30)
        return (seen(5 + 4 * (time_s - 2)) if 0 <= since < 5 or (since > 0 and since % 8 == 0) else None,)

    frames = [(time_s, tracks, lead) for time_s, tracks, lead, _ in drive(detections, 5.0) if tracks]
    assert frames[-1][0] > 4.5
    # Soon the five frames at its beginning are no third of all any more.
    assert all(track.doubtful for _, tracks, _ in frames for track in tracks)
    assert {lead for *_, lead in frames} == {None}


def every(frames, time_s):
    """Whether it is the turn of one of so many frames."""
    return round(time_s * 30) % frames == 0


def test_what_was_there_at_the_start_and_is_hardly_found_is_no_lead_for_long():
    frames = list(drive(lambda time_s: (seen(5.0) if time_s < 0.3 or every(12, time_s) else None,), 5.0))
    assert {lead for time_s, _, lead, _ in frames if 0.2 < time_s < 0.5} == {1}
    # After 3 s it was found in less than a quarter of its frames.
    later = [(tracks, lead) for time_s, tracks, lead, _ in frames if time_s > 3.0]
    assert all(track.doubtful for tracks, _ in later for track in tracks)
    assert any(tracks for tracks, _ in later)
    assert {lead for _, lead in later} == {None}


def test_what_was_there_at_the_start_is_doubted_where_a_vehicle_is_well_seen_through_it():
    def detections(time_s):
        return seen(30.0), seen(4.0) if every(5, time_s) or every(2, time_s) else None

    frames = list(drive(detections, 1.6))
    ahead, ghost = (next(t.track_id for t in frames[20][1] if abs(t.distance_m - d) < 2) for d in (28.5, 2.5))
    assert {lead for time_s, _, lead, _ in frames if 0.3 < time_s < 0.9} == {ghost}
    assert {lead for time_s, _, lead, _ in frames if time_s > 1.2} == {ahead}


def test_who_slides_in_front_of_the_lead_is_not_doubted_because_the_lead_was_found_just_before():
    """An oncoming car skidded across at 35 m/s; the lead had been found until it was hidden."""

    def detections(time_s):
        since_s, lead = time_s - 2.0, seen(60.0)
        if lead is None or since_s < 0:
            return (lead,)
        skids = seen(40 - 30 * since_s, max(3.5 - 3.5 * since_s, 0.0))
        hidden = skids is not None and shared_area(lead.box, skids.box) > 0.2 * lead.box.w * lead.box.h
        return (None if hidden else lead), skids

    frames = list(drive(detections, 3.1))
    assert {lead for time_s, _, lead, _ in frames if 0.5 < time_s < 2.0} == {1}
    skidding = [t for _, tracks, *_ in frames for t in tracks if t.track_id == 2]
    assert skidding
    assert skidding[-1].distance_m < 8.5
    assert not any(track.doubtful for track in skidding)


def test_a_vehicle_found_in_a_third_of_its_frames_from_the_start_stays_the_lead():
    frames = list(drive(lambda time_s: (seen(8.0) if time_s < 0.3 or every(3, time_s) else None,), 5.0))
    assert {lead for time_s, _, lead, _ in frames if time_s > 0.2} == {1}


def test_a_lead_that_was_well_found_and_is_hardly_found_any_more_is_still_believed():
    frames = list(drive(lambda time_s: (seen(8.0) if time_s < 2.0 or every(8, time_s) else None,), 10.0))
    assert {lead for time_s, _, lead, _ in frames if time_s > 0.2} == {1}
    assert not any(track.doubtful for _, tracks, *_ in frames for track in tracks)


def test_a_vehicle_lost_and_found_again_is_believed():
    def detections(time_s):
        return (None if 2 < time_s < 3.5 else seen(10.0),)

    frames = list(drive(detections, 4.2))
    assert not any(track.doubtful for _, tracks, *_ in frames for track in tracks)
    assert frames[-1][2] == 2


NOISE = np.random.default_rng(7).integers(0, 255, (200, 400)).astype(np.uint8).repeat(4, 0).repeat(4, 1)


def picture(time_s, still):
    """Noise that streams by, and a pattern that stands still or streams with it."""
    image = np.roll(NOISE, round(time_s * 200), axis=1)[:720, :1280]
    if still:
        image[560:700, 540:740] = NOISE[560:700, 540:740]
    return np.repeat(image[:, :, None], 3, axis=2)


@pytest.mark.slow
@pytest.mark.parametrize("still", [True, False])
def test_what_stands_still_while_the_road_moves_is_learned_and_what_moves_with_it_is_not(still):
    box = Detection(Box(545, 565, 190, 130), 9.0)
    frames = list(drive(lambda time_s: (box,), 4, None, lambda time_s: picture(time_s, still)))
    *_, (_, tracks, lead_id, _) = frames
    assert [track.doubtful for track in tracks] == [still]
    assert (lead_id is None) == still


def test_a_small_even_vehicle_that_nods_by_a_pixel_at_a_constant_gap_is_no_thing_on_the_windscreen():
    # Dark on a bright ground: a pixel aside it correlates with itself by 0.98.
    rows, columns = np.mgrid[330:380, 600:660]
    watch = StillPicture()
    for tenth in range(60):
        down_px = np.sin(2 * np.pi * 1.3 * tenth / 10)
        off = np.hypot((columns - 630) / 14, (rows - 355 - down_px) / 11)
        image = picture(tenth / 10, still=False)
        image[330:380, 600:660] = (220 - 180 / (1 + off**4))[:, :, None]
        assert not watch.update(tenth * 100_000_000, image, {1: Box(606.0, 337.0, 48.0, 36.0)})


def test_a_lead_that_stood_with_us_in_moving_traffic_is_believed_as_soon_as_we_come_nearer():
    def gap_m(time_s):
        return 4.0 - max(time_s - 6.0, 0.0) ** 2 / 2

    def image_at(time_s):
        image = np.roll(WORLD, round(300 * time_s), axis=1).copy()
        box = CALIBRATION.ground_box(gap_m(time_s), 0.0, 1.75, 1.5)
        left, top, right, bottom = (int(edge) for edge in (box.x, box.y, box.right, box.bottom))
        image[top:bottom, left:right] = cv2.resize(OTHER[:400, :400], (right - left, bottom - top))
        return image

    frames = list(drive(lambda time_s: [seen(gap_m(time_s))], 8, own_mps=None, image_at=image_at))
    doubted = {round(time_s, 1) for time_s, tracks, *_ in frames if any(track.doubtful for track in tracks)}
    assert max(doubted) == pytest.approx(6.2, abs=0.2)
    assert frames[-1][-1].level == WarningLevel.WARNING


def road_over(lower, time_s):
    """Pictures of moving ground whose lower 180 rows are something else, (180, 1280, 3)."""
    image = np.roll(WORLD, round(200 * time_s), axis=0).copy()
    image[540:] = lower
    return image


@pytest.mark.parametrize("stands", [True, False])
def test_the_road_that_is_boxed_with_our_own_dashboard_from_the_start_is_no_lead_for_long(stands):
    """The lower part of a vehicle does not stand in the picture while the rest goes by."""
    road = Detection(Box(100.0, 200.0, 1080.0, 519.0), 3.0)

    def image_at(time_s):
        down = 0 if stands else round(50 * time_s)
        return road_over(OTHER[down : down + 180], time_s)

    frames = list(drive(lambda _: [road], 5, own_mps=None, image_at=image_at))
    assert frames[15][2] == 1
    leads = {lead for time_s, _, lead, _ in frames if time_s > 2.5}
    assert leads == {None if stands else 1}


def test_a_lead_that_was_far_and_rarely_found_is_believed_when_it_is_near_and_always_found():
    def gap_m(time_s):
        slowly_m, fast_m = 35.0 - 3.0 * max(time_s - 20, 0.0), 25.0 - 6.0 * max(time_s - 23.33, 0.0)
        return max(min(slowly_m, fast_m) if time_s > 23.33 else slowly_m, 5.0)

    def detections(time_s):
        number = round(time_s * 30)
        return [seen(gap_m(time_s))] if gap_m(time_s) < 25 or number < 6 or number % 5 == 0 else []

    frames = list(drive(detections, 26.5))
    near = [(tracks, state) for time_s, tracks, _, state in frames if gap_m(time_s) < 24]
    assert sum(any(track.doubtful for track in tracks) for tracks, _ in near) / 30 < 1.0
    assert WarningLevel.WARNING in [state.level for _, state in near]


def test_a_ghost_does_not_take_the_width_of_the_lead_behind_it():
    """Of a reflection that hides a part of the lead, the closing speed came out 7 m/s too low."""
    ghost = Detection(Box(565.0, 340.0, 150.0, 100.0), 9.0)

    def worst_mps(with_ghost):
        worst = 0.0
        for time_s, tracks, _, _ in drive(
            lambda time_s: [seen(lead_m(time_s)), ghost if with_ghost and time_s > 1.5 else None], 8.5, 15.0
        ):
            lead = [track for track in tracks if track.track_id == 1]
            if lead and time_s > 6.5:
                worst = max(worst, abs(lead[0].closing_speed_mps - 4.0 * (time_s - 6)))
        return worst

    def lead_m(time_s):
        return 40.0 - 2.0 * max(time_s - 6, 0.0) ** 2  # it brakes with 4 m/s2

    assert worst_mps(with_ghost=True) < worst_mps(with_ghost=False) + 0.5
