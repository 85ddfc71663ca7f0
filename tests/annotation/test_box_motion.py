"""Boxes that nobody drew lie where the vehicle is."""

import csv
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fcw.annotation.box_motion import followed, interpolated, moved, reshaped
from fcw.annotation.records import LabelledBox, View
from fcw.box import Box, iou
from fcw.sources.video import VideoSource

DEMO = Path(__file__).parents[2] / "recordings" / "demo"
FRAMES, START, STEP = 60, 720, 15
"""A clip of the shipped drive, and from drawn box to drawn box."""
NARROWEST_PX, SEEN = 28.0, 0.9
"""A label counts from this width on (the data's own rule), and where so much of the vehicle is seen."""
HAND_PX = 1.0
"""1-sigma of each edge that a person draws."""
LEAST_IOU = 0.85

boxes = st.builds(Box, st.floats(0, 500), st.floats(0, 300), st.floats(5.0, 200.0), st.floats(5.0, 200.0))


@pytest.fixture(scope="module")
def truth() -> dict[str, dict[int, Box]]:
    """True boxes of the vehicles that are seen in the whole clip, by vehicle and frame."""
    found: dict[str, dict[int, Box]] = defaultdict(dict)
    with (DEMO / "truth.csv").open() as file:
        for row in csv.DictReader(file):
            if START <= int(row["frame"]) <= START + FRAMES and float(row["visible_fraction"]) > SEEN:
                values = (float(row[f"box_{name}"]) for name in ("x", "y", "w", "h"))
                found[row["vehicle"]][int(row["frame"])] = Box(*values)
    wide = {name: min(box.w for box in seen.values()) >= NARROWEST_PX for name, seen in found.items()}
    return {name: seen for name, seen in found.items() if len(seen) == FRAMES + 1 and wide[name]}


@given(first=boxes, last=boxes, part=st.floats(0, 1))
def test_edges_move_evenly_from_the_first_to_the_last(first: Box, last: Box, part: float):
    one, other = LabelledBox(first, 3, view=View.REAR), LabelledBox(last, 3)
    between = interpolated(one, other, part)
    assert (between.view, between.track_id) == (View.REAR, 3)
    for name in ("x", "y", "right", "bottom"):
        expected = (1 - part) * getattr(first, name) + part * getattr(last, name)
        assert getattr(between.box, name) == pytest.approx(expected)


@given(box=boxes, other=boxes, right=st.floats(-50, 50), down=st.floats(-50, 50))
def test_the_rear_face_keeps_its_place_in_the_box(box: Box, other: Box, right: float, down: float):
    rear = Box(box.x + 0.25 * box.w, box.y, 0.5 * box.w, box.h)
    label = LabelledBox(box, rear_box=rear)
    there = moved(label, right, down).rear_box
    assert there is not None
    assert (there.x, there.y) == (pytest.approx(rear.x + right), pytest.approx(rear.y + down))
    reshaped_rear = reshaped(label, other).rear_box
    assert reshaped_rear is not None
    assert reshaped_rear.x - other.x == pytest.approx(0.25 * other.w)
    assert reshaped_rear.w == pytest.approx(0.5 * other.w)


def test_a_clip_labelled_at_every_fifteenth_frame_is_labelled_well_in_all(truth: dict[str, dict[int, Box]]):
    assert len(truth) >= 2
    rng = np.random.default_rng(4)
    for seen in truth.values():

        def drawn(frame: int, seen: dict[int, Box] = seen) -> LabelledBox:
            left, top, right, bottom = rng.normal(0, HAND_PX, 4)
            box = seen[frame]
            return LabelledBox(Box(box.x + left, box.y + top, box.w + right - left, box.h + bottom - top))

        overlaps = []
        for start in range(START, START + FRAMES, STEP):
            first, last = drawn(start), drawn(start + STEP)
            overlaps += [iou(interpolated(first, last, k / STEP).box, seen[start + k]) for k in range(STEP)]
        assert np.mean(overlaps) >= LEAST_IOU


@pytest.mark.slow
def test_a_vehicle_is_followed_by_its_looks_until_they_change(truth: dict[str, dict[int, Box]]):
    seen = max(truth.values(), key=lambda one: one[START].w)
    frames = {}
    for frame in VideoSource(DEMO / "drive.mp4").frames():
        if START <= frame.index <= START + FRAMES:
            frames[frame.index] = frame
        if frame.index > START + FRAMES:
            break

    def pictures(hidden_from: int) -> Iterator[tuple[int, NDArray[np.uint8]]]:
        for index in range(START + 1, START + FRAMES + 1):
            image = frames[index].image
            shown = image if index < hidden_from else np.full_like(image, 120)
            yield frames[index].time_ns - frames[START].time_ns, shown

    label = LabelledBox(seen[START], 5)
    followed_all = list(followed(label, frames[START].image, pictures(10**9)))
    assert len(followed_all) == FRAMES
    overlaps = [iou(one.box, seen[START + 1 + k]) for k, one in enumerate(followed_all)]
    assert np.mean(overlaps) >= LEAST_IOU
    assert {replace(one, box=label.box) for one in followed_all} == {label}
    assert len(list(followed(label, frames[START].image, pictures(START + 20)))) == 19
