"""The kernel that paints the ground.

The road's cross-sections at growing distances are straight lines in the picture. For each column the kernel
climbs from one to the next; between two of them distance along the road and lateral position are linear in
the depth, so that a straight and level road is exact and a bend is as fine as the sections lie. Markings are
integrated over the length and width of road that a pixel sees.
"""

import math

import numpy as np
from numpy.typing import NDArray

from fcw.kernels.jit import kernel

MAP_CELLS = (2048, 512)
"""Cells along and across of the maps that repeat: powers of two."""
MAP_M = (128.0, 24.0)
"""What the asphalt's map covers; the grass uses the same cells for twice the width."""
GRAIN_CELLS = (512, 512)
GRAIN_M = (5.12, 5.12)
WHEEL_TRACK_M = 0.76
"""Wheels roll this far from the middle of a lane."""
GRAVEL_M = 0.9
"""Width of the bare strip beside the asphalt."""


@kernel()
def _sample(cells: NDArray, offset: int, rows: int, columns: int, along: float, across: float) -> float:
    """Bilinear in a repeating map; along and across in periods."""
    y, x = along * rows - 0.5, across * columns - 0.5
    i, j = math.floor(y), math.floor(x)
    fy, fx = np.float32(y - i), np.float32(x - j)
    i, j = i & (rows - 1), j & (columns - 1)
    i2, j2 = (i + 1) & (rows - 1), (j + 1) & (columns - 1)
    a, b = cells[offset + i * columns + j], cells[offset + i * columns + j2]
    c, d = cells[offset + i2 * columns + j], cells[offset + i2 * columns + j2]
    top = a + (b - a) * fx
    return top + (c + (d - c) * fx - top) * fy


@kernel()
def _bump(x: float) -> float:
    """1 at 0, falling smoothly to 0 at -1 and 1."""
    rest = max(1.0 - x * x, 0.0)
    return rest * rest


@kernel()
def _dash_cover(position: float, foot: float, dash: float, period: float) -> float:
    """Part of [position - foot/2, position + foot/2] that lies in [0, dash] of each period, exactly."""
    low, high = (position - foot / 2) / period, (position + foot / 2) / period
    low_n, high_n = math.floor(low), math.floor(high)
    part = dash / period
    painted = (high_n - low_n) * part + min(high - high_n, part) - min(low - low_n, part)
    return painted * period / foot


@kernel()
def _overlap(middle: float, half: float, position: float, foot: float) -> float:
    """Part of [position - foot/2, position + foot/2] within [middle - half, middle + half]."""
    low = max(middle - half, position - foot / 2)
    high = min(middle + half, position + foot / 2)
    return max(high - low, 0.0) / foot


@kernel()
def paint_ground(
    image: NDArray,
    sections: NDArray,
    optics: tuple[float, float],
    edges: tuple[float, float],
    lines: NDArray,
    boxes: NDArray,
    lanes: NDArray,
    asphalt: tuple[NDArray, NDArray],
    grass: tuple[NDArray, NDArray],
    grain: tuple[NDArray, NDArray],
    colors: NDArray,
    haze: NDArray,
    visibility_m: float,
) -> None:
    """Paint every pixel that looks at the ground.

    Args:
        image: (rows, columns, 3) float32 BGR, painted on.
        sections: (n, 8), see `fcw.simulation.picture.road.surface`.
        optics: focal length and column of the optical axis.
        edges: lateral position of the asphalt's right and left edge.
        lines: (n, 4) of each marking: lateral position, half its width, dash (negative: solid), period.
        boxes: (n, 4) of each mark: s, lateral position, half its length along and across.
        lanes: (n, 2) of each lane: lateral position, half its width.
        asphalt: cells and offsets of its deviation of brightness.
        grass: the same.
        grain: the same of both.
        colors: (5, 3) BGR of asphalt, gravel, grass, dry grass and paint.
        haze: BGR of the air.
        visibility_m: contrast falls to 1/e over it.
    """
    height, width = image.shape[0], image.shape[1]
    focal, middle_column = optics
    right_edge, left_edge = edges
    count = sections.shape[0]
    # For each column the two sections between which its row lies: row, depth and lateral position.
    index = np.full(width, -1, np.int64)
    row0, row1 = np.empty(width), np.full(width, 1e9)
    depth0, depth1 = np.empty(width), np.ones(width)
    side0, side1 = np.empty(width), np.zeros(width)
    level_a_rows, level_a_columns, level_b_rows, level_b_columns = 1, 1, 1, 1
    asphalt_at, grass_at, grain_at = asphalt[1][-1, -1], grass[1][-1, -1], grain[1][-1, -1]
    for row in range(height - 1, -1, -1):
        alive = False
        along_foot, across_foot = 1.0, 1.0
        fine, clarity = True, np.float32(0.0)
        for step in range(width + 1):
            # The middle column comes first: it tells how coarse the row is.
            column = width // 2 if step == 0 else step - 1
            while index[column] < count and row1[column] > row:
                index[column] += 1
                k = index[column]
                if k >= count:
                    break
                # The section's point in this column: (X + t dX) / (D + t dD) = u - u0.
                u = column - middle_column
                t = (u * sections[k, 2] - sections[k, 0]) / (sections[k, 3] - u * sections[k, 5])
                depth = sections[k, 2] + t * sections[k, 5]
                if depth < 0.2 or abs(t) > 400.0:
                    continue
                v = (sections[k, 1] + t * sections[k, 4]) / depth
                if v >= row1[column]:
                    continue  # behind a crest
                row0[column], depth0[column], side0[column] = row1[column], depth1[column], side1[column]
                row1[column], depth1[column], side1[column] = v, depth, t + sections[k, 7]
                if row0[column] > 1e8:
                    row0[column] = 1e8
            k = index[column]
            if k >= count or row1[column] > row:
                continue
            alive = True
            if row0[column] > 1e7:
                inverse, part = 1.0 / depth1[column], 1.0
                depth = depth1[column]
                s = sections[k, 6]
                side = side1[column]
                rate = 0.05
                s_rate = 1.0
            else:
                rows_between = row0[column] - row1[column]
                inverse0, inverse1 = 1.0 / depth0[column], 1.0 / depth1[column]
                fraction = (row0[column] - row) / rows_between
                inverse = inverse0 + (inverse1 - inverse0) * fraction
                depth = 1.0 / inverse
                between = depth1[column] - depth0[column]
                part = (depth - depth0[column]) / between
                s0 = sections[max(k - 1, 0), 6]
                s = s0 + (sections[k, 6] - s0) * part
                side = side0[column] + (side1[column] - side0[column]) * part
                rate = depth * depth * (inverse0 - inverse1) / rows_between
                s_rate = (sections[k, 6] - s0) / between
            if step == 0:
                along_foot = max(rate * s_rate, 1e-4)
                across_foot = max(depth / focal, 1e-4)
                a = int(min(max(math.log2(along_foot / (MAP_M[0] / MAP_CELLS[0])) + 0.5, 0.0), 11.0))
                b = int(min(max(math.log2(across_foot / (MAP_M[1] / MAP_CELLS[1])) + 0.5, 0.0), 9.0))
                level_a_rows, level_a_columns = MAP_CELLS[0] >> a, MAP_CELLS[1] >> b
                asphalt_at, grass_at = asphalt[1][a, b], grass[1][a, b]
                a = int(min(max(math.log2(along_foot / (GRAIN_M[0] / GRAIN_CELLS[0])) + 0.5, 0.0), 9.0))
                b = int(min(max(math.log2(across_foot / (GRAIN_M[1] / GRAIN_CELLS[1])) + 0.5, 0.0), 9.0))
                level_b_rows, level_b_columns = GRAIN_CELLS[0] >> a, GRAIN_CELLS[1] >> b
                grain_at = grain[1][a, b]
                fine = a < 8 and b < 8
                clarity = np.float32(math.exp(-depth / visibility_m))
                continue
            texture = np.float32(0.0)
            if fine:
                texture = _sample(
                    grain[0], grain_at, level_b_rows, level_b_columns, s / GRAIN_M[0], side / GRAIN_M[1]
                )
            beyond = max(right_edge - side, side - left_edge)
            b_, g_, r_ = np.float32(0), np.float32(0), np.float32(0)
            soft = max(across_foot, 0.03)
            on_road = min(max(0.5 - beyond / soft, 0.0), 1.0)
            if on_road > 0:
                patch = _sample(
                    asphalt[0], asphalt_at, level_a_rows, level_a_columns, s / MAP_M[0], side / MAP_M[1]
                )
                shade = 1.0 + patch + np.float32(0.08) * texture
                for n in range(lanes.shape[0]):
                    offset = side - lanes[n, 0]
                    if abs(offset) < lanes[n, 1]:
                        shade -= 0.08 * _bump((abs(offset) - WHEEL_TRACK_M) / 0.42)
                        shade -= 0.04 * _bump(offset / 0.45)
                # At grazing angles asphalt shows the sky.
                sheen = min(depth * 0.0016, 0.14)
                b_ = colors[0, 0] * shade * (1 + sheen)
                g_ = colors[0, 1] * shade * (1 + sheen)
                r_ = colors[0, 2] * shade * (1 + sheen)
                paint = 0.0
                for n in range(lines.shape[0]):
                    if abs(side - lines[n, 0]) < lines[n, 1] + across_foot:
                        cover = _overlap(lines[n, 0], lines[n, 1], side, across_foot)
                        if lines[n, 2] > 0:
                            cover *= _dash_cover(s, along_foot, lines[n, 2], lines[n, 3])
                        # Wheels and frost have worn it off in places.
                        paint += cover * min(max(0.93 + 1.5 * patch + 0.06 * texture, 0.25), 1.0)
                for n in range(boxes.shape[0]):
                    if abs(side - boxes[n, 1]) < boxes[n, 3] + across_foot:
                        across = _overlap(boxes[n, 1], boxes[n, 3], side, across_foot)
                        paint += across * _overlap(boxes[n, 0], boxes[n, 2], s, along_foot)
                paint = min(paint, 1.0)
                b_ += (colors[4, 0] - b_) * paint
                g_ += (colors[4, 1] - g_) * paint
                r_ += (colors[4, 2] - r_) * paint
            if on_road < 1:
                clump = _sample(
                    grass[0], grass_at, level_a_rows, level_a_columns, s / MAP_M[0], side / (2 * MAP_M[1])
                )
                dry = min(max(0.35 + 1.2 * clump, 0.0), 1.0)
                shade = 1.0 + 0.55 * clump + 0.11 * texture
                bare = min(max((GRAVEL_M - beyond + 1.2 * clump) / 0.5, 0.0), 1.0)
                off = 1 - on_road
                for c in range(3):
                    green = (colors[2, c] + (colors[3, c] - colors[2, c]) * dry) * shade
                    color = green + (colors[1, c] * (1.0 + 0.1 * texture) - green) * bare
                    if c == 0:
                        b_ = b_ * on_road + color * off
                    elif c == 1:
                        g_ = g_ * on_road + color * off
                    else:
                        r_ = r_ * on_road + color * off
            image[row, column, 0] = b_ * clarity + haze[0] * (1 - clarity)
            image[row, column, 1] = g_ * clarity + haze[1] * (1 - clarity)
            image[row, column, 2] = r_ * clarity + haze[2] * (1 - clarity)
        if not alive and row < height // 4:
            break
