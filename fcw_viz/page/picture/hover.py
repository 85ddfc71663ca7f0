"""What there is to know of the vehicle under the mouse: most boxes on a picture have no words of theirs."""

from pathlib import Path
from typing import NamedTuple

import viser

from fcw.box import Box
from fcw.logs.overlay import Rgb, overlay_boxes
from fcw.logs.records import FrameResult
from fcw_viz.overlay import vehicle_facts
from fcw_viz.page.picture.lines import LineOverlay, box_line
from fcw_viz.page.picture.view import PictureView
from fcw_viz.page.script import run_script

_BROWSER_SIDE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")
REACH_PX = 3.0
"""A box is met this far beside it, in pixels of the screen: far vehicles are small."""


class _Hint(NamedTuple):
    """A box with what is said of it under the mouse."""

    box: Box
    color: Rgb
    text: str


class HoverHints:
    """Words at the box under the mouse, in the tab's thread."""

    def __init__(self, view: PictureView, client: viser.ClientHandle) -> None:
        self._view, self._client = view, client
        self._lines = LineOverlay(view, client, "hover")
        self._hints: tuple[_Hint, ...] = ()
        self._mouse: tuple[float, float] | None = None
        self._shown: _Hint | None = None

    def start(self) -> None:
        """Have the page tell of the mouse, once its channel is open."""
        run_script(self._client, _BROWSER_SIDE)

    def show(self, result: FrameResult | None, imperial: bool = False) -> None:
        """Take the boxes of the frame that is shown; None for no boxes."""
        self._hints = (
            ()
            if result is None
            else tuple(
                _Hint(track.box, drawn.color, vehicle_facts(track, imperial))
                for track, drawn in zip(result.tracks, overlay_boxes(result, imperial), strict=True)
            )
        )
        self._follow()

    def move(self, about: str) -> None:
        """Take the page's message `hover`: where the mouse is now."""
        x, _, y = about.partition(" ")
        self._mouse = (float(x), float(y)) if y else None
        self._follow()

    @property
    def mouse_px(self) -> tuple[float, float] | None:
        """Column and row of the picture where the mouse is; None where it is elsewhere."""
        if self._mouse is None or self._view.away:
            return None
        left, top, right, bottom = self._view.window_px
        return left + self._mouse[0] * (right - left), top + self._mouse[1] * (bottom - top)

    def _follow(self) -> None:
        hint = self._under_mouse()
        if hint != self._shown:
            self._shown = hint
            self._lines.show([] if hint is None else [box_line(*hint)])

    def _under_mouse(self) -> _Hint | None:
        """The smallest box there, as a far vehicle may stand before a near one's box."""
        mouse_px = self.mouse_px
        if mouse_px is None:
            return None
        column_px, row_px = mouse_px
        reach_px = REACH_PX * self._view.pixels_per_screen_pixel
        met = [
            hint
            for hint in self._hints
            if hint.box.x - reach_px <= column_px <= hint.box.right + reach_px
            and hint.box.y - reach_px <= row_px <= hint.box.bottom + reach_px
        ]
        return min(met, key=lambda hint: hint.box.w * hint.box.h, default=None)
