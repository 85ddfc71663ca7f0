"""Training folders: labelled pictures with the calibrations of their cameras.

Two layouts are understood:

- one's own: `labels.json` (COCO), `images/`, and `calibration.yaml` for all pictures or
  `calibration/<clip>.yaml` for each clip, as `fcw calibrate` saves them;
- that of the project's own data (`fcw.detection.training.own_data`).
"""

from collections.abc import Callable
from pathlib import Path

from fcw.camera.calibration import Calibration
from fcw.camera.file import read_calibration
from fcw.detection.training.dataset import TrainingImage, read_labels
from fcw.detection.training.own_data import TABLE, own_calibrations, read_own_labels
from fcw.errors import UserError


def load_training_set(*directories: Path, permissive_only: bool = False) -> tuple[TrainingImage, ...]:
    """All labelled pictures of training folders, each in one of the two layouts, with their calibrations.

    Args:
        directories: the folders; the same clip's pictures in two of them go by each one's calibration.
        permissive_only: of the project's own data, leave out the pictures whose terms forbid commercial use
            or leave it open.

    Raises:
        UserError: a folder has neither layout, a file is missing or wrong, or no vehicle counts in any.
    """
    images = tuple(image for directory in directories for image in _load_folder(directory, permissive_only))
    if not any((~image.labelled.ignored).any() for image in images):
        names = ", ".join(map(str, directories))
        raise UserError(f"{names}: the labels hold no vehicle that counts (all boxes are ignored)")
    return images


def _load_folder(directory: Path, permissive_only: bool) -> tuple[TrainingImage, ...]:
    if (directory / "labels.json").is_file():
        labelled = read_labels(directory / "labels.json", directory / "images")
        calibration_of = _saved_calibrations(directory)
    elif (directory / TABLE).is_file():
        labelled = read_own_labels(directory, permissive_only=permissive_only)
        calibration_of = own_calibrations(directory)
    else:
        raise UserError(
            f"{directory}: holds neither labels.json nor {TABLE}; expected a folder with "
            "labels.json (COCO), images/ and calibration.yaml or calibration/<clip>.yaml"
        )
    cameras: dict[object, Calibration] = {}
    for image in labelled:
        if (image.clip, image.size) not in cameras:
            calibration = calibration_of(image.clip)
            try:
                cameras[image.clip, image.size] = calibration.for_image_size(image.size)
            except UserError as error:  # which of many clips it is
                raise UserError(f"{image.path}: {error}") from None
    return tuple(TrainingImage(image, cameras[image.clip, image.size]) for image in labelled)


def _saved_calibrations(directory: Path) -> Callable[[str], Calibration]:
    """How to find a clip's calibration beside `labels.json`."""
    if (directory / "calibration.yaml").is_file():
        shared = read_calibration(directory / "calibration.yaml")
        return lambda clip: shared
    return lambda clip: read_calibration(directory / "calibration" / f"{clip}.yaml")
