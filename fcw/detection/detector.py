"""The seam for detectors: what each is asked, and what it gives."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box


@dataclass(frozen=True, slots=True)
class Detection:
    """A vehicle seen from behind.

    Attributes:
        box: in the picture.
        score: the detector's, higher is surer.
        faint: its score is too low to take it for a vehicle by itself, but it may be one that is followed
            already. Only detectors made for a tracker give such boxes.
    """

    box: Box
    score: float
    faint: bool = False


@dataclass(frozen=True, slots=True)
class Aim:
    """Where vehicles are looked for.

    Attributes:
        pitch_rad: of the camera's axis below the road, as it is believed now.
        tolerance_rad: it may be off by so much either way.
    """

    pitch_rad: float
    tolerance_rad: float


class Detector(Protocol):
    """Finds vehicles in one picture. An instance owns scratch memory: use one for each thread."""

    @property
    def name(self) -> str:
        """Name on the command line and in logs, e.g. `acf`."""
        ...

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first.

        In a drive the picture is read-only: a detector that draws or scales in place works on a copy. There
        numbers that are not finite, and boxes without a size, end the drive with a message.
        """
        ...


@runtime_checkable
class WindowDetector(Detector, Protocol):
    """A detector that looks at windows one by one."""

    @property
    def windows_per_frame(self) -> int:
        """How many it looks at in a picture."""
        ...


@runtime_checkable
class AimedDetector(Detector, Protocol):
    """A detector that looks where a calibration says that vehicles can be.

    A tolerance in its own settings is the least that it looks with.
    """

    def aim(self, aim: Aim) -> None:
        """Look there from now on.

        Raises:
            UserError: the road would not be in the picture; it looks where it did.
        """
        ...
