"""How tests ask for a video, or for a drive so short and small that running it takes a second."""

import shutil
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Protocol

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.sources import open_source

DEMO = Path(__file__).parents[2] / "recordings" / "demo"
SIZE = 640, 360
BRAKING_S = 31.0
"""The lead of the demo drive brakes hard from here on."""


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
    with av.open(str(source)) as read, av.open(str(target), "w") as written:
        video = read.streams.video[0]
        stream = written.add_stream_from_template(video)
        for number, packet in enumerate(read.demux(video)):
            if number == frames or packet.dts is None:
                break
            packet.stream = stream
            written.mux(packet)
    return target


def write_short_drive(
    path: Path, start_s: float = BRAKING_S, frames: int = 45, options: dict[str, str] | None = None
) -> Path:
    """A video of a part of the demo drive, a keyframe every ten frames, with its calibration beside it.

    Args:
        path: of the video.
        start_s: of the part, in the demo drive.
        frames: how many there are.
        options: of libx264; by default there are no B frames.
    """
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height = SIZE
        stream.pix_fmt, stream.gop_size = "yuv420p", 10
        stream.options = dict(options or {"preset": "ultrafast", "bf": "0"})
        for number, frame in enumerate(open_source(DEMO / "drive.mp4").frames(round(start_s * 1e9))):
            if number == frames:
                break
            small = np.asarray(cv2.resize(frame.image, SIZE, interpolation=cv2.INTER_AREA), np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(small, format="bgr24")))
        container.mux(stream.encode(None))
    shutil.copy(DEMO / "drive.calibration.yaml", path.with_name(f"{path.stem}.calibration.yaml"))
    return path
