"""The job on a few pictures before a live drive begins: a camera does not wait for a compiler."""

import tempfile
import threading
from dataclasses import replace
from pathlib import Path

from fcw.job import DriveJob, run_drive
from fcw.logs.records import FrameResult

FRAMES = 20
"""After ten of the shipped drive's every kernel has been called: vehicles are followed by the picture, and
our own motion is known."""


def rehearse(job: DriveJob, drive: Path) -> None:
    """Run a job's stages, whose kernels are compiled at their first use, on another drive; nothing is kept.

    Args:
        job: whose detector and stages they are.
        drive: its calibration lies beside it; `FRAMES` pictures with a vehicle ahead are enough.

    Raises:
        UserError: an option of the job is wrong.
    """
    enough = threading.Event()

    def count(result: FrameResult) -> None:
        if result.index + 1 >= FRAMES:
            enough.set()

    with tempfile.TemporaryDirectory() as folder:
        other = replace(
            job,
            source=drive,
            out=Path(folder) / "out",
            calibration=None,
            topic=None,
            ego_speed=None,
            frame_rate_hz=None,
            detection_threads=0,  # in this thread alone, so that Ctrl-C ends it
        )
        run_drive(other, stop=enough, on_result=count)
