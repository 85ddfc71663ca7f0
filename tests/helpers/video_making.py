"""How tests of sources ask for a video."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class MakeVideo(Protocol):
    def __call__(
        self,
        name: str,
        images: Sequence[NDArray[np.uint8]],
        *,
        pts: Sequence[int] | None = None,
        time_base: Fraction = Fraction(1, 30),
        codec: str = "libx264",
        pixel_format: str = "yuv420p",
        codec_options: dict[str, str] | None = None,
        container_options: dict[str, str] | None = None,
        rotation: tuple[int, bool, bool] | None = None,
    ) -> Path: ...


def first_frames(source: Path, target: Path, frames: int) -> Path:
    """A video of the first frames of another, its packets as they are."""
    import av

    with av.open(str(source)) as read, av.open(str(target), "w") as written:
        video = read.streams.video[0]
        stream = written.add_stream_from_template(video)
        for number, packet in enumerate(read.demux(video)):
            if number == frames or packet.dts is None:
                break
            packet.stream = stream
            written.mux(packet)
    return target
