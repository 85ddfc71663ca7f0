"""The other lists of a folder: its moments across all drives, and the drives that a batch has not done."""

import base64
from collections.abc import Sequence
from html import escape

from fcw.batch.ledger import Record
from fcw.batch.moments import moment_name, read_moment
from fcw_viz.page.channel import is_item, says
from fcw_viz.review_app.drive import time_text, utc_text
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.time.timeline import kind_color
from fcw_viz.review_app.words import event_line, kind_title, verdict_sign, verdict_words


def moments_html(moments: Sequence[tuple[DriveCard, int]]) -> str:
    """A row for each moment; a click on it is `open:<its drive>#<event>`.

    Args:
        moments: drives with the numbers of their events, in the order of the list.
    """
    return "".join(_moment(card, number) for card, number in moments)


def unfinished_html(records: Sequence[Record]) -> str:
    """A row for each drive that a batch has not done, with the reason and what to do."""
    return "".join(
        f'<div class="fcw-row still calm" {is_item(record.name, False)}><div class="fcw-thumb">!</div>'
        f"<div><header><b>{escape(record.name)}</b><span>{escape(record.camera)}</span>"
        f"<span>{escape(record.state.value)}</span></header>"
        f'<p class="fcw-told">{escape(record.reason)}</p></div></div>'
        for record in records
    )


def event_words(card: DriveCard, number: int, attributes: str = "") -> str:
    """An event in a line: its kind, when it was, its figures and what all who judged it say.

    Args:
        card: of its drive.
        number: of the event.
        attributes: of the line's element.
    """
    event, judged = card.events[number], card.judged[number]
    words = escape("; ".join(map(verdict_words, judged.verdicts)))
    said = f"<span>{verdict_sign(judged)} {words}</span>" if words else ""
    return (
        f'<div class="fcw-worst" {attributes} style="--kind: {kind_color(event.kind)}"><i></i><b>'
        f"{escape(kind_title(event.kind))} at {time_text(event.start_s)}</b>"
        f"<span>{escape(event_line(event, card.imperial))}</span>{said}</div>"
    )


def thumbnail_style(jpeg: str) -> str:
    """The attribute of an element that shows a JPEG, in base 64; empty without one."""
    return f' style="background-image: url(data:image/jpeg;base64,{jpeg})"' if jpeg else ""


def _moment(card: DriveCard, number: int) -> str:
    event = card.events[number]
    picture = base64.b64encode(read_moment(card.path.parent, moment_name(event))).decode()
    if not picture and event.severity == card.severity:
        picture = card.thumbnail
    when = ""
    if card.begun_utc_ns is not None:
        when = utc_text(card.begun_utc_ns + round(event.start_s * 1e9), True)
    place = f"{card.name}#{number}"
    return (
        f'<div class="fcw-row calm" {is_item(place)} {says(f"open:{place}")}>'
        f'<div class="fcw-thumb"{thumbnail_style(picture)}></div>'
        f"<div><header><b>{escape(card.name)}</b><span>{escape(card.camera)}</span><span>{when}</span></header>"
        f"{event_words(card, number)}</div></div>"
    )
