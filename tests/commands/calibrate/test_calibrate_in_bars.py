"""`fcw calibrate --from-clip` of a clip with black bars: they are no part of the camera's picture."""

import math
from pathlib import Path

import av
import numpy as np
import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.file import read_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.self_calibration.clip import ClipCalibration, ClipObservations
from fcw_viz.calibrate_app.server import CalibrationPage
from fcw_viz.cli import main

BAR_PX = 160


def write_clip(clip: Path, bar_px: int) -> Path:
    random = np.random.default_rng(0)
    with av.open(str(clip), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 640 + 2 * bar_px, 360, "yuv420p"
        for _ in range(3):
            image = random.integers(40, 200, (360, 640, 3), dtype=np.uint8)
            image = np.pad(image, ((0, 0), (bar_px, bar_px), (0, 0)))
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="bgr24")))
        container.mux(stream.encode())
    return clip


def test_bars_are_left_out_of_the_fit_and_are_in_the_saved_file(tmp_path, monkeypatch, capsys):
    clip, saved = write_clip(tmp_path / "clip.mp4", BAR_PX), tmp_path / "clip.yaml"
    camera = GroundPlaneCamera(0.03, 500.0, 179.5, 1.3, 319.5)
    asked = []

    def look(source, _detector, _height_m, evidence, priors, **_others):
        asked.append((source.image_size, evidence, priors))
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
    assert "black bars beside the picture are cut off, which leaves 640x360 of 960x360" in told


@pytest.mark.parametrize(("bar_px", "said"), [(BAR_PX, True), (0, False)])
def test_the_page_says_what_bars_do_to_the_field_of_view(bar_px, said, tmp_path):
    page = CalibrationPage(write_clip(tmp_path / "clip.mp4", bar_px), tmp_path / "clip.yaml", 8600)
    try:
        assert ("The picture has black bars" in page.session.state.notice) == said
    finally:
        page.stop()
