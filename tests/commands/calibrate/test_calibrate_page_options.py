"""`fcw calibrate SOURCE` with options: what the command line says is said on the page already."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.export import camera_info_text
from fcw.camera.file import default_path
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.journal import journal_path, read_journal
from fcw_viz.cli import main

SIZE = ImageSize(128, 72)


@pytest.fixture
def source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A picture; its page ends as soon as it is served, as by Ctrl-C."""

    def interrupted(_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("fcw_viz.calibrate_app.server.CalibrationPage.wait", interrupted)
    picture = tmp_path / "road.png"
    cv2.imwrite(str(picture), np.zeros((SIZE.height, SIZE.width, 3), np.uint8))
    return picture


def said(source: Path, *options: str) -> Document:
    """What the page of a command knows."""
    assert main(["calibrate", str(source), "--no-open", "--port", "8391", *options]) == 130
    content = read_journal(journal_path(default_path(source)))
    assert content is not None
    return content.history.document


def test_the_lens_the_tape_and_the_errors_of_the_command_line_are_said_on_the_page(source, tmp_path):
    lens = tmp_path / "camera.lens.yaml"
    camera = GroundPlaneCamera(0.0, 110.0, 35.5, 1.3, 63.5)
    lens.write_text(camera_info_text(Calibration.from_camera(camera, SIZE)))
    options = ["--lens", str(lens), "--tape-error", "0.02", "--height", "1.3", "--height-sigma", "0.1"]
    document = said(source, *options)
    assert document.lens is not None
    assert document.lens.focal_y_px == pytest.approx(110.0)
    assert document.tape_error == 0.02
    assert (document.height_m, document.height_sigma_m) == (1.3, 0.1)
    again = said(source, "--height", "1.3")
    assert again == document, "a height that is said already keeps its error"


def test_a_lens_of_another_camera_is_refused_by_the_page_too(source, tmp_path, capsys):
    lens = tmp_path / "other.lens.yaml"
    camera = GroundPlaneCamera(0.0, 110.0, 47.5, 1.3, 63.5)
    lens.write_text(camera_info_text(Calibration.from_camera(camera, ImageSize(128, 96))))
    assert main(["calibrate", str(source), "--no-open", "--port", "8391", "--lens", str(lens)]) == 2
    assert f"--lens {lens}: the lens is of pictures of 128x96, these are 128x72" in capsys.readouterr().err


def test_beside_a_drive_on_a_card_that_cannot_be_written_the_option_for_another_place_is_named(
    source, monkeypatch, capsys
):
    monkeypatch.setattr("fcw.files.os.access", lambda *_: False)  # the tests may run as root
    from_clip = ["calibrate", str(source), "--from-clip", "--height", "1.3"]
    assert main(from_clip) == 2
    assert "it cannot be written to; name another folder with --save FILE\n" in capsys.readouterr().err
    assert main([*from_clip, "--save", str(source.with_name("c.yaml"))]) == 2
    assert "it cannot be written to; name another folder\n" in capsys.readouterr().err
