"""Training: boosted trees with rounds of hard negatives, and thresholds from held-out pictures.

Each round boosts a longer sequence of trees against the false positives of the round before, found by the
very scanning that the detector does. Nothing is measured on the pictures that were trained on: the score
threshold and the cascade's come from models that had not seen the pictures they were applied to.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fcw.detection.acf import AcfSettings
from fcw.detection.boosting import BoostingSettings, running_scores, train_trees
from fcw.detection.dataset import TrainingImage, background
from fcw.detection.mining import Detectors, false_positives
from fcw.detection.model import BoostedTrees, Model, VehicleStatistics, Window
from fcw.detection.samples import Augmentation, random_boxes, window_features
from fcw.detection.statistics import vehicle_statistics
from fcw.detection.suppression import suppress
from fcw.errors import UserError
from fcw.evaluation.detection import (
    DetectionCurve,
    LabelledDetections,
    OperatingPoint,
    detection_curve,
    match_detections,
)

# What random numbers are drawn for: each picture and purpose has a stream of its own.
_VEHICLES, _ANYTHING, _MINING = range(3)


@dataclass(frozen=True, slots=True)
class TrainingSettings:
    """How a model is trained.

    Attributes:
        tree_counts: trees of each round; before each but the first, hard negatives are mined.
        crops_per_vehicle: jittered windows of each vehicle, and as many mirrored ones.
        random_per_image: windows from anywhere on the road, the first round's negatives.
        mined_per_image: largest number of hard negatives that a round takes from a picture.
        whole_image_every: one picture in so many is also mined without the distance prior, so that the trees
            know what lies off the road as well, where plain ACF looks.
        max_negatives: largest number of negatives in a round; the newest go first.
        rejection_threshold: constant soft cascade while mining, and the lowest that is shipped.
        folds: parts of the pictures held out in turn to choose the thresholds.
        fppi: detections of mere background per held-out picture at the shipped score threshold.
        augmentation: of windows.
        seed: of everything random.
    """

    tree_counts: tuple[int, ...] = (64, 256, 512)
    crops_per_vehicle: int = 8
    random_per_image: int = 15
    mined_per_image: int = 40
    whole_image_every: int = 4
    max_negatives: int = 30_000
    rejection_threshold: float = -3.0
    folds: int = 3
    fppi: float = 0.1
    augmentation: Augmentation = Augmentation()  # noqa: RUF009 - frozen
    seed: int = 0


class Progress(Protocol):
    """Who is told how training goes."""

    def stage(self, name: str, steps: int) -> None:
        """Work of so many steps begins."""
        ...

    def advance(self) -> None:
        """A step is done."""
        ...

    def note(self, text: str) -> None:
        """Something worth keeping: a line of the log."""
        ...


class Samples(NamedTuple):
    """Windows, and the picture that each is from.

    Attributes:
        features: (N, F) uint8.
        image: (N,) index of the picture.
    """

    features: NDArray[np.uint8]
    image: NDArray[np.int64]


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


def train(images: Sequence[TrainingImage], settings: TrainingSettings, progress: Progress) -> TrainingResult:
    """Train a model.

    The pictures, in the order of clip and file, are cut into `folds` runs; neighbours in a drive are held
    out together. A model is trained for each fold, the thresholds follow from their detections, and then the
    model of all pictures is trained.

    Raises:
        UserError: too few pictures, or none holds a vehicle that counts.
    """
    if len(images) < settings.folds:
        raise UserError(f"{len(images)} labelled pictures; expected at least {settings.folds}: label more")
    images = sorted(images, key=lambda image: (image.labelled.clip, str(image.labelled.path)))
    try:
        statistics = vehicle_statistics(images)
    except ValueError as error:
        raise UserError(f"{error}; check the calibrations that lie beside the labels") from None
    trainer = _Trainer(images, statistics, settings, progress)
    fold_of = np.arange(len(images)) * settings.folds // len(images)
    results: list[LabelledDetections] = []
    lows: list[NDArray[np.float64]] = []
    for fold in range(settings.folds):
        name = f"fold {fold + 1} of {settings.folds}"
        model = trainer.fit(np.flatnonzero(fold_of != fold), name)
        for result, low in trainer.detect(model, np.flatnonzero(fold_of == fold), name):
            results.append(result)
            lows.append(low)
    curve = detection_curve(results)
    point = curve.at_threshold(_score_threshold(results, settings))
    progress.note(
        f"held out: detection rate {point.detection_rate:.3f}, {point.fppi:.3f} false positives per picture, "
        f"{settings.fppi:g} of them on background; score threshold {point.threshold:.2f}"
    )
    model = replace(
        trainer.fit(np.arange(len(images)), "all pictures"),
        score_threshold=point.threshold,
        rejection_threshold=_rejection_threshold(results, lows, point.threshold, settings),
    )
    progress.note(f"the cascade's rejection threshold {model.rejection_threshold:.1f}")
    return TrainingResult(model, curve, point)


def _score_threshold(results: Sequence[LabelledDetections], settings: TrainingSettings) -> float:
    """The lowest score with no more detections of background per held-out picture than wanted.

    A box badly placed on a vehicle is not counted here, though it is a false positive in evaluation: most
    of the surest such false positives are vans and three-quarter views whose shape is not the usual one, and
    a threshold above them would lose many vehicles and spare nobody a false alarm.
    """
    false = [
        result.scores[background(result.detections, result.labels, result.ignored)] for result in results
    ]
    scores = np.sort(np.concatenate(false))[::-1]
    allowed = int(settings.fppi * len(results))
    if len(scores) <= allowed:
        return settings.rejection_threshold
    return float(np.nextafter(scores[allowed], np.inf))


def _rejection_threshold(
    results: Sequence[LabelledDetections],
    lows: Sequence[NDArray[np.float64]],
    score_threshold: float,
    settings: TrainingSettings,
) -> float:
    """The highest cascade threshold, in tenths, that loses no held-out hit above the score threshold."""
    lowest = [
        low[(match_detections(*result) >= 0) & (result.scores >= score_threshold)]
        for result, low in zip(results, lows, strict=True)
    ]
    least = np.concatenate(lowest).min(initial=0.0)
    return float(max(np.floor(10.0 * least) / 10.0, settings.rejection_threshold))


class _Trainer:
    """What all fits share: the pictures, their vehicles' windows and the first negatives."""

    def __init__(
        self,
        images: Sequence[TrainingImage],
        statistics: VehicleStatistics,
        settings: TrainingSettings,
        progress: Progress,
    ) -> None:
        self.images = images
        self.statistics = statistics
        self.settings = settings
        self.progress = progress
        self.window = Window()
        progress.stage("cutting windows", len(images))
        positives, negatives = [], []
        for index in range(len(images)):
            positives.append(self._vehicles(index))
            negatives.append(self._anything(index))
            progress.advance()
        self.positives, self.negatives = _joined(positives), _joined(negatives)

    def fit(self, members: NDArray[np.int64], name: str) -> Model:
        """A model of some of the pictures, its score threshold as low as its cascade's."""
        settings = self.settings
        positives = self.positives.features[np.isin(self.positives.image, members)]
        negatives = self.negatives.features[np.isin(self.negatives.image, members)]
        model: Model | None = None
        for number, count in enumerate(settings.tree_counts):
            if model:
                mined = self._mine(model, members, number, name)
                negatives = np.concatenate([mined, negatives])[: settings.max_negatives]
            self.progress.stage(f"{name}: boosting {count} trees", count)
            trees = train_trees(
                positives,
                negatives,
                count,
                BoostingSettings(seed=settings.seed + number),
                self.progress.advance,
            )
            model = self._model(trees)
            gap = [np.median(running_scores(trees, side)[:, -1]) for side in (positives, negatives)]
            self.progress.note(
                f"{name}, round {number + 1}: {len(trees)} trees, {len(positives)} windows of vehicles "
                f"(median score {gap[0]:.1f}) against {len(negatives)} others ({gap[1]:.1f})"
            )
        assert model is not None
        return model

    def detect(
        self, model: Model, members: NDArray[np.int64], name: str
    ) -> list[tuple[LabelledDetections, NDArray[np.float64]]]:
        """Detections in some pictures, and the lowest running score that each had in the cascade."""
        self.progress.stage(f"{name}: detecting", len(members))
        detectors = Detectors(model)
        results = []
        for index in members:
            image = self.images[index]
            proposals = detectors.prior(image).scan(
                image.labelled.read(), self.settings.rejection_threshold, with_features=True
            )
            kept = suppress(proposals.boxes, proposals.scores, AcfSettings().largest_overlap)
            assert proposals.features is not None
            lows = running_scores(model.trees, proposals.features[kept]).min(axis=1, initial=np.inf)
            result = LabelledDetections(
                proposals.boxes[kept],
                proposals.scores[kept].astype(np.float64),
                image.labelled.boxes,
                image.labelled.ignored,
            )
            results.append((result, lows.astype(np.float64)))
            self.progress.advance()
        return results

    def _model(self, trees: BoostedTrees) -> Model:
        threshold = self.settings.rejection_threshold
        return Model(self.window, trees, self.statistics, threshold, threshold)

    def _vehicles(self, index: int) -> Samples:
        """The vehicles of a picture, jittered, and mirrored as often."""
        labelled = self.images[index].labelled
        generator = np.random.default_rng([self.settings.seed, _VEHICLES, index])
        boxes = labelled.boxes[~labelled.ignored]
        return self._cut(index, np.repeat(boxes, 2 * self.settings.crops_per_vehicle, axis=0), generator)

    def _anything(self, index: int) -> Samples:
        """Windows from anywhere on a picture's road that show no vehicle."""
        image, statistics = self.images[index], self.statistics
        generator = np.random.default_rng([self.settings.seed, _ANYTHING, index])
        boxes = random_boxes(
            self.settings.random_per_image,
            image.calibration.horizon_row_px,
            image.calibration.camera.height_m,
            image.labelled.size,
            (statistics.size_low_m, statistics.size_high_m),
            float(np.median(statistics.aspect_ratios)),
            generator,
        )
        return self._cut(
            index, boxes[background(boxes, image.labelled.boxes, image.labelled.ignored)], generator
        )

    def _cut(self, index: int, boxes: NDArray[np.float64], generator: np.random.Generator) -> Samples:
        """Features of windows, every second one mirrored."""
        features = np.empty((len(boxes), self.window.feature_count), np.uint8)
        if len(boxes):
            picture = self.images[index].labelled.read()
            for number, box in enumerate(boxes):
                features[number] = window_features(
                    picture, box, self.window, self.settings.augmentation, generator, mirrored=number % 2 == 1
                )
        return Samples(features, np.full(len(boxes), index))

    def _mine(
        self, model: Model, members: NDArray[np.int64], round_number: int, name: str
    ) -> NDArray[np.uint8]:
        """Features of the surest false positives of some pictures, surest first, each mirrored or not."""
        self.progress.stage(f"{name}: mining for round {round_number + 1}", len(members))
        detectors = Detectors(model)
        mined = []
        for number, index in enumerate(members):
            image = self.images[index]
            generator = np.random.default_rng([self.settings.seed, _MINING, round_number, index])
            picture, boxes = image.labelled.read(), image.labelled.boxes
            if generator.uniform() < 0.5:
                picture = np.ascontiguousarray(picture[:, ::-1])
                # A box from the column x to x + w reaches, mirrored, from width - 1 - (x + w).
                boxes = np.column_stack([picture.shape[1] - 1 - boxes[:, 0] - boxes[:, 2], boxes[:, 1:]])
            scans = [detectors.prior(image).scan]
            if number % self.settings.whole_image_every == 0:
                scans.append(detectors.full.scan)
            for scan in scans:
                proposals = scan(picture, self.settings.rejection_threshold, True)
                mined += false_positives(
                    proposals, boxes, image.labelled.ignored, self.settings.mined_per_image
                )
            self.progress.advance()
        mined.sort(key=lambda found: -found[0])
        above = sum(score >= 0 for score, _ in mined)
        self.progress.note(
            f"{name}: the {len(model.trees)} trees put {len(mined)} windows of background out, "
            f"{above / len(members):.2f} per picture with a score above 0"
        )
        return np.array([features for _, features in mined], np.uint8).reshape(-1, self.window.feature_count)


def _joined(samples: list[Samples]) -> Samples:
    return Samples(*(np.concatenate(parts) for parts in zip(*samples, strict=True)))
