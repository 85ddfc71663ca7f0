"""Steps of a net's learning: AdamW with one cycle of the learning rate (Smith 2018).

Products are of bfloat16 where the processor has them, which makes a step a third to a half shorter
(Kalamkar et al. 2019); weights and losses stay float32.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol, TypeVar

import llvmlite.binding

from fcw.detection.net.onnx_layers import Convolution
from fcw.detection.net.training.pytorch import nn, torch

B = TypeVar("B")
HAS_BFLOAT16 = llvmlite.binding.get_host_cpu_features().get("avx512bf16", False)
"""PyTorch imitates what a processor lacks, which takes longer than float32."""
KEPT_PART = 0.25
"""Of the weights that a net goes on from, in their mean with what it learns (Wortsman et al. 2022, "Robust
fine-tuning of zero-shot models"). None, a quarter and a half were tried, see the card of `net`."""


class Schedule(Protocol):
    """How long, and how fast, a net learns."""

    @property
    def steps(self) -> int:
        """Batches learnt from."""
        ...

    @property
    def learning_rate(self) -> float:
        """The largest."""
        ...

    @property
    def weight_decay(self) -> float:
        """Of AdamW."""
        ...


def learn_from(
    net: Any,  # noqa: ANN401 - a torch module
    batches: Iterator[B],
    loss_of: Callable[[B], Any],
    schedule: Schedule,
    on_step: Callable[[float], None],
    largest_gradient: float | None = None,
) -> None:
    """Change a net's weights, batch by batch, and leave it as it is used.

    Args:
        net: the net.
        batches: as many as the schedule has steps.
        loss_of: what is to become small, of a batch.
        schedule: how long and how fast.
        on_step: told the loss after each step.
        largest_gradient: norm to which a step's gradient is cut; None: it is not.
    """
    optimiser = torch.optim.AdamW(
        net.parameters(), lr=schedule.learning_rate, weight_decay=schedule.weight_decay
    )
    rate = torch.optim.lr_scheduler.OneCycleLR(optimiser, schedule.learning_rate, total_steps=schedule.steps)
    net.train()
    for batch in batches:
        with torch.autocast("cpu", torch.bfloat16, enabled=HAS_BFLOAT16):
            loss = loss_of(batch)
        optimiser.zero_grad()
        loss.backward()
        if largest_gradient is not None:
            nn.utils.clip_grad_norm_(net.parameters(), largest_gradient)
        optimiser.step()
        rate.step()
        on_step(float(loss.detach()))
    net.eval()


def keep_some(net: Any, begun: Mapping[str, Any]) -> None:  # noqa: ANN401 - a torch module and its tensors
    """Mean of what a net learnt and of `begun`, the state that it went on from, with `KEPT_PART` of that."""
    learnt = net.state_dict()
    net.load_state_dict({name: each.lerp(begun[name], KEPT_PART) for name, each in learnt.items()})


def take_convolutions(net: Any, learnt: Sequence[Convolution]) -> None:  # noqa: ANN401 - a torch module
    """Give a net's convolutions, in their order, weights and biases that were learnt before."""
    convolutions = [layer for layer in net.modules() if isinstance(layer, nn.Conv2d)]
    with torch.no_grad():
        for layer, each in zip(convolutions, learnt, strict=True):
            layer.weight.copy_(torch.from_numpy(each.weights))
            layer.bias.copy_(torch.from_numpy(each.biases))
