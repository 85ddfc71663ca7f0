"""Computes a lens from pictures of a chessboard."""

from collections import Counter
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.lens.model import Lens
from fcw.errors import UserError
from fcw.frame import ImageSize

FEWEST_BOARDS = 3
CROPPED_PX = 1
"""Some cameras crop single pictures by a pixel."""


def lens_of_chessboards(pictures: Sequence[NDArray[np.uint8]], inner_corners: tuple[int, int]) -> Lens:
    """The lens from pictures of one chessboard (Zhang 2000), with five distortion coefficients.

    Args:
        pictures: (height, width, 3) BGR or (height, width) grey, all of one size to within a pixel.
        inner_corners: numbers of the board's inner corners across and down.

    Raises:
        UserError: too few pictures show the whole board, or those that do have several sizes.
    """
    across, down = inner_corners
    board = np.zeros((across * down, 3), np.float32)
    board[:, :2] = np.mgrid[0:across, 0:down].T.reshape(-1, 2)
    found: list[NDArray] = []
    sizes: Counter[ImageSize] = Counter()
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 40, 1e-3)
    for picture in pictures:
        grey = (
            picture if picture.ndim == 2 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)
        )
        shown, corners = cv2.findChessboardCorners(grey, inner_corners)
        if shown:
            found.append(cv2.cornerSubPix(grey, corners, (9, 9), (-1, -1), criteria))
            sizes[ImageSize(grey.shape[1], grey.shape[0])] += 1
    if len(found) < FEWEST_BOARDS:
        raise UserError(
            f"the whole board of {across}x{down} inner corners shows in {len(found)} of {len(pictures)} "
            f"pictures, expected {FEWEST_BOARDS} or more; check the number of inner corners, and that all of "
            "them are in the picture"
        )
    size = next(iter(sizes))
    if any(max(abs(one.width - size.width), abs(one.height - size.height)) > CROPPED_PX for one in sizes):
        counted = ", ".join(f"{count} of {one}" for one, count in sizes.items())
        raise UserError(
            f"the board shows in pictures of several sizes ({counted}); a lens is of one mode of the camera, "
            "held one way up: leave the pictures of the others out"
        )
    _, matrix, coefficients, _, _ = cv2.calibrateCamera(
        [board] * len(found), found, (size.width, size.height), np.eye(3), np.zeros(5)
    )
    return Lens(
        "radtan",
        float(matrix[0, 0]),
        float(matrix[1, 1]),
        float(matrix[0, 2]),
        float(matrix[1, 2]),
        tuple(np.ravel(coefficients)[:5].tolist()),
        size,
    )
