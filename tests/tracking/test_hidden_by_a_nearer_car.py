"""A vehicle behind a nearer one is not carried off by it, nor seems to come nearer as it comes out."""

import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.evaluation.simulated import vehicle_at
from fcw.frame import ImageSize
from fcw.simulation.drive import true_calibration
from fcw.simulation.picture.renderer import Renderer
from fcw.simulation.truth.truth import frame_truth
from fcw.simulation.world.scenario import IMAGE_SIZE, load_scenario
from fcw.simulation.world.world import World
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import SeenBy

SIZE = ImageSize(1280, 720)
CALIBRATION = Calibration.from_camera(GroundPlaneCamera(0.03, 740.0, 359.5, 1.3, 639.5), SIZE)
BANDS = np.where(np.arange(384) % 60 < 30, 70, 170)[:, None]
"""Cars look alike: glass, body and bumper are at the same heights."""


def looks_like_a_car(rng, cell_px):
    """Bands, and what is a car's own; 384 x 384."""
    own = rng.integers(-30, 30, (384 // cell_px, 384 // cell_px))
    return (BANDS + np.kron(own, np.ones((cell_px, cell_px), int))).astype(np.uint8)


def paint(image, box, looks):
    left, top, right, bottom = (round(edge) for edge in (box.x, box.y, box.right, box.bottom))
    first, last = max(left, 0), min(right, SIZE.width)
    if last > first:
        image[top:bottom, first:last] = looks[: bottom - top, first - left : last - left, None]


@pytest.mark.parametrize("seed", [1, 2])
def test_a_hidden_car_stays_where_it_is_while_a_nearer_one_passes_in_front(seed):
    # What is left of the far car's looks goes over into the near one's, and would be carried away by it.
    rng = np.random.default_rng(seed)
    far_looks, near_looks = looks_like_a_car(rng, 8), looks_like_a_car(rng, 16)
    far = CALIBRATION.ground_box(22.0, 0.0, 1.8, 1.5)
    tracker, carried = Tracker(CALIBRATION), []
    for frame in range(100):
        time_s = frame / 30
        image = np.full((SIZE.height, SIZE.width, 3), 120, np.uint8)
        paint(image, far, far_looks)
        near = CALIBRATION.ground_box(9.0, 2.9 - 1.2 * max(time_s - 0.8, 0.0), 1.8, 1.5)
        paint(image, near, near_looks)
        hides = near.x < far.center_x < near.right
        # The detector finds the far car until the near one comes to it.
        detections = [Detection(near, 9.0)] + ([Detection(far, 9.0)] if near.right < far.x else [])
        for track in tracker.update(round(time_s * 1e9), detections, image=image):
            if track.distance_m > 15:
                carried.append((hides, track))
    hidden = [track for hides, track in carried if hides]
    assert hidden
    assert all(track.seen_by is SeenBy.COASTING for track in hidden)
    for _, track in carried:
        assert track.box.center_x == pytest.approx(far.center_x, abs=0.25 * far.w)


@pytest.mark.parametrize("with_picture", [False, True])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_car_that_comes_out_from_behind_a_nearer_one_does_not_seem_to_come_nearer(seed, with_picture):
    # It stays 40 m ahead. What is seen of it grows from less than half to the whole within half a second.
    rng = np.random.default_rng(seed)
    far_looks, near_looks = looks_like_a_car(rng, 4), looks_like_a_car(rng, 16)
    far = CALIBRATION.ground_box(40.0, 0.0, 1.8, 1.5)
    tracker, closing_mps = Tracker(CALIBRATION), []
    for frame in range(60):
        time_s = frame / 30
        image = np.full((SIZE.height, SIZE.width, 3), 120, np.uint8)
        paint(image, far, far_looks)
        near = CALIBRATION.ground_box(20.0, 1.0 + max(time_s - 0.1, 0.0), 1.8, 1.5)
        paint(image, near, near_looks)
        left = max(far.x, near.right)
        # Its roof comes out with its side.
        out = (far.right - left) / far.w
        height = far.h * (0.75 + 0.25 * out)
        found = Box(left, far.bottom - height, far.right - left, height)
        detections = [Detection(near, 9.0), Detection(found, 9.0)]
        tracks = tracker.update(round(time_s * 1e9), detections, image=image if with_picture else None)
        closing_mps += [track.closing_speed_mps for track in tracks if track.distance_m > 30]
    assert len(closing_mps) > 45
    assert max(closing_mps) < 3.0


@pytest.mark.slow
def test_a_rendered_car_that_comes_out_from_behind_another_comes_no_faster_than_it_does():
    scenario = load_scenario("bend-entry")
    camera, offset_m = scenario.camera.camera(), scenario.camera.reference_offset_m
    renderer = Renderer(camera, IMAGE_SIZE, 0)
    # Each frame is searched, and each second one: where one is not, its looks in the picture are all there
    # is, and they grow as it comes out.
    trackers = {every: Tracker(true_calibration(scenario)) for every in (1, 2)}
    faster_mps = {every: [] for every in trackers}
    states = [state for state in World(scenario, 0).states() if 1.0e9 <= state.time_ns <= 3.25e9]
    for number, state in enumerate(states):
        truth, picture = frame_truth(state, camera, IMAGE_SIZE, offset_m), renderer.render(state)
        seen = [vehicle for vehicle in truth.vehicles if vehicle.visible_fraction > 0.5]
        found = [Detection(vehicle.box, 9.0) for vehicle in seen if vehicle.distance_m < 45]
        for every, tracker in trackers.items():
            searched = found if number % every == 0 else None
            for track in tracker.update(state.time_ns, searched, image=picture):
                vehicle = vehicle_at(track.box, truth)
                if vehicle is not None:
                    faster_mps[every].append(track.closing_speed_mps - vehicle.closing_speed_mps)
    for of_one in faster_mps.values():
        assert len(of_one) > 50
        assert max(of_one) < 1.5
