"""What a person can say of a recorded drive, and the entry that keeps it.

Times are seconds from the drive's first frame, as in `fcw.logs.events`; frames are named by their index in
the log, which never changes. Boxes are in pixels of the log's pictures.
"""

import uuid
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar, get_args

from fcw.box import Box
from fcw.errors import UserError
from fcw.warning.types import WarningLevel

LONGEST_DRIVE_S = 1e9
"""Thirty years; a time beyond is damage."""
FARTHEST_PX = 1e5
"""Of a box from the picture's corner; pictures have at most 16384 a side, and boxes reach out of them."""


class Judgement(Enum):
    """What a warning was; the value is for a person."""

    RIGHT = "right"
    TOO_EARLY = "too early"
    TOO_LATE = "too late"
    FALSE = "false"


class Reason(Enum):
    """Why a warning was wrong; the value is for a person.

    They follow the questions by which alerts of field tests are sorted: was there a vehicle, was it in the
    way, what did it or the driver do, was it measured right.
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
"""The reasons to choose from with each judgement, the usual ones first."""


@dataclass(frozen=True, slots=True)
class EventReference:
    """The event that a verdict is about, so that it is found again when the finding of events is refined.

    Attributes:
        kind: of `fcw.logs.events.DriveEvent`.
        track_id: the vehicle that it was about; None where it was about none.
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
    """A person's judgement of an event; their next one on the same event takes its place.

    Attributes:
        event: what is judged.
        judgement: what it was.
        reason: one of `REASONS[judgement]`; None where none was given.
        text: more, in the person's own words.
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
    """A stretch in which a warning should have been shown and none was.

    Attributes:
        start_s: from when.
        end_s: until when it would have been of use.
        text: what happened.
        level: the warning that was due.
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
    """From where a vehicle is seen; the value is what labels say."""

    REAR = "rear"
    REAR_QUARTER = "rear-quarter"
    SIDE = "side"
    FRONT = "front"
    UNCLEAR = "unclear"


class VehicleKind(Enum):
    """What a vehicle is; the value is what labels say."""

    CAR = "car"
    SUV = "suv"
    VAN = "van"
    TRUCK = "truck"
    BUS = "bus"


class MadeBy(Enum):
    """How a box of a frame came about; the value is for a person."""

    HAND = "by hand"
    COPIED = "copied"
    INTERPOLATED = "interpolated"
    FOLLOWED = "followed"


MOST_OCCLUDED = 2
"""0: not hidden, 1: by up to about 40 %, 2: by more."""


@dataclass(frozen=True, slots=True)
class LabelledBox:
    """What a person says of a vehicle.

    Attributes:
        box: where it is; both sides longer than 0, no coordinate beyond `FARTHEST_PX`.
        track_id: of the log's track that it belongs to; None where it belongs to none.
        ignore: True where it is neither to be found nor to be taken for background: hidden, too far, another
            view.
        view: from where it is seen; None where nobody said.
        kind: what it is; None where nobody said.
        occluded: how much of it is hidden, 0 to `MOST_OCCLUDED`; None where nobody said.
        rear_box: its rear face alone, where the box holds a side too; None where nobody said.
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
    """A box of one frame corrected, added or deleted; the latest edit of the same box counts.

    Attributes:
        frame_index: the frame, `FrameResult.index`.
        box_id: which box of the frame: `track_box_id` for that of a track of the log, `new_box_id` for one
            that a person added.
        label: the box as it should be; None where there should be none.
        made_by: how it came about; between two by hand others are interpolated.
    """

    frame_index: int
    box_id: str
    label: LabelledBox | None
    made_by: MadeBy = MadeBy.HAND


@dataclass(frozen=True, slots=True)
class FrameConfirmed:
    """All boxes of a frame, as they stand with the edits, are right, and no vehicle is without one."""

    frame_index: int


@dataclass(frozen=True, slots=True)
class TakenBack:
    """An earlier entry of the same person does not count any more; one of these can be taken back too."""

    entry_id: str


Said = Verdict | MissedEvent | Note | BoxEdit | FrameConfirmed | TakenBack
SAID_TYPES: tuple[type[Said], ...] = get_args(Said)
SaidT_co = TypeVar("SaidT_co", bound=Said, covariant=True)


@dataclass(frozen=True, slots=True)
class Entry(Generic[SaidT_co]):
    """Something said of a drive.

    Attributes:
        entry_id: unique in all files.
        time: when, UTC, ISO 8601 with microseconds and a Z: such texts sort as their times do.
        person: who.
        said: what.
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
