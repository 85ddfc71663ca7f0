"""Standard output and error whose reader may leave: `fcw run` before a `head` writes its whole log."""

import codecs
import io
import os
import sys
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


class _MayBeUnread(io.FileIO):
    """Where nobody reads it any more, what is written is gone; that is no error."""

    def write(self, data: "ReadableBuffer", /) -> int:
        try:
            return super().write(data)
        except BrokenPipeError:
            return memoryview(data).nbytes


def go_on_unread() -> None:
    """Have all work go on when whoever reads what is printed has read enough.

    Otherwise Python raises, and rich ends the program at once without a word. It holds for the whole process:
    commands, jobs and the libraries that print for us.
    """
    sys.stdout, sys.stderr = _may_be_unread(sys.stdout), _may_be_unread(sys.stderr)


def _may_be_unread(stream: TextIO | None) -> TextIO:
    if stream is None:  # closed from the start (`>&-`); its place is taken before a file of ours gets it
        return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123 - until the end of the process
    if not isinstance(stream, io.TextIOWrapper):
        return stream  # somebody listens from within Python
    stream.flush()
    raw = _MayBeUnread(stream.fileno(), "w", closefd=False)
    return io.TextIOWrapper(
        # Where Python shall keep nothing back (-u), nothing is kept back here.
        raw if stream.write_through else io.BufferedWriter(raw),
        stream.encoding,
        # Other code pages lack some of our characters: \xb1 in the place of one is better than no result.
        stream.errors if codecs.lookup(stream.encoding).name == "utf-8" else "backslashreplace",
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )
