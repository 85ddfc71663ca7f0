"""A drive that was enlarged from a small video, and then a covered lens: what frames and summary say."""

from pathlib import Path

import cv2
import numpy as np
from drives.altered import DEMO, AlteredDrive, Picture

from fcw.camera.file import read_calibration
from fcw.detection.detector import Detection
from fcw.job import DriveJob, run_drive
from fcw.logs.records import NOTHING_SEEN, FrameResult

FRAMES, COVERED_FROM, SMALL = 110, 100, (160, 90)


def soft(index: int, picture: Picture) -> Picture:
    """From an eighth of its size; black where the lens is covered."""
    small = cv2.resize(picture, SMALL, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.resize(small * np.uint8(index < COVERED_FROM), (1280, 720)), np.uint8)


class SeesNothing:
    """Finds no vehicle."""

    name = "sees nothing"

    def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
        return ()


def test_a_soft_picture_is_noted_at_its_frames_and_in_the_summary(tmp_path: Path):
    results: list[FrameResult] = []
    calibration = read_calibration(DEMO / "drive.calibration.yaml")
    job = DriveJob(DEMO / "drive.mp4", tmp_path / "out", calibration, detector=SeesNothing())
    outcome = run_drive(job, AlteredDrive(FRAMES, soft), on_result=results.append)
    said = [any(note.startswith("soft picture, ") for note in result.notes) for result in results]
    # By the third of two pictures a second; where nothing can be seen that alone is said.
    assert said == [30 <= index < COVERED_FROM for index in range(FRAMES)]
    assert all(NOTHING_SEEN in result.notes for result in results[COVERED_FROM:])
    (note,) = [note for note in outcome.notes if "soft" in note]
    assert note.startswith("from 1.0 s to 3.3 s: soft picture, half of the cars ")
