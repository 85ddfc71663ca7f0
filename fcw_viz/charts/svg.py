"""The pieces of the SVG figures; words and axes in `currentColor`, so that they read in dark and in light."""

from collections.abc import Iterable
from html import escape

FONT = 'font-family="system-ui, sans-serif" font-size="11"'
EN_SPACE = "\u2002"
"""Two spaces in a row are one in SVG."""


def svg_element(width: float, height: float, parts: Iterable[str], title: str) -> str:
    """A figure that takes the width it is given, up to a readable one."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" {FONT} role="img" '
        'style="display: block; width: 100%; max-width: 26rem; height: auto">'
        f"<title>{escape(title)}</title>{''.join(parts)}</svg>"
    )


def words(
    x: float, y: float, text: str, anchor: str = "start", opacity: float = 1.0, size: float | None = None
) -> str:
    """Words on a base line."""
    font = "" if size is None else f' font-size="{size:g}"'
    return (
        f'<text x="{x:.2f}" y="{y:.2f}" text-anchor="{anchor}" fill="currentColor" '
        f'fill-opacity="{opacity:g}"{font}>{escape(text).replace("  ", EN_SPACE)}</text>'
    )


def line(x1: float, y1: float, x2: float, y2: float, opacity: float) -> str:
    """A thin line of an axis or a grid."""
    return (
        f'<line x1="{x1:.2f}" y1="{y1:.2f}" x2="{x2:.2f}" y2="{y2:.2f}" stroke="currentColor" '
        f'stroke-opacity="{opacity:g}"/>'
    )


def points_text(points: Iterable[tuple[float, float]]) -> str:
    """Points as an attribute of a polygon."""
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in points)
