"""COCO labels with everything that an evaluation needs: attributes of the boxes, times, calibrations."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.formats import json_value
from fcw.camera.calibration import Calibration
from fcw.camera.file import read_calibration
from fcw.detection.training.dataset import (
    NEITHER,
    LabelledImage,
    category_name,
    is_no_vehicle,
    read_coco,
    read_labels,
    vehicle_annotations,
)
from fcw.detection.training.own_data import read_calibration_table
from fcw.errors import UserError


@dataclass(frozen=True, slots=True, eq=False)
class AnnotatedImage:
    """A labelled picture as an evaluation needs it.

    Attributes:
        labelled: the picture and its boxes.
        image_id: its id in the labels.
        time_s: its time in the clip, from `frame` and `fps` of the labels; None if these are missing.
        attributes: the fields of the annotation of each box.
        frame: its number in the clip; None if the labels do not have it.
    """

    labelled: LabelledImage
    image_id: int | str
    time_s: float | None
    attributes: tuple[Mapping[str, Any], ...]
    frame: int | None = None

    @property
    def counted(self) -> NDArray[np.bool_]:
        """(N,) whether a box counts as hit or missed."""
        return ~self.labelled.ignored


def read_annotated(labels: Path, images: Path) -> tuple[AnnotatedImage, ...]:
    """Read COCO labels, and check that each picture exists.

    Args:
        labels: the JSON file.
        images: folder that the `file_name`s are relative to.

    Raises:
        UserError: as `dataset.read_labels`; or there are no pictures, or the file of one is missing.
    """
    labelled = read_labels(labels, images)
    if not labelled:
        raise UserError(f"{labels}: holds no image; expected COCO labels with at least one")
    missing = [image.path for image in labelled if not image.path.is_file()]
    if missing:
        raise UserError(
            f"{missing[0]}: {labels} names this picture, but there is no such file"
            + (f" (nor {len(missing) - 1} others)" if len(missing) > 1 else "")
            + "; give the folder that its file names are relative to with --images"
        )
    content = read_coco(labels)
    pictures = {picture["id"]: picture for picture in content["images"]}
    fields: dict[Any, list[Mapping[str, Any]]] = {identity: [] for identity in pictures}
    for annotation in vehicle_annotations(content):
        _, _, w, h = map(float, annotation["bbox"])
        if 0 not in (w, h):  # the rest says nothing: see read_labels
            fields[annotation["image_id"]].append(annotation)
    annotated = []
    for image, (identity, picture) in zip(labelled, pictures.items(), strict=True):
        if len(fields[identity]) != len(image.boxes):
            raise AssertionError(f"{labels}: image {identity} was read in two ways")
        frame, fps = picture.get("frame"), picture.get("fps")
        time_s = _time_s(labels, frame, fps)
        annotated.append(AnnotatedImage(image, identity, time_s, tuple(fields[identity]), frame))
    return tuple(annotated)


def _time_s(labels: Path, frame: object, fps: object) -> float | None:
    if frame is None or not fps:
        return None
    if not (isinstance(frame, int | float) and isinstance(fps, int | float)):
        raise UserError(f"{labels}: frame {frame!r:.40} at fps {fps!r:.40}; expected numbers")
    return frame / fps


def read_category(labels: Path) -> int:
    """The id of the first category of vehicles that is used in the labels; 1 if none is named.

    Some tools name the whole set as a first category, without an annotation.
    """
    content = read_coco(labels)
    categories = content.get("categories") or [{"id": 1}]
    try:
        used = {annotation.get("category_id") for annotation in vehicle_annotations(content)}
        names = {one["id"]: category_name(one) for one in categories}
        vehicles = [number for number, name in names.items() if not (name in NEITHER or is_no_vehicle(name))]
        return int(min(vehicles, key=lambda number: number not in used, default=1))
    except (AttributeError, KeyError, TypeError, ValueError):
        raise UserError(
            f"{labels}: categories is {categories!r:.80}, expected a list of objects with an id"
        ) from None


def count_only(images: Sequence[AnnotatedImage], conditions: Sequence[str]) -> tuple[AnnotatedImage, ...]:
    """The same pictures, with the boxes that fail a condition ignored.

    Args:
        images: the pictures.
        conditions: `attribute=value` with the value as in JSON (without quotes); all must hold.

    Raises:
        UserError: a condition has another form, names an attribute that no box has, or leaves no vehicle.
    """
    for condition in conditions:
        name, equals, text = condition.partition("=")
        if not (name and equals):
            raise UserError(f"--only {condition}: expected attribute=value, as in --only occluded=0")
        known = {str(fields[name]) for image in images for fields in image.attributes if name in fields}
        if not known:
            raise UserError(f"--only {condition}: no annotation has the attribute {name}; check its spelling")
        value = _parsed(text)
        images = tuple(
            replace(
                image,
                labelled=replace(
                    image.labelled,
                    ignored=image.labelled.ignored
                    | np.array([fields.get(name) != value for fields in image.attributes], bool),
                ),
            )
            for image in images
        )
        if not any(image.counted.any() for image in images):
            raise UserError(
                f"--only {condition}: no vehicle that counts has this; values are {', '.join(sorted(known))}"
            )
    return tuple(images)


def calibration_source(path: Path) -> Callable[[LabelledImage], Calibration]:
    """A function that gives the calibration of a picture.

    Args:
        path: a calibration file for all pictures; a folder with `<clip>.yaml` for each clip; or the table
            `calibrations.txt` of the project's own data.

    Returns:
        A function from a picture to its calibration, scaled to its size; the same object for the same clip
        and size. It raises UserError if there is none.

    Raises:
        UserError: there is no such file or folder, or it is not a calibration.
    """
    if not path.exists():
        raise UserError(
            f"--calibration {path}: no such file or folder; give a calibration file as `fcw calibrate` "
            "saves it, or a folder with <clip>.yaml for each clip"
        )
    if path.is_dir():
        find = _in_folder(path)
    elif path.suffix == ".txt":
        find = _in_table(path)
    else:
        find = _one_for_all(path)
    scaled: dict[tuple[str, Any], Calibration] = {}

    def calibration(image: LabelledImage) -> Calibration:
        key = image.clip, image.size
        if key not in scaled:
            found, origin = find(image)
            try:
                scaled[key] = found.for_image_size(image.size)
            except UserError as error:
                raise UserError(f"{origin}: {error} ({image.path})") from None
        return scaled[key]

    return calibration


def _one_for_all(path: Path) -> Callable[[LabelledImage], tuple[Calibration, Path]]:
    calibration = read_calibration(path)
    return lambda _: (calibration, path)


def _in_folder(folder: Path) -> Callable[[LabelledImage], tuple[Calibration, Path]]:
    def find(image: LabelledImage) -> tuple[Calibration, Path]:
        if not image.clip:
            raise UserError(
                f"{image.path}: the picture's clip is unknown, so that no calibration in {folder} is its; "
                "give the image a `clip` in the labels, or one calibration file for all"
            )
        path = folder / f"{image.clip}.yaml"
        if not path.is_file():
            raise UserError(
                f"{path}: no calibration for the clip {image.clip}, which {image.path.name} is from; "
                "make one with `fcw calibrate --save`, or give one calibration file for all"
            )
        return read_calibration(path), path

    return find


def _in_table(path: Path) -> Callable[[LabelledImage], tuple[Calibration, Path]]:
    table = read_calibration_table(path)

    def find(image: LabelledImage) -> tuple[Calibration, Path]:
        if image.clip not in table:
            raise UserError(f"{path}: no calibration for the clip {image.clip!r}; add its line")
        return table[image.clip], path

    return find


def _parsed(text: str) -> object:
    try:
        return json_value(text)
    except ValueError:
        return text
