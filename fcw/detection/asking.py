"""A detector is asked what is in a frame, which may be anybody's detector."""

from fcw.detection.detector import Detection, Detector
from fcw.frame import Frame


def vehicles_in(detector: Detector, frame: Frame) -> tuple[Detection, ...]:
    """What a detector finds in a frame.

    It sees the picture and cannot change it: the tracker goes by the same one, and it is written to the log.
    """
    shown = frame.image.view()
    shown.flags.writeable = False
    return detector.detect(shown)
