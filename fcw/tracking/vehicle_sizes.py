"""The kind of a vehicle, and so the prior of its size, from its box.

The prior of sizes is a sum of Gaussians, one for each kind. The filter keeps the likeliest kind only. As its
estimate of the size is Gaussian, the prior that it started from can be removed again, and the evidence for
every other kind follows in closed form (Alspach & Sorenson 1972, "Nonlinear Bayesian estimation using
Gaussian sum approximations", with one component kept).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fcw.tracking.range.model import RangeModel, VehicleKind

Vector2 = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Swap:
    """How to replace the prior of the present kind by that of another one.

    Attributes:
        kind: index of the new kind.
        precision: to be added to the precisions of log width and log height; may be negative.
        information: to be added to their precision times mean.
    """

    kind: int
    precision: Vector2
    information: Vector2


class SizePrior:
    """The kinds of vehicles a detector finds.

    Args:
        model: has the kinds.
        with_height: whether the detector measures heights. If not, only the width tells the kind.
        at_tyres: whether boxes end at the tyres, which are farther away than the rear by an overhang.
    """

    def __init__(self, model: RangeModel, with_height: bool, at_tyres: bool) -> None:
        kinds: Sequence[VehicleKind] = model.rears + (model.turned if with_height else ())
        self.rear_count = len(model.rears)
        self.log_sizes: list[Vector2] = [(math.log(k.width_m), math.log(k.height_m)) for k in kinds]
        self.sigmas: list[Vector2] = [(k.width_sigma, k.height_sigma) for k in kinds]
        self.overhangs_m = [k.overhang_m if at_tyres else 0.0 for k in kinds]
        self.lengths_m = [k.length_m for k in kinds]
        self._log_shares = [math.log(kind.share) for kind in kinds]
        self._with_height = with_height
        self._precisions: list[Vector2] = [(w**-2, h**-2) for w, h in self.sigmas]

    def first_sight(
        self,
        by_width: Vector2 | None,
        by_height: Vector2 | None,
        row_px: Vector2 | None,
        scale_m_px: float,
    ) -> tuple[int, float]:
        """The likeliest kind of a vehicle just found, and its depth in metres.

        Args:
            by_width: log depth of an object 1 m wide with this box, and its sigma.
            by_height: log depth of an object 1 m high with this box, and its sigma.
            row_px: how far the lower edge is below the horizon, and its sigma including that of the pitch.
            scale_m_px: rows below the horizon times depth.

        Raises:
            ValueError: neither width nor height is given.
        """
        best: tuple[float, int, float] | None = None
        for kind, (share, sizes, sigmas, overhang_m) in enumerate(
            zip(self._log_shares, self.log_sizes, self.sigmas, self.overhangs_m, strict=True)
        ):
            estimates = [
                (one_metre[0] + size, math.hypot(one_metre[1], sigma))
                for one_metre, size, sigma in zip((by_width, by_height), sizes, sigmas, strict=True)
                if one_metre is not None
            ]
            if not estimates:
                raise ValueError("a box without width and height shows no size")
            precision = sum(sigma**-2 for _, sigma in estimates)
            log_depth = sum(value / sigma**2 for value, sigma in estimates) / precision
            log_probability = share
            if len(estimates) == 2:
                apart = estimates[0][0] - estimates[1][0]
                log_probability += _log_normal(apart, estimates[0][1] ** 2 + estimates[1][1] ** 2)
            if row_px is not None:
                expected_px = scale_m_px / (math.exp(log_depth) + overhang_m)
                log_probability += _log_normal(
                    row_px[0] - expected_px, row_px[1] ** 2 + expected_px**2 / precision
                )
            if best is None or log_probability > best[0]:
                best = log_probability, kind, math.exp(log_depth)
        if best is None:
            raise ValueError("the model has no kinds of vehicles")
        return best[1], best[2]

    def likelier(self, kind: int, mean: Vector2, covariance: tuple[Vector2, Vector2]) -> Swap | None:
        """The likeliest kind, as a swap; None if it is the present one.

        There is no hysteresis, because a wrong kind affects all vehicles through their common pitch.

        Args:
            kind: the present kind, whose prior is part of the estimate.
            mean: estimate of log width and log height.
            covariance: covariance of the estimate.
        """
        (p_w, p_wh), (_, p_h) = covariance
        (now_w, now_h), (size_w, size_h) = self._precisions[kind], self.log_sizes[kind]
        if not self._with_height:
            # The height was never measured, so its estimate is still the prior.
            p_wh, p_h = 0.0, 1 / now_h
        determinant = p_w * p_h - p_wh**2
        i_w, i_wh, i_h = p_h / determinant, -p_wh / determinant, p_w / determinant
        mean_h = mean[1] if self._with_height else size_h
        # The information from measurements only, without the prior.
        seen_w = i_w * mean[0] + i_wh * mean_h - now_w * size_w
        seen_h = i_wh * mean[0] + i_h * mean_h - now_h * size_h
        evidence = []
        for share, (q_w, q_h), (m_w, m_h) in zip(
            self._log_shares, self._precisions, self.log_sizes, strict=True
        ):
            if not self._with_height:
                q_h, m_h = now_h, size_h
            j_w, j_h = i_w - now_w + q_w, i_h - now_h + q_h
            y_w, y_h = seen_w + q_w * m_w, seen_h + q_h * m_h
            d = j_w * j_h - i_wh**2
            if j_w <= 0 or d <= 0:
                # The estimate has become less certain than its own prior, so this prior cannot be swapped in.
                evidence.append(-math.inf)
                continue
            fit = (j_h * y_w**2 - 2 * i_wh * y_w * y_h + j_w * y_h**2) / d - q_w * m_w**2 - q_h * m_h**2
            evidence.append(share + 0.5 * (math.log(q_w * q_h / d) + fit))
        best = max(range(len(evidence)), key=evidence.__getitem__)
        if best == kind:
            return None
        (new_w, new_h), (to_w, to_h) = self._precisions[best], self.log_sizes[best]
        return Swap(
            best,
            (new_w - now_w, new_h - now_h),
            (new_w * to_w - now_w * size_w, new_h * to_h - now_h * size_h),
        )


def _log_normal(residual: float, variance: float) -> float:
    """Logarithm of a normal density up to a constant."""
    return -0.5 * (residual**2 / variance + math.log(variance))
