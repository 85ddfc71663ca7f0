"""ONNX nets that put out what a test wants."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

OPSET = 17


def write_net(
    path: Path,
    output: NDArray[np.float32],
    shown: tuple[int | str, int | str],
    metadata: Mapping[str, str] | None = None,
    *,
    batch: int | str = 1,
    takes: int = TensorProto.FLOAT,
) -> Path:
    """A net for 1x3xHxW pictures that puts out `output`, whatever it is shown.

    H and W are numbers, or names where the net takes any; so is the batch. `takes` is ONNX's number of the
    type of the picture's numbers.
    """
    picture = helper.make_tensor_value_info("images", takes, [batch, 3, *shown])
    put_out = helper.make_tensor_value_info("output", TensorProto.FLOAT, [1, None, None])
    graph = helper.make_graph(
        [
            helper.make_node("Cast", ["images"], ["picture"], to=TensorProto.FLOAT),
            helper.make_node("ReduceMean", ["picture"], ["mean"], keepdims=0),
            helper.make_node("Mul", ["mean", "zero"], ["nothing"]),
            helper.make_node("Add", ["constant", "nothing"], ["output"]),
        ],
        "tiny",
        [picture],
        [put_out],
        [
            numpy_helper.from_array(output.astype(np.float32), "constant"),
            numpy_helper.from_array(np.zeros((), np.float32), "zero"),
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=9)
    helper.set_model_props(model, dict(metadata or {}))
    onnx.save(model, path)
    return path


def write_quick_net(path: Path) -> Path:
    """A net that sees one car ahead in every picture: for what needs a detector and costs no time by it."""
    found = np.zeros((1, 300, 6), np.float32)
    found[0, 0] = 145.0, 100.0, 175.0, 128.0, 0.9, 2  # corners, score, and the class of cars
    return write_net(path, found, (192, 320))


def write_swelling_net(path: Path, shape: tuple[int, ...], side_px: int) -> Path:
    """A net of a few bytes that puts out zeros of that shape, which its file does not state."""
    picture = helper.make_tensor_value_info("images", TensorProto.FLOAT, [1, 3, side_px, side_px])
    put_out = helper.make_tensor_value_info("output", TensorProto.FLOAT, None)
    graph = helper.make_graph(
        [
            helper.make_node("ReduceMean", ["images"], ["mean"], keepdims=0),
            helper.make_node("Mul", ["mean", "zero"], ["nothing"]),
            helper.make_node("Add", ["shape", "nothing"], ["seen"]),
            helper.make_node("Cast", ["seen"], ["sides"], to=TensorProto.INT64),
            helper.make_node("Expand", ["nothing", "sides"], ["output"]),
        ],
        "swelling",
        [picture],
        [put_out],
        [
            numpy_helper.from_array(np.array(shape, np.float32), "shape"),
            numpy_helper.from_array(np.zeros((), np.float32), "zero"),
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=9)
    onnx.save(model, path)
    return path
