"""Training data: labels and calibrations are read right or refused, windows are cut where they should be."""

import json
import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.file import write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.model import CHANNEL_COUNT, Window
from fcw.detection.training.dataset import (
    LabelledImage,
    TrainingImage,
    background,
    read_labels,
    without_vehicle_in_place,
)
from fcw.detection.training.folders import load_training_set
from fcw.detection.training.samples import NO_AUGMENTATION, Augmentation, place, random_boxes, window_features
from fcw.detection.windows.statistics import vehicle_statistics
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(640, 360)
# Level, f = 500 px, 1.2 m high, horizon at row 180: 600 / d rows below it.
CAMERA = GroundPlaneCamera(0.0, 500.0, 180.0, 1.2, 319.5)
CALIBRATION = Calibration.from_camera(CAMERA, SIZE)


def coco(*boxes, ignored=(), file_name="drive/000.png", **image):
    return {
        "images": [{"id": 7, "file_name": file_name, "width": 640, "height": 360, **image}],
        "annotations": [
            {"id": i, "image_id": 7, "category_id": 1, "bbox": list(box), "ignore": i in ignored}
            for i, box in enumerate(boxes)
        ],
        "categories": [{"id": 1, "name": "vehicle"}],
    }


@pytest.fixture
def labels(tmp_path):
    def write(content):
        path = tmp_path / "labels.json"
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        return path

    return write


# What counts as a vehicle


def test_people_are_no_vehicles_and_crowds_and_two_wheelers_are_neither(labels, tmp_path):
    names = ["car", "Person_sitting", "motorcycle", "Lieferwagen", "traffic light", "truck"]
    content = coco(*[(10 * i, 0, 5, 5) for i in range(6)])
    content["categories"] = [{"id": i, "name": name} for i, name in enumerate(names)]
    for i, annotation in enumerate(content["annotations"]):
        annotation |= {"category_id": i, "iscrowd": int(names[i] == "truck")}
    (image,) = read_labels(labels(content), tmp_path)
    assert image.boxes[:, 0].tolist() == [0, 20, 30, 50]
    assert image.ignored.tolist() == [False, True, False, True]


@pytest.mark.parametrize(
    "name",
    ["traffic_cone", "barrier", "fire hydrant", "parking meter", "bench", "sign", "trafficLight-RedLeft"],
)
def test_what_stands_beside_the_road_is_no_vehicle(labels, tmp_path, name):
    content = coco((1, 2, 3, 4))
    content["categories"] = [{"id": 1, "name": name}]
    (image,) = read_labels(labels(content), tmp_path)
    assert not len(image.boxes)


# Which windows may serve as background


def test_background_is_what_neither_overlaps_a_vehicle_nor_lies_in_an_ignored_box():
    labelled = np.array([[0, 0, 10, 10], [100, 0, 100, 100]], float)
    ignored = np.array([False, True])
    boxes = np.array(
        [
            [50, 50, 10, 10],  # free
            [5, 0, 10, 10],  # IoU 50/150 = 0.33 with the vehicle
            [5.5, 0, 10, 10],  # IoU 45/155 = 0.29
            [97, 0, 4, 10],  # a quarter of it in the ignored box
            [98, 0, 4, 10],  # half of it in the ignored box, though the IoU is tiny
        ],
        float,
    )
    assert background(boxes, labelled, ignored).tolist() == [True, False, True, True, False]


def test_a_window_on_a_rear_face_is_no_background():
    # The rear face stands at the left of a body of 90 x 30, and is 0.30 of it, or a little less.
    body, none = np.array([[0, 0, 90, 30]], float), np.array([False])
    rear, far = np.array([[0, 0, 27, 30]], float), np.array([[0, 0, 26, 30]], float)
    assert background(rear, body, none).tolist() == [False]
    assert background(far, body, none).tolist() == [True]
    assert background(far, body, none, rear).tolist() == [False]
    assert without_vehicle_in_place(rear, body, none).tolist() == [True]
    assert without_vehicle_in_place(rear, body, none, rear).tolist() == [False]
    unknown = np.full((1, 4), np.nan)
    assert without_vehicle_in_place(rear, body, none, unknown).tolist() == [True]


def test_without_labels_everything_is_background():
    assert background(np.array([[0, 0, 1, 1]], float), np.zeros((0, 4)), np.zeros(0, bool)).all()


# Reading labels


def test_labels_keep_boxes_ignored_flags_and_clip(labels, tmp_path):
    (image,) = read_labels(labels(coco((1, 2, 3, 4), (5, 6, 7, 8), ignored=(1,))), tmp_path)
    assert image.path == tmp_path / "drive/000.png"
    assert image.boxes.tolist() == [[1, 2, 3, 4], [5, 6, 7, 8]]
    assert image.ignored.tolist() == [False, True]
    assert (image.clip, image.size) == ("drive", SIZE)


def test_of_a_vehicle_that_goes_on_beyond_the_picture_the_part_in_it_is_to_be_found(labels, tmp_path):
    boxes = (600, 200, 100, 80), (-0.4, 2, 3, 4), (641, 200, 100, 80), (-50, 340, 60, 40)
    (image,) = read_labels(labels(coco(*boxes)), tmp_path)
    assert image.boxes.tolist() == [[600, 200, 40, 80], [-0.4, 2, 3, 4], [0, 340, 10, 20]]


def test_rear_faces_are_read_where_there_are_any(labels, tmp_path):
    content = coco((1, 2, 30, 4), (5, 6, 7, 8))
    content["annotations"][0]["rear_box"] = [1, 2, 12, 4]
    content["annotations"][1]["rear_box"] = None
    (image,) = read_labels(labels(content), tmp_path)
    assert image.rear_boxes[0].tolist() == [1, 2, 12, 4]
    assert np.isnan(image.rear_boxes[1]).all()
    assert (image.complete, image.camera) == (True, "drive")
    content["annotations"][0]["rear_box"] = [1, 2, -12, 4]
    with pytest.raises(UserError, match=r"annotation 0 has the rear_box \[1, 2, -12, 4\]"):
        read_labels(labels(content), tmp_path)


def test_a_picture_says_that_some_of_its_vehicles_have_no_box(labels, tmp_path):
    box = (1, 2, 3, 4)
    (said,) = read_labels(labels(coco(box, complete=False)), tmp_path)
    (silent,) = read_labels(labels(coco(box)), tmp_path)
    assert not said.complete
    assert silent.complete


def test_the_clip_field_goes_before_the_folder_s_name(labels, tmp_path):
    (image,) = read_labels(labels(coco((1, 2, 3, 4), clip="evening")), tmp_path)
    assert image.clip == "evening"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{", "not COCO labels"),
        ("[]", "not COCO labels"),
        ({"images": []}, "annotations"),
        (coco((1, 2, 3)), "not COCO labels"),
        (coco((1, 2, 0, 4)), r"annotation 0 has the box \[1, 2, 0, 4\].*positive"),
        (coco((1, 2, math.inf, 4)), "annotation 0 has the box"),
        (
            coco() | {"annotations": [{"id": 3, "image_id": 9, "bbox": [1, 2, 3, 4]}]},
            "annotation 3 names image 9",
        ),
    ],
)
def test_wrong_labels_are_refused_by_name(labels, tmp_path, content, message):
    with pytest.raises(UserError, match=f"labels.json.*{message}"):
        read_labels(labels(content), tmp_path)


def test_images_that_share_an_id_or_a_file_are_refused_as_boxes_of_one_would_be_lost(labels, tmp_path):
    content = coco((1, 2, 3, 4))
    (first,) = content["images"]
    content["images"] = [first, first | {"file_name": "other/000.png"}]
    with pytest.raises(
        UserError, match=r"labels\.json: 2 images have the id 7.*number the images of one file"
    ):
        read_labels(labels(content), tmp_path)
    content["images"] = [first, first | {"id": 8}]
    with pytest.raises(UserError, match=r"2 images have the file_name drive/000\.png.*to one image"):
        read_labels(labels(content), tmp_path)


def test_an_ignored_box_without_area_is_dropped(labels, tmp_path):
    (image,) = read_labels(labels(coco((5, 5, 0, 0), (1, 2, 3, 4), ignored=(0,))), tmp_path)
    assert image.boxes.tolist() == [[1, 2, 3, 4]]


def test_a_missing_file_of_labels_is_named(tmp_path):
    with pytest.raises(UserError, match=r"absent\.json: cannot read the labels"):
        read_labels(tmp_path / "absent.json", tmp_path)


def test_a_picture_that_is_missing_or_of_another_size_is_refused(labels, tmp_path):
    (image,) = read_labels(labels(coco((1, 2, 3, 4))), tmp_path)
    with pytest.raises(UserError, match=r"000\.png: cannot read this picture"):
        image.read()
    image.path.parent.mkdir()
    cv2.imwrite(str(image.path), np.zeros((180, 320, 3), np.uint8))
    with pytest.raises(UserError, match="is 320x180, but the labels give it as 640x360"):
        image.read()


# The two layouts of a training folder


def test_own_layout_with_one_calibration_for_all(labels, tmp_path):
    labels(coco((300, 200, 40, 30)))
    write_calibration(CALIBRATION, tmp_path / "calibration.yaml")
    (image,) = load_training_set(tmp_path)
    assert image.labelled.path == tmp_path / "images/drive/000.png"
    assert image.calibration.horizon_row_px == pytest.approx(180.0)


def test_own_layout_with_a_calibration_for_each_clip_rescaled_to_the_pictures(labels, tmp_path):
    labels(coco((300, 200, 40, 30)))
    (tmp_path / "calibration").mkdir()
    double = Calibration.from_camera(GroundPlaneCamera(0.0, 1000.0, 360.5, 1.2, 639.5), ImageSize(1280, 720))
    write_calibration(double, tmp_path / "calibration/drive.yaml")
    (image,) = load_training_set(tmp_path)
    # Twice the size: centres of pixels map as 2 v + 1/2.
    assert image.calibration.horizon_row_px == pytest.approx(180.0)
    square = Calibration.from_camera(CAMERA, ImageSize(640, 640))
    write_calibration(square, tmp_path / "calibration/drive.yaml")
    with pytest.raises(UserError, match=r"images/drive/000\.png: .*for pictures of 640x640"):
        load_training_set(tmp_path)


def test_a_folder_without_labels_says_what_was_expected(tmp_path):
    with pytest.raises(UserError, match=r"labels\.json \(COCO\), images/ and calibration\.yaml"):
        load_training_set(tmp_path)


def test_labels_in_which_no_vehicle_counts_are_refused(labels, tmp_path):
    labels(coco((1, 2, 3, 4), ignored=(0,)))
    write_calibration(CALIBRATION, tmp_path / "calibration.yaml")
    with pytest.raises(UserError, match="no vehicle that counts"):
        load_training_set(tmp_path)


def test_several_folders_are_one_set_each_with_its_own_calibration(tmp_path):
    folders = []
    for name, horizon_row_px, ignored in (("a", 180.0, ()), ("b", 150.0, (0,))):
        folders.append(tmp_path / name)
        folders[-1].mkdir()
        content = coco((300, 200, 40, 30), ignored=ignored)
        (folders[-1] / "labels.json").write_text(json.dumps(content))
        camera = replace(CAMERA, principal_row_px=horizon_row_px)
        write_calibration(Calibration.from_camera(camera, SIZE), folders[-1] / "calibration.yaml")
    images = load_training_set(*folders)
    assert [image.labelled.path for image in images] == [f / "images/drive/000.png" for f in folders]
    assert [image.calibration.horizon_row_px for image in images] == pytest.approx([180.0, 150.0])
    # In the second one no vehicle counts, which is no fault beside the first.
    with pytest.raises(UserError, match="no vehicle that counts"):
        load_training_set(folders[1])


# Statistics of vehicles


def vehicles(*boxes, ignored=None):
    flags = np.zeros(len(boxes), bool) if ignored is None else np.array(ignored, bool)
    no_rears = np.full((len(boxes), 4), np.nan)
    labelled = LabelledImage(Path("none.png"), "drive", SIZE, np.array(boxes, float), flags, no_rears)
    return TrainingImage(labelled, CALIBRATION)


def standing_at(distance_m, width_m, height_m):
    box = CAMERA.ground_box(distance_m, 0.0, width_m, height_m)
    return box.x, box.y, box.w, box.h


def test_statistics_give_back_the_vehicles_sizes_and_aspect_ratios():
    near = [standing_at(6.0, 2.0, 1.25)] * 10
    far = [standing_at(40.0, 1.8, 1.5)] * 10
    statistics = vehicle_statistics([vehicles(*near), vehicles(*far)])
    assert statistics.aspect_distances_m == (6.0, 40.0)
    assert statistics.aspect_ratios == pytest.approx((1.6, 1.2))
    sizes = math.sqrt(2.0 * 1.25), math.sqrt(1.8 * 1.5)
    assert sizes[0] <= statistics.size_median_m <= sizes[1]
    assert statistics.size_low_m < min(sizes)
    assert statistics.size_high_m > max(sizes)


def test_ignored_vehicles_and_those_above_the_horizon_do_not_count():
    good = standing_at(10.0, 1.8, 1.5)
    statistics = vehicle_statistics([vehicles(good, (0, 300, 300, 50), (0, 0, 50, 50), ignored=[0, 1, 0])])
    assert statistics.size_median_m == pytest.approx(math.sqrt(1.8 * 1.5))


def test_statistics_of_nothing_are_refused():
    with pytest.raises(ValueError, match="below the horizon"):
        vehicle_statistics([vehicles((0, 0, 50, 50))])


def test_training_rejects_background_and_vehicles_out_of_place_but_nothing_that_may_be_in_place():
    labels = np.array([[100, 100, 60, 40], [300, 100, 20, 10], [400, 100, 300, 150]], float)
    ignored = np.array([False, True, True])
    rejected = {
        "the vehicle itself": ([100, 100, 60, 40], False),
        "a little beside it": ([110, 105, 60, 40], False),
        "half of it": ([130, 100, 60, 40], True),
        "around it, twice as large": ([70, 80, 120, 80], True),
        "mere road": ([0, 300, 60, 40], True),
        "around a far ignored vehicle": ([295, 97, 30, 16], True),
        "that far one itself": ([299, 99, 22, 12], False),
        "within a large ignored side view": ([450, 150, 60, 40], False),
    }
    boxes = np.array([box for box, _ in rejected.values()], float)
    found = without_vehicle_in_place(boxes, labels, ignored).tolist()
    assert dict(zip(rejected, found, strict=True)) == {name: wanted for name, (_, wanted) in rejected.items()}


# Cutting windows


def on_box(picture, box, augmentation, seed, mirrored):
    generator = np.random.default_rng(seed)
    placement = place(box, augmentation, generator)
    return window_features(picture, placement, Window(), augmentation, generator, mirrored)


def lightness(features):
    return features.reshape(CHANNEL_COUNT, 16, 16)[0].astype(float)


@pytest.mark.parametrize("size_px", [22, 40, 75, 260])
def test_a_vehicle_stands_in_its_window_at_its_size_centred_above_the_bottom_margin(size_px):
    # A square vehicle of light on black. Its edges are those of pixels, half a pixel before their middles.
    picture = np.zeros((720, 1280, 3), np.uint8)
    picture[500 - size_px : 500, 600 : 600 + size_px] = 255
    box = np.array([600 - 0.5, 500 - 0.5 - size_px, size_px, size_px])
    seen = lightness(on_box(picture, box, NO_AUGMENTATION, 0, mirrored=False))
    # 40 of the window's 64 px both ways: columns 12 to 52, rows 12 to 52, which is cells 3 to 13.
    inside = np.zeros((16, 16), bool)
    inside[3:13, 3:13] = True
    inner, outer = inside.copy(), ~inside
    inner[[3, 12], :] = False
    inner[:, [3, 12]] = False
    outer[[2, 13], :] = False
    outer[:, [2, 13]] = False
    assert seen[inner].min() > 0.9 * seen.max()
    assert seen[outer].max() < 0.1 * seen.max()


def test_a_mirrored_window_is_the_window_with_left_and_right_exchanged():
    picture = np.random.default_rng(1).integers(0, 256, (360, 640, 3), np.uint8)
    box = np.array([300.0, 150.0, 60.0, 40.0])
    plain, mirrored = (lightness(on_box(picture, box, Augmentation(), 2, mirror)) for mirror in (False, True))
    assert np.abs(mirrored[:, ::-1] - plain).max() <= 1


def test_windows_reach_beyond_the_picture():
    picture = np.full((100, 100, 3), 200, np.uint8)
    box = np.array([-20.0, 60.0, 60.0, 60.0])
    seen = lightness(on_box(picture, box, NO_AUGMENTATION, 0, False))
    assert np.ptp(seen) <= 1


@pytest.mark.parametrize("mirrored", [False, True])
def test_offsets_say_where_in_a_displaced_window_the_vehicle_is_seen(mirrored):
    # A bright box on black, in windows shifted, scaled and stretched at random.
    picture = np.zeros((720, 1280, 3), np.uint8)
    picture[420:500, 600:690] = 255
    box = np.array([599.5, 419.5, 90, 80])
    window, generator = Window(), np.random.default_rng(3)
    displacement = replace(NO_AUGMENTATION, shift=0.1, scale=0.15, stretch=0.12)
    for _ in range(20):
        placement = place(box, displacement, generator)
        features = window_features(picture, placement, window, NO_AUGMENTATION, generator, mirrored)
        seen = lightness(features) / lightness(features).max()
        dx, log_w, log_h = placement.offsets(box, mirrored)
        size = window.vehicle_size_px
        w, h = size * np.exp(log_w), size * np.exp(log_h)
        # Extents by area, place by centre of gravity, in px of the window; a cell is 4 px.
        bottom = window.vehicle_bottom_px + (box[1] + box[3] - placement.bottom_px) / placement.size_px * size
        assert 4 * seen.sum(axis=1).max() == pytest.approx(w, abs=2)
        assert 4 * seen.sum(axis=0).max() == pytest.approx(h, abs=2)
        columns = 4 * np.arange(16) + 2
        middle, centre = seen.sum(axis=0) @ columns / seen.sum(), seen.sum(axis=1) @ columns / seen.sum()
        assert middle == pytest.approx(32 + dx * size, abs=1)
        assert centre == pytest.approx(bottom - h / 2, abs=1)


def test_random_boxes_stand_on_the_road_with_sizes_in_the_range():
    boxes = random_boxes(500, 180.0, 1.2, SIZE, (1.0, 4.0), 1.5, np.random.default_rng(0))
    below_px = boxes[:, 1] + boxes[:, 3] - 180.0
    assert np.all((below_px > 0) & (boxes[:, 1] + boxes[:, 3] <= 360))
    sizes_m = np.sqrt(boxes[:, 2] * boxes[:, 3]) * 1.2 / below_px
    assert np.all((sizes_m >= 1.0 - 1e-9) & (sizes_m <= 4.0 + 1e-9))
    assert boxes[:, 2] / boxes[:, 3] == pytest.approx(np.full(500, 1.5))
