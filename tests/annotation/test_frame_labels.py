"""The frames that people labelled, as labels to learn from and to measure with."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from annotation_helpers import SIZE, frame_result, labels, write_log
from hypothesis import given
from hypothesis import strategies as st

from fcw.annotation.frame_labels import frame_labels
from fcw.annotation.records import BoxEdit, Entry, FrameConfirmed, LabelledBox, new_box_id, track_box_id
from fcw.annotation.review import fold
from fcw.annotation.store import ReviewStore
from fcw.box import Box
from fcw.detection.training.folders import load_training_set
from fcw.detection.training.training import TrainingSettings
from fcw.evaluation.detection.labels import read_annotated
from fcw.warning.types import WarningLevel
from fcw_viz.cli import main

NONE = WarningLevel.NONE
FIRST, SECOND = Box(140.25, 100.5, 40.0, 30.0), Box(20.0, 95.0, 20.0, 16.0)
"""Of the tracks 7 and 8 in every frame."""
CORRECTED = LabelledBox(Box(141.3, 99.7, 39.1, 31.9), 7)
ADDED = LabelledBox(Box(250.1, 96.2, 24.3, 20.4))


def said_of(*sayings):
    """What is known of frame 5 after one person said some things."""
    entries = (
        Entry(str(i), f"2026-11-20T10:00:{i:02}.000000Z", "Ann", said) for i, said in enumerate(sayings)
    )
    return fold(entries).frames[5]


def labelled(*sayings):
    return frame_labels(frame_result(5, NONE, FIRST, SECOND), said_of(*sayings))


def test_in_a_confirmed_frame_all_boxes_of_the_log_count():
    assert labelled(FrameConfirmed(5)) == (LabelledBox(FIRST, 7), LabelledBox(SECOND, 8))


def test_where_one_box_was_corrected_it_counts_and_the_others_are_ignored_until_somebody_confirms():
    edit = BoxEdit(5, track_box_id(7), CORRECTED)
    assert labelled(edit) == (CORRECTED, LabelledBox(SECOND, 8, ignore=True))
    assert labelled(edit, FrameConfirmed(5)) == (CORRECTED, LabelledBox(SECOND, 8))


def test_a_deleted_box_is_gone_and_an_added_one_is_there():
    new = new_box_id()
    edits = BoxEdit(5, track_box_id(8), None), BoxEdit(5, new, ADDED)
    assert labelled(FrameConfirmed(5), *edits) == (LabelledBox(FIRST, 7), ADDED)
    assert labelled(FrameConfirmed(5), *edits, BoxEdit(5, new, None)) == (LabelledBox(FIRST, 7),)


@given(st.lists(st.tuples(st.sampled_from([7, 8]), st.none() | labels), min_size=1))
def test_of_each_box_the_last_edit_counts(edits):
    found = labelled(*(BoxEdit(5, track_box_id(track_id), label) for track_id, label in edits))
    last = dict(edits)
    untouched = {7: LabelledBox(FIRST, 7, ignore=True), 8: LabelledBox(SECOND, 8, ignore=True)}
    assert list(found) == [label for label in (untouched | last).values() if label is not None]


# As files


def picture(index):
    """A road and, in the first track's place, a car with lights; brighter from frame to frame."""
    image = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    image[:90] = 180
    left, top = round(FIRST.x), round(FIRST.y)
    cv2.rectangle(image, (left, top), (left + 40, top + 30), (20 + 10 * index,) * 3, -1)
    cv2.rectangle(image, (left, top + 12), (left + 7, top + 18), (30, 30, 220), -1)
    cv2.rectangle(image, (left + 33, top + 12), (left + 40, top + 18), (30, 30, 220), -1)
    return np.clip(image + np.random.default_rng(index).normal(0, 5, image.shape), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def drives(tmp_path_factory):
    """Two drives: Ann labelled the frames 3, 4, 6, 8, 10 and 12 of the first and none of the second."""
    folder = tmp_path_factory.mktemp("drives")
    pictures = [picture(i) for i in range(16)]
    results = [frame_result(i, NONE, FIRST, SECOND) for i in range(16)]
    first = write_log(folder / "first/drive.mcap", results, pictures)
    write_log(folder / "second/drive.mcap", results[:3], pictures[:3])
    store = ReviewStore(first)
    store.add("Ann", BoxEdit(3, track_box_id(7), CORRECTED))
    store.add("Ann", BoxEdit(4, "new 1", replace(ADDED, ignore=True)))
    for index in (4, 6, 8, 10, 12):
        store.add("Ann", FrameConfirmed(index))
    store.close()
    return folder


def exported(drives, out, *options):
    assert (
        main(["export", *map(str, drives), "--format", "coco", "--annotations", "--out", str(out), *options])
        == 0
    )
    return out


@pytest.fixture(scope="module")
def folder(drives, tmp_path_factory):
    return exported([drives], tmp_path_factory.mktemp("out") / "labelled")


def test_the_folder_holds_the_labelled_frames_with_the_boxes_as_they_were_left(folder):
    images = read_annotated(folder / "labels.json", folder / "images")
    assert [image.labelled.path.name for image in images] == [f"{i:06}.jpg" for i in (3, 4, 6, 8, 10, 12)]
    third, fourth, *_ = images
    # The log's own boxes are of single precision, a person's are kept to the last bit.
    assert third.labelled.boxes.tolist() == [[141.3, 99.7, 39.1, 31.9], [20, 95, 20, 16]]
    assert third.labelled.ignored.tolist() == [False, True]
    assert [fields.get("track_id") for fields in third.attributes] == [7, 8]
    assert fourth.labelled.ignored.tolist() == [False, False, True]
    assert [fields.get("track_id") for fields in fourth.attributes] == [7, 8, None]


def test_the_pictures_are_those_of_the_frames(folder):
    for image in read_annotated(folder / "labels.json", folder / "images"):
        index = int(image.labelled.path.stem)
        difference = np.abs(image.labelled.read().astype(float) - picture(index))
        assert difference.mean() < 6  # H.264 and JPEG lose a little
        car = image.labelled.read()[103:110, 150:170].mean()
        assert car == pytest.approx(20 + 10 * index, abs=4)


@pytest.mark.slow
def test_fcw_train_learns_from_the_boxes_that_count(folder, tmp_path, monkeypatch, capsys):
    tiny = TrainingSettings(
        tree_counts=(2, 4),
        second_tree_count=2,
        second_runs=1,
        folds=2,
        crops_per_vehicle=1,
        displaced_per_vehicle=1,
        random_per_image=10,
        mined_per_image=2,
    )
    monkeypatch.setattr(
        "fcw.detection.training.training.TrainingSettings", lambda seed: replace(tiny, seed=seed)
    )
    assert main(["train", "--data", str(folder), "--out", str(tmp_path / "model.npz")]) == 0
    log = capsys.readouterr().err
    assert "training on 6 pictures" in log
    # 1 in the frame corrected, 2 in each of the 5 confirmed; two windows of each.
    assert "all pictures, round 1: 2 trees, 22 windows of vehicles" in log
    assert (tmp_path / "model.npz").is_file()


@pytest.mark.slow
def test_fcw_evaluate_detection_measures_with_them(folder, capsys):
    arguments = [str(folder / "labels.json"), "--images", str(folder / "images")]
    arguments += ["--calibration", str(folder / "calibration"), "--json"]
    assert main(["evaluate", "detection", *arguments]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["frames"], result["vehicles"]) == (6, 11)


def test_they_can_be_added_to_other_pictures(folder, drives, tmp_path):
    early = exported([drives / "first"], tmp_path / "early", "--between", "0", "0.45")
    images = load_training_set(folder, early)
    assert [int(image.labelled.path.stem) for image in images] == [3, 4, 6, 8, 10, 12, 3, 4]


def test_drives_without_labelled_frames_are_counted_and_left_out(drives, tmp_path, capsys):
    exported([drives], tmp_path / "out")
    assert "note: 1 of 2 drives has no labelled frame, left out\n" in capsys.readouterr().err
    exported([drives], tmp_path / "early", "--between", "0", "0.45")
    assert "note: 1 of 2 drives has no labelled frame in that time, left out\n" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("drive", "options", "message"),
    [
        ("second", ["--format", "coco", "--annotations"], "drive.mcap: no labelled frame; correct boxes"),
        ("first", ["--format", "csv", "--annotations"], "--annotations --format csv: only for coco"),
        ("first", ["--format", "coco", "--annotations", "--every", "2"], "people chose the frames"),
    ],
)
def test_what_cannot_be_exported_is_told(drives, drive, options, message, tmp_path, capsys):
    assert main(["export", str(drives / drive), *options, "--out", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err
