"""What is timed on single pictures, on one thread: the detectors, the channels, and a yardstick."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.detection.acf import AcfDetector, AcfSettings, FullAcfDetector, FullAcfSettings
from fcw.detection.channels.aggregated import ChannelComputer
from fcw.detection.choice import DetectorModel, make_detector
from fcw.detection.model import Model
from fcw.detection.net.detector import NetDetector
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel

NEAREST_M = AcfSettings().nearest_m
FARTHEST_M = (41.0, 60.0, 80.0)
"""41 m is the paper's range."""
PITCH_TOLERANCES_DEG = (0.5, 1.0, 2.0)
DEFAULT_PITCH_DEG = math.degrees(AcfSettings().pitch_tolerance_rad)

PRIOR_PREFIX = "distance prior"

Picture = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class PictureCase:
    """Something done with one picture.

    Attributes:
        run: does it.
        windows: that it looks at; None where there are none.
    """

    run: Callable[[Picture], object]
    windows: int | None = None


def prior_name(farthest_m: float, pitch_deg: float = DEFAULT_PITCH_DEG) -> str:
    """The name of a case with the distance prior."""
    return f"{PRIOR_PREFIX} {NEAREST_M:g}-{farthest_m:g} m, ±{pitch_deg:.1f}°"


LUV = "cv2 BGR to Luv"
CHANNELS = "channels, whole picture"
PRIOR_NEAR, PRIOR = prior_name(FARTHEST_M[0]), prior_name(FARTHEST_M[-1])
PRIOR_NATIVE = f"{PRIOR}, native"
NET = "detector net"
FULL = "plain ACF, same scales"
FULL_NATIVE = "plain ACF, same scales, native"
FULL_PAPER = "acf-full: 8 an octave, native"


def picture_cases(
    picture: Picture, calibration: Calibration, model: Model, plugged_in: tuple[str, DetectorModel] | None
) -> dict[str, PictureCase]:
    """The cases by name.

    The distance prior and plain ACF have the same kernels, octaves, trees and later stages; they differ in
    the windows they look at, and in the rows whose channels those need. Native ones do not enlarge the
    picture, by which the others find vehicles half as large.

    Args:
        picture: one of those to come; the detectors are warmed up with it.
        calibration: for the size of the pictures.
        model: of the trees; the net's is the shipped one.
        plugged_in: name and model of another detector to measure beside them.
    """
    computer = ChannelComputer(calibration.image_size)
    channels, luv = computer.compute(picture), np.empty_like(picture)
    cases = {
        LUV: PictureCase(lambda image: cv2.cvtColor(image, cv2.COLOR_BGR2LUV, dst=luv)),
        CHANNELS: PictureCase(lambda image: computer.compute(image, out=channels)),
    }
    settings = {
        prior_name(farthest_m, pitch_deg): AcfSettings(
            farthest_m=farthest_m, pitch_tolerance_rad=math.radians(pitch_deg)
        )
        for farthest_m in FARTHEST_M
        for pitch_deg in PITCH_TOLERANCES_DEG
    }
    for name, prior in (settings | {PRIOR_NATIVE: AcfSettings(largest_scale=1.0)}).items():
        detector = AcfDetector(model, calibration, prior)
        cases[name] = PictureCase(detector.detect, detector.windows_per_frame)
    net = NetDetector(NetModel.load(SHIPPED_NET_PATH), calibration)
    cases[NET] = PictureCase(net.detect, net.windows_per_frame)
    scales, largest = AcfSettings().scales_per_octave, AcfSettings().largest_scale
    for name, everywhere in (
        (FULL, FullAcfSettings(scales_per_octave=scales, largest_scale=largest)),
        (FULL_NATIVE, FullAcfSettings(scales_per_octave=scales, largest_scale=1.0)),
        (FULL_PAPER, FullAcfSettings()),
    ):
        full = FullAcfDetector(model, everywhere)
        full.detect(picture)  # it plans its windows at the first picture
        cases[name] = PictureCase(full.detect, full.windows_per_frame)
    if plugged_in is not None:
        other = make_detector(*plugged_in, calibration)
        cases[other.name] = PictureCase(other.detect)
    return cases
