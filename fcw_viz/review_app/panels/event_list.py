"""The list of a drive's events, and the words on the selected one."""

from collections.abc import Sequence
from html import escape

from fcw.annotation.records import REASONS, Judgement
from fcw.annotation.review import JudgedEvent
from fcw_viz.page.channel import chooses, keeps_scroll, says
from fcw_viz.review_app.drive import time_text
from fcw_viz.review_app.panels.remarks import run_html
from fcw_viz.review_app.place import list_order
from fcw_viz.review_app.time.timeline import kind_color
from fcw_viz.review_app.words import (
    JUDGEMENT_KEYS,
    JUDGEMENT_SIGNS,
    event_line,
    kind_title,
    verdict_counts,
    verdict_sign,
    verdict_words,
    when_words,
)


def list_html(
    name: str,
    events: Sequence[JudgedEvent],
    by_time: bool,
    selected: int | None,
    imperial: bool,
    told: Sequence[str] = (),
) -> str:
    """The list with its two orders; a click on an event is `event:<its number>`.

    Args:
        name: of the drive.
        events: in the order of their times.
        by_time: the order that is shown; `sort:time` and `sort:severity` ask for one.
        selected: number of the selected event.
        imperial: units of the words.
        told: by the run, of the drive; said where there are no events, and may be why.
    """
    if not events:
        return '<p class="dim">No events in this drive: no warning, no near miss.</p>' + run_html(told)
    orders = "".join(
        f'<button class="{"on" if chosen == by_time else ""}" {says(f"sort:{name}")}>{label}</button>'
        for name, label, chosen in (("severity", "worst first", False), ("time", "by time", True))
    )
    head = (
        f'<div class="fcw-list-head"><span>{len(events)} event{"s" * (len(events) != 1)}, '
        f'{verdict_counts(events) or "none judged"}</span><span class="fcw-choice">{orders}</span></div>'
    )
    order = list_order(events, by_time)
    rows = "".join(_row(number, events[number], number == selected, imperial) for number in order)
    more = len(events) - len(order)
    tail = f'<p class="dim">and {more} less severe ones on the timeline</p>' if more else ""
    return f'{head}<div class="fcw-events" {keeps_scroll(name)}>{rows}{tail}</div>'


def _row(number: int, judged: JudgedEvent, selected: bool, imperial: bool) -> str:
    event = judged.event
    title = "; ".join(map(verdict_words, judged.verdicts))
    kind = "wrong" if judged.judgement is Judgement.FALSE else ""
    return (
        f'<div class="fcw-event {"selected" if selected else ""}" data-event="{number}" '
        f'{says(f"event:{number}")} title="{escape(title)}" style="--kind: {kind_color(event.kind)}">'
        f'<i style="--part: {event.severity:.3f}" title="severity {event.severity:.0%}"></i>'
        f"<b>{kind_title(event.kind)}</b><time>{time_text(event.start_s)}</time>"
        f"<span>{escape(event_line(event, imperial))}</span>"
        f'<em class="{kind}">{verdict_sign(judged)}</em></div>'
    )


def verdict_html(judged: JudgedEvent, reviewer: str) -> str:
    """Buttons for a verdict (`verdict:<name>`), its reason (`reason:<name>`), and what others said."""
    own = next((entry for entry in judged.verdicts if entry.person == reviewer), None)
    buttons = "".join(
        f'<button class="{_own_class(own is not None and own.said.judgement is judgement)} {judgement.name}" '
        f"{says(f'verdict:{judgement.name}')}>{JUDGEMENT_SIGNS[judgement]} {judgement.value.capitalize()}"
        f"<kbd>{key}</kbd></button>"
        for judgement, key in JUDGEMENT_KEYS.items()
    )
    reasons = ""
    if own is not None and REASONS[own.said.judgement]:
        options = "".join(
            f'<option value="{reason.name}" {"selected" if own.said.reason is reason else ""}>'
            f"{escape(reason.value)}</option>"
            for reason in REASONS[own.said.judgement]
        )
        reasons = f'<select {chooses("reason")}><option value="">choose a reason</option>{options}</select>'
    said = "".join(
        f'<p class="fcw-said" title="{when_words(entry.time)}">{escape(verdict_words(entry))}</p>'
        for entry in judged.verdicts
        if entry.person != reviewer or entry.said.text
    )
    disagreement = (
        '<p class="fcw-disagree">You disagree with another reviewer.</p>'
        if judged.disagreement and own is not None
        else '<p class="fcw-disagree">Reviewers disagree.</p>'
        if judged.disagreement
        else ""
    )
    return f'<div class="fcw-verdicts">{buttons}</div>{reasons}{said}{disagreement}'


def _own_class(chosen: bool) -> str:
    return "on" if chosen else ""
