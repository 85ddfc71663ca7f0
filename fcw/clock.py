"""Real time, behind a seam for tests."""

import threading
import time


class Clock:
    """Real time, and waiting in it."""

    def now_s(self) -> float:
        """Seconds since some moment."""
        return time.monotonic()

    def wait_s(self, seconds: float, stop: threading.Event) -> None:
        """Wait, or until `stop` is set."""
        stop.wait(seconds)
