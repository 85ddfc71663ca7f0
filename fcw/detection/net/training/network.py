"""The net of the look, and how its weights are learnt; needs PyTorch."""

import io
import math
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np

from fcw.detection.net.look import LOOK_PX, normalised
from fcw.detection.net.onnx_layers import Layers
from fcw.detection.net.training.ahead import drawn_ahead
from fcw.detection.net.training.batches import Batch
from fcw.detection.net.training.pytorch import functional, nn, torch
from fcw.detection.net.training.steps import keep_some, learn_from, take_convolutions

OUTPUTS = 5
"""The logit of a vehicle, and its four offsets."""


@dataclass(frozen=True, slots=True)
class NetworkSettings:
    """The net and its training.

    Attributes:
        channels: of the convolutions.
        strides: of the same.
        hidden: of the layer before the output.
        steps: batches learnt from.
        learning_rate: the largest (one cycle, Smith 2018).
        weight_decay: of AdamW.
        offset_weight: of the offsets' loss beside the logit's.
        offset_precision: error of an offset from which its loss is linear.
        smoothing: labels are this far from 0 and 1.
        seed: of weights and batches.
    """

    channels: tuple[int, ...] = (24, 48, 48, 96)
    strides: tuple[int, ...] = (2, 2, 1, 2)
    hidden: int = 64
    steps: int = 20_000
    learning_rate: float = 4e-3
    weight_decay: float = 0.03
    offset_weight: float = 2.0
    offset_precision: float = 0.05
    smoothing: float = 0.01
    seed: int = 0


def build(settings: NetworkSettings, start: Layers | None = None) -> Any:  # noqa: ANN401 - a torch module
    """The net: convolutions, each normalised (Ioffe & Szegedy 2015), and two layers.

    Args:
        settings: its size.
        start: learnt weights to go on from, in which the normalisation is already; None: random ones.
    """
    before, layers = 3, []
    for channels, stride in zip(settings.channels, settings.strides, strict=True):
        layers.append(nn.Conv2d(before, channels, 3, stride, 1, bias=start is not None))
        if start is None:
            layers.append(nn.BatchNorm2d(channels))
        layers.append(nn.ReLU(inplace=True))
        before = channels
    side = LOOK_PX // math.prod(settings.strides)
    net = nn.Sequential(
        *layers,
        nn.Dropout2d(0.1),
        nn.Flatten(),
        nn.Linear(before * side * side, settings.hidden),
        nn.ReLU(inplace=True),
        nn.Dropout(0.3),
        nn.Linear(settings.hidden, OUTPUTS),
    )
    if start is not None:
        take_convolutions(net, start.convolutions)
        hidden, output = (layer for layer in net if isinstance(layer, nn.Linear))
        with torch.no_grad():
            for layer, weights, biases in (
                (hidden, start.hidden, start.hidden_biases),
                (output, start.output, start.output_biases),
            ):
                layer.weight.copy_(torch.from_numpy(weights))
                layer.bias.copy_(torch.from_numpy(biases))
    return net


def learn(
    draw: Callable[[np.random.Generator], Batch],
    settings: NetworkSettings,
    on_step: Callable[[float], None] = lambda loss: None,
    start: Layers | None = None,
) -> bytes:
    """Learn from batches; returns the net as an ONNX file's bytes.

    Args:
        draw: makes a batch; called in a thread of its own, ahead of the steps.
        settings: how.
        on_step: told the loss after each step.
        start: what was learnt before, to go on from; None: nothing.
    """
    torch.manual_seed(settings.seed)
    net = build(settings, start)
    begun = deepcopy(net.state_dict())
    with drawn_ahead(draw, settings.steps, settings.seed) as batches:
        learn_from(net, batches, lambda batch: _loss(net, batch, settings), settings, on_step)
    if start is not None:
        keep_some(net, begun)
    return _as_onnx(net)


def _loss(net: Any, batch: Batch, settings: NetworkSettings) -> Any:  # noqa: ANN401
    out = net(torch.from_numpy(normalised(batch.windows))).float()
    target = torch.from_numpy(batch.vehicle)
    smooth = settings.smoothing
    loss = functional.binary_cross_entropy_with_logits(out[:, 0], target * (1 - 2 * smooth) + smooth)
    inside = target > 0.5
    offsets = functional.smooth_l1_loss(
        out[inside, 1:], torch.from_numpy(batch.offsets)[inside], beta=settings.offset_precision
    )
    return loss + settings.offset_weight * offsets


def _as_onnx(net: Any) -> bytes:  # noqa: ANN401
    file = io.BytesIO()
    net.eval()
    torch.onnx.export(
        net,
        (torch.zeros(1, 3, LOOK_PX, LOOK_PX),),
        file,
        input_names=["windows"],
        output_names=["verdicts"],
        dynamic_axes={"windows": {0: "count"}, "verdicts": {0: "count"}},
        dynamo=False,
    )
    return file.getvalue()
