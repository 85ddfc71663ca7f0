"""Which of the cascade's windows are looked at."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.detection.acf import AcfSettings
from fcw.detection.model import Model
from fcw.detection.scanner import Scanner
from fcw.detection.windows.plan import DistancePrior, prior_levels
from fcw.kernels.jit import kernel


@dataclass(frozen=True, slots=True)
class ProposalSettings:
    """What is proposed.

    Attributes:
        search: where windows are looked at.
        size_parts: sizes, as parts of the picture's height, that part far vehicles from near ones.
        counts: most windows of each class of size: large ones have places of their own, for small are many.
        lowest_scores: of the cascade, for each class of size; a window is dropped as soon as it falls below,
            unless the model drops it sooner. Chosen on cameras left out, where these find what the -1.5 of
            training for all does; with -0.5 for all, vehicles from 20 % of the picture's height on were found
            less often, 0.78 for 0.81 at 0.1 false positives a picture.
        largest_iou: windows that overlap more show the same. Not the overlap of the smaller one: a
            tail lamp that the cascade likes must not hide the car around it.
    """

    search: AcfSettings = AcfSettings(nearest_m=3.0)  # noqa: RUF009 - frozen
    size_parts: tuple[float, ...] = (0.12,)
    counts: tuple[int, ...] = (64, 24)
    lowest_scores: tuple[float, ...] = (-0.5, -1.5)
    largest_iou: float = 0.6


class Proposer:
    """The windows of a picture that are worth a second look. Owns memory: use one for each thread.

    Raises:
        UserError: by the calibration the road is not in the picture.
    """

    def __init__(
        self, model: Model, calibration: Calibration, settings: ProposalSettings = ProposalSettings()
    ) -> None:
        self._settings = settings
        search = settings.search
        prior = DistancePrior(
            calibration.camera,
            model.statistics,
            search.nearest_m,
            search.farthest_m,
            search.pitch_tolerance_rad,
        )
        size = calibration.image_size
        levels = prior_levels(size, model.window, prior, search.scales_per_octave, search.largest_scale)
        cascade, place = replace(model, second=None, regressor=None), np.empty(0, np.int64)
        sizes = [level.vehicles(model.window, place, place)[2] / size.height for level in levels]
        lowest = np.maximum(settings.lowest_scores, model.rejection_threshold)
        rejections = lowest[_classes(np.array(sizes), settings.size_parts)]
        self._scanner = Scanner(cascade, size, levels, prior.aspect_ratios, rejections.tolist())

    @property
    def windows_per_frame(self) -> int:
        """Number of windows that the cascade looks at in each picture."""
        return self._scanner.windows_per_frame

    def propose(self, picture: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        """(N, 3) placements (middle, bottom and sqrt(w h) of the vehicles expected) and (N,) scores."""
        settings = self._settings
        found = self._scanner.find(picture, min(settings.lowest_scores))
        chosen = choose(
            found.boxes,
            found.placements[:, 2] / len(picture),
            settings.size_parts,
            settings.counts,
            settings.largest_iou,
        )
        return found.placements[chosen], found.scores[chosen]


def choose(
    boxes: NDArray[np.float64],
    sizes: NDArray[np.float64],
    edges: tuple[float, ...],
    counts: tuple[int, ...],
    largest_iou: float,
) -> NDArray[np.int64]:
    """Greedily, best first, which boxes overlap with none chosen before.

    Args:
        boxes: (N, 4) in the order of their scores.
        sizes: (N,) of their windows.
        edges: between classes of size, rising.
        counts: most of each class, one more than edges.
        largest_iou: with any other that is chosen.

    Returns:
        Indices, in the same order.
    """
    classes = _classes(sizes, edges)
    places = np.array(counts)
    chosen = np.empty(places.sum(), np.int64)
    return chosen[: _choose(boxes, classes, places, largest_iou, chosen)]


def _classes(sizes: NDArray[np.float64], edges: tuple[float, ...]) -> NDArray[np.int64]:
    return np.searchsorted(np.array(edges), sizes, side="right")


@kernel()
def _choose(
    boxes: NDArray[np.float64],
    classes: NDArray[np.int64],
    places: NDArray[np.int64],
    largest_iou: float,
    chosen: NDArray[np.int64],
) -> int:
    count = 0
    for i in range(len(boxes)):
        if places[classes[i]] == 0:
            continue
        alone = True
        area = boxes[i, 2] * boxes[i, 3]
        for k in range(count):
            j = chosen[k]
            width = min(boxes[i, 0] + boxes[i, 2], boxes[j, 0] + boxes[j, 2]) - max(boxes[i, 0], boxes[j, 0])
            height = min(boxes[i, 1] + boxes[i, 3], boxes[j, 1] + boxes[j, 3]) - max(boxes[i, 1], boxes[j, 1])
            common = max(width, 0.0) * max(height, 0.0)
            if common > largest_iou * (area + boxes[j, 2] * boxes[j, 3] - common):
                alone = False
                break
        if alone:
            chosen[count] = i
            count += 1
            places[classes[i]] -= 1
            if count == len(chosen):
                break
    return count
