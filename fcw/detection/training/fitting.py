"""Fitting one model to some pictures: rounds of trees against hard negatives, then the later stages."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.regression import fit_regressor
from fcw.detection.channels.decorrelation import decorrelated, learn_filters
from fcw.detection.model import (
    BoostedTrees,
    BoxRegressor,
    Model,
    SecondStage,
    VehicleStatistics,
    Window,
    tree_arrays,
    trees_of,
)
from fcw.detection.training.checkpoints import Checkpoints
from fcw.detection.training.dataset import TrainingImage, without_vehicle_in_place
from fcw.detection.training.mining import Detectors, false_positives
from fcw.detection.training.samples import Augmentation, place, random_boxes, window_features
from fcw.detection.training.settings import Progress, TrainingSettings
from fcw.detection.trees.boosting import BoostingSettings, running_scores, train_trees

# What random numbers are drawn for: each picture and purpose has a stream of its own.
_VEHICLES, _ANYTHING, _MINING, _DISPLACED = range(4)


class Samples(NamedTuple):
    """Windows, and the picture that each is from.

    Attributes:
        features: (N, F) uint8.
        image: (N,) index of the picture.
        offsets: (N, 3) how vehicles truly stand in them; zeros for windows of background.
    """

    features: NDArray[np.uint8]
    image: NDArray[np.int64]
    offsets: NDArray[np.float64]


class Fitter:
    """What all fits share: the pictures, their vehicles' windows and the first negatives."""

    def __init__(
        self,
        images: Sequence[TrainingImage],
        statistics: VehicleStatistics,
        settings: TrainingSettings,
        progress: Progress,
        checkpoints: Checkpoints,
    ) -> None:
        self.images = images
        self.statistics = statistics
        self.settings = settings
        self.progress = progress
        self.checkpoints = checkpoints
        self.window = Window()
        self.positives = self._vehicles(_VEHICLES, settings.crops_per_vehicle, settings.augmentation)
        self.negatives = self._anything()
        self.displaced = self._vehicles(_DISPLACED, settings.displaced_per_vehicle, settings.displacement)

    def fit(self, members: NDArray[np.int64], name: str) -> Model:
        """A model with all stages."""
        model, negatives = self.cascade(members, name)
        second = self._second(model, members, negatives, name)
        return replace(model, second=second, regressor=self._regressor(members, name))

    def cascade(self, members: NDArray[np.int64], name: str) -> tuple[Model, NDArray[np.uint8]]:
        """The first stage alone, and the windows of background that it learnt from."""
        settings = self.settings
        positives = self.positives.features[np.isin(self.positives.image, members)]
        negatives = self.negatives.features[np.isin(self.negatives.image, members)]
        model: Model | None = None
        for number, count in enumerate(settings.tree_counts):
            if model:
                mined = self._mine(model, members, number, name)
                negatives = np.concatenate([mined, negatives])[: settings.max_negatives]
            model = self._boosted(positives, negatives, count, number, name)
        assert model is not None
        return model, negatives

    def _boosted(
        self,
        positives: NDArray[np.uint8],
        negatives: NDArray[np.uint8],
        count: int,
        number: int,
        name: str,
    ) -> Model:
        self.progress.stage(f"{name}: boosting {count} trees", count)
        boosting = BoostingSettings(seed=self.settings.seed + number)
        arrays = self.checkpoints.stage(
            f"{name}-round{number + 1}",
            lambda: tree_arrays(
                train_trees(positives, negatives, count, boosting, self.progress.advance), "first"
            ),
        )
        trees = trees_of(arrays, "first")
        gap = [np.median(running_scores(trees, side)[:, -1]) for side in (positives, negatives)]
        self.progress.note(
            f"{name}, round {number + 1}: {len(trees)} trees, {len(positives)} windows of vehicles "
            f"(median score {gap[0]:.1f}) against {len(negatives)} others ({gap[1]:.1f})",
            round=number + 1,
            trees=len(trees),
            positives=len(positives),
            negatives=len(negatives),
            median_positive_score=float(gap[0]),
            median_negative_score=float(gap[1]),
        )
        threshold = self.settings.rejection_threshold
        return Model(self.window, trees, None, None, self.statistics, threshold, threshold, threshold)

    def _second(
        self, model: Model, members: NDArray[np.int64], negatives: NDArray[np.uint8], name: str
    ) -> SecondStage:
        """The second stage, of the same windows as the cascade.

        Only few of the negatives pass a cascade that learnt from them, many more in new pictures.
        """
        settings = self.settings

        positives = self.positives.features[np.isin(self.positives.image, members)]
        mined = self._mine(model, members, len(settings.tree_counts), name)
        negatives = np.concatenate([mined, negatives])[: settings.max_negatives]

        def compute() -> Mapping[str, NDArray[Any]]:
            weights, means, shifts = learn_filters(negatives, self.window)
            responses = [
                decorrelated(side, self.window, weights, means, shifts) for side in (positives, negatives)
            ]
            self.progress.stage(f"{name}: second stage", settings.second_runs * settings.second_tree_count)
            runs = [
                train_trees(
                    responses[0],
                    responses[1],
                    settings.second_tree_count,
                    BoostingSettings(seed=settings.seed + len(settings.tree_counts) + run),
                    self.progress.advance,
                )
                for run in range(settings.second_runs)
            ]
            trees = BoostedTrees(
                np.concatenate([run.feature for run in runs]),
                np.concatenate([run.threshold for run in runs]),
                np.concatenate([run.leaf for run in runs]) / np.float32(settings.second_runs),
            )
            return tree_arrays(trees, "second") | {"weights": weights, "means": means, "shifts": shifts}

        arrays = self.checkpoints.stage(f"{name}-second", compute)
        self.progress.note(
            f"{name}, second stage: {settings.second_runs} times {settings.second_tree_count} trees, "
            f"{len(positives)} windows of vehicles against {len(negatives)} others",
            trees=settings.second_runs * settings.second_tree_count,
            positives=len(positives),
            negatives=len(negatives),
        )
        return SecondStage(arrays["weights"], arrays["means"], arrays["shifts"], trees_of(arrays, "second"))

    def _regressor(self, members: NDArray[np.int64], name: str) -> BoxRegressor:
        of_members = np.isin(self.displaced.image, members)

        def compute() -> Mapping[str, NDArray[Any]]:
            regressor = fit_regressor(
                self.displaced.features[of_members], self.displaced.offsets[of_members], self.settings.ridge
            )
            return {"weights": regressor.weights, "constant": regressor.constant}

        arrays = self.checkpoints.stage(f"{name}-regressor", compute)
        return BoxRegressor(arrays["weights"], arrays["constant"], bottom=0.0)

    def _vehicles(self, purpose: int, crops: int, augmentation: Augmentation) -> Samples:
        """Windows of the vehicles that count, jittered, and mirrored as often."""
        self.progress.stage("cutting windows of vehicles", len(self.images))
        samples = []
        for index, image in enumerate(self.images):
            boxes = np.repeat(image.labelled.boxes[~image.labelled.ignored], 2 * crops, axis=0)
            samples.append(self._cut(index, boxes, augmentation, purpose))
            self.progress.advance()
        return _joined(samples)

    def _anything(self) -> Samples:
        """Windows from anywhere on the pictures' roads that show no vehicle."""
        self.progress.stage("cutting windows of background", len(self.images))
        statistics, samples = self.statistics, []
        for index, image in enumerate(self.images):
            if not image.labelled.complete:
                continue
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
            labelled = image.labelled
            boxes = boxes[
                without_vehicle_in_place(boxes, labelled.boxes, labelled.ignored, labelled.rear_boxes)
            ]
            samples.append(self._cut(index, boxes, self.settings.augmentation, _ANYTHING))
            self.progress.advance()
        return _joined(samples)

    def _cut(
        self, index: int, boxes: NDArray[np.float64], augmentation: Augmentation, purpose: int
    ) -> Samples:
        """Windows on boxes, every second one mirrored."""
        generator = np.random.default_rng([self.settings.seed, purpose, index])
        features = np.empty((len(boxes), self.window.feature_count), np.uint8)
        offsets = np.zeros((len(boxes), 3))
        if len(boxes):
            picture = self.images[index].labelled.read()
            for number, box in enumerate(boxes):
                mirrored = number % 2 == 1
                placement = place(box, augmentation, generator)
                offsets[number] = placement.offsets(box, mirrored)
                features[number] = window_features(
                    picture, placement, self.window, augmentation, generator, mirrored
                )
        return Samples(features, np.full(len(boxes), index), offsets)

    def _mine(
        self, model: Model, members: NDArray[np.int64], round_number: int, name: str
    ) -> NDArray[np.uint8]:
        """Features of the surest false positives of some pictures, surest first, each mirrored or not."""
        self.progress.stage(f"{name}: mining for round {round_number + 1}", len(members))
        arrays = self.checkpoints.stage(
            f"{name}-mined{round_number + 1}", lambda: self._mined(model, members, round_number)
        )
        above = int((arrays["scores"] >= 0).sum())
        self.progress.note(
            f"{name}: the {len(model.trees)} trees put {len(arrays['scores'])} windows of background out, "
            f"{above / len(members):.2f} per picture with a score above 0",
            mined=len(arrays["scores"]),
            above_zero_per_picture=above / len(members),
        )
        return arrays["features"]

    def _mined(
        self, model: Model, members: NDArray[np.int64], round_number: int
    ) -> Mapping[str, NDArray[Any]]:
        settings = self.settings
        detectors = Detectors(model, settings.search)
        mined = []
        for number, index in enumerate(members):
            image = self.images[index]
            if not image.labelled.complete:
                self.progress.advance()
                continue
            generator = np.random.default_rng([self.settings.seed, _MINING, round_number, index])
            picture, boxes, rears = image.labelled.read(), image.labelled.boxes, image.labelled.rear_boxes
            if generator.uniform() < 0.5:
                picture = np.ascontiguousarray(picture[:, ::-1])
                boxes, rears = (_mirrored(some, picture.shape[1]) for some in (boxes, rears))
            scans = [detectors.prior(image).scan]
            if settings.whole_image_every and number % settings.whole_image_every == 0:
                scans.append(detectors.full.scan)
            for scan in scans:
                proposals = scan(picture, settings.rejection_threshold, True)
                mined += false_positives(
                    proposals, boxes, image.labelled.ignored, rears, settings.mined_per_image
                )
            self.progress.advance()
        mined.sort(key=lambda found: -found[0])
        return {
            "scores": np.array([score for score, _ in mined], np.float32),
            "features": np.array([features for _, features in mined], np.uint8).reshape(
                -1, self.window.feature_count
            ),
        }


def _mirrored(boxes: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """A box from the column x to x + w reaches, mirrored, from width - 1 - (x + w)."""
    return np.column_stack([width - 1 - boxes[:, 0] - boxes[:, 2], boxes[:, 1:]])


def _joined(samples: Sequence[Samples]) -> Samples:
    return Samples(*(np.concatenate(parts) for parts in zip(*samples, strict=True)))
