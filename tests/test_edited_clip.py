"""A clip that was edited: nothing of what was followed goes on over a cut, and a broken picture is no cut."""

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np
import pytest
from drives.altered import DEMO, AlteredDrive, Picture

from fcw.camera.file import read_calibration
from fcw.detection.detector import Detection
from fcw.job import DriveJob, DriveOutcome, run_drive
from fcw.logs.records import CUT, FrameResult
from fcw.threat.threat import Threat
from fcw.warning.types import WarningLevel, WarningState

CALIBRATION = read_calibration(DEMO / "drive.calibration.yaml")
FRAMES = 90


def edited(turned: Collection[int]) -> AlteredDrive:
    """Three seconds of the shipped drive; at some frames the camera hangs upside down."""

    def alter(index: int, picture: Picture) -> Picture:
        return np.ascontiguousarray(picture[::-1, ::-1]) if index in turned else picture

    return AlteredDrive(FRAMES, alter)


class AlwaysOne:
    """Sees a car 20 m ahead, whatever it looks at."""

    name = "always one"

    def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
        return (Detection(CALIBRATION.ground_box(20.0, 0.0, 1.8, 1.5), 10.0),)


def run(turned: Collection[int], out: Path, threads: int) -> tuple[list[FrameResult], DriveOutcome]:
    results: list[FrameResult] = []
    job = DriveJob(
        DEMO / "drive.mp4", out, CALIBRATION, detector=AlwaysOne(), detection_threads=threads, search_hz=0.0
    )
    return results, run_drive(job, edited(turned), on_result=results.append)


@pytest.mark.parametrize("threads", [0, 2])
def test_no_vehicle_is_the_same_after_a_cut(tmp_path: Path, threads: int):
    results, outcome = run(range(45, FRAMES), tmp_path / "out", threads)
    assert [result.index for result in results if CUT in result.notes] == [46]
    assert [result.index for result in results if not result.searched] == [45]
    before = {track.track_id for result in results[:46] for track in result.tracks}
    after = {track.track_id for result in results[46:] for track in result.tracks}
    assert before == {1}
    assert after == {2}
    assert results[45].lead_id == 1
    assert results[46].tracks == ()
    (note,) = [note for note in outcome.notes if "cut" in note]
    assert note.startswith("the clip is cut at 1.5 s, as by editing: ")


def test_one_broken_picture_ends_no_track(tmp_path: Path):
    results, outcome = run([45], tmp_path / "out", 0)
    assert {track.track_id for result in results for track in result.tracks} == {1}
    assert all(len(result.tracks) == 1 for result in results[40:50])
    assert not any("cut" in note for note in outcome.notes)


class ToldOfCuts:
    """Warns of nothing, and counts the frames."""

    name = "told of cuts"

    def __init__(self) -> None:
        self.frames, self.anew_at = 0, list[int]()

    def begin_anew(self) -> None:
        self.anew_at.append(self.frames)

    def update(self, time_ns: int, threats: Sequence[Threat], ego_speed_mps: float | None) -> WarningState:
        self.frames += 1
        return WarningState(WarningLevel.NONE)


def test_a_policy_is_told_of_a_cut_before_it_judges_the_first_frame_after_it(tmp_path: Path):
    policy = ToldOfCuts()
    job = DriveJob(
        DEMO / "drive.mp4", tmp_path / "out", CALIBRATION, detector=AlwaysOne(), warning_policy=policy
    )
    run_drive(job, edited(range(45, FRAMES)))
    assert policy.anew_at == [46]
