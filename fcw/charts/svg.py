"""The pieces of a chart; words and axes in `currentColor`, so that they read in dark and in light."""

from collections.abc import Iterable
from html import escape

Attribute = float | str | Iterable[tuple[float, float]] | None

FONT = "system-ui, sans-serif"
FONT_PX = 11
MARK = f'font-family="{FONT}" font-size="{FONT_PX}" role="img"'.encode()
"""By this a picture of ours is known, in the place of which a new one may be written."""
EN_SPACE = "\u2002"
"""Two spaces in a row are one in SVG."""


def element(tag: str, *inside: str, **attributes: Attribute) -> str:
    """An element around others; `_` in a name stands for `-`, and what is None is left out."""
    text = "".join(
        f' {name.replace("_", "-")}="{_text(value)}"'
        for name, value in attributes.items()
        if value is not None
    )
    return f"<{tag}{text}>{''.join(inside)}</{tag}>" if inside else f"<{tag}{text}/>"


def picture(width: float, height: float, parts: Iterable[str], title: str, style: str = "") -> str:
    """A whole picture, so many CSS pixels large where no style says otherwise."""
    return element(
        "svg",
        element("title", escape(title)),
        *parts,
        xmlns="http://www.w3.org/2000/svg",
        viewBox=f"0 0 {width:g} {height:g}",
        font_family=FONT,
        font_size=FONT_PX,
        role="img",
        width=None if style else width,
        height=None if style else height,
        style=style or None,
    )


def words(
    x: float,
    y: float,
    text: str,
    anchor: str = "start",
    opacity: float = 1.0,
    size: float | None = None,
    transform: str | None = None,
) -> str:
    """Words on a base line."""
    return element(
        "text",
        escape(text).replace("  ", EN_SPACE),
        x=x,
        y=y,
        text_anchor=anchor,
        fill="currentColor",
        fill_opacity=opacity,
        font_size=size,
        transform=transform,
    )


def line(x1: float, y1: float, x2: float, y2: float, opacity: float) -> str:
    """A thin line of an axis or a grid."""
    return element("line", x1=x1, y1=y1, x2=x2, y2=y2, stroke="currentColor", stroke_opacity=opacity)


def css_color(rgb: tuple[int, int, int]) -> str:
    """A colour."""
    return "rgb({}, {}, {})".format(*rgb)


def _text(value: float | str | Iterable[tuple[float, float]]) -> str:
    """A number to six digits, points of a line to tenths of a pixel."""
    if isinstance(value, str):
        return escape(value)
    if isinstance(value, Iterable):
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in value)
    return f"{value:g}"
