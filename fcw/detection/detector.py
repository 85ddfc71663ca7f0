"""The seam for detectors: what each is asked, and what it gives."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box


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
