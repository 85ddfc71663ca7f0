"""Training: boosted trees with rounds of hard negatives, and thresholds from held-out pictures.

Each round boosts a longer sequence of trees against the false positives of the round before, found by the
very scanning that the detector does. Nothing is measured on the pictures that were trained on: the score
threshold and the cascade's come from models that had not seen the pictures they were applied to.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.detection.acf import AcfSettings
from fcw.detection.later_stages import LaterStages
from fcw.detection.matching import (
    FALSE_POSITIVE,
    DetectionCurve,
    LabelledDetections,
    OperatingPoint,
    detection_curve,
)
from fcw.detection.model import Model
from fcw.detection.training.checkpoints import Checkpoints
from fcw.detection.training.dataset import TrainingImage, background
from fcw.detection.training.fitting import Fitter
from fcw.detection.training.mining import Detectors
from fcw.detection.training.settings import Progress, TrainingSettings
from fcw.detection.trees.boosting import running_scores
from fcw.detection.windows.statistics import vehicle_statistics
from fcw.errors import UserError

__all__ = ["Progress", "TrainingResult", "TrainingSettings", "train"]


@dataclass(frozen=True, slots=True, eq=False)
class TrainingResult:
    """A trained model and what it did on held-out pictures.

    Attributes:
        model: trained on all pictures.
        held_out: detection rate against false positives of models trained without the pictures they saw.
        operating_point: at the model's score threshold.
    """

    model: Model
    held_out: DetectionCurve
    operating_point: OperatingPoint


def train(
    images: Sequence[TrainingImage],
    settings: TrainingSettings,
    progress: Progress,
    folder: Path | None = None,
) -> TrainingResult:
    """Train a model.

    The pictures, in the order of clip and file, are cut into `folds` runs; neighbours in a drive are held
    out together. A model is trained for each fold, the thresholds follow from their detections, and then the
    model of all pictures is trained.

    Args:
        images: what to learn from.
        settings: how.
        progress: who is told.
        folder: where finished stages are kept until the end, so that a killed training goes on; or None.

    Raises:
        UserError: too few pictures, or without a fold none holds a vehicle that counts, or background.
    """
    if len(images) < settings.folds:
        raise UserError(f"{len(images)} labelled pictures; expected at least {settings.folds}: label more")
    images = sorted(images, key=lambda image: (image.labelled.clip, str(image.labelled.path)))
    try:
        statistics = vehicle_statistics(images)
    except ValueError as error:
        raise UserError(f"{error}; check the calibrations that lie beside the labels") from None
    fold_of = np.arange(len(images)) * settings.folds // len(images)
    _check_folds(images, fold_of)
    checkpoints = Checkpoints(folder, repr(settings) + "".join(map(_identity, images)))
    fitter = Fitter(images, statistics, settings, progress, checkpoints)
    held_out = _HeldOut(fitter, fold_of)
    for fold in range(settings.folds):
        model = fitter.fit(np.flatnonzero(fold_of != fold), f"fold {fold + 1}")
        model = replace(model, rejection_threshold=settings.lowest_rejection_threshold)
        held_out.add(fold, model)
    curve = detection_curve(held_out.results)
    point = curve.at_threshold(_score_threshold(held_out.results, settings))
    progress.note(
        f"held out: detection rate {point.detection_rate:.3f}, {point.fppi:.3f} false positives per picture "
        f"(on background at most {settings.fppi:g} were allowed); score threshold {point.threshold:.2f}",
        detection_rate=point.detection_rate,
        fppi=point.fppi,
        score_threshold=point.threshold,
    )
    model = fitter.fit(np.arange(len(images)), "all pictures")
    assert model.regressor is not None
    bottom = _bottom(held_out.results, point.threshold)
    model = replace(
        model,
        regressor=replace(model.regressor, bottom=bottom),
        score_threshold=point.threshold,
        first_stage_threshold=_score_threshold(held_out.plain, settings),
        rejection_threshold=_rejection_threshold(held_out, point.threshold, settings),
    )
    progress.note(
        f"the cascade's rejection threshold {model.rejection_threshold:.1f}; bottom edges are "
        f"{bottom:.4f} sizes lower than windows have them",
        rejection_threshold=model.rejection_threshold,
        bottom=bottom,
    )
    return TrainingResult(model, curve, point)


def _check_folds(images: Sequence[TrainingImage], fold_of: NDArray[np.int64]) -> None:
    """See that without any fold there are vehicles to learn, and pictures whose rest is background.

    Raises:
        UserError: there are not.
    """
    for fold in np.unique(fold_of):
        held, rest = (
            [image.labelled for image, of in zip(images, fold_of, strict=True) if (of == fold) == is_held]
            for is_held in (True, False)
        )
        if all(labelled.ignored.all() for labelled in rest):
            missing = "vehicle that counts"
        elif not any(labelled.complete for labelled in rest):
            missing = "picture in which every vehicle is labelled"
        else:
            continue
        raise UserError(
            f"{held[0].path}: without this picture and the next {len(held) - 1}, held out to choose "
            f"thresholds, no {missing} is left to learn from; label more pictures, of several drives"
        )


def _identity(image: TrainingImage) -> str:
    """What a picture's part in training depends on."""
    labelled = image.labelled
    stat = labelled.path.stat() if labelled.path.exists() else None
    return repr(
        (
            str(labelled.path),
            stat and (stat.st_size, stat.st_mtime_ns),
            labelled.boxes.tolist(),
            labelled.ignored.tolist(),
            labelled.rear_boxes.tolist(),
            labelled.complete,
            image.calibration.camera,
        )
    )


class _HeldOut:
    """Detections in pictures that the models had not seen, in the pictures' order."""

    def __init__(self, fitter: Fitter, fold_of: NDArray[np.int64]) -> None:
        self._fitter, self._fold_of = fitter, fold_of
        self.results: list[LabelledDetections] = []
        self.plain: list[LabelledDetections] = []
        """Those of the cascade alone."""
        self.lows: list[NDArray[np.float32]] = []
        """Lowest running score that each of the results' windows had in the cascade."""

    def add(self, fold: int, model: Model) -> None:
        """Detections of a fold's model."""
        members = np.flatnonzero(self._fold_of == fold)
        progress = self._fitter.progress
        progress.stage(f"fold {fold + 1}: detecting", len(members))
        detectors = Detectors(model, AcfSettings())
        for index in members:
            image = self._fitter.images[int(index)]
            proposals = detectors.prior(image).scan(image.labelled.read(), -np.inf, with_features=True)
            vehicles, plain = (
                LaterStages(stages).vehicles(proposals, AcfSettings().largest_overlap, image.labelled.size)
                for stages in (model, model.plain())
            )
            assert proposals.features is not None
            running = running_scores(model.trees, proposals.features[vehicles.windows])
            self.lows.append(running.min(axis=1, initial=np.inf))
            for found, results in ((vehicles, self.results), (plain, self.plain)):
                results.append(image.labelled.with_detections(found.boxes, found.scores))
            progress.advance()


def _score_threshold(results: Sequence[LabelledDetections], settings: TrainingSettings) -> float:
    """The lowest score with no more detections of background per held-out picture than wanted.

    Pictures in which not every vehicle is labelled do not count.

    A box badly placed on a vehicle is not counted here, though it is a false positive in evaluation: most
    of the surest such false positives are vans and three-quarter views whose shape is not the usual one, and
    a threshold above them would lose many vehicles and spare nobody a false alarm.
    """
    complete = [result for result in results if result.complete]
    false = [
        result.scores[background(result.detections, result.labels, result.ignored, result.rear_boxes)]
        for result in complete
    ]
    scores = np.sort(np.concatenate([np.zeros(0), *false]))[::-1]
    allowed = int(settings.fppi * len(complete))
    if len(scores) <= allowed:
        return settings.lowest_rejection_threshold
    return float(np.nextafter(scores[allowed], np.inf))


def _bottom(results: Sequence[LabelledDetections], score_threshold: float) -> float:
    """Median of how much lower than found the vehicles' bottom edges are, in sizes; 0 where none is found."""
    lower = []
    for result in results:
        matches = np.where(result.scores >= score_threshold, result.matches(), FALSE_POSITIVE)
        found, labels = result.detections[matches >= 0], result.labels[matches[matches >= 0]]
        sizes = np.sqrt(np.prod(labels[:, 2:], axis=1))
        lower.append(((labels[:, 1] + labels[:, 3]) - (found[:, 1] + found[:, 3])) / sizes)
    together = np.concatenate(lower)
    return float(np.median(together)) if len(together) else 0.0


def _rejection_threshold(held_out: _HeldOut, score_threshold: float, settings: TrainingSettings) -> float:
    """The highest cascade threshold, in tenths, that loses no held-out hit above the score threshold."""
    lowest = [
        low[(result.matches() >= 0) & (result.scores >= score_threshold)]
        for result, low in zip(held_out.results, held_out.lows, strict=True)
    ]
    least = np.concatenate(lowest).min(initial=0.0)
    return float(max(np.floor(10.0 * least) / 10.0, settings.lowest_rejection_threshold))
