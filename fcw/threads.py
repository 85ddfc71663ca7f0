"""What there is to share among threads: the cores, and OpenCV's own threads."""

import os
from collections.abc import Iterator
from contextlib import contextmanager


def available_cores() -> int:
    """Those that this process may run on, where the system tells (Linux); else all of the computer's."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def one_opencv_thread() -> Iterator[None]:
    """OpenCV's calls stay in the thread that makes them.

    Where frames are worked on in several threads, OpenCV's own pool has no core left to win: its threads wait
    for each other, a tenth of the processor's time in `fcw run`.
    """
    import cv2  # whoever only counts cores does without it

    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)
