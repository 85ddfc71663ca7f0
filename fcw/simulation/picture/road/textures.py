"""What stands beside the road: trees, bushes, posts, signs, rails, walls, concrete."""

import cv2
import numpy as np

from fcw.simulation.picture.canvas import Bgr, Canvas, FloatImage, mixed

STEEL: Bgr = (150, 152, 152)
CONCRETE: Bgr = (146, 152, 156)
RAIL_PANEL_M = 12.0
"""One texture of a rail or wall is as long as this."""
TREE_ASPECT = 0.8


def tree_texture(generator: np.random.Generator, foliage: Bgr, bush: bool = False) -> FloatImage:
    """A tree, 0.8 times as wide as high, or a bush: clumps of leaves, lit from above, with gaps of sky."""
    size = 320
    wide = round(TREE_ASPECT * size) if not bush else round(1.6 * size)
    canvas = Canvas(wide / size, 1.0, size)
    if not bush:
        trunk: Bgr = (38, 46, 54)
        lean = float(generator.uniform(-0.04, 0.04))
        canvas.fill([(-0.028, 0.0), (0.028, 0.0), (0.016 + lean, 0.6), (lean - 0.016, 0.6)], trunk)
        for _ in range(6):
            tip = (float(generator.uniform(-0.16, 0.16)), float(generator.uniform(0.45, 0.72)))
            canvas.fill(
                [(-0.012, 0.28), (0.012, 0.28), (tip[0] + 0.005, tip[1]), (tip[0] - 0.005, tip[1])], trunk
            )
    rows, columns = canvas.image.shape[:2]
    hubs = generator.uniform(-1, 1, (11 if not bush else 12, 2))
    clumps = np.repeat(hubs, 190, axis=0) * (0.72, 0.66) + generator.normal(0, 0.2, (len(hubs) * 190, 2))
    clumps = clumps[np.hypot(*clumps.T) < 1.05]
    clumps = clumps[np.argsort(clumps[:, 1] + generator.normal(0, 0.5, len(clumps)))]
    middle, spread = (0.64, (0.34, 0.32)) if not bush else (0.42, (0.66, 0.42))
    tone = float(generator.uniform(0.85, 1.2))
    for u, v in clumps:
        x, y = columns / 2 + u * spread[0] * rows, rows * (1 - middle - v * spread[1])
        light = tone * (0.62 + 0.38 * v + float(generator.normal(0, 0.16)))
        color = tuple(
            float(channel * max(light, 0.18)) for channel in mixed(foliage, (60, 130, 120), 0.12 * (v + 1))
        )
        radius = int(generator.integers(rows // 200, rows // 52))
        axes = (radius, max(1, round(radius * float(generator.uniform(0.5, 1.0)))))
        cv2.ellipse(
            canvas.image,
            (round(x), round(y)),
            axes,
            float(generator.uniform(0, 180)),
            0,
            360,
            (*color, 1.0),
            -1,
        )
    if bush:
        canvas.rectangle(-0.7, 0.0, 0.7, 0.08, tuple(0.4 * c for c in foliage), (), 0.8)  # pyright: ignore[reportArgumentType]
    return canvas.finished()


def shadow_of_tree(generator: np.random.Generator) -> FloatImage:
    """The dappled shadow of a tree on the ground: black, only its alpha varies, 0 to 1."""
    shadow = np.zeros((96, 96, 4), np.float32)
    for _ in range(90):
        angle, radius = generator.uniform(0, 2 * np.pi), 30 * np.sqrt(generator.uniform())
        at = (round(48 + radius * np.cos(angle)), round(48 + radius * np.sin(angle)))
        cv2.circle(shadow, at, int(generator.integers(4, 12)), (0, 0, 0, 1), -1)
    shadow[..., 3] = cv2.GaussianBlur(shadow[..., 3], (0, 0), 2.2)
    return shadow


def soft_shadow(rows: int, columns: int, margin: int, strength: float) -> FloatImage:
    """A rectangular shadow with soft edges, `margin` cells inside the picture."""
    shadow = np.zeros((rows, columns, 4), np.float32)
    shadow[margin : rows - margin, margin : columns - margin, 3] = strength
    shadow[..., 3] = cv2.GaussianBlur(shadow[..., 3], (0, 0), margin / 2.2)
    return shadow


def post_texture() -> FloatImage:
    """A delineator: white with a slanted black band and a reflector."""
    canvas = Canvas(0.12, 1.0)
    canvas.fill([(-0.06, 0.0), (0.06, 0.0), (0.06, 0.97), (-0.06, 1.0)], (204, 208, 210))
    canvas.fill([(-0.06, 0.66), (0.06, 0.7), (0.06, 0.9), (-0.06, 0.86)], (28, 28, 30))
    canvas.rectangle(-0.02, 0.72, 0.02, 0.84, (60, 130, 215))
    return canvas.finished()


def sign_texture(
    width_m: float, height_m: float, clearance_m: float, generator: np.random.Generator
) -> FloatImage:
    """A road sign on its posts: a direction board, or a warning or speed sign where it is small."""
    canvas = Canvas(width_m, height_m, 64)
    half = width_m / 2
    small = width_m < 1.8 and generator.uniform() < 0.6
    steel = (118, 120, 122)
    for x_m in (0.0,) if small else (-0.35 * width_m, 0.35 * width_m):
        canvas.rectangle(x_m - 0.04, 0.0, x_m + 0.04, clearance_m + 0.1, steel)
    middle = (clearance_m + height_m) / 2
    radius = min(half, (height_m - clearance_m) / 2)
    if small and generator.uniform() < 0.5:
        canvas.disc(0.0, middle, radius, (44, 36, 176))
        canvas.disc(0.0, middle, 0.78 * radius, (226, 228, 230))
        for x_m in (-0.24, 0.16):
            canvas.rectangle(
                x_m * radius - 0.1 * radius,
                middle - 0.35 * radius,
                x_m * radius + 0.24 * radius,
                middle + 0.35 * radius,
                (24, 24, 24),
                (),
                0.9,
            )
    elif small:
        points = [(-radius, middle), (0.0, middle - radius), (radius, middle), (0.0, middle + radius)]
        canvas.fill(points, (20, 20, 20))
        canvas.fill([(0.9 * x, middle + 0.9 * (y - middle)) for x, y in points], (40, 190, 235))
        canvas.rectangle(
            -0.08 * radius, middle - 0.4 * radius, 0.08 * radius, middle + 0.4 * radius, (25, 25, 25)
        )
    else:
        board: Bgr = ((92, 92, 18), (150, 78, 16))[int(generator.integers(2))]
        canvas.rectangle(-half, clearance_m, half, height_m, (214, 216, 216))
        edge = 0.05
        canvas.rectangle(-half + edge, clearance_m + edge, half - edge, height_m - edge, board)
        y_m = height_m - 0.28
        while y_m > clearance_m + 0.3:
            length = float(generator.uniform(0.4, 0.85)) * width_m
            x_m = -half + 0.2
            while x_m < -half + length - 0.15:
                letter = float(generator.uniform(0.08, 0.16))
                canvas.rectangle(x_m, y_m - 0.16, x_m + letter * 0.7, y_m, (206, 208, 208), (), 0.85)
                x_m += letter
            y_m -= 0.42
    return canvas.finished()


def rail_texture(height_m: float) -> FloatImage:
    """A steel guard rail on posts, one panel long."""
    canvas = Canvas(RAIL_PANEL_M, height_m, 40)
    half, top = RAIL_PANEL_M / 2, height_m
    for x_m in np.arange(-half + 1.0, half, 2.0):
        canvas.rectangle(float(x_m) - 0.06, 0.0, float(x_m) + 0.06, top - 0.05, (96, 98, 98))
    shade = (
        (top - 0.33, 0.5),
        (top - 0.28, 1.0),
        (top - 0.22, 0.75),
        (top - 0.17, 0.55),
        (top - 0.12, 1.1),
        (top, 1.15),
    )
    canvas.rectangle(-half, top - 0.33, half, top, STEEL, shade)
    return canvas.finished()


def wall_texture(height_m: float, generator: np.random.Generator) -> FloatImage:
    """A concrete wall, one panel long, streaked by rain."""
    canvas = Canvas(RAIL_PANEL_M, height_m, 40)
    half = RAIL_PANEL_M / 2
    shade = ((0.0, 0.45), (0.07, 0.62), (0.25, 0.78), (height_m - 0.04, 0.86), (height_m, 1.2))
    canvas.rectangle(-half, 0.0, half, height_m, CONCRETE, shade)
    canvas.rectangle(-half, 0.0, -half + 0.04, height_m, (60, 62, 64))
    image = canvas.finished()
    streaks = cv2.GaussianBlur(
        generator.standard_normal(image.shape[:2]).astype(np.float32), (0, 0), sigmaX=1.5, sigmaY=9
    )
    image[..., :3] *= 1 + 0.06 * (streaks / streaks.std())[..., None]
    return image


def concrete_texture(
    generator: np.random.Generator, width_m: float, height_m: float, tone: float
) -> FloatImage:
    """A concrete face with shuttering joints and stains."""
    canvas = Canvas(width_m, height_m, max(4.0, min(24.0, 800 / width_m)))
    canvas.rectangle(
        -width_m / 2, 0, width_m / 2, height_m, CONCRETE, ((0, 0.72 * tone), (height_m, 1.0 * tone))
    )
    for x_m in np.arange(-width_m / 2, width_m / 2, 2.5):
        canvas.rectangle(float(x_m) - 0.03, 0, float(x_m) + 0.03, height_m, (70, 72, 74), (), 0.35)
    image = canvas.finished()
    stains = cv2.GaussianBlur(
        generator.standard_normal(image.shape[:2]).astype(np.float32), (0, 0), sigmaX=3, sigmaY=12
    )
    image[..., :3] *= 1 + 0.035 * (stains / stains.std())[..., None]
    return image
