"""Scenarios: what happens on a drive, as small typed files (`scenarios/*.yaml`).

Degrees and km/h stand in the files, as people write them; the program has radians and m/s.
"""

import math
from dataclasses import dataclass
from pathlib import Path

from fcw.bounded.files import MalformedError, read_text
from fcw.bounded.formats import MOST_YAML_BYTES, yaml_value
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.simulation.world.state import VehicleKind
from fcw.simulation.world.typed_yaml import read_dataclass

SCENARIO_FOLDER = Path(__file__).parent / "scenarios"
THREAT_FOLDER = SCENARIO_FOLDER / "threats"
IMAGE_SIZE = ImageSize(1280, 720)
FRAMES_PER_SECOND = 30
MPS_PER_KMH = 1 / 3.6
LONGEST_S = 3600.0
ON_GLASS = ("bonnet", "logo")


def _require(holds: bool, field: str, value: object, expected: str) -> None:
    if not holds:
        raise ValueError(f"{field} is {value!r}, expected {expected}")


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraPlan:
    """The camera behind the windscreen.

    Attributes:
        height_m: above the road.
        pitch_deg: down from the horizontal.
        focal_px: focal length.
        reference_offset_m: from the camera forward to the front bumper.
    """

    height_m: float = 1.3
    pitch_deg: float = 1.7
    focal_px: float = 1000.0
    reference_offset_m: float = 1.6

    def __post_init__(self) -> None:
        for name in ("height_m", "focal_px"):
            _require(0 < getattr(self, name) <= 1e5, name, getattr(self, name), "a number above 0")
        _require(self.reference_offset_m >= 0, "reference_offset_m", self.reference_offset_m, "0 or more")
        _require(abs(self.pitch_deg) < 15, "pitch_deg", self.pitch_deg, "an angle between -15 and 15")

    def camera(self) -> GroundPlaneCamera:
        """The camera, its axis through the picture's middle."""
        return GroundPlaneCamera(
            math.radians(self.pitch_deg),
            self.focal_px,
            (IMAGE_SIZE.height - 1) / 2,
            self.height_m,
            (IMAGE_SIZE.width - 1) / 2,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class BendPlan:
    """A bend: its smallest radius, at its middle, is positive to the left."""

    start_m: float
    length_m: float
    radius_m: float

    def __post_init__(self) -> None:
        _require(self.length_m > 0, "length_m", self.length_m, "a number above 0")
        _require(abs(self.radius_m) >= 50, "radius_m", self.radius_m, "50 or more, or -50 or less")


@dataclass(frozen=True, slots=True, kw_only=True)
class GradePlan:
    """A slope: its steepest part, at its middle, in per cent, positive uphill."""

    start_m: float
    length_m: float
    percent: float

    def __post_init__(self) -> None:
        _require(self.length_m > 0, "length_m", self.length_m, "a number above 0")
        _require(abs(self.percent) <= 20, "percent", self.percent, "a number between -20 and 20")


@dataclass(frozen=True, slots=True, kw_only=True)
class BarrierPlan:
    """A crash barrier along one edge of the road."""

    start_m: float
    length_m: float
    left: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadPlan:
    """The road and what is around it.

    Attributes:
        lane_width_m: of every lane.
        lanes_left: lanes of our direction to the left of lane 0, where we start.
        lanes_right: lanes of our direction to its right.
        opposing_lanes: lanes of oncoming traffic, left of all of ours.
        median_m: between ours and theirs; a barrier stands on one wider than 1.5 m.
        shoulder_m: asphalt beyond the outermost lines.
        roughness: 1 is a good main road; the pitch it shakes into the camera is proportional to it.
        bends: of the whole road.
        grades: of the whole road.
        marks_m: distances, from the bumper at the start, of marks painted in lane 0.
        trees_per_km: on both sides together.
        barriers: where there are any.
        bridges_m: where a bridge crosses.
        signs_m: where a sign stands.
    """

    lane_width_m: float = 3.5
    lanes_left: int = 0
    lanes_right: int = 0
    opposing_lanes: int = 0
    median_m: float = 0.3
    shoulder_m: float = 1.2
    roughness: float = 1.0
    bends: tuple[BendPlan, ...] = ()
    grades: tuple[GradePlan, ...] = ()
    marks_m: tuple[float, ...] = (6.0, 15.0, 30.0)
    trees_per_km: float = 60.0
    barriers: tuple[BarrierPlan, ...] = ()
    bridges_m: tuple[float, ...] = ()
    signs_m: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        _require(2 <= self.lane_width_m <= 6, "lane_width_m", self.lane_width_m, "2 to 6 m")
        for name in ("lanes_left", "lanes_right", "opposing_lanes"):
            _require(0 <= getattr(self, name) <= 4, name, getattr(self, name), "0 to 4")
        for name, most in (("median_m", 100), ("shoulder_m", 100), ("roughness", 20), ("trees_per_km", 1000)):
            _require(0 <= getattr(self, name) <= most, name, getattr(self, name), f"0 to {most}")
        marks = self.marks_m
        _require(
            len(marks) == 3 and 0 < marks[0] < marks[1] < marks[2],
            "marks_m",
            list(marks),
            "three ascending distances",
        )

    def lane_middle_m(self, lane: int) -> float:
        """Lateral position of a lane's middle; beyond our own lanes come the median and the opposing ones."""
        return lane * self.lane_width_m + (self.median_m if lane > self.lanes_left else 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Action:
    """What a driver begins to do at a time: exactly one of a speed, following, another lane, or a place.

    Attributes:
        at_s: when.
        speed_kmh: go to this speed at `rate_mps2` and hold it, whatever is ahead.
        rate_mps2: acceleration or deceleration, always positive.
        follow_kmh: go up to this speed and keep `headway_s` to the vehicle ahead in the lane.
        headway_s: time gap when following.
        reaction_s: when following, time that passes before the brakes are used, once that is needed.
        lane: change to this lane, counted from ours at the start, positive to the left.
        offset_m: go to this place across the road, from the middle of lane 0, positive to the left.
        over_s: how long the change of lane or place takes.
    """

    at_s: float
    speed_kmh: float | None = None
    rate_mps2: float = 1.5
    follow_kmh: float | None = None
    headway_s: float = 1.5
    reaction_s: float = 0.0
    lane: int | None = None
    offset_m: float | None = None
    over_s: float = 3.0

    def __post_init__(self) -> None:
        named = {
            "speed_kmh": self.speed_kmh,
            "follow_kmh": self.follow_kmh,
            "lane": self.lane,
            "offset_m": self.offset_m,
        }
        chosen = [name for name, value in named.items() if value is not None]
        _require(len(chosen) == 1, "action", chosen, f"exactly one of {', '.join(named)}")
        for name in ("speed_kmh", "follow_kmh"):
            value = named[name]
            _require(value is None or 0 <= value <= 250, name, value, "0 to 250")
        for name in ("rate_mps2", "headway_s", "over_s"):
            _require(0 < getattr(self, name) <= 1e5, name, getattr(self, name), "a number above 0")
        _require(self.reaction_s >= 0, "reaction_s", self.reaction_s, "0 or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class EgoPlan:
    """Our own drive.

    Attributes:
        speed_kmh: at the start.
        actions: what we do; until the first one the speed is kept.
    """

    speed_kmh: float = 0.0
    actions: tuple[Action, ...] = ()

    def __post_init__(self) -> None:
        _require(0 <= self.speed_kmh <= 250, "speed_kmh", self.speed_kmh, "0 to 250")


@dataclass(frozen=True, slots=True, kw_only=True)
class VehiclePlan:
    """Another vehicle's drive.

    Attributes:
        name: unique.
        gap_m: at the start, from our front bumper along the road to the face it turns to us (to its rear, or
            to the front of an oncoming one); negative when it starts behind that.
        speed_kmh: at the start; an oncoming one's towards us.
        kind: how it looks; the seed chooses where it is not given.
        lane: counted from ours at the start, positive to the left.
        offset_m: from the lane's middle, positive to the left.
        oncoming: whether it comes towards us.
        parked: whether it only stands there, lamps off.
        actions: what its driver does; until the first one the speed is kept. One who never drives along the
            road crosses it, and faces where he goes.
    """

    name: str
    gap_m: float
    speed_kmh: float = 0.0
    kind: VehicleKind | None = None
    lane: int = 0
    offset_m: float = 0.0
    oncoming: bool = False
    parked: bool = False
    actions: tuple[Action, ...] = ()

    def __post_init__(self) -> None:
        _require(0 <= self.speed_kmh <= 250, "speed_kmh", self.speed_kmh, "0 to 250")
        moves = self.speed_kmh > 0 or bool(self.actions)
        _require(not (self.parked and moves), "parked", True, "neither speed nor actions with it")
        follows = any(action.follow_kmh is not None for action in self.actions)
        _require(not (self.oncoming and follows), "follow_kmh", "given", "speeds only for oncoming vehicles")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """A drive: the road, ourselves, the others.

    Attributes:
        description: one sentence for a person.
        duration_s: of the drive.
        camera: where we look from.
        road: where we drive.
        ego: how we drive.
        vehicles: how the others drive.
        danger: name of the vehicle that we hit if nobody warns us; empty where there is nothing to warn of.
        on_glass: what the camera sees of its own car: `bonnet`, `logo`.
        timing_jitter_s: actions of the others begin up to this much earlier or later, by the seed.
    """

    description: str
    duration_s: float
    ego: EgoPlan
    camera: CameraPlan = CameraPlan()
    road: RoadPlan = RoadPlan()
    vehicles: tuple[VehiclePlan, ...] = ()
    danger: str = ""
    on_glass: tuple[str, ...] = ()
    timing_jitter_s: float = 0.2

    def __post_init__(self) -> None:
        _require(0 < self.duration_s <= LONGEST_S, "duration_s", self.duration_s, f"0 to {LONGEST_S:g}")
        one_picture = f"1/{FRAMES_PER_SECOND}, a picture, or more"
        _require(self.frame_count > 0, "duration_s", self.duration_s, one_picture)
        _require(self.timing_jitter_s >= 0, "timing_jitter_s", self.timing_jitter_s, "0 or more")
        names = [vehicle.name for vehicle in self.vehicles]
        _require(len(set(names)) == len(names), "vehicles", names, "names that differ")
        _require(self.danger in ("", *names), "danger", self.danger, f"one of {', '.join(names)}, or nothing")
        for thing in self.on_glass:
            _require(thing in ON_GLASS, "on_glass", thing, f"one of {', '.join(ON_GLASS)}")
        lanes = range(-self.road.lanes_right, self.road.lanes_left + self.road.opposing_lanes + 1)
        for plan in (self.ego, *self.vehicles):
            used = [action.lane for action in plan.actions if action.lane is not None]
            if isinstance(plan, VehiclePlan):
                used.append(plan.lane)
            for lane in used:
                _require(lane in lanes, "lane", lane, f"{lanes[0]} to {lanes[-1]}, the road's lanes")

    @property
    def frame_count(self) -> int:
        """Number of frames."""
        return round(self.duration_s * FRAMES_PER_SECOND)


def scenario_names() -> list[str]:
    """The scenarios that ship with the program."""
    return sorted(path.stem for path in SCENARIO_FOLDER.glob("*.yaml"))


def threat_names() -> list[str]:
    """The short scenarios of dangers, and of what looks like one, that ship with the program."""
    return sorted(path.stem for path in THREAT_FOLDER.glob("*.yaml"))


def load_scenario(name: str) -> Scenario:
    """A scenario that ships with the program, by name, or one's own by the path of its file.

    Raises:
        UserError: there is none, or the file is not a scenario; the message names file, field and mend.
    """
    folders = ((SCENARIO_FOLDER, scenario_names()), (THREAT_FOLDER, threat_names()))
    path = next((folder / f"{name}.yaml" for folder, names in folders if name in names), Path(name))
    try:
        text = read_text(path, MOST_YAML_BYTES)
    except (OSError, MalformedError) as error:
        raise UserError(
            f"scenario {name}: cannot be read ({getattr(error, 'strerror', None) or error}); "
            f"expected one of {', '.join((*scenario_names(), *threat_names()))}, "
            "or the path of a scenario file"
        ) from None
    try:
        document = yaml_value(text)
    except MalformedError as error:
        raise UserError(f"{path}: not a YAML file ({error})") from error
    return read_dataclass(Scenario, document, str(path))
