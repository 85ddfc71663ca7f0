"""What a detector gives: boxes with scores."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Box:
    """An axis-aligned box in pixels: left edge x, top edge y, width w, height h.

    Edges are continuous coordinates on the grid whose origin is the centre of the top-left pixel.
    """

    x: float
    y: float
    w: float
    h: float

    @property
    def right(self) -> float:
        """Column of the right edge."""
        return self.x + self.w

    @property
    def bottom(self) -> float:
        """Row of the bottom edge: where the vehicle meets the road."""
        return self.y + self.h

    @property
    def center_x(self) -> float:
        """Column of the middle."""
        return self.x + self.w / 2


@dataclass(frozen=True, slots=True)
class Detection:
    """A vehicle seen from behind: its box and the detector's score (higher is surer)."""

    box: Box
    score: float


class Detector(Protocol):
    """Finds vehicles in one picture. An instance owns scratch memory: use one for each thread."""

    @property
    def name(self) -> str:
        """Name on the command line and in logs, e.g. `acf`."""
        ...

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first."""
        ...
