"""Boxes in pictures."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Box:
    """An axis-aligned box in pixels: left edge x, top edge y, width w, height h.

    Edges are continuous coordinates on the grid whose origin is the centre of the top-left pixel.
    """

    x: float
    y: float
    w: float
    h: float

    @property
    def right(self) -> float:
        """Column of the right edge."""
        return self.x + self.w

    @property
    def bottom(self) -> float:
        """Row of the bottom edge: where the vehicle meets the road."""
        return self.y + self.h

    @property
    def center_x(self) -> float:
        """Column of the middle."""
        return self.x + self.w / 2


def shared_area(a: Box, b: Box) -> float:
    """Common area of two boxes, in square pixels."""
    width = min(a.right, b.right) - max(a.x, b.x)
    height = min(a.bottom, b.bottom) - max(a.y, b.y)
    return max(width, 0.0) * max(height, 0.0)


def iou(a: Box, b: Box) -> float:
    """Intersection over union of two boxes; their areas must be positive."""
    shared = shared_area(a, b)
    return shared / (a.w * a.h + b.w * b.h - shared)
