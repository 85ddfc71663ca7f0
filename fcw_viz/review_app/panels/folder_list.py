"""The list of a folder's drives with their events, the worst first."""

from collections.abc import Sequence
from html import escape

from fcw_viz.page.channel import says
from fcw_viz.review_app.drive import by_severity, duration_text, time_text
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.panels.troubles import troubles_html
from fcw_viz.review_app.time.axis import TimeAxis
from fcw_viz.review_app.time.timeline import (
    HEIGHT_PX,
    LABELLED_COLOR,
    MISSED_COLOR,
    NOTE_COLOR,
    TOUCHED_COLOR,
    kind_color,
    timeline_svg,
)
from fcw_viz.review_app.triage.drive_filter import DriveFilter
from fcw_viz.review_app.words import (
    DISAGREEMENT,
    DISAGREEMENT_SIGN,
    JUDGEMENT_SIGNS,
    KIND_MEANINGS,
    KIND_TITLES,
    event_line,
    kind_title,
    verdict_counts,
    verdict_words,
)

BESIDE_PX, AROUND_PX = 302.0, 86.0
"""Of the list's width what is not the time line: margins and the picture; in a narrow one only margins."""
NARROW_PX = 672.0
"""A list of less stands in one column, as review_page.css has it."""


MOST_LISTED = 30
"""Drives that are drawn at once; of more the first ones, for a list of hundreds takes a browser seconds."""


def folder_html(
    title: str,
    cards: Sequence[DriveCard],
    unread: int,
    width_px: float,
    asked: DriveFilter | None = None,
    most: int = MOST_LISTED,
) -> str:
    """The list; a click on a drive or on one of its marks is `open:<its name>` or `open:<its name>#<event>`.

    Args:
        title: of the folder.
        cards: all drives.
        unread: how many have still to be read.
        width_px: of the page's place for it.
        asked: which of them are listed, and in which order; by default all, the worst first.
        most: so many are listed; `more:` asks for the others.
    """
    axis_px = width_px - (AROUND_PX if width_px < NARROW_PX else BESIDE_PX)
    asked = asked or DriveFilter()
    listed = asked.drives(cards)
    rows = "".join(_row(card, axis_px, asked) for card in listed[:most])
    if len(listed) > most:
        rows += f"<button {says('more:')}>{len(listed) - most} more drives</button>"
    found = f"<p>{len(listed)} match the filter.</p>" if len(listed) < len(cards) else ""
    return f"<h1>{escape(title)}</h1><p>{escape(_summary(cards, unread))}</p>{found}{rows}"


def legend_html() -> str:
    """What the marks of the time lines mean."""
    kinds = "".join(
        f'<p class="fcw-title" style="--kind: {kind_color(kind)}"><i></i><b>{title}</b>'
        f'<span class="fcw-meaning">{KIND_MEANINGS[kind]}</span></p>'
        for kind, title in KIND_TITLES.items()
    )
    meanings = {sign: judgement.value for judgement, sign in JUDGEMENT_SIGNS.items()}
    meanings[DISAGREEMENT_SIGN] = DISAGREEMENT
    meanings[f'<i class="missed" style="--kind: {MISSED_COLOR}"></i>'] = "a missed warning, added by a person"
    for color, meaning in (
        (LABELLED_COLOR, "frames whose boxes are confirmed"),
        (TOUCHED_COLOR, "frames with corrected boxes"),
    ):
        meanings[f'<i class="labelled" style="--kind: {color}"></i>'] = meaning
    meanings[f'<i class="note" style="--kind: {NOTE_COLOR}"></i>'] = "a note"
    signs = "".join(
        f"<tr><td>{sign}</td><td style='text-align:left'>{meaning}</td></tr>"
        for sign, meaning in meanings.items()
    )
    return (
        f'<div class="fcw-legend">{kinds}<p>The sign above a mark is its verdict. Other marks:</p>'
        f"<table>{signs}</table></div>"
    )


def _summary(cards: Sequence[DriveCard], unread: int) -> str:
    hours = sum(card.duration_s for card in cards) / 3600
    warnings = [judged for card in cards for judged in card.judged if judged.event.kind == "warning"]
    count = len(cards)
    parts = [
        f"{count} drive{'s' * (count != 1)}",
        duration_text(hours * 3600),
        f"{len(warnings)} warning{'s' * (len(warnings) != 1)}",
    ]
    counts = verdict_counts(warnings)
    if counts:
        parts.append(counts)
    if unread:
        parts.append(f"reading {unread} more")
    return " · ".join(parts) + ". Click a drive to open it at its worst moment."


def _row(card: DriveCard, axis_px: float, asked: DriveFilter) -> str:
    if card.trouble:
        return (
            f'<div class="fcw-row still"><div class="fcw-thumb">?</div><header><b>{escape(card.name)}</b>'
            f"</header><div>{escape(card.trouble)}</div></div>"
        )
    if not card.read:
        return (
            f'<div class="fcw-row" {says(f"open:{card.name}")}><div class="fcw-thumb">…</div>'
            f"<div><header><b>{escape(card.name)}</b><span>not read yet</span></header></div></div>"
        )
    judged = card.judged
    axis = TimeAxis(0.0, max(card.duration_s, 0.04), axis_px)
    counts = _counts(card)
    worst, thumbnail, number = "", "", 0
    if card.thumbnail:
        thumbnail = f' style="background-image: url(data:image/jpeg;base64,{card.thumbnail})"'
    if card.events:
        number = next(iter(asked.numbers(card)), by_severity(card.events)[0])
        event = card.events[number]
        said = "".join(
            f"<span>{JUDGEMENT_SIGNS[entry.said.judgement]} {escape(verdict_words(entry))}</span>"
            for entry in judged[number].verdicts[:1]
        )
        worst = (
            f'<div class="fcw-worst" style="--kind: {kind_color(event.kind)}"><i></i><b>'
            f"{kind_title(event.kind)} at {time_text(event.start_s)}</b>"
            f"<span>{escape(event_line(event, card.imperial))}</span>{said}</div>"
        )
    else:
        worst = '<div class="fcw-worst"><span>No events.</span></div>'
    opens = f"open:{card.name}" if not card.events else f"open:{card.name}#{number}"
    calm = not (card.events or card.review.entries)
    # A mark of the time line opens the drive there: its message names the drive, too.
    svg = timeline_svg(axis, judged, card.review, None, None, card.imperial, f"open:{card.name}#")
    troubles = troubles_html(card.review_troubles, 1) if card.review_troubles else ""
    notice = "" if card.complete else "<span>not finished; shown up to its last frame</span>"
    return (
        f'<div class="fcw-row {"calm" if calm else ""}" data-drive="{escape(card.name)}" '
        f"{says(opens)}>"
        f'<div class="fcw-thumb"{thumbnail}></div>'
        f"<div><header><b>{escape(card.name)}</b>{notice}<span>{escape(counts)}</span>"
        f"<span>{duration_text(card.duration_s)}</span></header>{worst}"
        f'<div class="fcw-whole" style="height:{HEIGHT_PX:.0f}px">{svg}</div>{troubles}</div></div>'
    )


def _counts(card: DriveCard) -> str:
    """How many of each kind, the more urgent first."""
    kinds = list(dict.fromkeys(card.events[number].kind for number in by_severity(card.events)))
    numbers = {kind: sum(event.kind == kind for event in card.events) for kind in kinds}
    return ", ".join(f"{numbers[kind]} × {kind_title(kind).lower()}" for kind in kinds)
