"""The picture of a frame with everything drawn over it: they are one image, and so never out of step."""

from collections import OrderedDict

import numpy as np
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.logs.records import FrameResult
from fcw_viz.overlay import OverlayPainter
from fcw_viz.page.picture.label_layout import Area
from fcw_viz.review_app.drive import Drive

MISSING_GREY = 60
RESULTS_KEPT = 512


class FramePictures:
    """The pictures and results of one drive for one tab, in the tab's thread."""

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._pictures = drive.pictures()
        self._painter = OverlayPainter(drive.header, drive.first_ns)
        self._results: OrderedDict[int, FrameResult] = OrderedDict()

    def close(self) -> None:
        """Let go of the decoder."""
        self._pictures.close()

    def result(self, row: int) -> FrameResult:
        """What the log says of a frame.

        Raises:
            UserError: the log is damaged there.
        """
        result = self._results.get(row)
        if result is None:
            try:
                result = self._drive.log.result_at(self._drive.frame_index(row))
            except IndexError as error:
                raise UserError(f"{error}; was the log replaced? Open the drive again") from error
            self._results[row] = result
            while len(self._results) > RESULTS_KEPT:
                self._results.popitem(last=False)
        return result

    def words(self, drawn: FrameResult | None) -> tuple[Area, ...]:
        """What the words cover that `image` draws over a picture with that result."""
        if drawn is None:
            return ()
        grounds = (one.ground for one in self._painter.overlay(drawn).words)
        return tuple(Area(ground.x, ground.y, ground.right, ground.bottom) for ground in grounds)

    def image(self, row: int, drawn: FrameResult | None) -> tuple[NDArray[np.uint8], str]:
        """A picture, (height, width, 3) BGR, with a result drawn over it unless that is None.

        Returns:
            The picture, grey where it is missing in the log, and then the reason.
        """
        trouble = ""
        try:
            image = self._pictures.at(self._drive.frame_index(row)).copy()
        except UserError as error:
            size = self._drive.header.image_size
            image, trouble = np.full((size.height, size.width, 3), MISSING_GREY, np.uint8), str(error)
        if drawn is not None:
            self._painter.paint(image, drawn)
        return image, trouble
