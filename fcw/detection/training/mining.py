"""Hard negatives: what a detector in training puts out where no vehicle is."""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.acf import AcfDetector, AcfSettings, FullAcfDetector, Proposals
from fcw.detection.boxes.suppression import suppress
from fcw.detection.model import Model
from fcw.detection.training.dataset import TrainingImage, without_vehicle_in_place


class Detectors:
    """A model's detectors: the distance-prior one for each calibration, and that of whole pictures."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._prior: dict[int, AcfDetector] = {}
        self.full = FullAcfDetector(model)

    def prior(self, image: TrainingImage) -> AcfDetector:
        """The distance-prior detector for a picture's camera."""
        key = id(image.calibration)
        if key not in self._prior:
            self._prior[key] = AcfDetector(self._model, image.calibration)
        return self._prior[key]


def false_positives(
    proposals: Proposals, labels: NDArray[np.float64], ignored: NDArray[np.bool_], count: int
) -> list[tuple[float, NDArray[np.uint8]]]:
    """Score and features of a picture's surest windows of background.

    Suppression comes first: a window beside a vehicle that a surer one on it suppresses is no false positive.

    Args:
        proposals: with features.
        labels: (N, 4) labelled boxes of the picture.
        ignored: (N,) the ignored ones among them.
        count: how many at most.

    Raises:
        ValueError: the proposals were made without features.
    """
    if proposals.features is None:
        raise ValueError("mining needs proposals with features")
    kept = suppress(proposals.boxes, proposals.scores, AcfSettings().largest_overlap)
    kept = kept[without_vehicle_in_place(proposals.boxes[kept], labels, ignored)]
    return [(float(proposals.scores[i]), proposals.features[i].copy()) for i in kept[:count]]
