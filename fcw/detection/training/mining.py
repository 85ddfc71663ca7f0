"""Hard negatives: what a detector in training puts out where no vehicle is."""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.acf import AcfDetector, AcfSettings, FullAcfDetector, Proposals
from fcw.detection.boxes.suppression import suppress
from fcw.detection.model import Model
from fcw.detection.training.dataset import TrainingImage, without_vehicle_in_place
from fcw.errors import UserError


class Detectors:
    """A model's detectors: the distance-prior one for each calibration, and that of whole pictures."""

    def __init__(self, model: Model, search: AcfSettings) -> None:
        self._model, self._search = model, search
        self._prior: dict[int, AcfDetector] = {}
        self.full = FullAcfDetector(model)

    def prior(self, image: TrainingImage) -> AcfDetector:
        """The distance-prior detector for a picture's camera.

        Raises:
            UserError: by the picture's calibration the road is not in it.
        """
        key = id(image.calibration)
        if key not in self._prior:
            try:
                self._prior[key] = AcfDetector(self._model, image.calibration, self._search)
            except UserError as error:  # which of many clips it is
                raise UserError(f"{image.labelled.path}: {error}") from None
        return self._prior[key]


def false_positives(
    proposals: Proposals,
    labels: NDArray[np.float64],
    ignored: NDArray[np.bool_],
    rear_boxes: NDArray[np.float64],
    count: int,
) -> list[tuple[float, NDArray[np.uint8]]]:
    """Score and features of a picture's surest windows of background.

    Suppression comes first: a window beside a vehicle that a surer one on it suppresses is no false positive.

    Args:
        proposals: with features.
        labels: (N, 4) labelled boxes of the picture.
        ignored: (N,) the ignored ones among them.
        rear_boxes: (N, 4) their rear faces, NaN in the rows of those that have none.
        count: how many at most.

    Raises:
        ValueError: the proposals were made without features.
    """
    if proposals.features is None:
        raise ValueError("mining needs proposals with features")
    kept = suppress(proposals.boxes, proposals.scores, AcfSettings().largest_overlap)
    kept = kept[without_vehicle_in_place(proposals.boxes[kept], labels, ignored, rear_boxes)]
    return [(float(proposals.scores[i]), proposals.features[i].copy()) for i in kept[:count]]
