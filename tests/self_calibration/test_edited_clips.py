"""Calibrating a clip that was edited: by its longest part, as if that were all of it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fcw.camera.calibration import Gaussian
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.detection.choice import searching_detector
from fcw.frame import Frame, ImageSize
from fcw.self_calibration.clip import ClipCalibration, ClipObservations, calibrate_clip, rough_calibration
from fcw.sources.video import VideoSource
from fcw_viz.cli import main

DEMO = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"


class Edited(VideoSource):
    """The first seconds of the shipped drive; before a cut the camera hangs upside down."""

    def __init__(self, cut_s: float, begin_s: float = 0.0, end_s: float = 9.0) -> None:
        super().__init__(DEMO)
        self._cut_s, self._begin_s, self._end_s = cut_s, begin_s, end_s

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for frame in super().frames():
            time_s = frame.time_ns / 1e9
            if time_s > self._end_s:
                return
            if time_s >= self._begin_s and frame.index % 2 == 0:
                before = time_s < self._cut_s
                yield replace(frame, image=np.ascontiguousarray(frame.image[::-1])) if before else frame


def calibrated(source: VideoSource) -> ClipCalibration:
    detector = searching_detector(rough_calibration(source.image_size, 1.3))
    return calibrate_clip(source, detector, Known(Evidence(), source.image_size, Gaussian(1.3, 0.12)))


@pytest.mark.slow
def test_a_clip_that_is_cut_is_calibrated_by_its_longest_part():
    edited = calibrated(Edited(cut_s=3.0))
    assert edited.is_cut
    assert edited.piece_words == "from 3 s to 9 s"
    assert edited.piece_s is not None
    alone = calibrated(Edited(cut_s=0.0, begin_s=edited.piece_s[0]))
    assert not alone.is_cut
    assert alone.piece_s is None
    assert edited.calibration == alone.calibration


def test_the_command_says_which_part_of_a_clip_it_calibrated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    found = ClipCalibration(
        rough_calibration(ImageSize(1280, 720), 1.3),
        ClipObservations(None, None, (), 5),
        shows_road=True,
        by_motion=True,
        piece_s=(8.0, 20.0),
        is_cut=True,
    )
    monkeypatch.setattr("fcw.self_calibration.clip.calibrate_clip", lambda *_args, **_kwargs: found)
    assert main(["calibrate", str(DEMO), "--from-clip", "--save", str(tmp_path / "camera.yaml")]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert (
        "this clip is cut, as by editing; the calibration is that of its longest part, from 8 s to 20 s"
        in told
    )
    assert "the horizon jumps" not in told
