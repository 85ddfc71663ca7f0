"""The layers of a net, out of its ONNX file: what `fcw.detection.net.forward` can compute.

An ONNX file is a protocol buffer (https://protobuf.dev/programming-guides/encoding/), its fields numbered in
https://github.com/onnx/onnx/blob/main/onnx/onnx.proto. The few that matter are read here: the net's own
training writes them, and the `onnx` package is no part of what users install.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]

_VARINT, _EIGHT_BYTES, _BYTES, _FOUR_BYTES = 0, 1, 2, 5
_MODEL_GRAPH = 7
_GRAPH_NODE, _GRAPH_INITIALIZER = 1, 5
_NODE_INPUT, _NODE_OPERATION, _NODE_ATTRIBUTE = 1, 4, 5
_ATTRIBUTE_NAME, _ATTRIBUTE_INTEGER, _ATTRIBUTE_INTEGERS = 1, 3, 8
_TENSOR_DIMENSIONS, _TENSOR_TYPE, _TENSOR_NAME, _TENSOR_RAW = 1, 2, 8, 9
_SINGLE_PRECISION = 1


@dataclass(frozen=True, slots=True, eq=False)
class Convolution:
    """3x3, with a ring of zeros around what it looks at; what is negative becomes zero.

    Attributes:
        weights: (outputs, inputs, 3, 3).
        biases: (outputs,).
        stride: 1 or 2.
    """

    weights: FloatArray
    biases: FloatArray
    stride: int


@dataclass(frozen=True, slots=True, eq=False)
class Layers:
    """A net: convolutions, then a hidden layer of which what is negative becomes zero, then the outputs.

    Attributes:
        convolutions: the first ones.
        hidden: (H, inputs) weights; inputs in the order channel, row, column.
        hidden_biases: (H,).
        output: (outputs, H) weights.
        output_biases: (outputs,).
    """

    convolutions: tuple[Convolution, ...]
    hidden: FloatArray
    hidden_biases: FloatArray
    output: FloatArray
    output_biases: FloatArray


def read_layers(file: bytes) -> Layers:
    """The layers of a net by its ONNX file.

    Raises:
        ValueError: it is no such file, or a net of other layers.
    """
    graph = b"".join(_parts(file, _MODEL_GRAPH))
    tensors = dict(map(_tensor, _parts(graph, _GRAPH_INITIALIZER)))
    nodes = [_Node(node) for node in _parts(graph, _GRAPH_NODE)]
    names = [node.operation for node in nodes]
    count = names.count("Conv")
    if not count or names != ["Conv", "Relu"] * count + ["Flatten", "Gemm", "Relu", "Gemm"]:
        raise ValueError(
            f"a net of {', '.join(names)[:200] or 'no layers'}; expected Conv and Relu, once or more, then "
            "Flatten, Gemm, Relu, Gemm"
        )
    try:
        weights = [
            [tensors[name] for name in node.inputs[1:]]
            for node in nodes
            if node.operation in ("Conv", "Gemm")
        ]
        convolutions = tuple(
            Convolution(kernels, biases, _stride(node, kernels))
            for node, (kernels, biases) in zip(nodes[: 2 * count : 2], weights, strict=False)
        )
        layers = Layers(convolutions, *weights[-2], *weights[-1])
    except (KeyError, TypeError) as error:
        raise ValueError(f"a net whose weights are not all there ({error})") from None
    _check_shapes(layers, nodes)
    return layers


class _Node:
    """An operation of the net: its name, what it takes, and its whole numbers by name."""

    def __init__(self, data: bytes) -> None:
        self.operation = _text(data, _NODE_OPERATION)
        self.inputs = [name.decode() for name in _parts(data, _NODE_INPUT)]
        self.numbers = {
            _text(each, _ATTRIBUTE_NAME): _integers(each, _ATTRIBUTE_INTEGER, _ATTRIBUTE_INTEGERS)
            for each in _parts(data, _NODE_ATTRIBUTE)
        }


def _stride(node: _Node, weights: FloatArray) -> int:
    strides = node.numbers.get("strides", [1, 1])
    plain = node.numbers.get("pads") == [1] * 4 and node.numbers.get("group", [1]) == [1]
    plain &= node.numbers.get("dilations", [1, 1]) == [1, 1] and strides in ([1, 1], [2, 2])
    if not plain or weights.shape[2:] != (3, 3):
        raise ValueError(
            f"a convolution of {node.numbers}; expected 3x3 with pads of 1 and a stride of 1 or 2"
        )
    return strides[0]


def _check_shapes(layers: Layers, nodes: list[_Node]) -> None:
    """That each layer takes what the one before gives; the first dense one's inputs follow from the side."""
    given, fits = 3, all(node.numbers.get("transB") == [1] for node in nodes if node.operation == "Gemm")
    for each in layers.convolutions:
        fits &= each.weights.shape[1] == given and each.biases.shape == (len(each.weights),)
        given = len(each.weights)
    fits &= layers.hidden.ndim == layers.output.ndim == 2
    if not (
        fits
        and layers.hidden_biases.shape == (len(layers.hidden),)
        and layers.output.shape[1] == len(layers.hidden)
        and layers.output_biases.shape == (len(layers.output),)
    ):
        raise ValueError("a net whose layers do not fit each other")


def _tensor(data: bytes) -> tuple[str, FloatArray]:
    shape = _integers(data, _TENSOR_DIMENSIONS)
    if _integers(data, _TENSOR_TYPE) != [_SINGLE_PRECISION]:
        raise ValueError("weights that are not in single precision")
    values = np.frombuffer(b"".join(_parts(data, _TENSOR_RAW)), "<f4")
    if not np.isfinite(values).all():
        raise ValueError("weights that are no numbers")
    return _text(data, _TENSOR_NAME), values.reshape(shape).astype(np.float32)


def _parts(data: bytes, number: int) -> Iterator[bytes]:
    """Values of a field that holds messages, texts or bytes."""
    for found, value in _fields(data):
        if found == number and isinstance(value, bytes):
            yield value


def _text(data: bytes, number: int) -> str:
    return b"".join(_parts(data, number)).decode()


def _integers(data: bytes, *numbers: int) -> list[int]:
    """Whole numbers of fields, packed or not."""
    values: list[int] = []
    for found, value in _fields(data):
        if found not in numbers:
            continue
        if isinstance(value, int):
            values.append(value)
            continue
        at = 0
        while at < len(value):
            each, at = _varint(value, at)
            values.append(each)
    return values


def _fields(data: bytes) -> Iterator[tuple[int, int | bytes]]:
    """Numbers and values of a message's fields, in their order."""
    at = 0
    while at < len(data):
        key, at = _varint(data, at)
        kind = key & 7
        if kind == _VARINT:
            value, at = _varint(data, at)
        else:
            if kind == _BYTES:
                size, at = _varint(data, at)
            elif kind in (_EIGHT_BYTES, _FOUR_BYTES):
                size = 8 if kind == _EIGHT_BYTES else 4
            else:
                raise ValueError("not an ONNX file")
            value, at = data[at : at + size], at + size
            if at > len(data):
                raise ValueError("an ONNX file that is cut short")
        yield key >> 3, value


def _varint(data: bytes, at: int) -> tuple[int, int]:
    """A whole number of seven bits a byte, and where it ends."""
    value = shift = 0
    while at < len(data) and shift < 70:
        value |= (data[at] & 127) << shift
        shift, at = shift + 7, at + 1
        if data[at - 1] < 128:
            return value, at
    raise ValueError("an ONNX file that is cut short")
