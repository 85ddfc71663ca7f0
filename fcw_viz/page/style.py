"""The style of the panels, and the small pieces of HTML of which they consist."""

from html import escape
from pathlib import Path

import viser

STYLE = f"<style>{Path(__file__).with_suffix('.css').read_text(encoding='utf-8')}</style>"
_SHEET = Path(__file__).with_name("sheet.css").read_text(encoding="utf-8")
CROSSHAIR_STYLE = "<style>canvas[data-engine], div:has(> canvas) { cursor: crosshair !important; }</style>"
"""For pages with a picture on which clicks are measurements."""


def sheet_style(widest_px: int) -> str:
    """Show the picture first and the panel as a sheet below it, in small windows that are higher than wide.

    Args:
        widest_px: largest width of these windows; at most 900.
    """
    return f'<style media="(max-width: {widest_px}px)">{_SHEET}</style>'


def text_block(html: str) -> str:
    """HTML with the font and margins of the panels; text typed by users must be escaped before."""
    return f'<div class="fcw">{html}</div>'


def step_heading(number: int, title: str, mark: str = "", note: str = "") -> str:
    """The heading of one step; `mark` is "done", "now" or empty."""
    sign = "✓" if mark == "done" else str(number)
    side = f"<span>{escape(note)}</span>" if note else ""
    return text_block(f'<div class="fcw-step"><i class="{mark}">{sign}</i>{escape(title)}{side}</div>')


def heading(title: str, note: str = "") -> str:
    """A heading that is not that of a step."""
    side = f"<span>{escape(note)}</span>" if note else ""
    return text_block(f'<div class="fcw-step">{escape(title)}{side}</div>')


def card(html: str, kind: str = "") -> str:
    """A paragraph with a mark at its side; `kind` is "stale" for outdated content."""
    return f'<div class="fcw-card {kind}">{html}</div>'


def set_html(handle: viser.GuiHtmlHandle, html: str) -> None:
    """Send HTML if it has changed."""
    if handle.content != html:
        handle.content = html


def set_colours(gui: viser.GuiApi, dark: bool) -> None:
    """Set dark or light colours, without viser's own advertising."""
    gui.configure_theme(show_logo=False, show_share_button=False, dark_mode=dark)
