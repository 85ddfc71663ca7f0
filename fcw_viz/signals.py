"""Ctrl-C, `kill` and a terminal that closes are the same to every command: it ends."""

import atexit
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals that ask a program to end; Windows has no SIGHUP."""


class Interrupted(KeyboardInterrupt):
    """Raised in the place of KeyboardInterrupt itself.

    CPython notes when that one leaves code that was run from a text (dataclasses do so while modules load),
    and then ends the process by SIGINT, whatever the exit code is.
    """


@contextmanager
def signals_as_interrupts() -> Iterator[None]:
    """Each of them raises KeyboardInterrupt, for as long as the context; in other threads nothing changes."""

    def on_signal(_number: int, _stack: FrameType | None) -> None:
        raise Interrupted

    with handled(on_signal):
        yield


def keep_exit_code(code: int) -> None:
    """The work is done and Python cleans up for a moment: a signal ends that with the same exit code.

    At the very end Python gives back the signals that it handles to the system, which would end the process
    by them; those that are ignored it leaves so.
    """
    numbers = [number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN]
    for number in numbers:
        signal.signal(number, lambda _number, _stack: os._exit(code))

    def ignore() -> None:
        for number in numbers:
            signal.signal(number, signal.SIG_IGN)

    # Threads have been waited for by then. What was registered before is called later, in no time.
    atexit.register(ignore)


@contextmanager
def handled(handler: "signal._HANDLER") -> Iterator[None]:
    """Have them handled; a SIGHUP that `nohup` has us ignore stays ignored."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = [
        number
        for number in ENDING
        if number == signal.SIGINT or signal.getsignal(number) is not signal.SIG_IGN
    ]
    before = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)
