"""Batches to learn from: vehicles, windows misplaced on them, and background, in all looks."""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.look import LOOK_PX
from fcw.detection.net.training.background import Background
from fcw.detection.net.training.framing import Framing, misplaced, well_framed
from fcw.detection.net.training.vehicles import Vehicles
from fcw.detection.training.looks import Looks, vary_looks


@dataclass(frozen=True, slots=True)
class BatchSettings:
    """What a batch is made of.

    Attributes:
        count: windows.
        vehicle_part: of them with a vehicle in place.
        misplaced_part: of them on a vehicle, but out of place.
        varied_part: how many look otherwise than in their picture.
        blurred_part: how many lose detail.
        covered_part: how many have something in front: a wiper, a post, dirt.
        framing: how far windows on vehicles are off.
        looks: how they look.
    """

    count: int = 192
    vehicle_part: float = 0.35
    misplaced_part: float = 0.2
    varied_part: float = 0.8
    blurred_part: float = 0.35
    covered_part: float = 0.1
    framing: Framing = Framing()  # noqa: RUF009 - frozen
    looks: Looks = Looks()  # noqa: RUF009 - frozen


class Batch(NamedTuple):
    """N windows to learn from.

    Attributes:
        windows: (N, side, side, 3) uint8 BGR.
        vehicle: (N,) 1.0 where a vehicle stands in place, else 0.0.
        offsets: (N, 4) how it stands.
    """

    windows: NDArray[np.uint8]
    vehicle: NDArray[np.float32]
    offsets: NDArray[np.float32]


def draw_batch(
    vehicles: Vehicles, background: Background, settings: BatchSettings, random: np.random.Generator
) -> Batch:
    """A batch, half of it mirrored."""
    count = settings.count
    batch = Batch(
        np.empty((count, LOOK_PX, LOOK_PX, 3), np.uint8),
        np.zeros(count, np.float32),
        np.zeros((count, 4), np.float32),
    )
    vehicle_count = round(settings.vehicle_part * count)
    misplaced_end = vehicle_count + round(settings.misplaced_part * count)
    for index in range(count):
        if index < vehicle_count:
            window, batch.offsets[index] = well_framed(vehicles.draw(random), settings.framing, random)
            batch.vehicle[index] = 1.0
        elif index < misplaced_end:
            window = misplaced(vehicles.draw(random), settings.framing, random)
        else:
            window = background.draw(random)
        window = _varied(window, settings, random)
        if random.uniform() < 0.5:
            window = window[:, ::-1]
            batch.offsets[index, 0] *= -1
        batch.windows[index] = window
    return batch


def _varied(
    window: NDArray[np.uint8], settings: BatchSettings, random: np.random.Generator
) -> NDArray[np.uint8]:
    if random.uniform() < settings.blurred_part:
        side = max(10, int(LOOK_PX / random.uniform(1.2, 3.0)))
        small = cv2.resize(window, (side, side), interpolation=cv2.INTER_AREA)
        window = np.asarray(cv2.resize(small, (LOOK_PX, LOOK_PX)), np.uint8)
    if random.uniform() < settings.varied_part:
        window = vary_looks(window, settings.looks, random)
    if random.uniform() < settings.covered_part:
        window = window.copy()
        (left, top), (width, height) = random.integers(0, 40, 2), random.integers(4, 20, 2)
        window[top : top + height, left : left + width] = random.integers(0, 255, 3)
    return window
