"""The two detectors: ACF with the distance prior, and plain ACF over the whole picture as the baseline.

Both run the same channels, trees and cascade; they differ in the windows they look at.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.detection.later_stages import LaterStages, Vehicles
from fcw.detection.model import Model
from fcw.detection.scanner import Proposals, Scanner
from fcw.detection.types import Box, Detection
from fcw.detection.windows import DistancePrior, full_levels, prior_levels
from fcw.errors import UserError
from fcw.sources.frame import ImageSize

__all__ = ["AcfDetector", "AcfSettings", "FullAcfDetector", "FullAcfSettings", "Proposals"]


@dataclass(frozen=True, slots=True)
class AcfSettings:
    """What the distance-prior detector searches.

    Attributes:
        nearest_m: nearest vehicles looked for, from the camera.
        farthest_m: farthest vehicles looked for.
        pitch_tolerance_rad: braking, bumps and grades tilt the view by so much either way.
        scales_per_octave: window sizes for each doubling.
        largest_scale: how far the picture is enlarged for far vehicles, 1 to under 4.
        largest_overlap: of two boxes overlapping more (intersection over the smaller area) the better stays.
        score_threshold: score from which a window counts as a vehicle; None: the model's.
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
    An instance owns scratch memory: use one for each thread.

    Raises:
        UserError: by the calibration the road is not in the picture.
    """

    def __init__(
        self,
        model: Model,
        calibration: Calibration,
        settings: AcfSettings = AcfSettings(),
    ) -> None:
        self._model, self._settings = model, settings
        self._stages = LaterStages(model)
        self._prior = DistancePrior(
            calibration.camera,
            model.statistics,
            settings.nearest_m,
            settings.farthest_m,
            settings.pitch_tolerance_rad,
        )
        self.levels = prior_levels(
            calibration.image_size,
            model.window,
            self._prior,
            settings.scales_per_octave,
            settings.largest_scale,
        )
        if not self.levels:
            raise UserError(
                f"the calibration has its horizon in row {calibration.horizon_row_px:.0f} of pictures of "
                f"{calibration.image_size}: no vehicle {settings.nearest_m:g} to {settings.farthest_m:g} m "
                "away can be in them; calibrate again with points on the road ahead"
            )
        self._scanner = Scanner(model, calibration.image_size, self.levels)

    @property
    def name(self) -> str:
        """`acf`."""
        return "acf"

    @property
    def windows_per_frame(self) -> int:
        """Number of windows looked at in each picture."""
        return self._scanner.windows_per_frame

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first.

        Raises:
            ValueError: the picture has another size than the calibration.
        """
        threshold = _score_threshold(self._settings.score_threshold, self._model)
        proposals = self.scan(image, self._stages.gate(threshold), self._stages.need_features)
        vehicles = self._stages.vehicles(proposals, self._settings.largest_overlap, _size(image))
        return _detections(vehicles, threshold)

    def scan(self, image: NDArray[np.uint8], threshold: float, with_features: bool = False) -> Proposals:
        """All windows that pass the cascade with a score of at least `threshold`, as training mines them.

        Raises:
            ValueError: the picture has another size than the calibration.
        """
        _check(image, self._scanner.size)
        return self._scanner.scan(image, threshold, self._prior.aspect_ratios, with_features)


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

    Takes pictures of any size, and plans anew when it changes. An instance owns scratch memory: use one for
    each thread.
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
        """Number of windows looked at in each picture of the last size; 0 before the first."""
        return self._scanner.windows_per_frame if self._scanner else 0

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first."""
        threshold = _score_threshold(self._settings.score_threshold, self._model)
        proposals = self.scan(image, self._stages.gate(threshold), self._stages.need_features)
        vehicles = self._stages.vehicles(proposals, self._settings.largest_overlap, _size(image))
        return _detections(vehicles, threshold)

    def scan(self, image: NDArray[np.uint8], threshold: float, with_features: bool = False) -> Proposals:
        """All windows that pass the cascade with a score of at least `threshold`."""
        size = _size(image)
        if self._scanner is None or self._scanner.size != size:
            levels = full_levels(
                size, self._model.window, self._settings.scales_per_octave, self._settings.largest_scale
            )
            self._scanner = Scanner(self._model, size, levels)
        _check(image, size)
        return self._scanner.scan(
            image, threshold, lambda bottoms: np.full(len(bottoms), self._aspect_ratio), with_features
        )


def _score_threshold(setting: float | None, model: Model) -> float:
    return model.score_threshold if setting is None else setting


def _check(image: NDArray[np.uint8], size: ImageSize) -> None:
    if image.shape != (size.height, size.width, 3) or image.dtype != np.uint8:
        raise ValueError(
            f"the detector expects uint8 BGR pictures of {size}, got {image.dtype} of shape {image.shape}"
        )


def _size(image: NDArray[np.uint8]) -> ImageSize:
    return ImageSize(image.shape[1], image.shape[0])


def _detections(vehicles: Vehicles, threshold: float) -> tuple[Detection, ...]:
    return tuple(
        Detection(Box(*map(float, box)), float(score))
        for box, score in zip(vehicles.boxes, vehicles.scores, strict=True)
        if score >= threshold
    )
