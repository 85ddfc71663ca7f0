"""`--detector onnx:FILE` from the command line: a run whose log holds the net's boxes, and an evaluation."""

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from running.tiny_nets import write_net

from fcw.camera.file import read_calibration
from fcw.detection.choice import load_model
from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog
from fcw.sources import open_source
from fcw_viz.cli import main

DEMO = Path(__file__).parents[2] / "recordings" / "demo"
FRAMES = 6
SHOWN = (192, 320)  # height and width; a quarter of 1280x720 with 6 grey rows above and below
CELLS = 40 * 24 + 20 * 12 + 10 * 6
DISTANCE_M, WIDTH_M = 15.0, 1.7


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    """The first frames of the shipped drive as pictures, with its calibration beside the folder."""
    pictures = tmp_path / "short"
    pictures.mkdir()
    for frame in open_source(DEMO / "drive.mp4").frames():
        if frame.index == FRAMES:
            break
        cv2.imwrite(str(pictures / f"{frame.index:03d}.jpg"), frame.image)
    (tmp_path / "short.calibration.yaml").write_bytes((DEMO / "drive.calibration.yaml").read_bytes())
    return pictures


@pytest.fixture
def vehicle() -> tuple[float, float, float, float]:
    """Box of a rear straight ahead of the shipped drive's camera."""
    box = read_calibration(DEMO / "drive.calibration.yaml").camera.ground_box(DISTANCE_M, 0.0, WIDTH_M, 1.4)
    return box.x, box.y, box.w, box.h


@pytest.fixture
def net(tmp_path: Path, vehicle: tuple[float, float, float, float]) -> Path:
    """A YOLOv8 net that sees that vehicle in every picture, as a car with the score 0.9."""
    x, y, w, h = vehicle
    output = np.zeros((1, 84, CELLS), np.float32)
    output[0, :4, 100] = (x + 0.5 + w / 2) / 4, (y + 0.5 + h / 2) / 4 + 6, w / 4, h / 4
    output[0, 4 + 2, 100] = 0.9
    return write_net(tmp_path / "tiny.onnx", output, SHOWN)


@pytest.mark.slow
def test_a_run_follows_what_the_net_finds_and_the_log_says_which_net(
    drive: Path, net: Path, vehicle: tuple[float, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["run", str(drive), "--detector", f"onnx:{net}", "--out", str(out), "--json"]) == 0
    log = DriveLog(out / "drive.mcap")
    assert log.header.detector == "onnx:tiny.onnx"
    assert log.header.model_sha256 == hashlib.sha256(net.read_bytes()).hexdigest()
    results = list(log.results())
    assert len(results) == FRAMES
    for result in results:
        (found,) = result.detections
        assert (found.box.x, found.box.y, found.box.w, found.box.h) == pytest.approx(vehicle, abs=1e-3)
        assert found.score == pytest.approx(0.9, abs=1e-6)
    lead = results[-1].lead
    assert lead is not None
    offset_m = log.header.calibration.reference_offset_m
    assert lead.distance_m + offset_m == pytest.approx(DISTANCE_M, rel=0.05)
    assert json.loads(capsys.readouterr().out)["frames_with_lead"] >= 1


@pytest.mark.slow
def test_an_evaluation_takes_the_same_detectors(
    drive: Path, net: Path, vehicle: tuple[float, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    labels = tmp_path / "labels.json"
    images = [
        {"id": i, "file_name": f"{i:03d}.jpg", "width": 1280, "height": 720, "clip": "short"}
        for i in range(FRAMES)
    ]
    annotations = [
        {"id": i, "image_id": i, "category_id": 1, "bbox": list(vehicle), "iscrowd": 0} for i in range(FRAMES)
    ]
    categories = [{"id": 1, "name": "vehicle"}]
    labels.write_text(json.dumps({"images": images, "annotations": annotations, "categories": categories}))
    calibration = str(tmp_path / "short.calibration.yaml")
    arguments = ["evaluate", "detection", str(labels), "--images", str(drive), "--calibration", calibration]
    assert main([*arguments, "--detector", f"onnx:{net}", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert (figures["detection_rate"], figures["fppi"]) == (1.0, 0.0)
    assert figures["score_threshold"] == 0.25
    # As trains, class 6 of COCO, nothing is found.
    assert main([*arguments, "--detector", f"onnx:{net}", "--detector-classes", "6", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["detection_rate"] == 0.0


@pytest.mark.parametrize(
    ("detector", "more", "named"),
    [
        ("onnx:nowhere.onnx", [], "nowhere.onnx"),
        ("acf", ["--detector-classes", "car"], "--detector-classes car"),
        ("onnx:", [], "--detector onnx:: no file is named; expected onnx:FILE"),
        ("onnx:{net}", ["--detector-classes", "lorry"], "--detector-classes lorry"),
    ],
)
def test_wrong_use_is_one_message(
    detector: str, more: list[str], named: str, drive: Path, net: Path, tmp_path: Path, capsys
) -> None:
    name = detector.format(net=net)
    assert main(["run", str(drive), "--out", str(tmp_path / "out"), "--detector", name, *more]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert named in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_an_onnx_model_is_named_once() -> None:
    with pytest.raises(
        UserError, match=r"--model other\.npz: --detector onnx:net\.onnx names a model already"
    ):
        load_model("onnx:net.onnx", path=Path("other.npz"))
