"""Labelled pictures for training and measuring: COCO labels, their pictures and the cameras' calibrations.

Two layouts of a training folder are understood:

- one's own: `labels.json` (COCO), `images/`, and `calibration.yaml` for all pictures or
  `calibration/<clip>.yaml` for each clip, as `fcw calibrate` saves them;
- that of the project's own data: `tusimple/train.json`, `labels/train.json` and `calibrations.txt`.

The clip of a picture is the image's `clip` field or else the name of its folder. An annotation with
`"ignore": true` is neither a vehicle to learn from nor background.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.file import read_calibration
from fcw.camera.solve import calibrate
from fcw.detection.boxes.overlap import intersection_areas, intersection_over_union
from fcw.errors import UserError
from fcw.frame import ImageSize

# Pictures whose owners allow no commercial use (KITTI: CC BY-NC-SA 3.0): left out unless asked for.
NON_COMMERCIAL_CLIPS = frozenset({"kitti_object_first31"})

# A window is background only where it shows little of what is known or may be a vehicle.
NEGATIVE_MAX_IOU = 0.3
NEGATIVE_MAX_IGNORED_PART = 0.3
# A window is misplaced where every label that it shows stands in it with an IoU below this, none of them an
# ignored one of at least this part of the window's size: such a one may hold a vehicle in the right place.
MISPLACED_MAX_IOU = 0.45


@dataclass(frozen=True, slots=True, eq=False)
class LabelledImage:
    """One picture and what is known to be in it.

    Attributes:
        path: the picture's file.
        clip: name of the drive that it is from.
        size: width and height that the labels give.
        boxes: (N, 4) x, y, w, h of all labelled vehicles.
        ignored: (N,) boxes that are neither vehicles to find nor background.
    """

    path: Path
    clip: str
    size: ImageSize
    boxes: NDArray[np.float64]
    ignored: NDArray[np.bool_]

    def read(self) -> NDArray[np.uint8]:
        """The picture, (height, width, 3) BGR.

        Raises:
            UserError: the file is missing, is no picture, or has another size than the labels say.
        """
        image = cv2.imread(str(self.path), cv2.IMREAD_COLOR)
        if image is None:
            raise UserError(
                f"{self.path}: cannot read this picture, which the labels name; expected a JPEG or PNG file"
            )
        size = ImageSize(image.shape[1], image.shape[0])
        if size != self.size:
            raise UserError(
                f"{self.path}: the picture is {size}, but the labels give it as {self.size}; "
                "boxes and calibration would not fit: give the picture that was labelled"
            )
        return np.asarray(image, np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class TrainingImage:
    """A labelled picture with its camera's calibration."""

    labelled: LabelledImage
    calibration: Calibration


def read_labels(labels: Path, images: Path) -> tuple[LabelledImage, ...]:
    """Read COCO labels.

    Args:
        labels: the JSON file.
        images: folder that the `file_name`s are relative to.

    Raises:
        UserError: the file is missing, is no COCO JSON, or holds a box without an image or without an area.
    """
    try:
        content = json.loads(labels.read_text())
        pictures = {image["id"]: image for image in content["images"]}
        annotations: dict[Any, list[dict[str, Any]]] = {identity: [] for identity in pictures}
        for annotation in content["annotations"]:
            if annotation["image_id"] not in annotations:
                raise UserError(
                    f"{labels}: annotation {annotation['id']} names image {annotation['image_id']}, "
                    "which is not among the images; remove the annotation or add the image"
                )
            x, y, w, h = map(float, annotation["bbox"])
            if annotation.get("ignore") and w * h == 0:
                continue  # a slip of the annotator that says nothing; the TuSimple labels hold some
            if not (w > 0 and h > 0 and np.isfinite([x, y, w, h]).all()):
                raise UserError(
                    f"{labels}: annotation {annotation['id']} has the box {annotation['bbox']}; "
                    "expected x, y, width, height with a positive width and height"
                )
            annotations[annotation["image_id"]].append(annotation)
        return tuple(
            LabelledImage(
                path=images / picture["file_name"],
                clip=picture.get("clip") or PurePosixPath(picture["file_name"]).parent.name,
                size=ImageSize(int(picture["width"]), int(picture["height"])),
                boxes=np.array([a["bbox"] for a in annotations[identity]], np.float64).reshape(-1, 4),
                ignored=np.array([bool(a.get("ignore")) for a in annotations[identity]], bool),
            )
            for identity, picture in pictures.items()
        )
    except OSError as error:
        raise UserError(
            f"{labels}: cannot read the labels ({error.strerror}); expected a COCO file"
        ) from None
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise UserError(
            f"{labels}: not COCO labels ({type(error).__name__}: {error}); expected JSON with `images` "
            "(id, file_name, width, height) and `annotations` (id, image_id, bbox)"
        ) from error


def background(
    boxes: NDArray[np.float64], labels: NDArray[np.float64], ignored: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which boxes show nothing that is, or may be, a vehicle seen from behind.

    Args:
        boxes: (N, 4) boxes that a detector put out.
        labels: (M, 4) labelled boxes of the same picture.
        ignored: (M,) the labelled boxes that are ignored.

    Returns:
        (N,) False for boxes with IoU >= 0.3 with any label, or covered by 30 % by an ignored one.
    """
    near = intersection_over_union(boxes, labels) >= NEGATIVE_MAX_IOU
    covered = intersection_areas(boxes, labels[ignored]) / np.prod(boxes[:, 2:], axis=1)[:, None]
    return ~(near.any(axis=1) | (covered >= NEGATIVE_MAX_IGNORED_PART).any(axis=1))


def without_vehicle_in_place(
    boxes: NDArray[np.float64], labels: NDArray[np.float64], ignored: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which boxes are background or show vehicles out of place, too small above all: what training rejects.

    Args:
        boxes: (N, 4) boxes of windows.
        labels: (M, 4) labelled boxes of the same picture.
        ignored: (M,) the labelled boxes that are ignored.

    Returns:
        (N,) False for boxes with IoU >= 0.45 with any label, or covered by 30 % by an ignored one that has
        at least 45 % of their area.
    """
    areas = np.prod(boxes[:, 2:], axis=1)[:, None]
    near = intersection_over_union(boxes, labels) >= MISPLACED_MAX_IOU
    covered = intersection_areas(boxes, labels[ignored]) / areas >= NEGATIVE_MAX_IGNORED_PART
    covered &= np.prod(labels[ignored, 2:], axis=1) >= MISPLACED_MAX_IOU * areas
    return ~(near.any(axis=1) | covered.any(axis=1))


def load_training_set(*directories: Path, include_non_commercial: bool = False) -> tuple[TrainingImage, ...]:
    """All labelled pictures of training folders, each in one of the two layouts, with their calibrations.

    Args:
        directories: the folders; the same clip's pictures in two of them go by each one's calibration.
        include_non_commercial: of the project's own data, also the clips whose terms forbid commercial use.

    Raises:
        UserError: a folder has neither layout, a file is missing or wrong, or no vehicle counts in any.
    """
    images = tuple(
        image for directory in directories for image in _load_folder(directory, include_non_commercial)
    )
    if not any((~image.labelled.ignored).any() for image in images):
        names = ", ".join(map(str, directories))
        raise UserError(f"{names}: the labels hold no vehicle that counts (all boxes are ignored)")
    return images


def _load_folder(directory: Path, include_non_commercial: bool) -> tuple[TrainingImage, ...]:
    if (directory / "labels.json").is_file():
        labelled = read_labels(directory / "labels.json", directory / "images")
        calibration_of = _saved_calibrations(directory)
    elif (directory / "calibrations.txt").is_file():
        labelled = read_labels(directory / "tusimple" / "train.json", directory / "tusimple" / "images")
        labelled += read_labels(directory / "labels" / "train.json", directory / "labels" / "images")
        if not include_non_commercial:
            labelled = tuple(image for image in labelled if image.clip not in NON_COMMERCIAL_CLIPS)
        table = read_calibration_table(directory / "calibrations.txt")
        missing = sorted({image.clip for image in labelled} - table.keys())
        if missing:
            raise UserError(
                f"{directory / 'calibrations.txt'}: no calibration for {', '.join(missing)}; add its line"
            )
        calibration_of = table.__getitem__
    else:
        raise UserError(
            f"{directory}: holds neither labels.json nor calibrations.txt; expected a folder with "
            "labels.json (COCO), images/ and calibration.yaml or calibration/<clip>.yaml"
        )
    cameras = {
        key: calibration_of(key[0]).for_image_size(key[1]) for key in {(i.clip, i.size) for i in labelled}
    }
    return tuple(TrainingImage(image, cameras[image.clip, image.size]) for image in labelled)


def read_calibration_table(path: Path) -> dict[str, Calibration]:
    """Calibrations of the project's own data: lines of clip, WxH, height in metres, D:V three times, belief.

    Raises:
        UserError: the file is missing or a line is not of that form.
    """
    try:
        lines = path.read_text().splitlines()
    except OSError as error:
        raise UserError(f"{path}: cannot read the calibrations ({error.strerror})") from None
    calibrations: dict[str, Calibration] = {}
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            clip, size, height_m, *points, _belief = line.split()
            width, height = size.split("x")
            pairs = [point.split(":") for point in points]
            calibrations[clip] = calibrate(
                tuple(GroundPoint(float(distance_m), float(row_px)) for distance_m, row_px in pairs),
                ImageSize(int(width), int(height)),
                float(height_m),
            )
        except ValueError:
            raise UserError(
                f"{path}, line {number}: {line!r}; expected clip, WxH, height in metres, three or more "
                "distance:row and a word of belief"
            ) from None
    return calibrations


def _saved_calibrations(directory: Path) -> Callable[[str], Calibration]:
    """How to find a clip's calibration beside `labels.json`."""
    if (directory / "calibration.yaml").is_file():
        shared = read_calibration(directory / "calibration.yaml")
        return lambda clip: shared
    return lambda clip: read_calibration(directory / "calibration" / f"{clip}.yaml")
