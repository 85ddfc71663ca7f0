"""What a run told people of its drive, as its summary keeps it beside the log."""

from pathlib import Path

from fcw.bounded.files import read_text
from fcw.bounded.formats import json_value
from fcw.logs.names import MCAP_NAME, SUMMARY_NAME


def notes_of_run(log: Path) -> tuple[str, ...]:
    """The notes of the run that wrote a log; empty where its summary is missing, torn or another file's.

    Args:
        log: the log's file.
    """
    if log.name != MCAP_NAME:
        return ()
    try:
        notes = json_value(read_text(log.with_name(SUMMARY_NAME)))["notes"]
    except (OSError, ValueError, TypeError, KeyError):
        return ()
    return tuple(note for note in notes if isinstance(note, str)) if isinstance(notes, list) else ()
