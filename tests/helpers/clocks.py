"""Clocks that no busy machine can disturb."""

import threading

from fcw.clock import Clock


class FakeClock(Clock):
    """Time passes by waiting, and not otherwise."""

    def __init__(self) -> None:
        self.time_s = 500.0
        self.waited_s: list[float] = []

    def now_s(self) -> float:
        return self.time_s

    def wait_s(self, seconds: float, stop: threading.Event) -> None:
        self.waited_s.append(seconds)
        self.time_s += seconds
