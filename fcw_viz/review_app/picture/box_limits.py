"""What a box that a person draws may be: inside the picture, and no slip of the hand."""

from dataclasses import replace

from fcw.annotation.records import BoxEdit, MadeBy
from fcw.box import Box
from fcw.errors import UserError
from fcw.frame import ImageSize

SMALLEST_PX = 3.0
"""A box that is drawn smaller is a slip of the hand."""


def is_slip(box: Box) -> bool:
    """Whether it is too small to be meant."""
    return min(box.w, box.h) < SMALLEST_PX


def inside(size: ImageSize, left_px: float, top_px: float, right_px: float, bottom_px: float) -> Box:
    """A box cut at the picture's edges."""
    left_px, right_px = (min(max(x, -0.5), size.width - 0.5) for x in (left_px, right_px))
    top_px, bottom_px = (min(max(y, -0.5), size.height - 0.5) for y in (top_px, bottom_px))
    return Box(left_px, top_px, max(right_px - left_px, 1e-3), max(bottom_px - top_px, 1e-3))


def cut(size: ImageSize, edit: BoxEdit) -> BoxEdit:
    """An edit whose box and rear face are cut at the picture's edges.

    Raises:
        UserError: next to nothing is left of a box by hand.
    """
    label = edit.label
    if label is None:
        return edit
    box, rear = _cut_box(size, label.box), label.rear_box
    if edit.made_by is MadeBy.HAND and is_slip(box):
        raise UserError(f"a box has to be at least {SMALLEST_PX:g} pixels wide and high, inside the picture")
    if rear is not None:
        rear = _cut_box(size, rear)
        rear = None if is_slip(rear) else rear  # nothing of it is seen
    return replace(edit, label=replace(label, box=box, rear_box=rear))


def _cut_box(size: ImageSize, box: Box) -> Box:
    return inside(size, box.x, box.y, box.right, box.bottom)
