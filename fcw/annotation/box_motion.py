"""Boxes in frames where nobody drew one: between two drawn ones, or following the vehicle's appearance."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fcw.annotation.records import LabelledBox
from fcw.box import Box
from fcw.tracking.picture.follower import Follower, FollowingSettings

SMALLEST_FOLLOWED_PX = 8.0
"""A box that has become narrower or lower than this is too small to be followed."""


def interpolated(first: LabelledBox, last: LabelledBox, part: float) -> LabelledBox:
    """The box between two frames in which somebody drew it.

    Its edges move evenly, and so do those of its rear face if both have one. Everything else is taken from
    the first box.

    Args:
        first: the box in the earlier frame.
        last: the box in the later frame.
        part: part of the time between them that has passed, 0 to 1.
    """
    rear = (
        None
        if first.rear_box is None or last.rear_box is None
        else _between(first.rear_box, last.rear_box, part)
    )
    return replace(first, box=_between(first.box, last.box, part), rear_box=rear)


def followed(
    label: LabelledBox, first: NDArray[np.uint8], pictures: Iterable[tuple[int, NDArray[np.uint8]]]
) -> Iterator[LabelledBox]:
    """The box in the following pictures, as long as its content looks the same; after that it has drifted.

    Args:
        label: the box in the first picture.
        first: that picture, (height, width, 3) BGR.
        pictures: those after it, each with its time in nanoseconds from the first.
    """
    follower = Follower(FollowingSettings())
    if not follower.remember(first, label.box, 0, detected=True):
        return
    before, predicted = label, label.box
    for time_ns, image in pictures:
        moved = follower.follow(image, before.box, predicted)
        if moved is None or min(moved.box.w, moved.box.h) < SMALLEST_FOLLOWED_PX:
            return
        follower.remember(image, moved.box, time_ns, detected=False)
        rear = None if before.rear_box is None else _carried(before.rear_box, before.box, moved.box)
        now = replace(before, box=moved.box, rear_box=rear)
        # It is expected to move on as it did from the last picture to this one.
        predicted = _between(before.box, moved.box, 2.0)
        before = now
        yield now


def moved(label: LabelledBox, right_px: float, down_px: float) -> LabelledBox:
    """The box moved, with its rear face."""
    box = Box(label.box.x + right_px, label.box.y + down_px, label.box.w, label.box.h)
    return reshaped(label, box)


def reshaped(label: LabelledBox, box: Box) -> LabelledBox:
    """Another box for the same vehicle; the rear face keeps its place relative to the box."""
    rear = None if label.rear_box is None else _carried(label.rear_box, label.box, box)
    return replace(label, box=box, rear_box=rear)


def _between(first: Box, last: Box, part: float) -> Box:
    values = zip((first.x, first.y, first.w, first.h), (last.x, last.y, last.w, last.h), strict=True)
    x, y, w, h = ((1 - part) * one + part * other for one, other in values)
    return Box(x, y, max(w, 1e-3), max(h, 1e-3))


def _carried(inner: Box, before: Box, after: Box) -> Box:
    """The place of a part of a box in another box."""
    across, down = after.w / before.w, after.h / before.h
    return Box(
        after.x + (inner.x - before.x) * across,
        after.y + (inner.y - before.y) * down,
        inner.w * across,
        inner.h * down,
    )
