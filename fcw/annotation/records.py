"""What a person can say about a recorded drive, and the entry that stores it.

Times are seconds from the first frame of the drive, as in `fcw.logs.events`. Frames are identified by their
index in the log, which never changes. Boxes are in pixels of the log's pictures.
"""

import uuid
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar, get_args

from fcw.box import Box
from fcw.errors import UserError
from fcw.warning.types import WarningLevel

LONGEST_DRIVE_S = 1e9
"""Thirty years; a later time comes from damage."""
FARTHEST_PX = 1e5
"""Largest coordinate of a box; pictures have at most 16384 pixels a side, and boxes reach out of them."""


class Judgement(Enum):
    """How a person judges a warning; the value is the text on the page."""

    RIGHT = "right"
    TOO_EARLY = "too early"
    TOO_LATE = "too late"
    FALSE = "false"


class Reason(Enum):
    """Why a warning was wrong; the value is the text on the page.

    The reasons follow the questions by which alerts in field tests are classified: was there a vehicle, was
    it in the path, what did it or the driver do, was it measured correctly.
    """

    NO_VEHICLE = "no vehicle there: a shadow, sign, bridge or reflection"
    OTHER_LANE = "vehicle in another lane"
    CURVE = "vehicle beside the path in a curve"
    PARKED = "parked, or at the roadside"
    ONCOMING = "oncoming vehicle"
    LEFT_PATH = "vehicle ahead turned off or left the lane"
    OWN_MANOEUVRE = "driver was changing lanes, turning or overtaking"
    DRIVER_AWARE = "driver was braking already"
    CUT_IN = "vehicle cut in"
    FOUND_LATE = "vehicle was found late"
    TRACK_JUMPED = "track jumped to another vehicle"
    WRONG_DISTANCE = "distance or closing speed was wrong"
    OTHER = "another reason"


REASONS: dict[Judgement, tuple[Reason, ...]] = {
    Judgement.RIGHT: (),
    Judgement.TOO_EARLY: (
        Reason.DRIVER_AWARE,
        Reason.LEFT_PATH,
        Reason.OWN_MANOEUVRE,
        Reason.WRONG_DISTANCE,
        Reason.OTHER,
    ),
    Judgement.TOO_LATE: (
        Reason.FOUND_LATE,
        Reason.CUT_IN,
        Reason.TRACK_JUMPED,
        Reason.WRONG_DISTANCE,
        Reason.OTHER,
    ),
    Judgement.FALSE: tuple(reason for reason in Reason if reason not in (Reason.CUT_IN, Reason.FOUND_LATE)),
}
"""The reasons for each judgement, the most frequent ones first."""


@dataclass(frozen=True, slots=True)
class EventReference:
    """The event that a verdict is about, so that it is found again after the rules for events have changed.

    Attributes:
        kind: kind of the `fcw.logs.events.DriveEvent`.
        track_id: the vehicle that it was about; None if there was none.
        start_s: when it began.
        end_s: when it ended.
    """

    kind: str
    track_id: int | None
    start_s: float
    end_s: float

    def __post_init__(self) -> None:
        _check_span(self.start_s, self.end_s)


@dataclass(frozen=True, slots=True)
class Verdict:
    """A person's judgement of an event; a later one by the same person on the same event replaces it.

    Attributes:
        event: the event.
        judgement: the judgement.
        reason: one of `REASONS[judgement]`; None if none was given.
        text: a remark in the person's own words.
    """

    event: EventReference
    judgement: Judgement
    reason: Reason | None = None
    text: str = ""

    def __post_init__(self) -> None:
        if self.reason is not None and self.reason not in REASONS[self.judgement]:
            raise UserError(
                f"verdict {self.judgement.value!r}: {self.reason.value!r} is no reason for it; choose another"
            )


@dataclass(frozen=True, slots=True)
class MissedEvent:
    """A time in which a warning should have been shown but was not.

    Attributes:
        start_s: when the warning was due.
        end_s: until when it would have helped.
        text: what happened.
        level: the level that was due.
    """

    start_s: float
    end_s: float
    text: str
    level: WarningLevel = WarningLevel.WARNING

    def __post_init__(self) -> None:
        _check_span(self.start_s, self.end_s)
        if self.level == WarningLevel.NONE:
            raise UserError("missed event: expected the level of the warning that was due, not none")


@dataclass(frozen=True, slots=True)
class Note:
    """A free remark on a moment."""

    time_s: float
    text: str

    def __post_init__(self) -> None:
        if not abs(self.time_s) <= LONGEST_DRIVE_S:
            raise UserError(f"note at {self.time_s:g} s: expected a moment of the drive")
        if not self.text.strip():
            raise UserError("note: it is empty; write something first")


class View(Enum):
    """The side from which a vehicle is seen; the value is written into labels."""

    REAR = "rear"
    REAR_QUARTER = "rear-quarter"
    SIDE = "side"
    FRONT = "front"
    UNCLEAR = "unclear"


class VehicleKind(Enum):
    """The kind of a vehicle; the value is written into labels."""

    CAR = "car"
    SUV = "suv"
    VAN = "van"
    TRUCK = "truck"
    BUS = "bus"


class MadeBy(Enum):
    """How a box of a frame was made; the value is the text on the page."""

    HAND = "by hand"
    COPIED = "copied"
    INTERPOLATED = "interpolated"
    FOLLOWED = "followed"


MOST_OCCLUDED = 2
"""0: not hidden, 1: by up to about 40 %, 2: by more."""


@dataclass(frozen=True, slots=True)
class LabelledBox:
    """The label of a vehicle by a person.

    Attributes:
        box: its box; both sides are longer than 0, no coordinate is beyond `FARTHEST_PX`.
        track_id: the track of the log that it belongs to; None if it belongs to none.
        ignore: whether it is neither a vehicle to find nor background: hidden, too far, another view.
        view: the side from which it is seen; None if not stated.
        kind: kind of the vehicle; None if not stated.
        occluded: how much of it is hidden, 0 to `MOST_OCCLUDED`; None if not stated.
        rear_box: its rear face alone, if the box contains a side too; None if not stated.
    """

    box: Box
    track_id: int | None = None
    ignore: bool = False
    view: View | None = None
    kind: VehicleKind | None = None
    occluded: int | None = None
    rear_box: Box | None = None

    def __post_init__(self) -> None:
        for box in (self.box, self.rear_box):
            if box is None:
                continue
            near = all(abs(number) <= FARTHEST_PX for number in (box.x, box.y, box.w, box.h))
            if not (near and box.w > 0 and box.h > 0):
                raise UserError(
                    f"box {box.x:g}, {box.y:g}, {box.w:g} x {box.h:g}: expected one with an area, "
                    f"within {FARTHEST_PX:.0f} pixels"
                )
        if self.occluded is not None and not 0 <= self.occluded <= MOST_OCCLUDED:
            raise UserError(f"occluded {self.occluded}: expected 0 to {MOST_OCCLUDED}")


@dataclass(frozen=True, slots=True)
class BoxEdit:
    """A correction, addition or deletion of a box in one frame; the latest edit of the same box counts.

    Attributes:
        frame_index: the frame, `FrameResult.index`.
        box_id: the box in the frame: `track_box_id` for that of a track of the log, `new_box_id` for one
            that a person added.
        label: the box as it should be; None if there should be none.
        made_by: how it was made; between two boxes drawn by hand, others are interpolated.
    """

    frame_index: int
    box_id: str
    label: LabelledBox | None
    made_by: MadeBy = MadeBy.HAND


@dataclass(frozen=True, slots=True)
class FrameConfirmed:
    """All boxes of a frame, with the edits so far, are right, and every vehicle has one."""

    frame_index: int


@dataclass(frozen=True, slots=True)
class TakenBack:
    """Undoes an earlier entry of the same person; this can be taken back too."""

    entry_id: str


Said = Verdict | MissedEvent | Note | BoxEdit | FrameConfirmed | TakenBack
SAID_TYPES: tuple[type[Said], ...] = get_args(Said)
SaidT_co = TypeVar("SaidT_co", bound=Said, covariant=True)


@dataclass(frozen=True, slots=True)
class Entry(Generic[SaidT_co]):
    """Something that a person said about a drive.

    Attributes:
        entry_id: unique over all files.
        time: when it was said, UTC, ISO 8601 with microseconds and a Z, so that the texts sort by time.
        person: who said it.
        said: what was said.
    """

    entry_id: str
    time: str
    person: str
    said: SaidT_co


def track_box_id(track_id: int) -> str:
    """The id of a track's box in a frame."""
    return f"track {track_id}"


def new_box_id() -> str:
    """An id for a box that a person adds."""
    return f"new {uuid.uuid4().hex}"


def _check_span(start_s: float, end_s: float) -> None:
    if not -LONGEST_DRIVE_S <= start_s <= end_s <= LONGEST_DRIVE_S:
        raise UserError(
            f"event from {start_s:g} s to {end_s:g} s: expected an end not before the start, in the drive"
        )
