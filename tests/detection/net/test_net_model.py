"""The model's file: what is missing from one, or no number in it, is named."""

from dataclasses import replace

import numpy as np
import pytest

from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel
from fcw.detection.net.onnx_layers import read_layers
from fcw.errors import UserError


@pytest.fixture(scope="module")
def model() -> NetModel:
    return NetModel.load(SHIPPED_NET_PATH)


def test_a_file_without_a_whole_glance_is_refused(model, tmp_path):
    first, *others = model.glance
    cut = replace(first, weights=first.weights[:-1], biases=first.biases[:-1])
    replace(model, glance=(cut, *others)).save(tmp_path / "net.npz")
    with pytest.raises(
        UserError, match=r"net\.npz: not a model of the net \(no convolution of \(16, 3, 3, 3\)"
    ):
        NetModel.load(tmp_path / "net.npz")


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_a_file_of_weights_that_are_no_numbers_is_refused(model, tmp_path, number):
    first, *others = model.glance
    weights = first.weights.copy()
    weights[3, 1, 1, 1] = number
    replace(model, glance=(replace(first, weights=weights), *others)).save(tmp_path / "net.npz")
    with pytest.raises(
        UserError,
        match=r"not a model of the net \(weights that are no numbers, in the glance's",
    ):
        NetModel.load(tmp_path / "net.npz")
    largest = np.abs(read_layers(model.look).hidden).max()
    look = model.look.replace(np.float32(largest).tobytes(), np.float32(number).tobytes())
    look = look.replace(np.float32(-largest).tobytes(), np.float32(number).tobytes())
    replace(model, look=look).save(tmp_path / "net.npz")
    with pytest.raises(UserError, match=r"not a model of the net \(weights that are no numbers"):
        NetModel.load(tmp_path / "net.npz")


def test_a_threshold_that_is_no_number_is_refused(model, tmp_path):
    replace(model, score_threshold=np.nan).save(tmp_path / "net.npz")
    with pytest.raises(UserError, match=r"not a model of the net \(a score threshold of nan\)"):
        NetModel.load(tmp_path / "net.npz")
