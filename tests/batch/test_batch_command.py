"""`fcw batch` on real workers: broken drives, killed workers, other people's schedulers."""

import contextlib
import filecmp
import http.client
import io
import json
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import duckdb
import pyarrow.parquet as pq
import pytest
from video_making import write_short_drive

from fcw.annotation.records import EventReference, Judgement, Verdict
from fcw.annotation.store import ReviewStore
from fcw.batch.cluster import connected
from fcw.batch.ledger import MANIFEST_NAME, RECORD_NAME
from fcw.batch.review_list import REVIEW_LIST_NAME
from fcw.locked_file import LockedFile
from fcw.logs.events import find_events
from fcw.logs.mcap.reader import read_drive
from fcw_viz.cli import main

pytestmark = pytest.mark.slow
ARGUMENTS = ["--detector", "acf", "--json"]
FRAMES = 45


@pytest.fixture(scope="module")
def rendered(tmp_path_factory) -> Path:
    """Three drives of a second and a half that differ, each with a warning and its calibration."""
    folder = tmp_path_factory.mktemp("rendered")
    for number, start_s in enumerate((30.5, 31.0, 31.5)):
        write_short_drive(folder / f"d{number}.mp4", start_s, FRAMES)
    return folder


@pytest.fixture
def drives(rendered, tmp_path) -> Path:
    return shutil.copytree(rendered, tmp_path / "drives")


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory) -> Iterator[str]:
    """The address of a scheduler that somebody started by hand, with two workers."""
    folder = tmp_path_factory.mktemp("cluster")
    address_file = folder / "scheduler.json"
    common = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(address_file)]
    dask = [sys.executable, "-m", "dask"]
    of_workers = ["--nthreads", "1", "--nworkers", "2", "--local-directory", str(folder / "scratch")]
    processes = [
        subprocess.Popen([*dask, "scheduler", "--port", "0", *common], stderr=subprocess.DEVNULL),
        subprocess.Popen([*dask, "worker", *of_workers, *common], stderr=subprocess.DEVNULL),
    ]
    try:
        while not (address := address_in(address_file)):
            assert processes[0].poll() is None
            time.sleep(0.1)
        yield address
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait()


@pytest.fixture
def dashboard(rendered, tmp_path) -> Iterator[str]:
    """Host and port of that of a batch under way."""
    links: queue.Queue[str] = queue.Queue()
    end = threading.Event()

    def wait_in_place_of_drives(client, *_):
        links.put(client.dashboard_link)
        end.wait()
        return iter(())

    arguments = ["batch", str(rendered / "d0.mp4"), "--out", str(tmp_path), "--workers", "1", *ARGUMENTS]
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(io.StringIO()):
        patch.setattr("fcw.batch.cluster.run_tasks", wait_in_place_of_drives)
        running = threading.Thread(target=main, args=(arguments,))
        running.start()
        yield urlsplit(links.get()).netloc
        end.set()
        running.join()


def address_in(file: Path) -> str:
    """The scheduler's; nothing before its file is whole."""
    with contextlib.suppress(FileNotFoundError, json.JSONDecodeError):
        return json.loads(file.read_text())["address"]
    return ""


def batch(*arguments: object) -> tuple[int, dict[str, dict[str, object]]]:
    """Exit code, and what came of each drive."""
    with contextlib.redirect_stdout(io.StringIO()) as told:
        code = main(["batch", *map(str, arguments), *ARGUMENTS])
    return code, {record["name"]: record for record in json.loads(told.getvalue())}


def test_a_worker_keeps_the_memory_of_a_picture_for_the_next_one():
    with connected(workers=1) as client:
        assert client.submit(os.environ.get, "MALLOC_TRIM_THRESHOLD_").result() is None


def test_the_dashboard_answers_no_other_web_page(dashboard):
    identity, attacker = "/json/identity.json", "attacker.example"
    for status, path, headers in (
        (200, identity, {}),
        (200, identity, {"Host": "localhost:1"}),  # through an ssh tunnel
        (403, identity, {"Host": attacker}),
        (403, "/sitemap.json", {"Host": attacker}),
        (403, identity, {"Origin": f"http://{attacker}"}),
        (403, "/status/ws", {"Origin": f"http://{attacker}", "Upgrade": "websocket"}),
        (403, "/status/ws", {"Upgrade": "websocket"}),
    ):
        connection = http.client.HTTPConnection(dashboard)
        connection.request("GET", path, headers=headers)
        assert connection.getresponse().status == status, (path, headers)
        connection.close()


def test_good_drives_are_done_and_each_other_one_is_named(drives, tmp_path, scheduler):
    calibration = drives / "d0.calibration.yaml"
    good = {f"d{number}" for number in range(5)}
    for number in range(3, 5):
        shutil.copy(calibration, drives / f"d{number}.calibration.yaml")
        # The same pictures in another file: bytes after the end are read by nobody.
        (drives / f"d{number}.mp4").write_bytes((drives / "d0.mp4").read_bytes() + bytes(number))
    shutil.copy(drives / "d0.mp4", drives / "copy.mp4")
    shutil.copy(calibration, drives / "copy.calibration.yaml")
    shutil.copy(drives / "d1.mp4", drives / "bare.mp4")
    whole = (drives / "d1.mp4").read_bytes()
    for name, data in (("torn", whole[:5000]), ("empty", b""), ("text", b"no video at all")):
        (drives / f"{name}.mp4").write_bytes(data)
        shutil.copy(calibration, drives / f"{name}.calibration.yaml")
    out = tmp_path / "out"
    code, records = batch(drives, "--out", out, "--scheduler", scheduler)
    assert code == 2
    states = {name: record["state"] for name, record in records.items()}
    broken = ("torn", "empty", "text")
    assert states == dict.fromkeys(good - {"d0"}, "done") | dict.fromkeys(broken, "failed") | {
        "copy": "done",
        "d0": "duplicate",
        "bare": "no calibration",
    }
    for name in broken:
        assert f"{name}.mp4" in str(records[name]["reason"])
    assert "fcw calibrate" in str(records["bare"]["reason"])
    manifest = json.loads((out / MANIFEST_NAME).read_text())
    assert manifest["versions"]["fcw"]
    assert {drive["name"] for drive in manifest["drives"]} == set(records)
    table = pq.read_table(out / "drives.parquet").to_pydict()
    assert dict(zip(table["drive"], table["state"], strict=True)) == states
    # Each drive is what `fcw run` makes of it, and nothing is run twice.
    assert main(["run", str(drives / "d1.mp4"), "--out", str(tmp_path / "alone"), "--detector", "acf"]) == 0
    assert filecmp.cmp(out / "d1" / "drive.mcap", tmp_path / "alone" / "drive.mcap", shallow=False)
    written = {path: path.stat().st_mtime_ns for path in out.glob("*/drive.mcap")}
    events = (out / "events.parquet").read_bytes()
    judge_first_warning(out / "d1")
    assert batch(drives, "--out", out, "--scheduler", scheduler)[0] == 2
    assert {path: path.stat().st_mtime_ns for path in out.glob("*/drive.mcap")} == written
    assert (out / "events.parquet").read_bytes() != events
    ask_the_questions_of_the_docs(out)


def ask_the_questions_of_the_docs(out: Path) -> None:
    text = (Path(__file__).parents[2] / "docs" / "batch.md").read_text()
    (block,) = re.findall(r"```sql\n(.*?)```", text, re.DOTALL)
    questions = [line for line in block.splitlines() if not line.startswith("--")]
    assert len(questions) == 10
    with contextlib.chdir(out):
        answers = [duckdb.execute(question).fetchall() for question in questions]
    assert answers[6] == [(1.0,)]
    assert {row[:2] for row in answers[-1]} == {
        ("bare", "no calibration"),
        ("d0", "duplicate"),
        ("empty", "failed"),
        ("text", "failed"),
        ("torn", "failed"),
    }


def judge_first_warning(drive: Path) -> None:
    """Somebody finds that it was false."""
    log = read_drive(drive)
    event = next(event for event in find_events(log.series()) if event.kind == "warning")
    store = ReviewStore(log)
    reference = EventReference(event.kind, event.track_id, event.start_s, event.end_s)
    store.add("somebody", Verdict(reference, Judgement.FALSE))
    store.close()


def test_killed_workers_lose_no_drive(drives, tmp_path, scheduler):
    out = tmp_path / "out"
    killed: list[int] = []
    stop = threading.Event()

    def kill_workers() -> None:
        """As soon as it is in the middle of a drive, three times."""
        while not stop.is_set() and len(killed) < 3:
            for log in out.glob("*/*drive*"):
                if log.parent.joinpath(RECORD_NAME).exists():
                    continue
                for worker in worker_processes():
                    if worker not in killed and len(killed) < 3:
                        killed.append(worker)
                        os.kill(worker, signal.SIGKILL)
                        break
            time.sleep(0.2)

    killer = threading.Thread(target=kill_workers)
    killer.start()
    try:
        batch(drives, "--out", out, "--workers", 2)
    finally:
        stop.set()
        killer.join()
    assert killed
    code, records = batch(drives, "--out", out, "--scheduler", scheduler)
    assert code == 0
    assert {name: record["state"] for name, record in records.items()} == dict.fromkeys(
        ("d0", "d1", "d2"), "done"
    )
    for name in records:
        assert len(list(read_drive(out / name).results())) == FRAMES


def worker_processes() -> list[int]:
    """Dask's workers below this process: children of its nannies' spawning."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
            command = (stat.parent / "cmdline").read_bytes()
            if parent == os.getpid() and b"spawn_main" in command:
                found.append(int(stat.parent.name))
    return found


def test_any_cluster_gives_the_same_table_and_pieces_the_same_logs(drives, tmp_path, scheduler):
    own, theirs = tmp_path / "own", tmp_path / "theirs"
    assert batch(drives, "--out", own, "--workers", 1)[0] == 0
    with contextlib.chdir(tmp_path):  # the workers are elsewhere
        assert batch("drives", "--out", "theirs", "--scheduler", scheduler, "--piece-minutes", 0.008)[0] == 0
    for path in own.rglob("*"):
        # The page's list has the times of the logs' files.
        if path.suffix in (".parquet", ".mcap", ".html") and path.name != REVIEW_LIST_NAME:
            assert filecmp.cmp(path, theirs / path.relative_to(own), shallow=False), path


def test_a_second_folder_adds_to_the_tables_and_a_busy_drive_is_left_alone(drives, tmp_path, scheduler):
    out, others = tmp_path / "out", tmp_path / "others"
    others.mkdir()
    for suffix in (".mp4", ".calibration.yaml"):
        (drives / f"d1{suffix}").rename(others / f"d0{suffix}")
        (drives / f"d2{suffix}").unlink()
    assert batch(drives, "--out", out, "--scheduler", scheduler)[0] == 0
    judge_first_warning(out / "d0")
    code, records = batch(others, "--out", out, "--scheduler", scheduler)
    (name,) = records
    assert (code, name.startswith("d0-")) == (0, True)
    table = pq.read_table(out / "events.parquet").to_pylist()
    assert {event["drive"]: Path(event["source"]).parent.name for event in table} == {
        "d0": "drives",
        name: "others",
    }
    assert [event["drive"] for event in table if event["verdict"]] == ["d0"]
    # A task of a batch whose client was killed may still write there.
    (out / name / RECORD_NAME).unlink()
    lock = LockedFile.open(out / name / ".fcw.lock")
    assert lock is not None
    code, records = batch(others, "--out", out, "--scheduler", scheduler)
    assert (code, records[name]["state"]) == (2, "not finished")
    lock.close()
    code, records = batch(others, "--out", out, "--scheduler", scheduler)
    assert (code, records[name]["state"]) == (0, "done")
    # Once a batch has seen where the drive was moved to, each later one says so.
    for folder in (others.rename(tmp_path / "moved"), drives):
        assert batch(folder, "--out", out, "--scheduler", scheduler)[0] == 0
    table = pq.read_table(out / "events.parquet").to_pylist()
    assert {Path(event["source"]).parent.name for event in table if event["drive"] == name} == {"moved"}


def test_what_cannot_be_is_refused(tmp_path, capsys):
    for name in ("a", "b"):
        (tmp_path / f"{name}.mp4").write_bytes(b"a video")
    (tmp_path / "broken.onnx").write_bytes(b"no net")
    (tmp_path / "notes").touch()
    for arguments, told in (
        (["--workers", "0"], "--workers 0"),
        (["--workers", "1", "--scheduler", "tcp://127.0.0.1:1"], "--workers 1"),
        (["--piece-minutes", "-1"], "--piece-minutes -1"),
        (["--detector", "best"], "--detector best"),
        (["--warning-policy", "never"], "never"),
        (["--detector", f"onnx:{tmp_path}/broken.onnx"], f"{tmp_path}/broken.onnx"),
        (
            ["--out", str(tmp_path / "notes")],
            "batch's folder (File exists); name a folder that can be made",
        ),
    ):
        out = [] if "--out" in arguments else ["--out", str(tmp_path / "out")]
        assert main(["batch", str(tmp_path), *out, *arguments]) == 2
        captured = capsys.readouterr()
        assert told in captured.err
        assert captured.err.count("\n") == 1
        assert captured.out == ""
