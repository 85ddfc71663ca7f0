"""Labels, calibrations and conditions as `fcw evaluate` takes them, and its messages."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from labelled import CALIBRATION, annotated

from fcw.camera.file import write_calibration
from fcw.errors import UserError
from fcw.evaluation.detection.coco import write_coco_results
from fcw.evaluation.detection.detectors import FrameDetections
from fcw.evaluation.detection.labels import calibration_source, count_only, read_annotated, read_category
from fcw.frame import ImageSize


@pytest.fixture
def labels(tmp_path):
    """Two pictures of the clip `drive`, one box each."""
    content = {
        "images": [
            {"id": 5, "file_name": "drive/a.png", "width": 64, "height": 36, "frame": 50, "fps": 25.0},
            {"id": 3, "file_name": "drive/b.png", "width": 64, "height": 36},
        ],
        "annotations": [
            {"id": 1, "image_id": 3, "bbox": [1, 2, 10, 8], "occluded": 0},
            {"id": 2, "image_id": 5, "bbox": [3, 4, 0, 0], "ignore": True},
            {"id": 4, "image_id": 5, "bbox": [64, 4, 5, 6]},
            {"id": 3, "image_id": 5, "bbox": [3, 4, 5, 6], "ignore": True, "occluded": 2},
        ],
        "categories": [{"id": 9, "name": "vehicle"}],
    }
    path = tmp_path / "labels.json"
    path.write_text(json.dumps(content))
    for name in "ab":
        (tmp_path / "drive").mkdir(exist_ok=True)
        cv2.imwrite(str(tmp_path / "drive" / f"{name}.png"), np.zeros((36, 64, 3), np.uint8))
    return path


def test_pictures_keep_their_ids_times_and_attributes(labels):
    first, second = read_annotated(labels, labels.parent)
    assert (first.image_id, first.time_s, second.image_id, second.time_s) == (5, 2.0, 3, None)
    assert [fields["id"] for fields in first.attributes] == [3]  # neither without an area nor outside
    assert first.labelled.boxes.tolist() == [[3, 4, 5, 6]]
    assert (first.counted.tolist(), second.counted.tolist()) == ([False], [True])
    assert read_category(labels) == 9


def test_of_the_categories_of_coco_the_first_that_is_a_vehicle_is_given_back(labels):
    content = json.loads(labels.read_text())
    names = [(1, "person"), (2, "bicycle"), (9, "car"), (6, "bus")]
    content["categories"] = [{"id": number, "name": name} for number, name in names]
    labels.write_text(json.dumps(content))
    assert read_category(labels) == 9
    content["categories"].insert(0, {"id": 0, "name": "vehicles-of-my-town"})  # as Roboflow names the set
    content["annotations"][0]["category_id"] = 6
    labels.write_text(json.dumps(content))
    assert read_category(labels) == 6


def test_a_missing_picture_is_named(labels):
    (labels.parent / "drive" / "b.png").unlink()
    with pytest.raises(UserError, match=r"b\.png.*labels\.json names this picture.*--images"):
        read_annotated(labels, labels.parent)


def test_labels_without_images_are_refused(tmp_path):
    path = tmp_path / "empty.json"
    path.write_text('{"images": [], "annotations": []}')
    with pytest.raises(UserError, match=r"empty\.json: holds no image"):
        read_annotated(path, tmp_path)


def test_boxes_that_fail_a_condition_are_ignored():
    image = annotated(
        (0, 0, 9, 9),
        (20, 0, 9, 9),
        (40, 0, 9, 9),
        (60, 0, 9, 9),
        ignored=[3],
        attributes=[
            {"occluded": 0, "view": "rear"},
            {"occluded": 1, "view": "rear"},
            {"view": "rear"},
            {"occluded": 0, "view": "rear"},
        ],
    )
    (kept,) = count_only([image], ["occluded=0"])
    assert kept.counted.tolist() == [True, False, False, False]
    assert count_only([image], ["view=rear"])[0].counted.tolist() == [True, True, True, False]
    assert count_only([image], ["view=rear", "occluded=1"])[0].counted.tolist() == [False, True, False, False]


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ("occluded", r"--only occluded: expected attribute=value"),
        ("hidden=0", r"--only hidden=0: no annotation has the attribute hidden"),
        ("occluded=7", r"--only occluded=7: no vehicle that counts.*values are 0, 1"),
        ("occluded=" + "[" * 99_999, r"no vehicle that counts.*values are 0, 1"),
    ],
)
def test_conditions_that_mean_nothing_are_refused(condition, message):
    image = annotated((0, 0, 9, 9), (9, 0, 9, 9), attributes=[{"occluded": 0}, {"occluded": 1}])
    with pytest.raises(UserError, match=message):
        count_only([image], [condition])


def test_one_calibration_for_all_or_one_for_each_clip(tmp_path):
    write_calibration(CALIBRATION, tmp_path / "clip.yaml")
    image = annotated().labelled
    for path in (tmp_path / "clip.yaml", tmp_path):
        calibration_of = calibration_source(path)
        assert calibration_of(image).camera == CALIBRATION.camera
        assert calibration_of(image) is calibration_of(image)


def test_the_table_of_the_projects_own_data_is_read_too(tmp_path):
    table = tmp_path / "calibrations.txt"
    # Rows of a level camera 1.5 m high, focal length 1000 px, horizon in row 360: 360 + 1500 / d.
    table.write_text("clip 1280x720 1.5 5:660 10:510 30:410 good\n")
    assert calibration_source(table)(annotated().labelled).distance_at(435.0) == pytest.approx(20.0, rel=1e-4)
    with pytest.raises(UserError, match=r"calibrations\.txt: no calibration for the clip 'other'"):
        calibration_source(table)(annotated(clip="other").labelled)


def test_missing_calibrations_are_named(tmp_path):
    with pytest.raises(UserError, match=r"--calibration .*nowhere: no such file or folder"):
        calibration_source(tmp_path / "nowhere")
    with pytest.raises(UserError, match=r"clip\.yaml: no calibration for the clip clip"):
        calibration_source(tmp_path)(annotated().labelled)
    with pytest.raises(UserError, match="clip is unknown"):
        calibration_source(tmp_path)(annotated(clip="").labelled)


def test_a_calibration_of_another_shape_of_picture_is_refused_by_name(tmp_path):
    write_calibration(CALIBRATION.for_image_size(CALIBRATION.image_size), tmp_path / "clip.yaml")
    image = annotated().labelled
    other = replace(image, size=ImageSize(640, 480))
    with pytest.raises(UserError, match=r"clip\.yaml: .*another aspect ratio"):
        calibration_source(tmp_path)(other)


def test_coco_results_name_picture_box_and_score(tmp_path):
    found = FrameDetections(np.array([[1.5, 2, 3, 4]]), np.array([0.25]), 1.0, None)
    nothing = FrameDetections(np.zeros((0, 4)), np.zeros(0), 1.0, None)
    write_coco_results(
        [annotated(image_id=7), annotated(image_id=8)], [found, nothing], 9, tmp_path / "r.json"
    )
    assert json.loads((tmp_path / "r.json").read_text()) == [
        {"image_id": 7, "category_id": 9, "bbox": [1.5, 2.0, 3.0, 4.0], "score": 0.25}
    ]
