"""The project's own data: where its labels lie, which camera took what, calibrations and terms.

Its folder holds, for each split, TuSimple's motorway frames (`tusimple/`), labelled frames of several drives
(`labels/`), fog, dusk and towns (`streets/`) and single pictures in which only large vehicles are labelled
(`streets/positives_*.json`); `calibrations.txt` there and in `streets/` has a line for each clip.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fcw.bounded.files import MalformedError, read_text
from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.points import PARAMETER_COUNT
from fcw.camera.solve import calibrate
from fcw.detection.training.dataset import LabelledImage, read_labels
from fcw.errors import UserError
from fcw.frame import ImageSize

TABLE = "calibrations.txt"
TRAIN, VALIDATION = "train", "validation"
SPLITS = (TRAIN, VALIDATION)

CAMERAS = {
    "tusimple": "tusimple",
    "udacity": "udacity",
    "kb_": "kb",
    "kitti_object": "kitti_object",
    "solidWhiteRight": "solidWhiteRight",
    "muchlisin": "muchlisin",
    "kitti_sfnd": "sfnd",
    "dawn": "dawn",
    "camvid": "camvid",
    "nuscenes": "nuscenes",
    "mahfuz195": "mahfuz195",
    "level2": "level2",
}
"""Cameras by how the names of their clips begin; dawn and level2 are collections of single photographs."""

RESEARCH_ONLY = frozenset({"kitti_object", "sfnd", "dawn", "camvid", "nuscenes", "mahfuz195", "level2"})
"""Cameras whose pictures' terms forbid commercial use (KITTI: CC BY-NC-SA 3.0) or do not say."""

FRAMES_PER_S = {"camvid": 30.0, "mahfuz195": 12.0}
"""Where the labels number the frames of a drive but do not say how fast they follow each other."""


@dataclass(frozen=True, slots=True)
class Source:
    """A labelled set of the data.

    Attributes:
        name: what it is called.
        labels: its files of labels, `{split}` for the split.
        images: the folder that their file names are relative to.
        complete: whether every vehicle in its pictures has a box.
    """

    name: str
    labels: str
    images: str
    complete: bool = True

    def labels_of(self, data: Path, split: str) -> Path:
        """The labels of a split."""
        return data / self.labels.format(split=split)

    def completed(self, image: LabelledImage) -> LabelledImage:
        """A picture of this set with its camera, and whether all vehicles are labelled."""
        return replace(image, camera=camera_of(image.clip), complete=self.complete and image.complete)


SOURCES = (
    Source("tusimple", "tusimple/{split}_views.json", "tusimple/images"),
    Source("labels", "labels/{split}.json", "labels/images"),
    Source("streets", "streets/{split}.json", "streets/images"),
    Source("positives", "streets/positives_{split}.json", "streets/images", complete=False),
)


def camera_of(clip: str) -> str:
    """The camera that took a clip of the project's data; of other clips, the clip itself."""
    return next((camera for start, camera in CAMERAS.items() if clip.startswith(start)), clip)


def read_own_labels(
    data: Path, splits: Sequence[str] = (TRAIN,), permissive_only: bool = False
) -> tuple[LabelledImage, ...]:
    """The labelled pictures of all sources.

    Args:
        data: the folder.
        splits: of TRAIN and VALIDATION.
        permissive_only: leave out what is RESEARCH_ONLY.

    Raises:
        UserError: as `read_labels`.
    """
    images = (
        source.completed(image)
        for source in SOURCES
        for split in splits
        for image in read_labels(source.labels_of(data, split), data / source.images)
    )
    return tuple(image for image in images if not (permissive_only and image.camera in RESEARCH_ONLY))


def own_calibrations(data: Path) -> Callable[[str], Calibration]:
    """How to find the calibration of a clip of the project's data.

    Returns:
        A function from the clip to its calibration; it raises UserError where there is none.

    Raises:
        UserError: a table is missing or wrong.
    """
    tables = data / TABLE, data / "streets" / TABLE
    calibrations: Mapping[str, Calibration] = {
        clip: calibration for table in tables for clip, calibration in read_calibration_table(table).items()
    }

    def calibration_of(clip: str) -> Calibration:
        if clip not in calibrations:
            raise UserError(
                f"{data}: no calibration for the clip {clip} in {' or '.join(map(str, tables))}; add its line"
            )
        return calibrations[clip]

    return calibration_of


def read_calibration_table(path: Path) -> dict[str, Calibration]:
    """Calibrations by clip: lines of clip, WxH, height in metres, D:V three times, a word of belief.

    Raises:
        UserError: the file is missing or a line is not of that form.
    """
    try:
        lines = read_text(path).splitlines()
    except (OSError, MalformedError) as error:
        raise UserError(f"{path}: cannot read the calibrations ({error})") from None
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
                tape_error=0.0,
                exact=len(pairs) == PARAMETER_COUNT,  # they are rows of a known camera
            )
        except ValueError:
            raise UserError(
                f"{path}, line {number}: {line!r}; expected clip, WxH, height in metres, three or more "
                "distance:row and a word of belief"
            ) from None
    return calibrations
