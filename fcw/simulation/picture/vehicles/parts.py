"""Parts that vehicles have in common: colours, wheels, lamps, panes, plates."""

from dataclasses import dataclass

import numpy as np

from fcw.simulation.picture.canvas import Bgr, Canvas, Point, Shade, mixed
from fcw.simulation.world.state import VehicleKind

RUBBER: Bgr = (20, 19, 18)
UNDERSIDE: Bgr = (9, 9, 9)
PLASTIC: Bgr = (30, 29, 28)
GLASS: Bgr = (36, 32, 29)
SKY_IN_GLASS: Bgr = (150, 132, 112)
SEAM: Bgr = (14, 14, 14)
LAMP: Bgr = (34, 26, 118)
LAMP_DEEP: Bgr = (20, 14, 66)
LAMP_LIT: Bgr = (70, 52, 255)
LAMP_CORE: Bgr = (178, 172, 255)
CLEAR_LENS: Bgr = (176, 178, 186)
PLATES: tuple[Bgr, ...] = ((226, 228, 230), (214, 222, 224), (150, 208, 222))
CHROME: Bgr = (182, 184, 186)


@dataclass(frozen=True, slots=True)
class Greenhouse:
    """The part of a body above its waist, the same from behind and from the side.

    Attributes:
        waist_m: height of its foot.
        foot: its width there, as a fraction of the body's.
        roof: its width at the roof.
        length_m: from the rear to the foot of the windscreen.
        lean: of the windscreen, metres along for each metre up.
        nose_m: height of the front, from where the bonnet rises to the windscreen's foot.
    """

    waist_m: float
    foot: float
    roof: float
    length_m: float
    lean: float
    nose_m: float


GREENHOUSES: dict[VehicleKind, Greenhouse] = {
    VehicleKind.SALOON: Greenhouse(1.00, 0.90, 0.71, 3.55, 1.45, 0.80),
    VehicleKind.HATCHBACK: Greenhouse(0.98, 0.92, 0.77, 3.05, 1.45, 0.82),
    VehicleKind.VAN: Greenhouse(1.15, 0.97, 0.88, 4.35, 0.62, 1.02),
    VehicleKind.TRUCK: Greenhouse(1.15, 1.0, 1.0, 9.5, 0.0, 1.15),
}


def round_off(canvas: Canvas) -> None:
    """Darken towards the sides: bodies are round, and their flanks do not look at the sky."""
    across = np.linspace(-1, 1, canvas.image.shape[1], dtype=np.float32)
    canvas.image[..., :3] *= (1 - 0.30 * np.abs(across) ** 7)[None, :, None]


def wheels_and_underside(canvas: Canvas, half_m: float, tyre_m: float, top_m: float, floor_m: float) -> None:
    """Tyres on the road at both sides, and the dark between them."""
    canvas.rectangle(-half_m + 0.12, 0.13, half_m - 0.12, floor_m + 0.12, UNDERSIDE)
    canvas.mirrored(
        [
            (half_m - 0.035, 0.05),
            (half_m - 0.06, 0.0),
            (half_m - 0.02 - tyre_m, 0.0),
            (half_m - tyre_m, 0.05),
            (half_m - tyre_m, top_m),
            (half_m - 0.035, top_m),
        ],
        RUBBER,
        ((0.0, 0.6), (0.12, 1.0), (top_m, 0.4)),
    )


def plate(canvas: Canvas, x_m: float, y_m: float, generator: np.random.Generator) -> None:
    """A licence plate around a middle, with the hint of its characters."""
    face = PLATES[int(generator.integers(len(PLATES)))]
    canvas.rectangle(x_m - 0.275, y_m - 0.075, x_m + 0.275, y_m + 0.075, PLASTIC)
    canvas.rectangle(x_m - 0.255, y_m - 0.055, x_m + 0.255, y_m + 0.055, face)
    left = x_m - 0.205
    for _ in range(7):
        width = float(generator.uniform(0.028, 0.045))
        canvas.rectangle(left, y_m - 0.034, left + width, y_m + 0.034, mixed(face, (20, 20, 20), 0.75))
        left += width + 0.018


def lamp(canvas: Canvas, points: list[Point], braking: bool, rounding_m: float = 0.05) -> None:
    """A tail lamp at both sides: a dark red cluster, or lit with a bright core."""
    low, high = min(y for _, y in points), max(y for _, y in points)
    shade: Shade = ((low, 0.75), ((low + high) / 2, 1.15), (high, 0.9))
    canvas.mirrored(points, LAMP_LIT if braking else LAMP, () if braking else shade, 1.0, rounding_m)
    core = _shrunk(points, 0.62)
    canvas.mirrored(core, LAMP_CORE if braking else LAMP_DEEP, (), 0.85 if braking else 0.7, rounding_m)


def _shrunk(points: list[Point], part: float) -> list[Point]:
    x_m, y_m = (sum(values) / len(points) for values in zip(*points, strict=True))
    return [(x_m + (x - x_m) * part, y_m + (y - y_m) * part) for x, y in points]


def third_lamp(canvas: Canvas, y_m: float, half_m: float, braking: bool) -> None:
    """The lamp in the middle, high up."""
    canvas.rectangle(-half_m, y_m - 0.018, half_m, y_m + 0.018, LAMP_LIT if braking else LAMP_DEEP)
    if braking:
        canvas.rectangle(-half_m * 0.8, y_m - 0.008, half_m * 0.8, y_m + 0.008, LAMP_CORE)


def window(canvas: Canvas, points: list[Point], low_m: float, high_m: float, sky: float) -> None:
    """A pane that shows a dark inside below and the sky above; `sky` is how much of it."""
    canvas.fill(points, GLASS, ((low_m, 0.95), (high_m, 0.75)), 1.0, 0.06)
    for part, alpha in ((0.62, 0.35), (0.8, 0.4)):
        edge = low_m + (high_m - low_m) * part
        upper = [(x, max(y, edge)) for x, y in points]
        canvas.fill(upper, SKY_IN_GLASS, (), sky * alpha, 0.03)


def head_rests(canvas: Canvas, y_m: float, generator: np.random.Generator) -> None:
    """Head rests seen through the pane, darker than the light from the windscreen."""
    shift = float(generator.uniform(-0.03, 0.03))
    for x_m in (-0.36 + shift, 0.36 + shift):
        points = [(x_m - 0.13, y_m), (x_m + 0.13, y_m), (x_m + 0.11, y_m + 0.2), (x_m - 0.11, y_m + 0.2)]
        canvas.fill(points, (14, 14, 14), (), 0.75, 0.1)
