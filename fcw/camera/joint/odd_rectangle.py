"""Whether four corners are no rectangle of the sides that were said: exchanged sides, a corner elsewhere."""

import math
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import GroundRectangle
from fcw.camera.joint.fit import JointFit
from fcw.camera.joint.known import Known
from fcw.errors import UserError

ODD_SIGMAS = 5.0
"""Misfit of a rectangle from which it is spoken of. Ten residuals less its own five unknowns exceed that once
in 7,000 (chi-squared), and the camera gives way besides."""
SWAPPED_ODDS = 5.0
"""How much likelier exchanged sides must be. Seen from an angle they are told apart by far more; only who
stands square before a rectangle leaves it to the lens. Of 60 right ones before random cameras none came near
it."""


@dataclass(frozen=True, slots=True)
class OddRectangle:
    """A rectangle that is not as it was said.

    Attributes:
        index: of it, in the evidence.
        swapped: whether it fits with its sides exchanged.
        text: what is wrong, in one sentence.
    """

    index: int
    swapped: bool
    text: str


def odd_rectangle(known: Known) -> OddRectangle | None:
    """The first rectangle that is not as it was said; None where all are."""
    if not known.evidence.rectangles:
        return None
    fit = JointFit(known)
    try:
        x, covariance = fit.solve()
    except UserError:
        return None
    score, misfits = fit.log_evidence(x, covariance), fit.rectangle_misfits(x)
    for index, rectangle in enumerate(known.evidence.rectangles):
        if swap_gain(known, index, score) > math.log(SWAPPED_ODDS):
            return OddRectangle(index, True, f"the sides of the rectangle are exchanged: {_sides(rectangle)}")
        if misfits[index] > ODD_SIGMAS:
            return OddRectangle(
                index,
                False,
                f"the four corners are no rectangle{_of_size(rectangle)} on a flat road: a corner lies "
                "elsewhere, a side is wrong, the road is not flat, or the lens bends the picture",
            )
    return None


def swap_gain(known: Known, index: int, score: float | None = None) -> float:
    """By how much the logarithm of the evidence grows with the sides of a rectangle exchanged.

    Args:
        known: all that is known.
        index: of the rectangle.
        score: the logarithm of the evidence as it was said, if that is known.
    """
    rectangles = list(known.evidence.rectangles)
    if rectangles[index].swapped == rectangles[index]:
        return 0.0
    rectangles[index] = rectangles[index].swapped
    exchanged = replace(known, evidence=replace(known.evidence, rectangles=tuple(rectangles)))
    return _score(exchanged) - (_score(known) if score is None else score)


def _score(known: Known) -> float:
    fit = JointFit(known)
    try:
        return fit.log_evidence(*fit.solve())
    except (UserError, np.linalg.LinAlgError):
        return -math.inf


def _sides(rectangle: GroundRectangle) -> str:
    first, second = ("unknown" if side is None else f"{side.value:.4g} m" for side in rectangle.sides_m)
    return f"said {first} from the first corner to the second and {second} on to the third"


def _of_size(rectangle: GroundRectangle) -> str:
    first, second = rectangle.sides_m
    return "" if first is None or second is None else f" of {first.value:.4g} by {second.value:.4g} m"
