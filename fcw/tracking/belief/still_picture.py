"""What stands still in the picture while the road moves: own bonnet, a logo, a clock, a crack, a reflection.

Whatever belongs to the camera or the windscreen shows the same pixels in the same place second after second.
A vehicle does not, even at a constant gap: our own pitching and swaying moves it by pixels. On the clips of
the two dash cameras that see their own bonnet the correlation of a place with itself a second later was 0.98
to 1.00 on the bonnet in nine of ten cases, and of all boxes of vehicles it was never above 0.95.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.detection.boxes.overlap import intersection_over_union

Picture = NDArray[np.uint8]
Sample = NDArray[np.float32]

SAMPLES = 24
"""A place is compared on so many columns and rows of single pixels: a mean of several would hide the
motion."""
SCENE_ROWS = 0.3, 0.75
"""Where the road and its surroundings are, as parts of the picture's height."""
SMALLEST_PX = 8.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StillPictureSettings:
    """When a place in the picture is taken to belong to the camera.

    Attributes:
        compared_s: it is compared with itself after so long.
        likeness: correlation from which it is the same.
        times: so often it must have been the same in a row.
        scene_likeness: the picture moves where the whole of it correlates less than this.
        learned_likeness: correlation with what was learned from which a new box there is the same.
        same_place: overlap (intersection over union) of such a box with the learned place.
        most: so many places are kept, the latest ones.
    """

    compared_s: float = 1.0
    likeness: float = 0.97
    times: int = 2
    scene_likeness: float = 0.9
    learned_likeness: float = 0.95
    same_place: float = 0.5
    most: int = 8


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """A place in the picture as it looked at a time."""

    box: Box
    looks: Sample
    scene: Sample
    time_ns: int
    times: int = 0


class StillPicture:
    """Learns over seconds which boxes stand still in the picture.

    Args:
        settings: see `StillPictureSettings`.
    """

    def __init__(self, settings: StillPictureSettings | None = None) -> None:
        self._settings = settings or StillPictureSettings()
        self._watched: dict[int, _Place] = {}
        self._learned: list[_Place] = []

    def update(self, time_ns: int, image: Picture, boxes: dict[int, Box]) -> set[int]:
        """Take one picture with the boxes in it.

        Args:
            time_ns: of the picture.
            image: (height, width, 3).
            boxes: by the number of their track.

        Returns:
            The numbers of those that belong to the camera.
        """
        settings = self._settings
        self._watched = {number: place for number, place in self._watched.items() if number in boxes}
        still = set()
        scene: Sample | None = None
        for number, box in boxes.items():
            place = self._watched.get(number)
            if place is not None and _overlap(place.box, box) < settings.same_place:
                place = None
            due = place is None or (time_ns - place.time_ns) / 1e9 >= settings.compared_s
            if due:
                scene = _scene(image) if scene is None else scene
                place = self._compared(time_ns, image, scene, box, place)
                if place is None:
                    self._watched.pop(number, None)
                    continue
                self._watched[number] = place
            if place is not None and (place.times >= settings.times or self._is_learned(image, box)):
                still.add(number)
        return still

    def _compared(
        self, time_ns: int, image: Picture, scene: Sample, box: Box, place: _Place | None
    ) -> _Place | None:
        """What is remembered of a place from now on; None where the box is too small for it."""
        settings = self._settings
        if place is not None:
            now = _looks(image, place.box)
            moves = _likeness(scene, place.scene) < settings.scene_likeness
            if now is not None and _likeness(now, place.looks) >= settings.likeness:
                times = place.times + moves
                same = _Place(place.box, place.looks, scene, time_ns, times)
                if times == settings.times:
                    self._learned = [*self._learned, same][-settings.most :]
                return same
        looks = _looks(image, box)
        return None if looks is None else _Place(box, looks, scene, time_ns)

    def _is_learned(self, image: Picture, box: Box) -> bool:
        settings = self._settings
        for place in self._learned:
            if _overlap(place.box, box) >= settings.same_place:
                now = _looks(image, place.box)
                if now is not None and _likeness(now, place.looks) >= settings.learned_likeness:
                    return True
        return False


def _looks(image: Picture, box: Box) -> Sample | None:
    """Single pixels of the green channel on a grid over a box; None where too little of it is in the
    picture."""
    height, width = image.shape[:2]
    left, top = max(int(box.x), 0), max(int(box.y), 0)
    right, bottom = min(int(box.right), width), min(int(box.bottom), height)
    if right - left < SMALLEST_PX or bottom - top < SMALLEST_PX:
        return None
    across, down = max((right - left) // SAMPLES, 1), max((bottom - top) // SAMPLES, 1)
    return image[top:bottom:down, left:right:across, 1].astype(np.float32)


def _scene(image: Picture) -> Sample:
    """The same over road and surroundings."""
    height, width = image.shape[:2]
    first, last = (int(part * height) for part in SCENE_ROWS)
    sample = _looks(image, Box(0, first, width, last - first))
    return np.zeros((1, 1), np.float32) if sample is None else sample


def _likeness(a: Sample, b: Sample) -> float:
    """Correlation; 0 where one of them is all of one brightness, which looks like anything."""
    if a.shape != b.shape:
        return 0.0
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum()) / scale if scale > 0 else 0.0


def _overlap(a: Box, b: Box) -> float:
    boxes = np.array([(box.x, box.y, box.w, box.h) for box in (a, b)], np.float64)
    return float(intersection_over_union(boxes[:1], boxes[1:])[0, 0])
