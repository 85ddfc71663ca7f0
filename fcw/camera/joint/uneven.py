"""Finds out whether dashes keep the stated period, which a bridge or a road marked anew may not have.

What else is known about the camera (height, lens and lane) shows where each dash must be. So each way in
which the dashes may differ is fitted as well as the stated one, and weighted by how well it explains
everything (Laplace's approximation; MacKay 1992, "Bayesian interpolation"). The result is the mean camera,
and its covariance includes the spread: model averaging (Hoeting et al. 1999).
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.camera.joint.fit import JointFit, solved
from fcw.camera.joint.known import Known, Slip
from fcw.camera.joint.unknowns import SLIP
from fcw.errors import UserError

UNEVEN_SHARE = 0.2
"""Prior probability that the clicked dashes do not keep the rule, half of it for another period and half for
one other gap. This is a guess about roads, not a count; no picture was used for it."""
UNEVEN_SIGMA = 0.2
"""Relative deviation of the period or gap in that case; the rules of two countries differ by as much."""
FEWEST_DASHES = 3
SPOKEN_SHARE = 0.5
"""Least probability at which it is reported: then it is likelier than what was stated."""


@dataclass(frozen=True, slots=True)
class UnevenDashes:
    """Dashes that probably do not keep the stated period.

    Attributes:
        share: the probability of that.
        gaps_m: the likeliest gaps between them, the nearest first.
        said_m: the stated period.
    """

    share: float
    gaps_m: tuple[float, ...]
    said_m: float

    @property
    def text(self) -> str:
        """What is wrong, in one sentence."""
        odd = max(self.gaps_m, key=lambda gap_m: abs(gap_m / self.said_m - 1))
        place = self.gaps_m.index(odd)
        where = f"between dash {place + 1} and dash {place + 2} it is"
        if max(self.gaps_m) - min(self.gaps_m) < 0.01 * self.said_m:
            where = "here it is"
        return (
            f"these dashes do not keep their period of {self.said_m:.4g} m: judging by everything else you "
            f"gave, {where} about {odd:.1f} m, as at the joint of a bridge or where the road was marked "
            "anew. Click dashes elsewhere on the drive, or measure these; until then the intervals are "
            "wider"
        )


@dataclass(frozen=True, slots=True)
class Averaged:
    """The unknowns of the fit, averaged over all possible spacings of the dashes.

    Attributes:
        x: means of the unknowns.
        covariance: covariance of the unknowns.
        uneven: the dashes, if they probably do not keep the stated period.
    """

    x: FloatArray
    covariance: FloatArray
    uneven: UnevenDashes | None


def tells_of_spacing(known: Known) -> bool:
    """Whether anything is known that could contradict the spacing of the dashes."""
    evidence = known.evidence
    told = evidence.scale_px_m is not None or len(evidence.lines) > 1 or bool(evidence.rulers)
    told = told or known.lens is not None or known.priors.count > 0 or evidence.horizon is not None
    return evidence.first_unknown and told


@lru_cache(maxsize=8)
def averaged_over_spacings(known: Known) -> Averaged:
    """Average the fit over the stated spacing and others, weighted by what else is known.

    Args:
        known: what is known; its points are the dashes, counted from the first one. If their period was
            measured, only a single gap may differ.
    """
    evidence = known.evidence
    said = np.array([point.distance_m for point in evidence.points])
    x, covariance = solved(known)
    unknowns, covariances, places = [x], [covariance], [said]
    scores = [math.log(1 - UNEVEN_SHARE) + JointFit(known).log_evidence(x, covariance)]
    for share, moves_m in _other_spacings(said, evidence.period_sigma_m is not None):
        slipped = JointFit(known, slip=Slip(tuple(moves_m.tolist()), UNEVEN_SIGMA))
        try:
            there, spread = slipped.solve(start=x)
            score = math.log(share) + slipped.log_evidence(there, spread)
        except (UserError, np.linalg.LinAlgError):
            continue
        unknowns.append(there)
        covariances.append(spread)
        places.append(said + there[SLIP] * moves_m)
        scores.append(score)
    weights = np.exp(np.array(scores) - max(scores))
    weights /= weights.sum()
    mean = weights @ np.array(unknowns)
    off = np.array(unknowns) - mean
    total = np.einsum("j,jkl->kl", weights, np.array(covariances)) + np.einsum(
        "j,jk,jl->kl", weights, off, off
    )
    uneven = None
    if 1 - weights[0] > SPOKEN_SHARE:
        likeliest = places[1 + int(np.argmax(weights[1:]))]
        gaps_m = tuple(np.diff(np.sort(likeliest)).tolist())
        uneven = UnevenDashes(float(1 - weights[0]), gaps_m, float(np.diff(np.sort(said)).min()))
    return Averaged(mean, total, uneven)


def uneven_dashes(known: Known) -> UnevenDashes | None:
    """The dashes, if they probably do not keep the stated period; else None."""
    if not tells_of_spacing(known):
        return None
    try:
        return averaged_over_spacings(known).uneven
    except UserError:
        return None


def _other_spacings(said_m: FloatArray, measured: bool) -> list[tuple[float, FloatArray]]:
    """Probability of each other spacing, and how far a slip of 1 moves the dashes in it."""
    ordered_m = np.sort(said_m)
    gaps_m = [float(far - near) for near, far in pairwise(ordered_m)]
    if len(said_m) < FEWEST_DASHES or min(gaps_m) <= 0:
        return []  # two dashes tell nothing of their spacing
    found = [] if measured else [(UNEVEN_SHARE / 2, said_m)]
    for near_m, gap_m in zip(ordered_m, gaps_m, strict=False):
        found.append((UNEVEN_SHARE / 2 / len(gaps_m), np.where(said_m > near_m, gap_m, 0.0)))
    return found
