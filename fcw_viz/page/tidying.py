"""What closed tabs leave behind goes away soon, not at some time.

A tab's parts know each other in circles: its decoders, with their threads, would stay until Python happens to
look for such circles, and what they free the C library keeps.
"""

import ctypes
import gc
import sys
import threading
from contextlib import suppress

PAUSE_S = 1.0
"""Tabs that close together are tidied up after together."""
LATER_S = 5.0
"""And once more after this: threads of a closed tab may still have ended something."""
LARGE_BYTES = 1 << 18
"""Pieces of memory from this on go back to the system as soon as they are free, see `give_pictures_back`."""
_M_MMAP_THRESHOLD = -3
"""Of `mallopt`, in GNU's malloc.h."""


class Tidying:
    """A thread that cleans up after it was told."""

    def __init__(self) -> None:
        self._told, self._stop = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="tidy", daemon=True)
        self._thread.start()

    def give_pictures_back(self) -> None:
        """Have the memory of each picture go back to the system when it is free.

        By default GNU's C library soon keeps pieces as large as a picture among small ones, between which
        they cannot go back. It takes 2 ms of each frame where a drive is run, so not there.
        """
        _call("mallopt", _M_MMAP_THRESHOLD, LARGE_BYTES)

    def tell(self) -> None:
        """A tab has closed."""
        self._told.set()

    def stop(self) -> None:
        """End the thread."""
        self._stop.set()
        self._told.set()
        self._thread.join()

    def _run(self) -> None:
        while self._told.wait() and not self._stop.wait(PAUSE_S):
            self._told.clear()
            if self._stop.is_set():  # it was told of the end, after the pause
                return
            _tidy()
            if not self._told.wait(LATER_S):
                _tidy()


def _tidy() -> None:
    gc.collect()
    _call("malloc_trim", 0)


def _call(function: str, *arguments: int) -> None:
    """A function of GNU's C library; nothing with another one."""
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            getattr(ctypes.CDLL(None), function)(*arguments)
