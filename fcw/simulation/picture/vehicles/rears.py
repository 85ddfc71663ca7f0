"""What vehicles look like from behind: drawn in the measures of `VEHICLE_SIZES`, stretched to their own."""

import numpy as np

from fcw.simulation.picture.canvas import Bgr, Canvas, FloatImage, Shade, mixed
from fcw.simulation.picture.vehicles.parts import (
    CHROME,
    CLEAR_LENS,
    LAMP_DEEP,
    PLASTIC,
    RUBBER,
    SEAM,
    UNDERSIDE,
    head_rests,
    lamp,
    plate,
    round_off,
    third_lamp,
    wheels_and_underside,
    window,
)
from fcw.simulation.world.state import VEHICLE_SIZES, VehicleKind


def rear_texture(kind: VehicleKind, color: Bgr, seed: int, braking: bool) -> FloatImage:
    """The rear: (rows, columns, 4) BGRA, colours multiplied by alpha, as wide and high as the vehicle."""
    size = VEHICLE_SIZES[kind]
    canvas = Canvas(size.width_m, size.height_m)
    # Lamps draw no random numbers, so that a braking rear differs in its lamps alone.
    generator = np.random.default_rng(seed)
    {
        VehicleKind.SALOON: _saloon,
        VehicleKind.HATCHBACK: _hatchback,
        VehicleKind.VAN: _van,
        VehicleKind.TRUCK: _truck,
    }[kind](canvas, color, generator, braking)
    round_off(canvas)
    return canvas.finished()


def _saloon(canvas: Canvas, color: Bgr, generator: np.random.Generator, braking: bool) -> None:
    half, top = 0.91, 1.45
    low_plate = bool(generator.uniform() < 0.3)
    slim = float(generator.uniform(0.0, 1.0))
    wheels_and_underside(canvas, half, 0.235, 0.42, 0.3)
    # Greenhouse: roof, pillars and the raked pane, which shows much sky.
    foot, roof = 0.9 * half, 0.66 * half
    canvas.fill(
        [
            (-foot, 0.98),
            (foot, 0.98),
            (roof + 0.05, top - 0.09),
            (roof - 0.07, top),
            (-roof + 0.07, top),
            (-roof - 0.05, top - 0.09),
        ],
        color,
        ((1.0, 0.62), (1.3, 0.75), (1.4, 1.1), (top, 1.2)),
    )
    pane = [
        (-foot + 0.13, 1.02),
        (foot - 0.13, 1.02),
        (roof - 0.07, top - 0.085),
        (-roof + 0.07, top - 0.085),
    ]
    window(canvas, pane, 1.02, top - 0.08, float(generator.uniform(0.15, 0.8)))
    head_rests(canvas, 1.06, generator)
    third_lamp(canvas, 1.055, 0.15, braking)
    # Body: the boot's upper edge shines, its back leans and the bumper bulges.
    shade: Shade = (
        *((0.22, 0.35), (0.36, 0.55), (0.52, 0.7), (0.60, 1.0), (0.63, 1.12), (0.645, 0.72)),
        *((0.80, 0.82), (0.93, 0.95), (0.965, 1.0), (0.985, 1.35), (1.04, 1.25)),
    )
    canvas.fill(
        [
            (-half + 0.05, 0.27),
            (half - 0.05, 0.27),
            (half, 0.36),
            (half, 0.84),
            (half - 0.03, 0.95),
            (half - 0.16, 1.02),
            (0.4, 1.04),
            (-0.4, 1.04),
            (-half + 0.16, 1.02),
            (-half + 0.03, 0.95),
            (-half, 0.84),
            (-half, 0.36),
        ],
        color,
        shade,
    )
    canvas.fill([(-0.62, 0.25), (0.62, 0.25), (0.56, 0.37), (-0.56, 0.37)], PLASTIC, (), 0.95, 0.05)
    canvas.mirrored([(0.42, 0.245), (0.6, 0.245), (0.6, 0.29), (0.42, 0.29)], CHROME, (), 0.6)
    canvas.rectangle(-half + 0.03, 0.635, half - 0.03, 0.648, SEAM, (), 0.85)
    canvas.mirrored([(0.55, 0.65), (0.565, 0.65), (0.60, 0.97), (0.585, 0.97)], SEAM, (), 0.7)
    inner = 0.5 - 0.08 * slim
    high, low = 0.945, 0.72 + 0.06 * slim
    lamp(
        canvas,
        [
            (inner, low + 0.05),
            (half - 0.06, low),
            (half - 0.005, low + 0.06),
            (half - 0.02, high),
            (inner + 0.02, high - 0.02),
        ],
        braking,
    )
    canvas.mirrored(
        [(inner + 0.01, 0.8), (inner + 0.1, 0.8), (inner + 0.1, 0.86), (inner + 0.01, 0.87)], CLEAR_LENS
    )
    canvas.mirrored([(0.66, 0.43), (0.86, 0.43), (0.86, 0.465), (0.66, 0.465)], LAMP_DEEP)
    if generator.uniform() < 0.5:
        canvas.rectangle(-0.32, 0.875, 0.32, 0.9, CHROME, (), 0.8)
    canvas.disc(0.0, 0.93, 0.035, CHROME, 0.9)
    plate(canvas, 0.0, 0.5 if low_plate else 0.79, generator)


def _hatchback(canvas: Canvas, color: Bgr, generator: np.random.Generator, braking: bool) -> None:
    half, top = 0.885, 1.50
    tall = float(generator.uniform(0.0, 1.0))
    wheels_and_underside(canvas, half, 0.22, 0.42, 0.3)
    foot, roof = 0.92 * half, 0.72 * half
    canvas.fill(
        [
            (-half, 0.9),
            (half, 0.9),
            (foot, 1.02),
            (roof + 0.05, top - 0.1),
            (roof - 0.07, top),
            (-roof + 0.07, top),
            (-roof - 0.05, top - 0.1),
            (-foot, 1.02),
        ],
        color,
        ((0.95, 0.8), (1.2, 0.72), (1.38, 0.9), (1.42, 1.15), (top, 1.25)),
    )
    canvas.fill(
        [(-roof - 0.01, 1.385), (roof + 0.01, 1.385), (roof - 0.02, 1.45), (-roof + 0.02, 1.45)],
        color,
        ((1.38, 0.45), (1.42, 1.0), (1.45, 1.2)),
    )
    pane = [(-foot + 0.17, 1.0), (foot - 0.17, 1.0), (roof - 0.06, 1.385), (-roof + 0.06, 1.385)]
    window(canvas, pane, 1.0, 1.385, float(generator.uniform(0.05, 0.55)))
    head_rests(canvas, 1.05, generator)
    canvas.fill([(-0.02, 1.0), (0.3, 1.0), (0.32, 1.015), (-0.02, 1.02)], (10, 10, 10))
    third_lamp(canvas, 1.415, 0.16, braking)
    shade: Shade = (
        *((0.22, 0.35), (0.36, 0.5), (0.50, 0.68), (0.60, 1.02), (0.64, 1.1), (0.655, 0.7)),
        *((0.75, 0.72), (0.88, 0.92), (0.95, 1.05), (0.99, 1.15)),
    )
    canvas.fill(
        [
            (-half + 0.05, 0.27),
            (half - 0.05, 0.27),
            (half, 0.38),
            (half, 0.86),
            (half - 0.05, 0.99),
            (-half + 0.05, 0.99),
            (-half, 0.86),
            (-half, 0.38),
        ],
        color,
        shade,
    )
    canvas.fill([(-0.7, 0.25), (0.7, 0.25), (0.62, 0.4), (-0.62, 0.4)], PLASTIC, (), 0.95, 0.05)
    canvas.mirrored([(0.58, 0.65), (0.592, 0.65), (0.63, 0.99), (0.618, 0.99)], SEAM, (), 0.8)
    canvas.rectangle(-half + 0.03, 0.645, half - 0.03, 0.657, SEAM, (), 0.8)
    high, low = 1.0 + 0.16 * tall, 0.74
    lamp(
        canvas,
        [
            (0.62, low),
            (half - 0.03, low + 0.02),
            (half - 0.005, low + 0.12),
            (half - 0.05 - 0.05 * tall, high),
            (0.66, high - 0.03),
        ],
        braking,
    )
    canvas.mirrored([(0.64, 0.77), (0.82, 0.78), (0.82, 0.815), (0.64, 0.815)], CLEAR_LENS, (), 0.9)
    canvas.mirrored([(0.66, 0.45), (0.82, 0.45), (0.82, 0.48), (0.66, 0.48)], LAMP_DEEP)
    canvas.disc(0.0, 0.93, 0.04, CHROME, 0.9)
    plate(canvas, 0.0, 0.5 if generator.uniform() < 0.35 else 0.8, generator)


def _van(canvas: Canvas, color: Bgr, generator: np.random.Generator, braking: bool) -> None:
    half, top = 0.99, 2.05
    glazed = bool(generator.uniform() < 0.75)
    wheels_and_underside(canvas, half, 0.23, 0.45, 0.34)
    foot, roof = 0.97 * half, 0.86 * half
    shade: Shade = (
        *((0.3, 0.42), (0.45, 0.6), (0.58, 0.8), (0.62, 0.95), (0.9, 0.88), (1.15, 0.95)),
        *((1.2, 1.05), (1.25, 0.85), (1.9, 0.9), (1.98, 1.15), (top, 1.25)),
    )
    canvas.fill(
        [
            (-half + 0.04, 0.32),
            (half - 0.04, 0.32),
            (half, 0.4),
            (half, 1.05),
            (foot, 1.2),
            (roof + 0.02, 1.93),
            (roof - 0.12, top),
            (-roof + 0.12, top),
            (-roof - 0.02, 1.93),
            (-foot, 1.2),
            (-half, 1.05),
            (-half, 0.4),
        ],
        color,
        shade,
    )
    if glazed:
        sky = float(generator.uniform(0.0, 0.45))
        for side in (-1, 1):
            pane = [(side * 0.05, 1.22), (side * 0.78, 1.22), (side * 0.72, 1.83), (side * 0.05, 1.83)]
            window(canvas, pane, 1.22, 1.83, sky)
    else:
        canvas.rectangle(-0.5, 1.3, 0.5, 1.55, mixed(color, (60, 40, 30), 0.5), (), 0.7)
    canvas.rectangle(-0.008, 0.56, 0.008, 1.95, SEAM, (), 0.9)
    canvas.mirrored([(0.82, 0.56), (0.832, 0.56), (0.79, 1.93), (0.778, 1.93)], SEAM, (), 0.7)
    canvas.fill(
        [(-half + 0.01, 0.34), (half - 0.01, 0.34), (half - 0.01, 0.55), (-half + 0.01, 0.55)],
        PLASTIC,
        ((0.34, 0.6), (0.5, 1.2), (0.55, 1.7)),
    )
    lamp(
        canvas,
        [(half - 0.16, 0.66), (half - 0.01, 0.66), (half - 0.01, 1.12), (half - 0.15, 1.14)],
        braking,
        0.02,
    )
    canvas.mirrored(
        [(half - 0.15, 0.80), (half - 0.02, 0.80), (half - 0.02, 0.87), (half - 0.15, 0.87)], CLEAR_LENS
    )
    third_lamp(canvas, 1.945, 0.2, braking)
    canvas.rectangle(0.04, 0.98, 0.2, 1.02, PLASTIC)
    plate(canvas, -0.42 if generator.uniform() < 0.5 else 0.0, 0.76, generator)


def _truck(canvas: Canvas, color: Bgr, generator: np.random.Generator, braking: bool) -> None:
    half, top, floor = 1.25, 3.60, 1.15
    canvas.rectangle(-half + 0.15, 0.3, half - 0.15, floor, UNDERSIDE)
    for outer, inner in ((half - 0.06, half - 0.34), (half - 0.37, half - 0.65)):
        canvas.mirrored(
            [
                (outer, 0.06),
                (outer - 0.03, 0.0),
                (inner + 0.03, 0.0),
                (inner, 0.06),
                (inner, 0.95),
                (outer, 0.95),
            ],
            RUBBER,
            ((0.0, 0.7), (0.2, 1.0), (0.9, 0.5)),
        )
    canvas.mirrored([(0.5, 0.34), (1.22, 0.34), (1.22, 0.95), (0.5, 0.95)], (15, 15, 15), (), 0.9)
    # The under-run bar carries the lamps.
    canvas.rectangle(
        -half + 0.02, 0.5, half - 0.02, 0.64, (70, 70, 72), ((0.5, 0.6), (0.6, 1.1), (0.64, 1.5))
    )
    canvas.rectangle(-half, floor - 0.17, half, floor, (42, 42, 44), ((floor - 0.17, 0.7), (floor, 1.3)))
    canvas.rectangle(-half, floor, half, top, color, ((floor, 0.72), (2.0, 0.86), (3.4, 0.98), (top, 1.1)))
    frame = mixed(color, (120, 120, 120), 0.6)
    for low, high in ((floor, floor + 0.09), (top - 0.12, top)):
        canvas.rectangle(-half, low, half, high, frame, (), 0.9)
    canvas.mirrored([(half - 0.07, floor), (half, floor), (half, top), (half - 0.07, top)], frame, (), 0.9)
    canvas.rectangle(-0.015, floor, 0.015, top - 0.1, SEAM)
    for x_m in (0.22, 0.62):
        canvas.mirrored(
            [(x_m - 0.02, floor), (x_m + 0.02, floor), (x_m + 0.02, top), (x_m - 0.02, top)], CHROME, (), 0.75
        )
    if generator.uniform() < 0.5:
        band = mixed(color, (float(generator.uniform(30, 160)), float(generator.uniform(30, 120)), 90.0), 0.8)
        canvas.rectangle(-0.95, 2.3, 0.95, 2.75, band, (), 0.85)
    lamp(
        canvas,
        [(half - 0.5, 0.74), (half - 0.04, 0.74), (half - 0.04, 0.9), (half - 0.5, 0.9)],
        braking,
        0.02,
    )
    canvas.mirrored(
        [
            (half - 0.09, floor + 0.1),
            (half - 0.03, floor + 0.1),
            (half - 0.03, top - 0.2),
            (half - 0.09, top - 0.2),
        ],
        (40, 40, 150),
        (),
        0.35,
    )
    plate(canvas, 0.0, 0.76, generator)
