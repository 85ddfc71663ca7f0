"""`fcw evaluate detection`: the contract of its JSON, its files and its messages."""

import dataclasses
import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.evaluation.detection.detectors import EVERY_SCORE, DetectorCase, run_detectors
from fcw.evaluation.detection.labels import calibration_source, read_annotated
from fcw.evaluation.simulated import counts_as_rear_view
from fcw.simulation.truth.file import read_truth
from fcw.sources import VideoSource
from fcw_viz.cli import main
from fcw_viz.commands.demo import demo_folder
from fcw_viz.jobs.detection_report import _crop

FRAMES = range(100, 1000, 150)


@dataclasses.dataclass(frozen=True)
class Drive:
    labels: Path
    images: Path
    calibration: Path

    def arguments(self, *more: str) -> list[str]:
        """The command with `more`, which may say otherwise where pictures and calibration are."""
        usual = {"--images": str(self.images), "--calibration": str(self.calibration)}
        given = [text for option in usual.items() if option[0] not in more for text in option]
        return ["evaluate", "detection", str(self.labels), *given, *more]


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Drive:
    """Pictures of the shipped drive, labelled by its truth."""
    folder = tmp_path_factory.mktemp("labelled")
    (folder / "images" / "demo").mkdir(parents=True)
    truth = read_truth(demo_folder() / "truth.csv")
    source = VideoSource(demo_folder() / "drive.mp4")
    images, annotations = [], []
    times_ns = source.times_ns
    assert times_ns is not None
    for frame in (next(iter(source.frames(int(time_ns)))) for time_ns in times_ns[FRAMES]):
        name = f"demo/{frame.index:06d}.png"
        assert cv2.imwrite(str(folder / "images" / name), frame.image)
        height, width = frame.image.shape[:2]
        images.append({"id": frame.index, "file_name": name, "width": width, "height": height})
        images[-1] |= {"frame": frame.index, "fps": 30.0}
        for vehicle in truth[frame.index].vehicles:
            counts = counts_as_rear_view(vehicle)
            box = vehicle.box if counts else vehicle.body_box
            annotations.append(
                {"id": len(annotations), "image_id": frame.index, "bbox": [box.x, box.y, box.w, box.h]}
                | {"ignore": not counts, "track_id": vehicle.name, "lead": vehicle is truth[frame.index].lead}
            )
    labels = folder / "labels.json"
    labels.write_text(json.dumps({"images": images, "annotations": annotations}))
    return Drive(labels, folder / "images", demo_folder() / "drive.calibration.yaml")


@pytest.mark.slow
def test_json_alone_on_stdout_with_the_keys_scripts_rely_on(drive, capsys, tmp_path):
    results = tmp_path / "results.json"
    more = (
        "--at-fppi",
        "0.1",
        "1",
        "--json",
        "--detections",
        str(results),
        "--report",
        str(tmp_path / "page"),
    )
    assert main(drive.arguments(*more)) == 0
    figures = json.loads(capsys.readouterr().out)
    labels = json.loads(drive.labels.read_text())
    counted = [annotation for annotation in labels["annotations"] if not annotation["ignore"]]
    assert figures["frames"] == len(labels["images"]) == len(FRAMES)
    assert figures["vehicles"] == len(counted) >= 6
    assert figures["distinct_vehicles"] == len({annotation["track_id"] for annotation in counted})
    assert 0.5 < figures["detection_rate"] <= 1
    assert figures["fppi"] <= 1
    assert 0.5 < figures["average_precision"] <= 1
    assert figures["ms_per_frame"] > 0
    assert figures["windows_per_frame"] > 1000
    assert 0 <= figures["detection_rate_at_fppi"] <= 1
    assert [point["fppi"] for point in figures["at_fppi"]] == [0.1, 1.0]
    assert sum(row["vehicles"] for row in figures["by_distance"].values()) == len(counted)
    assert sum(row["vehicles"] for row in figures["by_height"].values()) == len(counted)
    assert list(figures["by_clip"]) == ["demo"]
    low, high = figures["detection_rate_interval"]
    assert low <= figures["detection_rate"] <= high

    written = json.loads(results.read_text())
    assert {frozenset(result) for result in written} == {
        frozenset({"image_id", "category_id", "bbox", "score"})
    }
    assert {result["image_id"] for result in written} <= set(FRAMES)
    sure = sum(result["score"] >= figures["score_threshold"] for result in written)
    assert sure >= figures["detection_rate"] * len(counted)  # the others are false or on ignored vehicles

    page = (tmp_path / "page" / "report.html").read_text()
    assert "<svg" in page
    assert not re.search(r'(src|href)="(?!data:|#)', page)  # it holds all it shows
    misses = len(counted) - round(figures["detection_rate"] * len(counted))
    assert sum(map(int, re.findall(r"<tr><td>missed: [^<]*<td>(\d+)", page))) == misses
    false = round(figures["fppi"] * figures["frames"])
    assert sum(map(int, re.findall(r"<tr><td>false: [^<]*<td>(\d+)", page))) == false


@pytest.mark.parametrize(
    "box", [(100, -200, 50, 50), (700, 100, 50, 50), (100, 400, 50, 40), (-300, 9, 9, 9)]
)
def test_of_a_box_outside_its_picture_the_report_shows_the_nearest_part(box: tuple[int, int, int, int]):
    crop, _, (left, top) = _crop(np.zeros((180, 320, 3), np.uint8), np.array(box, np.float64))
    assert crop.size > 0
    assert 0 <= left < 320
    assert 0 <= top < 180


@pytest.mark.slow
@pytest.mark.parametrize("name", ["acf", "acf-full"])
def test_a_detector_at_a_threshold_gives_what_the_curve_has_above_it(drive, name):
    images = read_annotated(drive.labels, drive.images)
    calibration_of = calibration_source(drive.calibration)
    model = Model.load(SHIPPED_MODEL_PATH)

    def run(threshold):
        case = DetectorCase(name, model, threshold)
        return run_detectors(images, {"only": case.detector_of(calibration_of)})["only"]

    every_score = run(EVERY_SCORE)
    middle = float(np.median(np.concatenate([frame.scores for frame in every_score])))
    for upper, every in zip(run(middle), every_score, strict=True):
        sure = every.scores >= middle
        assert upper.scores == pytest.approx(every.scores[sure])
        assert upper.boxes == pytest.approx(every.boxes[sure])
        assert upper.milliseconds > 0
        assert (upper.windows or 0) == (every.windows or 0) > 1000


@pytest.mark.slow
def test_the_table_is_for_people_and_only_ignores_the_other_vehicles(drive, capsys):
    assert main(drive.arguments("--only", "lead=true", "--detector", "acf-full")) == 0
    told = capsys.readouterr().out
    assert "acf-full" in told
    assert "only lead=true" in told.replace("\n", " ")
    assert "distance, m" in told


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--report", __file__), r"--report .*: this is a file; expected a folder"),
        (("--only", "colour=red"), r"--only colour=red: no annotation has the attribute colour"),
        (("--detector", "yolo"), r"--detector yolo: no such detector; expected one of net, acf, acf-full"),
        (("--at-fppi", "-1"), r"--at-fppi -1\.0: expected numbers of at least 0"),
        (("--model", "none.npz"), r"none\.npz: no such model file"),
        (("--calibration", "nowhere.yaml"), r"--calibration nowhere\.yaml: no such file or folder"),
        (("--images", "nowhere"), r"nowhere/demo/000100\.png: .* names this picture.* \(nor 5 others\)"),
        (
            ("--detections", "nowhere/x.json"),
            r"--detections nowhere/x\.json: the folder nowhere does not exist",
        ),
    ],
)
def test_mistakes_give_one_message(drive, capsys, more, message):
    assert main(drive.arguments(*more)) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert re.match(f"fcw: {message}", told.err)
    assert "Traceback" not in told.err


def test_labels_that_are_no_coco_file_are_refused(drive, capsys, tmp_path):
    for text, message in (("[]", "not COCO labels"), ('{"images": [], "annotations": []}', "holds no image")):
        labels = tmp_path / "labels.json"
        labels.write_text(text)
        assert main(dataclasses.replace(drive, labels=labels).arguments()) == 2
        assert f"labels.json: {message}" in capsys.readouterr().err


def test_on_real_drives_the_prior_keeps_pace_with_the_whole_picture(data_dir, capsys):
    """The shipped weights on footage whose cameras they never saw (docs/figures/detection.md)."""
    rates = {}
    for detector in ("acf", "acf-full"):
        labels = data_dir / "labels"
        given = ["--images", str(labels / "images"), "--calibration", str(data_dir / "calibrations.txt")]
        more = ["--only", "occluded=0", "--detector", detector, "--at-fppi", "0.1", "--json"]
        assert main(["evaluate", "detection", str(labels / "validation.json"), *given, *more]) == 0
        figures = json.loads(capsys.readouterr().out)
        assert (figures["frames"], figures["vehicles"], figures["distinct_vehicles"]) == (66, 72, 9)
        rates[detector] = figures["detection_rate_at_fppi"]
    assert rates["acf"] >= 0.75
    assert rates["acf"] > rates["acf-full"]
