"""From the windows that pass the scoring stages to vehicles: placing, suppression."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.detection.box_regression import regressed_boxes
from fcw.detection.model import Model
from fcw.detection.scanner import Proposals, cut_to_picture
from fcw.detection.suppression import merge, suppress
from fcw.sources.frame import ImageSize

UNDECIDED_SCORE = 0.0
"""Where the trees find vehicle and background alike: windows above it have a say in the box."""
LONE_WEIGHT = 1e-9
"""A kept window that is not above it stands for itself."""
AGREEING_IOU = 0.5
"""A window this near to the best one shows the same vehicle in the same place."""


@dataclass(frozen=True, slots=True, eq=False)
class Vehicles:
    """What is left of a picture's windows, best score first.

    Attributes:
        boxes: (N, 4) float64, x, y, w, h, cut to the picture.
        scores: (N,) float64, of all stages.
        windows: (N,) which of the proposals each is.
    """

    boxes: NDArray[np.float64]
    scores: NDArray[np.float64]
    windows: NDArray[np.int64]


class LaterStages:
    """A model's stages after the scores; without a regressor, suppression and box voting alone."""

    def __init__(self, model: Model) -> None:
        self._regressor = model.regressor
        self._two_scores = model.second is not None
        self.need_features = model.regressor is not None

    def gate(self, score_threshold: float) -> float:
        """Score from which windows matter for vehicles of a final score.

        Others have no say in a box, and suppress only what is worse than they.
        """
        return min(score_threshold, UNDECIDED_SCORE)

    def vehicles(self, proposals: Proposals, largest_overlap: float, size: ImageSize) -> Vehicles:
        """Keep the best of those that overlap, and place their boxes.

        A box is the mean of the windows that agree with the best one (box voting), each where the regressor
        puts it; boxes that then overlap too much are suppressed once more.
        """
        scores = proposals.scores.astype(np.float64)
        if self._two_scores:
            assert proposals.second_scores is not None
            scores += proposals.second_scores
        kept = suppress(proposals.boxes, scores, largest_overlap)
        weights = np.maximum(scores - UNDECIDED_SCORE, 0.0) ** 2  # squares: the surest windows stand best
        weights[kept] = np.maximum(weights[kept], LONE_WEIGHT)
        boxes = proposals.boxes
        if self._regressor and len(scores):
            assert proposals.features is not None
            boxes = regressed_boxes(self._regressor, proposals.features, proposals.placements)
        boxes = cut_to_picture(merge(boxes, proposals.boxes, weights, kept, AGREEING_IOU), size)
        scores = scores[kept]
        if self._regressor:
            again = suppress(boxes, scores, largest_overlap)
            boxes, scores, kept = boxes[again], scores[again], kept[again]
        return Vehicles(boxes, scores, kept)
