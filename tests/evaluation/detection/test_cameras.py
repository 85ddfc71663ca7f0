"""Leave-one-camera-out: no model is tested on a camera that it saw, and what was found is kept."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from fcw.box import Box
from fcw.detection.detector import Detection
from fcw.errors import UserError
from fcw.evaluation.detection.cameras import GROUPS, Found, detect_left_out, folds, read_cameras
from fcw.evaluation.detection.detectors import FrameDetections
from fcw.evaluation.detection.vehicles import vehicle_identities

CLIPS = {
    "tusimple/{split}_views.json": ("tusimple", "tusimple/images", {"train": 2, "validation": 2}),
    "labels/{split}.json": ("udacity_test_video", "labels/images", {"train": 2, "validation": 1}),
    "streets/{split}.json": ("mahfuz195", "streets/images", {"train": 1, "validation": 3}),
    "streets/positives_{split}.json": ("level2", "streets/images", {"train": 2, "validation": 4}),
}
SIDE = {"width": 64, "height": 36}


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """The layout of the project's data: four cameras, a vehicle in each picture, moving slowly."""
    for labels, (clip, images, splits) in CLIPS.items():
        for split, count in splits.items():
            pictures, annotations = [], []
            for number in range(count):
                name = f"{clip}/{split}{number}.png"
                path = tmp_path / images / name
                path.parent.mkdir(parents=True, exist_ok=True)
                cv2.imwrite(str(path), np.zeros((36, 64, 3), np.uint8))
                pictures.append({"id": number, "file_name": name, "clip": clip, "frame": 12 * number, **SIDE})
                annotations.append({"id": number, "image_id": number, "bbox": [10 + number, 15, 20, 16]})
            path = tmp_path / labels.format(split=split)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps({"images": pictures, "annotations": annotations}))
    line = "{} 64x36 1.2 6:28 12:23 60:19 good\n"
    (tmp_path / "calibrations.txt").write_text("".join(map(line.format, ("tusimple", "udacity_test_video"))))
    table = tmp_path / "streets/calibrations.txt"
    table.write_text("".join(map(line.format, ("mahfuz195", "level2"))))
    return tmp_path


SMALL_GROUPS = (("tusimple",), ("udacity", "mahfuz195"))


def test_no_picture_is_tested_by_a_model_that_learnt_from_its_camera(data: Path):
    cameras = read_cameras(data)
    first, second = folds(cameras, SMALL_GROUPS)
    names = cameras.cameras
    assert (first.name, second.name) == ("tusimple", "udacity+mahfuz195")
    assert sorted(names[first.learnt]) == ["level2"] * 2 + ["mahfuz195"] * 4 + ["udacity"] * 3
    assert sorted(names[first.tested]) == ["level2"] * 2 + ["tusimple"] * 4
    assert sorted(names[second.learnt]) == ["level2"] * 2 + ["tusimple"] * 4
    assert sorted(names[second.tested]) == ["level2"] * 2 + ["mahfuz195"] * 4 + ["udacity"] * 3
    tested = np.concatenate([first.tested, second.tested])
    learnt = np.concatenate([first.learnt, second.learnt])
    assert len(np.unique(tested)) == len(tested)
    # Of incomplete pictures the train split is always learnt from, the validation split never.
    held_out = np.flatnonzero(cameras.held_out)
    assert len(held_out) == 4
    assert set(held_out) <= set(tested)
    assert not set(held_out) & set(learnt)


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ((*SMALL_GROUPS, ("tusimple",)), "tusimple is named twice"),
        ((*SMALL_GROUPS, ("level2",)), "level2 is no camera of the data"),
    ],
)
def test_groups_name_no_camera_twice_and_none_that_is_not_there(data: Path, groups, message):
    with pytest.raises(UserError, match=message):
        folds(read_cameras(data), groups)


def test_cameras_in_no_group_are_learnt_from_and_not_tested(data: Path):
    cameras = read_cameras(data)
    (fold,) = folds(cameras, [("tusimple",)])
    assert set(cameras.cameras[fold.tested]) == {"level2", "tusimple"}
    assert sorted(cameras.cameras[fold.learnt]) == ["level2"] * 2 + ["mahfuz195"] * 4 + ["udacity"] * 3
    assert not set(fold.tested) & set(fold.learnt)


class Seen:
    """A detector that finds one box; its score says from how many pictures it learnt."""

    name = "seen"

    def __init__(self, pictures: int) -> None:
        self._pictures = pictures

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        return (Detection(Box(10.0, 15.0, 20.0, 16.0), float(self._pictures)),)


def test_each_fold_is_detected_in_by_the_model_that_was_made_without_it(data: Path, tmp_path: Path):
    cameras = read_cameras(data)
    parts = folds(cameras, SMALL_GROUPS)
    together = Found({}, tuple(part.name for part in parts))
    for part in parts:
        found = detect_left_out(cameras, part, len, {"it": lambda model, _: lambda image: Seen(model)})
        assert list(found) == ["it"]
        together = together.with_more(found["it"])
    tested = np.concatenate([part.tested for part in parts])
    assert together.has(cameras, tested)
    assert not together.has(cameras, parts[0].learnt)  # level2's train split
    scores = {
        camera: {float(frame.scores[0]) for frame in together.on(cameras, members)}
        for camera in ("tusimple", "udacity")
        for members in [tested[cameras.cameras[tested] == camera]]
    }
    assert scores == {"tusimple": {9.0}, "udacity": {6.0}}
    together.save(tmp_path / "it.npz")
    again = Found.load(tmp_path / "it.npz")
    assert again.groups == ("tusimple", "udacity+mahfuz195")
    for mine, other in zip(together.on(cameras, tested), again.on(cameras, tested), strict=True):
        assert mine.boxes.tolist() == other.boxes.tolist()
        assert mine.scores.tolist() == other.scores.tolist()


def test_pictures_without_detections_are_kept_as_looked_at(tmp_path: Path):
    one = FrameDetections(np.ones((1, 4)), np.ones(1), 0.0, None)
    none = FrameDetections(np.zeros((0, 4)), np.zeros(0), 0.0, None)
    Found({"a": none, "b": one, "c": none}).save(tmp_path / "it.npz")
    again = Found.load(tmp_path / "it.npz")
    assert {name: len(frame.scores) for name, frame in again.pictures.items()} == {"a": 0, "b": 1, "c": 0}
    assert again.groups == ()


def test_a_file_that_holds_something_else_is_refused(tmp_path: Path):
    np.savez(tmp_path / "it.npz", something=np.zeros(3))
    with pytest.raises(UserError, match="no detections"):
        Found.load(tmp_path / "it.npz")


def test_a_drive_with_a_known_rate_has_times_so_that_its_vehicles_are_linked(data: Path):
    images = [image for image in read_cameras(data).images if image.labelled.camera == "mahfuz195"]
    # Train has frame 0, validation 0, 12 and 24 of a drive at 12 pictures a second.
    assert [image.time_s for image in images] == [0.0, 0.0, 1.0, 2.0]
    assert len({int(each[0]) for each in vehicle_identities(images[1:])}) == 1


def test_the_default_groups_leave_out_every_camera_of_the_data_once(data_dir: Path):
    cameras = read_cameras(data_dir)
    parts = folds(cameras, GROUPS)
    tested = np.concatenate([part.tested for part in parts])
    assert len(np.unique(tested)) == len(tested) == int(cameras.complete.sum()) + 39
    counted = sum(int(cameras.images[index].counted.sum()) for index in tested)
    assert counted == 661 + 195 + 286 + 136 + 554 + 169 + 45
    for part in parts:
        left_out = set(part.name.split("+"))
        assert not left_out & set(cameras.cameras[part.learnt])
        assert set(cameras.cameras[part.tested]) == left_out | {"level2"}
