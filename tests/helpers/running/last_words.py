"""What a test process was doing when it died, or before it is ended because a test hangs.

It goes to a file each, which the summary shows: of a long run people see the end, not what a worker wrote.
"""

import atexit
import faulthandler
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

FOLDER = "FCW_TEST_LAST_WORDS"
"""Names the folder of these files to the workers."""
BEFORE_THE_END_S = 30
_files: list[int] = []


def listen(worker: str | None) -> None:
    """Have the stacks of all threads written at a crash; without a worker's name, make the files' folder."""
    if worker is None:
        os.environ[FOLDER] = tempfile.mkdtemp()
        atexit.register(shutil.rmtree, os.environ[FOLDER], ignore_errors=True)
    _files.append(os.open(Path(os.environ[FOLDER], worker or "alone"), os.O_WRONLY | os.O_CREAT))
    faulthandler.enable(_files[-1])


@contextmanager
def told_before(timeout_s: float) -> Iterator[None]:
    """Have the same written of what still runs shortly before it is ended."""
    faulthandler.dump_traceback_later(max(timeout_s - BEFORE_THE_END_S, 1), file=_files[-1])
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


def last_words() -> dict[str, str]:
    """What was written, by process."""
    files = sorted(Path(os.environ[FOLDER]).iterdir())
    return {file.name: text for file in files if (text := file.read_text())}
