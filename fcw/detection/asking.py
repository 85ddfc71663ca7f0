"""Runs a detector on a frame and checks its answer: the detector may be a user's own."""

import math
from dataclasses import replace
from typing import Any

from fcw.box import Box
from fcw.detection.detector import Detection, Detector
from fcw.errors import UserError
from fcw.frame import Frame

FARTHEST_PX = 1e6
"""Larger coordinates are surely wrong."""


def vehicles_in(detector: Detector, frame: Frame) -> tuple[Detection, ...]:
    """Run a detector on a frame, and check what it returns.

    The picture that it gets is read-only: the tracker uses the same one, and it is written to the log.

    Raises:
        UserError: it returns something else than detections, or a box or a score that is not valid.
    """
    shown = frame.image.view()
    shown.flags.writeable = False
    found: object = detector.detect(shown)
    if not isinstance(found, tuple | list):
        raise _wrong(detector, frame, f"gave {_short(found)}", "a tuple of fcw.Detection, empty for none")
    return tuple(_checked(detector, frame, one) for one in found)


def _checked(detector: Detector, frame: Frame, found: object) -> Detection:
    """A detection with Python's own floats, as sums and squares of NumPy's small integers would overflow."""
    if not isinstance(found, Detection) or not isinstance(found.box, Box):
        expected = "an fcw.Detection with an fcw.Box"
        raise _wrong(detector, frame, f"gave {_short(found)} in the tuple", expected)
    given = (found.box.x, found.box.y, found.box.w, found.box.h)
    x, y, w, h = map(_number, given)
    if not (all(abs(number) < FARTHEST_PX for number in (x, y, w, h)) and w > 0 and h > 0):
        expected = f"finite numbers, below {FARTHEST_PX:,.0f} px, and a positive size"
        raise _wrong(detector, frame, f"box ({', '.join(map(_short, given))})", expected)
    score = _number(found.score)
    if not math.isfinite(score):
        raise _wrong(detector, frame, f"score {_short(found.score)}", "a finite number")
    return replace(found, box=Box(x, y, w, h), score=score)


def _number(value: Any) -> float:  # noqa: ANN401 - whatever somebody took for a number
    """A number of any type as a Python float; NaN for anything else, such as an array or a string."""
    try:
        return math.nan if isinstance(value, str | bytes) else float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _wrong(detector: Detector, frame: Frame, what: str, expected: str) -> UserError:
    return UserError(f"detector {detector.name!r}, frame {frame.index}: {what}; expected {expected}")


def _short(value: object) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= 80 else f"{text[:80]}..."
