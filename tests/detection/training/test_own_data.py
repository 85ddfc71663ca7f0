"""The project's own data: what its sources hold, which camera took what, calibrations and terms."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from fcw.detection.training.dataset import read_labels
from fcw.detection.training.folders import load_training_set
from fcw.detection.training.own_data import (
    RESEARCH_ONLY,
    SOURCES,
    SPLITS,
    TRAIN,
    VALIDATION,
    camera_of,
    own_calibrations,
    read_calibration_table,
    read_own_labels,
)
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(640, 360)


def test_the_calibration_table_gives_the_rows_of_its_points(tmp_path):
    table = tmp_path / "calibrations.txt"
    table.write_text("# clip size height points belief\ndrive 640x360 1.2 6:280 12:230 60:190 good\n")
    calibration = read_calibration_table(table)["drive"]
    assert calibration.row_at(np.array([6.0, 12.0, 60.0])) == pytest.approx([280, 230, 190])
    assert calibration.image_size == SIZE


def test_a_wrong_line_of_the_calibration_table_is_named(tmp_path):
    table = tmp_path / "calibrations.txt"
    table.write_text("drive 640x360 tall 6:280 12:230 60:190 good\n")
    with pytest.raises(UserError, match=r"calibrations\.txt, line 1: 'drive 640x360 tall"):
        read_calibration_table(table)


# What the data's READMEs say of it

COUNTED = {
    ("tusimple", TRAIN): 661,
    ("tusimple", VALIDATION): 195,
    ("labels", TRAIN): 286,
    ("labels", VALIDATION): 136,
    ("streets", TRAIN): 554,
    ("streets", VALIDATION): 169,
    ("positives", TRAIN): 241,
    ("positives", VALIDATION): 45,
}


def test_every_source_has_the_vehicles_that_its_readme_counts(data_dir: Path):
    counted = {
        (source.name, split): sum(
            int((~image.ignored).sum())
            for image in read_labels(source.labels_of(data_dir, split), data_dir / source.images)
        )
        for source in SOURCES
        for split in SPLITS
    }
    assert counted == COUNTED


def test_every_picture_has_its_camera_and_a_calibration(data_dir: Path):
    images = read_own_labels(data_dir, SPLITS)
    pictures = Counter(image.camera for image in images)
    assert pictures == {
        "tusimple": 430 + 140,
        "udacity": 79,
        "kb": 70,
        "kitti_object": 31,
        "solidWhiteRight": 15,
        "muchlisin": 25,
        "sfnd": 26,
        "dawn": 118 + 29,
        "camvid": 225 + 15,
        "nuscenes": 32,
        "mahfuz195": 46,
        "level2": 200 + 39,
    }
    calibration_of = own_calibrations(data_dir)
    for image in images:
        calibration_of(image.clip).for_image_size(image.size)
    assert {image.camera for image in images if not image.complete} == {"level2"}
    assert all(image.path.is_file() for image in images)


def test_training_takes_all_train_splits_and_on_request_only_what_may_be_used_commercially(data_dir: Path):
    every, free = load_training_set(data_dir), load_training_set(data_dir, permissive_only=True)
    assert len(every) == 430 + 180 + 375 + 200
    assert sum(int((~image.labelled.ignored).sum()) for image in every) == 661 + 286 + 554 + 241
    assert {image.labelled.camera for image in free} == {"tusimple", "udacity", "kb"}
    assert {image.labelled.camera for image in every} - {image.labelled.camera for image in free} == (
        RESEARCH_ONLY - {"sfnd", "mahfuz195"}  # which are held out
    )


def test_the_views_give_tusimple_the_rear_faces_that_they_count(data_dir: Path):
    images = [image for image in read_own_labels(data_dir, SPLITS) if image.camera == "tusimple"]
    for image in images:
        x, _, w, h = image.boxes.T
        known = ~np.isnan(image.rear_boxes[:, 0])
        rear_x, _, rear_w, rear_h = image.rear_boxes.T
        inside = (rear_x >= x - 1) & (rear_x + rear_w <= x + w + 1) & (abs(rear_h - h) <= 1)
        assert inside[known].all()
    assert sum(int((~np.isnan(image.rear_boxes[:, 0])).sum()) for image in images) == 542 + 171


def test_a_clip_of_others_is_its_own_camera():
    assert camera_of("my_drive") == "my_drive"
    assert (camera_of("kitti_sfnd3d"), camera_of("kb_dashcam2")) == ("sfnd", "kb")


def test_a_clip_without_a_calibration_is_named(data_dir: Path):
    with pytest.raises(UserError, match=r"no calibration for the clip nowhere in .*calibrations\.txt"):
        own_calibrations(data_dir)("nowhere")
