"""A trained detector: window, boosted trees, soft cascade, statistics of vehicles; and its file."""

import hashlib
import json
import zipfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.files import whole_file

FORMAT_VERSION = 1
CELL_PX = 4
CHANNEL_COUNT = 10


@dataclass(frozen=True, slots=True)
class Window:
    """The window that the trees look at, and where the vehicle stands in it.

    A vehicle of width w and height h fills the window at the scale sqrt(w h) / vehicle_size_px, centred
    in it, its bottom edge `vehicle_bottom_px` below the window's top.
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
    """Sizes of labelled vehicles seen from behind; the distance prior's numbers.

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
class Model:
    """Everything a detector needs that was learnt.

    Attributes:
        rejection_threshold: constant soft cascade: a window whose running score falls below it is dropped.
        score_threshold: score from which a window counts as a vehicle by default.
    """

    window: Window
    trees: BoostedTrees
    statistics: VehicleStatistics
    rejection_threshold: float
    score_threshold: float

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
        }
        with whole_file(path) as partial, partial.open("wb") as file:
            np.savez_compressed(
                file,
                header=np.frombuffer(json.dumps(header).encode(), np.uint8),
                feature=self.trees.feature,
                threshold=self.trees.threshold,
                leaf=self.trees.leaf,
            )

    @classmethod
    def load(cls, path: Path) -> "Model":
        """Read a model file.

        Raises:
            UserError: the file is missing, is no model, or is of another format version.
        """
        try:
            with np.load(path, allow_pickle=False) as archive:
                header = json.loads(archive["header"].tobytes())
                trees = BoostedTrees(archive["feature"], archive["threshold"], archive["leaf"])
        except FileNotFoundError:
            raise UserError(f"{path}: no such model file; train one with `fcw train`") from None
        except (KeyError, ValueError, EOFError, OSError, zipfile.BadZipFile) as error:
            raise UserError(
                f"{path}: not a detector model of fcw ({error}); expected a file written by `fcw train`"
            ) from error
        if header["format_version"] != FORMAT_VERSION:
            raise UserError(
                f"{path}: model format version {header['format_version']}, expected {FORMAT_VERSION}; "
                "train it again with `fcw train`"
            )
        statistics = header["statistics"]
        return cls(
            Window(**header["window"]),
            trees,
            VehicleStatistics(
                statistics["size_low_m"],
                statistics["size_median_m"],
                statistics["size_high_m"],
                tuple(statistics["aspect_distances_m"]),
                tuple(statistics["aspect_ratios"]),
            ),
            header["rejection_threshold"],
            header["score_threshold"],
        )


SHIPPED_MODEL_PATH = Path(__file__).with_name("weights") / "rear.npz"


def model_sha256(path: Path) -> str:
    """Hash of a model file, as logs record it."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
