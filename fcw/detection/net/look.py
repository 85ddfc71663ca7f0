"""A closer look at the boxes of a glance: whether there is a vehicle, and where exactly.

As in cascaded nets (Cascade R-CNN: Cai & Vasconcelos 2018), the net that decides sees every vehicle at the
same place in its window and at the same size.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.forward import ForwardPass
from fcw.detection.net.onnx_layers import read_layers
from fcw.detection.net.windows import Pyramid, boxes_of

LOOK_PX = 48
"""Side of the windows that the net is given."""
LEAST_CONTRAST = 5.0
"""Grey levels added to a window's standard deviation, so that noise on a plain wall is not amplified."""


def normalised(windows: NDArray[np.uint8]) -> NDArray[np.float32]:
    """The net's input: windows with their mean subtracted, divided by their contrast.

    Haze, dusk and exposure change grey values by one scale and one offset at any one distance (Koschmieder's
    law). So a vehicle in fog looks to the net as it does on a clear day, except for noise.

    Args:
        windows: (N, side, side, 3) BGR.

    Returns:
        (N, 3, side, side).
    """
    values = windows.reshape(len(windows), -1).astype(np.float32)
    values -= values.mean(axis=1, keepdims=True)
    values /= np.sqrt(np.mean(values**2, axis=1, keepdims=True)) + LEAST_CONTRAST
    return np.ascontiguousarray(values.reshape(windows.shape).transpose(0, 3, 1, 2))


class Look:
    """A net that tells for each window whether it shows a vehicle, and where.

    Args:
        network: the bytes of an ONNX file. Input: (N, 3, side, side), `normalised`. Output: (N, 5), the logit
            of a vehicle, and its offsets (`fcw.detection.net.windows.boxes_of`).

    Raises:
        ValueError: the file holds another kind of net; see `fcw.detection.net.onnx_layers`.
    """

    def __init__(self, network: bytes) -> None:
        self._net = ForwardPass(read_layers(network), LOOK_PX, LEAST_CONTRAST)

    def at(
        self, pyramid: Pyramid, placements: NDArray[np.float64], mirrored: bool = False
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(N, 4) boxes of the vehicles in windows, and (N,) their logits.

        Args:
            pyramid: the picture.
            placements: (N, 3) placements of the windows; see `Pyramid.windows`.
            mirrored: whether the net is shown their mirror images.
        """
        if not len(placements):
            return np.empty((0, 4)), np.empty(0)
        windows = pyramid.windows(placements, LOOK_PX)
        verdicts = self._net(np.ascontiguousarray(windows[:, :, ::-1]) if mirrored else windows)
        verdicts = verdicts.astype(np.float64)
        if mirrored:
            verdicts[:, 1] *= -1.0
        return boxes_of(placements, verdicts[:, 1:]), verdicts[:, 0]
