"""The mouse over a box: the vehicle there is told of, in any zoom, and nothing where there is none."""

from dataclasses import replace

import pytest

from fcw.box import Box
from fcw.logs.records import FrameResult
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.page.picture import hover
from fcw_viz.page.picture.hover import HoverHints

NEAR = Track(
    3, Box(100, 100, 200, 100), 9.0, 12.0, 11.0, 13.0, 2.0, 1.0, 0.4, None, 3.0, SeenBy.DETECTOR, False
)
FAR = replace(
    NEAR, track_id=4, box=Box(150, 120, 20, 10), distance_m=60.0, distance_low_m=55, distance_high_m=65
)


class Surface:
    """A view of a picture of 400x200, twice as large as the window."""

    away = False
    window_px = (-0.5, -0.5, 399.5, 199.5)
    pixels_per_screen_pixel = 0.5


class Drawn:
    def __init__(self, *_):
        self.texts = []

    def show(self, lines):
        self.texts.append([line.text for line in lines])


@pytest.fixture
def hints(monkeypatch):
    monkeypatch.setattr(hover, "LineOverlay", Drawn)
    made = HoverHints(Surface(), None)  # pyright: ignore[reportArgumentType]
    made.show(FrameResult(0, 0, (), (NEAR, FAR), None, WarningState(WarningLevel.NONE), None, ()))
    return made


def told(hints):
    drawn = hints._lines.texts
    return drawn[-1][0].split()[0] if drawn and drawn[-1] else None


def test_the_box_under_the_mouse_is_told_of_the_smaller_one_first(hints):
    hints.move("0.3 0.9")
    assert told(hints) == "#3"
    hints.move("0.4 0.625")
    assert told(hints) == "#4"
    hints.move("0.9 0.1")
    assert told(hints) is None
    hints.move("0.4 0.625")
    hints.move("")
    assert told(hints) is None


def test_it_follows_the_frames_and_is_silent_from_above_and_without_an_overlay(hints):
    hints.move("0.3 0.9")
    hints.show(FrameResult(1, 0, (), (FAR,), None, WarningState(WarningLevel.NONE), None, ()))
    assert told(hints) is None
    hints.move("0.4 0.625")
    assert told(hints) == "#4"
    hints.show(None)
    assert told(hints) is None
    hints._view.away = True
    hints.show(FrameResult(1, 0, (), (FAR,), None, WarningState(WarningLevel.NONE), None, ()))
    assert told(hints) is None
