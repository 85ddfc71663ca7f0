"""Boxes of simulated vehicles as detectors give them: noisy, late, lost, wrong, cut, and without own motion.

What drives that nobody tuned to taught: the detector is silent for many frames, finds vehicles late and near,
and boxes a part of them; and the own speed is unknown. A danger that is in sight must be warned of all the
same.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.detector import Detection
from fcw.evaluation.distance.kitti import BOTTOM_NOISE_RATIO
from fcw.frame import ImageSize
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth
from fcw.simulation.world.scenario import FRAMES_PER_SECOND, IMAGE_SIZE

SEEN_FRACTION = 0.5
"""A detector finds a vehicle of which so much is visible."""
ACROSS_RATIO = 2.0
"""A body that is so many times as wide as its near face stands across the road."""
SMALLEST_PX = 6.0
FAULT_EVERY_S = 2.5
"""Mean time between two faults of the boxes of one vehicle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """How well vehicles are found, at the level of boxes.

    Attributes:
        name: in the results.
        noise_px: 1-sigma of the sides of the boxes, 1.5 times that of the lower edge.
        farthest_m: from the bumper; farther ones are not found.
        lost_part: part of the frames in which a vehicle is not found.
        lost_s: how long it is not found each time.
        seen_s: how long a vehicle is found in all, from the first time on.
        fault_s: duration of the faults of a box, which come every 2.5 s in the mean; 0 for none.
        height_part: by how much a fault makes a box taller or less tall, at its lower edge.
        boxed_part: a fault boxes this part of the vehicle's width alone, at one of its sides.
        shown: part of the picture's width and height that the camera shows, from the top left corner; what is
            beyond is cut off.
        own_motion: whether own motion is measured; without, own speed, turning and mount are unknown.
    """

    name: str = "as usual"
    noise_px: float = 2.0
    farthest_m: float = 80.0
    lost_part: float = 0.0
    lost_s: float = 0.2
    seen_s: float = math.inf
    fault_s: float = 0.0
    height_part: float = 0.0
    boxed_part: float = 1.0
    shown: tuple[float, float] = (1.0, 1.0)
    own_motion: bool = True

    @property
    def image_size(self) -> ImageSize:
        """Of the picture that is shown."""
        return ImageSize(
            round(IMAGE_SIZE.width * self.shown[0]),
            round(IMAGE_SIZE.height * self.shown[1]),
        )

    def calibration(self, calibration: Calibration) -> Calibration:
        """That of the picture that is shown; the axis stays where it is."""
        return calibration if self.shown == (1.0, 1.0) else replace(calibration, image_size=self.image_size)


USUAL_SIGHT = Sight()
SIGHTS = (
    USUAL_SIGHT,
    Sight(name="4 px of noise", noise_px=4.0),
    Sight(name="found at 15 m", farthest_m=15.0),
    Sight(name="lost in 30 %", lost_part=0.3),
)
WORSE_SIGHTS = (
    USUAL_SIGHT,
    Sight(name="5 px of noise", noise_px=5.0),
    Sight(name="lost in 30 %", lost_part=0.3),
    Sight(name="lost in 60 %", lost_part=0.6),
    Sight(name="found at 15 m", farthest_m=15.0),
    Sight(name="found at 10 m", farthest_m=10.0),
    Sight(name="at 15 m, for 0.6 s", farthest_m=15.0, seen_s=0.6),
    Sight(name="10 % too tall or low", fault_s=1.0, height_part=0.1),
    Sight(name="a part boxed", fault_s=0.5, boxed_part=0.6),
    Sight(name="cut by the picture", shown=(0.75, 0.75)),
    Sight(name="no own motion", own_motion=False),
)
"""The usual one, and those of a worse detector."""


@dataclass(slots=True)
class _Memory:
    """What befell the boxes of one vehicle so far; times in seconds."""

    first_s: float
    fault_until_s: float = -math.inf
    fault: float = 0.0


class Eye:
    """Sees the vehicles of one drive.

    Args:
        sight: how well.
        seed: of all that is random.
    """

    def __init__(self, sight: Sight, seed: int) -> None:
        self._sight = sight
        self._noise = np.random.default_rng(seed)
        self._losses = np.random.default_rng([seed, 2])
        self._faults = np.random.default_rng([seed, 3])
        self._lost_until_s = 0.0
        self._memories: dict[str, _Memory] = {}

    def see(self, truth: FrameTruth) -> dict[str, Detection]:
        """What is found in a frame, by the name of the vehicle."""
        sight, time_s = self._sight, truth.time_ns / 1e9
        found = dict(self._boxes(truth, time_s))
        # Lost for a while so often that the part of it comes out.
        begins = sight.lost_part / max(1 - sight.lost_part, 0.01) / (sight.lost_s * FRAMES_PER_SECOND)
        if time_s >= self._lost_until_s and self._losses.random() < begins:
            self._lost_until_s = time_s + sight.lost_s
        return {} if time_s < self._lost_until_s else found

    def _boxes(self, truth: FrameTruth, time_s: float) -> Iterator[tuple[str, Detection]]:
        """The whole bodies as a detector draws them, cut at the picture's border."""
        sight, size = self._sight, self._sight.image_size
        for vehicle in truth.vehicles:
            noise_px = sight.noise_px * np.array([1.0, 1.0, 1.0, BOTTOM_NOISE_RATIO])
            noise_px *= self._noise.standard_normal(4)
            if part_seen(vehicle, size) < SEEN_FRACTION or vehicle.distance_m > sight.farthest_m:
                continue
            memory = self._memories.setdefault(vehicle.name, _Memory(time_s))
            if time_s - memory.first_s > sight.seen_s:
                continue
            # The lower edge is that of the near face.
            body = vehicle.body_box
            left, right = body.x, body.right
            top, bottom = body.y, vehicle.box.bottom
            fault = self._fault(memory, time_s)
            bottom += fault * sight.height_part * (bottom - top)
            hidden_px = abs(fault) * (1 - sight.boxed_part) * (right - left)
            left, right = (left + hidden_px, right) if fault > 0 else (left, right - hidden_px)
            edges = np.array([left, top, right, bottom]) + noise_px
            left, right = np.clip(edges[[0, 2]], 0, size.width - 1).tolist()
            top, bottom = np.clip(edges[[1, 3]], 0, size.height - 1).tolist()
            if min(right - left, bottom - top) >= SMALLEST_PX:
                yield vehicle.name, Detection(Box(left, top, right - left, bottom - top), 1.0)

    def _fault(self, memory: _Memory, time_s: float) -> float:
        """The sign of the fault that a box has now; 0 for none."""
        sight = self._sight
        if sight.fault_s == 0:
            return 0.0
        if time_s >= memory.fault_until_s:
            begins = 1 / (FAULT_EVERY_S - sight.fault_s) / FRAMES_PER_SECOND
            memory.fault = 0.0
            if self._faults.random() < begins:
                memory.fault = float(self._faults.choice((-1.0, 1.0)))
                memory.fault_until_s = time_s + sight.fault_s
        return memory.fault


def part_seen(vehicle: VehicleTruth, size: ImageSize = IMAGE_SIZE) -> float:
    """How much of a vehicle is seen: of its near face, or, where it stands across, of its side."""
    body = vehicle.body_box
    if body.w > ACROSS_RATIO * vehicle.box.w:
        # Its near face is an end of it, and what is seen is its side.
        return max(vehicle.visible_fraction, _part_across(body, size))
    if size == IMAGE_SIZE:
        return vehicle.visible_fraction
    return min(vehicle.visible_fraction, _part_across(vehicle.box, size))


def _part_across(box: Box, size: ImageSize) -> float:
    width = min(box.right, size.width) - max(box.x, 0.0)
    return max(width, 0.0) / box.w
