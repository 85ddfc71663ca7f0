"""Scenes that the glance learns from, and what its cells are to say of the vehicles in them."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.net.bands import SHOWN
from fcw.detection.net.glance import CELL_PX
from fcw.detection.net.training.scenes import (
    COLUMNS,
    IGNORED,
    ROWS,
    Scenes,
    SceneSettings,
    View,
    above_bonnet,
    around_vehicle,
    cells_of,
    hidden_by,
    seen_through,
)
from fcw.detection.training.dataset import NO_BOX, LabelledImage, TrainingImage
from fcw.errors import UserError
from fcw.frame import ImageSize

PLAIN = SceneSettings(blurred_part=0.0, varied_part=0.0)


def view(*boxes: tuple[float, float, float, float], ignored: tuple[bool, ...] = ()) -> View:
    """Bright vehicles on black, by left, top, right, bottom."""
    picture = np.zeros((SHOWN.height, SHOWN.width, 3), np.uint8)
    corners = np.array(boxes, np.float64).reshape(-1, 4)
    for left, top, right, bottom in np.clip(corners, 0, None).astype(int):
        picture[top:bottom, left:right] = 200
    areas = np.prod(corners[:, 2:] - corners[:, :2], axis=1)
    return View(picture, corners, areas, np.array(ignored or [False] * len(corners), bool))


def found(vehicle: np.ndarray, reaches: np.ndarray) -> set[tuple[float, ...]]:
    """Left, top, right, bottom of the vehicles that cells are to find, px."""
    rows, columns = np.nonzero(vehicle == 1.0)
    middles = (np.column_stack([columns, rows]) + 0.5) * CELL_PX
    left, top, right, bottom = reaches[:, rows, columns] * CELL_PX
    sides = (middles[:, 0] - left, middles[:, 1] - top, middles[:, 0] + right, middles[:, 1] + bottom)
    return {tuple(np.round(box, 1).tolist()) for box in np.column_stack(sides)}


def test_cells_in_the_middle_of_a_vehicle_say_where_it_ends_and_others_that_there_is_none():
    vehicle, reaches = cells_of(view((60.0, 30.0, 140.0, 100.0)), complete=True)
    assert found(vehicle, reaches) == {(60.0, 30.0, 140.0, 100.0)}
    middle_row, middle_column = 65 // CELL_PX, 100 // CELL_PX
    assert vehicle[middle_row, middle_column] == 1.0
    assert vehicle[middle_row, 84 // CELL_PX - 1] == IGNORED  # between the middle and the edge
    assert vehicle[middle_row, 60 // CELL_PX - 1] == 0.0


def test_of_a_vehicle_that_is_cut_by_the_picture_what_is_left_is_to_be_found():
    vehicle, reaches = cells_of(view((-30.0, 40.0, 60.0, 150.0)), complete=True)
    assert found(vehicle, reaches) == {(0.0, 40.0, 60.0, float(SHOWN.height))}


@pytest.mark.parametrize(
    "box", [(100.0, 40.0, 112.0, 52.0), (-200.0, 40.0, 60.0, 120.0)], ids=["small", "mostly outside"]
)
def test_of_small_vehicles_and_of_those_mostly_outside_nothing_is_said(box):
    vehicle, _ = cells_of(view(box), complete=True)
    assert not np.any(vehicle == 1.0)
    rows, columns = np.nonzero(vehicle == IGNORED)
    assert len(rows)
    assert np.all((columns + 0.5) * CELL_PX < box[2] + 3)


def test_of_ignored_vehicles_nothing_is_said_and_of_what_is_not_labelled_neither():
    both = view((20.0, 40.0, 60.0, 80.0), (140.0, 40.0, 200.0, 100.0), ignored=(True, False))
    vehicle, reaches = cells_of(both, complete=True)
    assert found(vehicle, reaches) == {(140.0, 40.0, 200.0, 100.0)}
    assert vehicle[60 // CELL_PX, 40 // CELL_PX] == IGNORED
    assert vehicle[ROWS - 1, COLUMNS // 2] == 0.0
    vehicle, reaches = cells_of(both, complete=False)
    assert found(vehicle, reaches) == {(140.0, 40.0, 200.0, 100.0)}
    assert vehicle[ROWS - 1, COLUMNS // 2] == IGNORED


def test_the_vehicle_in_front_has_the_cells_that_two_share():
    vehicle, reaches = cells_of(view((40.0, 0.0, 200.0, 120.0), (90.0, 40.0, 150.0, 100.0)), complete=True)
    row, column = 70 // CELL_PX, 120 // CELL_PX
    assert vehicle[row, column] == 1.0
    assert reaches[1, row, column] * CELL_PX == pytest.approx((row + 0.5) * CELL_PX - 40.0)


@given(st.integers(0, 10_000))
@settings(deadline=None)
def test_above_a_bonnet_vehicles_end_where_it_begins(seed):
    before = view((60.0, 30.0, 140.0, 125.0))
    after = above_bonnet(before, np.random.default_rng(seed))
    assert after.boxes[0, 3] <= 125.0
    assert np.array_equal(after.boxes[0, :3], before.boxes[0, :3])
    end = int(after.boxes[0, 3])
    assert np.all(after.picture[30 : end - 1, 100] == 200)


@given(st.integers(0, 10_000))
@settings(deadline=None)
def test_what_is_set_in_front_is_a_vehicle_too_and_leaves_most_of_the_other(seed):
    before, other = view((60.0, 30.0, 140.0, 100.0)), np.full((50, 60, 3), 90, np.uint8)
    after = hidden_by(other, before, 0.45, np.random.default_rng(seed))
    assert len(after.boxes) == 2
    assert not after.ignored.any()
    left, _, right, _ = np.clip(after.boxes[1], 0, [SHOWN.width, SHOWN.height] * 2)
    assert (min(right, 140.0) - max(left, 60.0)) / 80.0 <= 0.47
    column = int(np.clip((left + right) / 2, 0, SHOWN.width - 1))
    assert np.any(after.picture[:, column] == 90)


def test_the_same_picture_through_a_window_has_its_boxes_there():
    picture = np.zeros((400, 600, 3), np.uint8)
    picture[100:200, 200:300] = 200
    box = np.array([[200.0, 100.0, 100.0, 100.0]])
    size = np.sqrt(100.0 * 100.0)
    for seed in range(20):
        random = np.random.default_rng(seed)
        window = around_vehicle(picture, box[0], SHOWN.width / SHOWN.height, PLAIN, random)
        assert PLAIN.sizes[0] <= size / window.height
        assert window.height <= 400 * PLAIN.beyond
        seen = seen_through(window, picture, box, np.zeros(1, bool))
        rows, columns = np.nonzero(seen.picture[..., 0] > 100)
        left, top, right, bottom = np.clip(seen.boxes[0], 0, [SHOWN.width, SHOWN.height] * 2)
        edges = columns.min(), rows.min(), columns.max() + 1, rows.max() + 1
        assert edges == pytest.approx((left, top, right, bottom), abs=2.5)


def test_scenes_are_drawn_from_labelled_pictures_with_or_without_vehicles(tmp_path):
    picture = np.full((240, 400, 3), 60, np.uint8)
    picture[100:180, 150:250] = 220
    cv2.imwrite(str(tmp_path / "a.png"), picture)
    size = ImageSize(400, 240)
    labelled = LabelledImage(
        tmp_path / "a.png",
        "one",
        size,
        np.array([[150.0, 100.0, 100.0, 80.0]]),
        np.zeros(1, bool),
        np.array([NO_BOX]),
    )
    empty = replace(
        labelled, clip="two", boxes=np.empty((0, 4)), ignored=np.zeros(0, bool), rear_boxes=np.empty((0, 4))
    )
    camera = GroundPlaneCamera(
        height_m=1.3, pitch_rad=0.0, focal_y_px=400.0, principal_row_px=120.0, principal_column_px=200.0
    )
    calibration = Calibration.from_camera(camera, size)
    images = [TrainingImage(each, calibration) for each in (labelled, empty)]
    scenes = Scenes(images, SceneSettings())
    assert len(scenes) == 1
    drawn = [scenes.draw(np.random.default_rng(seed)) for seed in range(40)]
    assert all(scene.picture.shape == (SHOWN.height, SHOWN.width, 3) for scene in drawn)
    assert sum(bool(np.any(scene.vehicle == 1.0)) for scene in drawn) >= 30
    again = scenes.draw(np.random.default_rng(7))
    assert all(np.array_equal(one, other) for one, other in zip(drawn[7], again, strict=True))
    small = replace(labelled, boxes=np.array([[150.0, 100.0, 14.0, 13.0]]))
    with pytest.raises(UserError, match=r"no labelled vehicle to learn from has 14 px.*label larger ones"):
        Scenes([TrainingImage(small, calibration)], SceneSettings())
