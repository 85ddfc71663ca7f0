"""The list of a folder's drives with their events, the worst first."""

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from pathlib import PurePath

from fcw.batch.ledger import Record
from fcw.logs.events import seen_s
from fcw_viz.page.channel import is_item, says
from fcw_viz.review_app.drive import by_severity, duration_text
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.panels.moment_list import (
    event_words,
    moments_html,
    thumbnail_style,
    unfinished_html,
)
from fcw_viz.review_app.panels.troubles import troubles_html
from fcw_viz.review_app.place import place_text
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
from fcw_viz.review_app.triage.drive_filter import DriveFilter, Listed
from fcw_viz.review_app.words import (
    DISAGREEMENT,
    DISAGREEMENT_SIGN,
    JUDGEMENT_SIGNS,
    KIND_MEANINGS,
    KIND_TITLES,
    kind_title,
    verdict_counts,
)

BESIDE_PX, AROUND_PX = 302.0, 86.0
"""Of the list's width what is not the time line: margins and the picture; in a narrow one only margins."""
NARROW_PX = 672.0
"""A list of less stands in one column, as review_page.css has it."""


MOST_LISTED = 30
"""Rows that are drawn at once; of more the first ones, for a list of hundreds takes a browser seconds."""
MORE_LISTED = 200
"""Rows that are drawn when more are asked for."""


_HINTS = {
    Listed.DRIVES: "Click a drive to open it at its worst moment.",
    Listed.MOMENTS: "Click a moment to open its drive there.",
    Listed.UNFINISHED: "Drives that the batch has not done, and why.",
}


def folder_html(
    title: str,
    cards: Sequence[DriveCard],
    unread: int,
    width_px: float,
    asked: DriveFilter | None = None,
    most: int = MOST_LISTED,
    unfinished: Sequence[Record] = (),
) -> str:
    """The list; a click on a drive or on one of its marks is `open:<its name>#` or `open:<its name>#<event>`.

    Args:
        title: of the folder.
        cards: all drives.
        unread: how many have still to be read.
        width_px: of the page's place for it.
        asked: which of them are listed, and in which order; by default all, the worst first. Or it asks for
            their moments, or for the drives that are not done.
        most: how many are listed; `more:` asks for the others.
        unfinished: drives that a batch has not done; listed at once where there are no others.
    """
    asked = asked or DriveFilter()
    if unfinished and not cards:
        asked = replace(asked, listed=Listed.UNFINISHED)  # there is nothing else to look at
    if asked.listed is Listed.MOMENTS:
        moments, what = asked.moments(cards), "moments"
        count, of = len(moments), sum(len(card.events) for card in cards)
        rows = moments_html(moments[:most])
    elif asked.listed is Listed.UNFINISHED:
        records, what = asked.unfinished(unfinished), "drives"
        count, of = len(records), len(unfinished)
        rows = unfinished_html(records[:most])
    else:
        axis_px = width_px - (AROUND_PX if width_px < NARROW_PX else BESIDE_PX)
        drives, what = asked.drives(cards), "drives"
        count, of = len(drives), len(cards)
        alike = _alike_files(cards)
        rows = "".join(_row(card, axis_px, asked, card.file in alike) for card in drives[:most])
    if count > most:
        left = count - most
        words = f"{left} more {what}" if left <= MORE_LISTED else f"{MORE_LISTED} of {left} more {what}"
        rows += f"<button {says('more:')}>{words}</button>"
    found = f"<p>{count} match{'es' * (count == 1)} the filter.</p>" if count < of else ""
    failed = ""
    if unfinished and asked.listed is not Listed.UNFINISHED:
        words = f"{len(unfinished)} drive{'s' * (len(unfinished) != 1)} not done"
        failed = f" <button {says(f'listed:{Listed.UNFINISHED.name}')}>{words}</button>"
    return (
        f"<h1>{escape(title)}</h1><p>{escape(_summary(cards, unread, asked.listed))}{failed}</p>{found}{rows}"
    )


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
        f'<div class="fcw-legend">{kinds}<p>Signs above an event show its verdict. Other marks:</p>'
        f"<table>{signs}</table></div>"
    )


def _summary(cards: Sequence[DriveCard], unread: int, listed: Listed) -> str:
    time_s = sum(seen_s(card.duration_s, card.events) for card in cards)
    warnings = [judged for card in cards for judged in card.judged if judged.event.kind == "warning"]
    count = len(cards)
    parts = [
        f"{count} drive{'s' * (count != 1)}",
        duration_text(time_s),
        f"{len(warnings)} warning{'s' * (len(warnings) != 1)}",
    ]
    counts = verdict_counts(warnings)
    if counts:
        parts.append(counts)
    if unread:
        parts.append(f"reading {unread} more")
    return f"{' · '.join(parts)}. {_HINTS[listed]}"


def _alike_files(cards: Sequence[DriveCard]) -> set[str]:
    """Files of a batch that only their folders tell apart: the cameras' folders, or those above them."""
    named: defaultdict[str, set[str]] = defaultdict(set)
    for card in cards:
        if card.file:
            named[PurePath(card.file).name].add(card.file)
    return {file for files in named.values() if len(files) > 1 for file in files}


def _row(card: DriveCard, axis_px: float, asked: DriveFilter, shows_file: bool) -> str:
    if card.trouble:
        return (
            f'<div class="fcw-row still" {is_item(card.name, False)}><div class="fcw-thumb">?</div>'
            f"<div><header><b>{escape(card.name)}</b></header>"
            f'<p class="fcw-told">{escape(card.trouble)}</p></div></div>'
        )
    if not card.read:
        return (
            f'<div class="fcw-row" {is_item(card.name)} {says(f"open:{place_text(card.name)}")}>'
            f'<div class="fcw-thumb">…</div>'
            f"<div><header><b>{escape(card.name)}</b><span>not read yet</span></header></div></div>"
        )
    judged = card.judged
    axis = TimeAxis(0.0, max(card.duration_s, 0.04), axis_px)
    counts = _counts(card)
    worst, number = '<div class="fcw-worst"><span>No events.</span></div>', None
    if card.events:
        ranked = asked.numbers(card) or by_severity(card.events)
        number = ranked[0]
        worst = event_words(card, number)
        warned = next((one for one in ranked if card.events[one].kind == "warning"), number)
        if warned != number:  # a caution may be more severe than what the driver was warned of
            worst += event_words(card, warned, says(f"open:{place_text(card.name, warned)}"))
    opens = f"open:{place_text(card.name, number)}"
    calm = not (card.events or card.review.entries)
    # A mark of the time line opens the drive there: its message names the drive, too.
    svg = timeline_svg(axis, judged, card.review, None, None, card.imperial, f"open:{card.name}#")
    troubles = troubles_html(card.review_troubles, 1) if card.review_troubles else ""
    told = (card.file, *card.notes) if shows_file else card.notes
    notes = "".join(f'<p class="fcw-told">{escape(one)}</p>' for one in told)
    camera = f"<span>{escape(card.camera)}</span>" if card.camera else ""
    notice = "" if card.complete else "<span>not finished; shown up to its last frame</span>"
    return (
        f'<div class="fcw-row {"calm" if calm else ""}" data-drive="{escape(card.name)}" '
        f"{is_item(card.name)} {says(opens)}>"
        f'<div class="fcw-thumb"{thumbnail_style(card.thumbnail)}></div>'
        f"<div><header><b>{escape(card.name)}</b>{camera}{notice}<span>{escape(counts)}</span>"
        f"<span>{duration_text(card.duration_s)}</span></header>{worst}"
        f'<div class="fcw-whole" style="height:{HEIGHT_PX:.0f}px">{svg}</div>{notes}{troubles}</div></div>'
    )


def _counts(card: DriveCard) -> str:
    """How many of each kind, the more urgent first."""
    numbers = Counter[str](event.kind for event in card.events)
    kinds = dict.fromkeys((*KIND_TITLES, *numbers))
    return ", ".join(f"{numbers[kind]} × {kind_title(kind).lower()}" for kind in kinds if numbers[kind])
