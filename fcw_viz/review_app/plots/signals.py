"""Which signals can be plotted: of a vehicle, and of the drive itself, by their names on the page."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from fcw.logs.records import FrameResult
from fcw.motion.state import Mount, OwnMotion
from fcw.threat.threat import required_deceleration_mps2
from fcw.tracking.types import Track
from fcw_viz.review_app.plots.quantities import (
    ACCELERATION,
    ANGLE,
    BENDING,
    BRAKING,
    COUNT,
    LENGTH,
    PIXELS,
    SCORE,
    SHARE,
    SLOW_SPEED,
    SPEED,
    TIME,
    TURNING,
    Quantity,
    Span,
)

AHEAD, OWN = "ahead", "own"
"""What signals are of, beside the vehicles: whom we are warned of, else the lead; and the drive itself."""
LONGEST_TTC_S, LONGEST_HEADWAY_S = 10.0, 4.0
"""Beyond ten seconds nobody is warned: the plots keep their room for what matters."""
FARTHEST_M = 150.0
FROM_ZERO = Span()

OfVehicle = Callable[[FrameResult, Track], float | None]
OfFrame = Callable[[FrameResult], float | None]


@dataclass(frozen=True, slots=True)
class Signal:
    """Something with a value at each frame, or none.

    Attributes:
        key: on the page.
        title: its name.
        quantity: what it is measured in.
        span: what its axis holds.
        of_vehicle: value, and lower and upper edge where it has an interval, of a vehicle; in SI units.
        of_frame: the same, of the drive; one of the two is empty.
        series: columns of the log's series that hold the same of `AHEAD` or `OWN`, in that order; those of
            a vehicle by the name that `DriveSeries.about` has for them. Empty where the frames themselves
            have to be read.
        sigma: the second of `series` is a standard deviation.
    """

    key: str
    title: str
    quantity: Quantity
    span: Span = FROM_ZERO
    of_vehicle: tuple[OfVehicle, ...] = ()
    of_frame: tuple[OfFrame, ...] = ()
    series: tuple[str, ...] = ()
    sigma: bool = False


class Chosen(NamedTuple):
    """A curve that somebody wants to see.

    Attributes:
        signal: key of the signal.
        subject: `AHEAD`, `OWN` or the vehicle's number in digits.
    """

    signal: str
    subject: str


def _closing(track: Track, sigmas: float) -> float:
    return track.closing_speed_mps + sigmas * track.closing_speed_sigma_mps


def _headway_s(result: FrameResult, track: Track) -> float | None:
    return track.distance_m / result.ego_speed_mps if result.ego_speed_mps else None


VEHICLE_SIGNALS = (
    Signal(
        "distance",
        "Distance",
        LENGTH,
        Span(highest=FARTHEST_M),
        (lambda _, t: t.distance_m, lambda _, t: t.distance_low_m, lambda _, t: t.distance_high_m),
        series=("distance_m", "distance_low_m", "distance_high_m"),
    ),
    Signal(
        "closing",
        "Closing speed",
        SPEED,
        Span(high=2.0),
        (lambda _, t: t.closing_speed_mps, lambda _, t: _closing(t, -1), lambda _, t: _closing(t, 1)),
        series=("closing_speed_mps",),
    ),
    Signal(
        "ttc",
        "Time to collision",
        TIME,
        Span(0.0, LONGEST_TTC_S, highest=LONGEST_TTC_S),
        (lambda _, t: t.ttc_s,),
        series=("ttc_s",),
    ),
    Signal(
        "headway",
        "Headway",
        TIME,
        Span(0.0, LONGEST_HEADWAY_S, highest=LONGEST_HEADWAY_S),
        (_headway_s,),
        series=("headway_s",),
    ),
    Signal(
        "braking",
        "Braking needed",
        BRAKING,
        Span(high=4.0, highest=12.0),
        (lambda _, t: required_deceleration_mps2(t.distance_m, t.closing_speed_mps),),
        series=("required_deceleration_mps2",),
    ),
    Signal(
        "acceleration",
        "Closing acceleration",
        ACCELERATION,
        Span(-1.0, 1.0),
        (lambda _, t: t.closing_acceleration_mps2,),
    ),
    Signal("lateral", "Lateral position, left", LENGTH, Span(-2.0, 2.0), (lambda _, t: t.lateral_m,)),
    Signal(
        "lateral_speed",
        "Lateral speed, left",
        SLOW_SPEED,
        Span(-1.0, 1.0),
        (lambda _, t: t.lateral_speed_mps,),
    ),
    Signal("width", "Width", LENGTH, FROM_ZERO, (lambda _, t: t.width_m,)),
    Signal("box_height", "Box height", PIXELS, FROM_ZERO, (lambda _, t: t.box.h,)),
    Signal("box_width", "Box width", PIXELS, FROM_ZERO, (lambda _, t: t.box.w,)),
    Signal("score", "Detector score", SCORE, FROM_ZERO, (lambda _, t: t.score,)),
)
"""Of every vehicle."""


def _motion(read: Callable[[OwnMotion], float | None]) -> OfFrame:
    return lambda result: None if result.own_motion is None else read(result.own_motion)


def _mount(read: Callable[[Mount], float]) -> OfFrame:
    return _motion(lambda motion: None if motion.mount is None else read(motion.mount))


def _yaw_rate(sigmas: float) -> OfFrame:
    def read(motion: OwnMotion) -> float | None:
        if motion.yaw_rate_radps is None:
            return None
        return motion.yaw_rate_radps + sigmas * (motion.yaw_rate_sigma_radps or 0.0)

    return _motion(read)


_DEGREE = 0.0175

OWN_SIGNALS = (
    Signal(
        "own_speed",
        "Own speed",
        SPEED,
        Span(high=2.0),
        of_frame=(lambda result: result.ego_speed_mps,),
        series=("ego_speed_mps", "ego_speed_sigma_mps"),
        sigma=True,
    ),
    Signal(
        "picture_speed",
        "Own speed from the picture",
        SPEED,
        Span(high=2.0),
        of_frame=(_motion(lambda motion: motion.picture_speed_mps),),
    ),
    Signal(
        "yaw_rate",
        "Yaw rate, left",
        TURNING,
        Span(-2 * _DEGREE, 2 * _DEGREE),
        of_frame=(_yaw_rate(0), _yaw_rate(-1), _yaw_rate(1)),
    ),
    Signal(
        "pitch",
        "Camera pitch, down",
        ANGLE,
        Span(None),
        of_frame=(
            _mount(lambda mount: mount.pitch_rad),
            _mount(lambda mount: mount.pitch_rad - mount.pitch_sigma_rad),
            _mount(lambda mount: mount.pitch_rad + mount.pitch_sigma_rad),
        ),
    ),
    Signal(
        "camera_yaw",
        "Camera yaw, left",
        ANGLE,
        Span(None),
        of_frame=(_mount(lambda mount: mount.yaw_rad),),
    ),
    Signal(
        "camera_roll",
        "Camera roll",
        ANGLE,
        Span(None),
        of_frame=(_mount(lambda mount: mount.roll_rad),),
    ),
    Signal(
        "curvature",
        "Path curvature, left",
        BENDING,
        Span(-0.002, 0.002),
        of_frame=(lambda result: None if result.own_path is None else result.own_path.curvature_per_m,),
    ),
    Signal(
        "probability",
        "Collision probability",
        SHARE,
        Span(0.0, 1.0),
        of_frame=(lambda result: result.told_warning.collision_probability,),
        series=("warned_probability",),
    ),
    Signal(
        "level",
        "Warning level, 0 to 3",
        COUNT,
        Span(0.0, 3.0),
        of_frame=(lambda result: float(result.warning.level),),
        series=("level",),
    ),
    Signal(
        "vehicles",
        "Tracked vehicles",
        COUNT,
        Span(high=4.0),
        of_frame=(lambda result: float(len(result.tracks)),),
    ),
)
"""Of the drive itself."""

SIGNALS = {signal.key: signal for signal in (*VEHICLE_SIGNALS, *OWN_SIGNALS)}
DEFAULT = (Chosen("distance", AHEAD), Chosen("closing", AHEAD), Chosen("ttc", AHEAD))
"""What somebody sees who has chosen nothing."""
LIVE = (*DEFAULT, Chosen("headway", AHEAD), Chosen("own_speed", OWN))
"""What the live page shows."""
MOST_PLOTS = 8


def signals_of(subject: str) -> tuple[Signal, ...]:
    """What can be chosen of a subject."""
    return OWN_SIGNALS if subject == OWN else VEHICLE_SIGNALS


def subject_name(subject: str) -> str:
    """What a subject is called."""
    return {AHEAD: "the vehicle ahead", OWN: "this drive"}.get(subject, f"#{subject}")


def in_series(chosen: Chosen) -> bool:
    """Whether the log's own columns hold it: it is there at once."""
    return bool(SIGNALS[chosen.signal].series) and chosen.subject in (AHEAD, OWN)


def parse_chosen(text: str) -> tuple[Chosen, ...]:
    """Curves by their names, `distance ahead,score 7`; what is none is left out."""
    found = (part.split(" ") for part in text.split(",") if part.count(" ") == 1)
    return tuple(Chosen(signal, subject) for signal, subject in found if _exists(signal, subject))


def chosen_text(chosen: Sequence[Chosen]) -> str:
    """The same curves as `parse_chosen` reads them."""
    return ",".join(" ".join(one) for one in chosen)


def _exists(signal: str, subject: str) -> bool:
    known = {one.key for one in signals_of(subject)}
    return signal in known and (subject in (AHEAD, OWN) or subject.isdigit())
