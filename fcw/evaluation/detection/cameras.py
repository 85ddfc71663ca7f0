"""Leave-one-camera-out: each camera of the project's data is tested with a model that never saw it.

The scores of models that were trained on different pictures are pooled in one curve, as if they came from one
model. If a threshold means something different to each model, the figures get worse, not better.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.arrays import npz_arrays
from fcw.camera.calibration import Calibration
from fcw.detection.training.dataset import LabelledImage, TrainingImage
from fcw.detection.training.own_data import FRAMES_PER_S, SOURCES, SPLITS, VALIDATION, own_calibrations
from fcw.errors import UserError
from fcw.evaluation.detection.detectors import CalibrationOf, DetectorOf, FrameDetections, run_detectors
from fcw.evaluation.detection.labels import AnnotatedImage, read_annotated
from fcw.files import whole_file

Group = tuple[str, ...]
GROUPS: tuple[Group, ...] = (
    ("tusimple",),
    ("udacity", "solidWhiteRight", "muchlisin"),
    ("kb", "sfnd", "kitti_object"),
    ("dawn",),
    ("camvid", "nuscenes", "mahfuz195"),
)
"""Groups of cameras that are left out together, to save trainings."""
M_co = TypeVar("M_co", covariant=True)
M = TypeVar("M")


class Fit(Protocol[M_co]):
    """A trainer, which makes a model of any kind from labelled pictures."""

    def __call__(self, images: Sequence[TrainingImage], /) -> M_co:
        """Train a model."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class LabelledCameras:
    """All labelled pictures of the project's data.

    Attributes:
        data: the folder of the data.
        images: the pictures.
        held_out: (N,) whether a picture is never used for training.
        calibration_of: the calibrations of the pictures.
    """

    data: Path
    images: tuple[AnnotatedImage, ...]
    held_out: NDArray[np.bool_]
    calibration_of: CalibrationOf

    @property
    def cameras(self) -> NDArray[np.str_]:
        """(N,) camera of each picture."""
        return np.array([image.labelled.camera for image in self.images])

    @property
    def complete(self) -> NDArray[np.bool_]:
        """(N,) whether every vehicle in a picture is labelled."""
        return np.array([image.labelled.complete for image in self.images])

    def training(self, indices: NDArray[np.int64]) -> tuple[TrainingImage, ...]:
        """Some of the pictures, for training."""
        labelled = [self.images[index].labelled for index in indices]
        return tuple(TrainingImage(image, self.calibration_of(image)) for image in labelled)

    def name(self, index: int) -> str:
        """The path of a picture in the data."""
        return self.images[index].labelled.path.relative_to(self.data).as_posix()


@dataclass(frozen=True, slots=True, eq=False)
class Fold:
    """A group of cameras that is left out.

    Attributes:
        name: name of the group.
        learnt: indices of the pictures to train on.
        tested: indices of the pictures to test on.
    """

    name: str
    learnt: NDArray[np.int64]
    tested: NDArray[np.int64]


def read_cameras(data: Path) -> LabelledCameras:
    """Read both splits of all sources of the project's data.

    Each picture in which only some vehicles are labelled comes from a camera of its own. Of these pictures,
    the validation split is held out.

    Raises:
        UserError: as `read_annotated` and `own_calibrations`.
    """
    images: list[AnnotatedImage] = []
    held_out: list[bool] = []
    for source in SOURCES:
        for split in SPLITS:
            for image in read_annotated(source.labels_of(data, split), data / source.images):
                labelled = source.completed(image.labelled)
                images.append(replace(image, labelled=labelled, time_s=_time_s(image, labelled.camera)))
                held_out.append(not source.complete and split == VALIDATION)
    of_clip = own_calibrations(data)
    scaled: dict[object, Calibration] = {}

    def calibration_of(image: LabelledImage) -> Calibration:
        key = image.clip, image.size
        if key not in scaled:
            scaled[key] = of_clip(image.clip).for_image_size(image.size)
        return scaled[key]

    return LabelledCameras(data, tuple(images), np.array(held_out, bool), calibration_of)


def folds(cameras: LabelledCameras, groups: Sequence[Group]) -> tuple[Fold, ...]:
    """The pictures that each model is trained and tested on; the cameras of a group are in one test only.

    Cameras in no group are used for training in every fold and are never tested. The same holds for
    incomplete pictures, except those that are held out, which are divided among the folds.

    Raises:
        UserError: a group names a camera that does not exist, or names one twice.
    """
    names, complete = cameras.cameras, cameras.complete
    known = sorted(set(names[complete].tolist()))
    given = [camera for group in groups for camera in group]
    for camera in given:
        if camera not in known or given.count(camera) > 1:
            raise UserError(
                f"--groups: {camera} is {'named twice' if camera in known else 'no camera of the data'}; "
                f"expected cameras of {', '.join(known)}, each once, those of a group joined by +"
            )
    shared = np.flatnonzero(cameras.held_out)
    made = []
    for number, group in enumerate(groups):
        left_out = complete & np.isin(names, group)
        made.append(
            Fold(
                name="+".join(group),
                learnt=np.flatnonzero(~left_out & ~cameras.held_out),
                tested=np.concatenate([np.flatnonzero(left_out), shared[number :: len(groups)]]),
            )
        )
    return tuple(made)


def detect_left_out(
    cameras: LabelledCameras,
    fold: Fold,
    fit: Fit[M],
    detectors: Mapping[str, Callable[[M, CalibrationOf], DetectorOf]],
    advance: Callable[[], None] = lambda: None,
) -> dict[str, "Found"]:
    """Train without the cameras of a fold, and detect in their pictures.

    Args:
        cameras: all pictures.
        fold: the fold to leave out.
        fit: the trainer.
        detectors: by name, functions that make a detector from the model, which gives boxes of every score.
        advance: called after each picture.

    Returns:
        What was found, by the same names.
    """
    model = fit(cameras.training(fold.learnt))
    made = {name: make(model, cameras.calibration_of) for name, make in detectors.items()}
    return detect_in(cameras, fold.tested, made, advance)


def detect_in(
    cameras: LabelledCameras,
    indices: NDArray[np.int64],
    detectors: Mapping[str, DetectorOf],
    advance: Callable[[], None] = lambda: None,
) -> dict[str, "Found"]:
    """Detect in some of the pictures with detectors that were trained elsewhere."""
    runs = run_detectors([cameras.images[index] for index in indices], detectors, advance)
    names = [cameras.name(int(index)) for index in indices]
    return {name: Found(dict(zip(names, frames, strict=True))) for name, frames in runs.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What a detector found, with boxes of every score.

    Attributes:
        pictures: detections by the path of the picture in the data.
        groups: names of the groups that were left out; empty if the detector was trained elsewhere.
    """

    pictures: Mapping[str, FrameDetections]
    groups: tuple[str, ...] = ()

    def has(self, cameras: LabelledCameras, indices: NDArray[np.int64]) -> bool:
        """Whether all of some pictures have been searched."""
        return all(cameras.name(int(index)) in self.pictures for index in indices)

    def on(self, cameras: LabelledCameras, indices: NDArray[np.int64]) -> tuple[FrameDetections, ...]:
        """The detections in some pictures, in the same order."""
        return tuple(self.pictures[cameras.name(int(index))] for index in indices)

    def with_more(self, other: "Found") -> "Found":
        """The same together with the detections in other pictures."""
        return replace(self, pictures={**self.pictures, **other.pictures})

    def save(self, path: Path) -> None:
        """Write a complete NumPy archive, or nothing.

        Raises:
            UserError: the file cannot be written.
        """
        frames = self.pictures.values()
        with whole_file(path) as partial, partial.open("wb") as file:
            np.savez_compressed(
                file,
                allow_pickle=False,
                groups=np.array(self.groups, np.str_),
                pictures=np.array(list(self.pictures), np.str_),
                counts=np.array([len(frame.scores) for frame in frames], np.int64),
                boxes=np.concatenate([np.zeros((0, 4)), *(frame.boxes for frame in frames)]),
                scores=np.concatenate([np.zeros(0), *(frame.scores for frame in frames)]),
            )

    @classmethod
    def load(cls, path: Path) -> "Found":
        """Read what `save` wrote.

        Raises:
            UserError: the file cannot be read, or contains something else.
        """
        try:
            file = npz_arrays(path)
            ends = np.cumsum(file["counts"])[:-1]
            parts = zip(np.split(file["boxes"], ends), np.split(file["scores"], ends), strict=True)
            frames = [FrameDetections(boxes, scores, float("nan"), None) for boxes, scores in parts]
            pictures = dict(zip(file["pictures"].tolist(), frames, strict=True))
            return cls(pictures, tuple(file["groups"].tolist()))
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise UserError(f"{path}: no detections that this program kept ({error})") from error


def _time_s(image: AnnotatedImage, camera: str) -> float | None:
    """The time of a picture in its clip, from the labels or else from the known rate of the drive."""
    if image.time_s is not None or camera not in FRAMES_PER_S or image.frame is None:
        return image.time_s
    return image.frame / FRAMES_PER_S[camera]
