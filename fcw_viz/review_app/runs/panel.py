"""The list of differences between two runs, in words."""

from html import escape

from fcw.logs.comparison import Difference, DifferenceKind
from fcw.units import distance_text
from fcw.warning.types import WarningLevel
from fcw_viz.page.channel import chooses, keeps_scroll, says
from fcw_viz.review_app.drive import time_text
from fcw_viz.review_app.runs.comparing import Comparing
from fcw_viz.review_app.time.other_run import DIFFERENCE_COLORS

MOST_LISTED = 300


def runs_html(comparing: Comparing, name: str, candidates: list[str], imperial: bool) -> str:
    """A list of the other runs (`compare:<name>`), and of the differences (`difference:<number>`).

    Args:
        comparing: what is compared.
        name: of the open run.
        candidates: names of the other ones.
        imperial: units.
    """
    other = comparing.other
    if not candidates and other is None:
        return (
            '<p class="dim">No other run of this drive is in the list. Run it again with another detector, '
            "policy or calibration, into a folder of its own beside this one (<code>fcw run … --out</code>). "
            "Then review the folder that holds both, and compare the two here.</p>"
        )
    chosen = "" if other is None else other.name
    options = "".join(
        f'<option value="{escape(one)}"{" selected" * (one == chosen)}>{escape(one)}</option>'
        for one in dict.fromkeys([*candidates, *filter(None, [chosen])])
    )
    select = (
        f'<select {chooses("compare")}><option value="">compare with another run</option>{options}</select>'
    )
    if other is None:
        return select
    if comparing.differences is None:
        return f"{select}<p>Comparing …</p>"
    differences = comparing.differences
    counts = [
        f"{sum(one.kind is kind for one in differences)} in the {kind.value}"
        for kind in DifferenceKind
        if any(one.kind is kind for one in differences)
    ]
    head = f"{len(differences)} difference{'s' * (len(differences) != 1)}"
    about = (
        f"{head}: {', '.join(counts)}. <kbd>D</kbd> jumps to the next one."
        if differences
        else "The two runs do not differ."
    )
    rows = "".join(
        _row(number, one, number == comparing.at, (name, other.name), imperial)
        for number, one in enumerate(differences[:MOST_LISTED])
    )
    more = len(differences) - MOST_LISTED
    tail = f'<p class="dim">and {more} later ones; press D to reach them</p>' if more > 0 else ""
    return (
        f'{select}<p class="dim">{escape(other.name)} ({escape(other.header.detector)}) is dashed in the '
        f"plots. Its lead is orange in the picture, and its warnings are above the timeline. {about}</p>"
        f'<div class="fcw-events" {keeps_scroll("differences")}>{rows}{tail}</div>'
    )


def difference_words(difference: Difference, names: tuple[str, str], imperial: bool) -> str:
    """What differs, in one line.

    Args:
        difference: it.
        names: of the first run and of the second.
        imperial: units.
    """
    first, second = names
    if difference.kind is DifferenceKind.WARNING:
        has = bool(difference.first_has)
        level, other = difference.first_level, difference.second_level
        level, other = (level, other) if has else (other, level)
        nothing = "nothing" if other is WarningLevel.NONE else f"{other.name.lower()} at most"
        shows, shows_not = (first, second) if has else (second, first)
        return f"{level.name.lower()} only in {shows}; {nothing} in {shows_not}"
    distances = (difference.first_m, difference.second_m)
    texts = ["none" if one is None else distance_text(one, imperial) for one in distances]
    if difference.first_has is not None:
        has = difference.first_has
        return f"a lead at {texts[0 if has else 1]} only in {first if has else second}"
    what = "one lead" if difference.kind is DifferenceKind.DISTANCE else "different leads"
    return f"{what}: {texts[0]} in {first}, {texts[1]} in {second}"


def _row(number: int, one: Difference, selected: bool, names: tuple[str, str], imperial: bool) -> str:
    title = {
        DifferenceKind.WARNING: "Warning",
        DifferenceKind.LEAD: "Lead",
        DifferenceKind.DISTANCE: "Distance",
    }[one.kind]
    return (
        f'<div class="fcw-event{" selected" * selected}"{" data-fcw-seen" * selected} '
        f"{says(f'difference:{number}')} "
        f'style="--kind: {DIFFERENCE_COLORS[one.kind]}"><i style="--part: 1"></i><b>{title}</b>'
        f"<time>{time_text(one.start_s)}</time><span>{escape(difference_words(one, names, imperial))}, "
        f"{one.end_s - one.start_s:.1f} s</span></div>"
    )
