"""Scenes to learn a glance from: parts of pictures in which a vehicle is near, however far it was.

The glance's picture is so small that most labelled vehicles have as many pixels as a near one has there.
Cut out with what is around it, each is seen as if it were near: at any size, cut by the picture's edges,
above an own bonnet, behind another vehicle.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.bands import SHOWN
from fcw.detection.net.glance import CELL_PX
from fcw.detection.net.training.lottery import Lottery
from fcw.detection.net.training.vehicles import drawing_weights
from fcw.detection.training.dataset import LabelledImage, TrainingImage
from fcw.detection.training.looks import Looks, vary_looks
from fcw.errors import UserError

FloatArray = NDArray[np.float32]
ROWS, COLUMNS = SHOWN.height // CELL_PX, SHOWN.width // CELL_PX
IGNORED = -1.0

STORED_PX = 800
"""Pictures are kept this wide or high at most: all of them are in memory."""
LEAST_STORED_PX = 14.0
"""sqrt(w h) of a vehicle there that a scene is made around."""
LEAST_PX = 16.0
"""sqrt(w h) of a vehicle in the scene that is to be found; smaller ones may be."""
LEAST_SEEN = 0.35
"""Part of a vehicle that lies in the scene; of less nothing is to be said."""
CORE, RIM = 0.22, 0.33
"""Parts of a vehicle's sides, from its middle, within which cells are to find it, or may."""
AROUND = 0.2
"""Parts of a vehicle's sides around it in which there is no other, where not all vehicles are labelled."""


@dataclass(frozen=True, slots=True)
class SceneSettings:
    """How scenes are made.

    Attributes:
        around_vehicle: part of the scenes that are made around a vehicle; the others are of anything.
        shape: standard deviation of the logarithm of how much wider they are shown.
        sizes: sqrt(w h) of that vehicle, smallest and largest, in heights of the scene.
        beyond: how much larger than the picture a scene may be; its edges are repeated.
        bonnet_part: how many end in an own bonnet.
        hidden_part: in how many another vehicle is set in front of one.
        most_hidden: of its width that is hidden then.
        blurred_part: how many lose detail.
        varied_part: how many look otherwise than in their picture.
        looks: how.
    """

    around_vehicle: float = 0.85
    shape: float = 0.12
    sizes: tuple[float, float] = (0.14, 1.15)
    beyond: float = 1.15
    bonnet_part: float = 0.15
    hidden_part: float = 0.2
    most_hidden: float = 0.45
    blurred_part: float = 0.3
    varied_part: float = 0.75
    looks: Looks = Looks()  # noqa: RUF009 - frozen


class Scene(NamedTuple):
    """What the net is shown, and what it is to say.

    Attributes:
        picture: (height, width, 3) uint8 BGR, of `SHOWN`.
        vehicle: (ROWS, COLUMNS) 1.0 where a cell is in the middle of a vehicle, else 0.0; `IGNORED` where
            either may be.
        reaches: (4, ROWS, COLUMNS) in cells, from those cells' middles to the vehicle's left, top, right and
            bottom.
    """

    picture: NDArray[np.uint8]
    vehicle: FloatArray
    reaches: FloatArray


class View(NamedTuple):
    """A scene that is being made.

    Attributes:
        picture: (height, width, 3) uint8 BGR, of `SHOWN`.
        boxes: (N, 4) left, top, right, bottom of vehicles, as far as they are visible, px.
        areas: (N,) of the whole vehicles, px².
        ignored: (N,) of which nothing is to be said.
    """

    picture: NDArray[np.uint8]
    boxes: NDArray[np.float64]
    areas: NDArray[np.float64]
    ignored: NDArray[np.bool_]


class Window(NamedTuple):
    """A part of a picture: left, top, width and height, px."""

    left: float
    top: float
    width: float
    height: float


class Scenes:
    """Scenes of labelled pictures, which it keeps in memory.

    Raises:
        UserError: a picture cannot be read, or no vehicle that counts is large enough.
    """

    def __init__(
        self,
        images: Sequence[TrainingImage],
        settings: SceneSettings,
        advance: Callable[[], None] = lambda: None,
    ) -> None:
        self._settings = settings
        self._pictures: list[NDArray[np.uint8]] = []
        self._labels: list[LabelledImage] = []
        self._boxes: list[NDArray[np.float64]] = []
        self._vehicles: list[tuple[int, int]] = []
        clips: list[str] = []
        for number, image in enumerate(images):
            picture, labelled = image.labelled.read(), image.labelled
            scale = min(1.0, STORED_PX / max(picture.shape[:2]))
            if scale < 1.0:
                picture = np.asarray(
                    cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8
                )
            boxes = labelled.boxes * scale
            large = np.sqrt(boxes[:, 2] * boxes[:, 3]) >= LEAST_STORED_PX
            own = [(number, int(which)) for which in np.flatnonzero(large & ~labelled.ignored)]
            self._pictures.append(picture)
            self._labels.append(labelled)
            self._boxes.append(boxes)
            self._vehicles += own
            clips += [labelled.clip] * len(own)
            advance()
        if not self._vehicles:
            raise UserError(
                f"no labelled vehicle to learn from has {LEAST_STORED_PX:g} px as the square root of width "
                f"times height, in pictures made {STORED_PX} px wide or high at most; label larger ones"
            )
        self._lottery = Lottery(drawing_weights(clips))
        self._complete = [number for number, labels in enumerate(self._labels) if labels.complete]

    def __len__(self) -> int:
        """How many vehicles scenes are made around."""
        return len(self._vehicles)

    def draw(self, random: np.random.Generator) -> Scene:
        """One scene, of a picture drawn at random."""
        settings = self._settings
        shape = SHOWN.width / SHOWN.height * np.exp(random.normal(0.0, settings.shape))
        if random.uniform() < settings.around_vehicle or not self._complete:
            number, which = self._any_vehicle(random)
            picture, box = self._pictures[number], self._boxes[number][which]
            window = around_vehicle(picture, box, shape, settings, random)
        else:
            number = self._complete[random.integers(len(self._complete))]
            window = of_anything(self._pictures[number], shape, random)
        labelled = self._labels[number]
        view = seen_through(window, self._pictures[number], self._boxes[number], labelled.ignored)
        if random.uniform() < settings.bonnet_part:
            view = above_bonnet(view, random)
        if random.uniform() < settings.hidden_part:
            view = hidden_by(self._cut_out(random), view, settings.most_hidden, random)
        vehicle, reaches = cells_of(view, labelled.complete)
        picture = view.picture
        if random.uniform() < 0.5:
            picture, vehicle = picture[:, ::-1], vehicle[:, ::-1]
            reaches = reaches[[2, 1, 0, 3], :, ::-1]
        return Scene(self._varied(np.ascontiguousarray(picture), random), vehicle, reaches)

    def _any_vehicle(self, random: np.random.Generator) -> tuple[int, int]:
        return self._vehicles[self._lottery.draw(random)]

    def _cut_out(self, random: np.random.Generator) -> NDArray[np.uint8]:
        number, which = self._any_vehicle(random)
        x, y, w, h = self._boxes[number][which]
        return self._pictures[number][max(int(y), 0) : int(y + h), max(int(x), 0) : int(x + w)]

    def _varied(self, picture: NDArray[np.uint8], random: np.random.Generator) -> NDArray[np.uint8]:
        settings = self._settings
        if random.uniform() < settings.blurred_part:
            scale = 1.0 / random.uniform(1.2, 2.5)
            small = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
            picture = np.asarray(cv2.resize(small, (SHOWN.width, SHOWN.height)), np.uint8)
        if random.uniform() < settings.varied_part:
            picture = vary_looks(picture, settings.looks, random)
        return picture


def around_vehicle(
    picture: NDArray[np.uint8],
    box: NDArray[np.float64],
    shape: float,
    settings: SceneSettings,
    random: np.random.Generator,
) -> Window:
    """A window in which a vehicle, its (4,) x, y, w, h, has some size and stands where near ones stand."""
    x, y, w, h = box
    low, high = np.log(settings.sizes)
    part = np.exp(random.uniform(low, high))
    picture_height, picture_width = picture.shape[:2]
    height = min(
        np.sqrt(w * h) / part, picture_height * settings.beyond, picture_width / shape * settings.beyond
    )
    width = height * shape
    across = random.uniform(-0.02, 1.02) if random.uniform() < 0.3 else np.clip(random.normal(0.5, 0.2), 0, 1)
    down = random.uniform(0.6, 1.0) if random.uniform() < 0.75 else random.uniform(0.95, 1.3)
    down = max(down, min(0.45 + part / 2, 1.0))
    left, top = x + w / 2 - across * width, y + h - down * height
    left = np.clip(left, 0, picture_width - width) if width <= picture_width else (picture_width - width) / 2
    within = picture_height - height
    return Window(float(left), float(np.clip(top, min(0, within), max(0, within))), width, height)


def of_anything(picture: NDArray[np.uint8], shape: float, random: np.random.Generator) -> Window:
    """Some window of a picture."""
    height = min(len(picture), picture.shape[1] / shape) * np.exp(-abs(random.normal(0.0, 0.35)))
    width = height * shape
    left = random.uniform(0.0, max(picture.shape[1] - width, 0.0))
    return Window(left, random.uniform(0.0, max(len(picture) - height, 0.0)), width, height)


def seen_through(
    window: Window, picture: NDArray[np.uint8], boxes: NDArray[np.float64], ignored: NDArray[np.bool_]
) -> View:
    """What is in a window of a picture with (N, 4) boxes x, y, w, h, of which some are ignored."""
    height, width = picture.shape[:2]
    left, top = int(np.floor(window.left)), int(np.floor(window.top))
    right, bottom = int(np.ceil(window.left + window.width)), int(np.ceil(window.top + window.height))
    part = picture[max(top, 0) : bottom, max(left, 0) : right]
    beyond = (max(-top, 0), max(bottom - height, 0), max(-left, 0), max(right - width, 0))
    if any(beyond):
        part = cv2.copyMakeBorder(part, *beyond, cv2.BORDER_REPLICATE)
    how = cv2.INTER_AREA if window.height > SHOWN.height else cv2.INTER_LINEAR
    shown = np.asarray(cv2.resize(part, (SHOWN.width, SHOWN.height), interpolation=how), np.uint8)
    scale = np.array([SHOWN.width / window.width, SHOWN.height / window.height])
    corners = (boxes[:, :2] - [window.left, window.top]) * scale
    sizes = boxes[:, 2:] * scale
    return View(shown, np.hstack([corners, corners + sizes]), np.prod(sizes, axis=1), ignored)


def above_bonnet(view: View, random: np.random.Generator) -> View:
    """The same with an own bonnet, above which vehicles end."""
    height, width = view.picture.shape[:2]
    top, rise = height * random.uniform(0.78, 1.0), height * random.uniform(0.0, 0.08)
    middle = width * random.uniform(0.2, 0.8)
    edge = np.clip(top + rise * ((np.arange(width) - middle) / (width / 2)) ** 2, 0, height)
    bonnet = np.arange(height)[:, None] >= edge
    below = view.picture[int(min(top, height - 1)) :]
    colour = below.mean(axis=(0, 1)) * random.uniform(0.2, 1.3)
    paint = np.linspace(random.uniform(0.6, 1.4), random.uniform(0.6, 1.4), height)[:, None, None] * colour
    if random.uniform() < 0.5:  # the sky's reflection
        paint = 0.7 * paint + 0.3 * view.picture[::-1]
    picture = np.where(bonnet[..., None], np.clip(paint, 0, 255).astype(np.uint8), view.picture)
    middles = np.clip((view.boxes[:, 0] + view.boxes[:, 2]) / 2, 0, width - 1).astype(int)
    boxes = view.boxes.copy()
    boxes[:, 3] = np.minimum(boxes[:, 3], edge[middles])
    return view._replace(picture=picture, boxes=boxes)


def hidden_by(other: NDArray[np.uint8], view: View, most_hidden: float, random: np.random.Generator) -> View:
    """The same with another vehicle, cut out, in front of one; what it hides for the most part is ignored."""
    height, width = view.picture.shape[:2]
    left, top, right, bottom = view.boxes.T
    known = np.flatnonzero(
        ~view.ignored
        & (right - left > 24)
        & (bottom > top)
        & (top < 0.9 * height)
        & (left < width)
        & (right > 0)
    )
    if not len(known) or min(other.shape[:2]) <= 8:
        return view
    left, top, right, bottom = view.boxes[known[random.integers(len(known))]]
    other_height = (bottom - top) * np.exp(random.uniform(-0.1, 0.4))
    other_width = other_height * other.shape[1] / len(other)
    hidden = random.uniform(0.1, most_hidden) * (right - left)
    first = left + hidden - other_width if random.uniform() < 0.5 else right - hidden
    last_row = bottom + random.uniform(0.0, 0.25) * (bottom - top)
    place = np.rint([first, last_row - other_height, first + other_width, last_row]).astype(int)
    to = np.clip(place, 0, [width, height] * 2)
    if (
        np.any(place[2:] - place[:2] <= 8)
        or np.any(place[2:] - place[:2] >= 3 * width)
        or np.any(to[2:] <= to[:2])
    ):
        return view
    size = (int(place[2] - place[0]), int(place[3] - place[1]))
    shown = cv2.resize(other, size, interpolation=cv2.INTER_AREA)
    picture = view.picture.copy()
    (x, y), (x_end, y_end) = to[:2] - place[:2], to[2:] - place[:2]
    picture[to[1] : to[3], to[0] : to[2]] = shown[y:y_end, x:x_end]
    sides = np.minimum(view.boxes[:, 2:], to[2:]) - np.maximum(view.boxes[:, :2], to[:2])
    areas = np.maximum(np.prod(view.boxes[:, 2:] - view.boxes[:, :2], axis=1), 1e-6)
    covered = np.prod(np.maximum(sides, 0.0), axis=1) / areas
    return View(
        picture,
        np.vstack([view.boxes, place]),
        np.append(view.areas, float(np.prod(size))),
        np.append(view.ignored | (covered > 0.5), False),
    )


def cells_of(view: View, complete: bool) -> tuple[FloatArray, FloatArray]:
    """What cells are to say: `vehicle` and `reaches` of `Scene`.

    Args:
        view: the scene.
        complete: whether every vehicle of the picture is labelled.
    """
    height, width = view.picture.shape[:2]
    boxes = np.clip(view.boxes, 0, [width, height] * 2)
    sizes = np.maximum(boxes[:, 2:] - boxes[:, :2], 0.0)
    areas = np.prod(sizes, axis=1)
    ignored = view.ignored | (np.sqrt(areas) < LEAST_PX) | (areas < LEAST_SEEN * view.areas)
    vehicle, reaches = np.zeros((ROWS, COLUMNS), np.float32), np.ones((4, ROWS, COLUMNS), np.float32)
    x, y = ((np.arange(count) + 0.5) * CELL_PX for count in (COLUMNS, ROWS))

    def cells(low: NDArray[np.float64], high: NDArray[np.float64]) -> tuple[NDArray[np.int64], ...]:
        return np.ix_(
            np.flatnonzero((y > low[1]) & (y < high[1])), np.flatnonzero((x > low[0]) & (x < high[0]))
        )

    if not complete:
        vehicle[:] = IGNORED
        for box, size in zip(boxes[~ignored], sizes[~ignored], strict=True):
            vehicle[cells(box[:2] - AROUND * size, box[2:] + AROUND * size)] = 0.0
    for box in boxes[ignored & (areas > 0)]:
        vehicle[cells(box[:2] - 2, box[2:] + 2)] = IGNORED
    for which in np.argsort(-areas, kind="stable"):  # of two the smaller, which is in front, has the cell
        if ignored[which]:
            continue
        box, size = boxes[which], sizes[which]
        middle = (box[:2] + box[2:]) / 2
        rim, core = (np.maximum(part * size, least * CELL_PX) for part, least in ((RIM, 0.9), (CORE, 0.51)))
        around = cells(middle - rim, middle + rim)
        vehicle[around] = np.where(vehicle[around] == 0.0, IGNORED, vehicle[around])
        inside = cells(middle - core, middle + core)
        vehicle[inside] = 1.0
        rows, columns = inside
        for side, reach in enumerate(
            (x[columns] - box[0], y[rows] - box[1], box[2] - x[columns], box[3] - y[rows])
        ):
            reaches[side][inside] = np.maximum(reach, 1.0) / CELL_PX
    return vehicle, reaches
