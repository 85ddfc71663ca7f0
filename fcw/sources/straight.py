"""Straightens the pictures of a source: the one place where distortion, roll and yaw are removed."""

import math
from collections.abc import Iterator
from dataclasses import replace

from fcw.camera.calibration import Calibration
from fcw.camera.straight import Straightening
from fcw.frame import Frame, Source
from fcw.sources.bars import without_bars
from fcw.sources.forwarding import ForwardingSource


class StraightSource(ForwardingSource):
    """Gives another source's frames as a level camera without distortion would have seen them.

    Args:
        source: the source of the pictures as they are.
        way: how they are straightened.
    """

    def __init__(self, source: Source, way: Straightening) -> None:
        super().__init__(source)
        self._way = way
        self._maps = way.maps()

    @property
    def relays_video(self) -> bool:
        """Always False: the packets contain the pictures as they were."""
        return False

    @property
    def coded_anew(self) -> str:
        """Why frames carry no packets."""
        return super().coded_anew or "they are straightened"

    @property
    def notes(self) -> tuple[str, ...]:
        """The source's notes, and what was removed."""
        orientation = self._way.orientation
        undone = [
            f"{name} of {math.degrees(angle_rad):+.1f} degrees"
            for name, angle_rad in (("yaw", orientation.yaw_rad), ("roll", orientation.roll_rad))
            if angle_rad
        ]
        if self._way.lens is not None:
            undone.append("the lens's distortion")
        return (*super().notes, f"pictures straightened: {', '.join(undone)} removed")

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """The source's frames, straightened."""
        for frame in super().frames(start_ns):
            yield replace(frame, image=self._way.image(frame.image, self._maps), packets=())


def straightened(source: Source, calibration: Calibration) -> tuple[Source, Calibration]:
    """A source and its calibration for straight pictures without bars; unchanged if nothing is to do."""
    source, part = without_bars(source)
    if part is not None:
        calibration = calibration.through(part)
    way = calibration.straightening
    return (source if way is None else StraightSource(source, way)), calibration.straight()
