"""Windows on vehicles: in place, as what proposes them may frame them, and out of place."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.cutting import cut_rectangle
from fcw.detection.net.look import LOOK_PX
from fcw.detection.net.training.vehicles import Seen
from fcw.detection.net.windows import BOTTOM_UNITS, VEHICLE_UNITS, WINDOW_UNITS


@dataclass(frozen=True, slots=True)
class Framing:
    """How far windows are off that still are in place, and those that are not.

    The former as far as the glance's boxes are that overlap with a vehicle (IoU 0.4), on cameras left out.

    Attributes:
        scale: standard deviation of the logarithm of the size of windows in place.
        right: of their middle, in sizes of the vehicle.
        down: of their bottom, likewise.
        stretch: largest logarithm of width to height, beyond what the window has.
        part: smallest and largest size, beside the vehicle's, of windows that show a part of it.
        aside: how far beside it those stand that do, in its widths.
        excess: size, beside the vehicle's, of windows that show too much.
    """

    scale: float = 0.16
    right: float = 0.1
    down: float = 0.09
    stretch: float = 0.1
    part: tuple[float, float] = (0.2, 0.5)
    aside: tuple[float, float] = (0.45, 0.7)
    excess: tuple[float, float] = (1.55, 1.8)


def well_framed(
    seen: Seen, framing: Framing, random: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """A window on a vehicle as it may be proposed, and (4,) how the vehicle stands in it."""
    scale = np.exp(random.normal(0.0, framing.scale))
    stretch = np.exp(random.uniform(-framing.stretch, framing.stretch))
    right, down = random.normal(0.0, framing.right), random.normal(0.0, framing.down)
    standing = seen.standing
    size = standing.size * scale
    middle, bottom = standing.middle + right * standing.size, standing.bottom + down * standing.size
    offsets = np.array(
        [
            (standing.middle - middle) / (size * stretch),
            (standing.bottom - bottom) / size,
            np.log(standing.width / (size * stretch)),
            np.log(standing.height / size),
        ]
    )
    return _window(seen.picture, middle, bottom, size, stretch), offsets


def misplaced(seen: Seen, framing: Framing, random: np.random.Generator) -> NDArray[np.uint8]:
    """A window that shows part of a vehicle, or what is beside it, or too much: none stands in place."""
    standing, kind = seen.standing, random.integers(3)
    middle, bottom, size = standing.middle, standing.bottom, standing.size
    if kind == 0:  # a lamp, a wheel, a pane
        size *= random.uniform(*framing.part)
        middle += random.uniform(-0.5, 0.5) * (standing.width - size)
        bottom -= random.uniform(0.0, 1.0) * max(standing.height - size, 0.0)
    elif kind == 1:
        middle += random.choice([-1, 1]) * random.uniform(*framing.aside) * standing.width
        bottom += random.uniform(-0.3, 0.3) * standing.height
    else:
        size *= random.uniform(*framing.excess)
        middle += random.uniform(-0.3, 0.3) * standing.width
    return _window(seen.picture, middle, bottom, size, np.exp(random.uniform(-0.1, 0.1)))


def _window(
    picture: NDArray[np.uint8], middle: float, bottom: float, size: float, stretch: float
) -> NDArray[np.uint8]:
    """A window of a stored picture, which may be wider than high."""
    unit = size / VEHICLE_UNITS
    step = WINDOW_UNITS * unit / LOOK_PX
    if step > 1.4:
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), 0.35 * step), np.uint8)
    width, height = WINDOW_UNITS * unit * stretch, WINDOW_UNITS * unit
    # Standings are counted from the first pixel's edge, as cuts are.
    return cut_rectangle(picture, middle - width / 2, bottom - BOTTOM_UNITS * unit, width, height, LOOK_PX)
