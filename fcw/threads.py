"""What there is to share among threads: the cores, and OpenCV's own threads."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_lock = threading.Lock()
_holders = 0
_before = 0
"""OpenCV's threads, as they were before the first of those who hold them at one."""


def available_cores() -> int:
    """Those that this process may run on, where the system tells (Linux); else all of the computer's."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def one_opencv_thread() -> Iterator[None]:
    """OpenCV's calls stay in the thread that makes them, until the last who asked for it has ended.

    Where frames are worked on in several threads, OpenCV's own pool has no core left to win: its threads wait
    for each other, a tenth of the processor's time in `fcw run`. The setting is the whole process's: in a
    batch one worker follows a drive and searches pieces of it at the same time.
    """
    import cv2  # whoever only counts cores does without it

    global _holders, _before
    with _lock:
        if _holders == 0:
            _before = cv2.getNumThreads()
            cv2.setNumThreads(1)
        _holders += 1
    try:
        yield
    finally:
        with _lock:
            _holders -= 1
            if _holders == 0:
                cv2.setNumThreads(_before)
