"""The two looks that the detector takes: a quick one at all that the cascade proposes, then a closer one.

As in cascades of convolutional nets (MTCNN: Zhang et al. 2016; Cascade R-CNN: Cai & Vasconcelos 2018): the
first look is cheap, throws most windows out and moves the others onto the vehicle; the second sees vehicles
that stand where they should, and decides.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.forward import ForwardPass
from fcw.detection.net.onnx_layers import read_layers
from fcw.detection.net.proposals import choose
from fcw.detection.net.windows import Pyramid, boxes_of, placements_on

FIRST_PX, SECOND_PX = 24, 48
"""Sides of the windows that the nets are given."""
LEAST_CONTRAST = 5.0
"""Counts added to a window's standard deviation, so that noise on a plain wall does not fill the scale."""


def normalised(windows: NDArray[np.uint8]) -> NDArray[np.float32]:
    """What the nets are given: each window's brightness taken away and its contrast divided out.

    Haze, dusk and exposure are affine to what they change, with one scale and one offset at one distance
    (Koschmieder's law): a vehicle in fog looks to the nets as it does on a clear day, but for noise.

    Args:
        windows: (N, side, side, 3) BGR.

    Returns:
        (N, 3, side, side).
    """
    values = windows.reshape(len(windows), -1).astype(np.float32)
    values -= values.mean(axis=1, keepdims=True)
    values /= np.sqrt(np.mean(values**2, axis=1, keepdims=True)) + LEAST_CONTRAST
    return np.ascontiguousarray(values.reshape(windows.shape).transpose(0, 3, 1, 2))


class Look:
    """A net that says of each window whether a vehicle stands in it, and where.

    Args:
        network: an ONNX file's bytes: (N, 3, side, side), `normalised`, to (N, 5): the logit that a
            vehicle stands in the window, and its offsets (`fcw.detection.net.windows.boxes_of`).
        side_px: of its windows.

    Raises:
        ValueError: the file holds another kind of net; see `fcw.detection.net.onnx_layers`.
    """

    def __init__(self, network: bytes, side_px: int) -> None:
        self._net, self._side_px = ForwardPass(read_layers(network), side_px, LEAST_CONTRAST), side_px

    def at(
        self, pyramid: Pyramid, placements: NDArray[np.float64], mirrored: bool = False
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(N, 4) boxes of the vehicles that would stand there, and (N,) logits that they do.

        Args:
            pyramid: of the picture.
            placements: (N, 3) of the windows.
            mirrored: whether the net is shown their mirror images.
        """
        return self._verdicts(pyramid.windows(placements, self._side_px), placements, mirrored)

    def both_ways(
        self,
        pyramid: Pyramid,
        placements: NDArray[np.float64],
        worth: Callable[[NDArray[np.float64]], NDArray[np.bool_]],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """As `at`; of windows that are worth it the mean with what their mirror images say.

        A net errs otherwise in a mirror image of the same vehicle, so that both together err less.

        Args:
            pyramid: of the picture.
            placements: (N, 3) of the windows.
            worth: (N,) which windows are, by the boxes of all.
        """
        windows = pyramid.windows(placements, self._side_px)
        boxes, logits = self._verdicts(windows, placements, mirrored=False)
        chosen = worth(boxes)
        mirrored_boxes, mirrored_logits = self._verdicts(windows[chosen], placements[chosen], mirrored=True)
        boxes[chosen] = (boxes[chosen] + mirrored_boxes) / 2
        logits[chosen] = (logits[chosen] + mirrored_logits) / 2
        return boxes, logits

    def _verdicts(
        self, windows: NDArray[np.uint8], placements: NDArray[np.float64], mirrored: bool
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Boxes and logits of windows that were cut at these placements."""
        if not len(placements):
            return np.empty((0, 4)), np.empty(0)
        verdicts = self._net(np.ascontiguousarray(windows[:, :, ::-1]) if mirrored else windows)
        verdicts = verdicts.astype(np.float64)
        if mirrored:
            verdicts[:, 1] *= -1.0
        return boxes_of(placements, verdicts[:, 1:]), verdicts[:, 0]


@dataclass(frozen=True, slots=True)
class PickSettings:
    """Which of the windows that were looked at once are worth a closer look.

    Attributes:
        lowest_logit: of the first look. On cameras left out -4 finds no more, and takes longer.
        size_parts: as of `ProposalSettings`.
        counts: likewise.
        largest_iou: boxes that overlap more show the same.
    """

    lowest_logit: float = -2.5
    size_parts: tuple[float, ...] = (0.12, 0.3)
    counts: tuple[int, ...] = (14, 6, 4)
    largest_iou: float = 0.75


def pick(
    boxes: NDArray[np.float64], logits: NDArray[np.float64], picture_height: int, settings: PickSettings
) -> NDArray[np.float64]:
    """(M, 3) placements of the closer windows, from the first look's boxes and logits; best first."""
    worth = np.flatnonzero((logits >= settings.lowest_logit) & np.all(boxes[:, 2:] > 1.0, axis=1))
    order = worth[np.argsort(-logits[worth], kind="stable")]
    boxes = np.ascontiguousarray(boxes[order])
    placements = placements_on(boxes)
    chosen = choose(
        boxes,
        placements[:, 2] / picture_height,
        settings.size_parts,
        settings.counts,
        settings.largest_iou,
    )
    return placements[chosen]
