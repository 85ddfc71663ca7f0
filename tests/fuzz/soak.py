"""Runs the corpus: every good and crafted file, mutations as long as there is time, and bad command lines.

    python tests/fuzz/soak.py [--seconds 600] [--each] [--seed 1] [--format NAME] [--every N]
        [--drive-hours H]

Prints JSON: how many inputs, and every one that ended in anything but a result or a UserError (of a command
line: exit code 0 or 2), took over 10 s, or took the process over 1 GB. The exit code is 1 where there is one.
The inputs of a seed are always the same.
"""

import argparse
import contextlib
import io
import itertools
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))
sys.path.insert(0, str(Path(__file__).parents[2]))  # this checkout, whatever is installed

import crafted_binaries
import crafted_labels
import crafted_places
import crafted_texts
from command_lines import command_lines
from driving import drive_for
from mutations import mutated
from readers import Format, formats
from review_drives import write_drive

from fcw.errors import UserError
from fcw_viz.cli import main as fcw

LONGEST_S = 10.0
"""Of processor time, for the machine may be busy; what waits has six times as long."""
LARGEST_MB = 1000
COMMAND_LINES = "command lines"
FEWEST_MUTATIONS = 30
"""Of each format, also where time is short."""


class TooLongError(BaseException):
    """Not caught by what is tested."""


@dataclass
class Outcome:
    """What came of it."""

    inputs: int = 0
    failures: list[dict[str, str]] = field(default_factory=list)
    slowest_s: float = 0.0
    slowest: str = ""
    verbose: bool = False

    def run(self, name: str, work: Callable[[], object]) -> None:
        """One input."""
        self.inputs += 1
        if self.verbose:
            sys.stderr.write(f"{name}\n")
            if not Path("/dev/null").is_char_device():
                sys.stderr.write("NULLGONE\n")
                os._exit(9)
        started_s, trouble = time.process_time(), ""
        signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
        signal.setitimer(signal.ITIMER_REAL, 6 * LONGEST_S)
        try:
            work()
        except (UserError, OSError):  # what the system refuses ends a command with 2 as well
            pass
        except TooLongError:
            trouble = f"over {LONGEST_S:g} s"
        except BaseException:
            trouble = traceback.format_exc(limit=-4)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            signal.setitimer(signal.ITIMER_REAL, 0)
        took_s = time.process_time() - started_s
        if took_s > self.slowest_s:
            self.slowest_s, self.slowest = took_s, name
        if took_s > LONGEST_S:
            trouble = trouble or f"took {took_s:.1f} s"
        if (
            not trouble
            and peak_mb() > LARGEST_MB
            and not any("MB" in one["trouble"] for one in self.failures)
        ):
            trouble = f"{peak_mb():.0f} MB"
        if trouble and self.verbose:
            sys.stderr.write(f"FAILED {trouble}\n")
        if trouble:
            self.failures.append({"input": name, "trouble": trouble})


def peak_mb() -> float:
    """The most memory that the process has had."""
    status = Path("/proc/self/status")
    if status.exists():  # getrusage's begins with what the process that started this one had
        (high_kb,) = (line.split()[1] for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(high_kb) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def more_crafted(form: Format) -> Iterable[bytes]:
    """What a second person thought of."""
    makers = crafted_texts.BY_NAME | crafted_labels.BY_NAME | crafted_binaries.BY_NAME
    return makers[form.name](form.good) if form.name in makers else []


def read(form: Format, data: bytes, folder: Path) -> None:
    """One file, in a folder that is made for it."""
    place = folder / "one"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    path = place / form.name
    path.write_bytes(data)
    form.read(path)


def command(arguments: list[str]) -> None:
    """A command line in this process; argument mistakes end in tyro's own exit."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as said:
        try:
            code = fcw(arguments)
        except SystemExit as ended:
            code = ended.code
    if code not in (0, 2) or "Traceback" in said.getvalue():
        raise AssertionError(f"exit code {code}: {said.getvalue()[-2000:]}")


def soak(
    log: Path,
    seconds: float,
    seed: int,
    only: str = "",
    mutations: int = FEWEST_MUTATIONS,
    verbose: bool = False,
    every: int = 1,
) -> Outcome:
    """All of it, in a folder that goes away; of the command lines `every` how many-th one."""
    outcome, end_s = Outcome(verbose=verbose), time.monotonic() + seconds

    def too_long(*_: object) -> None:
        raise TooLongError

    signal.signal(signal.SIGALRM, too_long)
    signal.signal(signal.SIGPROF, too_long)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copy(log, folder / "good.mcap")
        known = formats(log.read_bytes())
        chosen = [form for form in known if only in form.name]
        for form in chosen:
            first = (form.good, b"", b"\0" * 1000, *form.crafted)
            for number, data in enumerate(itertools.chain(first, more_crafted(form))):
                outcome.run(
                    f"{form.name} crafted {number}", lambda form=form, data=data: read(form, data, folder)
                )
        if only in COMMAND_LINES:
            places, picture = folder / "places", next(form.good for form in known if form.name == "1.jpg")
            places.mkdir()
            os.chdir(places)
            crafted = crafted_places.command_lines(places, picture, log.read_bytes())
            for arguments in (*command_lines(str(folder)), *crafted)[::every]:
                outcome.run(ascii(arguments)[:300], lambda arguments=arguments: command(arguments))
            changed = crafted_places.changed_inputs(places)
            outcome.failures += [{"input": name, "trouble": "was changed by an output"} for name in changed]
        number = 0
        while number < mutations or time.monotonic() < end_s:
            for form in chosen:
                dice = random.Random(f"{seed}/{form.name}/{number}")
                data = mutated(form.good, dice)
                outcome.run(
                    f"{form.name} {seed}/{number}", lambda form=form, data=data: read(form, data, folder)
                )
            number += 1
    return outcome


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--each", action="store_true", help="so many seconds for each format")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--format", default="", help=f"formats whose file's name holds this, or {COMMAND_LINES}"
    )
    parser.add_argument("--verbose", action="store_true", help="say each input before it is tried")
    parser.add_argument("--mutations", type=int, default=FEWEST_MUTATIONS, help="of each format, at least")
    parser.add_argument("--every", type=int, default=1, help="of the command lines only each so many-th")
    parser.add_argument("--drive-hours", type=float, default=0.0, help="drive so long afterwards")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        log = write_drive(Path(folder) / "drive.mcap", 2.0)
        seconds = arguments.seconds * (len(formats(log.read_bytes())) if arguments.each else 1)
        outcome = soak(
            log,
            seconds,
            arguments.seed,
            arguments.format,
            arguments.mutations,
            arguments.verbose,
            arguments.every,
        )
    result = {
        "inputs": outcome.inputs,
        "slowest_s": round(outcome.slowest_s, 2),
        "slowest": outcome.slowest,
        "peak_mb": round(peak_mb()),
        "failures": outcome.failures,
    }
    if arguments.drive_hours:
        driven = drive_for(arguments.drive_hours, lambda text: print(text, file=sys.stderr, flush=True))  # noqa: T201
        result["drive"] = driven
        outcome.failures += [{"input": "hours of drive", "trouble": f"grew: {driven['grown']}"}] * bool(
            driven["grown"]
        )
    sys.stdout.write(json.dumps(result, indent=1) + "\n")
    sys.stdout.flush()
    os._exit(1 if outcome.failures else 0)  # a reader that hangs in a thread does not hold it up


if __name__ == "__main__":
    main()
