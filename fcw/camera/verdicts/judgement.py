"""The verdict on the input of a calibration: which mistake, if any, explains it clearly better than noise."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, Priors
from fcw.camera.lens.usual import usual_lens
from fcw.camera.prior_sigmas import ROLL_SIGMA_RAD, TAPE_ERROR
from fcw.camera.straight import Straightening
from fcw.camera.verdicts.evidence import OFFSET, Beliefs, Fits, Rows, fit, log_sum
from fcw.camera.verdicts.hypotheses import (
    POINT_SIGMA_HEIGHTS,
    SHARES,
    Fault,
    Hypothesis,
    hypotheses,
)
from fcw.frame import ImageSize

USUAL_TANGENT, USUAL_TANGENT_SIGMA = 0.05, 0.09
"""Of a dash camera's pitch: 3 degrees down, give or take 5."""
TAPE_SCALES = (0.05, 0.2, 1.0)
"""Each mark is laid with an error of its own, too: one of these parts of the stated error of the tape."""
CAREFUL = (0.6, 0.3, 0.1)
"""Probabilities of these parts for people who take care. With them, the paper's own example, whose middle row
is 3 px off, contains a mistake; with marks that are off by the whole error, it is only imprecise."""
ANYHOW = (0.0, 0.0, 1.0)
"""The same for careless people. A mistake that is likelier than noise even for them is reported; one that is
likelier only for careful people is asked about."""
PROPOSED_ODDS = 3.0
"""Least odds at which a mistake is reported."""
ASKED_ODDS = 1.6
"""Least odds at which a question is asked."""
NAMED_SHARE = 0.75
"""Least probability among all mistakes at which one is named. The points may show that something is wrong,
but not what."""

WORST_SIGMAS = 4.0
"""If a mistake leaves a row farther off than this, something else is wrong too."""
SMALLEST_SIGMA_PX = 0.01
"""Least standard deviation of a click: a file may call its points exact, but nobody clicks as precisely."""


@dataclass(frozen=True, slots=True)
class Suspicion:
    """One mistake that may have been made.

    Attributes:
        fault: kind of mistake.
        probability: its probability among all hypotheses.
        points: indices of the points that are wrong.
        distances_m: distances of all points as they were meant.
        offset_m: fitted distance from the camera forward to the reference.
        period_m: period of the dashes, if it is not the stated one.
        worst_sigmas: misfit of the row that it explains worst.
    """

    fault: Fault
    probability: float
    points: tuple[int, ...]
    distances_m: tuple[float, ...]
    offset_m: float
    period_m: float | None
    worst_sigmas: float


@dataclass(frozen=True, slots=True)
class Judgement:
    """What is probable about the input.

    Attributes:
        as_said: probability that there is nothing but noise.
        suspicions: all mistakes, one of each kind, the likeliest first.
        if_careful: the same if each mark was laid with care, far better than the tape's error.
        least_odds: least odds at which a mistake is reported.
    """

    as_said: float
    suspicions: tuple[Suspicion, ...]
    if_careful: "Judgement | None" = None
    least_odds: float = PROPOSED_ODDS

    @property
    def question(self) -> "Judgement | None":
        """A mistake to ask about, because it is likely only if the marks were laid with care."""
        careful = self.if_careful
        return careful if careful is not None and careful.is_suspect and not self.is_suspect else None

    @property
    def odds(self) -> float:
        """Odds of a mistake against noise."""
        mistaken = sum(s.probability for s in self.suspicions)
        return mistaken / self.as_said if self.as_said else math.inf

    @property
    def is_suspect(self) -> bool:
        """Whether a mistake is clearly likelier than noise."""
        return self.odds > self.least_odds

    @property
    def named(self) -> Suspicion | None:
        """The mistake that explains it, if one is clearly the likeliest."""
        if not self.is_suspect:
            return None
        first = self.suspicions[0]
        stands_out = first.probability > NAMED_SHARE * (1 - self.as_said)
        if stands_out and first.worst_sigmas < WORST_SIGMAS:
            return first
        # That something is wrong is sure; which mistake it is shows best if the marks were laid with care.
        return self.if_careful and self.if_careful.named


def judge(calibration: Calibration, imperial: bool = False) -> Judgement:
    """Judge the points of a calibration, in the straight picture but with the roll not removed.

    Each hypothesis fits its own roll: a roll that was fitted with the mistake would explain it away.
    """
    points = _rolled_points(calibration)
    if not all(math.isfinite(point.row_px) for point in points):
        points = calibration.points  # a camera that has one of them behind it says nothing of where they lie
    return judge_points(
        points,
        calibration.image_size,
        calibration.camera.height_m,
        calibration.reference_offset_m,
        calibration.row_sigma_px,
        calibration.priors,
        calibration.tape_error,
        imperial,
    )


def _rolled_points(calibration: Calibration) -> tuple[GroundPoint, ...]:
    if any(point.column_px is None for point in calibration.points):
        return calibration.straight().points
    level = replace(calibration.orientation, roll_rad=0.0)
    way = Straightening(calibration.camera, level, calibration.lens, calibration.image_size)
    if way.is_identity:
        return calibration.points
    clicked = np.array([(point.column_px, point.row_px) for point in calibration.points], float)
    places = way.to_straight(clicked)
    return tuple(
        GroundPoint(point.distance_m, row_px, column_px)
        for point, (column_px, row_px) in zip(calibration.points, places.tolist(), strict=True)
    )


def judge_points(
    points: Sequence[GroundPoint],
    image_size: ImageSize,
    height_m: float,
    reference_offset_m: float = 0.0,
    row_sigma_px: float = 1.0,
    priors: Priors = Priors(),  # noqa: B008 - immutable
    tape_error: float = TAPE_ERROR,
    imperial: bool = False,
) -> Judgement:
    """Judge points that need not determine a camera; arguments as those of `fcw.camera.solve.calibrate`.

    Args:
        imperial: whether the distances were typed in feet, so that metres may have been meant.
    """
    supposed = hypotheses(points, reference_offset_m, imperial)
    tapes = [tape_error * scale for scale in TAPE_SCALES] if tape_error else [0.0]
    rows = rows_of(points, image_size, height_m)
    fits = fit(rows, beliefs_of(supposed, tapes, image_size, row_sigma_px, priors))
    if not tape_error:
        return _judgement(supposed, fits, (1.0,))
    careful = replace(_judgement(supposed, fits, CAREFUL), least_odds=ASKED_ODDS)
    return replace(_judgement(supposed, fits, ANYHOW), if_careful=careful)


def rows_of(points: Sequence[GroundPoint], image_size: ImageSize, height_m: float) -> Rows:
    """What was clicked, in the form that the evidence needs."""
    middle_px = (image_size.width - 1) / 2
    told = all(point.column_px is not None for point in points)
    return Rows(
        np.array([point.row_px for point in points]),
        np.array([(point.column_px or 0.0) - middle_px if told else 0.0 for point in points]),
        height_m,
        image_size.width / 2,
    )


def _judgement(supposed: Sequence[Hypothesis], fits: Fits, tape_shares: Sequence[float]) -> Judgement:
    """The posterior over the hypotheses, given the probabilities of the errors of marks."""
    with np.errstate(divide="ignore"):
        log_evidence = fits.log_evidence.reshape(len(supposed), -1) + np.log(tape_shares)
    log_posterior = log_sum(log_evidence, axis=1) + np.log([h.share for h in supposed])
    posterior = np.exp(log_posterior - log_sum(log_posterior))
    best_tape = np.argmax(log_evidence, axis=1)
    suspicions = []
    for fault in SHARES.keys() | {Fault.DASHES}:
        places = [k for k, h in enumerate(supposed) if h.fault is fault]
        if fault is Fault.NONE or not places:
            continue
        best = max(places, key=lambda k: posterior[k])
        fitted = best * len(tape_shares) + int(best_tape[best])
        suspicions.append(_suspicion(supposed[best], float(posterior[places].sum()), fits, fitted))
    suspicions.sort(key=lambda s: -s.probability)
    return Judgement(float(posterior[0]), tuple(suspicions))


def _suspicion(hypothesis: Hypothesis, probability: float, fits: Fits, place: int) -> Suspicion:
    return Suspicion(
        hypothesis.fault,
        probability,
        hypothesis.points,
        hypothesis.distances_m,
        float(fits.unknowns[place, OFFSET]),
        hypothesis.period_m,
        float(np.abs(fits.misfits[place]).max()),
    )


def beliefs_of(
    supposed: Sequence[Hypothesis],
    tapes: Sequence[float],
    size: ImageSize,
    row_sigma_px: float,
    priors: Priors,
) -> Beliefs:
    """Each hypothesis with each error of marks, those of one hypothesis next to each other."""
    row_sigma_px = max(row_sigma_px, SMALLEST_SIGMA_PX)
    usual = usual_lens(size, priors)
    view = priors.field_of_view_rad or usual.field_of_view_rad
    axis = priors.principal_row_px or usual.principal_row_px
    assert view is not None
    assert axis is not None
    horizon = priors.horizon_row_px
    means, sigmas, distances, row_sigmas, tape_m = [], [], [], [], []
    for hypothesis in supposed:
        offset_m, offset_sigma_m = hypothesis.offset_m
        loose = hypothesis.axis_sigma_heights
        axis_sigma = axis.sigma if loose is None else loose * size.height
        rows = np.full(len(hypothesis.distances_m), row_sigma_px)
        if hypothesis.loose is not None:
            rows[hypothesis.loose] = math.hypot(row_sigma_px, POINT_SIGMA_HEIGHTS * size.height)
        for tape in tapes:
            means.append((USUAL_TANGENT, view.value, axis.value, offset_m, 0.0))
            sigmas.append((USUAL_TANGENT_SIGMA, view.sigma, axis_sigma, offset_sigma_m, ROLL_SIGMA_RAD))
            distances.append(hypothesis.distances_m)
            row_sigmas.append(rows)
            tape_m.append(tape * np.array(hypothesis.distances_m))
    return Beliefs(
        np.array(distances),
        np.array(row_sigmas),
        np.array(tape_m),
        np.array(means),
        np.array(sigmas),
        _pair(horizon),
    )


def _pair(belief: Gaussian | None) -> tuple[float, float] | None:
    return None if belief is None else (belief.value, belief.sigma)
