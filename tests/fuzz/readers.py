"""Every format that the program reads: a good file of it, and what reads it."""

import io
import json
import shutil
import struct
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import zstandard
from mcap_files import foxglove_images, foxglove_raw_images
from running.tiny_nets import write_net

from fcw.annotation.summary import summarise
from fcw.camera.file import read_calibration
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.detection.net.model import NetModel
from fcw.detection.onnx.detector import OnnxModel
from fcw.detection.training.own_data import read_calibration_table
from fcw.evaluation.detection.labels import read_annotated, read_category
from fcw.evaluation.distance.kitti_tracking import read_own_motion, read_sequence
from fcw.evaluation.motion.poses import read_poses
from fcw.evaluation.warning.events import read_events
from fcw.frame import Frame
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.recovery import recover
from fcw.simulation.truth.file import read_truth
from fcw.simulation.world.scenario import SCENARIO_FOLDER, load_scenario
from fcw.simulation.world.world import World
from fcw.sources import open_source
from fcw.sources.mcap.facts import mcap_facts
from fcw.warning.ego_speed import EgoSpeed
from fcw_viz.calibrate_app.document.journal import read_journal

DEMO = Path(__file__).parents[2] / "recordings" / "demo"
NET_PATH = SHIPPED_MODEL_PATH.with_name("net.npz")


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        name: of the file, with the suffix by which it is known.
        good: what a good file holds.
        read: reads a file as the commands do; raises nothing but UserError.
        crafted: files that were made to do harm.
    """

    name: str
    good: bytes
    read: Callable[[Path], object]
    crafted: tuple[bytes, ...] = ()


DEEP = b"[" * 100_000
LONG = b"9" * 400
BOMB = (
    b"a: &a ["
    + b"1," * 9
    + b"1]\n"
    + b"".join(
        b"%c: &%c [%s]\n" % (new, new, b",".join([b"*%c" % old] * 9))
        for old, new in zip(b"abcdefgh", b"bcdefghi", strict=True)
    )
)
HUGE = b"x: 1\n" * (100 << 20 >> 2)


def formats(drive_log: bytes) -> list[Format]:
    """All of them; `drive_log` is a short drive.mcap."""
    speed = b"time_s,speed_mps,yaw_rate_radps\n0,10,0.1\n1,11.5,0\n2,12,-0.1\n"
    gpx = b"<gpx><trk><trkseg>%s</trkseg></trk></gpx>" % b"".join(
        b'<trkpt lat="48.1%d" lon="11.5"><time>2024-01-01T12:00:0%dZ</time></trkpt>' % (k, k)
        for k in range(4)
    )
    yaml = (DEMO / "drive.calibration.yaml").read_bytes()
    kitti = b"".join(
        b"%d 1 Car 0 0 -1.5 500 180 560 230 1.5 1.6 4.0 0.5 1.7 20.0 -1.57\n" % frame for frame in range(5)
    )
    poses = b"".join(b"1 0 0 0 0 1 0 0 0 0 1 %d\n" % k for k in range(5))
    truth = (DEMO / "truth.csv").read_bytes()[:4000].rpartition(b"\n")[0] + b"\n"
    return [
        Format("c.calibration.yaml", yaml, read_calibration, (DEEP, BOMB, HUGE, yaml + b"a: " + LONG)),
        Format(
            "s.yaml",
            (SCENARIO_FOLDER / "cut-in.yaml").read_bytes(),
            _world,
            (
                DEEP,
                BOMB,
                b"duration_s: 1e300\n",
                b"duration_s: 5\nroad: {trees_per_km: 1000000}\n",
                b"duration_s: 5\nroad: {bends: [{start_m: 1, length_m: 1e300, radius_m: 1e-300}]}\n",
            ),
        ),
        Format(
            "speed.csv",
            speed,
            _speed,
            (b"time_s,speed_mps\n" + b"x" * 140_000, b"time_s,speed_mps\n0," + LONG),
        ),
        Format(
            "track.gpx",
            gpx,
            _speed,
            (
                gpx.replace(b"48.11", b"inf"),
                b'<?xml version="1.0" encoding="nope"?>' + gpx,
                b"<a>" * 90_000,
                b'<!DOCTYPE a [<!ENTITY b "c">]>' + gpx,
                gpx.replace(b"2024", b"9" * 30),
            ),
        ),
        Format(
            "events.csv",
            b"start_s,end_s,level\n1,2,warning\n5,6,caution\n",
            read_events,
            (b"", b"a", b"x" * 140_000),
        ),
        Format(
            "events.json",
            b'[{"start_s": 1, "end_s": 2, "level": "warning"}]',
            read_events,
            (DEEP, b'[{"start_s": %s, "end_s": 2}]' % LONG, b'[{"start_s": [], "level": {}}]'),
        ),
        Format(
            "labels.json",
            _labels(3, 4),
            _read_labels,
            (
                DEEP,
                _labels(3, 10_000),
                _labels(1, 1).replace(b"[10", b"[" + LONG),
                b"[]",
                b"{}",
                b"1",
                _labels(1, 1).replace(b"1.jpg", b"../" * 2000),
                _labels(1, 1).replace(b'"1.jpg"', b"[1]"),
            ),
        ),
        Format(
            "0000.txt",
            kitti,
            _kitti,
            (kitti.replace(b"4 1 Car", b"999999999 1 Car"), kitti + LONG, kitti.replace(b"560", b"1e300")),
        ),
        Format("poses.txt", poses, read_poses, (LONG, b"")),
        Format(
            "calibrations.txt",
            b"clip 1280x720 1.3 6:640 15:520 30:480 good\n",
            read_calibration_table,
            (
                b"clip 1x1 1e300 6:640 15:520 30:480 x\n",
                b"clip %sx%s 1.3 6:640 15:520 30:480 x\n" % (LONG, LONG),
            ),
        ),
        Format("truth.csv", truth, read_truth, (truth + b"x" * 140_000, b"x" * 140_000)),
        Format(
            "timestamps.txt",
            b"0.0\n0.1\n",
            _times,
            (LONG + b"\n1\n", b"\xff\n", b"9" * 10 + b"\n" + b"9" * 10),
        ),
        Format("1.png", _picture(".png"), _pictures, (_stating(_picture(".png"), ">II", 16),)),
        Format("1.jpg", _picture(".jpg"), _pictures, (b"\xff\xd8\xff\xc0\x00\x11\x08\xff\xff\xff\xff\x03",)),
        Format("1.bmp", _picture(".bmp"), _pictures, (_stating(_picture(".bmp"), "<ii", 18),)),
        Format("1.webp", _picture(".webp"), _pictures),
        Format(
            "m.npz", SHIPPED_MODEL_PATH.read_bytes(), Model.load, (_npz_bomb(), b"\x93NUMPY", _wrong_model())
        ),
        Format("n.npz", NET_PATH.read_bytes(), NetModel.load, (_npz_bomb(),)),
        Format("drive.mcap", drive_log, _log, (_chunk_bomb(),)),
        Format("others.mcap", _others(foxglove_images), _log),
        Format("raw.mcap", _others(foxglove_raw_images), _log, (_odd_raw(),)),
        Format(
            "net.onnx",
            _net({}),
            _onnx,
            (
                _net({"imgsz": "[1000000, 1000000]"}),
                _net({"imgsz": LONG.decode()}),
                _net({"names": "{10000000000000: 'car'}"}),
                _net({"names": "[" * 50_000}),
                _net({"names": "{1e999: 'car'}"}),
            ),
        ),
        Format(
            "drive.mp4",
            (DEMO / "drive.mp4").read_bytes()[: 1 << 20],
            _source,
            (b"", b"#EXTM3U\n/etc/passwd\n"),
        ),
        Format(
            "drive.review.anna.jsonl",
            _review(),
            _reviews,
            (_review() + DEEP + b"\n", _review() + b'{"id":%s}\n' % LONG),
        ),
        Format(
            "j.calibration.work.jsonl",
            b'{"fcw_calibration_journal_version":1,"source":"a"}\n',
            read_journal,
            (DEEP, LONG),
        ),
    ]


def _world(path: Path) -> None:
    World(load_scenario(str(path)), 0)


def _speed(path: Path) -> None:
    EgoSpeed.parse(str(path))


def _labels(pictures: int, boxes: int) -> bytes:
    images = [
        {"id": k, "file_name": "1.jpg", "width": 64, "height": 48, "frame": k, "fps": 10}
        for k in range(pictures)
    ]
    annotations = [
        {
            "id": k,
            "image_id": k % pictures,
            "bbox": [10, 10, 20, 20],
            "category_id": 1,
            "rear_box": [10, 10, 9, 9],
        }
        for k in range(pictures * boxes)
    ]
    return json.dumps({"images": images, "annotations": annotations, "categories": [{"id": 1}]}).encode()


def _read_labels(path: Path) -> None:
    (path.parent / "1.jpg").write_bytes(_picture(".jpg"))
    images = read_annotated(path, path.parent)
    read_category(path)
    images[0].labelled.read()


def _kitti(path: Path) -> None:
    folder = path.parent / "kitti"
    for name in ("label_02", "calib", "poses"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    shutil.copy(path, folder / "label_02" / "0000.txt")
    shutil.copy(path, folder / "poses" / "0000.txt")
    (folder / "calib" / "0000.txt").write_text("P2: 700 0 600 0 0 700 170 0 0 0 1 0\n")
    read_sequence(folder, "0000")
    read_own_motion(folder, "0000")


def _picture(suffix: str) -> bytes:
    image = np.random.default_rng(1).integers(0, 256, (48, 64, 3), np.uint8)
    return cv2.imencode(suffix, image)[1].tobytes()


def _stating(picture: bytes, form: str, at: int) -> bytes:
    """A picture whose header says that it is huge."""
    return picture[:at] + struct.pack(form, 100_000, 100_000) + picture[at + 8 :]


def _pictures(path: Path) -> None:
    folder = path.parent / "pictures"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / f"0{path.suffix}").write_bytes(_picture(path.suffix))
    shutil.copy(path, folder / f"1²2{path.suffix}")
    list(open_source(folder, 10.0).frames())


def _times(path: Path) -> None:
    folder = path.parent / "timed"
    folder.mkdir(exist_ok=True)
    for name in ("1.jpg", "2.jpg"):
        (folder / name).write_bytes(_picture(".jpg"))
    shutil.copy(path, folder / "timestamps.txt")
    list(open_source(folder).frames())


@cache
def _npz_bomb() -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, header=np.zeros(300 << 20, np.uint8))
    return buffer.getvalue()


def _wrong_model() -> bytes:
    """A model whose trees look beyond the window."""
    with np.load(SHIPPED_MODEL_PATH) as archive:
        arrays = {name: archive[name] for name in archive.files}
    arrays["first_feature"] = np.full_like(arrays["first_feature"], 65535)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def _chunk_bomb() -> bytes:
    frame = zstandard.compress(bytes(300 << 20))
    content = struct.pack("<QQQII", 0, 1, 300 << 20, 0, 4) + b"zstd" + struct.pack("<Q", len(frame)) + frame
    header = struct.pack("<BQ", 1, 8) + bytes(8)
    return b"\x89MCAP0\r\n" + header + struct.pack("<BQ", 6, len(content)) + content


def _log(path: Path) -> None:
    """As a log of ours, as a log to be recovered, and as a source."""
    for read in (_results, lambda path: recover(path, path.with_name("whole.mcap")), mcap_facts, _source):
        _unless_refused(read, path)


def _results(path: Path) -> None:
    log = DriveLog(path)
    log.series()
    list(islice(log.entries(), 200))


def _source(path: Path) -> None:
    list(islice(open_source(path).frames(), 5))


def _unless_refused(read: Callable[[Path], object], path: Path) -> None:
    from fcw.errors import UserError

    try:
        read(path)
    except UserError:
        return


def _others(write: Callable[..., Path]) -> bytes:
    """An MCAP file of somebody else's."""
    with tempfile.TemporaryDirectory() as folder:
        frames = [Frame(k, k * 100_000_000, np.full((48, 64, 3), 9 * k, np.uint8)) for k in range(3)]
        return write(Path(folder) / "other.mcap", frames).read_bytes()


def _odd_raw() -> bytes:
    """Raw pictures whose width does not fit their encoding."""
    return _others(foxglove_raw_images).replace(b"rgb8", b"uyvy")


def _net(metadata: dict[str, str]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        output = np.zeros((1, 84, 8400), np.float32)
        return write_net(Path(folder) / "net.onnx", output, ("h", "w"), metadata).read_bytes()


def _onnx(path: Path) -> None:
    OnnxModel.load(path)


def _review() -> bytes:
    head = b'{"fcw_review_version":1,"log":"x"}\n'
    entry = {
        "id": "1",
        "time": "2026-01-01T00:00:00.000000Z",
        "person": "anna",
        "said": "Note",
        "time_s": 1.0,
        "text": "a",
    }
    return head + json.dumps(entry).encode() + b"\n"


def _reviews(path: Path) -> None:
    """With its drive beside it, which is named `drive.mcap` in the folder above."""
    log = path.parent / "drive.mcap"
    if not log.exists():
        shutil.copy(path.parent.parent / "good.mcap", log)
    summarise({"drive": log})
