"""Labelled pictures made up for tests of the evaluation."""

from pathlib import Path

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.training.dataset import NO_BOX, LabelledImage
from fcw.evaluation.detection.detectors import FrameDetections
from fcw.evaluation.detection.figures import DetectionEvaluation, evaluate
from fcw.evaluation.detection.labels import AnnotatedImage
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
# A level camera 1.5 m above the road, focal length 1000 px: row of distance d is 360 + 1500 / d.
CALIBRATION = Calibration.from_camera(GroundPlaneCamera(0.0, 1000.0, 360.0, 1.5, 640.0), SIZE)


def boxes(*rows):
    return np.array(rows, np.float64).reshape(-1, 4)


def annotated(
    *rows, ignored=(), clip="clip", time_s=None, image_id=1, attributes=None, complete=True, camera=""
):
    """A picture with these boxes; `ignored` are indices of boxes; rear faces are in the attributes."""
    flags = np.array([index in ignored for index in range(len(rows))], bool)
    fields = attributes if attributes is not None else [{} for _ in rows]
    rears = boxes(*(each.get("rear_box") or NO_BOX for each in fields))
    path = Path(f"{clip}/{image_id}.png")
    labelled = LabelledImage(path, clip, SIZE, boxes(*rows), flags, rears, complete, camera or clip)
    return AnnotatedImage(labelled, image_id, time_s, tuple(fields))


def found(*rows, scores=(), milliseconds=1.0, windows=None):
    return FrameDetections(boxes(*rows), np.array(scores, np.float64), milliseconds, windows)


def evaluated(images, detections, threshold=0.0, timed=()) -> DetectionEvaluation:
    return evaluate(images, lambda image: CALIBRATION, detections, threshold, timed)
