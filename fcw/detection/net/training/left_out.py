"""Choosing the threshold on clips that a first training leaves out."""

from collections.abc import Sequence

import numpy as np

from fcw.detection.net.detector import NetDetector, NetSettings
from fcw.detection.net.model import NetModel
from fcw.detection.training.dataset import TrainingImage, background
from fcw.detection.training.settings import Progress
from fcw.errors import UserError

LEFT_OUT_PART = 0.2
"""Of the pictures, to choose the threshold on."""


def some_clips(images: Sequence[TrainingImage], seed: int) -> list[TrainingImage]:
    """All pictures of some clips, drawn until they are a fifth of all.

    Raises:
        UserError: there are too few clips to leave one out.
    """
    clips = sorted({image.labelled.clip for image in images if image.labelled.complete})
    if len(clips) < 2:
        raise UserError(
            "the labelled pictures are of one clip, so that none can be left out to choose the threshold on; "
            "label another, or give --score-threshold"
        )
    left_out, learnt = list[TrainingImage](), list(images)
    for index in np.random.default_rng(seed).permutation(len(clips)):
        if len(left_out) >= LEFT_OUT_PART * len(images):
            break
        others = [image for image in learnt if image.labelled.clip != clips[index]]
        if _has_both_classes(others):
            left_out += [image for image in learnt if image.labelled.clip == clips[index]]
            learnt = others
    return left_out


def _has_both_classes(images: Sequence[TrainingImage]) -> bool:
    """Whether there are vehicles to learn, and pictures of which the rest is background."""
    labelled = [image.labelled for image in images]
    return any((~each.ignored).any() for each in labelled) and any(each.complete for each in labelled)


def chosen_threshold(
    model: NetModel, images: Sequence[TrainingImage], fppi: float, progress: Progress
) -> float:
    """The lowest with no more than `fppi` detections of mere background a picture.

    Pictures in which not every vehicle is labelled do not count: what is found there may be a vehicle.
    """
    images = [image for image in images if image.labelled.complete]
    every = NetSettings(score_threshold=-np.inf)
    scores: list[float] = []
    progress.stage("choosing the threshold", len(images))
    for image in images:
        found = NetDetector(model, image.calibration, every).detect(image.labelled.read())
        boxes = np.array([(d.box.x, d.box.y, d.box.w, d.box.h) for d in found]).reshape(-1, 4)
        labelled = image.labelled
        false = background(boxes, labelled.boxes, labelled.ignored, labelled.rear_boxes)
        scores += [detection.score for detection, is_false in zip(found, false, strict=True) if is_false]
        progress.advance()
    scores.sort(reverse=True)
    allowed = int(fppi * len(images))
    threshold = float(np.nextafter(scores[allowed], np.inf)) if len(scores) > allowed else 0.0
    progress.note(f"score threshold {threshold:.2f}, from {len(images)} pictures left out")
    return threshold
