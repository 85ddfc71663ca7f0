"""Batches drawn in a thread of their own, while a net learns from those before."""

import queue
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import numpy as np

B = TypeVar("B")


@contextmanager
def drawn_ahead(draw: Callable[[np.random.Generator], B], steps: int, seed: int) -> Iterator[Iterator[B]]:
    """So many batches; the same for the same seed. What drawing raises is raised where they are taken."""
    ready: queue.Queue[B | BaseException] = queue.Queue(4)
    stop = threading.Event()

    def work() -> None:
        random = np.random.default_rng(seed)
        try:
            for _ in range(steps):
                batch = draw(random)
                while not stop.is_set():
                    try:
                        ready.put(batch, timeout=0.2)
                        break
                    except queue.Full:
                        continue
                if stop.is_set():
                    return
        except BaseException as error:
            ready.put(error)

    def taken() -> Iterator[B]:
        for _ in range(steps):
            item = ready.get()
            if isinstance(item, BaseException):
                raise item
            yield item

    thread = threading.Thread(target=work, name="draw batches", daemon=True)
    thread.start()
    try:
        yield taken()
    finally:
        stop.set()
        thread.join()
