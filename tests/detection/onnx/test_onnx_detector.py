"""Detectors plugged in as ONNX files: each layout's boxes, classes, and what is refused.

The nets are made here and put out what a test writes into them, after the layouts' own descriptions.
"""

import builtins
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from onnx import TensorProto
from running.tiny_nets import write_net, write_swelling_net

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.detection.onnx.detector import OnnxDetector, OnnxModel
from fcw.detection.onnx.yolo import Layout, Letterbox, recognise
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
SHOWN = ImageSize(320, 192)  # the picture in it is 320x180, 6 grey rows above and below
STRIDES = (8, 16, 32)
CELLS = sum((SHOWN.width // s) * (SHOWN.height // s) for s in STRIDES)
CALIBRATION = Calibration.from_camera(GroundPlaneCamera(0.0, 1000.0, 360.0, 1.5, 640.0), SIZE)
IMAGE = np.zeros((SIZE.height, SIZE.width, 3), np.uint8)
COCO_CAR, COCO_PERSON, COCO_TRUCK = 2, 0, 7
# By that calibration 1.8 m wide on the road 10 m ahead, 20 m ahead to the left, and 40 m ahead.
NEAR, ASIDE, FAR = Box(550, 390, 180, 120), Box(400, 360, 90, 75), Box(620, 367.5, 45, 30)


@dataclass(frozen=True)
class Put:
    """A box that a net shall put out."""

    box: Box
    score: float
    number: int


def in_net(box: Box, layout: Layout) -> tuple[float, float, float, float]:
    """Left, top, width, height of a box of the picture in what the net is shown: a quarter of the size."""
    top = 0 if "YOLOX" in layout else 6
    return (box.x + 0.5) / 4, (box.y + 0.5) / 4 + top, box.w / 4, box.h / 4


def output_of(layout: Layout, puts: Sequence[Put], classes: int = 80) -> np.ndarray:
    """The output in which a net of this layout says that these boxes are there, and no others."""
    if layout is Layout.END_TO_END:
        rows = np.zeros((300, 6), np.float32)
        for row, put in zip(rows, puts, strict=False):
            x, y, w, h = in_net(put.box, layout)
            row[:] = x, y, x + w, y + h, put.score, put.number
        return rows[None]
    objectness = 0 if layout is Layout.YOLOV8 else 1
    rows = np.zeros((3 * CELLS if layout is Layout.YOLOV5 else CELLS, 4 + objectness + classes), np.float32)
    if layout in (Layout.YOLOX_DECODED, Layout.YOLOV6):
        rows[:, 0] = np.linspace(0, SHOWN.width - 4, len(rows))
    sureness = 1.0 if layout is Layout.YOLOV6 else 0.8
    if layout is Layout.YOLOV6:
        rows[:, 4] = sureness
    for number, put in enumerate(puts):
        x, y, w, h = in_net(put.box, layout)
        middle_x, middle_y = x + w / 2, y + h / 2
        if layout is Layout.YOLOX:  # the cell of 16 px that the middle is in, after all cells of 8 px
            column, line = int(middle_x // 16), int(middle_y // 16)
            index = (SHOWN.width // 8) * (SHOWN.height // 8) + line * (SHOWN.width // 16) + column
            rows[index, :4] = middle_x / 16 - column, middle_y / 16 - line, math.log(w / 16), math.log(h / 16)
        else:
            index = 7 + 50 * number
            rows[index, :4] = middle_x, middle_y, w, h
        if objectness:
            rows[index, 4] = sureness
        rows[index, 4 + objectness + put.number] = put.score / (sureness if objectness else 1.0)
    return rows.T[None] if layout is Layout.YOLOV8 else rows[None]


def net(folder: Path, layout: Layout, puts: Sequence[Put], **metadata: str) -> Path:
    return write_net(folder / "tiny.onnx", output_of(layout, puts), (SHOWN.height, SHOWN.width), metadata)


def detect(path: Path, classes: Sequence[str] = (), score_threshold: float | None = None):
    return OnnxDetector(OnnxModel.load(path, classes), CALIBRATION, score_threshold).detect(IMAGE)


def check(found: Sequence[Detection], expected: Sequence[Put]) -> None:
    assert [d.score for d in found] == pytest.approx([put.score for put in expected], abs=1e-5)
    for detection, put in zip(found, expected, strict=True):
        box = detection.box
        assert (box.x, box.y, box.w, box.h) == pytest.approx(
            (put.box.x, put.box.y, put.box.w, put.box.h), abs=1e-3
        )


@pytest.mark.parametrize("layout", list(Layout))
def test_each_layout_gives_its_boxes_back_in_the_picture_best_first(layout: Layout, tmp_path: Path) -> None:
    far, near, aside = Put(FAR, 0.5, COCO_CAR), Put(NEAR, 0.7, COCO_TRUCK), Put(ASIDE, 0.6, COCO_CAR)
    path = net(tmp_path, layout, [far, near, aside])
    assert OnnxModel.load(path).layout is layout
    check(detect(path), [near, aside, far])


@pytest.mark.parametrize("layout", list(Layout))
def test_what_is_no_vehicle_or_too_unsure_is_left_out(layout: Layout, tmp_path: Path) -> None:
    person, unsure, car = Put(NEAR, 0.8, COCO_PERSON), Put(ASIDE, 0.2, COCO_CAR), Put(FAR, 0.5, COCO_CAR)
    path = net(tmp_path, layout, [person, unsure, car])
    check(detect(path), [car])
    check(detect(path, score_threshold=-math.inf), [car, unsure])


@pytest.mark.parametrize("layout", list(Layout))
def test_a_net_that_puts_out_no_numbers_is_not_one_that_finds_nothing(layout: Layout, tmp_path: Path) -> None:
    broken = np.full_like(output_of(layout, []), math.nan)
    path = net(tmp_path, layout, [Put(NEAR, 0.8, COCO_CAR)])
    model = replace(OnnxModel.load(path), path=tmp_path / "mine.onnx", session=cast(Any, _Puts(broken)))
    with pytest.raises(UserError, match=r"^detector 'onnx:mine\.onnx': score nan; expected a finite number$"):
        OnnxDetector(model, CALIBRATION).detect(IMAGE)


def test_a_sure_box_without_edges_is_a_fault_of_the_net(tmp_path: Path) -> None:
    path = net(tmp_path, Layout.END_TO_END, [Put(Box(math.nan, 390, 180, 120), 0.8, COCO_CAR)])
    with pytest.raises(UserError, match="': box edge nan; expected a finite number"):
        detect(path)
    unsure = Put(Box(math.inf, 390, 180, 120), 0.1, COCO_CAR)
    assert detect(net(tmp_path, Layout.YOLOV8, [unsure])) == ()


class _Puts:
    """A session of onnxruntime that puts out an array, whatever it is shown."""

    def __init__(self, output: np.ndarray) -> None:
        self._output = output

    def run(self, *_: Any) -> list[np.ndarray]:
        return [self._output]


@given(
    layout=st.sampled_from([Layout.YOLOV5, Layout.YOLOV8, Layout.YOLOX]),
    rows=st.integers(2, 40),
    columns=st.integers(2, 40),
    classes=st.integers(1, 100),
    strides=st.sampled_from([(8, 16, 32), (8, 16, 32, 64), (4, 8, 16, 32)]),
)
def test_layouts_are_told_apart_at_any_size_and_number_of_classes(layout, rows, columns, classes, strides):
    shown = ImageSize(64 * columns, 64 * rows)
    cells = sum((shown.width // s) * (shown.height // s) for s in strides)
    shapes = {
        Layout.YOLOV5: (1, 3 * cells, 5 + classes),
        Layout.YOLOV8: (1, 4 + classes, cells),
        Layout.YOLOX: (1, cells, 5 + classes),
    }
    assert recognise(np.zeros(shapes[layout], np.float32), shown) is layout


@pytest.mark.parametrize("layout", [Layout.YOLOV6, Layout.YOLOV8, Layout.YOLOX])
@pytest.mark.parametrize("size", [ImageSize(1280, 720), ImageSize(641, 359), ImageSize(480, 800)])
def test_what_is_painted_in_the_picture_comes_back_from_where_the_net_sees_it(layout, size):
    shown = ImageSize(416, 416)
    letterbox = Letterbox(size, shown, layout)
    image = np.zeros((size.height, size.width, 3), np.uint8)
    x, y, w, h = 100, 200, 150, 90
    image[y : y + h, x : x + w] = 255
    seen = letterbox.show(image)
    bright = seen[0, 0] > 0.7 * seen.max()
    rows, columns = np.flatnonzero(bright.any(axis=1)), np.flatnonzero(bright.any(axis=0))
    in_net_px = [columns[0], rows[0], np.ptp(columns) + 1, np.ptp(rows) + 1]
    a_net_pixel = max(size.width, size.height) / 416
    assert letterbox.in_picture(np.array([in_net_px], float))[0] == pytest.approx(
        (x - 0.5, y - 0.5, w, h), abs=1.5 * a_net_pixel
    )


@pytest.mark.parametrize(
    ("layout", "blue_channel", "full", "corner"),
    [(Layout.YOLOV8, 2, 1.0, 114 / 255), (Layout.YOLOV5, 2, 1.0, 114 / 255), (Layout.YOLOX, 0, 255.0, 255.0)],
)
def test_colours_and_padding_are_those_the_family_trains_with(layout, blue_channel, full, corner):
    image = np.zeros((100, 200, 3), np.uint8)
    image[:, :, 0] = 255  # blue, as OpenCV orders channels
    seen = Letterbox(ImageSize(200, 100), ImageSize(64, 64), layout).show(image)
    assert seen.shape == (1, 3, 64, 64)
    assert seen[0, :, 24, 32] == pytest.approx([full if c == blue_channel else 0 for c in range(3)])
    assert seen[0, blue_channel, 0, 0] == pytest.approx(corner)
    assert seen[0, blue_channel, 63, 0] == pytest.approx(114 / (1 if full == 255 else 255))


def test_boxes_that_cannot_stand_on_the_road_are_left_out(tmp_path: Path) -> None:
    car = Put(NEAR, 0.5, COCO_CAR)
    in_the_sky = Put(Box(500, 100, 180, 120), 0.9, COCO_CAR)
    too_wide_for_its_row = Put(Box(300, 300, 500, 120), 0.9, COCO_CAR)  # 10 m wide, 20 m ahead
    # 0.15 m wide, 7 m ahead; inside the car's box, which it would hide if it were suppressed first
    too_narrow = Put(Box(600, 554, 20, 20), 0.9, COCO_CAR)
    check(detect(net(tmp_path, Layout.YOLOV8, [in_the_sky, too_wide_for_its_row, too_narrow, car])), [car])


def test_one_vehicle_that_the_net_calls_both_car_and_truck_is_one(tmp_path: Path) -> None:
    car, truck = Put(NEAR, 0.6, COCO_CAR), Put(Box(552, 391, 180, 121), 0.5, COCO_TRUCK)
    check(detect(net(tmp_path, Layout.YOLOV8, [car, truck])), [car])


def test_classes_are_chosen_by_name_or_number(tmp_path: Path) -> None:
    lorry, tram = Put(NEAR, 0.6, 1), Put(ASIDE, 0.5, 0)
    output = output_of(Layout.YOLOV8, [lorry, tram], classes=2)
    names = {"names": "{0: 'tram', 1: 'Lorry'}"}
    path = write_net(tmp_path / "own.onnx", output, (SHOWN.height, SHOWN.width), names)
    check(detect(path, ["lorry"]), [lorry])
    check(detect(path, ["0"]), [tram])
    check(detect(path, ["1", "Tram"]), [lorry, tram])
    with pytest.raises(
        UserError, match=r"own\.onnx.*which of its 2 classes.*tram, lorry.*--detector-classes"
    ):
        OnnxModel.load(path)
    with pytest.raises(UserError, match=r"--detector-classes bus: .*tram, lorry, or a number from 0 to 1"):
        OnnxModel.load(path, ["bus"])
    with pytest.raises(UserError, match="--detector-classes 2: "):
        OnnxModel.load(path, ["2"])


def test_names_in_the_metadata_go_before_the_numbers_of_coco(tmp_path: Path) -> None:
    names = ["car" if number == 5 else f"thing {number}" for number in range(80)]
    path = net(tmp_path, Layout.YOLOV5, [Put(NEAR, 0.6, 5), Put(ASIDE, 0.5, COCO_CAR)], names=str(names))
    check(detect(path), [Put(NEAR, 0.6, 5)])


def test_a_model_of_one_class_needs_no_names(tmp_path: Path) -> None:
    path = tmp_path / "one.onnx"
    write_net(path, output_of(Layout.YOLOX, [Put(NEAR, 0.6, 0)], classes=1), (SHOWN.height, SHOWN.width))
    check(detect(path), [Put(NEAR, 0.6, 0)])


def test_a_model_for_any_size_is_shown_what_it_was_trained_on(tmp_path: Path) -> None:
    path = write_net(
        tmp_path / "dynamic.onnx",
        output_of(Layout.YOLOV8, [Put(NEAR, 0.6, COCO_CAR)]),
        ("height", "width"),
        {"imgsz": "[192, 320]"},
    )
    assert OnnxModel.load(path).shown == SHOWN
    check(detect(path), [Put(NEAR, 0.6, COCO_CAR)])


def test_models_of_half_precision_and_of_any_batch_are_taken(tmp_path: Path) -> None:
    output, size = output_of(Layout.YOLOV8, [Put(NEAR, 0.6, COCO_CAR)]), (SHOWN.height, SHOWN.width)
    half = write_net(tmp_path / "half.onnx", output, size, batch="batch", takes=TensorProto.FLOAT16)
    check(detect(half), [Put(NEAR, 0.6, COCO_CAR)])
    whole = write_net(tmp_path / "whole.onnx", output, size, takes=TensorProto.UINT8)
    with pytest.raises(UserError, match=r"whole\.onnx: takes images: tensor\(uint8\) 1x3x192x320; expected"):
        OnnxModel.load(whole)
    many = write_net(tmp_path / "many.onnx", output, size, batch=8)
    with pytest.raises(UserError, match=r"8x3x192x320; expected one picture"):
        OnnxModel.load(many)


@given(
    st.lists(
        st.tuples(st.floats(-50, 1300), st.floats(200, 760), st.floats(5, 900), st.floats(5, 500)), max_size=9
    )
)
def test_detections_are_in_the_picture_and_sorted(tmp_path_factory, boxes):
    puts = [Put(Box(*box), 0.3 + 0.07 * i, COCO_CAR) for i, box in enumerate(boxes)]
    found = detect(net(tmp_path_factory.mktemp("nets"), Layout.YOLOV8, puts))
    scores = [d.score for d in found]
    assert scores == sorted(scores, reverse=True)
    for detection in found:
        box = detection.box
        assert -0.5 <= box.x < box.right <= SIZE.width - 0.5
        assert -0.5 <= box.y < box.bottom <= SIZE.height - 0.5


def test_a_picture_of_another_size_than_the_calibration_is_a_fault(tmp_path: Path) -> None:
    detector = OnnxDetector(OnnxModel.load(net(tmp_path, Layout.YOLOV8, [])), CALIBRATION)
    with pytest.raises(ValueError, match="1280x720"):
        detector.detect(np.zeros((360, 640, 3), np.uint8))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"nowhere\.onnx: no such file"):
        OnnxModel.load(tmp_path / "nowhere.onnx")


def test_a_file_that_is_no_model_is_named(tmp_path: Path) -> None:
    path = tmp_path / "text.onnx"
    path.write_text("not a net")
    with pytest.raises(UserError, match=r"text\.onnx: onnxruntime cannot load it"):
        OnnxModel.load(path)


@pytest.mark.parametrize("shape", [(1, 1000), (1, 77, 13), (1, 3, 10, 10)])
def test_an_unknown_layout_is_named_with_what_is_expected(shape, tmp_path: Path) -> None:
    path = write_net(tmp_path / "other.onnx", np.zeros(shape, np.float32), (SHOWN.height, SHOWN.width))
    with pytest.raises(UserError) as error:
        OnnxModel.load(path)
    message = str(error.value)
    assert f"other.onnx: its output has the shape {'x'.join(map(str, shape))}" in message
    assert f"1x{3 * CELLS}x(5 + classes) as YOLOv5" in message
    assert f"1x(4 + classes)x{CELLS} as YOLOv8" in message
    assert f"1x{CELLS}x(5 + classes) as YOLOX" in message


def test_two_scores_in_place_of_a_score_and_a_class_are_not_the_end_to_end_layout(tmp_path: Path) -> None:
    # Middle x and y, width and height as parts of the picture, and scores of two classes: RT-DETR.
    rows = np.random.default_rng(0).uniform(0.0, 0.9, (1, 300, 6)).astype(np.float32)
    path = write_net(tmp_path / "detr.onnx", rows, (SHOWN.height, SHOWN.width), {"names": "['car', 'truck']"})
    with pytest.raises(UserError, match=r"detr\.onnx: its output has the shape 1x300x6, a layout that is"):
        OnnxModel.load(path)


def test_a_model_for_another_task_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="for the task segment; expected one for the task detect"):
        OnnxModel.load(net(tmp_path, Layout.YOLOV8, [], task="segment"))


def test_a_model_whose_names_do_not_fit_its_output_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="names 1 classes, but its output has 80"):
        OnnxModel.load(net(tmp_path, Layout.YOLOV8, [], names="{0: 'car'}"))
    with pytest.raises(UserError, match="the entry `names` of its metadata"):
        OnnxModel.load(net(tmp_path, Layout.YOLOV8, [], names="car, truck"))


def test_without_onnxruntime_the_message_says_how_to_install_it(tmp_path: Path, monkeypatch) -> None:
    path, real_import = net(tmp_path, Layout.YOLOV8, []), builtins.__import__

    def without(name, *rest):
        if name == "onnxruntime":
            raise ImportError(name)
        return real_import(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(UserError, match=r"pip install 'fcw\[onnx\]'"):
        OnnxModel.load(path)


def test_a_net_that_puts_out_more_than_any_of_the_family_is_refused(tmp_path: Path) -> None:
    path = write_swelling_net(tmp_path / "wide.onnx", (1, 84, 400_000), 64)
    with pytest.raises(
        UserError, match="puts out 1x84x400000 numbers for a picture of 64x64; expected at most"
    ):
        OnnxModel.load(path, ("1",))


@pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded on Linux")
def test_a_net_that_asks_for_all_memory_is_refused_and_the_limit_is_gone_afterwards(tmp_path: Path) -> None:
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    path = write_swelling_net(tmp_path / "huge.onnx", (1, 84, 20_000_000), 64)  # 6.7 GB
    with pytest.raises(UserError, match=r"cannot run it on a picture of 64x64 \([^\n]*memory") as refused:
        OnnxModel.load(path)
    assert "\n" not in str(refused.value)
    assert resource.getrlimit(resource.RLIMIT_AS) == before
    OnnxModel.load(net(tmp_path, Layout.YOLOV8, []))


def test_of_more_vehicles_than_a_road_has_the_best_are_looked_at(tmp_path: Path) -> None:
    rows = np.zeros((1, 20_000, 6), np.float32)
    x, y, w, h = in_net(NEAR, Layout.END_TO_END)
    rows[0, :] = x, y, x + w, y + h, 0.5, COCO_CAR
    x, y, w, h = in_net(FAR, Layout.END_TO_END)
    rows[0, -1] = x, y, x + w, y + h, 0.9, COCO_CAR
    path = write_net(tmp_path / "many.onnx", rows, (SHOWN.height, SHOWN.width))
    check(detect(path), [Put(FAR, 0.9, COCO_CAR), Put(NEAR, 0.5, COCO_CAR)])
