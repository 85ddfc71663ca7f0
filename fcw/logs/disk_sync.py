"""A growing file on its disk, not only in the operating system's memory."""

import os
import time
from concurrent.futures import Future, ThreadPoolExecutor
from io import BufferedWriter
from types import TracebackType

DISK_SYNC_INTERVAL_S = 1.0
"""Left alone, Linux keeps written data in memory for half a minute, and a power cut takes it."""


class DiskSync:
    """Has a growing file brought to its disk about once a second, aside, so that no writer waits for it.

    As a context it brings all to the disk at its end.
    """

    def __init__(self, file: BufferedWriter) -> None:
        """Nothing happens before the first `sync`."""
        self._file = file
        self._thread = ThreadPoolExecutor(1, "sync")
        self._syncing: Future[None] | None = None
        self._started_s = time.monotonic()

    def sync(self) -> None:
        """Start to bring what was flushed to the disk, if the last time was a second ago.

        Raises:
            OSError: the disk did not take what was written before.
        """
        if time.monotonic() - self._started_s < DISK_SYNC_INTERVAL_S:
            return
        if self._syncing is not None:
            if not self._syncing.done():
                return
            self._syncing.result()
        self._started_s = time.monotonic()
        self._syncing = self._thread.submit(os.fsync, self._file.fileno())

    def __enter__(self) -> "DiskSync":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._thread.shutdown()
        if error is None:
            if self._syncing is not None:
                self._syncing.result()
            self._file.flush()
            os.fsync(self._file.fileno())
