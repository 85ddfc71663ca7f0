"""Commands that are run to be disturbed, and what came of them."""

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[2]
FCW = (sys.executable, "-m", "fcw_viz")
PATIENCE_S = 300
HUNG = -999


@dataclass(frozen=True)
class Ended:
    """A command that has ended; its code is `HUNG` where it had to be killed."""

    code: int
    said: str
    took_s: float


@dataclass
class Report:
    """What was tried, and what was not as it should be."""

    tried: Counter[str] = field(default_factory=Counter)
    codes: Counter[str] = field(default_factory=Counter)
    troubles: list[dict[str, str]] = field(default_factory=list)
    skipped: list[str] = field(default_factory=list)

    def note(self, kind: str, fault: str, code: int, troubles: list[str]) -> None:
        """One fault."""
        self.tried[kind] += 1
        self.codes[f"{kind}, {fault.partition(' at ')[0]}: {code}"] += 1
        self.troubles += [{"command": kind, "fault": fault, "trouble": text} for text in troubles]
        sys.stderr.write(f"{kind}, {fault}: {code} {'; '.join(troubles)}\n")


def run(
    command: list[str],
    folder: Path,
    fault: Callable[[subprocess.Popen[bytes]], object] | None = None,
    limit: Callable[[], object] | None = None,
    patience_s: float = PATIENCE_S,
) -> Ended:
    """Run a command in a folder, do something to it, and wait for its end.

    What it says goes to the file `said` of the folder, what it keeps of its user to the folder `state`.
    """
    environment = os.environ | {"XDG_STATE_HOME": str(folder / "state"), "PYTHONPATH": str(ROOT)}

    def before() -> None:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)  # `nohup` has its children ignore it
        if limit:
            limit()

    started_s = time.monotonic()
    with (folder / "said").open("wb") as said:
        process = subprocess.Popen(
            command,
            stdout=said,
            stderr=said,
            start_new_session=True,
            env=environment,
            preexec_fn=before,
            cwd=folder,
        )
        if fault:
            fault(process)
        try:
            code = process.wait(patience_s)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            code = HUNG
    return Ended(code, (folder / "said").read_text(errors="replace"), time.monotonic() - started_s)


def send(number: signal.Signals, after_s: float) -> Callable[[subprocess.Popen[bytes]], None]:
    """A signal, after so long."""

    def fault(process: subprocess.Popen[bytes]) -> None:
        time.sleep(after_s)
        process.send_signal(number)

    return fault


def signal_troubles(number: signal.Signals, ended: Ended) -> list[str]:
    """Whether a command ended as documented after a signal; it may have come to its end before."""
    right = {0, -number} if number is signal.SIGKILL else {0, 130}
    if not ended.said:  # Python has not come to the program's first line yet
        right.add(-number)
    troubles = [] if ended.code in right else [f"exit code {ended.code}: {ended.said[-1500:]}"]
    if "Traceback" in ended.said:
        troubles.append(f"a traceback: {ended.said[-1500:]}")
    return troubles


def message_troubles(ended: Ended, *words: str) -> list[str]:
    """Whether a command ended with code 2 and one message that says these words."""
    troubles = [] if ended.code == 2 else [f"exit code {ended.code}: {ended.said[-1500:]}"]
    if "Traceback" in ended.said:
        troubles.append(f"a traceback: {ended.said[-1500:]}")
    messages = [line for line in ended.said.splitlines() if line.startswith("fcw: ")]
    if len(messages) != 1 or not all(word in ended.said for word in words):
        troubles.append(f"not one message with {words}: {ended.said[-800:]}")
    return troubles
