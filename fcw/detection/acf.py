"""The two detectors: ACF with the distance prior, and plain ACF over the whole picture as the baseline.

Both run the same channels, trees and cascade; they differ in the windows they look at.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.detection.cascade import feature_offsets, score_windows
from fcw.detection.channels import CONTEXT_PX, ChannelComputer
from fcw.detection.model import CELL_PX, CHANNEL_COUNT, Model
from fcw.detection.suppression import suppress
from fcw.detection.types import Box, Detection
from fcw.detection.windows import PAD_CELLS, DistancePrior, Level, full_levels, prior_levels
from fcw.sources.frame import ImageSize

CONTEXT_CELLS = math.ceil((CONTEXT_PX + 1) / CELL_PX)
"""Cells computed beyond those wanted: what their channels depend on, and a pixel for the resizing."""
FIRST_CAPACITY = 4096
"""Windows that the result buffers hold at first; they grow where a low threshold lets more through."""


@dataclass(frozen=True, slots=True, eq=False)
class Proposals:
    """Windows that passed the cascade, best score first, before any suppression.

    Attributes:
        boxes: (N, 4) float64, x, y, w, h of the vehicles, cut to the picture.
        scores: (N,) float32.
        features: (N, 2560) uint8, what the trees saw: channel, row, column; None unless asked for.
    """

    boxes: NDArray[np.float64]
    scores: NDArray[np.float32]
    features: NDArray[np.uint8] | None


class _Octave:
    """One octave's channels in the rows that its levels need, edges repeated beyond the picture."""

    def __init__(self, size: ImageSize, octave: int, levels: list[Level]) -> None:
        self.octave = octave
        # Pixels of the picture for a cell; a fraction of a cell's 4 px where the octave is an enlargement.
        step_px = CELL_PX / 2.0**octave
        rows, self._columns = int(size.height // step_px), int(size.width // step_px)
        first_cut = min(level.first_cut for level in levels)
        end_cut = max(level.first_cut + level.cut_rows for level in levels)
        self.first_row = first_cut
        first, end = max(first_cut, 0), min(end_cut, rows)
        first_slab, end_slab = max(first - CONTEXT_CELLS, 0), min(end + CONTEXT_CELLS, rows)
        self._slab_rows = slice(round(first_slab * step_px), round(end_slab * step_px))
        self._slab_columns = slice(0, round(self._columns * step_px))
        slab_height = (end_slab - first_slab) * CELL_PX
        slab_width = size.width if octave == 0 else self._columns * CELL_PX
        self._computer = ChannelComputer(ImageSize(slab_width, slab_height))
        self._resized = None if octave == 0 else np.empty((slab_height, slab_width, 3), np.uint8)
        self._wanted = first - first_slab, end - first_slab
        self._pad_above, self._pad_below = first - first_cut, end_cut - end
        self.grid = np.empty((CHANNEL_COUNT, end_cut - first_cut, self._columns + 2 * PAD_CELLS), np.uint8)

    def compute(self, image: NDArray[np.uint8]) -> None:
        """Fill the grid from a picture."""
        slab = image[self._slab_rows]
        if self._resized is not None:
            interpolation = cv2.INTER_LINEAR if self.octave > 0 else cv2.INTER_AREA
            height, width = self._resized.shape[:2]
            cv2.resize(
                slab[:, self._slab_columns], (width, height), dst=self._resized, interpolation=interpolation
            )
            slab = self._resized
        grid, above = self.grid, self._pad_above
        end = grid.shape[1] - self._pad_below
        self._computer.compute(
            slab, *self._wanted, out=grid[:, above:end, PAD_CELLS : PAD_CELLS + self._columns]
        )
        grid[:, :, :PAD_CELLS] = grid[:, :, PAD_CELLS : PAD_CELLS + 1]
        grid[:, :, -PAD_CELLS:] = grid[:, :, -PAD_CELLS - 1 : -PAD_CELLS]
        grid[:, :above] = grid[:, above : above + 1]
        grid[:, end:] = grid[:, end - 1 : end]


class _Scanner:
    """Scores the windows of given levels in pictures of one size, in memory it keeps."""

    def __init__(self, model: Model, size: ImageSize, levels: tuple[Level, ...]) -> None:
        self.size = size
        self.windows_per_frame = sum(level.window_count for level in levels)
        self._model = model
        self._octaves: list[tuple[_Octave, list[tuple[Level, NDArray[np.int64]]]]] = []
        cut_size = level_size = columns = 1
        for number in sorted({level.octave for level in levels}, reverse=True):
            members = [level for level in levels if level.octave == number]
            octave = _Octave(size, number, members)
            placed = []
            for level in members:
                rows, pitch = (level.rows, level.columns) if level.resized else octave.grid.shape[1:]
                placed.append((level, feature_offsets(model.trees, model.window, rows * pitch, pitch)))
                cut_size = max(cut_size, CHANNEL_COUNT * level.cut_rows * level.cut_columns)
                level_size = max(level_size, CHANNEL_COUNT * level.rows * level.columns)
                columns = max(columns, level.window_columns)
            self._octaves.append((octave, placed))
        self._cut = np.empty(cut_size, np.uint8)
        self._level = np.empty(level_size, np.uint8)
        self._running = np.empty((2, columns), np.float32)
        self._places = np.empty((FIRST_CAPACITY, 2), np.int32)
        self._scores = np.empty(FIRST_CAPACITY, np.float32)
        self._leaves = np.ascontiguousarray(model.trees.leaf, np.float32)
        self._thresholds = np.ascontiguousarray(model.trees.threshold, np.uint8)

    def scan(
        self,
        image: NDArray[np.uint8],
        threshold: float,
        aspect_ratios: Callable[[NDArray[np.float64]], NDArray[np.float64]],
        with_features: bool,
    ) -> Proposals:
        """All windows scored at least `threshold`; `aspect_ratios` are asked for by their bottom rows."""
        boxes: list[NDArray[np.float64]] = []
        scores: list[NDArray[np.float32]] = []
        features: list[NDArray[np.uint8]] = []
        for octave, levels in self._octaves:
            octave.compute(image)
            for level, offsets in levels:
                grids, first_row = self._grids(octave, level)
                count = self._run(grids, level, first_row, offsets, threshold)
                if not count:
                    continue
                rows, columns = self._places[:count, 0], self._places[:count, 1]
                if with_features:
                    features.append(self._features(grids, rows, columns))
                middle, bottom, size_px = level.vehicles(self._model.window, rows - first_row, columns)
                root = np.sqrt(aspect_ratios(bottom))
                w, h = size_px * root, size_px / root
                boxes.append(np.column_stack([middle - w / 2, bottom - h, w, h]))
                scores.append(self._scores[:count].copy())
        if not scores:
            none = np.empty((0, self._model.window.feature_count), np.uint8) if with_features else None
            return Proposals(np.empty((0, 4)), np.empty(0, np.float32), none)
        all_scores = np.concatenate(scores)
        order = np.argsort(-all_scores, kind="stable")
        return Proposals(
            _cut_to_picture(np.concatenate(boxes)[order], self.size),
            all_scores[order],
            np.concatenate(features)[order] if with_features else None,
        )

    def _grids(self, octave: _Octave, level: Level) -> tuple[NDArray[np.uint8], int]:
        """A level's channels (10, rows, columns), and the row among them that is the level's first."""
        first = level.first_cut - octave.first_row
        if not level.resized:
            return octave.grid, first
        cut = self._cut[: CHANNEL_COUNT * level.cut_rows * level.cut_columns]
        cut = cut.reshape(CHANNEL_COUNT, level.cut_rows, level.cut_columns)
        np.copyto(cut, octave.grid[:, first : first + level.cut_rows])
        # All channels in one call: one above the other. Reduced, a row of one takes nothing from the next.
        stacked = self._level[: CHANNEL_COUNT * level.rows * level.columns].reshape(-1, level.columns)
        cv2.resize(
            cut.reshape(-1, level.cut_columns),
            (level.columns, CHANNEL_COUNT * level.rows),
            dst=stacked,
            interpolation=cv2.INTER_LINEAR,
        )
        return stacked.reshape(CHANNEL_COUNT, level.rows, level.columns), 0

    def _run(
        self,
        grids: NDArray[np.uint8],
        level: Level,
        first_row: int,
        offsets: NDArray[np.int64],
        threshold: float,
    ) -> int:
        """Run the cascade; the windows' rows (in `grids`), columns and scores are left in the buffers."""
        while True:
            count = score_windows(
                grids.reshape(-1),
                grids.shape[2],
                first_row + level.first_window,
                first_row + level.end_window,
                level.window_columns,
                offsets,
                self._thresholds,
                self._leaves,
                self._model.rejection_threshold,
                threshold,
                self._running,
                self._places,
                self._scores,
            )
            if count <= len(self._scores):
                return count
            self._places = np.empty((2 * count, 2), np.int32)
            self._scores = np.empty(2 * count, np.float32)

    def _features(
        self, grids: NDArray[np.uint8], rows: NDArray[np.int32], columns: NDArray[np.int32]
    ) -> NDArray[np.uint8]:
        """(N, 2560) features of windows."""
        cells = self._model.window.cells
        windows = np.lib.stride_tricks.sliding_window_view(grids, (cells, cells), (1, 2))
        return windows[:, rows, columns].transpose(1, 0, 2, 3).reshape(len(rows), -1)


@dataclass(frozen=True, slots=True)
class AcfSettings:
    """What the distance-prior detector searches.

    Attributes:
        nearest_m: nearest vehicles looked for, from the camera.
        farthest_m: farthest vehicles looked for.
        pitch_tolerance_rad: braking, bumps and grades tilt the view by so much either way.
        scales_per_octave: window sizes for each doubling.
        largest_scale: how far the picture is enlarged for far vehicles.
        largest_overlap: of two boxes overlapping more (intersection over the smaller area) the better stays.
        score_threshold: score from which a window counts as a vehicle; None: the model's.
    """

    nearest_m: float = 4.0
    farthest_m: float = 80.0
    pitch_tolerance_rad: float = math.radians(1.0)
    scales_per_octave: int = 4
    largest_scale: float = 2.4
    largest_overlap: float = 0.5
    score_threshold: float | None = None


class AcfDetector:
    """ACF with windows that follow from the calibration (section 3.2 of the paper).

    Scales, rows and aspect ratio of the windows come from the distance prior; see `fcw.detection.windows`.
    An instance owns scratch memory: use one for each thread.
    """

    def __init__(
        self,
        model: Model,
        calibration: Calibration,
        settings: AcfSettings = AcfSettings(),
    ) -> None:
        self._model, self._settings = model, settings
        self._prior = DistancePrior(
            calibration.camera,
            model.statistics,
            settings.nearest_m,
            settings.farthest_m,
            settings.pitch_tolerance_rad,
        )
        self.levels = prior_levels(
            calibration.image_size,
            model.window,
            self._prior,
            settings.scales_per_octave,
            settings.largest_scale,
        )
        self._scanner = _Scanner(model, calibration.image_size, self.levels)

    @property
    def name(self) -> str:
        """`acf`."""
        return "acf"

    @property
    def windows_per_frame(self) -> int:
        """Number of windows looked at in each picture."""
        return self._scanner.windows_per_frame

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first.

        Raises:
            ValueError: the picture has another size than the calibration.
        """
        proposals = self.scan(image, _score_threshold(self._settings.score_threshold, self._model))
        return _detections(proposals, self._settings.largest_overlap)

    def scan(self, image: NDArray[np.uint8], threshold: float, with_features: bool = False) -> Proposals:
        """All windows that pass the cascade with a score of at least `threshold`, as training mines them.

        Raises:
            ValueError: the picture has another size than the calibration.
        """
        _check(image, self._scanner.size)
        return self._scanner.scan(image, threshold, self._prior.aspect_ratios, with_features)


@dataclass(frozen=True, slots=True)
class FullAcfSettings:
    """What plain ACF searches; attributes as in `AcfSettings`."""

    scales_per_octave: int = 8
    largest_overlap: float = 0.5
    score_threshold: float | None = None


class FullAcfDetector:
    """Plain ACF: every scale over the whole picture, one aspect ratio; the paper's baseline.

    Takes pictures of any size, and plans anew when it changes. An instance owns scratch memory: use one for
    each thread.
    """

    def __init__(self, model: Model, settings: FullAcfSettings = FullAcfSettings()) -> None:
        self._model, self._settings = model, settings
        self._aspect_ratio = float(np.median(model.statistics.aspect_ratios))
        self._scanner: _Scanner | None = None

    @property
    def name(self) -> str:
        """`acf-full`."""
        return "acf-full"

    @property
    def windows_per_frame(self) -> int:
        """Number of windows looked at in each picture of the last size; 0 before the first."""
        return self._scanner.windows_per_frame if self._scanner else 0

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first."""
        proposals = self.scan(image, _score_threshold(self._settings.score_threshold, self._model))
        return _detections(proposals, self._settings.largest_overlap)

    def scan(self, image: NDArray[np.uint8], threshold: float, with_features: bool = False) -> Proposals:
        """All windows that pass the cascade with a score of at least `threshold`."""
        size = ImageSize(image.shape[1], image.shape[0])
        if self._scanner is None or self._scanner.size != size:
            levels = full_levels(size, self._model.window, self._settings.scales_per_octave)
            self._scanner = _Scanner(self._model, size, levels)
        _check(image, size)
        return self._scanner.scan(
            image, threshold, lambda bottoms: np.full(len(bottoms), self._aspect_ratio), with_features
        )


def _score_threshold(setting: float | None, model: Model) -> float:
    return model.score_threshold if setting is None else setting


def _check(image: NDArray[np.uint8], size: ImageSize) -> None:
    if image.shape != (size.height, size.width, 3) or image.dtype != np.uint8:
        raise ValueError(
            f"the detector expects uint8 BGR pictures of {size}, got {image.dtype} of shape {image.shape}"
        )


def _cut_to_picture(boxes: NDArray[np.float64], size: ImageSize) -> NDArray[np.float64]:
    """The parts of boxes that lie in the picture, whose edges are half a pixel outside its outer pixels."""
    limit = np.array([size.width, size.height]) - 0.5
    near = np.maximum(boxes[:, :2], -0.5)
    far = np.minimum(boxes[:, :2] + boxes[:, 2:], limit)
    return np.column_stack([near, far - near])


def _detections(proposals: Proposals, largest_overlap: float) -> tuple[Detection, ...]:
    kept = suppress(proposals.boxes, proposals.scores, largest_overlap)
    return tuple(Detection(Box(*map(float, proposals.boxes[i])), float(proposals.scores[i])) for i in kept)
