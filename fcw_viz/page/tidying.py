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


class Tidying:
    """A thread that cleans up after it was told."""

    def __init__(self) -> None:
        self._told, self._stop = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="tidy", daemon=True)
        self._thread.start()

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
            gc.collect()
            if sys.platform == "linux":
                with suppress(OSError, AttributeError):  # another C library than GNU's
                    ctypes.CDLL(None).malloc_trim(0)
