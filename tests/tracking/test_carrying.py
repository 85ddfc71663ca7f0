"""A vehicle the detector no longer finds is carried by the picture: rendered, real, and by boxes painted."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.solve import calibrate
from fcw.detection.acf import AcfDetector
from fcw.detection.detector import Detection
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.simulation.drive import true_calibration
from fcw.simulation.picture.renderer import Renderer
from fcw.simulation.truth.truth import frame_truth
from fcw.simulation.world.scenario import IMAGE_SIZE, load_scenario
from fcw.simulation.world.state import VEHICLE_SIZES, VehicleKind
from fcw.simulation.world.world import World
from fcw.sources import open_source
from fcw.tracking.picture.follower import FollowingSettings
from fcw.tracking.range.model import REARS, RangeModel
from fcw.tracking.settings import TrackerSettings
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import SeenBy

pytestmark = pytest.mark.slow

_SALOON = replace(REARS[0], overhang_m=VEHICLE_SIZES[VehicleKind.SALOON].overhang_m)
RENDERED = RangeModel(rears=(_SALOON, *REARS[1:]))
"""Knows where the rendered lead's tyres meet the road."""
SFND_FRAME_NS = round(1e9 / 9.65)
SFND_LEAD = {
    5: (556, 191, 706, 321),
    10: (556, 190, 712, 324),
    20: (553, 191, 726, 339),
    30: (547, 196, 742, 367),
    40: (541, 193, 762, 374.5),
    50: (530, 190, 783, 374.5),
    60: (529, 194, 788, 374.5),
    70: (531, 194, 788, 374.5),
    77: (531, 194, 788, 374.5),
}
"""Left, top, right and bottom of the lead of the SFND drive by frame, set by eye; from frame 40 on its tyres
are below the picture."""


def iou(box: Box, edges: tuple[float, float, float, float], height: int) -> float:
    """Of the part of a box in the picture with one of known edges."""
    left, top, right, bottom = edges
    lower = min(box.bottom, height - 0.5)
    w, h = min(box.right, right) - max(box.x, left), min(lower, bottom) - max(box.y, top)
    shared = max(w, 0.0) * max(h, 0.0)
    return shared / ((right - left) * (bottom - top) + box.w * (lower - box.y) - shared)


@pytest.fixture(scope="module")
def braking():
    """Frames of a lead that brakes, from 15 to 2 m, 15 a second: time, picture, truth of the lead."""
    scenario = load_scenario("braking")
    camera, offset_m = scenario.camera.camera(), scenario.camera.reference_offset_m
    renderer = Renderer(camera, IMAGE_SIZE, 0)
    states = [state for state in World(scenario, 0).states() if 7.0e9 <= state.time_ns <= 9.8e9][::2]
    frames = []
    for state in states:
        (lead,) = frame_truth(state, camera, IMAGE_SIZE, offset_m).vehicles
        frames.append((state.time_ns, renderer.render(state), lead))
    return true_calibration(scenario), frames


def test_a_lead_that_fills_the_picture_is_carried_where_the_detector_sees_nothing(braking):
    calibration, frames = braking
    # The rendered camera is calibrated exactly: this is about carrying, not about wrong calibrations.
    exact = replace(RENDERED, calibration_pitch_sigma_rad=0.0)
    tracker = Tracker(calibration, TrackerSettings(model=exact))
    for time_ns, image, truth in frames:
        found = truth.distance_m > 8.0
        tracks = tracker.update(time_ns, [Detection(truth.box, 9.0)] if found else [], image=image)
        if time_ns < frames[5][0]:
            continue
        (lead,) = tracks
        assert tracker.lead_id == lead.track_id == 1
        assert lead.seen_by is (SeenBy.DETECTOR if found else SeenBy.PICTURE)
        edges = truth.box.x, truth.box.y, truth.box.right, truth.box.bottom
        assert iou(lead.box, edges, IMAGE_SIZE.height) > 0.85
        if not found:
            assert lead.distance_m == pytest.approx(truth.distance_m, rel=0.1, abs=0.3)
            assert lead.closing_speed_mps == pytest.approx(truth.closing_speed_mps, abs=1.0)
    last = frames[-1][2]
    assert last.distance_m < 2.0
    assert last.box.w > 500


def test_growth_in_the_picture_tells_the_closing_speed_better_than_boxes(braking):
    calibration, frames = braking
    errors = {}
    for with_picture in (False, True):
        tracker = Tracker(calibration, TrackerSettings(model=RENDERED))
        rng = np.random.default_rng(3)
        for time_ns, image, truth in frames:
            x, y, right, bottom = (
                np.array([truth.box.x, truth.box.y, truth.box.right, truth.box.bottom])
                + 0.04 * truth.box.h * rng.standard_normal(4)
            ).tolist()
            found = Detection(Box(x, y, right - x, bottom - y), 9.0)
            tracks = tracker.update(time_ns, [found], image=image if with_picture else None)
            if tracks and tracks[0].age_s > 1.0:
                errors.setdefault(with_picture, []).append(
                    tracks[0].closing_speed_mps - truth.closing_speed_mps
                )
    by_boxes, by_picture = (math.sqrt(np.mean(np.square(errors[key]))) for key in (False, True))
    assert by_picture < by_boxes / 2
    assert by_picture < 0.7


def test_without_pictures_it_coasts_and_ends(braking):
    calibration, frames = braking
    tracker = Tracker(calibration)
    seen_by, tracks = set(), ()
    for time_ns, _, truth in frames:
        tracks = tracker.update(time_ns, [Detection(truth.box, 9.0)] if truth.distance_m > 8.0 else [])
        seen_by |= {track.seen_by for track in tracks}
    assert seen_by == {SeenBy.DETECTOR, SeenBy.COASTING}
    assert not tracks


def carried_s(frames, found_frames, following):
    """How long a vehicle found in the first frames is carried in a picture that stands still."""
    calibration, pictures = frames
    _, image, truth = pictures[0]
    tracker = Tracker(calibration, TrackerSettings(following=following))
    step_ns = 50_000_000
    carried = 0
    for k in range(found_frames + 200):
        detections = [Detection(truth.box, 9.0)] if k < found_frames else []
        tracks = tracker.update(k * step_ns, detections, image=image)
        carried += sum(track.seen_by is SeenBy.PICTURE for track in tracks)
    return carried * step_ns / 1e9


def test_what_the_detector_saw_for_longer_is_carried_for_longer_up_to_a_bound(braking):
    following = FollowingSettings(credit=4.0, longest_s=3.0)
    assert carried_s(braking, 3, following) == pytest.approx(4 * 2 * 0.05, abs=0.051)
    assert carried_s(braking, 6, following) == pytest.approx(4 * 5 * 0.05, abs=0.051)
    assert carried_s(braking, 40, following) == pytest.approx(3.0, abs=0.051)


@pytest.mark.parametrize(("own_mps", "carried"), [(20.0, False), (0.0, True), (None, True)])
def test_what_stands_still_in_the_picture_while_we_drive_is_not_carried_on(braking, own_mps, carried):
    """Dirt on the windscreen before a road that streams by, against a lead that we stand behind."""
    calibration, frames = braking
    tracker, (_, image, truth) = Tracker(calibration), frames[0]
    seen_by = []
    for k in range(60):
        detections = [Detection(truth.box, 9.0)] if k < 10 else []
        tracks = tracker.update(k * 50_000_000, detections, assumed_ego(own_mps), image)
        seen_by.append(tracks[0].seen_by if tracks else None)
    assert seen_by[10 : 10 + 19] == [SeenBy.PICTURE] * 19
    assert (seen_by[-1] is SeenBy.PICTURE) == carried


def test_a_part_of_a_vehicle_that_is_found_is_not_carried(braking):
    calibration, frames = braking
    tracker = Tracker(calibration)
    _, image, truth = frames[-1]
    tracks = ()
    whole, wheel = truth.box, Box(truth.box.x + 50, truth.box.y + 150, 150, 130)
    for k in range(30):
        found = [Detection(whole, 9.0)] + ([Detection(wheel, 9.0)] if k < 10 else [])
        tracks = tracker.update(k * 33_333_333, found, image=image)
    assert [track.seen_by for track in tracks if track.box.w < 300] in ([], [SeenBy.COASTING])


def test_the_lead_of_the_sfnd_drive_is_never_lost(data_dir):
    points = tuple(GroundPoint(d, row) for d, row in ((8.0, 321.67), (15.0, 252.22), (40.0, 202.62)))
    calibration: Calibration = calibrate(points, ImageSize(1242, 375), 1.65)
    detector, tracker = AcfDetector(Model.load(SHIPPED_MODEL_PATH), calibration), Tracker(calibration)
    ids, seen = set(), set()
    for index, frame in enumerate(open_source(data_dir / "kitti-sfnd" / "images").frames()):
        time_ns = index * SFND_FRAME_NS
        tracks = tracker.update(time_ns, detector.detect(frame.image), image=frame.image)
        if not 5 <= index <= 77:
            continue
        (lead,) = (track for track in tracks if track.track_id == tracker.lead_id)
        assert not lead.coasting, index
        ids.add(lead.track_id)
        seen.add(index)
        if index in SFND_LEAD:
            assert iou(lead.box, SFND_LEAD[index], 375) >= 0.5, index
    assert seen == set(range(5, 78))
    assert len(ids) == 1
