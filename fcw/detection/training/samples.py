"""Windows cut from pictures for training: placement, jitter, augmentation, channels as scanning sees them."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.cutting import cut_rectangle
from fcw.detection.boxes.regression import box_offsets
from fcw.detection.channels.aggregated import COARSE, CONTEXT_PX, FINE, ChannelComputer
from fcw.detection.model import CELL_PX, Window
from fcw.detection.training.looks import BRIGHTNESS, Looks, vary_looks
from fcw.detection.windows.plan import LARGEST_ENLARGEMENT
from fcw.frame import ImageSize

# Cells around a window that are computed with it and cut off again: its channels depend on their pixels.
MARGIN_CELLS = math.ceil(CONTEXT_PX / CELL_PX) + 1

# Random windows stand no farther than this below the horizon: nearer to it they are a few pixels small.
MIN_ROWS_BELOW_HORIZON = 8.0


@dataclass(frozen=True, slots=True)
class Augmentation:
    """How windows are varied, so that cameras other than those of the training pictures are met too.

    Attributes:
        shift: largest shift of a vehicle in its window, as a part of its size sqrt(width * height).
        scale: largest relative change of its size.
        stretch: largest relative change of its width.
        fine_part: part of the windows of larger vehicles that are seen as those of the smallest are.
        resampled_part: part of the windows that lose detail by being made smaller and larger again.
        resampling: smallest and largest factor of that.
        looks: how light, weather and cameras vary; None: not.
    """

    shift: float = 0.04
    scale: float = 0.10
    stretch: float = 0.08
    fine_part: float = 1 / 3
    resampled_part: float = 1 / 3
    resampling: tuple[float, float] = (1.2, 2.4)
    looks: Looks | None = BRIGHTNESS


NO_AUGMENTATION = Augmentation(0.0, 0.0, 0.0, 0.0, 0.0, looks=None)


@dataclass(frozen=True, slots=True)
class Placement:
    """Where a window takes its vehicle to stand.

    Attributes:
        middle_px: column of the vehicle's middle.
        bottom_px: row of its bottom edge.
        size_px: sqrt(width * height).
        stretch: how much more of the picture the window spans in width than in height.
    """

    middle_px: float
    bottom_px: float
    size_px: float
    stretch: float

    def offsets(self, box: NDArray[np.float64], mirrored: bool) -> NDArray[np.float64]:
        """(3,) how a box x, y, w, h truly stands, as `fcw.detection.boxes.regression` learns it."""
        x, _, w, h = box
        unstretched = np.array([[(x - self.middle_px) / self.stretch, 0.0, w / self.stretch, h]])
        offsets = box_offsets(unstretched, np.zeros(1), np.array([self.size_px]))[0]
        return offsets * [-1 if mirrored else 1, 1, 1]


def place(box: NDArray[np.float64], augmentation: Augmentation, generator: np.random.Generator) -> Placement:
    """A window on a vehicle's box, jittered."""
    size_px = math.sqrt(box[2] * box[3])
    shift_x, shift_y = generator.uniform(-augmentation.shift, augmentation.shift, 2) * size_px
    scale = math.exp(generator.uniform(-augmentation.scale, augmentation.scale))
    stretch = math.exp(generator.uniform(-augmentation.stretch, augmentation.stretch))
    return Placement(
        float(box[0] + box[2] / 2 + shift_x), float(box[1] + box[3] + shift_y), size_px * scale, stretch
    )


def window_features(
    image: NDArray[np.uint8],
    placement: Placement,
    window: Window,
    augmentation: Augmentation,
    generator: np.random.Generator,
    mirrored: bool,
) -> NDArray[np.uint8]:
    """Features of a window, augmented.

    A scanned picture's channels are computed at octaves of its scale and resized between them, and the
    smallest vehicles are seen in fine cells of the picture itself. Here the place in the octave is drawn at
    random, and so are fine cells for larger vehicles: the window is blurred as one met in scanning may be.

    Args:
        image: (height, width, 3) BGR.
        placement: where the window is.
        window: where the vehicle stands in it.
        augmentation: limits of the random changes of its pixels.
        generator: source of the randomness.
        mirrored: whether left and right are exchanged.

    Returns:
        (2560,) uint8 for the default window, in the order channel, row, column.
    """
    scale, stretch = placement.size_px / window.vehicle_size_px, placement.stretch
    # Image coordinates have their origin in the middle of the first pixel, crops at its edge.
    middle_x = placement.middle_px + 0.5
    top = placement.bottom_px - window.vehicle_bottom_px * scale + 0.5
    cells = window.cells + 2 * MARGIN_CELLS
    side = cells * CELL_PX * scale
    left, top = middle_x - side * stretch / 2, top - MARGIN_CELLS * CELL_PX * scale
    fine = generator.uniform() < augmentation.fine_part or scale < 2.0**-LARGEST_ENLARGEMENT
    settings = FINE if fine else COARSE
    # The octave's cells for each of the window's; no more than the picture has pixels for.
    reduction = min(2 ** generator.uniform(-LARGEST_ENLARGEMENT, 1 - LARGEST_ENLARGEMENT), scale * (1 + fine))
    octave_cells = round(cells * reduction)
    patch = cut_rectangle(image, left, top, side * stretch, side, octave_cells * settings.cell_px)
    if generator.uniform() < augmentation.resampled_part:
        patch = _lose_detail(patch, generator.uniform(*augmentation.resampling) * octave_cells / cells)
    if augmentation.looks:
        patch = vary_looks(patch, augmentation.looks, generator)
    computer = ChannelComputer(ImageSize(len(patch), len(patch)), settings)
    channels = computer.compute(patch[:, ::-1] if mirrored else patch)
    if octave_cells != cells:
        resized = cv2.resize(channels.transpose(1, 2, 0), (cells, cells), interpolation=cv2.INTER_LINEAR)
        channels = resized.transpose(2, 0, 1)
    inner = slice(MARGIN_CELLS, MARGIN_CELLS + window.cells)
    return np.asarray(channels[:, inner, inner], np.uint8).reshape(-1)


def random_boxes(
    count: int,
    horizon_row_px: float,
    camera_height_m: float,
    size: ImageSize,
    size_range_m: tuple[float, float],
    aspect_ratio: float,
    generator: np.random.Generator,
) -> NDArray[np.float64]:
    """(count, 4) boxes standing anywhere on the road as vehicles would, uniform in the picture's rows."""
    first_row = max(horizon_row_px + MIN_ROWS_BELOW_HORIZON, 0.0)
    bottom = generator.uniform(min(first_row, size.height - 1.0), size.height, count)
    size_m = np.exp(generator.uniform(math.log(size_range_m[0]), math.log(size_range_m[1]), count))
    size_px = size_m * np.maximum(bottom - horizon_row_px, MIN_ROWS_BELOW_HORIZON) / camera_height_m
    w, h = size_px * math.sqrt(aspect_ratio), size_px / math.sqrt(aspect_ratio)
    return np.column_stack([generator.uniform(0, size.width, count) - w / 2, bottom - h, w, h])


def _lose_detail(patch: NDArray[np.uint8], factor: float) -> NDArray[np.uint8]:
    """Made smaller by `factor` and larger again."""
    side = len(patch)
    small = max(2, round(side / factor))
    reduced = cv2.resize(patch, (small, small), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.resize(reduced, (side, side), interpolation=cv2.INTER_LINEAR), np.uint8)
