"""A detector is asked what is in a frame. It may be anybody's, so what it says is looked at."""

import math
from typing import Any

from fcw.box import Box
from fcw.detection.detector import Detection, Detector
from fcw.errors import UserError
from fcw.frame import Frame

FARTHEST_PX = 1e6
"""Larger numbers are surely no pixels of a picture or near it."""


def vehicles_in(detector: Detector, frame: Frame) -> tuple[Detection, ...]:
    """What a detector finds in a frame.

    It sees the picture and cannot change it: the tracker goes by the same one, and it is written to the log.

    Raises:
        UserError: it gives something else than detections, or a box or a score that is none.
    """
    shown = frame.image.view()
    shown.flags.writeable = False
    found: object = detector.detect(shown)
    if not isinstance(found, tuple | list):
        raise _wrong(detector, frame, f"gave {_short(found)}", "a tuple of fcw.Detection, empty for none")
    for one in found:
        _check(detector, frame, one)
    return tuple(found)


def _check(detector: Detector, frame: Frame, found: object) -> None:
    if not isinstance(found, Detection) or not isinstance(found.box, Box):
        expected = "an fcw.Detection with an fcw.Box"
        raise _wrong(detector, frame, f"gave {_short(found)} in the tuple", expected)
    box = found.box
    numbers = (box.x, box.y, box.w, box.h)
    if not (all(_is_below(number, FARTHEST_PX) for number in numbers) and box.w > 0 and box.h > 0):
        expected = f"finite numbers, below {FARTHEST_PX:,.0f} px, and a positive size"
        raise _wrong(detector, frame, f"box ({', '.join(map(_short, numbers))})", expected)
    if not _is_below(found.score, math.inf):
        raise _wrong(detector, frame, f"score {_short(found.score)}", "a finite number")


def _is_below(number: Any, most: float) -> bool:  # noqa: ANN401 - whatever somebody took for a number
    try:
        return bool(abs(number) < most)
    except (TypeError, ValueError):
        return False


def _wrong(detector: Detector, frame: Frame, what: str, expected: str) -> UserError:
    return UserError(f"detector {detector.name!r}, frame {frame.index}: {what}; expected {expected}")


def _short(value: object) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= 80 else f"{text[:80]}..."
