"""`fcw calibrate` of a clip with black bars: they are no part of the camera's picture."""

import math
from pathlib import Path

import av
import numpy as np
import pytest

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.file import read_calibration, write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.lens.pixel_map import PixelMap
from fcw.camera.solve import calibrate
from fcw.frame import ImageSize
from fcw.self_calibration.clip import ClipCalibration, ClipObservations
from fcw.sources import open_source
from fcw.sources.bars import for_pictures, without_bars
from fcw_viz.calibrate_app.server import CalibrationPage
from fcw_viz.cli import main

BAR_PX = 160


def write_clip(clip: Path, bar_px: int, frames: int = 3) -> Path:
    random = np.random.default_rng(0)
    with av.open(str(clip), "w", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 640 + 2 * bar_px, 360, "yuv420p"
        for _ in range(frames):
            image = random.integers(40, 200, (360, 640, 3), dtype=np.uint8)
            image = np.pad(image, ((0, 0), (bar_px, bar_px), (0, 0)))
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="bgr24")))
        container.mux(stream.encode())
    return clip


def test_of_a_clip_that_is_cut_short_it_is_said(tmp_path, monkeypatch, capsys):
    clip = write_clip(tmp_path / "clip.mp4", 0, frames=20)
    clip.write_bytes(clip.read_bytes()[: clip.stat().st_size // 2])

    def look(source, *_args, **_others):
        list(source.frames())
        camera = GroundPlaneCamera(0.03, 500.0, 179.5, 1.3, 319.5)
        calibration = Calibration.from_camera(camera, source.image_size)
        return ClipCalibration(calibration, ClipObservations(None, None, (), 5), True, True)

    monkeypatch.setattr("fcw.self_calibration.clip.calibrate_clip", look)
    assert main(["calibrate", str(clip), "--from-clip", "--height", "1.3"]) == 0
    assert "clip.mp4: the file is cut short" in " ".join(capsys.readouterr().err.split())


def test_bars_are_left_out_of_the_fit_and_are_in_the_saved_file(tmp_path, monkeypatch, capsys):
    clip, saved = write_clip(tmp_path / "clip.mp4", BAR_PX), tmp_path / "clip.yaml"
    camera = GroundPlaneCamera(0.03, 500.0, 179.5, 1.3, 319.5)
    asked = []

    def look(source, _detector, stated, *_args, **_others):
        asked.append((source.image_size, stated.evidence, stated.priors))
        calibration = Calibration.from_camera(camera, source.image_size)
        seen = ClipObservations(None, None, (), 5)
        return ClipCalibration(calibration, seen, shows_road=True, by_motion=True)

    monkeypatch.setattr("fcw.self_calibration.clip.calibrate_clip", look)
    said = ["--field-of-view", "60", "--horizon-row", "180", "--points", "10:300:480"]
    assert main(["calibrate", str(clip), "--from-clip", *said, "--height", "1.3", "--save", str(saved)]) == 0
    ((size, evidence, priors),) = asked
    assert size == ImageSize(640, 360)
    assert (evidence.points[0].row_px, evidence.points[0].column_px) == (300, 480 - BAR_PX)
    assert math.degrees(priors.field_of_view_rad.value) == pytest.approx(60)
    assert priors.horizon_row_px.value == 180
    found = read_calibration(saved)
    assert found.image_size == ImageSize(640 + 2 * BAR_PX, 360)
    assert found.camera.principal_column_px == 319.5 + BAR_PX
    assert found.camera.focal_y_px == 500
    told = " ".join(capsys.readouterr().err.split())
    assert "the bars beside the picture are cut off, which leaves 640x360 of 960x360" in told


@pytest.mark.parametrize("bar_px", [BAR_PX, 0])
def test_the_page_shows_pictures_without_their_bars_and_says_so(bar_px, tmp_path):
    page = CalibrationPage(write_clip(tmp_path / "clip.mp4", bar_px), tmp_path / "clip.yaml", 8600)
    try:
        assert page.pictures.image_size == page.session.state.document.image_size == ImageSize(640, 360)
        assert page.pictures.read(1).image.shape == (360, 640, 3)
        assert page.pictures.count == 3
        cut_off = "clip.mp4: the bars beside the picture are cut off, which leaves 640x360 of 960x360."
        assert page.session.state.notice == (cut_off if bar_px else "")
    finally:
        page.stop()


@pytest.mark.parametrize("with_bars", [True, False])
def test_the_page_takes_a_calibration_of_the_pictures_with_and_without_their_bars(with_bars, tmp_path):
    clip, file = write_clip(tmp_path / "clip.mp4", BAR_PX), tmp_path / "clip.yaml"
    places = ((6.0, 300.0, 320.0), (15.0, 220.0, 310.0), (40.0, 190.0, 330.0))
    points = [GroundPoint(distance_m, row_px, column_px) for distance_m, row_px, column_px in places]
    inner = calibrate(points, ImageSize(640, 360), 1.3)
    whole = inner.through(PixelMap(ImageSize(960, 360), left_px=-BAR_PX))
    write_calibration(whole if with_bars else inner, file)
    page = CalibrationPage(clip, file, 8600)
    try:
        marks = page.session.state.document.marks
        assert [(mark.distance_m, mark.row_px, mark.column_px) for mark in marks] == list(places)
        assert "is not used" not in page.session.state.notice
    finally:
        page.stop()
    source = open_source(clip)
    assert for_pictures(read_calibration(file), source).camera == whole.camera
    assert for_pictures(read_calibration(file), without_bars(source)[0]).camera == inner.camera
