"""Where a frame's time goes, as one bar."""

from collections.abc import Mapping

from fcw.charts.svg import element, picture, words

WIDTH_PX, SIDE_PX = 720, 20
TITLE_BASE_PX, BAR_TOP_PX, BAR_PX = 20, 32, 40
FIRST_NAME_PX, NAME_PX, SWATCH_PX = 96, 20, 12
TITLE_FONT_PX = 14
NARROWEST_NAMED_PX = 34
"""Of a part that has room for its own milliseconds."""
COLORS = (
    "#0b6e99",
    "#d1495b",
    "#8d6a9f",
    "#5b8c5a",
    "#c78a2c",
    "#4f6d7a",
    "#a05195",
    "#7a7a3a",
    "#2f9c95",
    "#6b4c3b",
    "#3d3d8f",
    "#b5651d",
    "#6f9a3a",
)


def stages_bar(stages_ms: Mapping[str, float]) -> str:
    """An SVG picture: the stages side by side, as wide as they take, and their names below.

    Args:
        stages_ms: milliseconds of each, in the order of the work.
    """
    total_ms = sum(stages_ms.values())
    room_px, left_px, parts = WIDTH_PX - 2 * SIDE_PX, float(SIDE_PX), []
    title = f"Where a frame's time goes: {total_ms:.1f} ms of one thread"
    for number, (name, ms) in enumerate(stages_ms.items()):
        width_px = room_px * ms / total_ms if total_ms > 0 else 0.0
        color = COLORS[number % len(COLORS)]
        parts.append(element("rect", x=left_px, y=BAR_TOP_PX, width=width_px, height=BAR_PX, fill=color))
        if width_px >= NARROWEST_NAMED_PX:
            middle_px, base_px = left_px + width_px / 2, BAR_TOP_PX + BAR_PX / 2 + 4
            parts.append(
                element("text", f"{ms:.1f}", x=middle_px, y=base_px, text_anchor="middle", fill="#ffffff")
            )
        base_px = FIRST_NAME_PX + number * NAME_PX
        swatch = {"y": base_px - SWATCH_PX + 2, "width": SWATCH_PX, "height": SWATCH_PX, "fill": color}
        parts.append(element("rect", x=SIDE_PX, **swatch))
        part = f", {ms / total_ms:.0%}" if total_ms > 0 else ""
        parts.append(words(SIDE_PX + SWATCH_PX + 8, base_px, f"{name}: {ms:.2f} ms{part}"))
        left_px += width_px
    height_px = FIRST_NAME_PX + len(stages_ms) * NAME_PX
    heading = words(SIDE_PX, TITLE_BASE_PX, title, size=TITLE_FONT_PX)
    return picture(WIDTH_PX, height_px, [heading, *parts], title)
