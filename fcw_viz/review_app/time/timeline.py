"""The time line of a whole drive: every warning, near miss and move of the mount is a mark to click."""

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import NamedTuple

from fcw.annotation.records import Entry, MissedEvent, Note
from fcw.annotation.review import JudgedEvent, Review
from fcw.charts.svg import css_color, element, line, picture, words
from fcw.logs.overlay import LEVEL_COLORS
from fcw.warning.types import WarningLevel
from fcw_viz.page.channel import says
from fcw_viz.review_app.drive import Drive, time_text
from fcw_viz.review_app.time.axis import TimeAxis
from fcw_viz.review_app.words import (
    CUT,
    MOUNT_MOVED,
    NEAR_MISS,
    NOTHING_SEEN,
    POOR_SIGHT,
    event_line,
    kind_title,
    verdict_sign,
)

KIND_COLORS = {
    "warning": css_color(LEVEL_COLORS[WarningLevel.WARNING]),
    "caution": css_color(LEVEL_COLORS[WarningLevel.CAUTION]),
    "advisory": css_color(LEVEL_COLORS[WarningLevel.ADVISORY]),
    NEAR_MISS: "rgb(214, 51, 132)",
    MOUNT_MOVED: "rgb(134, 92, 214)",
    NOTHING_SEEN: "rgb(121, 85, 72)",
    CUT: "rgb(120, 124, 128)",
    POOR_SIGHT: "rgb(176, 160, 120)",
}
OTHER_COLOR = "rgb(134, 142, 150)"
MISSED_COLOR = "rgb(230, 73, 128)"
NOTE_COLOR = "rgb(250, 176, 5)"
LABELLED_COLOR, TOUCHED_COLOR = "rgb(43, 138, 62)", "rgb(130, 201, 30)"
"""Of frames whose boxes are all said to be right, and of those in which some were corrected."""
LABELLED_PX = 4.0
KIND_HEIGHTS = {"warning": 1.0, "caution": 0.72, "advisory": 0.45, POOR_SIGHT: 0.25}
"""Of the track's height: how urgent it is reads without colours."""

SIGNS_PX, TRACK_PX, TICKS_PX = 13.0, 18.0, 13.0
"""From top to bottom: what people said, the marks, the words of the axis."""
HEIGHT_PX = SIGNS_PX + TRACK_PX + TICKS_PX
SMALLEST_MARK_PX = 3.0
REACH_PX = 4.0
"""How far beside a mark a click still means it."""
APART_PX = 2.0
"""Of marks closer together only the worse one is drawn."""


class LabelledSpan(NamedTuple):
    """Frames in a row in which people labelled boxes.

    Attributes:
        start_s: the first one.
        end_s: the last one.
        confirmed: whether somebody said of all of them that every box is right.
    """

    start_s: float
    end_s: float
    confirmed: bool


def labelled_spans(drive: Drive, review: Review) -> list[LabelledSpan]:
    """Where people labelled boxes of a drive."""
    known = set(drive.series.frame_index.tolist())
    spans: list[tuple[int, int, bool]] = []
    for index, frame in review.frames.items():
        if index not in known:
            continue
        row, confirmed = drive.series.row_of(index), bool(frame.confirmed)
        if spans and spans[-1][1] == row - 1 and spans[-1][2] == confirmed:
            spans[-1] = spans[-1][0], row, confirmed
        else:
            spans.append((row, row, confirmed))
    return [LabelledSpan(drive.time_s(first), drive.time_s(last), said) for first, last, said in spans]


def kind_color(kind: str) -> str:
    """The colour of a kind of events."""
    return KIND_COLORS.get(kind, OTHER_COLOR)


def timeline_svg(
    axis: TimeAxis,
    events: Sequence[JudgedEvent],
    review: Review,
    shown: tuple[float, float] | None,
    selected: int | None,
    imperial: bool,
    message: str = "event:",
    labelled: Sequence[LabelledSpan] = (),
) -> str:
    """The marks over the whole drive.

    Args:
        axis: the drive from its first frame to its last.
        events: in the order of their times.
        review: whose missed events and notes are shown, too.
        shown: start and end of the range that the plots show; None where there are none.
        selected: number of the selected event.
        imperial: units of the words.
        message: before an event's number, what a click on it says.
        labelled: where people labelled boxes.
    """
    bottom = SIGNS_PX + TRACK_PX
    track = {"y": SIGNS_PX, "height": TRACK_PX, "rx": 3, "fill": "currentColor"}
    parts = [element("rect", **track, width=axis.width_px, fill_opacity=0.07)]
    if shown is not None:
        left, right = (min(max(axis.x(edge), 0.0), axis.width_px) for edge in shown)
        width = max(right - left, 2)
        parts.append(element("rect", **track, data_name="shown", x=left, width=width, fill_opacity=0.1))
    for tick_s in axis.ticks_s():
        x = axis.x(tick_s)
        parts.append(line(x, bottom, x, bottom + 3, 0.5))
        anchor = "start" if x < 15 else "end" if x > axis.width_px - 15 else "middle"
        parts.append(words(x, HEIGHT_PX - 1.5, time_text(tick_s, axis.tick_decimals), anchor, 0.6, size=10))
    drawn = drawn_events(axis, events, selected)
    # The worst last, over the others.
    for number in sorted(drawn, key=lambda number: (number == selected, events[number].event.severity)):
        parts += _event(axis, number, events[number], number == selected, imperial, message)
    for span in labelled:
        left, right = axis.x(span.start_s), axis.x(span.end_s)
        place = {"x": left, "y": bottom - LABELLED_PX, "height": LABELLED_PX}
        color = LABELLED_COLOR if span.confirmed else TOUCHED_COLOR
        width = max(right - left, 1.0)
        parts.append(element("rect", **place, width=width, fill=color, data_name="labelled"))
    parts += _remarks(axis, review.missed, review.notes)
    return picture(round(axis.width_px), HEIGHT_PX, parts, "The whole drive")


def drawn_events(axis: TimeAxis, events: Sequence[JudgedEvent], selected: int | None) -> set[int]:
    """Numbers of the events that get a mark: of those that would run into each other the worst one."""
    order = sorted(
        range(len(events)), key=lambda number: (number != selected, -events[number].event.severity)
    )
    taken: dict[tuple[str, int], int] = {}
    for number in order:
        event = events[number].event
        lane = event.kind
        column = round(axis.x(event.start_s) / APART_PX)
        taken.setdefault((lane, column), number)
    return set(taken.values())


def _event(
    axis: TimeAxis, number: int, judged: JudgedEvent, selected: bool, imperial: bool, message: str
) -> Iterator[str]:
    event, color = judged.event, kind_color(judged.event.kind)
    left = min(axis.x(event.start_s), axis.width_px - SMALLEST_MARK_PX)
    right = max(axis.x(event.end_s), left + SMALLEST_MARK_PX)
    if event.kind == MOUNT_MOVED:
        right = left + SMALLEST_MARK_PX
    bottom = SIGNS_PX + TRACK_PX
    height = TRACK_PX * KIND_HEIGHTS.get(event.kind, 0.6)
    title = f"{kind_title(event.kind)} at {time_text(event.start_s)}"
    if line := event_line(event, imperial):
        title += f": {line}"
    look: dict[str, str | float] = {"fill": color}
    if selected:
        look |= {"stroke": "currentColor", "stroke_width": 1.5}
    if event.kind == NEAR_MISS:
        shape = element("path", d=f"M{left - 5:.1f} {bottom - TRACK_PX / 2:.1f} l5 -6 l5 6 l-5 6 z", **look)
    else:
        shape = element("rect", x=left, y=bottom - height, width=right - left, height=height, rx=1, **look)
    width = right - left + 2 * REACH_PX
    reach = element("rect", x=left - REACH_PX, y=SIGNS_PX, width=width, height=TRACK_PX, fill="transparent")
    sign = verdict_sign(judged)
    if sign:
        sign = words((left + right) / 2, SIGNS_PX - 2, sign, "middle", 0.9)
    yield (
        f'<g class="fcw-mark" data-event="{number}" {says(f"{message}{number}")}>'
        f"<title>{escape(title)}</title>{reach}{shape}{sign}</g>"
    )


def _remarks(
    axis: TimeAxis, missed: Iterable[Entry[MissedEvent]], notes: Iterable[Entry[Note]]
) -> Iterator[str]:
    """Missed events as outlines, notes as dots, each with its words."""
    bottom = SIGNS_PX + TRACK_PX
    for entry in missed:
        left, right = axis.x(entry.said.start_s), axis.x(entry.said.end_s)
        title = f"{entry.person}: missed, {entry.said.text}" if entry.said.text else f"{entry.person}: missed"
        width = max(right - left, SMALLEST_MARK_PX)
        line_style = {"stroke": MISSED_COLOR, "stroke_width": 1.5, "stroke_dasharray": "3 2"}
        place = {"x": left, "y": SIGNS_PX + 1, "width": width, "height": TRACK_PX - 2}
        yield (
            f'<g class="fcw-mark" {says(f"goto:{entry.said.start_s!r}")}><title>{escape(title)}</title>'
            f"{element('rect', **place, **line_style, fill='transparent')}</g>"
        )
    dot = {"cy": bottom, "r": 4, "fill": NOTE_COLOR, "stroke": "currentColor", "stroke_opacity": 0.5}
    for entry in notes:
        yield (
            f'<g class="fcw-mark" {says(f"goto:{entry.said.time_s!r}")}>'
            f"<title>{escape(f'{entry.person}: {entry.said.text}')}</title>"
            f"{element('circle', cx=axis.x(entry.said.time_s), **dot)}</g>"
        )
