"""Runs detectors over labelled pictures side by side, and measures the time of each."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.detection.choice import DetectorModel, make_detector
from fcw.detection.detector import Detector, WindowDetector
from fcw.detection.training.dataset import LabelledImage
from fcw.errors import UserError
from fcw.evaluation.detection.labels import AnnotatedImage

EVERY_SCORE = float("-inf")
"""With this threshold a detector gives everything that passes its cascade, and so the whole curve."""

DetectorOf = Callable[[LabelledImage], Detector]
CalibrationOf = Callable[[LabelledImage], Calibration]


class FrameDetections(NamedTuple):
    """What a detector found in one picture.

    Attributes:
        boxes: (D, 4) x, y, w, h, sorted by falling score.
        scores: (D,) scores.
        milliseconds: time of its thread for this picture.
        windows: number of windows searched; None if the detector does not tell.
    """

    boxes: NDArray[np.float64]
    scores: NDArray[np.float64]
    milliseconds: float
    windows: int | None


@dataclass(frozen=True, slots=True)
class DetectorCase:
    """A detector to measure.

    Attributes:
        name: `acf`, `acf-full`, `net` or `onnx:FILE`.
        model: its model.
        score_threshold: least score of a box that counts; None for the model's own.
        largest_scale: how much pictures are enlarged; None for the detector's own.
    """

    name: str
    model: DetectorModel
    score_threshold: float | None = None
    largest_scale: float | None = None

    def detector_of(self, calibration_of: CalibrationOf) -> DetectorOf:
        """A function from a picture to its detector.

        The detector stays the same while the clip and the size of the pictures do. Only the latest one is
        kept, because it takes tens of megabytes, and there may be thousands of clips.
        """
        last: tuple[object, Detector] | None = None

        def detector_of(image: LabelledImage) -> Detector:
            nonlocal last
            key = image.clip, image.size
            if last is None or last[0] != key:
                last = None  # before the next one is made
                calibration = calibration_of(image)
                model, threshold, scale = self.model, self.score_threshold, self.largest_scale
                try:
                    last = key, make_detector(self.name, model, calibration, threshold, scale)
                except UserError as error:  # which of many clips it is
                    raise UserError(f"{image.path}: {error}") from None
            return last[1]

        return detector_of


def run_detectors(
    images: Sequence[AnnotatedImage],
    detectors: Mapping[str, DetectorOf],
    advance: Callable[[], None] = lambda: None,
) -> dict[str, tuple[FrameDetections, ...]]:
    """Run several detectors over the same pictures, taking turns after each picture.

    So a busy machine slows all of them alike. Only the time of the thread itself counts, not that of other
    threads which run in between.

    Args:
        images: the pictures.
        detectors: by name, functions that give the detector for a picture.
        advance: called after each picture.

    Returns:
        What was found in each picture, by the same names.

    Raises:
        UserError: a picture cannot be read, or has no calibration.
    """
    found: dict[str, list[FrameDetections | None]] = {name: [None] * len(images) for name in detectors}
    started: dict[str, Detector] = {}
    clips: dict[object, list[int]] = {}
    for index, image in enumerate(images):
        clips.setdefault((image.labelled.clip, image.labelled.size), []).append(index)
    for index in chain.from_iterable(clips.values()):
        image = images[index].labelled
        pixels = image.read()
        for name, detector_of in detectors.items():
            detector = detector_of(image)
            if (
                started.get(name) is not detector
            ):  # compiling and first allocations are not what a frame takes
                detector.detect(pixels)
                started[name] = detector
            found[name][index] = _detect(detector, pixels)
        advance()
    return {name: tuple(frame for frame in frames if frame is not None) for name, frames in found.items()}


def median_milliseconds(frames: Sequence[FrameDetections]) -> float:
    """Median time of a picture."""
    return float(np.median([frame.milliseconds for frame in frames]))


def mean_windows(frames: Sequence[FrameDetections]) -> float | None:
    """Mean number of windows searched in a picture; None if the detector does not tell."""
    counts = [frame.windows for frame in frames if frame.windows is not None]
    return float(np.mean(counts)) if counts else None


def _detect(detector: Detector, pixels: NDArray[np.uint8]) -> FrameDetections:
    start_s = time.thread_time()
    found = detector.detect(pixels)
    milliseconds = 1e3 * (time.thread_time() - start_s)
    boxes = np.array([(d.box.x, d.box.y, d.box.w, d.box.h) for d in found], np.float64).reshape(-1, 4)
    scores = np.array([d.score for d in found], np.float64)
    windows = detector.windows_per_frame if isinstance(detector, WindowDetector) else None
    return FrameDetections(boxes, scores, milliseconds, windows)
