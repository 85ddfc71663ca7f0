"""The two detectors: ACF with the distance prior, and plain ACF over the whole picture as the baseline.

Both use the same channels, trees and cascade. They differ in the windows that they scan.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.detector import Aim, Detection
from fcw.detection.later_stages import LaterStages
from fcw.detection.model import Model
from fcw.detection.scanner import Proposals, Scanner
from fcw.detection.windows.plan import DistancePrior, full_levels, prior_levels
from fcw.frame import ImageSize

__all__ = ["AcfDetector", "AcfSettings", "FullAcfDetector", "FullAcfSettings", "Proposals"]


@dataclass(frozen=True, slots=True)
class AcfSettings:
    """What the distance-prior detector searches.

    Attributes:
        nearest_m: nearest distance at which vehicles are looked for, from the camera.
        farthest_m: farthest distance at which vehicles are looked for.
        pitch_tolerance_rad: largest change of pitch in either direction due to braking, bumps and grades.
        scales_per_octave: number of window sizes for each doubling.
        largest_scale: how far the picture is enlarged for far vehicles, 1 to under 4.
        largest_overlap: of two boxes with more overlap (intersection over the smaller area), the better is
            kept.
        score_threshold: least score of a detection; None for the model's.
    """

    nearest_m: float = 4.0
    farthest_m: float = 80.0
    pitch_tolerance_rad: float = math.radians(1.0)
    scales_per_octave: int = 4
    largest_scale: float = 2.0
    largest_overlap: float = 0.5
    score_threshold: float | None = None


class AcfDetector:
    """ACF with windows that follow from the calibration (section 3.2 of the paper).

    Scales, rows and aspect ratio of the windows come from the distance prior; see `fcw.detection.windows`.
    An instance owns working memory, so each thread needs its own.

    Raises:
        UserError: the calibration puts the road outside the picture.
    """

    def __init__(
        self,
        model: Model,
        calibration: Calibration,
        settings: AcfSettings = AcfSettings(),
    ) -> None:
        self._model, self._settings = model, settings
        self._stages = LaterStages(model)
        self._calibrated, self._size = calibration.camera, calibration.image_size
        self._aim: Aim | None = None
        self.aim(Aim(calibration.camera.pitch_rad, settings.pitch_tolerance_rad))

    @property
    def name(self) -> str:
        """`acf`."""
        return "acf"

    def aim(self, aim: Aim) -> None:
        """See `fcw.detection.detector.AimedDetector`."""
        if aim == self._aim:
            return
        model, settings, size = self._model, self._settings, self._size
        camera = replace(self._calibrated, pitch_rad=aim.pitch_rad)
        tolerance_rad = max(aim.tolerance_rad, settings.pitch_tolerance_rad)
        prior = DistancePrior(
            camera, model.statistics, settings.nearest_m, settings.farthest_m, tolerance_rad
        )
        levels = prior_levels(size, model.window, prior, settings.scales_per_octave, settings.largest_scale)
        self.levels, self._aim = levels, aim
        self._scanner = Scanner(model, size, levels, prior.aspect_ratios)

    @property
    def windows_per_frame(self) -> int:
        """Number of windows scanned in each picture."""
        return self._scanner.windows_per_frame

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first.

        Raises:
            ValueError: the picture has another size than the calibration.
        """
        threshold = _score_threshold(self._settings.score_threshold, self._model)
        _check(image, self._scanner.size)
        return _detect(self._scanner, self._stages, image, threshold, self._settings.largest_overlap)

    def scan(self, image: NDArray[np.uint8], threshold: float, with_features: bool = False) -> Proposals:
        """All windows that pass the cascade with a score of at least `threshold`, for mining in training.

        Raises:
            ValueError: the picture has another size than the calibration.
        """
        _check(image, self._scanner.size)
        return self._scanner.scan(image, threshold, with_features)


@dataclass(frozen=True, slots=True)
class FullAcfSettings:
    """What plain ACF searches; attributes as in `AcfSettings`.

    By default the picture is not enlarged, as in the paper's baseline: vehicles of 40 px and more are found.
    """

    scales_per_octave: int = 8
    largest_scale: float = 1.0
    largest_overlap: float = 0.5
    score_threshold: float | None = None


class FullAcfDetector:
    """Plain ACF: every scale over the whole picture, one aspect ratio; the paper's baseline.

    Pictures may have any size; the windows are planned anew when it changes. An instance owns working memory,
    so each thread needs its own.
    """

    def __init__(self, model: Model, settings: FullAcfSettings = FullAcfSettings()) -> None:
        self._model, self._settings = model, settings
        self._stages = LaterStages(model)
        self._aspect_ratio = float(np.median(model.statistics.aspect_ratios))
        self._scanner: Scanner | None = None

    @property
    def name(self) -> str:
        """`acf-full`."""
        return "acf-full"

    @property
    def windows_per_frame(self) -> int:
        """Number of windows scanned in a picture of the last size; 0 before the first picture."""
        return self._scanner.windows_per_frame if self._scanner else 0

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first."""
        threshold = _score_threshold(self._settings.score_threshold, self._model)
        scanner = self._scanner_for(image)
        return _detect(scanner, self._stages, image, threshold, self._settings.largest_overlap)

    def scan(self, image: NDArray[np.uint8], threshold: float, with_features: bool = False) -> Proposals:
        """All windows that pass the cascade with a score of at least `threshold`."""
        return self._scanner_for(image).scan(image, threshold, with_features)

    def _scanner_for(self, image: NDArray[np.uint8]) -> Scanner:
        """The scanner for pictures of this size."""
        size = ImageSize(image.shape[1], image.shape[0])
        _check(image, size)
        if self._scanner is None or self._scanner.size != size:
            levels = full_levels(
                size, self._model.window, self._settings.scales_per_octave, self._settings.largest_scale
            )
            self._scanner = Scanner(self._model, size, levels, self._aspect_ratios)
        return self._scanner

    def _aspect_ratios(self, bottom_rows: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.full(len(bottom_rows), self._aspect_ratio)


def _detect(
    scanner: Scanner,
    stages: LaterStages,
    image: NDArray[np.uint8],
    threshold: float,
    largest_overlap: float,
) -> tuple[Detection, ...]:
    found = scanner.find(image, stages.gate(threshold))
    vehicles = stages.find(found, largest_overlap, scanner.size, threshold)
    return tuple(
        Detection(Box(*box), score)
        for box, score in zip(vehicles.boxes.tolist(), vehicles.scores.tolist(), strict=True)
    )


def _score_threshold(setting: float | None, model: Model) -> float:
    return model.score_threshold if setting is None else setting


def _check(image: NDArray[np.uint8], size: ImageSize) -> None:
    if image.shape != (size.height, size.width, 3) or image.dtype != np.uint8:
        raise ValueError(
            f"the detector expects uint8 BGR pictures of {size}, got {image.dtype} of shape {image.shape}"
        )
