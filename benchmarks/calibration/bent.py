"""How often a lens that bends the picture is noticed, and a straight picture accused, of random cameras.

    python benchmarks/calibration/bent.py [--count N]

Cameras as in `random_cameras.py`, turned by some degrees; nine marks in three columns, clicked to a pixel and
each laid to a quarter of a percent, or a pole at each side, clicked at nine places.
"""

import argparse
import math
import sys
from dataclasses import replace

import numpy as np
from random_cameras import CHOSEN_ON, OTHER, SIZE, Population

from fcw.camera.calibration import Gaussian, GroundPoint
from fcw.camera.joint.bent import bent_picture
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.lens.model import Lens
from fcw.camera.straight import Orientation, Straightening, straight_column

NEAREST_M = 6.0
MARKS = [(distance_m, lateral_m) for distance_m in (6.0, 15.0, 30.0) for lateral_m in (-3.0, 0.0, 3.0)]
MARK_ERROR, HEIGHT_SIGMA_M, CLICK_PX = 0.0025, 0.03, 1.0
YAW_SIGMA_DEG, ROLL_SIGMA_DEG = 2.0, 1.0
BENDS = (0.0, -0.25)


def main() -> None:
    """Print how many of each were accused."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--count", type=int, default=500)
    count = parser.parse_args().count
    for population in (CHOSEN_ON, OTHER):
        for name, evidence_of in (("nine marks", _marks), ("two poles", _poles)):
            for bend in BENDS:
                rng, told = np.random.default_rng(0), 0
                for _ in range(count):
                    there = _picture(population, rng, bend)
                    height_m = Gaussian(there.camera.height_m, HEIGHT_SIGMA_M)
                    told += bent_picture(Known(evidence_of(there, rng), SIZE, height_m)) is not None
                sys.stdout.write(f"{population.name}, {name}, k1 {bend:g}: {told / count:.1%} of {count}\n")
                sys.stdout.flush()


def _picture(population: Population, rng: np.random.Generator, bend: float) -> Straightening:
    real = population.seeing(rng, NEAREST_M)
    turned = Orientation(
        math.radians(rng.normal(0, YAW_SIGMA_DEG)), math.radians(rng.normal(0, ROLL_SIGMA_DEG))
    )
    straight = replace(real, principal_column_px=straight_column(real, turned))
    focal_px, middle = real.focal_y_px, (real.principal_column_px, real.principal_row_px)
    lens = Lens("radtan", focal_px, focal_px, *middle, (bend, bend**2, 0.0, 0.0), SIZE)
    return Straightening(straight, turned, lens if bend else None, SIZE)


def _clicked(
    there: Straightening, rng: np.random.Generator, straight: np.ndarray
) -> list[tuple[float, float]]:
    places = there.to_picture(straight) + CLICK_PX * rng.standard_normal(straight.shape)
    return [(float(u), float(v)) for u, v in places if 0 <= u < SIZE.width and 0 <= v < SIZE.height]


def _marks(there: Straightening, rng: np.random.Generator) -> Evidence:
    points = []
    for distance_m, lateral_m in MARKS:
        true_m = distance_m * (1 + MARK_ERROR * rng.standard_normal())
        place = [[there.camera.column_at(lateral_m, true_m), there.camera.row_at(true_m)]]
        points += [GroundPoint(distance_m, v, u) for u, v in _clicked(there, rng, np.array(place))]
    return Evidence(tuple(points))


def _poles(there: Straightening, rng: np.random.Generator) -> Evidence:
    edges = []
    for column_px in (60.0, SIZE.width - 60.0):
        rows_px = np.linspace(40, SIZE.height - 40, 9)
        ends = there.to_straight(np.array([[column_px, rows_px[0]], [column_px, rows_px[-1]]]))
        parts = np.linspace(0, 1, 9)[:, None]
        edges.append(tuple(_clicked(there, rng, ends[0] + parts * (ends[1] - ends[0]))))
    return Evidence(edges=tuple(edge for edge in edges if len(edge) >= 5))


if __name__ == "__main__":
    main()
