"""How the glance's weights are learnt; needs PyTorch."""

from collections.abc import Callable, Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass
from itertools import pairwise, zip_longest
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.glance import CHANNELS, LARGEST_REACH, LEAST_CONTRAST, STRIDES
from fcw.detection.net.onnx_layers import Convolution
from fcw.detection.net.training.ahead import drawn_ahead
from fcw.detection.net.training.pytorch import functional, nn, torch
from fcw.detection.net.training.scenes import IGNORED, Scene
from fcw.detection.net.training.steps import keep_some, learn_from, take_convolutions

DROPPED = 0.1
"""Part of the coarse planes that is left out at a step, before their last convolution."""
UNLIKELY_LOGIT = -4.0
"""Of every cell at first: few are in the middle of a vehicle."""
LEAST_REACH = -3.0
"""Of the logarithms of reaches, in cells."""
LARGEST_GRADIENT = 5.0


@dataclass(frozen=True, slots=True)
class GlanceSettings:
    """The glance's training.

    Attributes:
        count: scenes of a batch.
        steps: batches learnt from.
        learning_rate: the largest (one cycle, Smith 2018).
        weight_decay: of AdamW.
        smoothing: labels are this far from 0 and 1.
        least_weight: of a cell about which the net is right: each counts by how wrong it is of it.
        seed: of weights and scenes.
    """

    count: int = 64
    steps: int = 20_000
    learning_rate: float = 3e-3
    weight_decay: float = 0.03
    smoothing: float = 0.01
    least_weight: float = 0.05
    seed: int = 0


class _Batch(NamedTuple):
    """N scenes, each of `Scene`'s arrays stacked."""

    pictures: NDArray[np.uint8]
    vehicle: NDArray[np.float32]
    reaches: NDArray[np.float32]


class _Net(nn.Module):
    """As `fcw.detection.net.glance.GlanceNet`; all but the last are normalised (Ioffe & Szegedy 2015).

    Args:
        start: learnt weights to go on from, in which the normalisation is already; None: random ones.
    """

    def __init__(self, start: Sequence[Convolution] | None) -> None:
        super().__init__()
        strides = iter(STRIDES)
        self.parts = nn.ModuleList()
        for number, row in enumerate(CHANNELS):
            is_last = number + 1 == len(CHANNELS)
            layers: list[Any] = []
            for inputs, outputs in pairwise(row):
                has_bias = is_last or start is not None
                layers.append(nn.Conv2d(inputs, outputs, 3, next(strides), 1, bias=has_bias))
                if not has_bias:
                    layers.append(nn.BatchNorm2d(outputs))
                if not is_last:
                    layers.append(nn.ReLU(inplace=True))
            self.parts.append(nn.Sequential(*layers))
        coarse: Any = self.parts[2]
        coarse.insert(len(coarse) - 3, nn.Dropout2d(DROPPED))
        if start is not None:
            take_convolutions(self, start)
            return
        bias = self.outputs[0].bias
        nn.init.constant_(bias, 1.0)
        nn.init.constant_(bias[:1], UNLIKELY_LOGIT)

    @property
    def outputs(self) -> Any:  # noqa: ANN401 - a torch module
        """The last part."""
        return self.parts[-1]

    def forward(self, pictures: Any) -> Any:  # noqa: ANN401 - torch tensors
        """(N, 5, rows, columns) of (N, 3, height, width)."""
        fine_part, middle_part, coarse_part, after_coarse, after_middle, outputs = self.parts
        fine = fine_part(pictures)
        middle = middle_part(fine)
        middle = after_coarse(middle + _doubled(coarse_part(middle)))
        return outputs(after_middle(fine + _doubled(middle)))


def _doubled(planes: Any) -> Any:  # noqa: ANN401 - a torch tensor
    return functional.interpolate(planes, scale_factor=2.0, mode="nearest")


def learn_glance(
    draw: Callable[[np.random.Generator], Scene],
    settings: GlanceSettings,
    on_step: Callable[[float], None] = lambda loss: None,
    start: Sequence[Convolution] | None = None,
) -> tuple[Convolution, ...]:
    """Learn from scenes; returns the convolutions of `fcw.detection.net.glance.SHAPES`.

    Args:
        draw: makes a scene; called in a thread of its own, ahead of the steps.
        settings: how.
        on_step: told the loss after each step.
        start: what was learnt before, to go on from; None: nothing.
    """

    def draw_batch(random: np.random.Generator) -> _Batch:
        scenes = [draw(random) for _ in range(settings.count)]
        return _Batch(*(np.stack(arrays) for arrays in zip(*scenes, strict=True)))

    torch.manual_seed(settings.seed)
    net = _Net(start).to(memory_format=torch.channels_last)
    begun = deepcopy(net.state_dict())
    with drawn_ahead(draw_batch, settings.steps, settings.seed) as batches:
        learn_from(
            net, batches, lambda batch: _loss(net, batch, settings), settings, on_step, LARGEST_GRADIENT
        )
    if start is not None:
        keep_some(net, begun)
    return tuple(_convolutions(net))


def _loss(net: Any, batch: _Batch, settings: GlanceSettings) -> Any:  # noqa: ANN401 - torch tensors
    pictures = torch.from_numpy(batch.pictures).permute(0, 3, 1, 2).float()
    pictures = pictures - pictures.mean((1, 2, 3), keepdim=True)
    pictures = pictures / (pictures.square().mean((1, 2, 3), keepdim=True).sqrt() + LEAST_CONTRAST)
    seen = net(pictures.contiguous(memory_format=torch.channels_last)).float()
    target, reaches = torch.from_numpy(batch.vehicle), torch.from_numpy(batch.reaches)
    known, inside = target != IGNORED, target > 0.5
    logits, wanted, smooth = seen[:, 0][known], target[known], settings.smoothing
    losses = functional.binary_cross_entropy_with_logits(
        logits, wanted * (1 - 2 * smooth) + smooth, reduction="none"
    )
    wrong = (torch.sigmoid(logits.detach()) - wanted).abs()
    loss = (losses * wrong.clamp(min=settings.least_weight)).sum() / max(int(inside.sum()), 1)
    found = torch.exp(seen[:, 1:].permute(0, 2, 3, 1)[inside].clamp(LEAST_REACH, LARGEST_REACH))
    return loss + (1.0 - _intersection_over_union(found, reaches.permute(0, 2, 3, 1)[inside])).mean()


def _intersection_over_union(reaches: Any, others: Any) -> Any:  # noqa: ANN401 - torch tensors
    """(N,) of boxes around a point each, by (N, 4) reaches to left, top, right, bottom (UnitBox, 2016)."""
    common = torch.minimum(reaches, others)
    common, area, other = (
        (each[:, 0] + each[:, 2]) * (each[:, 1] + each[:, 3]) for each in (common, reaches, others)
    )
    return common / (area + other - common).clamp(min=1e-3)


def _convolutions(net: Any) -> Iterator[Convolution]:  # noqa: ANN401 - a torch module
    """Those of a net that has learnt, each with the normalisation that follows it."""
    strides = iter(STRIDES)
    for part in net.parts:
        convolutions: list[Any] = [layer for layer in part if isinstance(layer, nn.Conv2d)]
        norms: list[Any] = [layer for layer in part if isinstance(layer, nn.BatchNorm2d)]
        for convolution, norm in zip_longest(convolutions, norms):
            weights, biases = convolution.weight, convolution.bias
            if norm is not None:
                scale = norm.weight / torch.sqrt(norm.running_var + norm.eps)
                weights = weights * scale[:, None, None, None]
                biases = norm.bias - norm.running_mean * scale
            yield Convolution(weights.detach().numpy(), biases.detach().numpy(), next(strides))
