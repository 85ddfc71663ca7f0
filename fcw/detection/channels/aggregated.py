"""The ten aggregated channel features (ACF) of a picture, as planar uint8 grids of 4x4 px cells.

Definition (P. Dollár et al., "Fast Feature Pyramids for Object Detection", PAMI 2014, and its toolbox):
BGR -> LUV; smoothing with [1 2 1]/4 both ways; central differences, in each pixel those of the colour
channel with the largest gradient magnitude M; normalisation M / (S + 0.005), S being M smoothed by a
triangle filter of radius 5 both ways; each pixel's magnitude shared between the two nearest of 6
orientations; means over 4x4 px cells; smoothing of the cells with [1 2 1]/4 both ways. Edges are repeated
beyond the picture, which is first cut to whole cells.

| channel | what | value before quantisation | stored as |
| --- | --- | --- | --- |
| 0 | L | L* / 270: 0 to 0.37 | L times 255 * 270 / 100 |
| 1 | u | (u* + 88) / 270, grey at 0.326 | 112 + 510 times (u less grey) |
| 2 | v | (v* + 134) / 270, grey at 0.496 | 112 + 510 times (v less grey) |
| 3 | normalised gradient magnitude | 0 to about 1.1 | 200 times its square root |
| 4-9 | its part in the orientation k * 30 degrees | the six add up to channel 3 | 200 times its square root |

Stored values are rounded and held within 0..255. LUV is taken of the picture's RGB values without undoing
their gamma, as the toolbox does. The square root keeps the low end of the gradients, where far vehicles live.
The orientation is that of the gradient in [0, pi): 0 for a vertical edge, pi/2 for a horizontal one, growing
from u towards v.

Far vehicles are looked for at twice the picture's scale. `FINE` cells of 2x2 px stand for the 4x4 px cells of
an enlarged picture at a quarter of the work: enlarging smooths by itself and halves the differences between
neighbours, so the smoothing is less ([1 10 1]/12), the filter's radius 2 and the constant 0.01. The channels
agree with those of the picture enlarged by bilinear interpolation to a correlation of 0.96 to 0.999, and in
their mean.

A window's values depend on nothing but its own pixels and those up to `CONTEXT_PX` around it: a crop with
that margin, a band of rows and the whole picture give the same channels.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.detection.channels.kernel import channel_rows
from fcw.detection.channels.stages import CELL_RING, LUV_RING, MAGNITUDE_RING, PAD, TRIANGLE_REACH
from fcw.detection.model import CELL_PX, CHANNEL_COUNT
from fcw.frame import ImageSize
from fcw.kernels.aligned import aligned_row, aligned_zeros
from fcw.kernels.jit import rows_of_bytes


@dataclass(frozen=True, slots=True)
class CellSettings:
    """How channels are computed for cells of one size.

    Attributes:
        cell_px: side of a cell, 4 or 2.
        smoothing: outer weights of the colours' smoothing, the middle one being 1 less both.
        triangle_radius: of the filter that the gradients are normalised by.
        normalisation_constant: added to the filtered magnitude, so that noise in flat areas stays small.
    """

    cell_px: int
    smoothing: float
    triangle_radius: int
    normalisation_constant: float


COARSE = CellSettings(CELL_PX, 1 / 4, 5, 0.005)
"""ACF's own cells."""
FINE = CellSettings(CELL_PX // 2, 1 / 12, 2, 0.01)
"""Cells of half the size, in place of those of a picture of twice the size."""
CONTEXT_PX = CELL_PX + COARSE.triangle_radius + 2
"""Pixels around a cell that its channels depend on: a cell of smoothing, filter, difference, smoothing."""


class ChannelComputer:
    """Computes channels of pictures of one size, in memory it keeps: one instance for each thread."""

    def __init__(self, size: ImageSize, settings: CellSettings = COARSE) -> None:
        self.size = size
        self._settings = settings
        cell_px = settings.cell_px
        self.rows = size.height // cell_px
        self.columns = size.width // cell_px
        if self.rows < 1 or self.columns < 1:
            raise ValueError(f"a picture of {size} is smaller than one cell of {cell_px}x{cell_px} px")
        width = self.columns * cell_px
        weights = np.maximum(settings.triangle_radius + 1 - np.arange(TRIANGLE_REACH + 1), 0)
        self._triangle = (weights / (settings.triangle_radius + 1) ** 2).astype(np.float32)
        pixels, cells = aligned_row(width, np.float32), aligned_row(self.columns, np.float32)
        padded_pixels, padded_cells = pixels + 2 * PAD, cells + 2 * PAD
        self._luv = aligned_zeros((LUV_RING, 3, padded_pixels), np.float32)
        self._smooth = aligned_zeros((LUV_RING, 3, padded_pixels), np.float32)
        self._magnitudes = aligned_zeros((MAGNITUDE_RING, pixels), np.float32)
        self._orientations = aligned_zeros((MAGNITUDE_RING, pixels), np.float32)
        self._normalised = aligned_zeros((pixels,), np.float32)
        self._vertical = aligned_zeros((1, 3 * padded_pixels), np.float32)
        self._filtered = aligned_zeros((padded_pixels,), np.float32)
        self._sums = aligned_zeros((CHANNEL_COUNT, padded_pixels), np.float32)
        self._cells = aligned_zeros((CELL_RING, CHANNEL_COUNT, padded_cells), np.float32)

    def compute(
        self,
        image: NDArray[np.uint8],
        first_row: int = 0,
        end_row: int | None = None,
        out: NDArray[np.uint8] | None = None,
    ) -> NDArray[np.uint8]:
        """Channels of the cell rows first_row..end_row-1.

        Args:
            image: (height, width, 3) BGR of this computer's size; copied where it is not contiguous.
            first_row: first row of cells wanted.
            end_row: one past the last; None: to the picture's end.
            out: (10, end_row - first_row, columns) to write into; None: a new array.

        Returns:
            (10, end_row - first_row, columns): the same values as those rows of the whole picture's channels.

        Raises:
            ValueError: the picture has another size, or the rows do not lie in it.
        """
        if image.shape != (self.size.height, self.size.width, 3) or image.dtype != np.uint8:
            raise ValueError(
                f"expected a uint8 BGR picture of {self.size}, got {image.dtype} of shape {image.shape}"
            )
        end_row = self.rows if end_row is None else end_row
        if not 0 <= first_row < end_row <= self.rows:
            raise ValueError(f"cell rows {first_row}..{end_row} of a picture with {self.rows}")
        shape = (CHANNEL_COUNT, end_row - first_row, self.columns)
        if out is None:
            out = np.empty(shape, np.uint8)
        elif out.shape != shape:
            raise ValueError(f"`out` must be of shape {shape}, got {out.shape}")
        channel_rows(
            rows_of_bytes(image),
            first_row,
            end_row,
            self._settings.cell_px,
            np.float32(self._settings.smoothing),
            self._triangle,
            np.float32(self._settings.normalisation_constant),
            self._luv,
            self._smooth,
            self._magnitudes,
            self._orientations,
            self._normalised,
            self._vertical,
            self._filtered,
            self._sums,
            self._cells,
            out.transpose(1, 2, 0),  # never contiguous: one type for every caller, and one compiled kernel
        )
        return out


def compute_channels(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Channels of a (height, width, 3) BGR picture: (10, height // 4, width // 4) uint8.

    Raises:
        ValueError: the picture is smaller than a cell, or not uint8 BGR.
    """
    return ChannelComputer(ImageSize(image.shape[1], image.shape[0])).compute(image)
