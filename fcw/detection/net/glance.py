"""The glance: a net that sees the picture and its bands at low resolution, vehicles with their surroundings.

As in FCOS (Tian et al. 2019), each cell of the net's output tells whether it is in the middle of a vehicle,
and how far the vehicle extends to each side. As in feature pyramids (Lin et al. 2017), coarse features of a
wider surrounding are added to fine ones. The same net sees the whole picture and bands that enlarge what is
far away (`fcw.detection.net.bands`), so that to it all vehicles are near.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.boxes.suppression import keep_unlike
from fcw.detection.net.bands import Band
from fcw.detection.net.byte_weights import ByteWeights
from fcw.detection.net.onnx_layers import Convolution
from fcw.detection.net.planes import (
    BEYOND,
    PlaneConvolution,
    convolve,
    plane_convolution,
    put_picture,
    put_planes,
)
from fcw.detection.net.windows import Pyramid
from fcw.frame import ImageSize
from fcw.kernels.aligned import Scratch
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel

FloatArray = NDArray[np.float32]
WordArray = NDArray[np.int32]

CELL_PX = 8
"""Side of a cell, in pixels of the net's input."""
LEAST_CONTRAST = 8.0
"""Grey levels added to the standard deviation of the input before it is divided out, as for windows."""
LARGEST_REACH = 4.0
"""Upper bound of the log extent of a vehicle, in cells: 50 cells are more than the whole picture has."""
CUT_PX = 3.0
"""A box that ends this near to the edge of a band may continue beyond it."""

LOWEST = float(np.finfo(np.float32).min)
"""Lower bound of all outputs, so that kernels may assume finite numbers."""

FINE, MIDDLE, COARSE = 4, 2, 3
"""Number of convolutions at the finest scale, at half, and at a quarter of it."""
CHANNELS = ((3, 16, 32, 48, 48), (48, 96, 96), (96, 128, 128, 96), (96, 48), (48, 48), (48, 5))
"""Channels of the convolutions: fine, middle, coarse, after each of the two sums, and of the output."""
STRIDES = (2, 2, 2, 1, 2, 1, 2, 1, 1, 1, 1, 1)
SHAPES = tuple((outputs, inputs, 3, 3) for row in CHANNELS for inputs, outputs in pairwise(row))
"""Shapes of the weights of all convolutions."""


class GlanceMemory:
    """Weights and working memory that the nets for several input sizes share. Each thread needs its own.

    Args:
        convolutions: all convolutions of the net, of `SHAPES`.
    """

    def __init__(self, convolutions: Sequence[Convolution]) -> None:
        self.weights = [ByteWeights(each) for each in convolutions]
        self.words, self.sums = Scratch(np.int32), Scratch(np.int32)
        self.planes, self.fine, self.middle = Scratch(), Scratch(), Scratch()


class GlanceNet:
    """The net for one input size.

    Args:
        memory: weights and working memory, shared with the other nets of its thread.
        shown: the input size.
    """

    def __init__(self, memory: GlanceMemory, shown: ImageSize) -> None:
        self._memory = memory
        layers: list[PlaneConvolution] = []
        halvings = 0
        for number, each in enumerate(memory.weights):
            if number in (FINE + MIDDLE + COARSE, FINE + MIDDLE + COARSE + 1):  # after a sum
                halvings -= 1
            layers.append(plane_convolution(each, shown.height >> halvings, shown.width >> halvings))
            halvings += each.stride - 1
        self._layers = tuple(layers)
        self._word_count = max(each.word_count for each in layers)
        self._sum_count = max(each.sum_count for each in layers)
        self._plane_count = max(each.output_count for each in layers)

    def __call__(self, picture: NDArray[np.uint8]) -> FloatArray:
        """(5, rows, columns): each cell's logit, and log extents of the vehicle to left, top, right, bottom.

        Extents are from the middle of the cell, in cells. The result is in memory that the next call of any
        net of the thread overwrites.
        """
        memory, (outputs, rows, columns) = self._memory, self._layers[-1].outputs
        planes = memory.planes.of(self._plane_count)
        _see(
            np.ascontiguousarray(picture),
            LEAST_CONTRAST,
            self._layers,
            memory.words.of(self._word_count),
            memory.sums.of(self._sum_count),
            planes,
            memory.fine.of(self._layers[FINE - 1].output_count),
            memory.middle.of(self._layers[FINE + MIDDLE - 1].output_count),
        )
        return planes[: self._layers[-1].output_count].reshape(outputs, rows, -1)[:, :, :columns]


@kernel()
def _see(
    picture: NDArray[np.uint8],
    least_contrast: float,
    layers: tuple[PlaneConvolution, ...],
    words: WordArray,
    sums: WordArray,
    planes: FloatArray,
    fine: FloatArray,
    middle: FloatArray,
) -> None:
    """The whole net in one call; between several calls, it would have to wait for the interpreter's lock."""
    for number in range(len(layers)):
        if number == FINE:
            _copy(planes, fine)
        elif number == FINE + MIDDLE:
            _copy(planes, middle)
        elif number == FINE + MIDDLE + COARSE:
            _add_doubled(middle, layers[number].inputs, planes)
            _copy(middle, planes)
        elif number == FINE + MIDDLE + COARSE + 1:
            _add_doubled(fine, layers[number].inputs, planes)
            _copy(fine, planes)
        if number == 0:
            step, zero = put_picture(picture, layers[0], least_contrast, words, sums)
        else:
            step, zero = put_planes(planes, layers[number], words, sums)
        least = np.float32(0 if number + 1 < len(layers) else LOWEST)
        convolve(layers[number], step, zero, least, words, sums, planes)


@inner_kernel(no_alias=True)
def _copy(planes: FloatArray, to: FloatArray) -> None:
    for i in range(min(len(planes), len(to))):
        to[i] = planes[i]


@inner_kernel(no_alias=True)
def _add_doubled(planes: FloatArray, shape: tuple[int, int, int], coarse: FloatArray) -> None:
    """Add coarser planes, enlarged twice by repeating their elements."""
    count, rows, columns = shape
    pitch, coarse_pitch = columns + BEYOND, columns // 2 + BEYOND
    for plane in range(count):
        for row in range(rows):
            start = (plane * rows + row) * pitch
            coarse_start = (plane * (rows // 2) + row // 2) * coarse_pitch
            for column in range(columns // 2):
                value = coarse[coarse_start + column]
                planes[start + 2 * column] += value
                planes[start + 2 * column + 1] += value


@dataclass(frozen=True, slots=True, eq=False)
class Glanced:
    """The result of a glance.

    Attributes:
        boxes: (N, 4) x, y, w, h of possible vehicles, in pixels of the picture.
        logits: (N,) their logits, best first.
    """

    boxes: NDArray[np.float64]
    logits: NDArray[np.float64]

    def best(self, count: int, largest_iou: float, least_logit: float) -> "Glanced":
        """The best boxes with at least a logit, of which no two have more than an IoU."""
        enough = np.searchsorted(-self.logits, -least_logit, side="right")
        chosen = keep_unlike(self.boxes[:enough], largest_iou, count)
        return Glanced(self.boxes[chosen], self.logits[chosen])

    def logits_of(
        self, boxes: NDArray[np.float64], least_iou: float, least_logit: float
    ) -> NDArray[np.float64]:
        """(M,) best logit of those that agree with each of (M, 4) boxes, and at least `least_logit`."""
        agree = intersection_over_union(boxes, self.boxes) >= least_iou
        logits = np.where(agree, self.logits, least_logit)
        return logits.max(axis=1, initial=least_logit)

    def boxes_of(self, boxes: NDArray[np.float64], least_iou: float) -> NDArray[np.float64]:
        """(M, 4) for each box, the mean of those that agree with it, weighted by probability; else itself."""
        agree = intersection_over_union(boxes, self.boxes) >= least_iou
        weights = agree / (1.0 + np.exp(-self.logits))
        total = weights.sum(axis=1, keepdims=True)
        return np.where(total > 0, weights @ self.boxes / np.maximum(total, 1e-9), boxes)


class Glance:
    """Glances at pictures. An instance owns working memory, so each thread needs its own.

    Args:
        convolutions: the convolutions of the net.
        least_logit: cells with a lower logit are ignored.
    """

    def __init__(self, convolutions: Sequence[Convolution], least_logit: float) -> None:
        self._memory, self._least_logit = GlanceMemory(convolutions), least_logit
        self._nets: dict[ImageSize, GlanceNet] = {}

    def at(self, pyramid: Pyramid, bands: Sequence[Band]) -> Glanced:
        """Possible vehicles in the bands of a picture."""
        seen = [self._in(pyramid, band) for band in bands]
        logits = np.concatenate([logits for _, logits in seen])
        order = np.argsort(-logits, kind="stable")
        return Glanced(np.concatenate([boxes for boxes, _ in seen])[order], logits[order])

    def _in(self, pyramid: Pyramid, band: Band) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(N, 4) boxes and (N,) logits."""
        if band.shown not in self._nets:
            self._nets[band.shown] = GlanceNet(self._memory, band.shown)
        cut_rows, cut_columns = slice(band.first_row, band.end_row), slice(band.first_column, band.end_column)
        shown = pyramid.part(band.level, cut_rows, cut_columns, band.shown)
        seen = self._nets[band.shown](shown)
        rows, columns = np.nonzero(seen[0] >= self._least_logit)
        middles = (np.column_stack([columns, rows]) + 0.5) * CELL_PX
        reaches = np.exp(np.minimum(seen[1:, rows, columns].T.astype(np.float64), LARGEST_REACH)) * CELL_PX
        corners, far_corners = middles - reaches[:, :2], middles + reaches[:, 2:]
        goes_on_before, goes_on_beyond = band.is_cut
        ends = (band.shown.width - CUT_PX, band.shown.height - CUT_PX)
        cut = ((corners < CUT_PX) & goes_on_before) | ((far_corners > ends) & goes_on_beyond)
        whole = ~cut.any(axis=1)
        # The origin of coordinates is the centre of the first pixel.
        corners = corners[whole] * band.scale + np.subtract(band.corner_px, 0.5)
        sizes = (reaches[whole, :2] + reaches[whole, 2:]) * band.scale
        boxes = np.hstack([corners, sizes]).astype(np.float64)
        return boxes, seen[0, rows[whole], columns[whole]].astype(np.float64)
