"""How the camera moved between two pictures, for a lens that is supposed: where a bundle adjustment starts.

Two pictures of a car that turns tell no focal length: its optical axes meet at the same distance from both
(Sturm 2001), so any lens has its motion that explains them.
"""

import cv2
import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.self_calibration.turning.lens import PlainLens, Rays

SCALES_PX = (8.0, 8.0, 4.0, 4.0, 2.0, 1.0, 1.0)
"""From which on a point counts less, step by step."""
STEPS = (1e-5, 1e-5, 1e-5, 1e-4, 1e-4)
BELIEVED = (0.02, 0.35, 0.02, 0.04, 0.02)
"""Sigmas of pitch, yaw and roll between the pictures, and of the direction of travel aside and down."""
NOISE_PX = 0.3
LARGEST_STEP = 0.1


def motion_between(
    before_px: FloatArray, after_px: FloatArray, lens: PlainLens
) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3) and shift (3,) of length 1 from the axes of the first picture to those of the second.

    Args:
        before_px: (N, 2) columns and rows in the first picture.
        after_px: (N, 2) in the second.
        lens: as supposed.
    """
    before, after = lens.rays(before_px), lens.rays(after_px)
    motion = np.zeros(5)
    motion[1] = np.median(after_px[:, 0] - before_px[:, 0]) / lens.focal_px
    for scale_px in SCALES_PX:
        off_px = epipolar_misfits(motion, before, after)
        slopes = np.empty((len(off_px), 5))
        for k, step in enumerate(STEPS):
            there = motion.copy()
            there[k] += step
            slopes[:, k] = (epipolar_misfits(there, before, after) - off_px) / step
        weighted = slopes.T * (scale_px**2 / (scale_px**2 + off_px**2)) ** 2 / NOISE_PX**2
        beliefs = np.array(BELIEVED) ** -2.0
        change = np.linalg.solve(weighted @ slopes + np.diag(beliefs), weighted @ off_px + beliefs * motion)
        motion -= np.clip(change, -LARGEST_STEP, LARGEST_STEP)
    half, way = _half_and_way(motion)
    return half @ half, -half @ way


def epipolar_misfits(motion: FloatArray, before: Rays, after: Rays) -> FloatArray:
    """(N,) Sampson's distance in pixels (Hartley & Zisserman 2004, 11.4.3).

    Args:
        motion: (5,) rotation vector, and x / z and y / z of the travel in axes turned by half of it.
        before: rays in the first picture.
        after: of the same points in the second.
    """
    half, way = _half_and_way(motion)
    across = np.array([[0, -way[2], way[1]], [way[2], 0, -way[0]], [-way[1], way[0], 0]])
    essential = half @ across @ half
    ones = np.ones((len(before.places), 1))
    first, second = np.hstack((before.places, ones)), np.hstack((after.places, ones))
    on_second, on_first = first @ essential.T, second @ essential
    slopes = np.hstack(
        (
            np.einsum("nij,ni->nj", before.slopes, on_first[:, :2]),
            np.einsum("nij,ni->nj", after.slopes, on_second[:, :2]),
        )
    )
    return (second * on_second).sum(axis=1) / np.sqrt((slopes**2).sum(axis=1) + 1e-12)


def _half_and_way(motion: FloatArray) -> tuple[FloatArray, FloatArray]:
    half = np.asarray(cv2.Rodrigues(motion[:3] / 2)[0], np.float64)
    way = np.array([motion[3], motion[4], 1.0])
    return half, way / np.linalg.norm(way)
