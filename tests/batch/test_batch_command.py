"""`fcw batch` on real workers: broken drives, killed workers, other people's schedulers."""

import contextlib
import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import duckdb
import pyarrow.parquet as pq
import pytest
from running.demo_cut import cut_demo

from fcw.annotation.records import EventReference, Judgement, Verdict
from fcw.annotation.store import ReviewStore
from fcw.batch.ledger import MANIFEST_NAME, RECORD_NAME
from fcw.logs.events import find_events
from fcw.logs.mcap.reader import read_drive
from fcw_viz.cli import main

pytestmark = pytest.mark.slow
ARGUMENTS = ["--detector", "acf", "--json"]


@pytest.fixture
def drives(tmp_path) -> Path:
    """Three drives of two seconds that differ, each with its calibration: in all of them the lead brakes."""
    for number in range(3):
        cut_demo(tmp_path / "drives", 30 + number, 2, f"d{number}")
    return tmp_path / "drives"


def batch(*arguments: object) -> tuple[int, dict[str, dict[str, object]]]:
    """Exit code, and what came of each drive."""
    with contextlib.redirect_stdout(io.StringIO()) as told:
        code = main(["batch", *map(str, arguments), *ARGUMENTS])
    return code, {record["name"]: record for record in json.loads(told.getvalue())}


def test_good_drives_are_done_and_each_other_one_is_named(drives, tmp_path):
    shutil.copy(drives / "d0.mp4", drives / "copy.mp4")
    shutil.copy(drives / "d0.calibration.yaml", drives / "copy.calibration.yaml")
    shutil.copy(drives / "d1.mp4", drives / "bare.mp4")
    (drives / "torn.mp4").write_bytes((drives / "d1.mp4").read_bytes()[:5000])
    shutil.copy(drives / "d0.calibration.yaml", drives / "torn.calibration.yaml")
    out = tmp_path / "out"
    code, records = batch(drives, "--out", out, "--workers", 2)
    assert code == 2
    states = {name: record["state"] for name, record in records.items()}
    assert states == {
        "copy": "done",
        "d0": "duplicate",
        "d1": "done",
        "d2": "done",
        "bare": "no calibration",
        "torn": "failed",
    }
    assert "torn.mp4" in str(records["torn"]["reason"])
    manifest = json.loads((out / MANIFEST_NAME).read_text())
    assert manifest["versions"]["fcw"]
    assert {drive["name"] for drive in manifest["drives"]} == set(records)
    table = pq.read_table(out / "drives.parquet").to_pydict()
    assert dict(zip(table["drive"], table["state"], strict=True)) == states
    # Each drive is what `fcw run` makes of it, and nothing is run twice.
    assert main(["run", str(drives / "d1.mp4"), "--out", str(tmp_path / "alone"), "--detector", "acf"]) == 0
    assert list(read_drive(out / "d1").results()) == list(read_drive(tmp_path / "alone").results())
    written = {path: path.stat().st_mtime_ns for path in out.glob("*/drive.mcap")}
    events = (out / "events.parquet").read_bytes()
    judge_first_warning(out / "d1")
    assert batch(drives, "--out", out, "--workers", 1)[0] == 2
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


def test_killed_workers_lose_no_drive(drives, tmp_path):
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
    code, records = batch(drives, "--out", out, "--workers", 2)
    assert code == 0
    assert {name: record["state"] for name, record in records.items()} == dict.fromkeys(
        ("d0", "d1", "d2"), "done"
    )
    for name in records:
        assert len(list(read_drive(out / name).results())) == 60


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


def test_a_scheduler_started_by_hand_gives_the_same_table(drives, tmp_path):
    for path in drives.glob("d0.*"):
        path.unlink()
    assert batch(drives, "--out", tmp_path / "own", "--workers", 1)[0] == 0
    assert pq.read_table(tmp_path / "own" / "events.parquet").num_rows > 0
    address_file = tmp_path / "scheduler.json"
    here = ("--host", "127.0.0.1", "--no-dashboard")
    with contextlib.ExitStack() as ended:
        scheduler = start_dask(ended, "scheduler", *here, "--port", "0", "--scheduler-file", address_file)
        while not (address := address_in(address_file)):
            assert scheduler.poll() is None
            time.sleep(0.1)
        scratch = ("--local-directory", tmp_path / "scratch")
        start_dask(ended, "worker", address, *here, "--nthreads", "1", *scratch)
        assert batch(drives, "--out", tmp_path / "theirs", "--scheduler", address)[0] == 0
    for table in ("events.parquet", "drives.parquet"):
        assert (tmp_path / "own" / table).read_bytes() == (tmp_path / "theirs" / table).read_bytes()


def start_dask(ended: contextlib.ExitStack, *arguments: object) -> "subprocess.Popen[bytes]":
    """A program of Dask's, until the end."""
    command = [sys.executable, "-m", "dask", *map(str, arguments)]
    process = ended.enter_context(subprocess.Popen(command, stderr=subprocess.DEVNULL))
    ended.callback(process.terminate)
    return process


def address_in(file: Path) -> str:
    """The scheduler's; nothing before its file is whole."""
    with contextlib.suppress(FileNotFoundError, json.JSONDecodeError):
        return json.loads(file.read_text())["address"]
    return ""


def test_what_cannot_be_is_refused(tmp_path, capsys):
    (tmp_path / "a.mp4").write_bytes(b"")
    for arguments, told in (
        (["--workers", "0"], "--workers 0"),
        (["--workers", "1", "--scheduler", "tcp://127.0.0.1:1"], "--workers 1"),
        (["--detector", "best"], "--detector best"),
        (["--warning-policy", "never"], "never"),
    ):
        assert main(["batch", str(tmp_path), "--out", str(tmp_path / "out"), *arguments]) == 2
        assert told in capsys.readouterr().err
