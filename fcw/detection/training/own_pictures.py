"""Whether a model finds anything at all of what it learnt from."""

from collections.abc import Sequence

import numpy as np

from fcw.detection.choice import DetectorModel, make_detector
from fcw.detection.detector import Detector
from fcw.detection.training.dataset import TrainingImage
from fcw.detection.training.settings import Progress

MOST_PICTURES = 100
"""A model of any use finds a vehicle in these, and they take some seconds."""


def found_of_own(
    name: str, model: DetectorModel, images: Sequence[TrainingImage], progress: Progress
) -> tuple[int, int]:
    """How many vehicles a model finds in pictures that it learnt from, and how many are labelled in them.

    Args:
        name: of its detector.
        model: what was learnt.
        images: all that it learnt from; some of those with vehicles are looked at, spread over all.
        progress: who is told.
    """
    shown = [image for image in images if not image.labelled.ignored.all()]
    shown = shown[:: -(-len(shown) // MOST_PICTURES) or 1]
    progress.stage("looking at its own pictures", len(shown))
    detectors: dict[int, Detector] = {}  # pictures of a clip have one calibration
    found = vehicles = 0
    for image in shown:
        if id(image.calibration) not in detectors:
            detectors[id(image.calibration)] = make_detector(name, model, image.calibration)
        detections = detectors[id(image.calibration)].detect(image.labelled.read())
        boxes = np.array([(d.box.x, d.box.y, d.box.w, d.box.h) for d in detections]).reshape(-1, 4)
        scores = np.array([detection.score for detection in detections])
        found += int(np.count_nonzero(image.labelled.with_detections(boxes, scores).matches() >= 0))
        vehicles += int(np.count_nonzero(~image.labelled.ignored))
        progress.advance()
    return found, vehicles
