"""Detectors by their names on the command line."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from fcw.bounded.arrays import npz_arrays
from fcw.bounded.files import MalformedError
from fcw.camera.calibration import Calibration
from fcw.detection.acf import AcfDetector, AcfSettings, FullAcfDetector, FullAcfSettings
from fcw.detection.detector import Detector
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.detection.net.detector import NetDetector, NetSettings
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel
from fcw.detection.onnx.detector import OnnxDetector, OnnxModel
from fcw.errors import UserError

NET, ACF, ACF_FULL, ONNX_PREFIX = "net", "acf", "acf-full", "onnx:"
DETECTOR_NAMES = (NET, ACF, ACF_FULL, f"{ONNX_PREFIX}FILE")
DEFAULT_DETECTOR = NET
"""The best one on cameras left out (`benchmarks/leave_one_camera_out.py`); `acf` is the paper's."""
FAINT_MARGIN = 1.5
"""How far below the net's threshold a logit still counts as faint, for a tracker.

Chosen on seven clips of strangers: a larger margin finds hardly more of the tracked vehicles
(docs/figures/detection.md, "Faint boxes").
"""
SEARCHED_RAD = math.radians(12.0)
"""Tolerance of the pitch of an uncalibrated camera, within which far vehicles are searched for. Nine of ten
cameras that people mount to look ahead are within it (`fcw.camera.prior_sigmas`)."""
SEARCHED_TOLERANCES = (1.0, 2.0)
"""`NetSettings.size_tolerances` of such a search. With 6 for both, one clip of 28 (of strangers) was
calibrated with its horizon 18 % of the picture too low."""
SEARCHED_SCORE = 3.5
"""Score threshold of such a search, which cannot know that a house is too large to be a vehicle.

Two of five boxes below it were no vehicle or not as wide as one; of those above it, one in six (ten clips of
the data and 32 of strangers, on which it was chosen).
"""

DetectorModel = NetModel | Model | OnnxModel


def model_path(name: str, path: Path | None = None) -> Path:
    """The file of a detector's model.

    Args:
        name: `net`, `acf`, `acf-full` or `onnx:FILE`.
        path: another model than the shipped one; not for `onnx:FILE`.

    Raises:
        UserError: there is no detector of that name, or an ONNX model is named twice or without a file.
    """
    if name.startswith(ONNX_PREFIX):
        if path is not None:
            raise UserError(f"--model {path}: --detector {name} names a model already; leave one of them out")
        if name == ONNX_PREFIX:
            raise UserError(f"--detector {name}: no file is named; expected {ONNX_PREFIX}FILE, an ONNX model")
        return Path(name.removeprefix(ONNX_PREFIX))
    if name not in DETECTOR_NAMES:
        raise UserError(f"--detector {name}: no such detector; expected one of {', '.join(DETECTOR_NAMES)}")
    return path or (SHIPPED_NET_PATH if name == NET else SHIPPED_MODEL_PATH)


def load_model(name: str, classes: Sequence[str] = (), path: Path | None = None) -> DetectorModel:
    """Load the model of a detector, once for all its threads.

    Args:
        name: `net`, `acf`, `acf-full` or `onnx:FILE`.
        classes: names of the classes of an ONNX model that are vehicles; see `OnnxModel.load`.
        path: another model than the shipped one; not for `onnx:FILE`.

    Raises:
        UserError: there is no detector of that name, its model cannot be used, or classes are given to a
            detector that has none.
    """
    file = model_path(name, path)
    if name.startswith(ONNX_PREFIX):
        return OnnxModel.load(file, classes)
    if classes:
        raise UserError(
            f"--detector-classes {' '.join(classes)}: --detector {name} finds vehicles alone; expected only "
            f"with --detector {ONNX_PREFIX}FILE"
        )
    try:
        return NetModel.load(file) if name == NET else Model.load(file)
    except UserError:
        written_for = _detector_of(file)
        if written_for is None or (name == NET) == (written_for == NET):
            raise
        raise UserError(
            f"{file}: a model of {written_for}, but --detector {name} is to use it; "
            f"name --detector {written_for}"
        ) from None


def _detector_of(file: Path) -> str | None:
    """The name of the detector whose model a file holds, by its arrays; None if it holds none."""
    try:
        arrays = npz_arrays(file)
    except (OSError, MalformedError):
        return None
    return next((name for name, array in ((NET, "look"), (ACF, "first_feature")) if array in arrays), None)


def make_detector(
    name: str,
    model: DetectorModel,
    calibration: Calibration,
    score_threshold: float | None = None,
    largest_scale: float | None = None,
    for_tracker: bool = False,
) -> Detector:
    """A detector by its name, for one thread.

    Args:
        name: `net`, `acf`, `acf-full` or `onnx:FILE`.
        model: its model, from `load_model`.
        calibration: calibration for the image size.
        score_threshold: least score of a detection; None for the model's own.
        largest_scale: largest factor by which pictures are enlarged, not for `onnx:FILE`; None for the
            detector's default.
        for_tracker: whether it returns faint boxes as well, which only `net` can.

    Raises:
        UserError: there is no detector of that name, or the calibration puts the road outside the picture.
    """
    if isinstance(model, OnnxModel):
        return OnnxDetector(model, calibration, score_threshold)
    model_path(name)
    enlarging = {} if largest_scale is None else {"largest_scale": largest_scale}
    if isinstance(model, NetModel):
        margin = FAINT_MARGIN if for_tracker else 0.0
        settings = NetSettings(score_threshold=score_threshold, faint_margin=margin)
        return NetDetector(model, calibration, replace(settings, **enlarging))
    if name == ACF:
        settings = AcfSettings(score_threshold=score_threshold)
        return AcfDetector(model, calibration, replace(settings, **enlarging))
    return FullAcfDetector(model, replace(FullAcfSettings(score_threshold=score_threshold), **enlarging))


def searching_detector(guess: Calibration) -> Detector:
    """A detector for an uncalibrated camera, which searches wherever the road may be.

    Args:
        guess: a rough calibration for the image size.
    """
    model = load_model(NET)
    assert isinstance(model, NetModel)
    settings = NetSettings(
        pitch_tolerance_rad=SEARCHED_RAD, size_tolerances=SEARCHED_TOLERANCES, score_threshold=SEARCHED_SCORE
    )
    return NetDetector(model, guess, settings)
