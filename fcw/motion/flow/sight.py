"""Whether pictures show enough to find vehicles in them: how sharp they are, and how much contrast they have.

The blur of an edge is measured by blurring it once more. With a sigma of a, the steepness falls to s /
sqrt(s^2 + a^2) of what it was, where s is the edge's own sigma, whatever its contrast (Zhuo & Sim 2011,
"Defocus map estimation from a single image"). The steepest edges of a picture are used, as they are the
sharpest things in it.
"""

import math
from collections import deque
from enum import Enum
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

ROWS = (0.4, 0.7)
"""First and last row that are used, as fractions of the height: about the horizon, where vehicles are. Our
bonnet is mostly below, and so is text written by recorders, which is sharp however blurred the rest is."""
LINES, WIDTH = 40, 640
"""About this many rows are used, of pictures reduced by a whole factor to about this width."""
EDGES_PART, FEWEST_EDGES = 0.004, 20
"""Number of steepest edges per pixel that determine the sharpness, and the least number of edges."""
CONTRAST_PART = 0.001
"""Fraction of the pixels, the steepest ones, that determine the contrast."""
AGAIN_PX = 1.0
"""Sigma by which edges are blurred once more."""
WHITE = 250
"""Grey value from which a pixel is white."""
QUARTILE_SIGMAS = 0.3186
"""A quarter of a Gaussian's values are closer to its mean than this many sigmas."""

STEP_NS = 500_000_000
"""Time between two looks."""
LOOKS, FEWEST_LOOKS = 5, 3
"""The median of this many looks counts, so that a wiper or the shadow of a bridge does not."""
MOST_BLUR, LEAST_CONTRAST, LEAST_OVER_NOISE, MOST_WHITE = 1.3 / WIDTH, 9.0, 3.0, 0.5
"""Limits beyond which a picture is soft (blur as a fraction of its width), dark or faint (contrast in grey
values per pixel, or in sigmas of its noise), or overexposed (fraction of white pixels).

Beyond them, a fifth to a third of the small vehicles are lost that the net finds in the same pictures
undegraded (docs/figures/sight.md).
"""
RELEASED = {"blur": 0.9, "contrast": 1.3, "white": 0.8}
"""A note is withdrawn once the value is better than the limit times these factors."""
DARK_BELOW = 60.0
"""Median grey value below which a picture without contrast counts as dark instead of faint."""
LOST_SIGMAS, CAR_HEIGHT_M = 14.0, 1.5
"""Half of the vehicles whose height is this many sigmas of the blur are lost, on cameras that are new to the
net; on those that it was trained on, 10 to 12.5, whichever is left out."""
TOLD_STEP_M = 5
"""The distance at which half are lost is rounded to this. It is known to about a tenth, and finer steps would
flicker."""


class Look(NamedTuple):
    """Properties of one picture.

    Attributes:
        blur: 1-sigma of its sharpest edges, as a fraction of its width; NaN if there are too few edges.
        contrast: slope at its steepest pixels, in grey values per pixel of the small picture.
        brightness: median grey value.
        white: fraction of white pixels.
        noise: 1-sigma of the noise, in grey values.
    """

    blur: float
    contrast: float
    brightness: float
    white: float
    noise: float = 0.0


class PoorSight(Enum):
    """Why vehicles are missed; the value is the beginning of the note."""

    SOFT = "soft picture"
    DARK = "dark picture"
    FAINT = "faint picture"
    OVEREXPOSED = "overexposed picture"


CAUSES = {
    PoorSight.SOFT: "it is blurred, as by a lens that is fogged, dirty or out of focus, or by enlarging",
    PoorSight.DARK: "hardly anything stands out from the dark, or from noise",
    PoorSight.FAINT: "hardly anything stands out, as in fog, against the sun, through misted glass or noise",
    PoorSight.OVEREXPOSED: "most of it is white",
}


class SightWatch:
    """Tells when the pictures of a drive show too little.

    Args:
        focal_part: focal length over the width of the picture; None when unknown, in which case the note does
            not tell from which distance on cars are missed.
    """

    def __init__(self, focal_part: float | None = None) -> None:
        self._focal_part = focal_part
        self._looks: deque[Look] = deque(maxlen=LOOKS)
        self._next_ns: int | None = None
        self._poor: PoorSight | None = None
        self._note = ""

    def see(self, time_ns: int, image: NDArray[np.uint8]) -> str:
        """Update with the next picture, (height, width, 3) BGR.

        Returns:
            The present note; empty if enough can be seen.
        """
        if self._next_ns is None or time_ns >= self._next_ns:
            self._next_ns = time_ns + STEP_NS
            self._looks.append(look_at(image))
            if len(self._looks) >= FEWEST_LOOKS:
                self._judge(Look(*np.median(self._looks, axis=0).tolist()))
        return self._note

    def _judge(self, look: Look) -> None:
        self._poor = poor_sight(look, self._poor)
        self._note = "" if self._poor is None else self._text(self._poor, look.blur)

    def _text(self, poor: PoorSight, blur: float) -> str:
        lost = "vehicles are missed, far ones first"
        if poor is PoorSight.SOFT and self._focal_part is not None:
            distance_m = CAR_HEIGHT_M * self._focal_part / (LOST_SIGMAS * blur)
            told_m = max(round(distance_m / TOLD_STEP_M), 1) * TOLD_STEP_M
            lost = f"half of the cars {told_m} m away are missed, and most beyond"
        return f"{poor.value}, {lost}: {CAUSES[poor]}"


def poor_sight(look: Look, before: PoorSight | None = None) -> PoorSight | None:
    """Why too little can be seen in such pictures; None if enough can be seen.

    Args:
        look: properties of the pictures.
        before: the reason given for the previous pictures, which is kept for a little longer.
    """

    def limit(value: float, name: str, *kinds: PoorSight) -> float:
        return value * (RELEASED[name] if before in kinds else 1.0)

    least = max(LEAST_CONTRAST, LEAST_OVER_NOISE * look.noise)
    if look.contrast < limit(least, "contrast", PoorSight.DARK, PoorSight.FAINT):
        return PoorSight.DARK if look.brightness < DARK_BELOW else PoorSight.FAINT
    if look.white > limit(MOST_WHITE, "white", PoorSight.OVEREXPOSED):
        return PoorSight.OVEREXPOSED
    if look.blur > limit(MOST_BLUR, "blur", PoorSight.SOFT):
        return PoorSight.SOFT
    return None


def look_at(image: NDArray[np.uint8]) -> Look:
    """Properties of a (height, width, 3) BGR picture, by its green, which is most of the brightness."""
    height, width = image.shape[:2]
    first, last = (int(part * height) for part in ROWS)
    factor = max(round(width / WIDTH), 1)
    lines = image[first : last + 1 : max((last - first) // LINES, 1), : width // factor * factor, 1]
    small = cv2.resize(lines, (width // factor, len(lines)), interpolation=cv2.INTER_AREA)
    grey = small.astype(np.float32)
    slopes = cv2.sepFilter2D(grey, -1, _DIFFERENCE, _ONE)
    again = np.abs(cv2.sepFilter2D(slopes, -1, _BLUR, _ONE))
    slopes = np.abs(slopes)
    inner = slopes[:, 1:-1]
    edges = (inner >= slopes[:, :-2]) & (inner > slopes[:, 2:])
    steep, blurred = inner[edges], again[:, 1:-1][edges]
    count, pixels = len(steep), grey.size
    blur = math.nan
    if count >= FEWEST_EDGES:
        most = min(max(round(EDGES_PART * pixels), FEWEST_EDGES), count)
        steepest = np.argpartition(steep, count - most)[count - most :]
        ratio = np.median(steep[steepest] / np.maximum(blurred[steepest], 1e-3))
        blur = AGAIN_PX / math.sqrt(max(float(ratio) ** 2 - 1, 1e-3)) * factor / width
    standing_out = pixels - max(round(CONTRAST_PART * pixels), 1)
    contrast = np.partition(again, standing_out, axis=None)[standing_out]
    bends = np.abs(cv2.sepFilter2D(grey, -1, _SECOND_DIFFERENCE, _ONE))
    quartile = float(np.partition(bends, pixels // 4, axis=None)[pixels // 4])
    noise = quartile / QUARTILE_SIGMAS / float(np.linalg.norm(_SECOND_DIFFERENCE))
    return Look(blur, float(contrast), float(np.median(small)), float(np.mean(small >= WHITE)), noise)


_ONE = np.ones(1, np.float32)
_DIFFERENCE = np.array([-0.5, 0.0, 0.5], np.float32)
_SECOND_DIFFERENCE = np.array([1.0, -2.0, 1.0], np.float32)
_BLUR = cv2.getGaussianKernel(9, AGAIN_PX, cv2.CV_32F)
