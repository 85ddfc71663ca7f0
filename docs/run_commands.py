"""Runs the long commands of the documents, one after the other, on the shipped drive in a scratch folder.

    python docs/run_commands.py [WORD]

With WORD, only the commands that contain it. Prints each command, the end of its output, its exit code
and its time. The exit code is 1 if one of them fails. `tests/helpers/documents/commands.py` has the list,
and names what runs the other commands.
"""

import argparse
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "tests" / "helpers"))

from documents.commands import LONG, ROOT


def main() -> int:
    """Run them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("word", nargs="?", default="", help="part of the commands that are run; default: all")
    wanted, failed = parser.parse_args().word, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "drives").mkdir()
        for place in (folder, folder / "drives"):
            for file in ("drive.mp4", "drive.calibration.yaml"):
                shutil.copy(ROOT / "recordings" / "demo" / file, place)
        shutil.copytree(ROOT / "recordings", folder / "recordings", ignore=shutil.ignore_patterns("out"))
        (folder / "docs").symlink_to(ROOT / "docs")
        (folder / "pictures").mkdir()
        for command in LONG:
            if wanted not in command:
                continue
            words = shlex.split(command)
            program = ["-m", "fcw_viz"] if words[0] == "fcw" else []
            started_s = time.monotonic()
            ended = subprocess.run(
                [sys.executable, *program, *words[1:]],
                cwd=folder,
                env=os.environ | {"PYTHONPATH": str(ROOT)},
                capture_output=True,
                text=True,
                check=False,
            )
            failed += ended.returncode != 0
            said = (ended.stdout or ended.stderr).strip()[-600:]
            sys.stdout.write(
                f"$ {command}\n{said}\n[{ended.returncode}, {time.monotonic() - started_s:.0f} s]\n\n"
            )
            sys.stdout.flush()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
