"""Bundle adjustment of a few seconds, with focal length and bend of the lens unknown (Triggs et al. 2000).

Each point is one direction and one inverse depth, and each picture one pose. Points are eliminated first (the
Schur complement), so that a step solves only for poses and lens. The first pose and the length of the whole
way are fixed, because pictures show no scale.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray
from fcw.self_calibration.turning.lens import PlainLens
from fcw.self_calibration.turning.pair import NOISE_PX, motion_between

BEND = Gaussian(-0.12, 0.15)
"""Prior for a camera behind a windscreen: straightened pictures 0, Udacity's -0.24, KITTI's raw ones
-0.37."""
BEND_RANGE = (-0.45, 0.2)
FOCAL_RANGE = (0.15, 3.0)
"""In widths of the picture."""
FEWEST_SHARED = 25
"""Points that two pictures must share."""
NEAREST = 0.02
WIDEST = 4.0
DEEPEST = 5.0
"""Inverse depth, where the car drives 1 in a second."""
LENS = 2
LARGEST_STEP = 0.3
FIRST_DAMPING, CONVERGED = 1e-4, 2e-3
POINT_STIFFNESS = 1e-3


class _Places(NamedTuple):
    """Unknowns: rotations (K, 3, 3), shifts (K, 3), directions (N, 3), inverse depths (N,) and the lens."""

    rotations: FloatArray
    shifts: FloatArray
    directions: FloatArray
    inverse_depths: FloatArray
    log_focal: float
    bend: float


class _Equations(NamedTuple):
    """Normal equations of poses and lens, and what leads back to the points."""

    matrix: FloatArray
    slope: FloatArray
    of_points: FloatArray
    coupling: FloatArray
    point_slope: FloatArray


@dataclass(frozen=True, slots=True)
class Told:
    """What some seconds tell of the lens.

    Attributes:
        log_focal: logarithm of the focal length in pixels, with what pixel noise alone makes of its error.
        bend: of the lens likewise, see `PlainLens`.
        inlying: mean weight of the points, 1 if all of them are where they should be.
        cost: half the squared misfits in sigmas, robust.
    """

    log_focal: Gaussian
    bend: Gaussian
    inlying: float
    cost: float


class Bundle:
    """The poses, points and lens of some seconds.

    Args:
        times_s: (K,) of the pictures.
        places_px: (N, K, 2) columns and rows; NaN where a point is not seen.
        size: width and height of the pictures.
        focal_px: to start with.
    """

    def __init__(
        self, times_s: FloatArray, places_px: FloatArray, size: tuple[int, int], focal_px: float
    ) -> None:
        self._axis_px, self._width_px = ((size[0] - 1) / 2, (size[1] - 1) / 2), size[0]
        self._point, self._key = np.nonzero(np.isfinite(places_px[:, :, 0]))
        self._seen_px = places_px[self._point, self._key]
        self._points, self._keys = places_px.shape[:2]
        # What was seen of a point stands together.
        self._begins, self._firsts = np.unique(self._point, return_index=True)
        self._at = self._start(times_s, places_px, PlainLens(focal_px, BEND.value, self._axis_px))

    def _start(self, times_s: FloatArray, places_px: FloatArray, lens: PlainLens) -> _Places:
        """Poses by pairs of pictures at an even speed, and points where their rays come nearest."""
        rotations, shifts = [np.eye(3)], [np.zeros(3)]
        for k in range(1, self._keys):
            shared = np.isfinite(places_px[:, k - 1 : k + 1, 0]).all(axis=1)
            turn, shift = np.eye(3), np.array([0.0, 0.0, -1.0])
            if shared.sum() >= FEWEST_SHARED:
                turn, shift = motion_between(places_px[shared, k - 1], places_px[shared, k], lens)
            shifts.append(turn @ shifts[-1] + shift * (times_s[k] - times_s[k - 1]))
            rotations.append(turn @ rotations[-1])
        turns, moves = np.array(rotations), np.array(shifts)
        rays = np.hstack((lens.rays(self._seen_px).places, np.ones((len(self._seen_px), 1))))
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        first = np.r_[True, self._point[1:] != self._point[:-1]]
        anchor = self._key[first]
        directions = np.einsum("nji,nj->ni", turns[anchor], rays[first])
        centres = -np.einsum("kji,kj->ki", turns, moves)[anchor]
        far = np.einsum("nij,nj->ni", turns[self._key], directions[self._point])
        near = moves[self._key] + np.einsum("nij,nj->ni", turns[self._key], centres[self._point])
        off, by = np.cross(rays, far), np.cross(rays, near)
        inverse = -np.bincount(self._point, (off * by).sum(axis=1), self._points)
        inverse /= np.bincount(self._point, (by * by).sum(axis=1), self._points) + 1e-4
        inverse = np.clip(inverse, 1e-3, 2.0)
        directions = directions + inverse[:, None] * centres
        length = np.linalg.norm(directions, axis=1)
        return _Places(
            turns, moves, directions / length[:, None], inverse / length, np.log(lens.focal_px), lens.bend
        )

    def fit(self, plan: Sequence[tuple[float, int]], focal_open: bool) -> Told:
        """Go on from where it is.

        Args:
            plan: from which misfit on points count less, in pixels, and how many steps, one after another.
            focal_open: whether the focal length is; else it stays.
        """
        scale_px = 1.0
        for scale_px, steps in plan:
            self._descend(scale_px, steps, focal_open)
        matrix = self._equations(self._at, scale_px, 0.0)[0].matrix
        covariance = np.linalg.inv(matrix + 1e-9 * np.eye(len(matrix)))[-LENS:, -LENS:]
        off = (self._misfits_px(self._at) ** 2).sum(axis=1)
        sigmas = np.sqrt(np.maximum(np.diag(covariance), 0.0)).tolist()
        return Told(
            Gaussian(self._at.log_focal, sigmas[0]),
            Gaussian(self._at.bend, sigmas[1]),
            float(np.mean((scale_px**2 / (scale_px**2 + off)) ** 2)),
            self._cost(self._at, scale_px),
        )

    def _descend(self, scale_px: float, steps: int, focal_open: bool) -> None:
        """Levenberg-Marquardt, under the weights of Geman & McClure (1985)."""
        damping, cost = FIRST_DAMPING, self._cost(self._at, scale_px)
        for _ in range(steps):
            equations, basis = self._equations(self._at, scale_px, damping)
            matrix, slope = equations.matrix, equations.slope
            if not focal_open:
                matrix[-LENS, :] = matrix[:, -LENS] = slope[-LENS] = 0.0
                matrix[-LENS, -LENS] = 1.0
            change = -np.asarray(np.linalg.solve(matrix + 1e-9 * np.eye(len(matrix)), slope), np.float64)
            moved = equations.point_slope + equations.coupling @ change
            there = self._moved(change, -np.einsum("nij,nj->ni", equations.of_points, moved), basis)
            other = self._cost(there, scale_px)
            if other < cost:
                gained, cost, self._at, damping = cost - other, other, there, max(damping / 10, 1e-9)
                if gained < CONVERGED and damping < FIRST_DAMPING:
                    return
            else:
                damping *= 8
                if damping > 1e4:
                    return

    def _moved(self, change: FloatArray, of_points: FloatArray, basis: FloatArray) -> _Places:
        at = self._at
        poses = np.clip(change[:-LENS].reshape(-1, 6), -LARGEST_STEP, LARGEST_STEP)
        of_points = np.clip(of_points, -LARGEST_STEP, LARGEST_STEP)
        turns = np.array([cv2.Rodrigues(pose[:3])[0] for pose in poses])
        directions = at.directions + np.einsum("nij,nj->ni", basis, of_points[:, :2])
        low, high = np.log(self._width_px * np.array(FOCAL_RANGE))
        return _Places(
            turns @ at.rotations,
            at.shifts + poses[:, 3:],
            directions / np.linalg.norm(directions, axis=1)[:, None],
            np.clip(at.inverse_depths + of_points[:, 2], 0.0, DEEPEST),
            float(np.clip(at.log_focal + np.clip(change[-LENS], -0.25, 0.25), low, high)),
            float(np.clip(at.bend + np.clip(change[-1], -0.1, 0.1), *BEND_RANGE)),
        )

    def _seen_from(self, at: _Places) -> tuple[FloatArray, FloatArray]:
        """(M, 3) turned directions, and places in the axes of the pictures, of all that was seen."""
        turned = np.einsum("nij,nj->ni", at.rotations[self._key], at.directions[self._point])
        return turned, turned + at.inverse_depths[self._point, None] * at.shifts[self._key]

    def _misfits_px(self, at: _Places) -> FloatArray:
        """(M, 2)."""
        _, there = self._seen_from(at)
        rays = np.clip(there[:, :2] / np.maximum(there[:, 2:], NEAREST), -WIDEST, WIDEST)
        bent = PlainLens(1.0, at.bend, self._axis_px).bent(rays)
        return np.array(self._axis_px) + np.exp(at.log_focal) * bent - self._seen_px

    def _cost(self, at: _Places, scale_px: float) -> float:
        squares = (self._misfits_px(at) ** 2).sum(axis=1)
        of_bend = ((at.bend - BEND.value) / BEND.sigma) ** 2
        return float((scale_px**2 * squares / (scale_px**2 + squares)).sum() / NOISE_PX**2 + of_bend) / 2

    def _equations(self, at: _Places, scale_px: float, damping: float) -> tuple[_Equations, FloatArray]:
        """The equations, and (N, 3, 2) how directions move by their two unknowns."""
        of_pose, of_lens, of_point, basis = self._slopes(at)
        misfits = self._misfits_px(at)
        weights = (scale_px**2 / (scale_px**2 + (misfits**2).sum(axis=1))) ** 2 / NOISE_PX**2
        count = 6 * self._keys + LENS
        weighted = np.swapaxes(of_point * weights[:, None, None], 1, 2)
        points = self._by_point(weighted @ of_point)
        point_slope = self._by_point(np.einsum("nij,nj->ni", weighted, misfits))
        camera = np.concatenate((of_pose, of_lens), axis=2)
        blocks = weighted @ camera
        of_poses = np.zeros((self._points, 3, self._keys, 6))
        of_poses[self._point, :, self._key] = blocks[:, :, :6]  # a picture shows a point once
        of_poses = of_poses.reshape(self._points, 3, -1)
        coupling = np.concatenate((of_poses, self._by_point(blocks[:, :, 6:])), axis=2)
        matrix, slope = np.zeros((count, count)), np.zeros(count)
        weighted = np.swapaxes(camera * weights[:, None, None], 1, 2)
        squares, slopes = weighted @ camera, np.einsum("nij,nj->ni", weighted, misfits)
        for key in range(self._keys):
            seen, place = self._key == key, np.r_[6 * key : 6 * key + 6, count - 2, count - 1]
            matrix[np.ix_(place, place)] += squares[seen].sum(axis=0)
            slope[place] += slopes[seen].sum(axis=0)
        matrix[np.arange(6), np.arange(6)] += 1e10
        last = slice(count - LENS - 3, count - LENS)
        way = at.shifts[-1] / np.linalg.norm(at.shifts[-1])
        matrix[last, last] += 1e6 * np.outer(way, way)
        matrix[-1, -1] += BEND.sigma**-2
        slope[-1] += (at.bend - BEND.value) / BEND.sigma**2
        points += POINT_STIFFNESS * np.eye(3) + damping * points * np.eye(3)
        inverse = np.asarray(np.linalg.inv(points), np.float64)
        led = np.einsum("nij,nik->jnk", coupling, inverse).reshape(count, -1)
        matrix += damping * np.diag(np.diag(matrix)) - led @ coupling.reshape(-1, count)
        slope -= led @ point_slope.ravel()
        return _Equations(matrix, slope, inverse, coupling, point_slope), basis

    def _by_point(self, values: FloatArray) -> FloatArray:
        """(N, ...) sums over what was seen of each point."""
        sums = np.zeros((self._points, *values.shape[1:]))
        sums[self._begins] = np.add.reduceat(values, self._firsts)
        return sums

    def _slopes(self, at: _Places) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """(M, 2, 6) of the misfits by pose, (M, 2, 2) by lens, (M, 2, 3) by point; and the points' basis."""
        turned, there = self._seen_from(at)
        depths = np.maximum(there[:, 2], NEAREST)
        rays = np.clip(there[:, :2] / depths[:, None], -WIDEST, WIDEST)
        focal_px, lens = np.exp(at.log_focal), PlainLens(1.0, at.bend, self._axis_px)
        by_place = np.zeros((len(rays), 2, 3))
        by_place[:, 0, 0] = by_place[:, 1, 1] = 1 / depths
        by_place[:, :, 2] = -rays / depths[:, None]
        by_place = focal_px * lens.bending(rays) @ by_place
        # By a small turn d, the place moves by d x turned.
        by_turn = np.cross(turned[:, None, :], by_place)
        inverse = at.inverse_depths[self._point, None, None]
        of_pose = np.concatenate((np.asarray(by_turn, np.float64), by_place * inverse), axis=2)
        of_lens = focal_px * np.stack((lens.bent(rays), lens.by_bend(rays)), axis=2)
        upright = np.abs(at.directions[:, 2:]) < 0.9
        helper = np.where(upright, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
        first = np.cross(at.directions, helper)
        first /= np.linalg.norm(first, axis=1)[:, None]
        basis = np.asarray(np.stack((first, np.cross(at.directions, first)), axis=2), np.float64)
        by_direction = by_place @ (at.rotations[self._key] @ basis[self._point])
        by_depth = np.einsum("nij,nj->ni", by_place, at.shifts[self._key])
        return of_pose, of_lens, np.concatenate((by_direction, by_depth[:, :, None]), axis=2), basis
