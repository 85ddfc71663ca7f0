"""What an MCAP file knows beside its pictures: the own speed, a calibration, a field of view."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import takewhile
from operator import attrgetter
from pathlib import Path
from typing import Any

from fcw.camera.calibration import Calibration
from fcw.camera.file import parse_calibration
from fcw.sources.mcap.file import Clock, McapFile, Topic, stray_notes
from fcw.sources.mcap.pictures import PICTURE_TYPES
from fcw.sources.mcap.source import is_own_log, picture_topic
from fcw.warning.ego_speed import HIGHEST_SPEED_MPS, EgoSpeed

CALIBRATION_NAME = "calibration.yaml"
"""Attachment in which this program's logs keep their calibration; other files may have one as well."""
RESULT_TYPE = "fcw.FrameResult"
COMMAND_WORDS = ("cmd", "command", "control", "target", "desired")
"""In names of topics that say what speed somebody wants."""


def _length(get: Callable[[Any], Any]) -> Callable[[Any], float]:
    return lambda message: math.hypot(get(message).x, get(message).y, get(message).z)


def _given(message: Any) -> float:  # noqa: ANN401 - of our own schema
    """Of a log of this program what it was told; what it found in the pictures it finds again."""
    if not message.HasField("ego_speed_mps"):
        return math.nan
    motion = message.own_motion  # all its defaults where an old log has none
    return math.nan if motion.speed_source == motion.PICTURE else message.ego_speed_mps


_SPEEDS: dict[str, Callable[[Any], float]] = {
    RESULT_TYPE: _given,
    "autoware_vehicle_msgs/VelocityReport": lambda message: abs(message.longitudinal_velocity),
    "autoware_auto_vehicle_msgs/VelocityReport": lambda message: abs(message.longitudinal_velocity),
    "nav_msgs/Odometry": _length(attrgetter("twist.twist.linear")),
    "geometry_msgs/TwistWithCovarianceStamped": _length(attrgetter("twist.twist.linear")),
    "geometry_msgs/TwistStamped": _length(attrgetter("twist.linear")),
}
"""Own speed in metres per second in each type of message, the surest one first."""
_CAMERA_TYPES = ("foxglove.CameraCalibration", "foxglove_msgs/CameraCalibration", "sensor_msgs/CameraInfo")


@dataclass(frozen=True, slots=True)
class McapFacts:
    """What a file knows beside its pictures.

    Attributes:
        calibration: of its attachment; None where it has none.
        ego_speed: the own speed at the pictures' times; None where no topic, or no single one, has it.
        field_of_view_rad: horizontal, as the camera info of the pictures states it; it says nothing of where
            the camera is.
        camera_topic: where the field of view was found.
        pictures: the topic of the pictures.
        other_pictures: topics of other cameras' pictures, for which a calibration beside the file may be.
        notes: what of it a person should know.
    """

    calibration: Calibration | None
    ego_speed: EgoSpeed | None
    field_of_view_rad: float | None
    camera_topic: str
    pictures: str
    other_pictures: tuple[str, ...]
    notes: tuple[str, ...]

    def notes_on_calibration(self, beside: Path) -> tuple[str, ...]:
        """That a calibration beside the file, which names no camera, may be another one's."""
        if not self.other_pictures:
            return ()
        others = ", ".join(self.other_pictures)
        return (
            f"{beside.name}: taken as that of {self.pictures}; the file has {others} as well: name the "
            "calibration of each with --calibration",
        )


def mcap_facts(path: Path, topic: str | None = None) -> McapFacts:
    """Look through a file; its pictures are not decoded.

    Args:
        path: the file.
        topic: of its pictures, as for `open_mcap`.

    Raises:
        UserError: see `open_mcap`; or the calibration in it is damaged.
    """
    file = McapFile(path)
    pictures = picture_topic(file, topic)
    attached = file.attachment(CALIBRATION_NAME)
    calibration = None
    if attached is not None:
        calibration = parse_calibration(attached.decode("utf-8", "replace"), f"{path}: {CALIBRATION_NAME}")
    ego_speed, notes = _ego_speed(file, Clock.of(file, pictures.name).stamps and not is_own_log(file))
    field_of_view_rad, camera_topic = _field_of_view(file, pictures)
    others = _others(file, pictures)
    return McapFacts(calibration, ego_speed, field_of_view_rad, camera_topic, pictures.name, others, notes)


def _ego_speed(file: McapFile, stamps: bool) -> tuple[EgoSpeed | None, tuple[str, ...]]:
    """The own speed, and in words where it is from or why it is not used."""
    notes: tuple[str, ...] = ()
    for kind, speed_of in _SPEEDS.items():
        topics = [
            topic.name
            for topic in file.topics
            if topic.type == kind
            and topic.readable
            and topic.count != 0
            and not any(word in topic.name.lower() for word in COMMAND_WORDS)
        ]
        if len(topics) > 1:
            return None, (
                *notes,
                f"{file.path.name}: the own speed may be in {' or '.join(topics)} ({kind}); "
                "none is used: give it with --ego-speed",
            )
        if topics:
            speed, strays, beyond = _speeds(file, topics[0], speed_of, stamps)
            if speed is not None and (kind == RESULT_TYPE or any(speed.speeds_mps)):
                label = f"{file.path.name}: {topics[0]}"
                notes += (f"{file.path.name}: own speed from {topics[0]} ({kind})",)
                if beyond:
                    notes += (f"{label}: {beyond} of its speeds, beyond {HIGHEST_SPEED_MPS:g} m/s, left out",)
                return speed, (*notes, *stray_notes(label, strays, "message"))
            if beyond and speed is None:
                notes += (
                    f"{file.path.name}: the own speed in {topics[0]} ({kind}) is beyond "
                    f"{HIGHEST_SPEED_MPS:g} m/s throughout: it is not used; "
                    "if it is in km/h, give it with --ego-speed in m/s",
                )
            elif speed is not None:
                # Who knows only places leaves the speed empty; if we stood, nothing would be warned of.
                notes += (
                    f"{file.path.name}: the own speed in {topics[0]} ({kind}) is 0 throughout, as where "
                    "nobody filled it in: it is not used; if you stood, give it with --ego-speed 0",
                )
    return None, notes


def _speeds(
    file: McapFile, topic: str, speed_of: Callable[[Any], float], stamps: bool
) -> tuple[EgoSpeed | None, int, int]:
    """The speeds of a topic in the order of their times; how many stamps are stray; how many no car's."""
    speeds_mps: dict[float, float] = {}
    strays = beyond = 0
    for message, time_ns, stray in Clock(stamps, 0).timed(file.messages([topic])):
        speed_mps = message.read(lambda content: float(speed_of(content)))
        if speed_mps is None or not 0 <= speed_mps <= HIGHEST_SPEED_MPS:
            beyond += speed_mps is not None and speed_mps > HIGHEST_SPEED_MPS
            continue
        speeds_mps.setdefault(time_ns / 1e9, speed_mps)
        strays += stray
    if not speeds_mps:
        return None, strays, beyond
    times_s = sorted(speeds_mps)
    return EgoSpeed(tuple(times_s), tuple(speeds_mps[time_s] for time_s in times_s)), strays, beyond


def _field_of_view(file: McapFile, pictures: Topic) -> tuple[float | None, str]:
    """Of the camera info with a focal length that belongs to a topic of pictures: the nearest by its name.

    One that is nearer to other pictures is another camera's. Of several that are as near, one that names the
    pictures' own frame of reference goes first.
    """
    first = next(file.messages([pictures.name]), None)
    frame_id = None if first is None else first.read(_frame_id)
    others = _others(file, pictures)
    found: list[tuple[int, bool, float, str]] = []
    for topic in file.topics:
        if topic.type not in _CAMERA_TYPES or not topic.readable:
            continue
        shared = _shared_levels(topic.name, pictures.name)
        message = next(file.messages([topic.name]), None)
        angle_rad = None if message is None else message.read(_angle_of_view_rad)
        if message is None or angle_rad is None:
            continue
        if all(_shared_levels(topic.name, other) <= shared for other in others):
            found.append((shared, message.read(_frame_id) == frame_id, angle_rad, topic.name))
    nearest = max((one[:2] for one in found), default=None)
    best = [one for one in found if one[:2] == nearest]
    if len({angle_rad for _, _, angle_rad, _ in best}) != 1:
        return None, ""  # whose any of them is cannot be told
    return best[0][2:]


def _others(file: McapFile, pictures: Topic) -> tuple[str, ...]:
    """The other topics that have pictures."""
    of_pictures = (topic for topic in file.topics if topic.type in PICTURE_TYPES and topic.count != 0)
    return tuple(topic.name for topic in of_pictures if topic.name != pictures.name)


def _shared_levels(a: str, b: str) -> int:
    """How many levels the names of two topics share: `/front/image/compressed` and `/front/info` one."""
    pairs = zip(a.strip("/").split("/"), b.strip("/").split("/"), strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))


def _frame_id(content: Any) -> str:  # noqa: ANN401 - of any schema
    header = getattr(content, "header", None)
    return str(content.frame_id if header is None else header.frame_id)


def _angle_of_view_rad(content: Any) -> float | None:  # noqa: ANN401 - of any schema
    matrix = getattr(content, "K", None) or getattr(content, "k", None) or ()
    if len(matrix) != 9 or not matrix[0] > 0:
        return None
    return 2 * math.atan(content.width / (2 * matrix[0]))
