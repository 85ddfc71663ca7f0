"""Drives so short and small that running them takes a second: parts of the demo drive at half its size."""

import shutil
from pathlib import Path

import av
import cv2

from fcw.sources import open_source

DEMO = Path(__file__).parents[2] / "recordings" / "demo"
SIZE = 640, 360
BRAKING_S = 31.0
"""The lead of the demo drive brakes hard from here on."""


def write_short_drive(path: Path, start_s: float = BRAKING_S, frames: int = 45) -> Path:
    """A video of a part of the demo drive, a keyframe every ten frames, with its calibration beside it."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height = SIZE
        stream.pix_fmt, stream.gop_size = "yuv420p", 10
        stream.options = {"preset": "ultrafast", "bf": "0"}
        for number, frame in enumerate(open_source(DEMO / "drive.mp4").frames(round(start_s * 1e9))):
            if number == frames:
                break
            small = cv2.resize(frame.image, SIZE, interpolation=cv2.INTER_AREA)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(small, format="bgr24")))
        container.mux(stream.encode(None))
    shutil.copy(DEMO / "drive.calibration.yaml", path.with_name(f"{path.stem}.calibration.yaml"))
    return path
