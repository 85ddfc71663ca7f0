"""Which windows a detector scans: the scales, and the rows for each scale, planned once for a picture size.

A picture's channels are computed at octaves of its scale (2, 1, 1/2, ...). A level is a scale in between: a
grid of cells resized from an octave's, over which the model's window moves cell by cell.

Plain ACF scans everything at every scale. With the distance prior (section 3.2 of the paper), a window of
size s px with the vehicle's bottom edge in row v is scanned only if a vehicle of plausible size may stand
there on the road. A rear of S metres is S / h times as large as the number of rows from the horizon B to its
bottom edge, so

    size_low_m <= s h / (v - B) <= size_high_m    and    row(farthest) <= v <= row(nearest)

for some pitch within the tolerance. The rows are those of eq. 4, signed.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.model import CELL_PX, VehicleStatistics, Window
from fcw.errors import UserError
from fcw.frame import ImageSize

PAD_CELLS = 6
"""Cells by which an octave's edges are repeated, so that vehicles at the picture's edge have a window."""
LARGEST_ENLARGEMENT = 0.45
"""Largest enlargement of an octave to a level, in octaves: a factor of 1.37. Other levels are reduced from
the octave above, to no less than 0.68. Channels that are enlarged a little are closer to the true scale's
than those that are reduced a lot: at 0.59 they differ by 6 of 255 steps, not 10.
"""
LARGEST_SCALE_LIMIT = 4
"""There is only one octave above the picture's own."""
ROUNDING_ROWS = 6
"""Largest number of rows added to a cut so that its resized height is close to a whole number of cells."""


@dataclass(frozen=True, slots=True)
class RowRange:
    """Rows in which a vehicle's bottom edge may be, both ends included."""

    first_px: float
    last_px: float


@dataclass(frozen=True, slots=True)
class Level:
    """A grid of cells at one scale, and the windows that are scanned in it.

    Attributes:
        octave: its channels are resized from those of the picture scaled by 2**octave.
        first_cut: first row of the octave's cells that it is made from; negative above the picture.
        cut_rows: number of those rows.
        cut_columns: number of the octave's columns, including `PAD_CELLS` beyond the picture on both sides.
        rows: number of rows of its own cells.
        columns: number of columns of its own cells.
        first_window: row of cells where the first windows have their top.
        end_window: one past the last such row.
        window_columns: number of windows in a row.
    """

    octave: int
    first_cut: int
    cut_rows: int
    cut_columns: int
    rows: int
    columns: int
    first_window: int
    end_window: int
    window_columns: int

    @property
    def window_count(self) -> int:
        """Number of windows scanned."""
        return (self.end_window - self.first_window) * self.window_columns

    @property
    def resized(self) -> bool:
        """Whether its cells are not the octave's own."""
        return (self.rows, self.columns) != (self.cut_rows, self.cut_columns)

    @property
    def cell_px(self) -> tuple[float, float]:
        """Width and height of a cell in pixels of the picture."""
        octave_cell_px = CELL_PX / 2.0**self.octave
        return octave_cell_px * self.cut_columns / self.columns, octave_cell_px * self.cut_rows / self.rows

    def vehicles(
        self, window: Window, rows: NDArray[np.integer], columns: NDArray[np.integer]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """Middle columns, bottom rows and sqrt(w h), in px, of the vehicles that windows expect.

        Args:
            window: the model's window.
            rows: rows of the windows' top cells in the level.
            columns: columns of the windows' left cells.
        """
        cell_x, cell_y = self.cell_px
        octave_cell_px = CELL_PX / 2.0**self.octave
        # Half a pixel, because cells begin at the first pixel's edge and coordinates at its centre.
        middles = (columns.astype(np.float64) + window.cells / 2) * cell_x - PAD_CELLS * octave_cell_px - 0.5
        bottoms = (
            (rows.astype(np.float64) + window.vehicle_bottom_px / CELL_PX) * cell_y
            + self.first_cut * octave_cell_px
            - 0.5
        )
        return middles, bottoms, math.sqrt(cell_x * cell_y) / CELL_PX * window.vehicle_size_px


@dataclass(frozen=True, slots=True)
class DistancePrior:
    """Where on the road vehicles are looked for.

    Attributes:
        camera: the calibrated camera.
        statistics: sizes of vehicles.
        nearest_m: nearest distance from the camera.
        farthest_m: farthest distance from the camera.
        pitch_tolerance_rad: largest difference of the pitch from the calibration's, up or down.
    """

    camera: GroundPlaneCamera
    statistics: VehicleStatistics
    nearest_m: float
    farthest_m: float
    pitch_tolerance_rad: float

    def bottom_rows(self, size_px: float) -> RowRange | None:
        """Rows where a vehicle of this size, sqrt(w h), may have its bottom edge; None if there are none."""
        ranges = [
            self._rows_at_pitch(size_px, self.camera.pitch_rad + sign * self.pitch_tolerance_rad)
            for sign in (1, 0, -1)
        ]
        if all(rows.first_px > rows.last_px for rows in ranges):
            return None
        return RowRange(ranges[0].first_px, ranges[-1].last_px)

    def aspect_ratios(self, bottom_rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Width over height of vehicles with these bottom rows, which are limited to the distance range."""
        distances_m = np.clip(self.camera.distance_at(bottom_rows), self.nearest_m, self.farthest_m)
        return np.asarray(self.statistics.aspect_ratio(distances_m))

    def _rows_at_pitch(self, size_px: float, pitch_rad: float) -> RowRange:
        camera = replace(self.camera, pitch_rad=pitch_rad)
        height_in_sizes = size_px * camera.height_m
        return RowRange(
            max(
                camera.horizon_row_px + height_in_sizes / self.statistics.size_high_m,
                camera.row_at(self.farthest_m),
            ),
            min(
                camera.horizon_row_px + height_in_sizes / self.statistics.size_low_m,
                camera.row_at(self.nearest_m),
            ),
        )


def prior_levels(
    size: ImageSize,
    window: Window,
    prior: DistancePrior,
    scales_per_octave: int,
    largest_scale: float,
) -> tuple[Level, ...]:
    """Levels of the distance-prior detector, from the largest scale (the farthest vehicles) down.

    Raises:
        UserError: the calibration puts the road outside the picture.
    """
    levels = []
    # A near vehicle's window may reach beyond the picture; twice its size is more than the padding allows.
    smallest = window.size_px / min(size.width, size.height) / 2
    for scale in _scales_down(scales_per_octave, largest_scale, smallest):
        rows = prior.bottom_rows(window.vehicle_size_px / scale)
        level = rows and _level(size, window, scale, largest_scale, rows)
        if level:
            levels.append(level)
    if not levels:
        raise UserError(
            f"the calibration has its horizon in row {prior.camera.horizon_row_px:.0f} of pictures of "
            f"{size}: no vehicle {prior.nearest_m:g} to {prior.farthest_m:g} m away can be in them; "
            "calibrate again with points on the road ahead"
        )
    return tuple(levels)


def full_levels(
    size: ImageSize, window: Window, scales_per_octave: int, largest_scale: float
) -> tuple[Level, ...]:
    """Levels of plain ACF: the whole picture, from the largest scale until a window fills it."""
    everywhere = RowRange(-math.inf, math.inf)
    smallest = window.size_px / min(size.width, size.height)
    levels = (
        _level(size, window, scale, largest_scale, everywhere)
        for scale in _scales_down(scales_per_octave, largest_scale, smallest)
    )
    return tuple(level for level in levels if level)


def _scales_down(scales_per_octave: int, largest: float, smallest: float) -> Iterator[float]:
    """Scales 2**(k / scales_per_octave) within limits, from the largest down."""
    if not 1 <= largest < LARGEST_SCALE_LIMIT:
        raise ValueError(f"largest_scale {largest}: expected 1 to under {LARGEST_SCALE_LIMIT}")
    step = math.floor(scales_per_octave * math.log2(largest) + 1e-9)
    while (scale := 2.0 ** (step / scales_per_octave)) >= smallest:
        yield scale
        step -= 1


def _level(
    size: ImageSize, window: Window, scale: float, largest_scale: float, bottoms: RowRange
) -> Level | None:
    """The level of a scale for bottom edges within a range; None if it has no window."""
    top_octave = math.floor(math.log2(largest_scale))
    octave = min(math.ceil(math.log2(scale) - LARGEST_ENLARGEMENT), top_octave)
    octave_cell_px = CELL_PX / 2.0**octave
    ratio = scale / 2.0**octave
    octave_rows, octave_columns = int(size.height // octave_cell_px), int(size.width // octave_cell_px)
    # Rows of the octave's cells that the windows cover, plus one on each side for the interpolation.
    below_bottom_px = (window.size_px - window.vehicle_bottom_px) / scale
    top_px = bottoms.first_px - window.vehicle_bottom_px / scale + 0.5
    end_px = bottoms.last_px + below_bottom_px + 0.5
    first = math.floor(max(top_px / octave_cell_px - 1, -PAD_CELLS))
    end = math.ceil(min(end_px / octave_cell_px + 1, octave_rows + PAD_CELLS))
    if end <= first:
        return None
    if ratio != 1.0:
        limit = max(end, min(end + ROUNDING_ROWS, octave_rows + PAD_CELLS))
        end = min(range(end, limit + 1), key=lambda e: abs((e - first) * ratio - round((e - first) * ratio)))
    cut_rows, cut_columns = end - first, octave_columns + 2 * PAD_CELLS
    rows, columns = round(cut_rows * ratio), round(cut_columns * ratio)
    window_columns = columns - window.cells + 1
    if rows < window.cells or window_columns < 1:
        return None
    level = Level(
        octave, first, cut_rows, cut_columns, rows, columns, 0, rows - window.cells + 1, window_columns
    )
    # Channels are stacked when they are enlarged, so outermost rows mix with the next channel and are not
    # used.
    edge = 1 if ratio > 1 else 0
    tops = np.arange(edge, level.end_window - edge)
    _, bottom_rows, _ = level.vehicles(window, tops, tops)
    last_px = min(bottoms.last_px, size.height - 0.5)
    inside = tops[(bottom_rows >= bottoms.first_px) & (bottom_rows <= last_px)]
    if not len(inside):
        return None
    return replace(level, first_window=int(inside[0]), end_window=int(inside[-1]) + 1)
