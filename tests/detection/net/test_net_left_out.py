"""The clips that are left out to choose a net's threshold, and the threshold that they give."""

from collections import Counter
from pathlib import Path
from typing import cast

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.detection.net.model import NetModel
from fcw.detection.net.training import left_out
from fcw.detection.net.training.left_out import chosen_threshold, some_clips
from fcw.detection.training.dataset import NO_BOX, LabelledImage, TrainingImage
from fcw.frame import ImageSize

SIZE = ImageSize(64, 36)
CALIBRATION = Calibration.from_camera(GroundPlaneCamera(0.0, 60.0, 18.0, 1.3, 31.5), SIZE)


def picture(clip: str, vehicles: int = 1, complete: bool = True, path: Path = Path()) -> TrainingImage:
    boxes, ignored = np.tile([5.0, 20.0, 8.0, 6.0], (vehicles, 1)), np.zeros(vehicles, bool)
    rears = np.tile(NO_BOX, (vehicles, 1))
    return TrainingImage(LabelledImage(path, clip, SIZE, boxes, ignored, rears, complete), CALIBRATION)


class Quiet:
    def stage(self, name: str, steps: int) -> None: ...

    def advance(self) -> None: ...

    def note(self, text: str, **figures: float) -> None: ...


def test_a_fifth_of_the_pictures_is_left_out_by_whole_clips():
    images = [picture(clip) for clip in "abcdefghij" for _ in range(3)]
    assert list(Counter(image.labelled.clip for image in some_clips(images, 3)).values()) == [3, 3]


@pytest.mark.parametrize("seed", range(6))
def test_what_is_learnt_from_has_vehicles_and_background(seed):
    images = [picture("a", 2), picture("b", 0), picture("c", 0), picture("d", 1, complete=False)]
    for some in (images, images[:3], images[:2]):
        chosen = some_clips(some, seed)
        learnt = [image.labelled for image in some if image not in chosen]
        assert chosen
        assert sum(len(labelled.boxes) for labelled in learnt) > 0
        assert any(labelled.complete for labelled in learnt)


def test_what_is_found_where_vehicles_have_no_box_is_no_false_alarm(tmp_path, monkeypatch):
    class Brightness:
        """Finds something beside the labelled vehicle, the surer the brighter the picture is."""

        def __init__(self, *_: object) -> None: ...

        def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
            return (Detection(Box(40.0, 20.0, 8.0, 6.0), float(image[0, 0, 0])),)

    images = []
    for brightness, complete in ((1, True), (9, False)):
        path = tmp_path / f"{brightness}.png"
        cv2.imwrite(str(path), np.full((SIZE.height, SIZE.width, 3), brightness, np.uint8))
        images.append(picture("drive", complete=complete, path=path))
    monkeypatch.setattr(left_out, "NetDetector", Brightness)
    threshold = chosen_threshold(cast(NetModel, None), images, 0.0, Quiet())
    assert threshold == pytest.approx(1.0)
