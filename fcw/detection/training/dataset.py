"""Labelled pictures for training and measuring: COCO labels, and which windows may serve as background.

The clip of a picture is the image's `clip` field or else the name of its folder. An image with
`"complete": false` has vehicles without a box, so that nothing in it is sure to be background. An annotation
with `"ignore": true` is neither a vehicle to learn from nor background. `rear_box` is the rear face of a
vehicle that is seen from a corner: who finds that has found the vehicle too.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.files import read_text
from fcw.bounded.formats import MOST_JSON_BYTES, json_value
from fcw.bounded.pictures import read_picture
from fcw.camera.calibration import Calibration
from fcw.detection.boxes.overlap import intersection_areas, vehicle_overlap
from fcw.detection.matching import LabelledDetections
from fcw.errors import UserError
from fcw.frame import ImageSize

# A window is background only where it shows little of what is known or may be a vehicle.
NEGATIVE_MAX_IOU = 0.3
NEGATIVE_MAX_IGNORED_PART = 0.3
# A window is misplaced where every label that it shows stands in it with an IoU below this, none of them an
# ignored one of at least this part of the window's size: such a one may hold a vehicle in the right place.
MISPLACED_MAX_IOU = 0.45

MOST_BOXES = 2000
"""In one picture: every box is compared with every other."""
PEOPLE = {"person", "people", "pedestrian", "child", "rider", "cyclist", "biker", "motorcyclist"}
ANIMALS = {"animal", "bird", "cat", "dog", "horse", "sheep", "cow"}
ROADSIDE = {
    "sign",
    "stopsign",
    "trafficcone",
    "cone",
    "barrier",
    "pole",
    "firehydrant",
    "parkingmeter",
    "bench",
}
NO_VEHICLES = PEOPLE | ANIMALS | ROADSIDE | {"train"}
"""Categories of COCO, KITTI, BDD100K, Cityscapes, nuImages, Waymo and Udacity, on roads and beside them, that
are no vehicles ahead, as `category_name` gives them."""
NO_VEHICLES_BEGIN = ("trafficlight", "trafficsign")
"""Names of further ones begin so: `trafficLight-Red`."""
NEITHER = {"bicycle", "bike", "motorcycle", "motorbike", "motor", "dontcare", "misc"}
"""Names of those that are neither hit nor false: two-wheelers, and what nobody labelled one by one."""
NO_BOX = (float("nan"),) * 4
"""The row of an array of boxes that stands for none."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledImage:
    """One picture and what is known to be in it.

    Attributes:
        path: the picture's file.
        clip: name of the drive that it is from.
        size: width and height that the labels give.
        boxes: (N, 4) x, y, w, h of all labelled vehicles.
        ignored: (N,) boxes that are neither vehicles to find nor background.
        rear_boxes: (N, 4) of the vehicles' rear faces, NaN in the rows of those that have none.
        complete: whether every vehicle has a box. Else nothing beside the boxes is sure to be background:
            none is learnt from the picture, and no false positive is counted in it.
        camera: name of the camera that took it, which may have taken several clips.
    """

    path: Path
    clip: str
    size: ImageSize
    boxes: NDArray[np.float64]
    ignored: NDArray[np.bool_]
    rear_boxes: NDArray[np.float64]
    complete: bool = True
    camera: str = ""

    def with_detections(self, boxes: NDArray[np.float64], scores: NDArray[np.float64]) -> LabelledDetections:
        """What a detector found in the picture, (D, 4) boxes with (D,) scores, beside its labels."""
        return LabelledDetections(boxes, scores, self.boxes, self.ignored, self.rear_boxes, self.complete)

    def read(self) -> NDArray[np.uint8]:
        """The picture, (height, width, 3) BGR.

        Raises:
            UserError: the file is missing, is no picture, or has another size than the labels say.
        """
        image = read_picture(self.path)
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
        return image


@dataclass(frozen=True, slots=True, eq=False)
class TrainingImage:
    """A labelled picture with its camera's calibration."""

    labelled: LabelledImage
    calibration: Calibration


def read_coco(labels: Path) -> Any:  # noqa: ANN401 - JSON has no type
    """What a JSON file of labels holds.

    Raises:
        OSError: it cannot be read.
        ValueError: it is no JSON, or larger than it may be.
    """
    return json_value(read_text(labels, MOST_JSON_BYTES))


def vehicle_annotations(content: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Annotations of COCO labels without those of categories that are no vehicles by their names.

    Two-wheelers, and crowds of vehicles, are ignored: `ignore` is set. Other names all count. Of what is
    followed beyond the picture's edge, as our own exports have it, nothing can be seen: it is left out.
    """
    sizes = {picture["id"]: _size(picture) for picture in content["images"]}
    names = {one["id"]: category_name(one) for one in content.get("categories") or ()}
    for annotation in content["annotations"]:
        name = names.get(annotation.get("category_id"), "")
        size = sizes.get(annotation.get("image_id"))
        if is_no_vehicle(name) or (size is not None and _lies_outside(annotation["bbox"], size)):
            continue
        neither = annotation.get("iscrowd") or name in NEITHER
        yield {**annotation, "ignore": True} if neither else annotation


def category_name(category: Mapping[str, Any]) -> str:
    """Its letters and digits in lower case: `traffic light`, `traffic_light`, `trafficLight` are one name."""
    name = "".join(filter(str.isalnum, str(category.get("name", "")).lower()))
    return name.removesuffix("sitting")


def is_no_vehicle(name: str) -> bool:
    """Whether what has this name, of `category_name`, is no vehicle ahead."""
    return name in NO_VEHICLES or name.startswith(NO_VEHICLES_BEGIN)


def read_labels(labels: Path, images: Path) -> tuple[LabelledImage, ...]:
    """Read COCO labels; of several categories those that are vehicles, see `vehicle_annotations`.

    Args:
        labels: the JSON file.
        images: folder that the `file_name`s are relative to.

    Raises:
        UserError: the file is missing, is no COCO JSON, or holds a box without an image or without an area.
    """
    try:
        content = read_coco(labels)
        pictures = {image["id"]: image for image in content["images"]}
        _check_each_once(labels, content["images"])
        annotations: dict[Any, list[dict[str, Any]]] = {identity: [] for identity in pictures}
        for annotation in vehicle_annotations(content):
            if annotation["image_id"] not in annotations:
                raise UserError(
                    f"{labels}: annotation {annotation['id']} names image {annotation['image_id']}, "
                    "which is not among the images; remove the annotation or add the image"
                )
            x, y, w, h = map(float, annotation["bbox"])
            if annotation.get("ignore") and 0 in (w, h):
                continue  # a slip of the annotator that says nothing; the TuSimple labels hold some
            if not (w > 0 and h > 0 and np.isfinite([x, y, w, h]).all()):
                raise UserError(
                    f"{labels}: annotation {annotation['id']} has the box {annotation['bbox']}; "
                    "expected x, y, width, height with a positive width and height"
                )
            _check_rear_box(labels, annotation)
            annotations[annotation["image_id"]].append(annotation)
            if len(annotations[annotation["image_id"]]) > MOST_BOXES:
                raise UserError(
                    f"{labels}: image {annotation['image_id']} has more than {MOST_BOXES} boxes; "
                    "expected the vehicles of one picture"
                )
        return tuple(
            _labelled(picture, annotations[identity], images) for identity, picture in pictures.items()
        )
    except OSError as error:
        raise UserError(
            f"{labels}: cannot read the labels ({error.strerror}); expected a COCO file"
        ) from None
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, IndexError) as error:
        raise UserError(
            f"{labels}: not COCO labels ({type(error).__name__}: {error}); expected JSON with `images` "
            "(id, file_name, width, height) and `annotations` (id, image_id, bbox)"
        ) from error


def _check_each_once(labels: Path, images: Sequence[Mapping[str, Any]]) -> None:
    """See that no two images have one id or one file: boxes of the one would be missing in the other."""
    for field, mend in (
        ("id", "number the images of one file anew"),
        ("file_name", "give their boxes to one image"),
    ):
        (value, count), *_ = Counter(image[field] for image in images).most_common(1) or [(None, 0)]
        if count > 1:
            raise UserError(
                f"{labels}: {count} images have the {field} {value}, so boxes of one would be missing in "
                f"another; expected one image for each {field}: where labels were joined, {mend}"
            )


def _labelled(
    picture: Mapping[str, Any], annotations: Sequence[Mapping[str, Any]], images: Path
) -> LabelledImage:
    clip = picture.get("clip") or PurePosixPath(picture["file_name"]).parent.name
    size = _size(picture)
    rear_boxes = [_inside(a["rear_box"], size) if a.get("rear_box") else NO_BOX for a in annotations]
    return LabelledImage(
        path=images / picture["file_name"],
        clip=clip,
        size=size,
        boxes=np.array([_inside(a["bbox"], size) for a in annotations], np.float64).reshape(-1, 4),
        ignored=np.array([bool(a.get("ignore")) for a in annotations], bool),
        rear_boxes=np.array(rear_boxes, np.float64).reshape(-1, 4),
        complete=bool(picture.get("complete", True)),
        camera=clip,
    )


def _size(picture: Mapping[str, Any]) -> ImageSize:
    return ImageSize(int(picture["width"]), int(picture["height"]))


def _lies_outside(bbox: Sequence[float], size: ImageSize) -> bool:
    """Whether nothing of a box is in the picture."""
    x, y, w, h = map(float, bbox)
    return w > 0 and h > 0 and (x >= size.width or y >= size.height or x + w <= 0 or y + h <= 0)


def _inside(bbox: Sequence[float], size: ImageSize) -> tuple[float, float, float, float]:
    """The part of a box in the picture, as detectors give it; parts of a pixel beyond do not matter."""
    x, y, w, h = map(float, bbox)
    left, top, right, bottom = max(x, 0.0), max(y, 0.0), min(x + w, size.width), min(y + h, size.height)
    if max(left - x, top - y, x + w - right, y + h - bottom) < 1.0 or left >= right or top >= bottom:
        return x, y, w, h
    return left, top, right - left, bottom - top


def _check_rear_box(labels: Path, annotation: Mapping[str, Any]) -> None:
    rear_box = annotation.get("rear_box")
    if rear_box is None:
        return
    x, y, w, h = map(float, rear_box)
    if not (w > 0 and h > 0 and np.isfinite([x, y, w, h]).all()):
        raise UserError(
            f"{labels}: annotation {annotation['id']} has the rear_box {rear_box}; "
            "expected null or x, y, width, height with a positive width and height"
        )


def background(
    boxes: NDArray[np.float64],
    labels: NDArray[np.float64],
    ignored: NDArray[np.bool_],
    rear_boxes: NDArray[np.float64] | None = None,
) -> NDArray[np.bool_]:
    """Which boxes show nothing that is, or may be, a vehicle seen from behind.

    Args:
        boxes: (N, 4) boxes that a detector put out.
        labels: (M, 4) labelled boxes of the same picture.
        ignored: (M,) the labelled boxes that are ignored.
        rear_boxes: (M, 4) of the rear faces, NaN where there is none; None: there are none.

    Returns:
        (N,) False for boxes with IoU >= 0.3 with any label or rear face, or covered by 30 % by an ignored
        label.
    """
    near = vehicle_overlap(boxes, labels, rear_boxes) >= NEGATIVE_MAX_IOU
    covered = intersection_areas(boxes, labels[ignored]) / np.prod(boxes[:, 2:], axis=1)[:, None]
    return ~(near.any(axis=1) | (covered >= NEGATIVE_MAX_IGNORED_PART).any(axis=1))


def without_vehicle_in_place(
    boxes: NDArray[np.float64],
    labels: NDArray[np.float64],
    ignored: NDArray[np.bool_],
    rear_boxes: NDArray[np.float64] | None = None,
) -> NDArray[np.bool_]:
    """Which boxes are background or show vehicles out of place, too small above all: what training rejects.

    Args:
        boxes: (N, 4) boxes of windows.
        labels: (M, 4) labelled boxes of the same picture.
        ignored: (M,) the labelled boxes that are ignored.
        rear_boxes: (M, 4) of the rear faces, NaN where there is none; None: there are none.

    Returns:
        (N,) False for boxes with IoU >= 0.45 with any label or rear face, or covered by 30 % by an ignored
        label that has at least 45 % of their area.
    """
    areas = np.prod(boxes[:, 2:], axis=1)[:, None]
    near = vehicle_overlap(boxes, labels, rear_boxes) >= MISPLACED_MAX_IOU
    covered = intersection_areas(boxes, labels[ignored]) / areas >= NEGATIVE_MAX_IGNORED_PART
    covered &= np.prod(labels[ignored, 2:], axis=1) >= MISPLACED_MAX_IOU * areas
    return ~(near.any(axis=1) | covered.any(axis=1))
