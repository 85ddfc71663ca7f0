"""The protocols that detectors implement, and the detections that they return."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box


@dataclass(frozen=True, slots=True)
class Detection:
    """A vehicle seen from behind.

    Attributes:
        box: bounding box in the picture.
        score: the detector's score; higher is more certain.
        faint: whether the score is too low for a new vehicle, but may support one that is already tracked.
            Only detectors made for a tracker return such boxes.
    """

    box: Box
    score: float
    faint: bool = False


@dataclass(frozen=True, slots=True)
class Aim:
    """Where vehicles are looked for.

    Attributes:
        pitch_rad: estimated angle of the camera's axis below the road.
        tolerance_rad: largest error of `pitch_rad` in either direction.
    """

    pitch_rad: float
    tolerance_rad: float


class Detector(Protocol):
    """Finds vehicles in one picture. An instance owns working memory, so each thread needs its own."""

    @property
    def name(self) -> str:
        """Name on the command line and in logs, e.g. `acf`."""
        ...

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first.

        In a drive the picture is read-only, so a detector that modifies it must work on a copy. Numbers that
        are not finite, and boxes without a size, end the drive with a message.
        """
        ...


@runtime_checkable
class WindowDetector(Detector, Protocol):
    """A detector that classifies windows one by one."""

    @property
    def windows_per_frame(self) -> int:
        """Number of windows in a picture."""
        ...


@runtime_checkable
class AimedDetector(Detector, Protocol):
    """A detector that only looks where vehicles can be according to a calibration.

    A tolerance in its own settings is the least that it uses.
    """

    def aim(self, aim: Aim) -> None:
        """Change where the detector looks.

        Raises:
            UserError: the road would not be in the picture; the detector keeps its last aim.
        """
        ...
