"""The look in kernels of our own says what its definition, and OpenCV's dnn, say of the same windows."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from fcw.detection.net.forward import ForwardPass
from fcw.detection.net.look import LEAST_CONTRAST, LOOK_PX, normalised
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel
from fcw.detection.net.onnx_layers import Layers, read_layers
from fcw.errors import UserError


@pytest.fixture(scope="module")
def model() -> NetModel:
    return NetModel.load(SHIPPED_NET_PATH)


def verdicts_by_opencv(network: bytes, windows: np.ndarray) -> np.ndarray:
    net = cv2.dnn.readNetFromONNX(np.frombuffer(network, np.uint8))
    net.setInput(normalised(windows))
    return np.asarray(net.forward()).reshape(len(windows), -1)


def some_windows(count: int) -> np.ndarray:
    """Of a picture's smooth and rough parts: noise, larger and larger."""
    random = np.random.default_rng(count)
    windows = [
        cv2.resize(random.integers(0, 256, (size, size, 3)).astype(np.uint8), (LOOK_PX, LOOK_PX))
        for size in random.integers(2, LOOK_PX + 1, count)
    ]
    windows[0] = np.full((LOOK_PX, LOOK_PX, 3), 90, np.uint8)  # a plain wall
    return np.array(windows)


def in_bytes(numbers: np.ndarray) -> np.ndarray:
    """What is left of each row's numbers, none below zero, in whole steps, 255 of which are its largest."""
    steps = np.maximum(numbers.reshape(len(numbers), -1).max(axis=1), 1e-30) / 255
    steps = steps.reshape(-1, *[1] * (numbers.ndim - 1))
    return np.floor(numbers / steps + 0.5) * steps


def with_bytes(weights: np.ndarray) -> np.ndarray:
    """What is left of each output's weights in whole steps, 127 of which are its largest."""
    steps = np.abs(weights.reshape(len(weights), -1)).max(axis=1) / 127
    steps = steps.reshape(-1, *[1] * (weights.ndim - 1))
    return np.rint(weights / steps) * steps


def verdicts_by_definition(layers: Layers, windows: np.ndarray) -> np.ndarray:
    pixels = windows.astype(np.float64)
    mean = pixels.mean(axis=(1, 2, 3), keepdims=True)
    scale = 1 / (pixels.std(axis=(1, 2, 3), keepdims=True) + LEAST_CONTRAST)
    ring = np.rint(mean).transpose(0, 3, 1, 2) * np.ones((1, 3, 1, 1))
    planes = pixels.transpose(0, 3, 1, 2)
    for number, layer in enumerate(layers.convolutions):
        padded = np.pad(planes if number else planes - ring, ((0, 0), (0, 0), (1, 1), (1, 1)))
        if not number:
            padded = (padded + ring - mean) * scale
        looked_at = np.lib.stride_tricks.sliding_window_view(padded, (3, 3), axis=(2, 3))
        looked_at = looked_at[:, :, :: layer.stride, :: layer.stride]
        sums = np.einsum("ncyxij,ocij->noyx", looked_at, with_bytes(layer.weights), optimize=True)
        planes = in_bytes(np.maximum(sums + layer.biases[:, None, None], 0.0))
    hidden = planes.reshape(len(planes), -1) @ with_bytes(layers.hidden).T + layers.hidden_biases
    return np.maximum(hidden, 0.0) @ layers.output.T + layers.output_biases


@pytest.mark.parametrize("by_row_pairs", [False, True])
@pytest.mark.parametrize("count", [1, 8, 23, 80])
def test_verdicts_are_those_of_the_definition_and_nearly_those_of_opencv(model, count, by_row_pairs):
    windows, layers = some_windows(count), read_layers(model.look)
    verdicts = ForwardPass(layers, LOOK_PX, LEAST_CONTRAST, by_row_pairs)(windows)
    # A step more or less, of a number in the middle of two, goes on through all layers.
    assert verdicts == pytest.approx(verdicts_by_definition(layers, windows), abs=0.02)
    by_opencv = verdicts_by_opencv(model.look, windows)
    assert verdicts[:, 0] == pytest.approx(by_opencv[:, 0], abs=0.4)
    assert verdicts[:, 1:] == pytest.approx(by_opencv[:, 1:], abs=0.04)


@pytest.mark.parametrize("side", [48, 24, 12])
def test_rows_summed_two_at_once_say_the_same_of_windows_of_any_size(model, side):
    # Halved twice, windows of 12 px have three rows in the layer that goes a row a step.
    layers = read_layers(model.look)
    convolutions = layers.convolutions[:3]
    inputs = len(convolutions[-1].weights) * (side // 4) ** 2
    hidden = np.random.default_rng(side).normal(size=(len(layers.hidden), inputs)).astype(np.float32)
    small = replace(layers, convolutions=convolutions, hidden=hidden)
    windows = np.random.default_rng(0).integers(0, 256, (11, side, side, 3)).astype(np.uint8)
    one, two = (ForwardPass(small, side, LEAST_CONTRAST, at_once)(windows) for at_once in (False, True))
    assert np.array_equal(one, two)


def test_a_window_is_seen_alike_in_any_company(model):
    windows = np.random.default_rng(0).integers(0, 256, (30, LOOK_PX, LOOK_PX, 3)).astype(np.uint8)
    look = ForwardPass(read_layers(model.look), LOOK_PX, LEAST_CONTRAST)
    together = look(windows)
    for i in (0, 17, 29):
        assert look(windows[i : i + 1])[0] == pytest.approx(
            together[i], abs=1e-6
        )  # the last layer is NumPy's


def test_every_output_counts_where_they_are_no_multiple_of_four(model):
    # Of the last convolution the last two outputs are taken away, and what the hidden layer made of them.
    layers = read_layers(model.look)
    last = layers.convolutions[-1]
    fewer = replace(last, weights=last.weights[:-2], biases=last.biases[:-2])
    inputs = layers.hidden.shape[1] // len(last.weights) * len(fewer.weights)
    cut = replace(layers, convolutions=(*layers.convolutions[:-1], fewer), hidden=layers.hidden[:, :inputs])
    without = replace(layers, hidden=layers.hidden.copy())
    without.hidden[:, inputs:] = 0
    last.weights[-2:], last.biases[-2:] = 0, 0  # nor do they say what a byte's step is
    windows = np.random.default_rng(1).integers(0, 256, (5, LOOK_PX, LOOK_PX, 3)).astype(np.uint8)
    expected = ForwardPass(without, LOOK_PX, LEAST_CONTRAST)(windows)
    assert ForwardPass(cut, LOOK_PX, LEAST_CONTRAST)(windows) == pytest.approx(expected, abs=2e-5)


def test_windows_of_another_size_are_refused(model):
    layers: Layers = read_layers(model.look)
    with pytest.raises(ValueError, match="a net for other windows than of 24 px"):
        ForwardPass(layers, 24, LEAST_CONTRAST)
    with pytest.raises(ValueError, match="cannot halve so often"):
        ForwardPass(layers, 23, LEAST_CONTRAST)


@pytest.mark.parametrize("part", [0, 1, 1000, -5])
def test_a_net_that_is_cut_short_is_refused(model, part):
    with pytest.raises(ValueError, match=r"cut short|no layers|not all there|not an ONNX file"):
        read_layers(model.look[:part])


def test_a_net_of_other_layers_is_refused_by_the_models_file(model, tmp_path):
    other = model.look.replace(b"Relu", b"Tanh")
    replace(model, look=other).save(tmp_path / "net.npz")
    with pytest.raises(UserError, match=r"net\.npz: not a model of the net \(a net of Conv, Tanh, Conv"):
        NetModel.load(tmp_path / "net.npz")
