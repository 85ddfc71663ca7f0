"""Writes detections as a COCO results file, which other tools can evaluate."""

import json
from collections.abc import Sequence
from pathlib import Path

from fcw.evaluation.detection.detectors import FrameDetections
from fcw.evaluation.detection.labels import AnnotatedImage
from fcw.files import write_whole


def write_coco_results(
    images: Sequence[AnnotatedImage], found: Sequence[FrameDetections], category_id: int, path: Path
) -> None:
    """Write a complete list of image_id, category_id, bbox (x, y, w, h in pixels) and score, or nothing.

    Raises:
        UserError: the file cannot be written.
    """
    results = [
        {
            "image_id": image.image_id,
            "category_id": category_id,
            "bbox": [float(value) for value in box],
            "score": float(score),
        }
        for image, frame in zip(images, found, strict=True)
        for box, score in zip(frame.boxes, frame.scores, strict=True)
    ]
    write_whole(path, json.dumps(results))
