"""What benchmarks print: lines, rows of Markdown tables, and how often something takes how long."""

import statistics
import sys
from collections.abc import Sequence
from datetime import date

from fcw.versions import machine, versions


def say(text: str) -> None:
    """A line on stdout, at once."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def say_row(cells: Sequence[object], head: bool = False) -> None:
    """A row of a table; a head has a rule below it."""
    say("| " + " | ".join(map(str, cells)) + " |")
    if head:
        say("|" + " --- |" * len(cells))


def where_and_with_what() -> str:
    """Date, machine, and the versions of the libraries."""
    libraries = ", ".join(f"{name} {number}" for name, number in versions().items())
    return f"{date.today()}, {machine()}; {libraries}"


def median_and_p95(times_ms: Sequence[float]) -> str:
    """Median and 95th percentile in words."""
    p95_ms = statistics.quantiles(times_ms, n=20)[-1]
    return f"median {statistics.median(times_ms):.0f} ms, p95 {p95_ms:.0f} ms"
