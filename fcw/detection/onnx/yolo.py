"""What the nets of the YOLO family take and put out, told apart by the shape of the output.

For pictures of H x W the heads have one cell for each 8 x 8, 16 x 16 and 32 x 32 px (some also 4 x 4 or
64 x 64): M = HW/64 + HW/256 + HW/1024 cells in all. With C classes the exported nets put out

    YOLOv5          1 x 3M x (5 + C)    middle x, y, width, height, objectness, classes
    YOLOv6          1 x M x (5 + C)     likewise, the objectness of all being 1
    YOLOv8 and on   1 x (4 + C) x M     middle x, y, width, height, classes
    YOLOX           1 x M x (5 + C)     as YOLOv5; offsets from the cell and logarithms of sizes, in cells
    end to end      1 x N x 6           left, top, right, bottom, score, class (YOLOv10, YOLO26)

in pixels of what they were shown, whose first pixel begins at 0. Sources: ultralytics/yolov5 `export.py` and
`utils/augmentations.py`, meituan/YOLOv6 `yolov6/models/effidehead.py` and `yolov6/core/inferer.py`,
ultralytics/ultralytics `engine/exporter.py` and `data/augment.py`,
Megvii-BaseDetection/YOLOX `yolox/utils/demo_utils.py` and `yolox/data/data_augment.py`.
"""

from collections.abc import Sequence
from enum import StrEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.frame import ImageSize

STRIDES_PX = ((8, 16, 32), (8, 16, 32, 64), (4, 8, 16, 32))
"""Cells of the usual heads, of those for large pictures (P6) and of those for small things (P2)."""
YOLOV5_ANCHORS = 3
"""Boxes a cell."""
PAD_VALUE = 114
"""The grey around a letterboxed picture."""


class Layout(StrEnum):
    """How an exported net writes its boxes."""

    YOLOV5 = "YOLOv5"
    YOLOV6 = "YOLOv6"
    YOLOV8 = "YOLOv8"
    YOLOX = "YOLOX"
    YOLOX_DECODED = "YOLOX, decoded"
    END_TO_END = "end to end"


def recognise(output: NDArray[np.floating], shown: ImageSize) -> Layout | None:
    """The layout of an output, by its shape; None where it is none of them.

    Args:
        output: what the net puts out for any picture.
        shown: size of what it is shown.
    """
    if output.ndim != 3 or len(output) != 1:
        return None
    rows, columns = output.shape[1:]
    for strides in STRIDES_PX:
        cells = len(_cells(shown, strides)[0])
        if rows == YOLOV5_ANCHORS * cells and columns > 5:
            return Layout.YOLOV5
        if columns == cells and rows > 4:
            return Layout.YOLOV8
        if rows == cells and columns > 5:
            if (output[0, :, 4] == 1.0).all():  # objectness, which YOLOv6 does not tell
                return Layout.YOLOV6
            # Exported with decode_in_inference the middles are in pixels, and those of the cells at the right
            # are near the right edge; raw ones are within a few cells of their own.
            decoded = output[0, :, 0].max() > shown.width / min(strides)
            return Layout.YOLOX_DECODED if decoded else Layout.YOLOX
    # Of two classes RT-DETR puts out as many columns, the last of which is a score.
    numbers = output[0, :, 5:]
    if columns == 6 and np.array_equal(numbers, np.rint(numbers), equal_nan=True):
        return Layout.END_TO_END
    return None


def expected_shapes(shown: ImageSize) -> str:
    """The shapes that are recognised, for a person."""
    cells = len(_cells(shown, STRIDES_PX[0])[0])
    return (
        f"1x{YOLOV5_ANCHORS * cells}x(5 + classes) as YOLOv5, 1x(4 + classes)x{cells} as YOLOv8 and later, "
        f"1x{cells}x(5 + classes) as YOLOX, or 1xNx6 end to end, each ending in a class's number"
    )


def class_count(layout: Layout, output: NDArray[np.floating]) -> int | None:
    """How many classes the net knows; None where its output does not tell."""
    if layout is Layout.END_TO_END:
        return None
    return output.shape[1] - 4 if layout is Layout.YOLOV8 else output.shape[2] - 5


def decode(
    layout: Layout, output: NDArray[np.floating], shown: ImageSize, classes: Sequence[int]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Boxes and scores of some classes, before any threshold or suppression.

    Args:
        layout: of the output.
        output: of one picture.
        shown: size of what the net was shown.
        classes: numbers of the classes wanted.

    Returns:
        (N, 4) left, top, width, height in pixels of what the net was shown, and (N,) scores, 0 to 1: the best
        of the wanted classes, times the objectness where there is one. NaN where the net puts out NaN.
    """
    rows = output[0].T if layout is Layout.YOLOV8 else output[0]
    if layout is Layout.END_TO_END:
        rows = rows.astype(np.float64)
        corners, score, number = rows[:, :4], rows[:, 4], rows[:, 5]
        boxes = np.column_stack([corners[:, :2], corners[:, 2:] - corners[:, :2]])
        return boxes, score * np.isin(number.round(), classes)  # NaN stays: it is of no class
    first = 4 if layout is Layout.YOLOV8 else 5
    # Only what is wanted: of a thousand classes all others would be copied too.
    scores = rows[:, [first + number for number in classes]].max(axis=1).astype(np.float64)
    rows = rows[:, :first].astype(np.float64)
    if layout is not Layout.YOLOV8:
        scores *= rows[:, 4]
    middles, sizes = rows[:, :2], rows[:, 2:4]
    if layout is Layout.YOLOX:
        strides = next(s for s in STRIDES_PX if len(_cells(shown, s)[0]) == len(rows))
        corners, cell_px = _cells(shown, strides)
        middles, sizes = (middles + corners) * cell_px, np.exp(sizes) * cell_px
    return np.column_stack([middles - sizes / 2, sizes]), scores


class Letterbox:
    """Pictures of one size fitted into what a net is shown, their aspect ratio kept, grey around them.

    YOLOX puts the picture at the top left and takes BGR counts; the others put it in the middle and take RGB
    from 0 to 1. An instance owns scratch memory: use one for each thread.

    Args:
        picture: size of the pictures.
        shown: size of what the net is shown.
        layout: of the net.
    """

    def __init__(self, picture: ImageSize, shown: ImageSize, layout: Layout) -> None:
        self._yolox = layout in (Layout.YOLOX, Layout.YOLOX_DECODED)
        scale = min(shown.width / picture.width, shown.height / picture.height)
        whole = int if self._yolox else round
        width, height = max(whole(picture.width * scale), 1), max(whole(picture.height * scale), 1)
        # Of an odd number of grey rows the family's own code puts one more below, of columns at the right.
        left, top = (0, 0) if self._yolox else ((shown.width - width) // 2, (shown.height - height) // 2)
        self._corner = np.array([left, top], np.float64)
        self._scale = np.array([width / picture.width, height / picture.height])
        self._canvas = np.full((shown.height, shown.width, 3), PAD_VALUE, np.uint8)
        self._inside = self._canvas[top : top + height, left : left + width]

    def show(self, image: NDArray[np.uint8]) -> NDArray[np.float32]:
        """(1, 3, H, W) what the net is shown of a (height, width, 3) BGR picture."""
        size = self._inside.shape[1], self._inside.shape[0]
        self._inside[:] = cv2.resize(image, size, interpolation=cv2.INTER_LINEAR)
        factor = 1.0 if self._yolox else 1 / 255
        return np.asarray(cv2.dnn.blobFromImage(self._canvas, factor, swapRB=not self._yolox), np.float32)

    def in_picture(self, boxes: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 4) x, y, w, h of boxes in the picture, on the grid whose origin is its first pixel's middle."""
        corners = (boxes[:, :2] - self._corner) / self._scale - 0.5
        return np.column_stack([corners, boxes[:, 2:] / self._scale])


def _cells(shown: ImageSize, strides_px: Sequence[int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of every cell (M, 2) column and row in its own grid, and (M, 1) its side in px; rows from the top."""
    corners, sides = [], []
    for stride in strides_px:
        rows, columns = np.mgrid[: shown.height // stride, : shown.width // stride]
        corners.append(np.column_stack([columns.ravel(), rows.ravel()]))
        sides.append(np.full((rows.size, 1), stride))
    return np.concatenate(corners).astype(np.float64), np.concatenate(sides).astype(np.float64)
