"""A glance at the whole picture, shown small: near vehicles in their surroundings.

The looks see a window at a time, and take part of a lorry for a car, or a car that is cut by the picture's
edge for nothing. A net that sees all of the picture knows better what is near. As in FCOS (Tian et al. 2019)
each of its cells says whether it is in the middle of a vehicle, and how far that reaches to either side; as
in feature pyramids (Lin et al. 2017) what is seen of larger surroundings is added to what is seen finely.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.net.onnx_layers import Convolution
from fcw.detection.net.planes import PlaneConvolution
from fcw.detection.net.proposals import choose
from fcw.detection.net.windows import Pyramid
from fcw.frame import ImageSize

FloatArray = NDArray[np.float32]

CELL_PX = 8
"""Side of a cell, in the small picture."""
SHOWN = ImageSize(224, 128)
"""The small picture, where pictures are 7 to 4. Others are shown as large, and a little out of shape."""
SIDES_PX = 32
"""A multiple of which its sides are: it is halved five times."""
LEAST_CONTRAST = 8.0
"""Counts added to the picture's standard deviation, as for windows."""
LARGEST_REACH = 4.0
"""Of the logarithms of reaches, in cells: 50 cells are more than the picture has."""

FINE, MIDDLE, COARSE = 4, 2, 3
"""How many convolutions come first, see cells twice as large, and four times."""
CHANNELS = ((3, 16, 32, 48, 48), (48, 96, 96), (96, 128, 128, 96), (96, 48), (48, 48), (48, 5))
"""Of the convolutions: fine, middle, coarse; after each of the two sums; and those of the outputs."""
STRIDES = (2, 2, 2, 1, 2, 1, 2, 1, 1, 1, 1, 1)
SHAPES = tuple((outputs, inputs, 3, 3) for row in CHANNELS for inputs, outputs in pairwise(row))
"""Of the weights of all convolutions."""


class GlanceNet:
    """The net for pictures of one shape, in memory it keeps: one for each thread.

    Args:
        convolutions: all of them, of `SHAPES`.
        shown: size of the small picture.
    """

    def __init__(self, convolutions: Sequence[Convolution], shown: ImageSize) -> None:
        self._layers: list[PlaneConvolution] = []
        halvings = 0
        for number, each in enumerate(convolutions):
            if number in (FINE + MIDDLE + COARSE, FINE + MIDDLE + COARSE + 1):  # after a sum
                halvings -= 1
            self._layers.append(PlaneConvolution(each, shown.height >> halvings, shown.width >> halvings))
            halvings += each.stride - 1

    def __call__(self, picture: NDArray[np.uint8]) -> FloatArray:
        """(5, rows, columns): each cell's logit, and how far the vehicle reaches to left, top, right, bottom.

        The latter from the cell's middle, as logarithms, in cells.
        """
        planes = picture.astype(np.float32).transpose(2, 0, 1)
        planes = (planes - planes.mean()) / (planes.std() + np.float32(LEAST_CONTRAST))
        layers = iter(self._layers)

        def after(planes: FloatArray, count: int) -> FloatArray:
            for _ in range(count):
                planes = next(layers)(planes)
            return planes

        fine = after(planes, FINE)
        middle = after(fine, MIDDLE)
        middle = after(middle + _doubled(after(middle, COARSE)), 1)
        fine = after(fine + _doubled(middle), 1)
        return next(layers)(fine, least=-np.inf)


def _doubled(planes: FloatArray) -> FloatArray:
    return planes.repeat(2, axis=1).repeat(2, axis=2)


@dataclass(frozen=True, slots=True, eq=False)
class Glanced:
    """What a glance saw.

    Attributes:
        boxes: (N, 4) x, y, w, h of the vehicles that cells would be in the middle of, px of the picture.
        logits: (N,) that they are, best first.
    """

    boxes: NDArray[np.float64]
    logits: NDArray[np.float64]

    def best(self, count: int, largest_iou: float) -> "Glanced":
        """The best ones of which no two overlap by more."""
        chosen = choose(self.boxes, np.zeros(len(self.boxes)), (), (count,), largest_iou)
        return Glanced(self.boxes[chosen], self.logits[chosen])

    def logits_of(
        self, boxes: NDArray[np.float64], least_iou: float, least_logit: float
    ) -> NDArray[np.float64]:
        """(M,) the best logit of what agrees with each of (M, 4) boxes, and no less than `least_logit`."""
        agree = intersection_over_union(boxes, self.boxes) >= least_iou
        logits = np.where(agree, self.logits, least_logit)
        return logits.max(axis=1, initial=least_logit)


class Glance:
    """Glances at pictures of one size; owns memory: use one for each thread.

    Args:
        convolutions: of the net.
        size: of the pictures.
        least_logit: cells below it say nothing.
    """

    def __init__(self, convolutions: Sequence[Convolution], size: ImageSize, least_logit: float) -> None:
        self._shown = shown_as(size)
        self._net, self._least_logit = GlanceNet(convolutions, self._shown), least_logit
        self._scale = np.array([size.width / self._shown.width, size.height / self._shown.height], np.float64)

    def at(self, pyramid: Pyramid) -> Glanced:
        """What may be a near vehicle in a picture."""
        seen = self._net(pyramid.shown_as(self._shown))
        rows, columns = np.nonzero(seen[0] >= self._least_logit)
        logits = seen[0, rows, columns].astype(np.float64)
        order = np.argsort(-logits, kind="stable")
        rows, columns = rows[order], columns[order]
        middles = (np.column_stack([columns, rows]) + 0.5) * CELL_PX
        reaches = np.exp(np.minimum(seen[1:, rows, columns].T.astype(np.float64), LARGEST_REACH)) * CELL_PX
        # Coordinates have their origin in the middle of the first pixel.
        corners = (middles - reaches[:, :2]) * self._scale - 0.5
        sizes = (reaches[:, :2] + reaches[:, 2:]) * self._scale
        return Glanced(np.hstack([corners, sizes]), logits[order])


def shown_as(size: ImageSize) -> ImageSize:
    """How large a picture is shown: about as many pixels as `SHOWN` has, in nearly the picture's shape."""
    scale = np.sqrt(SHOWN.width * SHOWN.height / (size.width * size.height))
    width, height = (max(2, round(side * scale / SIDES_PX)) * SIDES_PX for side in (size.width, size.height))
    return ImageSize(width, height)
