"""Crafted folders, names and options: what stands where a file should, and where the outputs go."""

import hashlib
import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path

POINTS = ("--points", "6:640", "15:520", "30:480", "--image-size", "1280x720", "--height", "1.3")
STRANGE_NAMES = (
    "-x.mp4",
    "%03d.jpg",
    "concat:a|b",
    "subfile,,start,0,end,9,,:a.mp4",
    "data:video_mp4;base64,AAAA",
    "a\nb.mp4",
    "~",
    "*?[a].mp4",
    "a.",
    " ",
    "\u202egpm.mp4",
    "\U0001f697.mp4",
    "é" * 127,
    ".hidden.mp4",
    "a.mp4.calibration.yaml",
    "$(touch x).mp4",
    "onnx:",
)


def command_lines(root: Path, picture: bytes, log: bytes) -> Iterator[list[str]]:
    """Makes the places below a folder; each command line ends with 0 or 2, at once."""
    yield from _instead_of_files(root, picture, log)
    yield from _outputs(root, log)
    yield from _names(root, picture)
    yield from _folders(root, picture, log)
    yield from _options(root)
    yield from _outputs_at_inputs(root, picture, log)


def _instead_of_files(root: Path, picture: bytes, log: bytes) -> Iterator[list[str]]:
    """A pipe, a folder, a link to itself, to nothing, to a device without end, wherever a file is read."""
    for kind in ("pipe", "folder", "loop", "dangling", "endless", "socket"):
        place = root / kind
        place.mkdir()
        pictures = place / "pictures"
        pictures.mkdir()
        for name in ("0.jpg", "1.jpg"):
            (pictures / name).write_bytes(picture)
        named = {
            name: _make(kind, place / name)
            for name in (
                "drive.mp4",
                "drive.mcap",
                "labels.json",
                "lens.yaml",
                "speed.csv",
                "track.gpx",
                "poses.txt",
                "events.json",
                "table.csv",
                "model.npz",
                "net.onnx",
                "scenario.yaml",
            )
        }
        _make(kind, pictures / "2.jpg")
        _make(kind, pictures / "timestamps.txt")
        _make(kind, place / "pictures.calibration.yaml")
        reviewed = place / "reviewed"
        reviewed.mkdir()
        (reviewed / "drive.mcap").write_bytes(log)
        _make(kind, reviewed / "drive.review.anna.jsonl")
        shown = str(pictures)
        yield ["run", named["drive.mp4"], "--out", f"{place}/o"]
        yield ["run", named["drive.mcap"], "--out", f"{place}/o"]
        yield ["run", shown, "--out", f"{place}/o"]
        yield ["run", shown, "--out", f"{place}/o", "--calibration", named["lens.yaml"]]
        yield ["run", shown, "--out", f"{place}/o", "--ego-speed", named["speed.csv"]]
        yield ["run", shown, "--out", f"{place}/o", "--ego-speed", named["track.gpx"]]
        yield ["run", shown, "--out", f"{place}/o", "--detector", f"onnx:{named['net.onnx']}"]
        yield ["calibrate", *POINTS, "--lens", named["lens.yaml"]]
        yield ["calibrate", "--from-drive", named["drive.mcap"], "--save", f"{place}/c.yaml"]
        yield ["calibrate", named["drive.mp4"], "--from-clip"]
        yield ["recover", named["drive.mcap"]]
        yield ["export", named["drive.mcap"], "--format", "csv", "--out", f"{place}/t.csv"]
        yield ["review", named["drive.mcap"], "--summary"]
        yield ["review", str(reviewed), "--summary"]
        yield ["evaluate", "warning", "--events", named["events.json"], "--log", str(reviewed)]
        yield ["evaluate", "warning", "--events", str(reviewed), "--log", named["drive.mcap"]]
        yield ["evaluate", "motion", shown, "--poses", named["poses.txt"]]
        yield [
            "evaluate",
            "distance",
            "--kitti-tracking",
            str(place),
            "--tusimple-velocity",
            named["events.json"],
        ]
        detection = ["evaluate", "detection", named["labels.json"], "--images", shown]
        yield [*detection, "--calibration", named["lens.yaml"]]
        yield [*detection, "--calibration", str(place), "--model", named["model.npz"]]
        yield ["batch", named["drive.mp4"], "--out", f"{place}/batch", "--calibration", named["table.csv"]]
        yield ["batch", str(place), "--out", named["table.csv"]]
        yield ["train", "--data", str(place), "--out", f"{place}/m.npz"]
        yield ["simulate", named["scenario.yaml"], "--out", f"{place}/simulated"]
        yield ["bench", named["drive.mp4"]]


def _make(kind: str, path: Path) -> str:
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "loop":
        path.symlink_to(path.name)
    elif kind == "dangling":
        path.symlink_to("nowhere")
    elif kind == "endless":
        path.symlink_to("/dev/zero")
    else:
        import socket

        with socket.socket(socket.AF_UNIX) as server:
            server.bind(str(path))
    return str(path)


def _outputs(root: Path, log: bytes) -> Iterator[list[str]]:
    """Where nothing of ours may go, or nothing can."""
    place = root / "outputs"
    place.mkdir()
    drive = place / "drive.mcap"
    drive.write_bytes(log)
    (place / "file").write_text("a file")
    os.mknod(place / "device", 0o600 | 0o020000, os.makedev(1, 3)) if os.geteuid() == 0 else _make(
        "pipe", place / "device"
    )
    pipe = _make("pipe", place / "pipe")
    loop = _make("loop", place / "loop")
    targets = [
        str(place / "device"),
        pipe,
        loop,
        f"{place}/file/x",
        "",
        ".",
        "/proc/nothing",
        "/sys/x",
        "/dev/full",
    ]
    targets += [f"{place}/{'x' * 256}", "/" + "a/" * 3000, f"{place}/\udcff"]
    for target in targets:
        yield ["calibrate", *POINTS, "--save", target]
        yield ["calibrate", *POINTS, "--export", "kalibr", target]
        yield ["recover", str(drive), "--out", target]
        for form in ("csv", "kitti", "mot", "coco", "mp4", "rrd", "mcap", "parquet"):
            yield ["export", str(drive), "--format", form, "--out", target, "--overwrite"]
        yield ["run", f"{place}/none", "--out", target]
        yield ["batch", str(place), "--out", target]
        yield ["train", "--data", str(place), "--out", target]
        yield ["simulate", "no-such", "--out", target]
        yield [
            "evaluate",
            "distance",
            "--kitti-tracking",
            str(place),
            "--samples",
            target,
            "--report",
            target,
        ]


def _null_device(path: Path) -> str:
    """What `/dev/null` is, at a place where it may be lost; for whoever may not make one a pipe."""
    try:
        os.mknod(path, stat.S_IFCHR | 0o600, os.makedev(1, 3))
    except PermissionError:
        return _make("pipe", path)
    return str(path)


def _names(root: Path, picture: bytes) -> Iterator[list[str]]:
    place = root / "names"
    place.mkdir()
    for name in STRANGE_NAMES:
        try:
            (place / name).write_bytes(picture)
        except OSError:
            continue
        path = str(place / name)
        yield ["run", path, "--out", str(place / "o")]
        yield ["calibrate", path, *POINTS[:4], "--height", "1.3", "--no-open", "--json"]
        yield ["recover", path]
        yield ["review", str(place / "o"), "--reviewer", name, "--no-open"]


def _folders(root: Path, picture: bytes, log: bytes) -> Iterator[list[str]]:
    """Folders that hold what should not be there."""
    place = root / "folders"
    place.mkdir()
    (place / "again").symlink_to(place)  # a folder in itself
    records = place / "batch"
    bad_records: list[object] = [
        [],
        {"state": "done"},
        {"state": []},
        {"state": "done", "frames": "many"},
        {"name": "a", "source": "a", "camera": "a", "state": "done", "frames": "x", "seconds": "y"},
        {
            "name": "a",
            "source": "a",
            "camera": "a",
            "state": "done",
            "frames": 10**17,
            "seconds": float("nan"),
        },
    ]
    for number, value in enumerate(bad_records):
        (records / str(number)).mkdir(parents=True)
        (records / str(number) / "batch.json").write_text(json.dumps(value))
    (records / "pipe").mkdir()
    _make("pipe", records / "pipe" / "batch.json")
    yield ["batch", str(place), "--out", str(records)]
    (place / "some.mp4").write_bytes(picture)
    yield ["batch", str(place), "--out", str(records)]
    tables = [
        "",
        "camera\n",
        "camera,calibration\na\n",
        'camera,calibration\n"a\n',
        "camera,calibration\na,b,c\n",
    ]
    tables += ["camera,calibration\n" + "a," + "x" * 200_000, "camera,camera\na,b\n", "\x00"]
    for number, text in enumerate(tables):
        (place / f"{number}.csv").write_text(text)
        yield ["batch", str(place), "--out", str(records), "--calibration", str(place / f"{number}.csv")]
    many = place / "many"
    many.mkdir()
    (many / "drive.mcap").write_bytes(log)
    for number in range(300):
        (many / f"drive.review.p{number}.jsonl").write_bytes(b"\xff" * number)
    yield ["review", str(many), "--summary"]
    yield ["review", str(place), "--summary"]
    yield ["export", str(place), "--format", "csv", "--events", "--out", str(place / "events.csv")]
    locked = place / "locked"
    (locked / ".fcw.lock").mkdir(parents=True)
    yield ["run", str(place / "some.mp4"), "--out", str(locked)]


INPUTS = "inputs"


def _outputs_at_inputs(root: Path, picture: bytes, log: bytes) -> Iterator[list[str]]:
    """Every output option, pointed at each input of its command by name, by link and by a detour."""
    place = root / INPUTS
    (place / "pictures").mkdir(parents=True)
    (place / "drive.mcap").write_bytes(log)
    (place / "pictures" / "1.jpg").write_bytes(picture)
    names = ("a.mp4", "a.yaml", "a.csv", "a.gpx", "lens.yaml", "labels.json", "a.npz", "a.onnx", "gt.json")
    for name in (*names, "poses.txt"):
        (place / name).write_text(f"the {name}")
    (root / "digests.json").write_text(json.dumps(_digests(place)))
    detection = ["evaluate", "detection", "labels.json", "--images", "pictures", "--calibration", "a.yaml"]
    distance = ["evaluate", "distance", "--kitti-tracking", "pictures", "--tusimple-velocity", "gt.json"]
    commands = [
        (["calibrate", "a.mp4", "--lens", "lens.yaml", *POINTS], [["--save"], ["--export", "kalibr"]]),
        (["calibrate", "pictures", *POINTS], [["--save"], ["--export", "camera_info"]]),
        (["calibrate", "--from-drive", "drive.mcap"], [["--save"]]),
        ([*detection, "--model", "a.npz"], [["--detections"], ["--report"]]),
        ([*detection, "--detector", "onnx:a.onnx"], [["--detections"], ["--report"]]),
        (distance, [["--samples"], ["--report"]]),
        (["run", "a.mp4", "--calibration", "a.yaml", "--ego-speed", "a.csv"], [["--out"]]),
        (["run", "a.mp4", "--detector", "onnx:a.onnx", "--ego-speed", "a.gpx"], [["--out"]]),
        (["recover", "drive.mcap"], [["--out"]]),
        (["simulate", "a.yaml"], [["--out"]]),
        (["batch", "a.mp4", "--calibration", "a.csv"], [["--out"]]),
        (["train", "--data", "pictures"], [["--out"]]),
        (["bench", "a.mp4", "--calibration", "a.yaml", "--onnx", "a.onnx"], [["--report"]]),
    ]
    for form in ("csv", "parquet", "kitti", "mot", "coco", "mp4", "rrd", "mcap"):
        commands.append((["export", "drive.mcap", "--format", form, "--overwrite"], [["--out"]]))
    for words, outputs in commands:
        read = [word.removeprefix("onnx:") for word in words if (place / word.removeprefix("onnx:")).exists()]
        read += ["pictures/1.jpg"] * ("pictures" in read)
        whole = [str(place / word) if word in read else word for word in words]
        whole = [f"onnx:{place}/a.onnx" if word == "onnx:a.onnx" else word for word in whole]
        for output in outputs:
            for name in read:
                link = root / f"link-{name.replace('/', '-')}"
                if not link.exists():
                    link.symlink_to(place / name)
                for target in (str(place / name), str(link), f"{place}/pictures/../{name}"):
                    yield [*whole, *output, target]


def changed_inputs(root: Path) -> list[str]:
    """Which of those inputs are not as they were."""
    before, now = json.loads((root / "digests.json").read_text()), _digests(root / INPUTS)
    return sorted(name for name in before if now.get(name) != before[name])


def _digests(folder: Path) -> dict[str, str]:
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def _options(root: Path) -> Iterator[list[str]]:
    """Options that the first corpus does not try, with values that nobody should give."""
    bad = (
        "nan",
        "inf",
        "-1",
        "0",
        "1e308",
        "9" * 400,
        "",
        "\u0661",  # 1, and another 1: a batch starts so many workers
        "0_1",
        "0x10",
        " 1",
        "1,5",
        "\x1b[2J",
        "--json",
    )
    log = str(root / "outputs" / "drive.mcap")
    for value in (
        "nan",
        "inf",
        "-1",
        "1e308",
        "9" * 400,
        "",
        "0x10",
        "1,5",
        "\x1b[2J",
        "--json",
    ):  # no work to do
        yield ["evaluate", "warning", "--mount-hours", value]
        yield ["evaluate", "warning", "--following-hours", value]
        yield ["evaluate", "warning", "--ncap", f"--box-noise={value}"]
        yield ["evaluate", "warning", "--threats", f"--seeds={value}", "--seed", "1"]
    for value in bad:
        points = ["calibrate", *POINTS]
        yield [*points, f"--lane-width={value}"]
        yield [*points, f"--lane-width=3.5:{value}", "--lane-line", "1:2:3:4"]
        yield [*points, f"--dash-period={value}"]
        yield [*points, f"--dashes={value}", "--dash-period", "9"]
        yield [*points, f"--height-sigma={value}"]
        yield [*points, f"--horizon-line={value}"]
        yield [*points, "--horizon-line", f"0:{value}:9:{value}"]
        yield [*points, f"--lane-line={value}:{value}:{value}:{value}"]
        yield [*points, f"--speed={value}", "--from-clip"]
        yield [*points, f"--vehicle-class={value}"]
        yield [*points, f"--units={value}"]
        yield [*points, f"--topic={value}"]
        yield ["export", log, "--format", "coco", "--out", str(root / "o.json"), f"--every={value}"]
        yield ["export", log, "--format", value, "--out", str(root / "o.json")]
        yield ["export", log, "--format", "csv", "--out", str(root / "o.csv"), "--between", value, value]
        yield ["evaluate", "distance", "--kitti-tracking", str(root), f"--simulated-tracks={value}"]
        yield ["evaluate", "distance", "--kitti-tracking", str(root), f"--pitch-error={value}"]
        yield ["evaluate", "distance", "--kitti-tracking", str(root), "--sequences", value]
        yield [
            "evaluate",
            "detection",
            log,
            "--images",
            str(root),
            "--calibration",
            log,
            f"--at-fppi={value}",
        ]
        yield ["evaluate", "detection", log, "--images", str(root), "--calibration", log, f"--only={value}"]
        yield ["batch", log, "--out", str(root / "b"), f"--workers={value}"]
        yield ["batch", log, "--out", str(root / "b"), f"--scheduler={value}", "--detector", "magic"]
        yield ["train", "--data", str(root), "--out", str(root / "m.npz"), f"--score-threshold={value}"]
        yield ["train", "--data", str(root), "--out", str(root / "m.npz"), f"--seed={value}"]
        yield ["run", log, "--out", str(root / "o"), f"--warning-policy={value}"]
        yield ["run", log, "--out", str(root / "o"), f"--warning-timing={value}"]
        yield ["run", log, "--out", str(root / "o"), "--detector", "onnx:", f"--detector-classes={value}"]
        yield ["run", "rtsp://127.0.0.1:9/x", f"--frame-rate={value}"]
        yield ["bench", "none.mp4", f"--rounds={value}", f"--shortest={value}"]
        yield ["bench", "none.mp4", "--rounds", "1", f"--detector-frames={value}"]
