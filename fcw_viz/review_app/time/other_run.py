"""On the time line: another run's warnings, and where the two runs differ."""

from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from fcw.charts.svg import element, picture
from fcw.logs.comparison import Difference, DifferenceKind
from fcw.logs.events import DriveEvent
from fcw_viz.page.channel import says
from fcw_viz.review_app.drive import time_text
from fcw_viz.review_app.time.axis import TimeAxis
from fcw_viz.review_app.time.timeline import HEIGHT_PX, SIGNS_PX, TRACK_PX, kind_color

EVENT_PX, DIFFERENCE_PX = 4.0, 3.0
SMALLEST_PX = 2.0
DIFFERENCE_COLORS = {
    DifferenceKind.WARNING: "rgb(224, 49, 49)",
    DifferenceKind.LEAD: "rgb(132, 94, 247)",
    DifferenceKind.DISTANCE: "rgb(12, 133, 153)",
}


class OtherRun(NamedTuple):
    """What is drawn of a run that is compared with.

    Attributes:
        events: its own, in its own seconds.
        later_s: how much later it begins.
        differences: between the two, in the open run's seconds.
    """

    events: Sequence[DriveEvent]
    later_s: float
    differences: Sequence[Difference]


NO_OTHER_RUN = OtherRun((), 0.0, ())


def other_run_svg(axis: TimeAxis, other: OtherRun) -> str:
    """Over the upper edge of the track the other run's warnings, on its lower edge what differs."""
    if not (other.events or other.differences):
        return ""
    parts = []
    for event in other.events:
        start_s, end_s = event.start_s + other.later_s, event.end_s + other.later_s
        title = f"the other run: {event.kind} at {time_text(start_s)}"
        place = {"y": SIGNS_PX - EVENT_PX - 1, "height": EVENT_PX, "fill": kind_color(event.kind)}
        words = element("title", escape(title))
        parts.append(element("rect", words, **_along(axis, start_s, end_s), **place, data_name="other"))
    for number, one in enumerate(other.differences):
        place = {"y": SIGNS_PX + TRACK_PX, "height": DIFFERENCE_PX, "fill": DIFFERENCE_COLORS[one.kind]}
        words = element("title", escape(f"differs: {one.kind.value} at {time_text(one.start_s)}"))
        rect = element("rect", words, **_along(axis, one.start_s, one.end_s), **place, data_name="difference")
        parts.append(f'<g class="fcw-mark" {says(f"difference:{number}")}>{rect}</g>')
    return picture(round(axis.width_px), HEIGHT_PX, parts, "The other run")


def _along(axis: TimeAxis, start_s: float, end_s: float) -> dict[str, float]:
    left, right = (min(max(axis.x(time_s), 0.0), axis.width_px) for time_s in (start_s, end_s))
    return {"x": left, "width": max(right - left, SMALLEST_PX)}
