"""How commands and jobs speak: results on standard output, all else on standard error.

Whoever shall not be heard is given `SILENT`. Errors are `fcw.errors.UserError`: the command line says them.
"""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskID,
    TaskProgressColumn,
    TimeRemainingColumn,
)
from rich.table import Column
from rich.text import Text

from fcw.json_form import without_non_finite
from fcw_viz.console_text import one_line

WIDTH = None if sys.stdout.isatty() else 10_000
"""In characters. What a file or a pipe takes is not wrapped: a line is a sentence, or a row of a table."""
RESULTS = Console(highlight=False, markup=False, emoji=False, width=WIDTH)
MESSAGES = Console(stderr=True, highlight=False, soft_wrap=True, markup=False, emoji=False)
"""Names of files and drives may hold brackets and colons: no console takes a text for markup."""
SILENT = Console(quiet=True)
BAR_WIDTH = 20
"""In characters: beside it there is room for words in a terminal of 80."""


def print_json(value: Any) -> None:  # noqa: ANN401 - JSON has no type
    """Print a result for scripts, alone on standard output; what is not finite is null."""
    sys.stdout.write(json.dumps(without_non_finite(value), indent=2, allow_nan=False) + "\n")
    sys.stdout.flush()


def note(text: str, console: Console = MESSAGES) -> None:
    """Say what a person should know of a result that is there all the same."""
    console.print(f"note: {one_line(text)}", markup=False)


class Bar:
    """How far a piece of work is; `advance` may be handed to whoever does it."""

    def __init__(self, progress: Progress, task: TaskID) -> None:
        """Draws a task."""
        self._progress, self._task = progress, task

    def advance(self, done: float = 1) -> None:
        """So much more is done."""
        self._progress.advance(self._task, done)

    def reach(self, done: float) -> None:
        """So much of the total is done."""
        self._progress.update(self._task, completed=done)

    def begin(self, name: str, steps: float | None) -> None:
        """Other work, from its start."""
        self._progress.reset(self._task, description=one_line(name), total=steps)


@contextmanager
def progress(text: str, total: float | None, console: Console = MESSAGES, rate_of: str = "") -> Iterator[Bar]:
    """A bar as long as the work lasts, where the console is a terminal; one line, however long its text is.

    Args:
        text: what is done.
        total: how much of it; None: not known.
        console: where to draw.
        rate_of: what is counted a second, e.g. "frames"; empty: no rate.
    """
    whole = Column(no_wrap=True)
    columns = (_Name(), BarColumn(BAR_WIDTH), _Done(rate_of), TimeRemainingColumn(table_column=whole))
    hidden = console.quiet or not console.is_terminal
    with Progress(*columns, console=console, disable=hidden, transient=True) as shown:
        yield Bar(shown, shown.add_task(one_line(text), total=total))


class _Name(ProgressColumn):
    """What is done; shortened where the terminal is too narrow, and never a second line."""

    def render(self, task: Task) -> Text:
        return Text(task.description, no_wrap=True, overflow="ellipsis")


class _Done(ProgressColumn):
    """Steps of how many, or a percentage of what does not come in steps; and how many a second."""

    def __init__(self, rate_of: str) -> None:
        super().__init__(Column(no_wrap=True))
        self._rate_of, self._steps, self._part = rate_of, MofNCompleteColumn(), TaskProgressColumn()

    def render(self, task: Task) -> Text:
        done = (self._part if isinstance(task.total, float) else self._steps).render(task)
        if self._rate_of and task.elapsed:
            done.append(f" {task.completed / task.elapsed:.0f} {self._rate_of}/s")
        return done
