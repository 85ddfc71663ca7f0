"""Calibrations with a known error, to measure what a badly mounted or moved camera does to a detector."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from fcw.camera.calibration import Calibration
from fcw.detection.training.dataset import LabelledImage


@dataclass(frozen=True, slots=True)
class CalibrationError:
    """The error of a calibration.

    Attributes:
        pitch_rad: its pitch minus the true one.
        height_factor: its height divided by the true one; focal length and horizon stay right.
    """

    pitch_rad: float = 0.0
    height_factor: float = 1.0

    def __str__(self) -> str:
        if self.pitch_rad:
            return f"pitch {math.degrees(self.pitch_rad):+.1f} degrees"
        return f"height {self.height_factor - 1:+.0%}"

    def applied(self, calibration: Calibration) -> Calibration:
        """A calibration with this error, which is not included in its uncertainty."""
        camera = replace(
            calibration.camera,
            pitch_rad=calibration.camera.pitch_rad + self.pitch_rad,
            height_m=calibration.camera.height_m * self.height_factor,
        )
        return Calibration.from_camera(camera, calibration.image_size, calibration.reference_offset_m)

    def on(
        self, calibration_of: Callable[[LabelledImage], Calibration]
    ) -> Callable[[LabelledImage], Calibration]:
        """A function that gives the calibrations of pictures with this error."""
        return lambda image: self.applied(calibration_of(image))


CALIBRATION_ERRORS = (
    *(CalibrationError(pitch_rad=math.radians(degrees)) for degrees in (-1.0, -0.5, 0.5, 1.0)),
    *(CalibrationError(height_factor=factor) for factor in (0.9, 1.1)),
)
