"""The tracker's constants chosen on all sequences but one, and measured on that one, each in turn.

What a constant was chosen on is no evidence for it. The choice is by the interval score (Gneiting & Raftery
2007, "Strictly proper scoring rules, prediction, and estimation", eq. 43) of the logarithm of the distance:
an interval costs its width, and more where the truth is outside. It asks for small errors and for honesty at
once.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from fcw.evaluation.distance.kitti import (
    DistanceEvaluation,
    DistanceSample,
    measured_vehicles,
    sample_sequence,
    track_numbers,
    track_weights,
)
from fcw.evaluation.distance.kitti_tracking import read_own_motion, read_sequence
from fcw.tracking.range.model import REARS, RangeModel

OUTSIDE_PART = 0.32
"""Of the true distances, outside a 1-sigma interval."""
CAR_WIDTH_SIGMAS = (0.07, 0.09)
CALIBRATION_SIGMAS_DEG = (0.5, 0.7)
UNMODELLED_SIGMAS = (0.03, 0.05)


def candidates() -> dict[str, RangeModel]:
    """The models that are tried, by what is told of them."""
    models = {}
    for width_sigma, pitch_deg, unmodelled in product(
        CAR_WIDTH_SIGMAS, CALIBRATION_SIGMAS_DEG, UNMODELLED_SIGMAS
    ):
        cars = replace(REARS[0], width_sigma=width_sigma)
        models[f"widths of cars {width_sigma:g}, pitch {pitch_deg:g} degrees, unmodelled {unmodelled:g}"] = (
            RangeModel(
                rears=(cars, *REARS[1:]),
                calibration_pitch_sigma_rad=math.radians(pitch_deg),
                unmodelled_sigma=unmodelled,
            )
        )
    return models


def interval_score(samples: Sequence[DistanceSample]) -> float:
    """Mean interval score of the logarithms of the distances, each track counting as much as any other."""
    true, low, high = (np.log([getattr(s, name) for s in samples]) for name in ("true_m", "low_m", "high_m"))
    outside = np.maximum(low - true, 0.0) + np.maximum(true - high, 0.0)
    return float((high - low + 2 / OUTSIDE_PART * outside) @ track_weights(track_numbers(samples)))


def evaluate_left_out(
    folder: Path, names: Sequence[str], box_noise_px: float, seed: int, pitch_error_rad: float = 0.0
) -> tuple[DistanceEvaluation, dict[str, str]]:
    """Measure each sequence with the candidate that is best on the others.

    Args:
        folder: of KITTI tracking.
        names: of the sequences, at least two.
        box_noise_px: as in `evaluate_distance`.
        seed: likewise.
        pitch_error_rad: likewise.

    Returns:
        The evaluation; and what was chosen for each sequence.

    Raises:
        UserError: a file is missing or not as expected.
    """
    models = candidates()
    found: dict[tuple[str, str], tuple[list[DistanceSample], list[tuple[str, int, int]]]] = {}
    measured = 0
    for name in names:
        sequence = read_sequence(folder, name)
        speeds_mps, _ = read_own_motion(folder, name)
        measured += measured_vehicles(sequence)
        for text, model in models.items():
            rng = np.random.default_rng([seed, *name.encode()])
            found[name, text] = sample_sequence(
                sequence, speeds_mps, rng, box_noise_px, (), pitch_error_rad, model
            )
    chosen = {}
    for name in names:
        others = [other for other in names if other != name]
        scores = {
            text: interval_score([sample for other in others for sample in found[other, text][0]])
            for text in models
        }
        chosen[name] = min(scores, key=lambda text: scores[text])
    samples = [sample for name in names for sample in found[name, chosen[name]][0]]
    warnings = [warning for name in names for warning in found[name, chosen[name]][1]]
    return DistanceEvaluation(tuple(samples), tuple(warnings), measured, box_noise_px, seed), chosen
