"""What the simulated surfaces look like: vehicles drawn in metres with shading, trees, posts, the ground."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

FloatImage = NDArray[np.float32]
Bgr = tuple[float, float, float]

SHOULDER_WIDTH = 0.94
"""Width of the body at the foot of the windows, of the whole."""
PIXELS_PER_METRE = 200
"""Finer than the picture shows a vehicle 6 m away."""
SUPERSAMPLING = 2
LANE_WIDTH_M = 3.6
DASH_M, DASH_PERIOD_M = 4.0, 12.0
MARKING_WIDTH_M = 0.14
ROAD_EDGE_M = 7.8
"""Three lanes and the shoulders: half the width of the asphalt."""
GLASS: Bgr = (46, 42, 38)
RUBBER: Bgr = (24, 23, 22)
PLATE: Bgr = (225, 228, 230)
LAMP: Bgr = (38, 30, 150)
LAMP_LIT: Bgr = (120, 110, 255)


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """Shape and colour of a vehicle.

    Attributes:
        width_m: of the rear.
        height_m: of the roof above the road.
        length_m: from the rear to the front.
        cabin_length_m: from the rear to the foot of the windscreen.
        roof_width: width of the roof as a fraction of the body's.
        waist_m: height of the lower edge of the windows.
        color: of the paint, BGR 0 to 255.
    """

    width_m: float
    height_m: float
    length_m: float
    cabin_length_m: float
    roof_width: float
    waist_m: float
    color: Bgr


class _Canvas:
    """A (rows, columns, 4) BGRA picture, alpha 0 to 1, addressed in metres: x from the middle, y up."""

    def __init__(self, width_m: float, height_m: float) -> None:
        self._scale = PIXELS_PER_METRE * SUPERSAMPLING
        self._size = (round(width_m * self._scale), round(height_m * self._scale))
        self.image: FloatImage = np.zeros((self._size[1], self._size[0], 4), np.float32)

    def polygon(self, points_m: list[tuple[float, float]], color: Bgr) -> None:
        """Fill a polygon with an opaque colour."""
        width, height = self._size
        corners = [[width / 2 + x * self._scale, height - y * self._scale] for x, y in points_m]
        cv2.fillPoly(self.image, [np.round(corners).astype(np.int32)], (*color, 1.0))

    def rectangle(self, x_m: float, y_m: float, width_m: float, height_m: float, color: Bgr) -> None:
        """Fill a rectangle given by its lower left corner."""
        right, top = x_m + width_m, y_m + height_m
        self.polygon([(x_m, y_m), (right, y_m), (right, top), (x_m, top)], color)

    def shade_rows(self, low_m: float, high_m: float, low_factor: float, high_factor: float) -> None:
        """Multiply what is between two heights by factors from the lower to the upper one."""
        height = self._size[1]
        top, bottom = round(height - high_m * self._scale), round(height - low_m * self._scale)
        rows = self.image[max(top, 0) : bottom]
        rows[..., :3] *= np.linspace(high_factor, low_factor, len(rows), dtype=np.float32)[:, None, None]

    def finished(self) -> FloatImage:
        """The picture at its final resolution, colours multiplied by alpha."""
        self.image[..., :3] *= self.image[..., 3:]
        size = (self._size[0] // SUPERSAMPLING, self._size[1] // SUPERSAMPLING)
        return np.asarray(cv2.resize(self.image, size, interpolation=cv2.INTER_AREA), np.float32)


def rear_texture(body: Body, braking: bool) -> FloatImage:
    """The rear: (rows, columns, 4) BGRA, colours multiplied by alpha, as wide and high as the vehicle."""
    canvas = _Canvas(body.width_m, body.height_m)
    half, waist, top = body.width_m / 2, body.waist_m, body.height_m
    shoulder, roof = SHOULDER_WIDTH * half, body.roof_width * half
    sill = 0.26
    for side in (-1, 1):
        canvas.rectangle(side * (half - 0.16) - 0.115, 0.0, 0.23, 0.36, RUBBER)
    # Between the wheels one looks at the dark underside.
    canvas.rectangle(-half + 0.2, 0.12, 2 * half - 0.4, 0.2, (12, 12, 12))
    outline = [(-half, sill + 0.1), (-half + 0.08, sill), (half - 0.08, sill), (half, sill + 0.1)]
    outline += [(half, waist - 0.18), (shoulder, waist), (-shoulder, waist), (-half, waist - 0.18)]
    canvas.polygon(outline, body.color)
    canvas.polygon(
        [
            (-shoulder, waist),
            (shoulder, waist),
            (roof + 0.05, top - 0.06),
            (roof - 0.05, top),
            (-roof + 0.05, top),
            (-roof - 0.05, top - 0.06),
        ],
        body.color,
    )
    # Paint reflects the sky above and the road below; the waist is an edge between the two.
    canvas.shade_rows(sill, waist - 0.12, 0.45, 0.95)
    canvas.shade_rows(waist - 0.12, waist, 1.25, 1.35)
    canvas.shade_rows(waist, top, 0.8, 1.15)
    inset = 0.09
    canvas.polygon(
        [
            (-shoulder + inset, waist + 0.04),
            (shoulder - inset, waist + 0.04),
            (roof - inset, top - 0.11),
            (-roof + inset, top - 0.11),
        ],
        GLASS,
    )
    canvas.shade_rows(waist + 0.04, top - 0.11, 0.8, 1.7)
    canvas.rectangle(-half + 0.02, sill + 0.13, 2 * half - 0.04, 0.03, (20, 20, 20))
    canvas.rectangle(-half * 0.75, waist - 0.06, half * 1.5, 0.015, (25, 25, 25))
    lamp = LAMP_LIT if braking else LAMP
    for side in (-1, 1):
        inner, outer = side * (half - 0.36), side * (half - 0.02)
        low, high = waist - 0.34, waist - 0.12
        canvas.polygon([(inner, low), (outer, low), (outer, high), (inner, high - 0.03)], lamp)
        canvas.polygon(
            [(inner, low), (inner + side * 0.1, low), (inner + side * 0.1, low + 0.06), (inner, low + 0.06)],
            (170, 175, 190),
        )
    if braking:
        canvas.rectangle(-0.16, waist + 0.05, 0.32, 0.035, LAMP_LIT)
    canvas.rectangle(-0.27, waist - 0.36, 0.54, 0.13, (30, 30, 30))
    canvas.rectangle(-0.26, waist - 0.35, 0.52, 0.11, PLATE)
    columns = np.linspace(-1, 1, canvas.image.shape[1], dtype=np.float32)
    canvas.image[..., :3] *= (1 - 0.35 * columns**6)[None, :, None]
    return canvas.finished()


def body_side_texture(body: Body) -> FloatImage:
    """A side below the windows, the rear at its left: (rows, columns, 4), as long as the vehicle."""
    canvas = _Canvas(body.length_m, body.waist_m)
    half, waist = body.length_m / 2, body.waist_m
    canvas.polygon(
        [(-half, 0.26), (half, 0.3), (half, waist - 0.25), (half - 0.2, waist - 0.12), (-half, waist)],
        body.color,
    )
    canvas.shade_rows(0.2, waist, 0.35, 0.8)
    canvas.rectangle(-half, waist - 0.32, body.length_m, 0.015, (25, 25, 25))
    for axle_m in (-half + 0.8, half - 0.85):
        angles = np.linspace(0, 2 * np.pi, 32)
        for radius_m, color in ((0.33, RUBBER), (0.19, (110, 110, 112))):
            points = [(axle_m + radius_m * np.cos(a), 0.33 + radius_m * np.sin(a)) for a in angles]
            canvas.polygon(points, color)
    return canvas.finished()


def cabin_side_texture(body: Body) -> FloatImage:
    """The side's windows and roof, as long as the cabin."""
    length, height = body.cabin_length_m, body.height_m - body.waist_m
    canvas = _Canvas(length, height)
    half, slope = length / 2, 0.7 * height
    canvas.polygon([(-half, 0), (half, 0), (half - slope, height), (-half, height)], body.color)
    canvas.shade_rows(0, height, 0.6, 0.95)
    for left, right in ((-half + 0.12, -0.05), (0.05, half - 0.18)):
        top_right = min(right, half - slope - 0.05)
        canvas.polygon([(left, 0.03), (right, 0.03), (top_right, height - 0.1), (left, height - 0.1)], GLASS)
    return canvas.finished()


def tree_texture(generator: np.random.Generator) -> FloatImage:
    """A tree or bush 4 m wide and 5 m high: many overlapping leaves' clumps, lit from above."""
    canvas = _Canvas(4.0 / 4, 5.0 / 4)
    canvas.rectangle(-0.03, 0.0, 0.06, 0.4, (38, 48, 58))
    height, width = canvas.image.shape[:2]
    for _ in range(220):
        angle, radius = generator.uniform(0, 2 * np.pi), np.sqrt(generator.uniform(0, 1))
        x, y = 0.38 * radius * np.cos(angle), 0.72 + 0.42 * radius * np.sin(angle)
        light = 0.45 + 0.5 * (y - 0.3) + generator.uniform(-0.12, 0.12)
        center = (round(width / 2 + x * width), round(height - y / 1.25 * height))
        color = (48 * light, 92 * light, 74 * light, 1.0)
        cv2.circle(canvas.image, center, int(generator.integers(14, 34)), color, cv2.FILLED)
    return canvas.finished()


def post_texture() -> FloatImage:
    """A roadside post: white with a black band."""
    canvas = _Canvas(0.12, 1.0)
    canvas.rectangle(-0.06, 0.0, 0.12, 1.0, (214, 216, 218))
    canvas.rectangle(-0.06, 0.7, 0.12, 0.18, (32, 32, 34))
    return canvas.finished()


def shadow_texture() -> FloatImage:
    """The soft shadow under a vehicle, for its outline plus a margin: black, only its alpha varies."""
    shadow = np.zeros((160, 80, 4), np.float32)
    shadow[10:150, 9:71, 3] = 0.82
    shadow[..., 3] = cv2.GaussianBlur(shadow[..., 3], (0, 0), 4)
    return shadow


def ground_texture(
    cells: int, length_m: float, half_width_m: float, generator: np.random.Generator
) -> NDArray[np.uint8]:
    """The ground from above: grass, asphalt with wheel tracks, and markings.

    Returns:
        (cells, cells, 3) BGR; rows along the road, columns from the left to the right side.
    """
    along_m = (np.arange(cells) + 0.5) * length_m / cells
    left_m = half_width_m - (np.arange(cells) + 0.5) * 2 * half_width_m / cells

    def noise(sigma_cells: float) -> FloatImage:
        # What is smooth needs few samples.
        coarseness = max(1, round(sigma_cells / 2))
        field = generator.standard_normal((cells // coarseness, cells // coarseness)).astype(np.float32)
        blurred = cv2.GaussianBlur(field, (0, 0), sigma_cells / coarseness)
        full = cv2.resize(blurred / blurred.std(), (cells, cells), interpolation=cv2.INTER_LINEAR)
        return np.asarray(full, np.float32)[..., None]

    grass = np.array((62.0, 108.0, 98.0), np.float32) + noise(2) * 9 + noise(25) * 11
    in_lane_m = (left_m + LANE_WIDTH_M / 2) % LANE_WIDTH_M - LANE_WIDTH_M / 2
    tracks = np.exp(-(((np.abs(in_lane_m) - 0.75) / 0.3) ** 2)).astype(np.float32)[None, :, None]
    asphalt = np.array((112.0, 110.0, 108.0), np.float32) - 7 * tracks + noise(1.2) * 3.5 + noise(30) * 4
    image = np.where((np.abs(left_m) < ROAD_EDGE_M)[None, :, None], asphalt, grass)
    paint = 205 + 8 * noise(3)
    dashed = (along_m % DASH_PERIOD_M < DASH_M)[:, None]
    for line_m, drawn in (
        (-1.5 * LANE_WIDTH_M, np.ones_like(dashed)),
        (-0.5 * LANE_WIDTH_M, dashed),
        (0.5 * LANE_WIDTH_M, dashed),
        (1.5 * LANE_WIDTH_M, np.ones_like(dashed)),
    ):
        marked = drawn & (np.abs(left_m - line_m) < MARKING_WIDTH_M / 2)[None, :]
        image = np.where(marked[..., None], paint, image)
    return np.clip(image, 0, 255).astype(np.uint8)
