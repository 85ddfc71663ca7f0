"""A glance at the picture and its bands: its convolutions, its geometry, and what it has to say."""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.net.bands import SHOWN, bands_of, whole
from fcw.detection.net.byte_weights import ByteWeights
from fcw.detection.net.glance import (
    CELL_PX,
    CUT_PX,
    LOWEST,
    SHAPES,
    STRIDES,
    Glance,
    Glanced,
    GlanceMemory,
    GlanceNet,
)
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel
from fcw.detection.net.onnx_layers import Convolution
from fcw.detection.net.planes import (
    BEYOND,
    PlaneConvolution,
    convolve,
    plane_convolution,
    put_picture,
    put_planes,
)
from fcw.detection.net.windows import Pyramid
from fcw.frame import ImageSize
from fcw.kernels.aligned import Scratch


@pytest.fixture(scope="module")
def model() -> NetModel:
    return NetModel.load(SHIPPED_NET_PATH)


def convolved(planes: np.ndarray, convolution: Convolution) -> np.ndarray:
    """By the definition."""
    padded = np.pad(planes, ((0, 0), (1, 1), (1, 1)))
    windows = np.lib.stride_tricks.sliding_window_view(padded, (3, 3), axis=(1, 2))
    windows = windows[:, :: convolution.stride, :: convolution.stride]
    return np.einsum("cyxij,ocij->oyx", windows, convolution.weights) + convolution.biases[:, None, None]


def in_bytes(planes: np.ndarray) -> np.ndarray:
    """What is left of planes, of which nothing is below zero, in whole steps: 255 are the largest number."""
    step = max(planes.max(), 1e-30) / 255
    return np.floor(planes / step + 0.5) * step


def with_bytes(convolution: Convolution) -> Convolution:
    """With what is left of its weights in whole steps, 127 of which are an output's largest."""
    steps = np.maximum(np.abs(convolution.weights).max(axis=(1, 2, 3), keepdims=True), 1e-30) / 127
    return replace(convolution, weights=np.rint(convolution.weights / steps) * steps)


@numba.njit
def convolved_planes(
    planes: np.ndarray,
    convolution: PlaneConvolution,
    least: float,
    words: np.ndarray,
    sums: np.ndarray,
    outputs: np.ndarray,
) -> None:
    step, zero = put_planes(planes, convolution, words, sums)
    convolve(convolution, step, zero, np.float32(least), words, sums, outputs)


@numba.njit
def convolved_picture(
    picture: np.ndarray,
    convolution: PlaneConvolution,
    words: np.ndarray,
    sums: np.ndarray,
    outputs: np.ndarray,
) -> None:
    step, zero = put_picture(picture, convolution, 8.0, words, sums)
    convolve(convolution, step, zero, np.float32(LOWEST), words, sums, outputs)


def used_memory(convolution: PlaneConvolution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Words, sums and outputs in which another computation left something."""
    words, sums = Scratch(np.int32).of(convolution.word_count), Scratch(np.int32).of(convolution.sum_count)
    words[:], sums[:] = -1, -1
    count, rows, columns = convolution.inputs
    outputs = Scratch().of(max(convolution.output_count, count * rows * (columns + BEYOND)))
    outputs[:] = np.nan
    return words, sums, outputs


def with_zeros_beyond(planes: np.ndarray) -> np.ndarray:
    return np.pad(planes, ((0, 0), (0, 0), (0, BEYOND))).reshape(-1)


def of_size(outputs: np.ndarray, convolution: PlaneConvolution) -> np.ndarray:
    """Outputs without what lies beyond, all of which is zero."""
    count, rows, columns = convolution.outputs
    planes = outputs[: convolution.output_count].reshape(count, rows, -1)
    assert not planes[:, :, columns:].any()
    return planes[:, :, :columns]


@given(
    st.integers(1, 9),
    st.sampled_from([1, 3, 8, 11]),
    st.sampled_from([1, 2]),
    st.booleans(),
    st.integers(1, 18),
    st.integers(1, 60),
    st.integers(0, 1000),
)
def test_planes_are_convolved_as_by_the_definition(
    inputs, outputs, stride, by_row_pairs, height, width, seed
):
    random, (height, width) = np.random.default_rng(seed), (height * stride, width * stride)
    planes = np.maximum(random.normal(size=(inputs, height, width)), 0).astype(np.float32)
    convolution = Convolution(
        random.normal(size=(outputs, inputs, 3, 3)).astype(np.float32),
        random.normal(size=outputs).astype(np.float32),
        stride,
    )
    expected = convolved(in_bytes(planes), with_bytes(convolution))
    layer = plane_convolution(ByteWeights(convolution, by_row_pairs), height, width)
    words, sums, memory = used_memory(layer)
    convolved_planes(with_zeros_beyond(planes), layer, 0.0, words, sums, memory)
    # A number in the middle of two steps may go to either.
    step, largest = float(planes.max()) / 255, float(np.abs(convolution.weights).max())
    found = of_size(memory, layer)
    assert found == pytest.approx(np.maximum(expected, 0.0), abs=1e-4 + step * largest)
    shown = with_zeros_beyond(planes)
    memory[: len(shown)] = shown
    convolved_planes(memory, layer, LOWEST, words, sums, memory)  # in its own place
    found = of_size(memory, layer)
    assert found == pytest.approx(expected, abs=1e-4 + step * largest)
    # Half a step of each number, and of each weight, is what bytes may cost.
    lost = 9 * inputs * (step / 2 * largest + largest / 127 * 255 / 2 * step)
    assert found == pytest.approx(convolved(planes, convolution), abs=1.01 * lost + 1e-4)


@given(st.integers(1, 12), st.integers(1, 40), st.integers(0, 255), st.integers(0, 1000))
def test_a_picture_is_convolved_without_its_brightness_and_over_its_contrast(
    half_height, half_width, least, seed
):
    random = np.random.default_rng(seed)
    picture = random.integers(least, 256, (2 * half_height, 2 * half_width, 3)).astype(np.uint8)
    convolution = Convolution(
        random.normal(size=(11, 3, 3, 3)).astype(np.float32), random.normal(size=11).astype(np.float32), 2
    )
    layer = plane_convolution(ByteWeights(convolution), 2 * half_height, 2 * half_width)
    memory = used_memory(layer)
    convolved_picture(picture, layer, *memory)
    # Around the picture is the byte that is next to its mean.
    ringed = np.pad(picture, ((1, 1), (1, 1), (0, 0)), constant_values=round(picture.mean()))
    shown = ((ringed - picture.mean()) / (picture.std() + 8.0)).transpose(2, 0, 1)
    windows = np.lib.stride_tricks.sliding_window_view(shown, (3, 3), axis=(1, 2))[:, ::2, ::2]
    expected = np.einsum("cyxij,ocij->oyx", windows, with_bytes(convolution).weights)
    expected += convolution.biases[:, None, None]
    assert of_size(memory[2], layer) == pytest.approx(expected, abs=2e-3)


@given(
    st.integers(1, 40),
    st.integers(1, 12),
    st.integers(1, 9),
    st.integers(1, 70),
    st.booleans(),
    st.integers(0, 1000),
)
def test_two_rows_at_once_are_summed_to_what_one_after_the_other_is(
    inputs, outputs, height, width, outermost, seed
):
    random = np.random.default_rng(seed)
    planes = random.random((inputs, height, width))
    steps = random.integers(-127, 128, (outputs, inputs, 3, 3))
    if outermost:  # the numbers of 16 bits become as large as they can
        planes, steps = np.rint(planes), 127 * np.sign(steps)
    convolution = Convolution(steps.astype(np.float32), random.normal(size=outputs).astype(np.float32), 1)
    found = []
    for by_row_pairs in (False, True):
        layer = plane_convolution(ByteWeights(convolution, by_row_pairs), height, width)
        words, sums, memory = used_memory(layer)
        convolved_planes(with_zeros_beyond(planes.astype(np.float32)), layer, LOWEST, words, sums, memory)
        found.append(of_size(memory, layer))
    assert np.array_equal(*found)


def test_planes_that_cannot_be_halved_are_refused():
    convolution = Convolution(np.zeros((1, 1, 3, 3), np.float32), np.zeros(1, np.float32), 2)
    with pytest.raises(ValueError, match="7x4, which cannot be halved"):
        plane_convolution(ByteWeights(convolution), 4, 7)


def seen_by_definition(
    convolutions: Sequence[Convolution], picture: np.ndarray, shown: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """What layers and sums give, each convolution of planes as they are shown to it."""
    pixels = picture.astype(np.float64).transpose(2, 0, 1)
    layers = iter(convolutions)

    def after(planes: np.ndarray, count: int) -> np.ndarray:
        for layer in itertools.islice(layers, count):
            planes = np.maximum(convolved(shown(planes), layer), 0.0)
        return planes

    def doubled(planes: np.ndarray) -> np.ndarray:
        return np.kron(planes, np.ones((1, 2, 2)))

    first = convolved((pixels - pixels.mean()) / (pixels.std() + 8.0), next(layers))
    fine = after(np.maximum(first, 0.0), 3)
    middle = after(fine, 2)
    middle = after(middle + doubled(after(middle, 3)), 1)
    return convolved(shown(after(fine + doubled(middle), 1)), next(layers))


def test_what_the_net_sees_is_what_its_layers_and_sums_give(model):
    picture = np.random.default_rng(0).integers(0, 256, (SHOWN.height, SHOWN.width, 3)).astype(np.uint8)
    seen = GlanceNet(GlanceMemory(model.glance), SHOWN)(picture)
    expected = seen_by_definition([with_bytes(each) for each in model.glance], picture, in_bytes)
    # A step more or less, of a number in the middle of two, goes on through all layers.
    assert seen == pytest.approx(expected, abs=0.05)
    assert np.abs(seen - expected).mean() < 5e-3


def test_bytes_tell_of_real_pictures_nearly_what_unrounded_numbers_do(model, data_dir):
    seen, expected = [], []
    for name in (
        "labels/images/kitti_object_first31/000001.jpg",
        "tusimple/images/0002.jpg",
        "tusimple/images/0016.jpg",
        "tusimple/images/0026.jpg",
    ):
        pixels = cv2.imread(str(data_dir / name))
        assert pixels is not None
        picture = np.asarray(cv2.resize(pixels, (SHOWN.width, SHOWN.height)), np.uint8)
        seen.append(GlanceNet(GlanceMemory(model.glance), SHOWN)(picture).copy())
        expected.append(seen_by_definition(model.glance, picture, lambda planes: planes))
    off, told = np.abs(np.stack(seen) - np.stack(expected)), np.stack(expected)
    assert (off.mean(axis=(0, 2, 3)) < 0.05 * told.std(axis=(0, 2, 3))).all()


def test_pictures_of_several_sizes_one_after_another_are_seen_as_each_alone(model):
    random, memory = np.random.default_rng(0), GlanceMemory(model.glance)
    sizes = [ImageSize(224, 128), ImageSize(448, 160), ImageSize(896, 96), ImageSize(32, 32)]
    nets = {size: GlanceNet(memory, size) for size in sizes}
    for size in [*sizes, *reversed(sizes)]:
        picture = random.integers(0, 256, (size.height, size.width, 3)).astype(np.uint8)
        alone = GlanceNet(GlanceMemory(model.glance), size)
        assert np.array_equal(nets[size](picture), alone(picture))


def constant_net(outputs: list[float]) -> tuple[Convolution, ...]:
    """A net whose cells all say the same."""
    layers = [
        Convolution(np.zeros(shape, np.float32), np.zeros(shape[0], np.float32), stride)
        for shape, stride in zip(SHAPES, STRIDES, strict=True)
    ]
    layers[-1] = replace(layers[-1], biases=np.array(outputs, np.float32))
    return tuple(layers)


@pytest.mark.parametrize("size", [ImageSize(1792, 1024), ImageSize(224, 128), ImageSize(640, 480)])
def test_boxes_reach_from_the_cells_middles_as_far_as_the_net_says(size):
    logit, reaches = 1.5, np.array([1.0, 2.0, 3.0, 0.5])
    net = constant_net([logit, *np.log(reaches)])
    band = whole(size)
    seen = Glance(net, -6.0).at(Pyramid(np.zeros((size.height, size.width, 3), np.uint8)), [band])
    shown = band.shown
    assert len(seen.logits) == shown.width // CELL_PX * (shown.height // CELL_PX)
    cell_width, cell_height = size.width * CELL_PX / shown.width, size.height * CELL_PX / shown.height
    # The first cell's middle is half a cell from the picture's edge, which is half a pixel before its origin.
    left, top = -0.5 * cell_width, -1.5 * cell_height
    expected = [left - 0.5, top - 0.5, 4 * cell_width, 2.5 * cell_height]
    assert seen.boxes[0] == pytest.approx(expected, rel=1e-5)
    assert seen.logits == pytest.approx(logit)


WIDE = GroundPlaneCamera(0.0, 500.0, 359.5, 1.3, 639.5)
"""Its third band shows the picture's middle alone."""


def test_boxes_of_a_band_stand_where_it_was_cut_and_none_ends_where_the_picture_goes_on():
    size = ImageSize(1280, 720)
    _, middle, far, farthest = bands_of(size, WIDE, math.radians(1.0), 2.0)
    for band, sides_are_cut in ((middle, False), (far, False), (farthest, True)):
        small = 0.1  # cells to either side of a cell's middle
        net = constant_net([1.5, *np.log([small] * 4)])
        seen = Glance(net, -6.0).at(Pyramid(np.zeros((720, 1280, 3), np.uint8)), [band])
        middles = seen.boxes[:, :2] + seen.boxes[:, 2:] / 2 + 0.5
        shown = band.shown.width, band.shown.height
        for places, first_px, scale, count in zip(middles.T, band.corner_px, band.scale, shown, strict=True):
            steps, step = np.unique(np.round(places, 6)), CELL_PX * scale
            assert np.diff(steps) == pytest.approx(step)
            assert steps[0] == pytest.approx(first_px + step / 2)
            assert steps[-1] == pytest.approx(first_px + count * scale - step / 2)
        at_edge = constant_net([1.5, *np.log([2.0] * 4)])
        cut = Glance(at_edge, -6.0).at(Pyramid(np.zeros((720, 1280, 3), np.uint8)), [band])
        assert len(cut.logits) < len(seen.logits)
        ends = cut.boxes[:, :2] + cut.boxes[:, 2:]
        for axis, is_cut in ((0, sides_are_cut), (1, True)):
            limit = CUT_PX * band.scale[axis]
            first_px = band.corner_px[axis] - 0.5
            last_px = first_px + shown[axis] * band.scale[axis]
            inside = (cut.boxes[:, axis] >= first_px + limit - 1e-6) & (
                ends[:, axis] <= last_px - limit + 1e-6
            )
            assert np.all(inside) == is_cut


def test_the_net_is_shown_a_part_of_the_picture_there():
    # About the middle a pixel is as bright as it is far to the right (green), and down (red and blue).
    across = np.broadcast_to(np.clip(np.arange(1280) - 512, 0, 255), (720, 1280))
    down = np.broadcast_to(np.clip(np.arange(720) - 232, 0, 255)[:, None], (720, 1280))
    picture = np.stack([down, across, down], axis=-1).astype(np.uint8)
    for band in bands_of(ImageSize(1280, 720), WIDE, math.radians(1.0), 2.0):
        rows, columns = slice(band.first_row, band.end_row), slice(band.first_column, band.end_column)
        shown = Pyramid(picture).part(band.level, rows, columns, band.shown)
        assert shown.shape == (band.shown.height, band.shown.width, 3)
        for axis, line, start in ((0, shown[50, :, 1], 512), (1, shown[:, 100, 0], 232)):
            places = band.corner_px[axis] + (np.arange(len(line)) + 0.5) * band.scale[axis] - 0.5
            slope = np.flatnonzero((line > 10) & (line < 245))[2:-2]  # the outermost ones are those repeated
            assert len(slope) >= 20
            assert line[slope] == pytest.approx(places[slope] - start, abs=1.0)


def test_cells_below_the_least_logit_say_nothing():
    net = constant_net([-6.5, 0.0, 0.0, 0.0, 0.0])
    seen = Glance(net, -6.0).at(Pyramid(np.zeros((SHOWN.height, SHOWN.width, 3), np.uint8)), [whole(SHOWN)])
    assert not len(seen.logits)
    assert not len(seen.best(8, 0.6, -9.0).logits)
    assert seen.logits_of(np.array([[10.0, 10.0, 30.0, 20.0]]), 0.5, -6.0).tolist() == [-6.0]


def test_of_boxes_that_show_the_same_the_best_is_kept_and_every_box_has_the_best_logit_that_agrees():
    boxes = np.array([[10.0, 10.0, 40.0, 40.0], [12.0, 10.0, 40.0, 40.0], [100.0, 10.0, 40.0, 40.0]])
    seen = Glanced(boxes, np.array([3.0, 2.0, -1.0]))
    assert seen.best(8, 0.6, -1.0).logits.tolist() == [3.0, -1.0]
    assert seen.best(8, 0.6, -0.9).logits.tolist() == [3.0]
    assert seen.best(1, 0.6, -1.0).logits.tolist() == [3.0]
    asked = np.array([[14.0, 10.0, 40.0, 40.0], [100.0, 20.0, 40.0, 40.0], [300.0, 10.0, 40.0, 40.0]])
    assert seen.logits_of(asked, 0.5, -6.0).tolist() == [3.0, -1.0, -6.0]


def test_boxes_that_agree_count_as_they_are_likely():
    boxes = np.array([[10.0, 10.0, 40.0, 40.0], [14.0, 10.0, 40.0, 40.0], [100.0, 10.0, 40.0, 40.0]])
    seen = Glanced(boxes, np.array([math.log(3.0), 0.0, 5.0]))  # as likely as 3/4 and 1/2
    asked = np.array([[12.0, 10.0, 40.0, 40.0], [300.0, 10.0, 40.0, 40.0]])
    assert seen.boxes_of(asked, 0.6) == pytest.approx(np.array([[11.6, 10.0, 40.0, 40.0], asked[1]]))


def test_a_vehicle_is_seen_where_it_stands(model, data_dir):
    # The lead of the SFND drive, 4.1 m away by lidar, its tyres below the picture. The box was set by eye.
    image = cv2.imread(str(data_dir / "kitti-sfnd" / "images" / "0000000070.jpg"))
    assert image is not None
    picture = np.asarray(image, np.uint8)
    everything = whole(ImageSize(picture.shape[1], picture.shape[0]))
    seen = Glance(model.glance, -3.0).at(Pyramid(picture), [everything])
    lead = np.array([[531.0, 194.0, 257.0, 180.0]])
    assert seen.logits_of(lead, 0.5, -3.0)[0] > 0.0
    assert seen.logits_of(lead + np.array([300.0, -150.0, 0.0, 0.0]), 0.5, -3.0)[0] == -3.0
