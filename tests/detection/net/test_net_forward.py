"""The look in kernels of our own says what OpenCV's dnn says of the same windows."""

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


@pytest.mark.parametrize("count", [1, 8, 23, 80])
def test_verdicts_are_those_of_opencv(model, count):
    random = np.random.default_rng(count)
    windows = random.integers(0, 256, (count, LOOK_PX, LOOK_PX, 3)).astype(np.uint8)
    windows[0] = 90  # a plain wall
    verdicts = ForwardPass(read_layers(model.look), LOOK_PX, LEAST_CONTRAST)(windows)
    assert verdicts == pytest.approx(verdicts_by_opencv(model.look, windows), abs=2e-5)


def test_a_window_is_seen_alike_in_any_company(model):
    windows = np.random.default_rng(0).integers(0, 256, (30, LOOK_PX, LOOK_PX, 3)).astype(np.uint8)
    look = ForwardPass(read_layers(model.look), LOOK_PX, LEAST_CONTRAST)
    together = look(windows)
    for i in (0, 17, 29):
        assert look(windows[i : i + 1])[0] == pytest.approx(together[i], abs=2e-5)


def test_every_output_counts_where_they_are_no_multiple_of_four(model):
    # Of the last convolution the last two outputs are taken away, and what the hidden layer made of them.
    layers = read_layers(model.look)
    last = layers.convolutions[-1]
    fewer = replace(last, weights=last.weights[:-2], biases=last.biases[:-2])
    inputs = layers.hidden.shape[1] // len(last.weights) * len(fewer.weights)
    cut = replace(layers, convolutions=(*layers.convolutions[:-1], fewer), hidden=layers.hidden[:, :inputs])
    without = replace(layers, hidden=layers.hidden.copy())
    without.hidden[:, inputs:] = 0
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
