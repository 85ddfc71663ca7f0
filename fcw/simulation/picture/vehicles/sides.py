"""What vehicles look like from the side and, oncoming, from the front; in the measures of `VEHICLE_SIZES`."""

import numpy as np

from fcw.simulation.picture.canvas import Bgr, Canvas, FloatImage, Point, Shade, mixed
from fcw.simulation.picture.vehicles.parts import (
    CHROME,
    GLASS,
    GREENHOUSES,
    PLASTIC,
    RUBBER,
    SEAM,
    SKY_IN_GLASS,
    UNDERSIDE,
    plate,
    wheels_and_underside,
)
from fcw.simulation.world.state import VEHICLE_SIZES, VehicleKind

SIDE_PIXELS_PER_METRE = 80
"""Sides are seen at a slant."""
SIDE_GLASS: Bgr = (84, 80, 74)
"""At a slant panes mirror what stands beside the road."""
RIM: Bgr = (120, 121, 122)
LENS: Bgr = (255, 255, 252)
LENS_DARK: Bgr = (92, 90, 86)


def side_texture(kind: VehicleKind, color: Bgr) -> FloatImage:
    """A side with the rear at its left: (rows, columns, 4), as long and high as the vehicle.

    It is painted in two planes: upright below the waist of `GREENHOUSES`, leaning above it.
    """
    size = VEHICLE_SIZES[kind]
    canvas = Canvas(size.length_m, size.height_m, SIDE_PIXELS_PER_METRE)
    if kind is VehicleKind.TRUCK:
        _truck_side(canvas, color)
    else:
        _car_side(canvas, kind, color)
    return canvas.finished()


def _car_side(canvas: Canvas, kind: VehicleKind, color: Bgr) -> None:
    size, house = VEHICLE_SIZES[kind], GREENHOUSES[kind]
    half, waist, top = size.length_m / 2, house.waist_m, size.height_m
    is_van = kind is VehicleKind.VAN
    radius, front_axle = 0.33 + 0.02 * is_van, half - size.overhang_m
    rear_axle = -front_axle
    windscreen = -half + house.length_m
    slope = house.lean * (top - waist)
    canvas.rectangle(-half + 0.25, 0.14, half - 0.3, 0.4, UNDERSIDE, (), 0.9)
    canvas.rectangle(-half, size.clearance_m, rear_axle, 0.4, UNDERSIDE)
    shade: Shade = (
        *((0.2, 0.3), (0.34, 0.42), (0.55, 0.6), (0.7, 0.72), (0.78, 0.9), (0.8, 0.68)),
        *((waist - 0.1, 0.82), (waist, 1.1)),
    )
    nose = house.nose_m - 0.1
    body = [(-half, 0.3), (half - 0.05, 0.24), (half, 0.45), (half - 0.02, nose), (half - 0.25, nose + 0.1)]
    body += [(windscreen, waist), (-half, waist)]
    canvas.fill(body, color, shade)
    canvas.fill(
        [
            (-half, waist - 0.01),
            (windscreen, waist - 0.01),
            (windscreen - slope, top - 0.02),
            (windscreen - slope - 0.3, top),
            (-half, top),
        ],
        color,
        ((waist, 0.75), (top - 0.12, 0.85), (top - 0.04, 1.1)),
    )
    high = top - 0.12
    lean = slope * (high - waist) / (top - waist)
    panes: list[tuple[float, float]] = [(-half + 0.35, -0.42), (-0.34, windscreen - 0.42)]
    if is_van:
        panes = [(windscreen - 1.35, windscreen - 0.3)]
    for index, (left, right) in enumerate(panes):
        last = index == len(panes) - 1
        points: list[Point] = [(left, waist + 0.03), (right + (0.3 if last else 0.0), waist + 0.03)]
        points += [(right + 0.35 - lean if last else right, high), (left + (0.15 if index == 0 else 0), high)]
        canvas.fill(points, SIDE_GLASS, ((waist, 0.8), (high, 1.25)), 1.0, 0.04)
        upper = [(x, max(y, waist + 0.22)) for x, y in points]
        canvas.fill(upper, SKY_IN_GLASS, (), 0.3, 0.03)
    for x_m in (-half + 1.35, -0.38, windscreen - 0.45):
        canvas.rectangle(x_m - 0.008, 0.36, x_m + 0.008, waist, SEAM, (), 0.8)
    for x_m in (-0.75, 0.3):
        canvas.rectangle(x_m, waist - 0.16, x_m + 0.2, waist - 0.125, mixed(color, (20, 20, 20), 0.5))
    canvas.rectangle(-half, waist - 0.33, -half + 0.22, waist - 0.1, (30, 24, 105))
    for axle in (rear_axle, front_axle):
        _wheel(canvas, axle, radius)


def _truck_side(canvas: Canvas, color: Bgr) -> None:
    size, floor = VEHICLE_SIZES[VehicleKind.TRUCK], 1.15
    half, top, axle_m = size.length_m / 2, size.height_m, size.length_m / 2 - size.overhang_m
    canvas.rectangle(-half, 0.55, half - 0.3, floor, (26, 26, 27), ((0.5, 0.5), (floor, 1.2)))
    canvas.rectangle(-half + 2.6, 0.42, half - 2.6, floor - 0.1, (88, 88, 90), ((0.4, 0.7), (1.0, 1.0)))
    canvas.rectangle(-half, floor, half - 2.15, top, color, ((floor, 0.62), (3.3, 0.85), (top, 1.0)))
    canvas.rectangle(-half, floor, half - 2.15, floor + 0.08, CHROME, (), 0.7)
    canvas.fill(
        [(half - 2.05, 0.5), (half, 0.5), (half, 1.7), (half - 0.25, 2.9), (half - 2.05, 3.0)],
        mixed(color, (70, 40, 40), 0.4),
        ((0.5, 0.6), (2.0, 0.85), (3.0, 1.05)),
    )
    canvas.fill([(half - 1.2, 1.8), (half - 0.15, 1.8), (half - 0.35, 2.6), (half - 1.2, 2.6)], GLASS)
    for axle in (-axle_m, axle_m):
        _wheel(canvas, axle, 0.5)


def _wheel(canvas: Canvas, axle_m: float, radius_m: float) -> None:
    canvas.disc(axle_m, radius_m + 0.03, radius_m + 0.06, (8, 8, 8))
    canvas.disc(axle_m, radius_m, radius_m, RUBBER)
    canvas.disc(axle_m, radius_m, 0.64 * radius_m, RIM)
    for angle in np.linspace(0, 2 * np.pi, 5, endpoint=False):
        x_m, y_m = axle_m + 0.4 * radius_m * np.cos(angle), radius_m + 0.4 * radius_m * np.sin(angle)
        canvas.disc(x_m, y_m, 0.14 * radius_m, (40, 40, 41))


def front_texture(kind: VehicleKind, color: Bgr, seed: int) -> FloatImage:
    """The front: (rows, columns, 4) BGRA, colours multiplied by alpha, as wide and high as the vehicle."""
    size = VEHICLE_SIZES[kind]
    canvas = Canvas(size.width_m, size.height_m)
    generator = np.random.default_rng(seed)
    if kind is VehicleKind.TRUCK:
        _truck_front(canvas, color, generator)
    else:
        _car_front(canvas, kind, color, generator)
    return canvas.finished()


def _car_front(canvas: Canvas, kind: VehicleKind, color: Bgr, generator: np.random.Generator) -> None:
    size, house = VEHICLE_SIZES[kind], GREENHOUSES[kind]
    half, waist, top = size.width_m / 2, house.waist_m, size.height_m
    foot, roof = house.foot * half, house.roof * half
    nose = waist - 0.22
    wheels_and_underside(canvas, half, 0.22, 0.42, 0.26)
    canvas.fill(
        [
            (-foot, waist - 0.05),
            (foot, waist - 0.05),
            (roof + 0.05, top - 0.08),
            (roof - 0.1, top),
            (-roof + 0.1, top),
            (-roof - 0.05, top - 0.08),
        ],
        color,
        ((waist, 0.7), (top - 0.1, 0.95), (top, 1.2)),
    )
    screen = [
        (-foot + 0.07, waist),
        (foot - 0.07, waist),
        (roof - 0.03, top - 0.1),
        (-roof + 0.03, top - 0.1),
    ]
    canvas.fill(screen, GLASS, ((waist, 1.1), (top, 0.9)), 1.0, 0.06)
    canvas.fill([(x, max(y, waist + 0.18)) for x, y in screen], SKY_IN_GLASS, (), 0.3, 0.05)
    canvas.fill(
        [
            (-half + 0.04, 0.24),
            (half - 0.04, 0.24),
            (half, 0.4),
            (half, nose),
            (half - 0.06, waist - 0.06),
            (foot - 0.08, waist + 0.03),
            (-foot + 0.08, waist + 0.03),
            (-half + 0.06, waist - 0.06),
            (-half, nose),
            (-half, 0.4),
        ],
        color,
        ((0.24, 0.4), (0.5, 0.75), (nose - 0.02, 0.95), (nose, 1.1), (waist, 1.45)),
    )
    canvas.fill(
        [(-0.46, nose - 0.16), (0.46, nose - 0.16), (0.5, nose), (-0.5, nose)], (16, 16, 16), (), 1, 0.04
    )
    for y_m in (nose - 0.11, nose - 0.05):
        canvas.rectangle(-0.45, y_m, 0.45, y_m + 0.015, CHROME, (), 0.6)
    canvas.disc(0.0, nose - 0.06, 0.055, CHROME)
    lamp = [(0.52, nose - 0.13), (half - 0.06, nose - 0.08), (half - 0.03, nose + 0.06), (0.56, nose + 0.0)]
    canvas.mirrored(lamp, LENS_DARK, (), 1.0, 0.03)
    canvas.mirrored(
        [(0.6, nose - 0.09), (half - 0.14, nose - 0.06), (half - 0.14, nose + 0.01), (0.62, nose - 0.03)],
        LENS,
        (),
        1.0,
        0.03,
    )
    canvas.fill([(-0.6, 0.3), (0.6, 0.3), (0.54, 0.45), (-0.54, 0.45)], PLASTIC, ((0.3, 0.5), (0.45, 0.9)))
    canvas.mirrored(
        [(half - 0.22, 0.36), (half - 0.1, 0.36), (half - 0.1, 0.44), (half - 0.22, 0.44)], LENS_DARK
    )
    plate(canvas, 0.0, 0.5, generator)


def _truck_front(canvas: Canvas, color: Bgr, generator: np.random.Generator) -> None:
    half, top = 1.25, 3.60
    canvas.rectangle(-half, 1.2, half, top, color, ((1.2, 0.7), (top, 1.1)))
    wheels_and_underside(canvas, half, 0.32, 0.9, 0.45)
    cab = mixed(color, (70, 40, 40), 0.4)
    canvas.fill(
        [(-half, 0.5), (half, 0.5), (half, 2.6), (half - 0.12, 2.95), (-half + 0.12, 2.95), (-half, 2.6)],
        cab,
        ((0.5, 0.5), (1.4, 0.9), (2.9, 1.15)),
    )
    canvas.fill(
        [(-1.1, 1.72), (1.1, 1.72), (1.04, 2.55), (-1.04, 2.55)], GLASS, ((1.7, 1.2), (2.5, 1.0)), 1, 0.08
    )
    canvas.fill([(-1.1, 2.1), (1.1, 2.1), (1.04, 2.55), (-1.04, 2.55)], SKY_IN_GLASS, (), 0.35, 0.06)
    canvas.rectangle(-0.8, 0.95, 0.8, 1.6, (18, 18, 18))
    for y_m in np.arange(1.0, 1.55, 0.12):
        canvas.rectangle(-0.78, float(y_m), 0.78, float(y_m) + 0.04, (70, 70, 72))
    canvas.mirrored([(0.82, 0.65), (1.18, 0.65), (1.18, 0.85), (0.82, 0.85)], LENS, (), 1.0, 0.04)
    canvas.rectangle(-half, 0.45, half, 0.58, PLASTIC)
    plate(canvas, 0.0, 0.68, generator)
