"""What an MCAP file knows beside its pictures: the own speed, a calibration, a field of view."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import takewhile
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.camera.file import parse_calibration
from fcw.camera.lens.files import MODELS
from fcw.camera.lens.model import COEFFICIENT_COUNTS, Lens
from fcw.frame import ImageSize
from fcw.logs.mcap.format import CALIBRATION_NAME
from fcw.sources.mcap.file import Clock, McapFile, Topic, stray_notes
from fcw.sources.mcap.pictures import PICTURE_TYPES
from fcw.sources.mcap.source import is_own_log, picture_topic
from fcw.warning.ego_speed import HIGHEST_SPEED_MPS, EgoSpeed

RESULT_TYPE = "fcw.FrameResult"
RECTIFIED = "rect"
"""In names of topics whose pictures were made straight: ROS's image_rect, image_rect_color."""
LEAST_BENT_PX = 1.0
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
        bent_px: how far that camera info's lens moves a corner of the picture.
    """

    calibration: Calibration | None
    ego_speed: EgoSpeed | None
    field_of_view_rad: float | None
    camera_topic: str
    pictures: str
    other_pictures: tuple[str, ...]
    notes: tuple[str, ...]
    bent_px: float = 0.0

    def notes_on_lens(self, calibration: Calibration) -> tuple[str, ...]:
        """That the file knows a lens that bends lines, and the calibration of its pictures none."""
        if calibration.lens is not None or self.bent_px < LEAST_BENT_PX or RECTIFIED in self.pictures.lower():
            return ()
        return (
            f"by {self.camera_topic} the lens moves the picture's corners by {self.bent_px:.0f} px, and the "
            "calibration has no lens: unless these pictures are rectified, distances are off beside the "
            "middle; give the lens with `fcw calibrate --lens`",
        )

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
    field_of_view_rad, camera_topic, bent_px = _camera_info(file, pictures)
    others = _others(file, pictures)
    return McapFacts(
        calibration, ego_speed, field_of_view_rad, camera_topic, pictures.name, others, notes, bent_px
    )


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
                f"{file.path.name}: the own speed may be in {' or '.join(topics)} ({kind}); none of them "
                "is used: give the own speed with --ego-speed",
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
                    f"{file.path.name}: the own speed in {topics[0]} ({kind}) is 0 throughout, as if never "
                    "filled in: it is not used; if the car stood, give --ego-speed 0",
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


def _camera_info(file: McapFile, pictures: Topic) -> tuple[float | None, str, float]:
    """Of the camera info with a focal length that belongs to a topic of pictures: the nearest by its name.

    Its field of view, its topic, and how far it bends the picture.

    One that is nearer to other pictures is another camera's. Of several that are as near, one that names the
    pictures' own frame of reference goes first.
    """
    first = next(file.messages([pictures.name]), None)
    frame_id = None if first is None else first.read(_frame_id)
    others = _others(file, pictures)
    found: list[tuple[int, bool, float, str, float]] = []
    for topic in file.topics:
        if topic.type not in _CAMERA_TYPES or not topic.readable:
            continue
        shared = _shared_levels(topic.name, pictures.name)
        message = next(file.messages([topic.name]), None)
        angle_rad = None if message is None else message.read(_angle_of_view_rad)
        if message is None or angle_rad is None:
            continue
        if all(_shared_levels(topic.name, other) <= shared for other in others):
            same_frame, bent_px = message.read(_frame_id) == frame_id, message.read(_bent_px) or 0.0
            found.append((shared, same_frame, angle_rad, topic.name, bent_px))
    nearest = max((one[:2] for one in found), default=None)
    best = [one for one in found if one[:2] == nearest]
    if len({angle_rad for _, _, angle_rad, *_ in best}) != 1:
        return None, "", 0.0  # whose any of them is cannot be told
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


def _bent_px(content: Any) -> float:  # noqa: ANN401 - of any schema
    """How far a lens moves the corner of the picture from where one without distortion has it."""
    model, width, height = MODELS.get(content.distortion_model), content.width, content.height
    k = getattr(content, "K", None) or content.k
    coefficients = tuple(float(d) for d in getattr(content, "D", None) or content.d)
    known = model is not None and len(coefficients) in COEFFICIENT_COUNTS[model]
    if model is None or not known or not any(coefficients) or not min(k[0], k[4]) > 0:
        return 0.0
    lens = Lens(model, k[0], k[4], k[2], k[5], coefficients, ImageSize(width, height))
    corners = np.array([(column, row) for column in (0.0, width - 1.0) for row in (0.0, height - 1.0)])
    rays = (corners - (k[2], k[5])) / (k[0], k[4])
    moved_px = np.linalg.norm(lens.distorted(rays) - corners, axis=1)
    return float(np.nan_to_num(moved_px.max(), posinf=0.0))
