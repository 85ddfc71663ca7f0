"""Compares detectors on the same pictures, each by the mean over several models (seeds of training)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fcw.detection.matching import DetectionCurve
from fcw.evaluation.detection.figures import DetectionEvaluation
from fcw.evaluation.detection.intervals import RESAMPLES, Interval, interval

Figure = Callable[[DetectionCurve], float]


def rate_at(fppi: float) -> Figure:
    """The figure "detection rate at a number of false positives per image"."""
    return lambda curve: curve.at_fppi(fppi).detection_rate


class EqualRate(NamedTuple):
    """False positives per image of two detectors at the same detection rate.

    Attributes:
        detection_rate: the rate of the base detector at the given false positives.
        fppi: false positives per image of the detector; None if it does not reach the rate.
        base_fppi: those of the base detector.
    """

    detection_rate: float
    fppi: float | None
    base_fppi: float


@dataclass(frozen=True, slots=True, eq=False)
class SeedMean:
    """One detector with several models on the same pictures and labels.

    Attributes:
        evaluations: one evaluation for each model.
    """

    evaluations: tuple[DetectionEvaluation, ...]

    def mean(self, figure: Figure) -> float:
        """Mean of a figure over the models."""
        return float(np.mean([figure(evaluation.curve) for evaluation in self.evaluations]))

    def values(self, figure: Figure) -> tuple[float, ...]:
        """The figure of each model."""
        return tuple(figure(evaluation.curve) for evaluation in self.evaluations)

    def interval(self, figure: Figure, resamples: int = RESAMPLES, same_clips: bool = False) -> Interval:
        """95 % interval of the mean, with clips and vehicles resampled (see `Grouping.resamples`)."""
        return interval(self._resampled(figure, resamples, same_clips))

    def difference_interval(
        self, base: "SeedMean", figure: Figure, resamples: int = RESAMPLES, same_clips: bool = False
    ) -> Interval:
        """95 % interval of this mean minus another detector's, on the same draws of vehicles and pictures."""
        mine, others = (each._resampled(figure, resamples, same_clips) for each in (self, base))
        return interval(mine - others)

    def at_equal_rate(self, base: "SeedMean", base_fppi: float) -> EqualRate:
        """False positives at the rate that the base has at `base_fppi`; means over the models."""
        rates, mine, others = [], [], []
        for evaluation, other in zip(self.evaluations, base.evaluations, strict=True):
            rate = other.curve.at_fppi(base_fppi).detection_rate
            at, other_at = evaluation.curve.at_rate(rate), other.curve.at_rate(rate)
            rates.append(rate)
            mine.append(None if at is None else at.fppi)
            others.append(0.0 if other_at is None else other_at.fppi)
        reached = [fppi for fppi in mine if fppi is not None]
        return EqualRate(
            float(np.mean(rates)),
            float(np.mean(reached)) if len(reached) == len(mine) else None,
            float(np.mean(others)),
        )

    def _resampled(self, figure: Figure, resamples: int, same_clips: bool) -> np.ndarray:
        grouping = self.evaluations[0].grouping  # of the labels, which all share
        return np.array(
            [
                np.mean([figure(each.matches.curve(*weights)) for each in self.evaluations])
                for weights in grouping.resamples(resamples, same_clips)
            ]
        )
