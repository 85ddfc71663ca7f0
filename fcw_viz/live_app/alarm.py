"""The visible and audible warning: a border with words over the picture, and sounds."""

from html import escape
from pathlib import Path

import viser

from fcw.logs.overlay import LEVEL_COLORS
from fcw.logs.records import FrameResult
from fcw.units import distance_text
from fcw.warning.types import WarningLevel
from fcw_viz.page.script import run_script
from fcw_viz.page.style import set_html

_BROWSER_SIDE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")

COMMANDS = {
    WarningLevel.ADVISORY: "Keep more distance",
    WarningLevel.CAUTION: "Get ready to brake",
    WarningLevel.WARNING: "Brake!",
}
"""Short enough to be read at a glance."""
SOUNDING = {WarningLevel.CAUTION: "caution", WarningLevel.WARNING: "warning"}
"""Levels with a sound, by their names in alarm.js; an advisory is only visible."""
SILENT = "none"


class Alarm:
    """The warning in one tab."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._banner = client.gui.add_html("")
        self.muted = False
        run_script(client, _BROWSER_SIDE)

    def show(self, result: FrameResult, captured: str, imperial: bool) -> None:
        """Show and sound the warning of a frame.

        Args:
            result: result of the frame.
            captured: when its picture was captured, from `PictureAge.in_browser`.
            imperial: whether the words use imperial units.
        """
        level = result.warning.level
        set_html(self._banner, banner_html(result, imperial))
        run_script(self._client, f"window.fcwAlarm.tell('{SOUNDING.get(level, SILENT)}', {captured});")

    def mute(self, muted: bool) -> None:
        """Switch the sounds off or on."""
        self.muted = muted
        run_script(self._client, f"window.fcwAlarm.mute({'true' if muted else 'false'});")

    def end(self, lost: bool) -> None:
        """End the drive; a lost source is sounded once."""
        set_html(self._banner, "")
        run_script(self._client, f"window.fcwAlarm.end({'true' if lost else 'false'});")


def banner_html(result: FrameResult, imperial: bool) -> str:
    """A border in the colour of the level, and what to do; empty without a warning."""
    warning = result.told_warning
    if warning.level is WarningLevel.NONE:
        return ""
    figures = [] if warning.distance_m is None else [distance_text(warning.distance_m, imperial)]
    if warning.ttc_s is not None:
        figures.append(f"{warning.ttc_s:.1f} s")
    color = "rgb({}, {}, {})".format(*LEVEL_COLORS[warning.level])
    name = warning.level.name.lower()
    return (
        f'<div class="fcw-alarm {name}" data-level="{name}" style="--level: {color}">'
        f"<b>{escape(COMMANDS[warning.level])}</b><span>{' · '.join(figures)}</span></div>"
    )
