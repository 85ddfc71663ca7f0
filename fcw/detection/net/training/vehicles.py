"""Vehicles cut out with what is around them, and seen as they may be met: hidden, cut by edges, lit."""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.training.lottery import Lottery
from fcw.detection.net.windows import BOTTOM_UNITS, VEHICLE_UNITS, WINDOW_UNITS, Pyramid, placements_on
from fcw.detection.training.dataset import TrainingImage

STORED_PX = 128
"""A vehicle is kept with so many units around its window's middle, at one pixel a unit."""
MIDDLE_PX = STORED_PX / 2
BOTTOM_PX = MIDDLE_PX + BOTTOM_UNITS - WINDOW_UNITS / 2
ENOUGH_OF_A_CLIP = 15
"""Vehicles of a clip that count in full; of more each counts less: they are the same few."""


class Standing(NamedTuple):
    """Where a vehicle stands in a stored picture: middle, bottom, width and height, px."""

    middle: float
    bottom: float
    width: float
    height: float

    @property
    def size(self) -> float:
        """sqrt(width * height)."""
        return float(np.sqrt(self.width * self.height))


class Seen(NamedTuple):
    """A vehicle and the picture around it, (STORED_PX, STORED_PX, 3)."""

    picture: NDArray[np.uint8]
    standing: Standing


@dataclass(frozen=True, slots=True)
class Circumstances:
    """How often each of these happens to a vehicle, as a part of all.

    Attributes:
        lit: its tail lamps shine.
        hidden: another vehicle stands in front of it.
        cut_at_side: the picture ends within it.
        cut_at_bottom: the picture, or the own bonnet, ends above its tyres.
        largest_hidden: most of its width that is hidden; of those cut, nearly as much is.
    """

    lit: float = 0.15
    hidden: float = 0.15
    cut_at_side: float = 0.08
    cut_at_bottom: float = 0.12
    largest_hidden: float = 0.45


class Vehicles:
    """All vehicles that count, each drawn the less often the more of its clip there are."""

    def __init__(
        self,
        images: Sequence[TrainingImage],
        circumstances: Circumstances,
        advance: Callable[[], None] = lambda: None,
    ) -> None:
        self._circumstances = circumstances
        self._seen: list[Seen] = []
        clips: list[str] = []
        for image in images:
            boxes = image.labelled.boxes[~image.labelled.ignored]
            if len(boxes):
                placements = placements_on(boxes)
                units = placements[:, 2] / VEHICLE_UNITS
                pictures = Pyramid(image.labelled.read()).windows(placements, STORED_PX, STORED_PX)
                for picture, (w, h) in zip(pictures, boxes[:, 2:] / units[:, None], strict=True):
                    self._seen.append(Seen(picture, Standing(MIDDLE_PX, BOTTOM_PX, float(w), float(h))))
                    clips.append(image.labelled.clip)
            advance()
        self._lottery = Lottery(drawing_weights(clips))

    def __len__(self) -> int:
        return len(self._seen)

    def draw(self, random: np.random.Generator) -> Seen:
        """One vehicle, in circumstances drawn at random."""
        chances, seen = self._circumstances, self._any(random)
        if random.uniform() < chances.lit:
            seen = with_lamps(seen, random)
        if random.uniform() < chances.hidden:
            part = random.uniform(0.1, chances.largest_hidden)
            seen = hidden_by(self._any(random), seen, part, random)
        if random.uniform() < chances.cut_at_side:
            seen = cut_at_side(seen, random.uniform(0.1, 0.4), left=random.uniform() < 0.5)
        if random.uniform() < chances.cut_at_bottom:
            seen = cut_at_bottom(seen, random.uniform(0.08, 0.4), random)
        return seen

    def _any(self, random: np.random.Generator) -> Seen:
        return self._seen[self._lottery.draw(random)]


def drawing_weights(clips: Sequence[str]) -> list[float]:
    """How often each vehicle is drawn, beside the others, from the names of their clips."""
    count = Counter(clips)
    return [min(1.0, math.sqrt(ENOUGH_OF_A_CLIP / count[clip])) for clip in clips]


def with_lamps(seen: Seen, random: np.random.Generator) -> Seen:
    """Both tail lamps shine, and perhaps the third brake lamp."""
    middle, bottom, width, height = seen.standing
    row, aside = bottom - height * random.uniform(0.35, 0.7), width * random.uniform(0.36, 0.46)
    radius, colour = width * random.uniform(0.03, 0.1), lamp_colour(random)
    picture = seen.picture
    for column in (middle - aside, middle + aside):
        picture = with_glow(picture, column, row, radius, colour)
    if random.uniform() < 0.4:
        row = bottom - height * random.uniform(0.6, 0.95)
        picture = with_glow(picture, middle, row, 0.6 * radius, colour)
    return Seen(picture, seen.standing)


def lamp_colour(random: np.random.Generator) -> NDArray[np.float32]:
    """(3,) BGR of a red lamp, more than white where it dazzles."""
    return np.array([random.uniform(0.1, 0.5), random.uniform(0.05, 0.4), 1.0], np.float32) * random.uniform(
        90, 300
    )


def with_glow(
    picture: NDArray[np.uint8], column: float, row: float, radius: float, colour: NDArray[np.float32]
) -> NDArray[np.uint8]:
    """A light in the picture, of a Gaussian's shape."""
    height, width = picture.shape[:2]
    down, right = (
        np.exp(-((np.arange(n) - at) ** 2) / (2 * radius**2)) for n, at in ((height, row), (width, column))
    )
    light = np.outer(down, right).astype(np.float32)
    return np.clip(picture + light[..., None] * colour, 0, 255).astype(np.uint8)


def hidden_by(other: Seen, seen: Seen, part: float, random: np.random.Generator) -> Seen:
    """Another vehicle in front, hiding so much of the width from one side. The box stays the whole one."""
    scale = np.exp(random.uniform(-0.1, 0.35))
    size = (STORED_PX, STORED_PX)
    width, height = scale * other.standing.width, scale * other.standing.height
    middle, bottom, own_width, own_height = seen.standing
    side = random.choice([-1, 1])
    shift = side * (own_width / 2 + width / 2 - part * own_width)
    down = random.uniform(0.0, 0.25) * own_height
    to_place = np.array(
        [
            [scale, 0.0, middle + shift - scale * other.standing.middle],
            [0.0, scale, bottom + down - scale * other.standing.bottom],
        ]
    )
    placed = cv2.warpAffine(other.picture, to_place, size, borderMode=cv2.BORDER_REPLICATE)
    mask = np.zeros(size, np.float32)
    left, top = middle + shift - width / 2, bottom + down - height
    cv2.rectangle(mask, _point(left, top), _point(left + width, top + height), 1.0, cv2.FILLED)
    mask = np.asarray(cv2.GaussianBlur(mask, (0, 0), 1.0))[..., None]
    return Seen((seen.picture * (1 - mask) + placed * mask).astype(np.uint8), seen.standing)


def cut_at_side(seen: Seen, part: float, left: bool) -> Seen:
    """The picture ends within the vehicle; the box is what is left of it."""
    middle, bottom, width, height = seen.standing
    picture = seen.picture.copy()
    edge = int(middle + (part - 0.5) * width * (1 if left else -1))
    if left:
        picture[:, :edge] = picture[:, edge : edge + 1]
    else:
        picture[:, edge + 1 :] = picture[:, edge : edge + 1]
    shift = part * width / 2 * (1 if left else -1)
    return Seen(picture, Standing(middle + shift, bottom, width * (1 - part), height))


def cut_at_bottom(seen: Seen, part: float, random: np.random.Generator) -> Seen:
    """The picture, or the own bonnet, ends above the tyres; the box is what is left."""
    middle, bottom, width, height = seen.standing
    picture, row = seen.picture.copy(), int(bottom - part * height)
    if random.uniform() < 0.5:
        picture[row:] = picture[row - 1 : row]
    else:
        bonnet = picture[row:].mean(axis=(0, 1)) * random.uniform(0.2, 1.2)
        picture[row:] = np.clip(bonnet, 0, 255)
    return Seen(picture, Standing(middle, bottom - part * height, width, height * (1 - part)))


def _point(x: float, y: float) -> tuple[int, int]:
    return round(x), round(y)
