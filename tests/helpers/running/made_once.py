"""What several test processes need, and one of them makes for all."""

import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from fcw.locked_file import LockedFile


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """A folder that the first who asks for it fills, also among the processes of one call of pytest.

    Nobody may write into it: others read it.
    """
    base = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        base = base.parent
    folder, unfinished = base / name, base / f"{name}.part"
    while (lock := LockedFile.open(base / f"{name}.lock")) is None:
        time.sleep(0.05)
    try:
        if not folder.exists():
            unfinished.mkdir()
            make(unfinished)
            unfinished.rename(folder)
    finally:
        lock.close()
    return folder
