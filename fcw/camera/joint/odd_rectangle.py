"""Finds rectangles whose corners contradict the stated sides: exchanged sides, or a misplaced corner."""

import math
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Gaussian, GroundRectangle
from fcw.camera.ground_plane import FloatArray
from fcw.camera.joint.fit import JointFit, solved
from fcw.camera.joint.known import Known
from fcw.camera.joint.rectangle import RECTANGLE_MEANS
from fcw.camera.joint.unknowns import CAMERA_UNKNOWNS, LOG_TAPE
from fcw.errors import UserError

ODD_SIGMAS = 5.0
"""Least misfit of a rectangle that is reported. Ten residuals less its five unknowns exceed it once in 7,000
times (chi-squared), and less often because the camera adapts too."""
SWAPPED_ODDS = 5.0
"""Least odds of exchanged sides. Seen at an angle, the odds are far larger; only if the camera looks straight
at the rectangle does it depend on the lens. None of 160 correct rectangles in front of random cameras was
reported (`benchmarks/calibration/rectangle.py --count 20`)."""
UNKNOWN_SIGMA_M = 1e6
"""Standard deviation of a side that is left open."""


@dataclass(frozen=True, slots=True)
class OddRectangle:
    """A rectangle that contradicts what was stated.

    Attributes:
        index: its index in the evidence.
        swapped: whether it fits if its sides are exchanged.
        text: what is wrong, in one sentence.
    """

    index: int
    swapped: bool
    text: str


def odd_rectangle(known: Known) -> OddRectangle | None:
    """The first rectangle that contradicts what was stated; None if there is none."""
    if not known.evidence.rectangles:
        return None
    try:
        x, _ = solved(known)
    except UserError:
        return None
    misfits = JointFit(known).rectangle_misfits(x)
    for index, rectangle in enumerate(known.evidence.rectangles):
        if _are_exchanged(known, index):
            return OddRectangle(index, True, f"the sides of the rectangle are exchanged: {_sides(rectangle)}")
        if misfits[index] > ODD_SIGMAS:
            return OddRectangle(
                index,
                False,
                f"the four corners are no rectangle{_of_size(rectangle)} on a flat road: a corner lies "
                "elsewhere, a side is wrong, the road is not flat, or the lens bends the picture",
            )
    return None


def swap_gain(known: Known, index: int) -> float:
    """Logarithm of the odds that the sides of a rectangle are exchanged.

    A fit without the sides predicts their lengths with their uncertainty. The stated sides have a density
    under this Gaussian in either order (the posterior predictive; Gelman et al. 2013, "Bayesian Data
    Analysis", section 1.3). One fit serves both orders, and wrong sides cannot pull it aside.

    Args:
        known: all that is known.
        index: index of the rectangle.
    """
    as_said, exchanged = _both_ways(known, index)
    return exchanged.log_density - as_said.log_density


@dataclass(frozen=True, slots=True)
class _Sides:
    """How well the sides of a rectangle agree with everything else.

    Attributes:
        log_density: logarithm of their density, up to terms that do not depend on their order.
        sigmas: how far both together are off.
    """

    log_density: float = 0.0
    sigmas: float = 0.0


def _are_exchanged(known: Known, index: int) -> bool:
    """Whether exchanged sides are far likelier, and agree with what was clicked."""
    as_said, exchanged = _both_ways(known, index)
    likelier = exchanged.log_density - as_said.log_density > math.log(SWAPPED_ODDS)
    return likelier and exchanged.sigmas < ODD_SIGMAS


def _both_ways(known: Known, index: int) -> tuple[_Sides, _Sides]:
    """The sides as stated, and exchanged."""
    rectangle = known.evidence.rectangles[index]
    if rectangle.swapped == rectangle:
        return _Sides(), _Sides()
    try:
        x, covariance = JointFit(_with_open_sides(known, index)).solve()
    except (UserError, np.linalg.LinAlgError):
        return _Sides(), _Sides()
    by = np.zeros((2, len(x)))  # the sides by the tape that measured them, as logarithms
    last = CAMERA_UNKNOWNS + len(RECTANGLE_MEANS) * (index + 1)
    by[0, last - 2] = by[1, last - 1] = 1.0
    by[:, LOG_TAPE] = -1.0
    lengths, spread = by @ x, by @ covariance @ by.T
    return _sides_by(rectangle, lengths, spread), _sides_by(rectangle.swapped, lengths, spread)


def _with_open_sides(known: Known, index: int) -> Known:
    """The same with unknown sides. Leaving the sides out instead would change the prior of the lens."""
    rectangles = list(known.evidence.rectangles)
    first, second = (side and Gaussian(side.value, UNKNOWN_SIGMA_M) for side in rectangles[index].sides_m)
    rectangles[index] = replace(rectangles[index], first_side_m=first, second_side_m=second)
    return replace(known, evidence=replace(known.evidence, rectangles=tuple(rectangles)))


def _sides_by(rectangle: GroundRectangle, lengths: FloatArray, spread: FloatArray) -> _Sides:
    """Compare the stated sides with the logarithms of the predicted lengths and their covariance."""
    told = [(k, side) for k, side in enumerate(rectangle.sides_m) if side is not None]
    at = [k for k, _ in told]
    off = np.array([math.log(side.value) for _, side in told]) - lengths[at]
    total = spread[np.ix_(at, at)] + np.diag([(side.sigma / side.value) ** 2 for _, side in told])
    squared = float(off @ np.linalg.solve(total, off))
    return _Sides(-(squared + float(np.linalg.slogdet(total)[1])) / 2, math.sqrt(squared))


def _sides(rectangle: GroundRectangle) -> str:
    first, second = ("unknown" if side is None else f"{side.value:.4g} m" for side in rectangle.sides_m)
    return f"you gave {first} from the first corner to the second and {second} from there to the third"


def _of_size(rectangle: GroundRectangle) -> str:
    first, second = rectangle.sides_m
    return "" if first is None or second is None else f" of {first.value:.4g} by {second.value:.4g} m"
