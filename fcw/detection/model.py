"""A trained detector: window, cascade, second stage, box regressor, statistics of vehicles; and its file."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.arrays import npz_arrays
from fcw.bounded.formats import json_value
from fcw.errors import UserError
from fcw.files import whole_file

FORMAT_VERSION = 2
CELL_PX = 4
CHANNEL_COUNT = 10
LARGEST_WINDOW_PX = 512
FILTER_CELLS = 5
FILTERS_PER_CHANNEL = 4
_FILTER_ARRAYS = ("weights", "means", "shifts")


@dataclass(frozen=True, slots=True)
class Window:
    """The trees' window, and where the vehicle is in it.

    A vehicle of width w and height h belongs to the window at the scale sqrt(w h) / vehicle_size_px. It is
    centred horizontally, with its bottom edge `vehicle_bottom_px` below the window's top.
    """

    size_px: int = 64
    vehicle_size_px: float = 40.0
    vehicle_bottom_px: float = 52.0

    @property
    def cells(self) -> int:
        """Cells along one side."""
        return self.size_px // CELL_PX

    @property
    def feature_count(self) -> int:
        """Length of a window's feature vector, in the order channel, row, column."""
        return CHANNEL_COUNT * self.cells**2


@dataclass(frozen=True, slots=True, eq=False)
class BoostedTrees:
    """T depth-2 trees over uint8 features.

    Node 0 is the root, 1 its left and 2 its right child; a window goes left where
    `feature <= threshold`. Leaves from left to right.

    Attributes:
        feature: (T, 3) uint16, index into the window's feature vector.
        threshold: (T, 3) uint8.
        leaf: (T, 4) float32, added to the score.
    """

    feature: NDArray[np.uint16]
    threshold: NDArray[np.uint8]
    leaf: NDArray[np.float32]

    def __post_init__(self) -> None:
        count = len(self.feature)
        shapes = (self.feature.shape, self.threshold.shape, self.leaf.shape)
        if shapes != ((count, 3), (count, 3), (count, 4)):
            raise ValueError(f"expected trees of the shapes (T, 3), (T, 3) and (T, 4), got {shapes}")

    def __len__(self) -> int:
        return len(self.feature)


@dataclass(frozen=True, slots=True)
class VehicleStatistics:
    """Sizes of labelled vehicles seen from behind, for the distance prior.

    Attributes:
        size_low_m: smallest sqrt(width * height) searched for.
        size_median_m: median of sqrt(width * height).
        size_high_m: largest sqrt(width * height) searched for.
        aspect_distances_m: distances at which the aspect ratio was taken, ascending.
        aspect_ratios: median width / height at those distances.
    """

    size_low_m: float
    size_median_m: float
    size_high_m: float
    aspect_distances_m: tuple[float, ...]
    aspect_ratios: tuple[float, ...]

    def aspect_ratio(self, distance_m: float | NDArray[np.float64]) -> float | NDArray[np.float64]:
        """Width over height at a distance, interpolated in the logarithm of the distance."""
        ratio = np.interp(np.log(distance_m), np.log(self.aspect_distances_m), self.aspect_ratios)
        return float(ratio) if np.ndim(distance_m) == 0 else ratio


@dataclass(frozen=True, slots=True, eq=False)
class SecondStage:
    """Trees over locally decorrelated channels (`fcw.detection.trees.second_stage`).

    Attributes:
        weights: (10, 4, 5, 5) int8, the filters.
        means: (10, 4) int32, their mean responses.
        shifts: (10, 4) uint8, powers of two that responses are divided by.
        trees: over the responses in 256 steps; their sum is added to the cascade's score.
    """

    weights: NDArray[np.int8]
    means: NDArray[np.int32]
    shifts: NDArray[np.uint8]
    trees: BoostedTrees


@dataclass(frozen=True, slots=True, eq=False)
class BoxRegressor:
    """A linear map from a window's channels to the box of its vehicle (`fcw.detection.boxes.regression`).

    Attributes:
        weights: (F, 3) float32, for the offset of the middle and the logarithms of width and height.
        constant: (3,) float32, added to these.
        bottom: how much lower the bottom edges of vehicles are than windows expect, in sizes sqrt(w h).
    """

    weights: NDArray[np.float32]
    constant: NDArray[np.float32]
    bottom: float


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Everything that a detector has learned.

    Attributes:
        window: the trees' window.
        trees: trees of the cascade, the first stage.
        second: second stage, which scores the windows that pass the cascade; None in plain ACF.
        regressor: refines the boxes; None in plain ACF.
        statistics: sizes of vehicles.
        rejection_threshold: constant soft cascade: a window whose running score falls below it is dropped.
        score_threshold: default threshold for the sum of both stages' scores.
        first_stage_threshold: default threshold for the cascade's score alone.
    """

    window: Window
    trees: BoostedTrees
    second: SecondStage | None
    regressor: BoxRegressor | None
    statistics: VehicleStatistics
    rejection_threshold: float
    score_threshold: float
    first_stage_threshold: float

    def plain(self) -> "Model":
        """The cascade alone with its own threshold: ACF as in the paper."""
        return replace(self, second=None, regressor=None, score_threshold=self.first_stage_threshold)

    def save(self, path: Path) -> None:
        """Write the model file (a NumPy .npz archive) whole or not at all.

        Raises:
            UserError: the file cannot be written there.
        """
        header = {
            "format_version": FORMAT_VERSION,
            "window": asdict(self.window),
            "statistics": asdict(self.statistics),
            "rejection_threshold": self.rejection_threshold,
            "score_threshold": self.score_threshold,
            "first_stage_threshold": self.first_stage_threshold,
        }
        arrays: dict[str, NDArray[Any]] = tree_arrays(self.trees, "first")
        if self.second:
            arrays |= tree_arrays(self.second.trees, "second")
            arrays |= {f"filter_{name}": getattr(self.second, name) for name in _FILTER_ARRAYS}
        if self.regressor:
            arrays["regressor_weights"] = self.regressor.weights
            arrays["regressor_constant"] = self.regressor.constant
            header["regressor_bottom"] = self.regressor.bottom
        with whole_file(path) as partial, partial.open("wb") as file:
            arrays["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
            np.savez_compressed(file, allow_pickle=False, **arrays)

    @classmethod
    def load(cls, path: Path) -> "Model":
        """Read a model file.

        Raises:
            UserError: the file is missing, is no model, or is of another format version.
        """
        try:
            arrays = npz_arrays(path)
            header = json_value(arrays["header"].tobytes().decode())
            version = header["format_version"]
            model = cls._of(header, arrays) if version == FORMAT_VERSION else None
        except FileNotFoundError:
            raise UserError(f"{path}: no such model file; train one with `fcw train`") from None
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError, OSError) as error:
            reason = f"no {error} in it" if isinstance(error, KeyError) else error
            raise UserError(
                f"{path}: not a detector model of fcw ({reason}); expected a file written by `fcw train`"
            ) from error
        if model is None:
            raise UserError(
                f"{path}: model format version {version}, expected {FORMAT_VERSION}; "
                "train it again with `fcw train`"
            )
        return model

    @classmethod
    def _of(cls, header: dict[str, Any], arrays: Mapping[str, NDArray[Any]]) -> "Model":
        """The model from a file's parts; raises ValueError if they do not fit together."""
        statistics = header["statistics"]
        model = cls(
            Window(**header["window"]),
            trees_of(arrays, "first"),
            SecondStage(
                *(arrays[f"filter_{name}"] for name in _FILTER_ARRAYS), trees=trees_of(arrays, "second")
            )
            if "second_feature" in arrays
            else None,
            BoxRegressor(
                arrays["regressor_weights"], arrays["regressor_constant"], header["regressor_bottom"]
            )
            if "regressor_weights" in arrays
            else None,
            VehicleStatistics(
                statistics["size_low_m"],
                statistics["size_median_m"],
                statistics["size_high_m"],
                tuple(statistics["aspect_distances_m"]),
                tuple(statistics["aspect_ratios"]),
            ),
            header["rejection_threshold"],
            header["score_threshold"],
            header["first_stage_threshold"],
        )
        check_parts(model)
        return model


def check_parts(model: Model) -> None:
    """Check that the parts of a model fit together, as the loops over trees check no bounds.

    Raises:
        ValueError: they do not.
    """
    window, statistics = model.window, model.statistics
    if not (CELL_PX <= window.size_px <= LARGEST_WINDOW_PX and window.size_px % CELL_PX == 0):
        raise ValueError(f"a window of {window.size_px} pixels")
    stages = [(model.trees, window.feature_count)]
    if model.second is not None:
        second = model.second
        shapes = (CHANNEL_COUNT, FILTERS_PER_CHANNEL)
        if (second.weights.shape, second.means.shape, second.shifts.shape) != (
            (*shapes, FILTER_CELLS, FILTER_CELLS),
            shapes,
            shapes,
        ):
            raise ValueError("filters of other shapes")
        places = window.cells - FILTER_CELLS + 1
        stages.append((second.trees, CHANNEL_COUNT * FILTERS_PER_CHANNEL * max(places, 0) ** 2))
    for trees, features in stages:
        kinds = (trees.feature.dtype, trees.threshold.dtype, trees.leaf.dtype)
        if kinds != (np.uint16, np.uint8, np.float32):
            raise ValueError(f"trees of the types {', '.join(map(str, kinds))}")
        if len(trees) and int(trees.feature.max()) >= features:
            raise ValueError(f"a tree asks for feature {int(trees.feature.max())} of {features}")
        if not np.isfinite(trees.leaf).all():
            raise ValueError("a tree with a leaf that is no number")
    if model.regressor is not None:
        weights, constant = model.regressor.weights, model.regressor.constant
        if (weights.shape, constant.shape) != ((window.feature_count, 3), (3,)):
            raise ValueError(f"a regressor of the shapes {weights.shape} and {constant.shape}")
        if not all(np.isfinite(part).all() for part in (weights, constant, model.regressor.bottom)):
            raise ValueError("a regressor with a weight that is no number")
    distances, ratios = statistics.aspect_distances_m, statistics.aspect_ratios
    sizes = (statistics.size_low_m, statistics.size_median_m, statistics.size_high_m)
    lengths = (window.vehicle_size_px, window.vehicle_bottom_px, *sizes, *distances, *ratios)
    numbers = (model.rejection_threshold, model.score_threshold, model.first_stage_threshold)
    if not (all(0 < value < math.inf for value in lengths) and all(map(math.isfinite, numbers))):
        raise ValueError("a number that is none, or not above 0")
    if not (0 < len(distances) == len(ratios) and all(a < b for a, b in pairwise(distances))):
        raise ValueError("aspect ratios without their rising distances")


def tree_arrays(trees: BoostedTrees, stage: str) -> dict[str, NDArray[Any]]:
    """The trees of a stage as arrays of a file."""
    return {f"{stage}_{name}": getattr(trees, name) for name in ("feature", "threshold", "leaf")}


def trees_of(arrays: Mapping[str, NDArray[Any]], stage: str) -> BoostedTrees:
    """The trees of a stage from a file's arrays."""
    return BoostedTrees(*(arrays[f"{stage}_{name}"] for name in ("feature", "threshold", "leaf")))


SHIPPED_MODEL_PATH = Path(__file__).with_name("weights") / "rear.npz"


def model_sha256(path: Path) -> str:
    """Hash of a model file, as logs record it."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
