"""`fcw review FOLDER --summary`: what people's verdicts on the warnings of many drives come to."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rich.table import Column, Table

from fcw.annotation.records import Judgement
from fcw.annotation.summary import ReviewSummary, Tally, summarise
from fcw.logs.export.clip import find_drives
from fcw.warning.types import WarningLevel
from fcw_viz.console import RESULTS, note, print_json, progress
from fcw_viz.review_app.drive import duration_text

RATE_FROM_H = 5 / 60
"""A rate per hour of less driving is chance: one warning in six seconds would be 600."""
LEVELS = (WarningLevel.WARNING, WarningLevel.CAUTION, WarningLevel.ADVISORY)


def print_summary(path: Path, as_json: bool) -> None:
    """Print the summary of a drive, or of all drives below a folder, on stdout.

    Raises:
        UserError: there is no drive, or none that can be read.
    """
    drives = find_drives([path])
    with progress("drives", len(drives)) as bar:
        summary = summarise(drives, bar.advance)
    for text in (*summary.left_out, *(text for drive in summary.drives for text in drive.troubles)):
        note(text)
    if as_json:
        print_json(summary_as_json(summary))
        return
    for table in summary_tables(summary):
        if table.row_count:
            RESULTS.print(table, "")


def summary_as_json(summary: ReviewSummary) -> dict[str, Any]:
    """The summary with names that scripts can rely on."""
    return {
        "drives": [
            {
                "drive": drive.name,
                "path": str(drive.path),
                "people": drive.people,
                "lost_verdicts": drive.lost_verdicts,
                "troubles": drive.troubles,
                **_levels_as_json(drive.tallies),
            }
            for drive in summary.drives
        ],
        "all": _levels_as_json(summary.all),
        "left_out": summary.left_out,
    }


def _levels_as_json(tallies: Mapping[WarningLevel, Tally]) -> dict[str, Any]:
    return {level.name.lower(): _tally_as_json(tallies[level]) for level in LEVELS}


def _tally_as_json(tally: Tally) -> dict[str, Any]:
    low, high = tally.share_false_interval or (None, None)
    return {
        "hours": tally.hours,
        "warnings": tally.warnings,
        "per_hour": tally.per_hour,
        "judgements": {one.name.lower(): tally.judgements.get(one, 0) for one in Judgement},
        "disagreements": tally.disagreements,
        "unjudged": tally.unjudged,
        "missed": tally.missed,
        "share_false": tally.share_false,
        "share_false_low": low,
        "share_false_high": high,
        "reasons": [
            {"judgement": judgement.name.lower(), "reason": reason and reason.name.lower(), "warnings": count}
            for (judgement, reason), count in tally.reasons.items()
        ],
    }


def summary_tables(summary: ReviewSummary) -> Iterator[Table]:
    """How often and how falsely each drive warned, and, where somebody judged, what they judged and why."""
    parts = [(drive.name, drive.tallies) for drive in summary.drives]
    if len(parts) > 1:
        parts.append(("all", summary.all))
    rows = [
        (name, tallies[level], level.name.lower())
        for name, tallies in parts
        for level in LEVELS
        if tallies[level].warnings or tallies[level].missed or level is WarningLevel.WARNING
    ]
    rates = Table(
        Column("drive", overflow="fold"),
        "level",
        "driven",
        "shown",
        "per hour",
        "missed",
        "judged false",
        box=None,
    )
    for name, tally, level in rows:
        rates.add_row(
            name,
            level,
            duration_text(tally.hours * 3600),
            str(tally.warnings),
            "-" if tally.per_hour is None or tally.hours < RATE_FROM_H else f"{tally.per_hour:.1f}",
            str(tally.missed),
            _share(tally),
        )
    yield rates
    names = (one.value for one in Judgement)
    verdicts = Table(Column("drive", overflow="fold"), "level", *names, "disagreed", "unjudged", box=None)
    for name, tally, level in rows:
        if tally.judged or tally.disagreements:
            counts = (tally.judgements.get(one, 0) for one in Judgement)
            verdicts.add_row(name, level, *map(str, (*counts, tally.disagreements, tally.unjudged)))
    yield verdicts
    reasons = Table("level", "judged", "reason", "warnings", "of those judged", box=None)
    for level in LEVELS:
        tally = summary.all[level]
        for (judgement, reason), count in sorted(tally.reasons.items(), key=lambda item: -item[1]):
            reasons.add_row(
                level.name.lower(),
                judgement.value,
                "no reason given" if reason is None else reason.value,
                str(count),
                f"{count / tally.judged:.0%}",
            )
    yield reasons


def _share(tally: Tally) -> str:
    """As a percentage of those judged, with its 95 % interval."""
    if tally.share_false is None or tally.share_false_interval is None:
        return "-"
    low, high = tally.share_false_interval
    return f"{tally.share_false:.0%} of {tally.judged} ({100 * low:.0f}-{high:.0%})"
