"""What is wrong with the files of a drive's review, in words."""

from collections.abc import Sequence
from html import escape

MOST_TOLD = 4
"""Of the troubles of one drive; a file may have hundreds of damaged lines."""


def troubles_html(troubles: Sequence[str], most: int = MOST_TOLD) -> str:
    """Each trouble in a line.

    Args:
        troubles: at least one.
        most: how many are told; of the others only their number is.
    """
    lines = "".join(f"<p>{escape(trouble)}</p>" for trouble in troubles[:most])
    if len(troubles) > most:
        lines += f"<p>and {len(troubles) - most} more</p>"
    return f'<div class="fcw-card fcw-troubles"><b>Problems in the review files</b>{lines}</div>'
