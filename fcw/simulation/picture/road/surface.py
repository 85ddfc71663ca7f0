"""The ground: asphalt with its markings, gravel and grass along a road that bends and rises.

`fcw.simulation.picture.road.kernel` says how its pixels are found.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.simulation.picture.canvas import FloatImage
from fcw.simulation.picture.light import Daylight
from fcw.simulation.picture.road.kernel import GRAIN_CELLS, MAP_CELLS, paint_ground
from fcw.simulation.world.state import WorldState

SECTIONS = 170
NEAREST_M, FARTHEST_M = 0.6, 1500.0


@dataclass(frozen=True, slots=True, eq=False)
class _RipMap:
    """A repeating map in all combinations of halved sizes along and across, in one array.

    Attributes:
        cells: every size, one after the other.
        offsets: (levels along, levels across), where each begins.
    """

    cells: FloatImage
    offsets: NDArray[np.int64]

    @classmethod
    def of(cls, full: FloatImage) -> "_RipMap":
        """All sizes of a map whose measures are powers of two."""
        parts: list[FloatImage] = []
        levels = [int(math.log2(cells)) + 1 for cells in full.shape]
        offsets = np.zeros(levels, np.int64)
        start, tall = 0, full
        for i in range(levels[0]):
            wide = tall
            for j in range(levels[1]):
                offsets[i, j] = start
                parts.append(wide.ravel().astype(np.float32))
                start += wide.size
                wide = (wide[:, 0::2] + wide[:, 1::2]) / 2 if wide.shape[1] > 1 else wide
            tall = (tall[0::2] + tall[1::2]) / 2 if tall.shape[0] > 1 else tall
        return cls(np.concatenate(parts), offsets)


class Ground:
    """Paints the ground of one drive.

    Args:
        camera: as calibrated; focal length and principal point never change.
        generator: of the surfaces.
        light: of the drive.
    """

    def __init__(self, camera: GroundPlaneCamera, generator: np.random.Generator, light: Daylight) -> None:
        self._light = light
        self._asphalt = _RipMap.of(_asphalt(generator))
        self._grass = _RipMap.of(_grass(generator))
        self._grain = _RipMap.of(_noise(generator, GRAIN_CELLS, 0.8))
        self._section_m = np.geomspace(NEAREST_M, FARTHEST_M, SECTIONS)
        self._focal_px, self._column_px = camera.focal_y_px, camera.principal_column_px

    def paint(self, image: FloatImage, state: WorldState, camera: GroundPlaneCamera) -> None:
        """Paint every pixel that looks at the ground.

        Args:
            image: (rows, columns, 3) float32 BGR, painted on.
            state: road and own vehicle.
            camera: as it stands at this instant.
        """
        ego, road = state.ego, state.road
        s_m = ego.s_m + self._section_m
        middles = state.road_points(s_m, ego.lateral_m)
        lefts = state.road_points(s_m, ego.lateral_m + 1.0) - middles
        sections = _sections(middles, lefts, s_m, ego.lateral_m, camera)
        lines = np.array(
            [(m.lateral_m, m.width_m / 2, m.dash_m if m.dashed else -1.0, m.period_m) for m in road.markings]
        ).reshape(-1, 4)
        marks = [mark for mark in state.marks if abs(mark.s_m - ego.s_m) < FARTHEST_M]
        boxes = np.array([(m.s_m, m.lateral_m, m.along_m / 2, m.across_m / 2) for m in marks]).reshape(-1, 4)
        lanes = np.array([(lane.lateral_m, lane.width_m / 2) for lane in road.lanes]).reshape(-1, 2)
        light = self._light
        paint_ground(
            image,
            sections,
            (self._focal_px, self._column_px),
            (road.right_edge_m, road.left_edge_m),
            lines,
            boxes,
            lanes,
            (self._asphalt.cells, self._asphalt.offsets),
            (self._grass.cells, self._grass.offsets),
            (self._grain.cells, self._grain.offsets),
            np.array((light.asphalt, light.gravel, light.grass, light.dry_grass, light.paint), np.float32),
            np.array(light.haze, np.float32),
            light.visibility_m,
        )


def _sections(
    middles: NDArray[np.float64],
    lefts: NDArray[np.float64],
    s_m: NDArray[np.float64],
    lateral_m: float,
    camera: GroundPlaneCamera,
) -> NDArray[np.float64]:
    """Cross-sections in camera axes: (n, 8).

    Column and row times depth, depth, the change of the three per metre to the left; s and t of the middle.

    Sections whose middle is not in front of the camera are left out.
    """
    cosine, sine = math.cos(camera.pitch_rad), math.sin(camera.pitch_rad)
    x, y, below = middles[:, 0], middles[:, 1], camera.height_m - middles[:, 2]
    dx, dy, dz = lefts.T
    depth = x * cosine + below * sine
    columns = (
        -y,
        below * cosine - x * sine,
        depth,
        -dy,
        -dz * cosine - dx * sine,
        dx * cosine - dz * sine,
        s_m,
    )
    sections = np.stack((*columns, np.full_like(s_m, lateral_m)), axis=1)
    sections[:, :2] *= camera.focal_y_px
    sections[:, 3:5] *= camera.focal_y_px
    sections[:, 1] += camera.principal_row_px * sections[:, 2]
    sections[:, 4] += camera.principal_row_px * sections[:, 5]
    return sections[depth > 0.2]


def _noise(generator: np.random.Generator, cells: tuple[int, int], sigma_cells: float) -> FloatImage:
    """Smooth noise of unit variance that repeats, (cells along, cells across)."""
    coarseness = 1 << max(0, math.floor(math.log2(max(sigma_cells / 2, 1))))
    field = generator.standard_normal((cells[0] // coarseness, cells[1] // coarseness)).astype(np.float32)
    margin = max(4, math.ceil(4 * sigma_cells / coarseness))
    padded = cv2.copyMakeBorder(field, margin, margin, margin, margin, cv2.BORDER_WRAP)
    blurred = cv2.GaussianBlur(padded, (0, 0), sigma_cells / coarseness)
    full = cv2.resize(blurred, None, fx=coarseness, fy=coarseness, interpolation=cv2.INTER_LINEAR)
    cut = margin * coarseness
    inner = full[cut : cut + cells[0], cut : cut + cells[1]]
    return np.asarray(inner / inner.std(), np.float32)


def _asphalt(generator: np.random.Generator) -> FloatImage:
    """Deviation of the asphalt's brightness: mottling, streaks along the road, patches, sealed cracks."""
    rows, columns = MAP_CELLS
    mottled = 0.03 * _noise(generator, MAP_CELLS, 1.2) + 0.03 * _noise(generator, MAP_CELLS, 14)
    streaks = cv2.GaussianBlur(_noise(generator, MAP_CELLS, 1.5), (0, 0), sigmaX=1.0, sigmaY=40)
    image = mottled + 0.03 * streaks / streaks.std()
    for _ in range(9):
        top, left = int(generator.integers(rows - 260)), int(generator.integers(columns - 90))
        tall, wide = int(generator.integers(30, 250)), int(generator.integers(20, 80))
        image[top : top + tall, left : left + wide] += float(generator.uniform(-0.12, 0.06))
    for _ in range(26):
        along = generator.uniform() < 0.5
        row, column = float(generator.uniform(0, rows)), float(generator.uniform(0, columns))
        points = [(column, row)]
        for _ in range(int(generator.integers(8, 30))):
            column += float(generator.normal(0 if along else 9, 2.5))
            row += float(generator.normal(12 if along else 0, 3))
            points.append((column, row))
        line = np.round(np.array(points)).astype(np.int32)
        cv2.polylines(image, [line], False, float(generator.uniform(-0.3, -0.12)), 1, cv2.LINE_8)
    return np.asarray(np.clip(image, -0.45, 0.3), np.float32)


def _grass(generator: np.random.Generator) -> FloatImage:
    """Deviation of the grass: tufts, clumps and wide patches."""
    return np.asarray(
        0.14 * _noise(generator, MAP_CELLS, 1.0)
        + 0.13 * _noise(generator, MAP_CELLS, 5)
        + 0.16 * _noise(generator, MAP_CELLS, 40),
        np.float32,
    )
