"""Where words stand on the picture so that none covers another, at the zoom of the moment."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

Point = tuple[float, float]
"""Column and row, in pixels of the picture."""

FONT_CSS_PX = 12.0
"""Height of the letters' em square of viser's labels at a font scale of 1."""
LABEL_HEIGHT_CSS_PX = 1.62 * FONT_CSS_PX
"""Of a label's ground: a line of the tallest of viser's fonts (Segoe UI, 1.33 em) and its margin, a fifth."""
LABEL_MARGIN_CSS_PX = 0.3 * FONT_CSS_PX
"""Left and right of the words together."""
WIDE_LETTERS = frozenset("mwMWABCDEGHKNOPQRSUVXYZ%+<=>±≈→–—")
NARROW_LETTERS = frozenset("ijlftI .,:;'|!()[]-")
LETTER_EM, WIDE_EM, NARROW_EM = 0.58, 0.9, 0.36
"""The widest of their kind in viser's fonts (Segoe UI, Roboto, Helvetica, Arial, Liberation Sans)."""


@dataclass(frozen=True, slots=True)
class Window:
    """The part of the picture that is seen, and how large.

    Attributes:
        left_px: its left edge, in pixels of the picture like the other edges.
        top_px: its upper edge.
        right_px: its right edge.
        bottom_px: its lower edge.
        pixels_per_screen_pixel: picture pixels that a CSS pixel covers.
    """

    left_px: float
    top_px: float
    right_px: float
    bottom_px: float
    pixels_per_screen_pixel: float


@dataclass(frozen=True, slots=True)
class Area:
    """A rectangle of the picture, in its pixels."""

    left_px: float
    top_px: float
    right_px: float
    bottom_px: float

    def overlaps(self, other: "Area") -> bool:
        """Whether the two share more than an edge."""
        return (
            self.left_px < other.right_px
            and other.left_px < self.right_px
            and self.top_px < other.bottom_px
            and other.top_px < self.bottom_px
        )

    @classmethod
    def around(cls, center_px: Point, radius_px: float) -> "Area":
        """The square around a circle."""
        column_px, row_px = center_px
        return cls(column_px - radius_px, row_px - radius_px, column_px + radius_px, row_px + radius_px)


@dataclass(frozen=True, slots=True)
class LabelWish:
    """Words, and where they may stand: left end and middle height of the words, the best place first."""

    text: str
    places_px: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class Label:
    """Words with their place.

    Attributes:
        text: the words.
        left_px: column of their left end.
        row_px: row of their middle height.
        area: what they cover.
    """

    text: str
    left_px: float
    row_px: float
    area: Area


def text_width_css_px(text: str) -> float:
    """At least the width of a label with that text, its margin included."""
    width_em = sum(
        WIDE_EM if letter in WIDE_LETTERS else NARROW_EM if letter in NARROW_LETTERS else LETTER_EM
        for letter in text
    )
    return width_em * FONT_CSS_PX + LABEL_MARGIN_CSS_PX


def lay_out_labels(
    wishes: Sequence[LabelWish], window: Window, obstacles: Iterable[Area] = ()
) -> tuple[Label, ...]:
    """Labels that cover neither each other nor an obstacle, whole inside the window.

    Args:
        wishes: the more important first; each gets the first of its places that is free.
        window: what is seen.
        obstacles: what no label may cover.

    Returns:
        The labels for which there is a place, in the order of the wishes.
    """
    scale = window.pixels_per_screen_pixel
    half_height_px = LABEL_HEIGHT_CSS_PX * scale / 2
    taken = list(obstacles)
    labels: list[Label] = []
    for wish in wishes:
        width_px = text_width_css_px(wish.text) * scale
        for left_px, row_px in wish.places_px:
            area = Area(left_px, row_px - half_height_px, left_px + width_px, row_px + half_height_px)
            inside = (
                area.left_px >= window.left_px
                and area.right_px <= window.right_px
                and area.top_px >= window.top_px
                and area.bottom_px <= window.bottom_px
            )
            if inside and not any(area.overlaps(other) for other in taken):
                labels.append(Label(wish.text, left_px, row_px, area))
                taken.append(area)
                break
    return tuple(labels)
