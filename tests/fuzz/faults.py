"""Faults: commands are ended at moments of their lives, or their disk, folder, handles or memory end.

    python tests/fuzz/faults.py [--moments 10] [--only run]

Prints JSON: how many faults of each command, the exit codes seen, and everything that was not as
docs/faults.md says; the exit code is 1 where there is any such thing.
"""

import argparse
import json
import re
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))
sys.path.insert(0, str(Path(__file__).parents[2]))  # this checkout, whatever is installed

import limits
from drives.rrd_files import read_frame_times
from fault_running import FCW, ROOT, Ended, Report, run, send, signal_troubles
from review_drives import write_drive
from training.pictures import write_drawn_set
from video_making import first_frames

from fcw.annotation.store import read_review
from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.recovery import recover

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
DRIVE_NAMES = {"drive.mcap", "drive.rrd", "summary.json"}
PATCHED = """
import sys
from fcw_viz.signals import signals_as_interrupts
try:
    with signals_as_interrupts():
        {patch}
except KeyboardInterrupt:
    sys.exit(130)
from fcw_viz.__main__ import main
sys.exit(main())
"""
SMALL_TRAINING = """
        from dataclasses import replace
        import fcw.detection.training.training as training
        settings = training.TrainingSettings
        training.TrainingSettings = lambda seed: replace(settings(seed=seed), tree_counts=(2, 4), folds=2,
            second_tree_count=2, second_runs=1, crops_per_vehicle=1, displaced_per_vehicle=1,
            random_per_image=10, mined_per_image=5)
"""
TALKING_REVIEW = """
        from fcw.annotation.records import Note
        from fcw_viz.review_app.server import ReviewPage
        def talk(page):
            drive = next(iter(page.session.drives))
            page.session.open(page, drive)
            for number in range(100_000):
                entry, = page.session.say(drive, Note(float(number), "note"))
                print("kept", entry.entry_id, flush=True)
        ReviewPage.wait = talk
"""


@dataclass(frozen=True)
class Life:
    """A command that is ended at moments of its life.

    Attributes:
        prepare: makes what it reads in its folder, the same each time.
        command: what is run there.
        check: after its end: what is not as it should be; the signal's number is None where it was not ended.
        lasts_s: its life, where it has no end of its own.
    """

    prepare: Callable[[Path], object]
    command: list[str]
    check: Callable[[Path, Ended, signal.Signals | None], Iterator[str]]
    lasts_s: float | None = None


def patched(patch: str) -> str:
    """The program with something of it changed first; a signal meanwhile ends it as later."""
    return PATCHED.format(patch=patch.strip())


def lives(made: Path) -> dict[str, Life]:
    """The commands, on inputs that are made once in a folder."""
    drive, earlier, log, pictures = (made / name for name in ("drive.mp4", "earlier", "log", "pictures"))
    video = ROOT / "recordings" / "demo" / "drive.mp4"
    first_frames(video, drive, 120)
    shutil.copy(video.with_name("drive.calibration.yaml"), made)
    first_frames(video, made / "short.mp4", 12)
    shutil.copy(video.with_name("drive.calibration.yaml"), made / "short.calibration.yaml")
    ended = run([*FCW, "run", str(made / "short.mp4"), "--out", str(earlier)], made)
    assert ended.code == 0, ended.said
    write_drive(log / "drive.mcap", 24.0)
    write_drawn_set(pictures, 6, seed=1)
    whole = {path.name: path.read_bytes() for path in earlier.iterdir()}

    def check_run(folder: Path, ended: Ended, number: signal.Signals | None) -> Iterator[str]:
        yield from drive_troubles(folder / "out", whole, number)
        if number is signal.SIGKILL:
            again = run([*FCW, "run", str(made / "short.mp4"), "--out", "out"], folder)
            if again.code != 0:
                yield f"the next run ended with {again.code}: {again.said[-800:]}"
            elif left := {path.name for path in (folder / "out").iterdir()} - DRIVE_NAMES:
                yield f"the next run left {left}"

    def export(name: str, *options: str) -> Life:
        def prepare(folder: Path) -> None:
            (folder / "out").mkdir()
            (folder / "out" / name).write_bytes(b"earlier")

        command = [*FCW, "export", str(log), "--format", Path(name).suffix[1:], "--out", f"out/{name}"]
        return Life(prepare, [*command, "--overwrite", *options], whole_file_check(f"out/{name}"))

    def check_training(folder: Path, ended: Ended, number: signal.Signals | None) -> Iterator[str]:
        if number is not None and ended.code != 0:
            ended = run(training, folder)
            if ended.code != 0:
                yield f"the same command again ended with {ended.code}: {ended.said[-800:]}"
                return
        model = (folder / "m.npz").read_bytes()
        if model != uninterrupted.setdefault("model", model):
            yield "the model is another one than without the stop"
        if left := {path.name for path in folder.iterdir()} - {"m.npz", "m.npz.log.jsonl", "said", "state"}:
            yield f"left {left}"

    def check_review(folder: Path, ended: Ended, number: signal.Signals | None) -> Iterator[str]:
        # The last line may be cut off: the words were kept, and their number was not told any more.
        kept = re.findall(r"^kept (\S+)$", ended.said, re.MULTILINE)
        review, troubles = read_review(DriveLog(folder / "drive.mcap"))
        found = [entry.entry_id for entry in review.entries]
        if found[: len(kept)] != kept or len(found) > len(kept) + 1 or troubles:
            yield f"{len(found)} of {len(kept)} words are kept; {troubles}"
        if (folder / "drive.mcap").read_bytes() != (log / "drive.mcap").read_bytes():
            yield "the log was changed"

    uninterrupted: dict[str, bytes] = {}
    training = [
        sys.executable,
        "-c",
        patched(SMALL_TRAINING),
        "train",
        "--data",
        str(pictures),
        "--out",
        "m.npz",
        "--overwrite",  # a signal may come when the model is there
    ]
    reviewing = [
        sys.executable,
        "-c",
        patched(TALKING_REVIEW),
        "review",
        "drive.mcap",
        "--no-open",
        "--reviewer",
        "Ann",
    ]
    return {
        "run": Life(
            lambda folder: shutil.copytree(earlier, folder / "out"),
            [*FCW, "run", str(drive), "--out", "out"],
            check_run,
        ),
        "export csv": export("tracks.csv"),
        "export mp4": export("drive.mp4"),
        "export mcap": export("cut.mcap", "--between", "2", "22"),
        "train": Life(lambda folder: None, training, check_training),
        "review": Life(
            lambda folder: shutil.copy(log / "drive.mcap", folder), reviewing, check_review, lasts_s=15.0
        ),
    }


def drive_troubles(out: Path, earlier: dict[str, bytes], number: signal.Signals | None) -> Iterator[str]:
    """What a run leaves: one whole drive; after a kill also the earlier one aside, and a log to recover."""
    there = {path.name for path in out.iterdir()}
    is_earlier = all(
        (out / name).is_file() and (out / name).read_bytes() == data for name, data in earlier.items()
    )
    if number is signal.SIGKILL:
        aside = list(out.glob(".earlier-*"))
        if aside and [sorted(path.name for path in one.iterdir()) for one in aside] != [sorted(earlier)]:
            yield f"the earlier drive is in pieces: {[list(one.iterdir()) for one in aside]}"
        log = out / "drive.mcap"
        if aside and log.exists() and log.stat().st_size:
            try:
                frames = len(list(DriveLog(log).results()))
                if frames:
                    recover(log, out.parent / "recovered.mcap")
            except UserError as error:
                if "before the first frame" not in str(error) and "no drive log" not in str(error):
                    yield f"the killed run's log: {error}"
        return
    if there != DRIVE_NAMES:
        yield f"there are {sorted(there)}"
    elif not is_earlier:
        log = DriveLog(out / "drive.mcap")
        frames = [(result.index, result.time_ns) for result in log.results()]
        if not log.complete or read_frame_times(out / "drive.rrd") != frames:
            yield "the logs are not whole"
        if json.loads((out / "summary.json").read_text())["frames"] != len(frames):
            yield "the summary is of another drive"


def whole_file_check(name: str) -> Callable[[Path, Ended, signal.Signals | None], Iterator[str]]:
    """A file is as it was, or as long as the command that was not stopped made it; nothing else is left."""
    sizes: dict[str, int] = {}

    def check(folder: Path, ended: Ended, number: signal.Signals | None) -> Iterator[str]:
        path = folder / name
        data = path.read_bytes()
        if number is None:
            sizes[name] = len(data)
        if data != b"earlier" and abs(len(data) - sizes[name]) > 64:  # an id or a date in it
            yield f"{name} has {len(data)} of {sizes[name]} bytes"
        left = [one.name for one in path.parent.iterdir() if one != path]
        if left and (number is not signal.SIGKILL or any(not one.startswith(".") for one in left)):
            yield f"left {left}"

    return check


def end_at_moments(kind: str, life: Life, moments: int, report: Report) -> None:
    """Every signal at so many moments between the start of a command and its end."""

    def one(number: signal.Signals | None, after_s: float) -> Ended:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            life.prepare(folder)
            ended = run(life.command, folder, send(number, after_s) if number else None)
            troubles = list(life.check(folder, ended, number))
            if number:
                troubles += signal_troubles(number, ended)
            elif ended.code != 0:
                troubles.append(f"exit code {ended.code}: {ended.said[-800:]}")
        report.note(kind, f"{number.name} at {after_s:.2f} s" if number else "none", ended.code, troubles)
        return ended

    lasts_s = life.lasts_s or one(None, 0.0).took_s
    for number in SIGNALS:
        for moment in range(moments):
            one(number, lasts_s * (moment + 0.5) / moments)


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--moments", type=int, default=10)
    parser.add_argument(
        "--only", default="", help="the commands whose name holds this; limits: disks and so on"
    )
    arguments = parser.parse_args()
    report, started_s = Report(), time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        made = Path(name)
        chosen = lives(made)
        for kind, life in chosen.items():
            if arguments.only in kind:
                end_at_moments(kind, life, arguments.moments, report)
        if arguments.only in "limits":
            limits.try_all(made, report)
    result = {
        "tried": dict(report.tried),
        "seconds": round(time.monotonic() - started_s),
        "codes": dict(report.codes),
        "skipped": report.skipped,
        "troubles": report.troubles,
    }
    sys.stdout.write(json.dumps(result, indent=1) + "\n")
    return 1 if report.troubles else 0


if __name__ == "__main__":
    sys.exit(main())
