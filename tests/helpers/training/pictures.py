"""A small set of labelled pictures to train on: drawn cars on a drawn road."""

import json
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.camera.file import write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize

SIZE = ImageSize(480, 270)
CAMERA = GroundPlaneCamera(0.0, 400.0, 120.0, 1.3, 239.5)


def drawn_picture(generator: np.random.Generator) -> tuple[NDArray[np.uint8], list[list[int]]]:
    """A road with lane lines, a few trees and one or two cars from behind; returns it and the cars' boxes."""
    picture = np.empty((SIZE.height, SIZE.width, 3), np.uint8)
    picture[:120] = (220, 190, 160)
    picture[120:] = 90
    for end in generator.integers(0, SIZE.width, 3):
        cv2.line(picture, (240, 120), (int(end), SIZE.height), (230, 230, 230), 3)
    for left in generator.integers(0, SIZE.width, 5):
        cv2.rectangle(picture, (int(left), 80), (int(left) + 15, 130), (40, 90, 50), -1)
    boxes = []
    for lateral_m in generator.permutation([-3.5, 0.0, 3.5])[: generator.integers(1, 3)]:
        box = CAMERA.ground_box(generator.uniform(8, 18), lateral_m, 1.8, 1.4)
        x, y, w, h = (round(value) for value in (box.x, box.y, box.w, box.h))
        colour = tuple(int(c) for c in generator.integers(0, 256, 3))
        cv2.rectangle(picture, (x, y), (x + w, y + h), colour, -1)
        cv2.rectangle(picture, (x + w // 6, y + h // 8), (x + w - w // 6, y + h // 2), (60, 50, 40), -1)
        cv2.rectangle(picture, (x, y + h // 2), (x + w // 6, y + 2 * h // 3), (20, 20, 220), -1)
        cv2.rectangle(picture, (x + w - w // 6, y + h // 2), (x + w, y + 2 * h // 3), (20, 20, 220), -1)
        cv2.rectangle(picture, (x, y + h - h // 8), (x + w, y + h), (10, 10, 10), -1)
        boxes.append([x, y, w, h])
    noise = generator.normal(0, 6, picture.shape)
    return np.clip(picture + noise, 0, 255).astype(np.uint8), boxes


def write_drawn_set(folder: Path, count: int, seed: int) -> Path:
    """Pictures, labels and a calibration in a folder."""
    (folder / "images").mkdir(parents=True)
    generator = np.random.default_rng(seed)
    images, annotations = [], []
    for number in range(count):
        picture, boxes = drawn_picture(generator)
        cv2.imwrite(str(folder / f"images/{number:03}.png"), picture)
        images.append({"id": number, "file_name": f"{number:03}.png", "width": 480, "height": 270})
        annotations += [
            {"id": len(annotations) + i, "image_id": number, "bbox": b} for i, b in enumerate(boxes)
        ]
    (folder / "labels.json").write_text(json.dumps({"images": images, "annotations": annotations}))
    write_calibration(Calibration.from_camera(CAMERA, SIZE), folder / "calibration.yaml")
    return folder
