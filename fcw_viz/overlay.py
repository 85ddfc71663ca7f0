"""What is drawn over a frame: boxes, distances, distance rows and the warning, said here for every surface.

`FrameOverlay` says it in pixel coordinates of the picture (the centre of the top-left pixel is (0, 0), as
everywhere), `paint` draws it with OpenCV. Words are of ASCII: fonts of OpenCV 4 have nothing else.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.frame import ImageSize
from fcw.logs.overlay import (
    LEVEL_COLORS,
    PATH_COLOR,
    ROW_COLOR,
    ROW_LABEL_PARTS,
    OverlayBox,
    OverlayRow,
    Rgb,
    overlay_boxes,
    overlay_path,
    overlay_rows,
    own_speed_text,
    pitch_now,
)
from fcw.logs.records import DriveHeader, FrameResult
from fcw.tracking.types import SeenBy, Track
from fcw.units import FEET_PER_METRE, NS_PER_S, distance_text, speed_text
from fcw.warning.describe import describe
from fcw.warning.types import WarningLevel

LETTER_PART = 1 / 48
"""Height of a capital as a part of the picture's: 15 px of 720."""
SMALLEST_LETTER_PX = 8.0
SMALL_LETTER_PART = 0.75
"""Words of the distance rows and of notes are smaller by this: they do not change."""
MARGIN_PART = 0.5
"""Room around words, as a part of the letters' height."""
LEAD_LINE_PART, LINE_PART = 1 / 240, 1 / 360
"""Width of a box's line as a part of the picture's height: 3 and 2 px of 720."""
THIN_LINE_PX = 1.0
"""Of a box without words, and of one that this frame did not see."""
COASTING_OPACITY = 0.5
"""Of the latter: it is a guess."""
WHITE: Rgb = (255, 255, 255)
BLACK: Rgb = (0, 0, 0)
GROUND: Rgb = (16, 16, 20)
GROUND_OPACITY = 0.8
ROW_OPACITY = 0.5
"""The rows go over the vehicles: they must not hide a far one."""
PATH_OPACITY = 0.6
LONGEST_TTC_SHOWN_S = 10.0
_FONT = cv2.FONT_HERSHEY_DUPLEX
_SHIFT = 4
"""Fractional bits of OpenCV's coordinates: a sixteenth of a pixel."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Stroke:
    """A line through points in pixels, drawn with its middle on them.

    Attributes:
        points: its corners.
        closed: whether it goes back to the first one.
        color: of the line.
        width_px: of the line.
        opacity: 0 to 1.
    """

    points: tuple[Point, ...]
    closed: bool
    color: Rgb
    width_px: float
    opacity: float = 1.0


@dataclass(frozen=True, slots=True)
class Words:
    """A line of words on a ground.

    Attributes:
        text: the words.
        left_px: left end of the letters.
        baseline_px: row on which they stand.
        letter_px: height of a capital.
        color: of the letters.
        ground: what is filled behind them.
        ground_color: with what.
        opacity: of the ground, 0 to 1.
    """

    text: str
    left_px: float
    baseline_px: float
    letter_px: float
    color: Rgb
    ground: Box
    ground_color: Rgb = GROUND
    opacity: float = GROUND_OPACITY


@dataclass(frozen=True, slots=True)
class FrameOverlay:
    """All that is drawn over one frame: first the strokes, then the words, each in order."""

    strokes: tuple[Stroke, ...]
    words: tuple[Words, ...]


class OverlayPainter:
    """Says and draws what stands over the frames of one drive."""

    def __init__(self, header: DriveHeader, first_ns: int = 0, *, banner: bool = True) -> None:
        """Prepare for a drive.

        Args:
            header: of the drive.
            first_ns: from which the times shown count.
            banner: whether the warning stands across the top; not where something else says it, and sooner.
        """
        self._has_banner = banner
        self._size, self._imperial, self._first_ns = header.image_size, header.imperial, first_ns
        self._letter_px = max(self._size.height * LETTER_PART, SMALLEST_LETTER_PX)
        self._calibration = header.calibration
        self._small_letter_px = max(self._letter_px * SMALL_LETTER_PART, SMALLEST_LETTER_PX)
        self._rows: tuple[float, FrameOverlay] | None = None

    def overlay(self, result: FrameResult) -> FrameOverlay:
        """What is drawn over a frame."""
        boxes = overlay_boxes(result, self._imperial)
        outlines = (
            Stroke(
                _corners(drawn.box),
                True,
                drawn.color,
                self._line_px(drawn, track.coasting),
                COASTING_OPACITY if track.coasting else 1.0,
            )
            for track, drawn in zip(result.tracks, boxes, strict=True)
        )
        path = tuple(
            Stroke(line, False, PATH_COLOR, self._size.height * LINE_PART, PATH_OPACITY)
            for line in overlay_path(result, self._calibration) or ()
        )
        status, banner = self._status(result), (self._banner(result),) if self._has_banner else ()
        labels = self._labels(result, (*banner, *status))
        rows = self._rows_at(pitch_now(self._calibration, result))
        return FrameOverlay((*rows.strokes, *path, *outlines), (*rows.words, *labels, *status, *banner))

    def paint(self, image: NDArray[np.uint8], result: FrameResult) -> None:
        """Draw over a frame's picture, (height, width, 3) BGR, in place."""
        paint(image, self.overlay(result))

    def _line_px(self, drawn: OverlayBox, coasting: bool) -> float:
        if coasting or not drawn.told:
            return THIN_LINE_PX
        return max(self._size.height * (LEAD_LINE_PART if drawn.is_lead else LINE_PART), THIN_LINE_PX)

    def _rows_at(self, pitch_rad: float) -> FrameOverlay:
        """The distances of the road, where a camera of that pitch sees them."""
        known = self._rows  # of all threads
        if known is not None and known[0] == pitch_rad:
            return known[1]
        rows = overlay_rows(self._calibration, self._imperial, pitch_rad)
        ends = -0.5, self._size.width - 0.5
        lines = (tuple((end, row.row_px) for end in ends) for row in rows)
        strokes = tuple(Stroke(line, False, ROW_COLOR, 1.0, ROW_OPACITY) for line in lines)
        drawn = FrameOverlay(strokes, self._words_of_rows(rows))
        self._rows = pitch_rad, drawn
        return drawn

    def _words_of_rows(self, rows: Sequence[OverlayRow]) -> tuple[Words, ...]:
        """The distances of the rows, near ones first; a far one that would be over another is left out."""
        said: list[Words] = []
        for row in rows:
            places = [
                _words(
                    row.label,
                    self._size.width * part,
                    row.row_px,
                    self._small_letter_px,
                    self._size,
                    ROW_COLOR,
                )
                for part in dict.fromkeys((row.label_part, *ROW_LABEL_PARTS))
            ]
            grounds = [words.ground for words in said]
            said += [words for words in places if not _meets(words.ground, grounds)][:1]
        return tuple(said)

    def _labels(self, result: FrameResult, taken: tuple[Words, ...]) -> list[Words]:
        """Words of the vehicles that have some beside their boxes, the lead first, then from near to far.

        None is over another; they cover a box only where there is no other place, and are left out where
        there is none at all.
        """
        drawn = zip(result.tracks, overlay_boxes(result, self._imperial), strict=True)
        ranked = sorted(
            (pair for pair in drawn if pair[1].told),
            key=lambda pair: (not pair[1].is_lead, pair[0].distance_m),
        )
        boxes = [track.box for track in result.tracks]
        labels: list[Words] = []
        for track, box in ranked:
            text = vehicle_words(track, self._imperial)
            width_px = _width(text, self._letter_px)
            places = [
                _words(text, left_px, row_px, self._letter_px, self._size, box.color)
                for left_px, row_px in _places(box.box, width_px, self._letter_px)
            ]
            grounds = [words.ground for words in (*taken, *labels)]
            free = [words for words in places if not _meets(words.ground, grounds)]
            clear = [words for words in free if not _meets(words.ground, boxes)]
            labels += (clear or free or (places if box.is_lead else []))[:1]
        return labels

    def _banner(self, result: FrameResult) -> Words:
        """The warning across the top, in the colour of its level."""
        level = result.warning.level
        text = describe(result.told_warning, self._imperial)
        if level != WarningLevel.NONE:
            text = level.name + text[len(level.name) :]
        margin_px = self._letter_px * MARGIN_PART
        room_px = self._size.width - 2 * margin_px
        while (
            _width(text, self._letter_px) > room_px and (shorter := re.sub(r"[,;] [^,;]*$", "", text)) != text
        ):
            text = shorter  # the least important is said last
        letter_px = self._letter_px * min(1.0, room_px / _width(text, self._letter_px))
        ground = Box(-0.5, -0.5, self._size.width, self._letter_px + 3 * margin_px)
        color, opacity = (
            (LEVEL_COLORS[level], 1.0) if level != WarningLevel.NONE else (GROUND, GROUND_OPACITY)
        )
        baseline_px = ground.y + (ground.h + letter_px) / 2
        return Words(text, margin_px, baseline_px, letter_px, _readable_on(color), ground, color, opacity)

    def _status(self, result: FrameResult) -> tuple[Words, ...]:
        """Time and own speed at the bottom left, and above them a small line of each note."""
        time_s = (result.time_ns - self._first_ns) / NS_PER_S
        text = f"{time_s:.2f} s"
        if result.ego_speed_mps is not None:
            text += f"   own speed {own_speed_text(result, self._imperial)}"
        margin_px, small_px = self._letter_px * MARGIN_PART, self._small_letter_px
        baseline_px = self._size.height - 2 * margin_px
        words = [_words(text, margin_px, baseline_px, self._letter_px, self._size)]
        baseline_px -= self._letter_px + 2 * margin_px
        for note in result.notes:
            said = _shortened(note, small_px, self._size.width - 2 * margin_px)
            words.append(_words(said, margin_px, baseline_px, small_px, self._size))
            baseline_px -= small_px * (1 + 2 * MARGIN_PART)
        return tuple(words)


def vehicle_words(track: Track, imperial: bool = False) -> str:
    """Number, distance with its interval of 68 %, the TTC where it is under ten seconds, and if not found."""
    low_m, high_m = track.distance_low_m, track.distance_high_m
    low = _number(low_m, track.distance_m, imperial)
    interval = (
        f"{low}-{_number(high_m, track.distance_m, imperial)}" if math.isfinite(high_m) else f"over {low}"
    )
    text = f"#{track.track_id} {distance_text(track.distance_m, imperial)} ({interval})"
    if track.ttc_s is not None and track.ttc_s <= LONGEST_TTC_SHOWN_S:
        text += f" TTC {track.ttc_s:.1f} s"
    return f"{text} carried" if track.seen_by is SeenBy.PICTURE else text


def vehicle_facts(track: Track, imperial: bool = False) -> str:
    """All that there is to know of a vehicle at a glance: its words, and where and how it moves."""
    side = "left" if track.lateral_m > 0 else "right"
    closing_mps = track.closing_speed_mps
    closing = "closing" if closing_mps > 0 else "leaving"
    facts = [
        vehicle_words(track, imperial),
        f"{distance_text(abs(track.lateral_m), imperial)} {side}",
        f"{closing} at {speed_text(abs(closing_mps), imperial)}",
    ]
    if track.coasting:
        facts.append("not seen")
    return ", ".join(facts)


def paint(image: NDArray[np.uint8], overlay: FrameOverlay) -> None:
    """Draw an overlay over a (height, width, 3) BGR picture, in place."""
    for stroke in overlay.strokes:
        _draw_stroke(image, stroke)
    for words in overlay.words:
        _fill(image, words.ground, words.ground_color, words.opacity)
        origin = round(words.left_px), round(words.baseline_px)
        scale, thickness = words.letter_px / _letter_height(), 1
        cv2.putText(image, words.text, origin, _FONT, scale, words.color[::-1], thickness, cv2.LINE_AA)


def _corners(box: Box) -> tuple[Point, ...]:
    return (box.x, box.y), (box.right, box.y), (box.right, box.bottom), (box.x, box.bottom)


def _places(box: Box, width_px: float, letter_px: float) -> Iterator[Point]:
    """Where a box's words may start, the best place first: over it, further up, under it, further down."""
    margin_px = 2 * letter_px * MARGIN_PART
    line_px = letter_px + margin_px
    above_px, below_px = box.y - margin_px, box.bottom + line_px
    for lines in range(4):
        for row_px in (above_px - lines * line_px, below_px + lines * line_px):
            yield box.x, row_px
            yield box.right - width_px, row_px


def _words(
    text: str,
    left_px: float,
    baseline_px: float,
    letter_px: float,
    size: ImageSize,
    ground_color: Rgb = GROUND,
) -> Words:
    """Words with their ground, moved into the picture where they would stick out."""
    margin_px = letter_px * MARGIN_PART
    width_px = _width(text, letter_px)
    left_px = min(max(left_px, margin_px), max(size.width - width_px - margin_px, margin_px))
    baseline_px = min(max(baseline_px, letter_px + margin_px), size.height - 1 - margin_px)
    ground = Box(
        left_px - margin_px,
        baseline_px - letter_px - margin_px,
        width_px + 2 * margin_px,
        letter_px + 2 * margin_px,
    )
    return Words(text, left_px, baseline_px, letter_px, _readable_on(ground_color), ground, ground_color)


def _number(distance_m: float, scale_m: float, imperial: bool) -> str:
    """A distance without its unit, as precise as `distance_text` is at another one."""
    if imperial:
        return f"{distance_m * FEET_PER_METRE:.0f}"
    return f"{distance_m:.1f}" if distance_text(scale_m).count(".") else f"{distance_m:.0f}"


def _draw_stroke(image: NDArray[np.uint8], stroke: Stroke) -> None:
    corners = np.array(stroke.points)
    width_px = max(round(stroke.width_px), 1)
    # Only the part of the picture that the line touches is mixed.
    left, top = np.maximum(np.floor(corners.min(axis=0)).astype(int) - width_px, 0)
    right, bottom = np.maximum(np.ceil(corners.max(axis=0)).astype(int) + width_px + 1, 0)
    region = image[top:bottom, left:right]
    drawn = region if stroke.opacity == 1 else region.copy()
    points = np.round((corners - (left, top)) * (1 << _SHIFT)).astype(np.int32)
    cv2.polylines(drawn, [points], stroke.closed, stroke.color[::-1], width_px, cv2.LINE_AA, _SHIFT)
    if drawn is not region:
        cv2.addWeighted(drawn, stroke.opacity, region, 1 - stroke.opacity, 0.0, dst=region)


def _fill(image: NDArray[np.uint8], box: Box, color: Rgb, opacity: float) -> None:
    height, width = image.shape[:2]
    top, bottom = (min(max(round(row), 0), height) for row in (box.y, box.bottom))
    left, right = (min(max(round(column), 0), width) for column in (box.x, box.right))
    if top < bottom and left < right:
        region = image[top:bottom, left:right]
        cv2.addWeighted(np.full_like(region, color[::-1]), opacity, region, 1 - opacity, 0.0, dst=region)


def _shortened(note: str, letter_px: float, room_px: float) -> str:
    """What a note says first, up to its colon, in one line: all of it would hide the road."""
    words = note.partition(": ")[0].split()
    text = " ".join(words)
    while _width(text, letter_px) > room_px and len(words) > 1:
        words.pop()
        text = " ".join((*words, "..."))
    return text


def _meets(a: Box, others: Sequence[Box]) -> bool:
    return any(a.x < b.right and b.x < a.right and a.y < b.bottom and b.y < a.bottom for b in others)


def _readable_on(color: Rgb) -> Rgb:
    """Black or white, whichever stands out more (luma of ITU-R BT.601)."""
    red, green, blue = color
    return BLACK if 0.299 * red + 0.587 * green + 0.114 * blue > 140 else WHITE


def _width(text: str, letter_px: float) -> float:
    return cv2.getTextSize(text, _FONT, letter_px / _letter_height(), 1)[0][0]


@cache
def _letter_height() -> float:
    """Height of a capital at a font scale of 1."""
    canvas = np.zeros((200, 200), np.uint8)
    cv2.putText(canvas, "H", (50, 150), _FONT, 4.0, (255,), 1)
    return float(np.ptp(np.nonzero(canvas.any(axis=1))[0]) + 1) / 4.0
