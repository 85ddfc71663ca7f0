"""A detector plugged in as an ONNX file: nets of the YOLO family, filtered by the distance prior."""

import ast
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.bounded.memory import at_most_more
from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.boxes.overlap import cut_to_picture
from fcw.detection.boxes.plausible import ROAD_VEHICLES, PlausibleVehicles, plausible
from fcw.detection.detector import Aim, Detection
from fcw.detection.onnx.yolo import (
    PAD_VALUE,
    Layout,
    Letterbox,
    class_count,
    decode,
    expected_shapes,
    recognise,
)
from fcw.errors import UserError
from fcw.frame import ImageSize

if TYPE_CHECKING:
    import onnxruntime

INSTALL_COMMAND = "pip install 'fcw[onnx]'"
COCO_CLASS_COUNT = 80
COCO_VEHICLES: Mapping[str, int] = {"bicycle": 1, "car": 2, "motorcycle": 3, "bus": 5, "truck": 7}
"""Numbers of COCO's classes, for models that do not name theirs."""
DEFAULT_CLASSES = ("car", "truck", "bus", "van", "vehicle")
"""Those whose usual widths the tracker knows; of these the model's own are taken."""
SHOWN_BY_DEFAULT = ImageSize(640, 640)
"""For models that take any size and do not say which they were trained on."""
INPUT_TYPES = {"tensor(float)": np.float32, "tensor(float16)": np.float16}
SCORE_THRESHOLD = 0.25
"""From which the family's own programs show a box."""
LOWEST_SCORE = 0.001
"""Lower ones are not put out, whatever the threshold: every cell has a box. The family's own evaluations
begin there.
"""

LARGEST_SHOWN_PX = 4096
MOST_CLASSES = 100_000
MOST_PUT_OUT = 1 << 24
"""Numbers; nets of 1280 px with the finest heads and 80 classes put out 11 million."""
MOST_BYTES_AT_FIRST = 1 << 30
"""For the graph and one picture, and as often as a file's bytes are copied while it is opened."""
COPIES_OF_FILE = 4
MOST_BOXES = 3000
"""The best of those that can be vehicles; a net that is sure of more is not looking at a road."""
LONGEST_NAMES = 1 << 20


@dataclass(frozen=True, slots=True, eq=False)
class OnnxModel:
    """A net that is loaded, shared by the threads that use it.

    Attributes:
        path: its file.
        session: onnxruntime's.
        input_name: of its picture.
        input_type: of the picture's numbers.
        shown: size of what it is shown.
        layout: of its output.
        classes: numbers of the classes that count as vehicles.
    """

    path: Path
    session: "onnxruntime.InferenceSession"
    input_name: str
    input_type: type[np.floating]
    shown: ImageSize
    layout: Layout
    classes: tuple[int, ...]

    @property
    def score_threshold(self) -> float:
        """From which a box counts as a vehicle."""
        return SCORE_THRESHOLD

    @classmethod
    def load(cls, path: Path, classes: Sequence[str] = (), threads: int = 1) -> "OnnxModel":
        """Load a net and see what it is by showing it a grey picture.

        Args:
            path: the ONNX file.
            classes: names, or numbers from 0, of the classes that are vehicles; by default those of
                `DEFAULT_CLASSES` that the model knows.
            threads: that one picture is worked on with. The pipeline has a thread for each picture.

        Raises:
            UserError: onnxruntime is not installed, the file is missing or is no model, its layout is not
                known, or it does not know the classes.
        """
        with at_most_more(_most_bytes_at_first(path)):
            return cls._load(path, classes, threads)

    @classmethod
    def _load(cls, path: Path, classes: Sequence[str], threads: int) -> "OnnxModel":
        session = _session(path, threads)
        metadata = session.get_modelmeta().custom_metadata_map
        task = metadata.get("task", "detect")
        if task != "detect":
            raise UserError(f"{path}: a model for the task {task}; expected one for the task detect")
        entry = session.get_inputs()[0]
        shown = _shown_size(entry.shape, metadata)
        if len(session.get_inputs()) != 1 or shown is None or entry.type not in INPUT_TYPES:
            inputs = ", ".join(f"{i.name}: {i.type} {_times(i.shape)}" for i in session.get_inputs())
            raise UserError(
                f"{path}: takes {inputs}; expected one picture, float or float16 of the shape 1x3xHxW"
            )
        if not (min(shown.width, shown.height) > 0 and max(shown.width, shown.height) <= LARGEST_SHOWN_PX):
            raise UserError(
                f"{path}: takes pictures of {shown}; expected sides from 1 to {LARGEST_SHOWN_PX} pixels"
            )
        grey = np.full((1, 3, shown.height, shown.width), PAD_VALUE / 255, INPUT_TYPES[entry.type])
        try:
            output = np.asarray(session.run(None, {entry.name: grey})[0])
        except Exception as error:
            raise UserError(
                f"{path}: onnxruntime cannot run it on a picture of {shown} ({_one_line(error)})"
            ) from error
        if output.size > MOST_PUT_OUT:
            raise UserError(
                f"{path}: puts out {_times(output.shape)} numbers for a picture of {shown}; expected at most "
                f"{MOST_PUT_OUT:,}. Export it for smaller pictures, or with fewer classes"
            )
        layout = recognise(output, shown)
        if layout is None:
            raise UserError(
                f"{path}: its output has the shape {_times(output.shape)}, a layout that is not known; for "
                f"pictures of {shown} expected {expected_shapes(shown)}. Export a model of the YOLO family "
                "for detection, with a batch of one"
            )
        chosen = _choose(path, _names(path, metadata), class_count(layout, output), classes)
        return cls(path, session, entry.name, INPUT_TYPES[entry.type], shown, layout, chosen)

    def run(self, shown: NDArray[np.float32]) -> NDArray[np.floating]:
        """What the net puts out for a (1, 3, H, W) letterboxed picture."""
        entry = {self.input_name: shown.astype(self.input_type, copy=False)}
        return np.asarray(self.session.run(None, entry)[0])


class OnnxDetector:
    """Vehicles that a plugged-in net finds, where the calibration says that vehicles can be.

    An instance owns scratch memory: use one for each thread.

    Args:
        model: the net.
        calibration: for the size of the pictures.
        score_threshold: from which a box counts; None: the model's.
        largest_iou: of two boxes with a larger overlap the better stays, whatever their classes.
        vehicles: what a box must be like to be a vehicle on the road.
    """

    def __init__(
        self,
        model: OnnxModel,
        calibration: Calibration,
        score_threshold: float | None = None,
        largest_iou: float = 0.45,
        vehicles: PlausibleVehicles = ROAD_VEHICLES,
    ) -> None:
        self._model, self._size, self._camera = model, calibration.image_size, calibration.camera
        threshold = model.score_threshold if score_threshold is None else score_threshold
        self._score_threshold = max(threshold, LOWEST_SCORE)
        self._largest_iou, self._vehicles = largest_iou, vehicles
        self._least_tolerance_rad = vehicles.pitch_tolerance_rad
        self._letterbox = Letterbox(calibration.image_size, model.shown, model.layout)

    @property
    def name(self) -> str:
        """`onnx:` and the name of the file."""
        return f"onnx:{self._model.path.name}"

    def aim(self, aim: Aim) -> None:
        """See `fcw.detection.detector.AimedDetector`."""
        self._camera = replace(self._camera, pitch_rad=aim.pitch_rad)
        tolerance_rad = max(aim.tolerance_rad, self._least_tolerance_rad)
        self._vehicles = replace(self._vehicles, pitch_tolerance_rad=tolerance_rad)

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture, best score first.

        Raises:
            ValueError: the picture has another size than the calibration.
            UserError: the net puts out what are no numbers; of half precision they may have overflowed.
        """
        size, model = self._size, self._model
        if image.shape != (size.height, size.width, 3):
            raise ValueError(f"the detector expects BGR pictures of {size}, got the shape {image.shape}")
        output = model.run(self._letterbox.show(image))
        boxes, scores = decode(model.layout, output, model.shown, model.classes)
        sure = ~(scores < self._score_threshold)  # NaN is not below it: nothing found would look the same
        boxes, scores = boxes[sure], scores[sure]
        for what, numbers in (("score", scores), ("box edge", boxes)):
            if wrong := numbers[~np.isfinite(numbers)].tolist():
                raise UserError(f"detector {self.name!r}: {what} {wrong[0]}; expected a finite number")
        boxes = cut_to_picture(self._letterbox.in_picture(boxes), size)
        # Before suppression: what cannot be a vehicle must not hide one.
        standing = (boxes[:, 2:] > 0).all(axis=1)
        standing &= plausible(boxes, self._camera, size, self._vehicles)
        boxes, scores = boxes[standing], scores[standing]
        best = np.argsort(-scores, kind="stable")[:MOST_BOXES]
        boxes, scores = boxes[best], scores[best]
        kept = cv2.dnn.NMSBoxes(boxes.tolist(), scores.tolist(), 0.0, self._largest_iou)
        return tuple(Detection(Box(*boxes[i].tolist()), float(scores[i])) for i in np.ravel(kept).astype(int))


def _session(path: Path, threads: int) -> "onnxruntime.InferenceSession":
    try:
        import onnxruntime
    except ImportError:
        raise UserError(
            f"{path}: ONNX models need onnxruntime, which is not installed; {INSTALL_COMMAND}"
        ) from None
    if not path.is_file():
        raise UserError(f"{path}: no such file; expected an ONNX model after --detector onnx:")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.log_severity_level = 4  # nothing but its end: what it thinks of a model is said in our message
    try:
        return onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # each of its errors is a class of its own, without a common base
        raise UserError(
            f"{path}: onnxruntime cannot load it as an ONNX model ({_one_line(error)})"
        ) from error


def _most_bytes_at_first(path: Path) -> int:
    return MOST_BYTES_AT_FIRST + COPIES_OF_FILE * (path.stat().st_size if path.is_file() else 0)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def _times(shape: Sequence[object]) -> str:
    return "x".join(map(str, shape))


def _shown_size(shape: Sequence[object], metadata: Mapping[str, str]) -> ImageSize | None:
    """Size of the pictures that an input of this shape takes; None where it takes none."""
    if len(shape) != 4 or shape[1] != 3 or (isinstance(shape[0], int) and shape[0] != 1):
        return None
    height, width = shape[2:]
    if isinstance(height, int) and isinstance(width, int):
        return ImageSize(width, height)
    trained = re.findall(r"[0-9]{1,9}", metadata.get("imgsz", "")[:80])  # "[height, width]"
    return ImageSize(int(trained[-1]), int(trained[0])) if trained else SHOWN_BY_DEFAULT


def _names(path: Path, metadata: Mapping[str, str]) -> dict[int, str]:
    """Names of the classes by number, as the model's metadata have them; empty where they have none.

    The family's exporters write a Python dictionary or list.
    """
    written = metadata.get("names")
    if written is None:
        return {}
    try:
        if len(written) > LONGEST_NAMES:
            raise ValueError("too long")
        names = ast.literal_eval(written)
        pairs = names.items() if isinstance(names, dict) else enumerate(names)
        by_number = {int(number): str(name) for number, name in pairs}
        if not all(0 <= number < MOST_CLASSES for number in by_number):
            raise ValueError("no number of a class")
        return by_number
    except (ValueError, TypeError, SyntaxError, OverflowError, RecursionError, MemoryError):
        raise UserError(
            f"{path}: the entry `names` of its metadata is {written[:80]!r}; expected class names by number, "
            "as {0: 'person', 1: 'car'}"
        ) from None


def _choose(
    path: Path, names: Mapping[int, str], count: int | None, wanted: Sequence[str]
) -> tuple[int, ...]:
    """Numbers of the classes that are vehicles."""
    if names and count is not None and len(names) != count:
        raise UserError(
            f"{path}: names {len(names)} classes, but its output has {count}; expected a model for detection"
        )
    known = {name.lower(): number for number, name in names.items()}
    if not names and count in (COCO_CLASS_COUNT, None):
        known = dict(COCO_VEHICLES)
    end = count if count is not None else max(names, default=COCO_CLASS_COUNT - 1) + 1
    chosen = []
    for name in wanted:
        number = int(name) if re.fullmatch("[0-9]{1,9}", name) else known.get(name.strip().lower(), -1)
        if not 0 <= number < end:
            raise UserError(
                f"--detector-classes {name}: {path} has no such class; expected "
                + (f"one of {', '.join(known)}, or " if known else "")
                + f"a number from 0 to {end - 1}"
            )
        chosen.append(number)
    if not wanted and end == 1:
        chosen = [0]
    elif not wanted:
        chosen = [known[name] for name in DEFAULT_CLASSES if name in known]
    if not chosen:
        raise UserError(
            f"{path}: which of its {end} classes are vehicles is not known"
            + (f" (it has {', '.join(known)})" if known else "")
            + "; name them, by name or number, with --detector-classes"
        )
    return tuple(dict.fromkeys(chosen))
