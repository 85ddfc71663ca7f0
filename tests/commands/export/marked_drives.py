"""Made drives whose boxes are drawn in their pictures, and what exports are looked at with."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.logs.records import FrameResult
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.cli import main

SIZE = ImageSize(1280, 720)
RATE_HZ = 25.0
FRAMES = 60
GREY = 96


def box_of(index: int) -> Box:
    return Box(400.0 + 5 * index, 300.0 + 2 * index, 160.0, 120.0)


def marked_picture(index: int) -> NDArray[np.uint8]:
    """Grey, with a mark drawn where the box is: a black line three pixels wide along its edges."""
    image = np.full((SIZE.height, SIZE.width, 3), GREY, np.uint8)
    box = box_of(index)
    left, top, right, bottom = (round(edge) for edge in (box.x, box.y, box.right, box.bottom))
    image[top - 1 : bottom + 2, left - 1 : right + 2] = 0
    image[top + 2 : bottom - 1, left + 2 : right - 1] = GREY
    return image


def result_of(index: int) -> FrameResult:
    """A vehicle about which a warning is given from 0.8 s to 1.6 s; none at all in the last ten frames."""
    time_ns = 7_000_000_000 + index * 40_000_000
    if index >= FRAMES - 10:
        return FrameResult(index, time_ns, (), (), None, WarningState(WarningLevel.NONE), 20.0)
    track = Track(
        4, box_of(index), 8.0, 15.0, 14.0, 16.2, 0.1, 9.0, 0.3, 15 / 9, index / 25, SeenBy.DETECTOR, True
    )
    warned = 20 <= index <= 40
    state = WarningState(WarningLevel.NONE)
    if warned:
        state = WarningState(WarningLevel.WARNING, 4, "ttc", 15 / 9, 4.0, 0.75)
    return FrameResult(index, time_ns, (Detection(track.box, 8.0),), (track,), 4, state, 20.0)


def export(*arguments: str | Path) -> int:
    return main(["export", *map(str, arguments)])


def read_video(path: Path) -> list[NDArray[np.uint8]]:
    video, pictures = cv2.VideoCapture(str(path)), []
    while True:
        there, picture = video.read()
        if not there:
            return pictures
        pictures.append(np.asarray(picture, np.uint8))
