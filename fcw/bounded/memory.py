"""What the libraries of others may take while they open a file: a few bytes can ask them for all there is."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def at_most_more(most_bytes: int) -> Iterator[None]:
    """This process gets no more than so many bytes of addresses on top of what it has, on Linux.

    A library that wants more is refused it by the system, as where memory is at its end: what it then raises
    is its caller's to tell. Other threads are refused as well: this is for short work at the start.

    Args:
        most_bytes: beyond what the process has when the context begins.
    """
    if sys.platform != "linux":
        yield
        return
    import resource

    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
    before, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = pages * resource.getpagesize() + most_bytes
    if before == resource.RLIM_INFINITY or wanted < before:
        resource.setrlimit(resource.RLIMIT_AS, (wanted, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, hard))
