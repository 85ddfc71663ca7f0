"""The whole job from Python, with one's own source, detector, policy and logs."""

import json
import math
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import fcw
from fcw.camera.calibration import GroundPoint
from fcw.camera.file import write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.frame import VideoPacket
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.records import DriveHeader

SIZE = fcw.ImageSize(320, 192)
CAMERA = GroundPlaneCamera(0.0, 300.0, 96.0, 1.5, 160.0)
CALIBRATION = fcw.Calibration.from_camera(CAMERA, SIZE)
FRAMES, FRAME_NS = 20, 40_000_000
_REAR = CAMERA.ground_box(15.0, 0.0, 1.8, 1.4)
BOX = fcw.Box(_REAR.x, _REAR.y, _REAR.w, CAMERA.row_at(15.75) - _REAR.y)
"""Down to the tyres, 0.75 m ahead of the rear."""


class GreySource:
    """Grey pictures, which no file holds."""

    name, image_size, frame_count, frame_rate_hz, relays_video = "grey", SIZE, FRAMES, 25.0, False
    notes = ("all of it is grey",)

    def frames(self, start_ns: int | None = None):
        for index in range(FRAMES):
            yield fcw.Frame(index, index * FRAME_NS, np.full((SIZE.height, SIZE.width, 3), 99, np.uint8))


class OwnDetector:
    """Sees the same vehicle in every picture."""

    name = "own"

    def detect(self, image: NDArray[np.uint8]) -> tuple[fcw.Detection, ...]:
        return (fcw.Detection(BOX, 0.75),)


class OwnPolicy:
    """Warns of every lead, from the tenth frame on."""

    name = "own"

    def update(
        self, time_ns: int, threats: Sequence[fcw.Threat], ego_speed_mps: float | None
    ) -> fcw.WarningState:
        lead = next((threat.track for threat in threats if threat.is_lead), None)
        if lead is None or time_ns < 10 * FRAME_NS:
            return fcw.WarningState(fcw.WarningLevel.NONE)
        return fcw.WarningState(fcw.WarningLevel.WARNING, lead.track_id, f"at {ego_speed_mps:g} m/s")


class Notebook:
    """A log of another kind."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def open(self, header: DriveHeader) -> None:
        self.lines.append(header.source)

    def write(self, result: fcw.FrameResult, packets: Sequence[VideoPacket]) -> None:
        self.lines.append(result.warning.level.name)

    def close(self) -> None:
        self.lines.append("end")


def job(folder: Path) -> fcw.DriveJob:
    return fcw.DriveJob(
        source=Path("grey"),
        out=folder,
        calibration=CALIBRATION,
        detector=OwnDetector(),
        ego_speed=fcw.EgoSpeed.constant(12.0),
        warning_policy=OwnPolicy(),
    )


def test_own_parts_take_the_place_of_the_programs(tmp_path):
    notebook, seen = Notebook(), []
    outcome = fcw.run_drive(job(tmp_path), GreySource(), sinks=(notebook,), on_result=seen.append)
    log = fcw.read_drive(tmp_path)
    assert (log.header.detector, log.header.model_sha256) == ("own", "")
    assert log.header.calibration == CALIBRATION
    results = list(log.results())
    assert results == seen
    for result in results:
        (found,) = result.detections
        assert (found.box.x, found.box.y) == pytest.approx((BOX.x, BOX.y), rel=1e-6)
        assert found.score == 0.75
        assert result.ego_speed_mps == 12.0
    assert results[-1].lead is not None
    assert results[-1].lead.distance_m == pytest.approx(15.0, rel=0.03)
    assert results[-1].warning.rule == "at 12 m/s"
    assert notebook.lines == ["grey", *(result.warning.level.name for result in results), "end"]
    (span,) = outcome.summary["warnings"]
    assert (span["start_s"], span["end_s"]) == pytest.approx((0.4, 0.76))
    assert json.loads((tmp_path / "summary.json").read_text()) == outcome.summary
    of_source, of_drive = outcome.notes
    assert of_source == "all of it is grey"
    assert of_drive.startswith("pictures are black or blank from 0.0 s to ")
    assert outcome.summary["blind_s"] == pytest.approx(outcome.summary["duration_s"])
    assert outcome.summary["notes"] == list(outcome.notes)
    assert not outcome.interrupted


def test_a_job_takes_texts_for_paths_and_a_number_for_the_own_speed(tmp_path):
    calibration = tmp_path / "a.yaml"
    fcw.write_calibration(CALIBRATION, calibration)
    texts: Any = {"source": "grey", "out": str(tmp_path / "out"), "calibration": str(calibration)}
    for ego_speed in (12, 12.0, "12"):
        outcome = fcw.run_drive(
            fcw.DriveJob(**texts, detector=OwnDetector(), ego_speed=ego_speed), GreySource()
        )
        assert outcome.summary["own_motion"]["speed_known_part"] == 1.0
        assert next(fcw.read_drive(tmp_path / "out").results()).ego_speed_mps == 12.0
    speeds = tmp_path / "a.csv"
    speeds.write_text("time_s,speed_mps\n0,12\n9,12\n")
    fcw.run_drive(fcw.DriveJob(**texts, detector=OwnDetector(), ego_speed=speeds), GreySource())
    assert next(fcw.read_drive(tmp_path / "out").results()).ego_speed_mps == 12.0


@pytest.mark.parametrize(
    ("field", "value", "expected"),
    [
        ("source", 3, "a path"),
        ("out", None, "a path"),
        ("calibration", 3, "a path, or a Calibration"),
        (
            "detector",
            3,
            "net, acf, acf-full, onnx:FILE, or an object with `name` and `detect`",
        ),
        (
            "warning_policy",
            None,
            "timely-braking, ttc, required-deceleration, euro-ncap-driver, headway, rss, "
            "or an object with `update`",
        ),
        ("detector_classes", "car", "a tuple of names"),
        ("ego_speed", True, "metres per second, the path of a CSV or GPX file, or an EgoSpeed"),
        ("frame_rate_hz", "30", "a number of pictures a second"),
    ],
)
def test_what_no_field_of_a_job_can_be_is_named_with_its_field(field: str, value: Any, expected: str):
    with pytest.raises(fcw.UserError) as raised:
        fcw.DriveJob(**{"source": Path("a"), "out": Path("b"), field: value})
    assert str(raised.value) == f"DriveJob({field}={value!r}): expected {expected}"


class LateSource(GreySource):
    """Its clock shows an hour at the first picture, as that of a stream recorded to MPEG-TS may."""

    def frames(self, start_ns: int | None = None):
        for frame in super().frames(start_ns):
            yield replace(frame, time_ns=frame.time_ns + 3_600_000_000_000)


def test_a_gpx_track_begins_with_the_first_picture_whatever_the_clock_shows_then(tmp_path):
    points = (
        f'<trkpt lat="48" lon="11"><time>2026-05-01T10:00:0{second}Z</time>'
        f"<speed>{10 + second}</speed></trkpt>"
        for second in range(3)
    )
    (tmp_path / "drive.gpx").write_text(f"<gpx><trk><trkseg>{''.join(points)}</trkseg></trk></gpx>")
    seen: list[fcw.FrameResult] = []
    given = replace(job(tmp_path / "out"), ego_speed=tmp_path / "drive.gpx", own_motion=False)
    fcw.run_drive(given, LateSource(), on_result=seen.append)
    assert [one.ego_speed_mps for one in seen] == pytest.approx([10 + 0.04 * i for i in range(FRAMES)])


def test_an_own_speed_of_another_time_is_told(tmp_path):
    speeds = "".join(f"{time_s},10\n" for time_s in range(0, 61, 10))
    (tmp_path / "speed.csv").write_text(f"time_s,speed_mps\n{speeds}")
    given = replace(job(tmp_path / "out"), ego_speed=tmp_path / "speed.csv", warning_policy="ttc")
    told = "the given own speed is not used: it is from 0.0 s to 60.0 s, and the drive from 3600.0 s"
    late, in_time = (fcw.run_drive(given, source()).notes for source in (LateSource, GreySource))
    assert [note for note in late if note.startswith(told)] == [f"{told} to 3600.8 s on its source's clock"]
    assert [note for note in in_time if note.startswith("the own speed")] == []


def test_gaps_of_the_own_speed_that_was_given_are_told(tmp_path):
    (tmp_path / "speed.csv").write_text("time_s,speed_mps\n0,10\n0.1,10\n0.2,10\n5.2,10\n5.3,10\n")
    given = replace(
        job(tmp_path / "out"), ego_speed=tmp_path / "speed.csv", own_motion=False, warning_policy="ttc"
    )
    seen: list[fcw.FrameResult] = []
    notes = fcw.run_drive(given, GreySource(), on_result=seen.append).notes
    told = "the given own speed is not used for 0.6 s, as its samples there are more than 1.0 s"
    assert f"{told} apart" in notes
    assert [one.ego_speed_mps for one in seen] == [10.0] * 6 + [None] * (FRAMES - 6)


def test_a_picture_of_another_size_than_the_source_states_is_named_with_the_frame(tmp_path):
    class Halving(GreySource):
        def frames(self, start_ns: int | None = None):
            for frame in super().frames(start_ns):
                yield frame if frame.index < 5 else replace(frame, image=frame.image[::2, ::2])

    with pytest.raises(fcw.UserError, match=r"source 'grey', frame 5: a picture of the shape \(96, 160, 3\)"):
        fcw.run_drive(job(tmp_path / "out"), Halving())


def test_what_is_no_state_of_a_warning_is_named_with_the_frame(tmp_path):
    class Forgetful:
        name = "forgetful"

        def update(self, time_ns: int, threats: Sequence[fcw.Threat], ego_speed_mps: float | None) -> Any:
            return fcw.WarningState(fcw.WarningLevel.NONE) if time_ns < 3 * FRAME_NS else None

    forgetful = replace(job(tmp_path / "out"), warning_policy=Forgetful())
    with pytest.raises(fcw.UserError, match="warning policy of the type Forgetful, frame 3: gave None"):
        fcw.run_drive(forgetful, GreySource())


def test_a_detectors_class_is_no_detector():
    mistaken: Any = OwnDetector
    with pytest.raises(fcw.UserError, match="an object with `name` and `detect`"):
        fcw.DriveJob(Path("a"), Path("b"), detector=mistaken)


class BlackeningDetector(OwnDetector):
    """Works in the picture that it is shown."""

    def detect(self, image: NDArray[np.uint8]) -> tuple[fcw.Detection, ...]:
        image[:] = 0
        return super().detect(image)


@pytest.mark.parametrize("detection_threads", [0, 2])
def test_a_detector_does_not_change_the_picture_of_tracker_and_log(tmp_path, detection_threads):
    changing = replace(job(tmp_path), detector=BlackeningDetector(), detection_threads=detection_threads)
    with pytest.raises(ValueError, match="read-only"):
        fcw.run_drive(changing, GreySource())


def test_a_calibration_of_another_shape_is_refused_before_anything_is_written(tmp_path):
    other = fcw.Calibration.from_camera(CAMERA, fcw.ImageSize(320, 240))
    mistaken = fcw.DriveJob(Path("grey"), tmp_path / "out", other, detector=OwnDetector())
    with pytest.raises(fcw.UserError, match="the calibration is for pictures of 320x240, these are 320x192"):
        fcw.run_drive(mistaken, GreySource())
    assert not (tmp_path / "out").exists()


def test_the_calibration_of_a_folder_is_of_all_drives_in_it_that_have_none_of_their_own(tmp_path):
    def run() -> tuple[float, tuple[str, ...]]:
        job = fcw.DriveJob(tmp_path / "grey.mp4", tmp_path / "out", detector=OwnDetector())
        outcome = fcw.run_drive(job, GreySource())
        told = tuple(note for note in outcome.notes if "calibration from" in note)
        return DriveLog(tmp_path / "out" / "drive.mcap").header.calibration.camera.height_m, told

    (tmp_path / "grey.mp4").touch()
    for foreign in ("", "image_width: 320\nimage_height: 192\n"):  # the second is as ROS has it
        (tmp_path / "calibration.yaml").write_text(foreign)
        with pytest.raises(fcw.UserError, match=r"grey\.calibration\.yaml: no calibration for .*grey\.mp4"):
            run()
    (tmp_path / "calibration.yaml").unlink()
    for name, height_m, told in (
        ("calibration.yaml", 1.7, (f"grey: calibration from {tmp_path / 'calibration.yaml'}",)),
        ("grey.calibration.yaml", 1.1, ()),
    ):
        camera = replace(CAMERA, height_m=height_m)
        write_calibration(fcw.Calibration.from_camera(camera, SIZE), tmp_path / name)
        assert run() == (height_m, told)


def test_a_calibration_that_its_maker_was_warned_of_is_told_with_the_drive(tmp_path):
    steep = fcw.Calibration.from_camera(replace(CAMERA, pitch_rad=math.radians(53.0), height_m=130.0), SIZE)
    for calibration, told in ((steep, True), (CALIBRATION, False)):
        job = fcw.DriveJob(Path("grey"), tmp_path / "out", calibration, detector=OwnDetector())
        outcome = fcw.run_drive(job, GreySource(), sinks=[Notebook()])
        wrong = [
            note for note in outcome.notes if note.startswith("the calibration looks wrong, so distances")
        ]
        assert ["53" in note for note in wrong] == [True] * told


def test_an_earlier_runs_files_do_not_stand_beside_this_runs(tmp_path):
    for name in ("drive.mcap", "drive.rrd", "summary.json"):
        (tmp_path / name).touch()  # as a run leaves them that is killed at its start
    fcw.run_drive(job(tmp_path), GreySource())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drive.mcap", "summary.json"]
    fcw.run_drive(job(tmp_path), GreySource())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drive.mcap", "summary.json"]
    assert len(list(fcw.read_drive(tmp_path / "drive.mcap").results())) == FRAMES


@pytest.mark.slow
def test_vehicles_are_found_with_a_calibration_that_is_degrees_off_once_the_road_told_it(tmp_path, data_dir):
    """Parked cars. Windows for the calibrated pitch would find one in 6 of these pictures."""
    # `calibrations.txt`, and 3.5 degrees farther up.
    marks = [GroundPoint(8, 266.75), GroundPoint(15, 232.33), GroundPoint(40, 207.75)]
    right = calibrate(marks, fcw.ImageSize(640, 360), 1.6).camera
    wrong = replace(right, pitch_rad=right.pitch_rad - math.radians(3.5))
    stop, found = threading.Event(), []

    def on_result(result: fcw.FrameResult) -> None:
        found.append(bool(result.detections))
        if result.index == 299:
            stop.set()

    job = fcw.DriveJob(
        source=data_dir / "clips" / "tmo_seattlestreet2.mp4",
        out=tmp_path / "out",
        calibration=fcw.Calibration.from_camera(wrong, fcw.ImageSize(640, 360)),
        detector="acf",
    )
    fcw.run_drive(job, stop=stop, on_result=on_result)
    assert sum(found[150:300]) > 100


def test_pictures_too_large_to_have_several_under_way_are_refused(tmp_path):
    """A page can still show one of them."""
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((1100, 16000, 3), np.uint8))
    with pytest.raises(fcw.UserError, match="pictures of 16000x1100; expected at most 16,777,216 pixels"):
        fcw.run_drive(fcw.DriveJob(tmp_path, tmp_path / "out"))
    assert fcw.open_source(tmp_path).image_size.width == 16000


def test_pictures_in_which_nothing_can_be_seen_are_refused(tmp_path):
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((1, 50, 3), np.uint8))
    with pytest.raises(fcw.UserError, match="pictures of 50x1; expected sides of at least 8"):
        fcw.run_drive(fcw.DriveJob(tmp_path, tmp_path / "out"))
