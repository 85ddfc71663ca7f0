"""What people have beside a camera: a tape measure, lane dashes of a known period, a parking bay.

Sizes of parking bays:

- Germany: 2.50 x 5.00 m. Empfehlungen fuer Anlagen des ruhenden Verkehrs (EAR).
- United Kingdom: 2.4 x 4.8 m. Manual for Streets, section 8.3.
- Australia: 2.4 x 5.4 m. AS/NZS 2890.1.
- USA: 9 x 18 ft; cities differ, 8.5 to 10 ft and 16 to 20 ft.

Periods of lane dashes, from the near end of one to the near end of the next:

- USA: 10 ft of line and 30 ft of gap, 40 ft. Manual on Uniform Traffic Control Devices (FHWA), section 3A.06.
  A recommendation: states and cities differ.
- California, motorways: 48 ft, as found on the Udacity drives (14.63 m).
- Germany, motorways: 6 m and 12 m, 18 m. Richtlinien fuer die Markierung von Strassen (RMS).
- United Kingdom, lane lines where the limit is above 40 mph: 2 m and 7 m, 9 m. Traffic Signs Manual,
  chapter 5, table 4-2, diagram 1005.1.
"""

import math
from dataclasses import dataclass

from fcw.camera.calibration import Gaussian
from fcw.camera.joint.plates import PLATE_WIDTHS_M
from fcw.errors import UserError
from fcw.units import FEET_PER_METRE

FEWEST_DASHES = 3
FARTHEST_DASH_M = 45.0
"""Beyond the first one: farther ends are blurred, and a warning comes from nearer."""


@dataclass(frozen=True, slots=True)
class Preset:
    """Marks at known distances.

    Attributes:
        name: what a list calls it.
        instruction: what to do, in one or two sentences.
        distances_m: from the reference, in the order of clicking.
    """

    name: str
    instruction: str
    distances_m: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SpacedPreset:
    """Marks a known way apart, of which the first one's distance has still to be measured.

    Attributes:
        name: what a list calls it.
        instruction: what to do, in one or two sentences.
        spacing_m: from one mark to the next.
        count: how many marks.
    """

    name: str
    instruction: str
    spacing_m: float
    count: int

    def starting_at(self, first_m: float) -> Preset:
        """The preset with the first mark at a distance from the reference.

        Raises:
            UserError: it is not a distance.
        """
        if not (math.isfinite(first_m) and first_m > 0):
            raise UserError(
                f"distance of the first mark {first_m:g}: expected a number above 0, "
                "metres along the road to its near end"
            )
        distances_m = tuple(round(first_m + k * self.spacing_m, 4) for k in range(self.count))
        return Preset(self.name, self.instruction, distances_m)


def _tape(*distances_m: float, advice: str) -> Preset:
    numbers = ", ".join(f"{distance_m:g}" for distance_m in distances_m)
    return Preset(
        f"Tape measure: {numbers} m",
        f"Lay the tape straight ahead and put something flat on the road at {numbers} m. "
        f"Click the near edge of each, the nearest first. {advice}",
        distances_m,
    )


def _tape_feet(*distances_ft: float) -> Preset:
    numbers = ", ".join(f"{distance_ft:g}" for distance_ft in distances_ft)
    return Preset(
        f"Tape measure: {numbers} ft",
        f"Lay the tape straight ahead and put something flat on the road at {numbers} ft. "
        "Click the near edge of each, the nearest first.",
        tuple(round(distance_ft / FEET_PER_METRE, 4) for distance_ft in distances_ft),
    )


def dashes(where: str, period_m: float) -> SpacedPreset:
    """Lane dashes that repeat so."""
    count = max(math.floor(FARTHEST_DASH_M / period_m + 1e-9) + 1, FEWEST_DASHES)
    return SpacedPreset(
        f"{where}: every {period_m:.4g} m",
        f"Click the near ends of {FEWEST_DASHES} dashes or more of one line that follow each other, the "
        "nearest first. If you can, measure or pace the way to the first one: else the height decides.",
        period_m,
        count,
    )


TAPE_PRESETS = (
    _tape(4.0, 5.0, 7.0, advice="Far distances stay uncertain: add a far mark if you can."),
    _tape(5.0, 10.0, 20.0, advice="Good to about 40 m."),
    _tape_feet(15.0, 30.0, 65.0),
)
"""Marks whose distances are known."""

DASH_PRESETS = (
    dashes("USA", 40 / FEET_PER_METRE),
    dashes("California motorways", 48 / FEET_PER_METRE),
    dashes("Germany, motorways", 18.0),
    dashes("Britain, above 40 mph", 9.0),
)
"""Marks a known way apart, the first of which has to be measured."""

PLATE_PRESETS = {
    "EU, Britain: 520 mm": PLATE_WIDTHS_M["eu"],
    "USA, Canada, Mexico: 12 in": PLATE_WIDTHS_M["us"],
    "Japan: 330 mm": PLATE_WIDTHS_M["jp"],
    "Australia: 372 mm": PLATE_WIDTHS_M["au"],
}
"""Widths of number plates."""

BAY_WIDTH_SIGMA_M, BAY_DEPTH_SIGMA_M = 0.10, 0.20
"""Of bays that are to be of a rule's size: rules say the least, builders round, paint is a hand wide."""


@dataclass(frozen=True, slots=True)
class RectanglePreset:
    """A rectangle that is painted by a rule.

    Attributes:
        name: what a list calls it.
        sides_m: both sides, and how far they stray from the rule.
    """

    name: str
    sides_m: tuple[Gaussian, Gaussian]


def _bay(where: str, width_m: float, depth_m: float, stray: float = 1.0) -> RectanglePreset:
    sides_m = (Gaussian(width_m, stray * BAY_WIDTH_SIGMA_M), Gaussian(depth_m, stray * BAY_DEPTH_SIGMA_M))
    return RectanglePreset(f"Parking bay, {where}: {width_m:.2f} x {depth_m:.2f} m", sides_m)


RECTANGLE_PRESETS = (
    _bay("Germany", 2.5, 5.0),
    _bay("Britain", 2.4, 4.8),
    _bay("Australia", 2.4, 5.4),
    _bay("USA", round(9 / FEET_PER_METRE, 2), round(18 / FEET_PER_METRE, 2), stray=2.0),
)
"""Bays square to the aisle. A taped side is far better than any of them."""
