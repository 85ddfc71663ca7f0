"""Full and read-only disks, folders that go away, too few handles, too little memory, and too small files."""

import os
import resource
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fault_running import FCW, Ended, Report, message_troubles, run

Fault = Callable[[subprocess.Popen[bytes]], None]
SPIN_S = 120.0
"""A command that has not ended after so long, where it can't do its work, spins."""


def try_all(made: Path, report: Report) -> None:
    """Every one of them; `made` has the inputs of `faults.lives`."""
    try_disks(made, report)
    try_folders(made, report)
    try_limits(made, report)


def commands(made: Path, out: Path) -> dict[str, list[str]]:
    """What writes, each onto a disk."""
    return {
        "run": [*FCW, "run", str(made / "drive.mp4"), "--out", str(out / "drive")],
        "export csv": [*FCW, "export", str(made / "log"), "--format", "csv", "--out", str(out / "t.csv")],
        "export mp4": [*FCW, "export", str(made / "log"), "--format", "mp4", "--out", str(out / "t.mp4")],
        "export mcap": [*FCW, "export", str(made / "log"), "--format", "mcap", "--out", str(out / "t.mcap")],
        "export rrd": [*FCW, "export", str(made / "log"), "--format", "rrd", "--out", str(out / "t.rrd")],
        "recover": [*FCW, "recover", str(made / "log" / "drive.mcap"), "--out", str(out / "t.mcap")],
        "simulate": [*FCW, "simulate", "cut-in", "--out", str(out / "simulated")],
        "train": [*FCW, "train", "--data", str(made / "pictures"), "--out", str(out / "m.npz")],
    }


@contextmanager
def small_disk(size: str, *options: str) -> Iterator[Path]:
    """A file system of its own.

    Raises:
        PermissionError: this user may not mount one.
    """
    with tempfile.TemporaryDirectory() as name:
        mounted = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", ",".join((f"size={size}", *options)), "none", name],
            capture_output=True,
            check=False,
        )
        if mounted.returncode:
            raise PermissionError(mounted.stderr.decode().strip())
        try:
            yield Path(name)
        finally:
            subprocess.run(["umount", "--lazy", name], check=True)


def try_disks(made: Path, report: Report) -> None:
    """Full from the start, full midway, and read-only."""
    disks = {
        "disk full from the start": ("4k",),
        "disk full midway": ("100k",),
        "read-only disk": ("1m", "ro"),
    }
    for fault, options in disks.items():
        for kind in commands(made, made):
            try:
                with small_disk(*options) as disk, tempfile.TemporaryDirectory() as folder:
                    if fault == "disk full from the start":
                        (disk / "filler").write_bytes(bytes(4096))
                    ended = run(commands(made, disk)[kind], Path(folder))
                    left = [
                        str(path.relative_to(disk))
                        for path in disk.rglob("*")
                        if path.is_file() and path.name not in KEPT and path.parent.suffix != ".parts"
                    ]
            except FileNotFoundError as error:
                report.skipped.append(f"{fault}: no mount ({error})")
                return
            except PermissionError as error:
                report.skipped.append(f"{fault}: may not mount a disk here ({error})")
                return
            troubles = message_troubles(ended)
            if left:
                troubles.append(f"left {left}")
            report.note(kind, fault, ended.code, troubles)


KEPT = {"filler", "failed-drive.mcap", "m.npz.log.jsonl", "identity"}
"""What a full disk leaves: the beginning of a drive, and of a training."""


def try_folders(made: Path, report: Report) -> None:
    """The folder of a run is moved, or deleted, while it is written; two runs have one folder."""

    def when_begun(act: Callable[[Path], object]) -> Callable[[Path], Fault]:
        def of(folder: Path) -> Fault:
            def fault(process: subprocess.Popen[bytes]) -> None:
                log = folder / "out" / "drive.mcap"
                while process.poll() is None and not (log.exists() and log.stat().st_size > 50_000):
                    time.sleep(0.02)
                act(folder / "out")

            return fault

        return of

    faults = {
        "folder moved": when_begun(lambda out: out.rename(out.with_name("elsewhere"))),
        "folder deleted": when_begun(shutil.rmtree),
        "log deleted": when_begun(lambda out: (out / "drive.mcap").unlink()),
    }
    command = [*FCW, "run", str(made / "drive.mp4"), "--out", "out"]
    for name, fault in faults.items():
        with tempfile.TemporaryDirectory() as text:
            folder = Path(text)
            ended = run(command, folder, fault(folder))
            report.note("run", name, ended.code, message_troubles(ended))
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        second: list[Ended] = []
        (folder / "second").mkdir()
        into_same = [*command[:-1], str(folder / "out")]
        started = when_begun(lambda out: second.append(run(into_same, folder / "second")))(folder)
        ended = run(command, folder, started)
        troubles = message_troubles(second[0], "another run is writing")
        if ended.code != 0:
            troubles.append(f"the first ended with {ended.code}: {ended.said[-800:]}")
        report.note("run", "two into one folder", second[0].code, troubles)


def try_limits(made: Path, report: Report) -> None:
    """Few handles, little memory, small files: one message, or the work done; no command that spins."""
    limits: dict[str, Callable[[], object]] = {
        f"ulimit -n {count}": lambda count=count: resource.setrlimit(resource.RLIMIT_NOFILE, (count, count))
        for count in (8, 12, 64)
    }
    limits |= {
        f"ulimit -v {mb} MB": lambda mb=mb: resource.setrlimit(resource.RLIMIT_AS, (mb << 20, mb << 20))
        for mb in (100, 400, 1600, 3000)
    }
    limits |= {
        f"ulimit -f {kb} kB": lambda kb=kb: resource.setrlimit(resource.RLIMIT_FSIZE, (kb << 10, kb << 10))
        for kb in (1, 100)
    }
    for fault, limit in limits.items():
        for kind in ("run", "export csv", "export mp4", "review"):
            with tempfile.TemporaryDirectory() as text:
                folder = Path(text)
                command = commands(made, folder).get(kind)
                if command is None:
                    shutil.copy(made / "log" / "drive.mcap", folder)
                    command = [*FCW, "review", "drive.mcap", "--no-open", "--port", "18281"]
                ended = run(command, folder, _ctrl_c_after_a_while, limit, SPIN_S)
            fine = ended.code in (0, 130) and "Traceback" not in ended.said
            report.note(kind, fault, ended.code, [] if fine else message_troubles(ended))


def _ctrl_c_after_a_while(process: subprocess.Popen[bytes]) -> None:
    """A page is served until then; a command that spins would ignore it."""
    end_s = time.monotonic() + SPIN_S / 4
    while process.poll() is None and time.monotonic() < end_s:
        time.sleep(0.05)
    if process.poll() is None:
        os.kill(process.pid, signal.SIGINT)
