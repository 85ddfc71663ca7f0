"""Training folders, and rough cameras for pictures of which little more is known than their size."""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.camera.file import write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.files import write_whole
from fcw.frame import ImageSize

JPEG_QUALITY = 90
LEAST_WIDTH_PX = 24
"""Of vehicles that count."""


@dataclass(frozen=True, slots=True)
class Rough:
    """A camera of which little is known: its height, and its focal length beside the picture's width."""

    height_m: float
    focal_widths: float

    def calibration(self, size: ImageSize, horizon_row_px: float) -> Calibration:
        """Of pictures of this size, level."""
        middle = size.width / 2
        camera = GroundPlaneCamera(0.0, self.focal_widths * size.width, horizon_row_px, self.height_m, middle)
        return Calibration.from_camera(camera, size)


@dataclass(slots=True)
class Folder:
    """A training folder that is being filled, as `fcw train` takes it."""

    path: Path
    images: list[dict[str, Any]] = field(default_factory=list)
    annotations: list[dict[str, Any]] = field(default_factory=list)

    def add(
        self,
        name: str,
        clip: str,
        picture: NDArray[np.uint8],
        calibration: Calibration,
        boxes: Sequence[Mapping[str, Any]],
        complete: bool,
    ) -> None:
        """A picture with its boxes."""
        number = len(self.images) + 1
        height, width = picture.shape[:2]
        for folder in ("images", "calibration"):
            (self.path / folder).mkdir(parents=True, exist_ok=True)
        file_name = f"{name}.jpg"
        cv2.imwrite(str(self.path / "images" / file_name), picture, (cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY))
        write_calibration(calibration, self.path / "calibration" / f"{clip}.yaml")
        self.images.append(
            {
                "id": number,
                "file_name": file_name,
                "width": width,
                "height": height,
                "clip": clip,
                "complete": complete,
            }
        )
        for box in boxes:
            self.annotations.append(
                {"id": len(self.annotations) + 1, "image_id": number, "category_id": 1, **box}
            )

    def write(self) -> None:
        """The labels, once all pictures are in."""
        labels = {
            "images": self.images,
            "annotations": self.annotations,
            "categories": [{"id": 1, "name": "vehicle"}],
        }
        write_whole(self.path / "labels.json", json.dumps(labels))
        counting = sum(not box["ignore"] for box in self.annotations)
        sys.stderr.write(f"{self.path}: {len(self.images)} pictures, {counting} vehicles that count\n")
