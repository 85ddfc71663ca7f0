"""A drive that was enlarged from a small video, and then a covered lens: what frames and summary say."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from fcw.camera.file import read_calibration
from fcw.detection.detector import Detection
from fcw.frame import Frame
from fcw.job import DriveJob, run_drive
from fcw.logs.records import NOTHING_SEEN, FrameResult
from fcw.sources.video import VideoSource

DEMO = Path(__file__).parents[3] / "recordings" / "demo"
FRAMES, COVERED_FROM, SMALL = 110, 100, (160, 90)


class SoftDrive(VideoSource):
    """The beginning of the shipped drive, from an eighth of its size."""

    def __init__(self) -> None:
        super().__init__(DEMO / "drive.mp4")

    @property
    def relays_video(self) -> bool:
        return False

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for frame in super().frames():
            if frame.index == FRAMES:
                return
            small = cv2.resize(frame.image, SMALL, interpolation=cv2.INTER_AREA)
            image = cv2.resize(small * np.uint8(frame.index < COVERED_FROM), (1280, 720))
            yield Frame(frame.index, frame.time_ns, np.asarray(image, np.uint8))


class SeesNothing:
    """Finds no vehicle."""

    name = "sees nothing"

    def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
        return ()


def test_a_soft_picture_is_noted_at_its_frames_and_in_the_summary(tmp_path: Path):
    results: list[FrameResult] = []
    calibration = read_calibration(DEMO / "drive.calibration.yaml")
    job = DriveJob(DEMO / "drive.mp4", tmp_path / "out", calibration, detector=SeesNothing())
    outcome = run_drive(job, SoftDrive(), on_result=results.append)
    soft = [any(note.startswith("soft picture, ") for note in result.notes) for result in results]
    # By the third of two pictures a second; where nothing can be seen that alone is said.
    assert soft == [30 <= index < COVERED_FROM for index in range(FRAMES)]
    assert all(NOTHING_SEEN in result.notes for result in results[COVERED_FROM:])
    (note,) = [note for note in outcome.notes if "soft" in note]
    assert note.startswith("from 1.0 s to 3.3 s: soft picture, half of the cars ")
