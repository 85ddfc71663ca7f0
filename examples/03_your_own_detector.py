"""Put a detector of your own into the job: here one that reads what an earlier run found.

    python examples/03_your_own_detector.py [EARLIER] [FOLDER]

EARLIER is a folder of `fcw run` on the shipped drive, by default recordings/demo/out (`fcw demo`). A net of
yours would look at the picture instead.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import fcw

drive = Path(__file__).parents[1] / "recordings" / "demo" / "drive.mp4"
earlier = Path(sys.argv[1]) if len(sys.argv) > 1 else drive.with_name("out")
out = Path(sys.argv[2]) if len(sys.argv) > 2 else drive.with_name("own-detector")


class Replay:
    """Any class with a name and this method is a detector."""

    name = "replay"

    def __init__(self) -> None:
        self._results = fcw.read_drive(earlier).results()

    def detect(self, image: NDArray[np.uint8]) -> tuple[fcw.Detection, ...]:
        """Vehicles in a (height, width, 3) BGR picture."""
        boxes = [(found.box, found.score) for found in next(self._results).detections]
        return tuple(fcw.Detection(box, score) for box, score in boxes if box.h > 20)


outcome = fcw.run_drive(fcw.DriveJob(drive, out, detector=Replay()))
print(f"{outcome.summary['frames']} frames, {len(outcome.summary['warnings'])} warnings")
