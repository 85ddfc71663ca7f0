"""The beginning of the shipped drive with its pictures altered, as a clip that something was done to."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.frame import Frame
from fcw.sources.video import VideoSource

DEMO = Path(__file__).parents[3] / "recordings" / "demo"

Picture = NDArray[np.uint8]


class AlteredDrive(VideoSource):
    """So many frames of the shipped drive, each picture as `alter` makes it of its number and itself."""

    def __init__(self, frames: int, alter: Callable[[int, Picture], Picture]) -> None:
        super().__init__(DEMO / "drive.mp4")
        self._end_index, self._alter = frames, alter

    @property
    def relays_video(self) -> bool:
        return False

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for frame in super().frames():
            if frame.index == self._end_index:
                return
            yield Frame(frame.index, frame.time_ns, self._alter(frame.index, frame.image))
