"""The commands that the documents show, and how each is run."""

import re
import shlex
from pathlib import Path

ROOT = Path(__file__).parents[3]
DOCUMENTS = sorted(
    path
    for pattern in ("*.md", "docs/**/*.md", "recordings/*.md", "fcw/detection/weights/*.md")
    for path in ROOT.glob(pattern)
)
PROGRAMS = ("fcw", "python", "make", "pip")
PLACEHOLDERS = {
    "D:ROW": "6:640",
    "D": "6",
    "H": "1.3",
    "N": "3",
    "X": "0.1",
    "S": "1",
    "DEG": "0.5",
    "MPS": "20",
    "WxH": "1280x720",
    "FORMAT": "csv",
    "NAME": "ttc",
}
"""What stands for a value that an option checks while it is parsed; other capitals may stay as they are."""
QUICK = (
    "fcw calibrate --points 4:461 5:428 7:383 --image-size 1280x720 --height 1.225",
    "fcw calibrate --points 4:461 5:428 7:383 --image-size 1280x720 --height 1.225 --exact",
    "fcw calibrate drive.mp4 --points 6:640 15:520 30:480 --height 1.25",
    "fcw calibrate --dashes 612 498 460 442 --dash-period 12 --height 1.25 --image-size 1280x720",
    "fcw --help",
    "fcw --version",
    "fcw COMMAND --help",
)
"""Run by `tests/test_document_commands.py`, as they stand."""
ELSEWHERE = {
    "make": "the build itself; CI runs `make test`, which begins with what `make check` does",
    "pip": "needs the network; the extras' names are tested",
    "python -m build": "makes the wheel; done for a release",
    "python tests/fuzz/faults.py": "make soak",
    "python": "benchmarks and pictures: minutes to hours, and some need a browser or FCW_DATA",
    "fcw run": "tests/commands/test_run_command.py, tests/commands/test_run_live_command.py",
    "fcw demo": "tests/commands/test_demo.py",
    "fcw bench": "tests/commands/test_bench.py",
    "fcw batch": "tests/batch/test_batch_command.py",
    "fcw calibrate": "tests/commands/calibrate, tests/browser/calibrate",
    "fcw review": "tests/browser/review, tests/annotation/test_review_summary.py",
    "fcw export": "tests/commands/export/test_export_command.py",
    "fcw recover": "tests/logs/mcap/test_recovery.py",
    "fcw simulate": "tests/commands/test_simulate_command.py",
    "fcw train": "tests/detection/training/test_training.py, tests/detection/net/test_net_training.py",
    "fcw evaluate warning": "tests/commands/test_evaluate_warning_command.py",
    "fcw evaluate": "tests/commands/test_evaluate_command.py",
}
"""Those that take longer, or need a page, data or weights: how they begin, and what runs them."""
LONG = (
    "fcw demo --no-serve",
    "python docs/theory_figures.py recordings/demo/out pictures",
    "fcw run drive.mp4",
    "fcw calibrate drive.mp4 --from-clip --field-of-view 60 --height 1.25",
    "fcw calibrate drive.mp4 --from-clip",
    "fcw calibrate --from-drive recordings/drive --save mount.calibration.yaml",
    "fcw review recordings/drive --summary",
    "fcw export recordings --format coco --pictures --every 30 --out labelled",
    "fcw evaluate detection labelled/labels.json --images labelled/images --calibration labelled/calibration",
    "fcw train --data labelled --out mine.npz",
    "fcw batch drives --out batch",
    "fcw simulate braking --out simulated",
    "fcw bench --rounds 1 --detector-frames 10",
    "fcw evaluate warning --ncap",
    "fcw evaluate warning --threats --seeds 1",
    "fcw evaluate warning --following-hours 1",
    "fcw evaluate motion --bends",
    "python docs/licence_list.py",
)
"""Run one after the other in a scratch folder by `python docs/run_commands.py`: some take minutes."""


def shown_commands(document: Path) -> list[str]:
    """Commands in a document's blocks and in its lines, without comments and the sign of an alternative."""
    text = document.read_text(encoding="utf-8").replace("\\|", "|")
    blocks = re.findall(r"^```(?:sh)?\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    beside = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    blocks += re.findall(r"^(?:    \S.*\n)+", beside, re.MULTILINE)
    lines = [line.strip() for block in blocks for line in block.splitlines()]
    lines += re.findall(r"`((?:fcw|python|make|pip)\s[^`]+)`", beside)
    commands = (re.sub(r"\s+#.*", "", re.sub(r"\s+", " ", line)) for line in lines)
    return [
        command
        for command in (re.sub(r"^FCW_DATA=\S+ ", "", command) for command in commands)
        if command.startswith(tuple(f"{program} " for program in PROGRAMS))
    ]


def filled(command: str) -> list[str]:
    """A command's arguments with its optional parts, the first of its alternatives, and values for names."""
    command = re.sub(r"\[([a-z0-9]+)\]'", r"<\1>'", command)  # an extra is no optional part
    plain = command.replace("[", "").replace("]", "").replace("...", "").replace("<", "[").replace(">", "]")
    words = [re.sub(r"\|.*", "", word) for word in shlex.split(plain)]
    return [PLACEHOLDERS.get(word, word) for word in words]
