"""From FFmpeg's decoded pictures to those that the program looks at."""

import numpy as np
from av.video.frame import VideoFrame
from av.video.reformatter import VideoReformatter
from numpy.typing import NDArray


def bgr(picture: VideoFrame) -> NDArray[np.uint8]:
    """The picture's pixels: (height, width, 3) uint8, BGR.

    In the calling thread alone. Left to itself FFmpeg spreads this half a millisecond of work over all cores
    and waits for each of them, which takes ten times as long where they have other work.
    """
    return np.asarray(VideoReformatter().reformat(picture, format="bgr24", threads=1).to_ndarray(), np.uint8)
