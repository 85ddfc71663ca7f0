"""The part of `fcw evaluate warning` that compares a log with labelled events, or with people's verdicts."""

from dataclasses import asdict
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from fcw.errors import UserError
from fcw_viz.console_text import counted

if TYPE_CHECKING:
    from rich.console import Console

    from fcw.evaluation.warning.events import Event, EventComparison

MOST_LISTED = 20
"""Of missed events, and of false alarms."""


def evaluate_events(log_path: Path, labels: Path | None, console: "Console") -> dict[str, Any]:
    """Compare a log with labels, and print the comparison.

    Args:
        log_path: the drive.mcap, or its folder.
        labels: a file of labelled events, or a reviewed drive; None for the log's own review.
        console: where to print.

    Returns:
        The keys for the JSON result.

    Raises:
        UserError: a log or the labels cannot be read, or nobody has judged a warning of the reviewed drive.
    """
    from fcw.evaluation.warning.events import compare_with_events, read_events
    from fcw.logs.mcap.reader import read_drive
    from fcw.logs.names import mcap_path

    log = read_drive(log_path)
    labels = labels or log_path
    reviewed = labels.is_dir() or labels.suffix.lower() == ".mcap"
    events, judged = _verdicts(mcap_path(labels)) if reviewed else (read_events(labels), {})
    comparison = compare_with_events(log.results(), events, complete=not reviewed)
    print_events(comparison, console)
    return {
        "hits": len(comparison.hits),
        "missed": len(comparison.missed),
        "false_alarms": len(comparison.false_alarms),
        "missed_events": [asdict(event) for event in comparison.missed],
        "false_alarm_spans": [asdict(run) for run in comparison.false_alarms],
        "unjudged_spans": [asdict(run) for run in comparison.unjudged],
    } | judged


def _verdicts(path: Path) -> "tuple[tuple[Event, ...], dict[str, Any]]":
    """The labels that people's verdicts on a drive give, and what else there is to tell of them."""
    from fcw.annotation.records import Judgement
    from fcw.annotation.store import read_review
    from fcw.annotation.warning_labels import warning_labels
    from fcw.logs.events import find_events
    from fcw.logs.mcap.reader import DriveLog
    from fcw_viz.console import note

    log = DriveLog(path)
    review, troubles = read_review(log)
    labels = warning_labels(review, find_events(log.series()))
    if not labels.events:
        raise UserError(
            f"{path}: no warning of this drive has a verdict yet; judge them with "
            f"`fcw review {quote(str(path))}`, or give labelled events with --events FILE"
        )
    for trouble in troubles:
        note(trouble)
    if labels.disagreements:
        count = len(labels.disagreements)
        note(f"people disagree about {count} warning{'s' * (count != 1)}: not used as a label")
    if labels.lost:
        note(f"{counted(labels.lost, 'verdict')} on warnings that are not in the log any more")
    return labels.events, {
        "judgements": {one.name.lower(): labels.judgements.get(one, 0) for one in Judgement},
        "disagreements": len(labels.disagreements),
        "lost_verdicts": labels.lost,
    }


def print_events(comparison: "EventComparison", console: "Console") -> None:
    """Print how a log compares with its labels."""
    console.print(
        f"{counted(len(comparison.hits), 'event')} warned of, {len(comparison.missed)} missed, "
        f"{counted(len(comparison.false_alarms), 'false alarm')}"
        + (f", {len(comparison.unjudged)} unjudged" if comparison.unjudged else ""),
        highlight=False,
    )
    missed = [(event.level, event.start_s, event.end_s) for event in comparison.missed]
    false_alarms = [(run.highest, run.start_s, run.end_s) for run in comparison.false_alarms]
    for what, stretches in (("missed", missed), ("false alarm", false_alarms)):
        for level, start_s, end_s in stretches[:MOST_LISTED]:
            console.print(f"  {what}: {level.name.lower()} {start_s:.2f} s to {end_s:.2f} s", highlight=False)
        if len(stretches) > MOST_LISTED:
            console.print(
                f"  {what}: and {len(stretches) - MOST_LISTED} more; --json lists all", highlight=False
            )
