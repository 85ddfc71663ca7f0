"""How the panels look, said once, and the small pieces of HTML that they are made of."""

from html import escape
from pathlib import Path

import viser

STYLE = f"<style>{Path(__file__).with_suffix('.css').read_text(encoding='utf-8')}</style>"
_SHEET = Path(__file__).with_name("sheet.css").read_text(encoding="utf-8")
CROSSHAIR_STYLE = "<style>canvas[data-engine], div:has(> canvas) { cursor: crosshair !important; }</style>"
"""For pages on whose picture a click is a measurement."""


def sheet_style(widest_px: int) -> str:
    """The picture first and the panel as a sheet below it, in small windows that are higher than wide.

    Args:
        widest_px: of these windows; at most 900.
    """
    return f'<style media="(max-width: {widest_px}px)">{_SHEET}</style>'


def text_block(html: str) -> str:
    """HTML in the panels' font and margins; what somebody typed in it has to be escaped before."""
    return f'<div class="fcw">{html}</div>'


def step_heading(number: int, title: str, mark: str = "", note: str = "") -> str:
    """The head of one step of the job; `mark` is "done", "now" or empty."""
    sign = "✓" if mark == "done" else str(number)
    side = f"<span>{escape(note)}</span>" if note else ""
    return text_block(f'<div class="fcw-step"><i class="{mark}">{sign}</i>{escape(title)}{side}</div>')


def heading(title: str, note: str = "") -> str:
    """The head of something that is no step."""
    side = f"<span>{escape(note)}</span>" if note else ""
    return text_block(f'<div class="fcw-step">{escape(title)}{side}</div>')


def card(html: str, kind: str = "") -> str:
    """A paragraph set off at its side; `kind` is "stale" for what is no longer current."""
    return f'<div class="fcw-card {kind}">{html}</div>'


def set_html(handle: viser.GuiHtmlHandle, html: str) -> None:
    """Send HTML, unless it is there already."""
    if handle.content != html:
        handle.content = html


def set_colours(gui: viser.GuiApi, dark: bool) -> None:
    """Dark or light, and none of viser's own advertising."""
    gui.configure_theme(show_logo=False, show_share_button=False, dark_mode=dark)
