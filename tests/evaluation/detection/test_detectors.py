"""Running detectors over labelled pictures: one detector at a time, whatever the order of the pictures."""

import weakref
from typing import ClassVar

import cv2
import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.acf import AcfSettings
from fcw.detection.choice import load_model
from fcw.detection.detector import Detection
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.detection.training.dataset import LabelledImage, TrainingImage
from fcw.detection.training.mining import Detectors
from fcw.errors import UserError
from fcw.evaluation.detection import detectors
from fcw.evaluation.detection.detectors import DetectorCase, run_detectors
from fcw.evaluation.detection.labels import AnnotatedImage
from fcw.frame import ImageSize

SIZE = ImageSize(32, 16)
NONE = np.zeros((0, 4))


class MeanDetector:
    """Finds a box that is as wide as the picture is bright."""

    alive: ClassVar[weakref.WeakSet] = weakref.WeakSet()
    most: ClassVar[int] = 0

    def __init__(self):
        self.alive.add(self)
        MeanDetector.most = max(MeanDetector.most, len(self.alive))

    def detect(self, image):
        return (Detection(Box(0.0, 0.0, float(image.mean()), 1.0), 1.0),)


def test_one_detector_is_kept_however_many_clips_there_are(tmp_path, monkeypatch):
    images = []
    for index in range(12):
        path = tmp_path / f"{index}.png"
        cv2.imwrite(str(path), np.full((SIZE.height, SIZE.width, 3), index + 1, np.uint8))
        labelled = LabelledImage(path, f"clip {index % 4}", SIZE, NONE, np.zeros(0, bool), NONE)
        images.append(AnnotatedImage(labelled, index, None, ()))
    monkeypatch.setattr(detectors, "make_detector", lambda *_: MeanDetector())
    case = DetectorCase("net", None)  # type: ignore[arg-type]

    frames = run_detectors(images, {"mean": case.detector_of(lambda image: None)})["mean"]  # type: ignore[arg-type]

    # In the order of the pictures, though taken clip by clip; two while the next one is made.
    assert [frame.boxes[0, 2] for frame in frames] == list(range(1, 13))
    assert MeanDetector.most <= 2


def test_of_many_calibrations_the_one_without_the_road_is_named_by_a_picture(tmp_path):
    sky = Calibration.from_camera(GroundPlaneCamera(-1.2, 30.0, 8.0, 1.3, 15.5), SIZE)
    image = LabelledImage(tmp_path / "up.png", "clip", SIZE, NONE, np.zeros(0, bool), NONE)
    for name in ("net", "acf"):
        with pytest.raises(UserError, match=r"up\.png: the calibration has its horizon in row"):
            DetectorCase(name, load_model(name)).detector_of(lambda _: sky)(image)
    with pytest.raises(UserError, match=r"up\.png: the calibration has its horizon in row"):
        Detectors(Model.load(SHIPPED_MODEL_PATH), AcfSettings()).prior(TrainingImage(image, sky))
