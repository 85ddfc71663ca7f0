"""Pictures of dash cameras out of many repositories, with vehicles judged by eye.

`gathered.json` names each picture, its camera, and its boxes: of vehicles that are seen from behind, with
kind and view, and of all others. `hard.json` names more of them, chosen for what the others show too seldom:
bad weather and light, lorries, buses and vans, vehicles that are near, half-hidden or cut by the picture's
edge. `later.json` and `latest.json` name more of both sorts, each found when weights that learnt from the
others were in use.
A quarter of the drives is for judging, the rest for learning.
"""

import io
import json
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
from folders import LEAST_WIDTH_PX, Folder, Rough
from numpy.typing import NDArray
from repositories import Files, Repository

from fcw.frame import ImageSize

GATHERED, HARD, LATER, LATEST = (
    Path(__file__).with_name(name) for name in ("gathered.json", "hard.json", "later.json", "latest.json")
)
CAMERA = Rough(1.35, 0.8)
"""Of an unknown maker: a field of view of 64 degrees."""
HEIGHTS_M = {"car": 1.5, "suv": 1.75, "van": 2.1, "truck": 3.2, "bus": 3.1}
"""Of vehicles, to tell where the horizon lies."""
HORIZON_PARTS = 0.25, 0.7
"""Of the picture's height, which it is believed to lie between."""
WHOLE_FIELDS = 6
"""Of a vehicle that is neither hidden nor cut."""
TIME_TOLERANCE_S = 1e-3


@dataclass(frozen=True, slots=True)
class Gathered:
    """A picture.

    Attributes:
        repository: where it is.
        commit: and in which commit.
        path: its file, or a video's.
        time_s: when in the video; None of a picture.
        camera: the same of all pictures that one camera or drive took.
        size: that the boxes are for: larger pictures are shrunk to it.
        judge: whether it is for judging.
        vehicles: x, y, w, h, kind, view, and perhaps `hidden` or `cut` of those seen from behind.
        others: x, y, w, h of all other vehicles, and of what may be one.
    """

    repository: str
    commit: str
    path: str
    time_s: float | None
    camera: str
    size: ImageSize
    judge: bool
    vehicles: tuple[tuple[Any, ...], ...]
    others: tuple[tuple[float, ...], ...]

    def boxes(self) -> Iterator[Mapping[str, Any]]:
        """As a training folder has them."""
        for x, y, w, h, kind, view, *marks in self.vehicles:
            yield {
                "bbox": [x, y, w, h],
                "ignore": w < LEAST_WIDTH_PX,
                "kind": kind,
                "view": view,
                "occluded": int("hidden" in marks),
                "truncated": "cut" in marks,
            }
        for box in self.others:
            yield {"bbox": list(box), "ignore": True}

    @property
    def clip(self) -> str:
        """The camera, for boxes of one size."""
        return f"gathered_{self.camera}_{self.size}"


def read_gathered(path: Path) -> tuple[Gathered, ...]:
    """All pictures, by repository and commit."""
    read: list[Gathered] = []
    for place, pictures in json.loads(path.read_text()).items():
        repository, commit = place.split("@")
        read += [
            Gathered(
                repository,
                commit,
                each["path"],
                each.get("time_s"),
                each["camera"],
                ImageSize(*each["size"]),
                each["judge"],
                tuple(map(tuple, each["vehicles"])),
                tuple(map(tuple, each["others"])),
            )
            for each in pictures
        ]
    return tuple(read)


def build_gathered(clones: Path, choice: Path, learn: Folder, judge: Folder) -> None:
    """Both folders of a choice: to learn from, and to judge by."""
    of_clip: dict[str, list[Gathered]] = defaultdict(list)
    of_repository: dict[tuple[str, str], list[tuple[int, Gathered]]] = defaultdict(list)
    for number, each in enumerate(read_gathered(choice)):
        of_clip[each.clip].append(each)
        of_repository[each.repository, each.commit].append((number, each))
    cameras = {
        clip: CAMERA.calibration(pictures[0].size, horizon_row_px(pictures))
        for clip, pictures in of_clip.items()
    }
    for (repository, commit), numbered in of_repository.items():
        with Repository(clones, repository).files(commit) as files:
            for number, each in numbered:
                name, picture = f"{repository.replace('/', '_')}_{number:04d}", picture_of(files, each)
                folder = judge if each.judge else learn
                folder.add(name, each.clip, picture, cameras[each.clip], list(each.boxes()), complete=True)


def horizon_row_px(pictures: Sequence[Gathered]) -> float:
    """Where the heights of a camera's vehicles put it, in the median."""
    vehicles = [vehicle for each in pictures for vehicle in each.vehicles]
    whole = [vehicle for vehicle in vehicles if len(vehicle) == WHOLE_FIELDS] or vehicles
    rows = [
        y + h - CAMERA.height_m * h / HEIGHTS_M.get(kind, HEIGHTS_M["car"]) for _, y, _, h, kind, *_ in whole
    ]
    low, high = (part * pictures[0].size.height for part in HORIZON_PARTS)
    return float(np.clip(np.median(rows) if rows else (low + high) / 2, low, high))


def picture_of(files: Files, gathered: Gathered) -> NDArray[np.uint8]:
    """In the size that its boxes are for.

    Raises:
        ValueError: a video has no picture at that time.
    """
    if gathered.time_s is None:
        picture = files.picture(gathered.path)
    else:
        picture = frame_of(files.content(gathered.path), gathered.time_s)
    size = gathered.size.width, gathered.size.height
    if picture.shape[1::-1] == size:
        return picture
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def frame_of(video: bytes, time_s: float) -> NDArray[np.uint8]:
    """The first picture of a video from a time on."""
    with av.open(io.BytesIO(video), "r") as container:
        for frame in container.decode(video=0):
            if frame.time is not None and frame.time >= time_s - TIME_TOLERANCE_S:
                return np.asarray(frame.to_ndarray(format="bgr24"), np.uint8)
    raise ValueError(f"the video ends before {time_s:g} s")
