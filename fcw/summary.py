"""The summary of a drive: counts, notes, and its warnings as spans of time (`summary.json`)."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from fcw.logs.events import BLIND_AFTER_S, find_events
from fcw.logs.records import MOMENTS, NOTHING_SEEN, POOR_SIGHT, FrameResult
from fcw.logs.series import SeriesBuilder
from fcw.motion.state import Mount, SpeedSource
from fcw.units import NS_PER_S
from fcw.warning.ego_speed import EgoSpeed
from fcw.warning.types import WarningLevel

LEVEL_NAMES = {level.name.lower() for level in WarningLevel if level > WarningLevel.NONE}
SCALE_ABOVE_MPS = 3.0
"""The scale is compared above this speed. Below it, both speeds are mostly error."""
SCALE_AFTER_M = 100.0
"""Distance that must be driven before the scale is judged."""
SCALE_SAID = 0.04
"""A ratio that differs from one by more than this is reported. Speedometers, GPS and our own estimate are
good to about 3 %."""
STANDS_BELOW_MPS, DRIVES_ABOVE_MPS = 1.0, 5.0
"""A given speed below the first contradicts a speed by the picture above the second, whatever the scale."""
CONTRADICTED_S = 2.0
"""Total time of contradiction from which it is reported. Less may be an error of the picture, for example if
somebody passes in front of a standing car."""
SLOWEST_HZ = 9.5
"""Tracking is made for 10 frames per second and more. At 5, five of seven harmless drives had a `warning`; at
8.3, none of two; a clip at 7.5 instead of 30 lost its `caution`."""
RATE_TOLD_AFTER_S = 2.0
"""A shorter drive does not tell the frame rate."""
BLANK_TOLD_S = 0.1
"""Total blank time from which it is reported. The first frame of a fade, for example, hides nothing."""
POOR_TOLD_S = 2.0
"""Total time of poor sight from which it is reported for the whole drive; less may be a bridge."""
MOST_SPANS = 3
"""The most cuts, and times of poor or no sight, that a note lists."""


@dataclass(slots=True)
class WarningSpan:
    """A warning of a drive: an event of `fcw.logs.events` that is not a near miss.

    Attributes:
        level: its highest level: `advisory`, `caution` or `warning`.
        start_s: time of its first frame, from the first frame of the drive.
        end_s: time of its last frame.
        min_ttc_s: smallest TTC of the vehicle during the warning; None if the gap never closed.
        min_distance_m: smallest distance of the vehicle; None if it was never measured.
        track_id: the vehicle.
    """

    level: str
    start_s: float
    end_s: float
    min_ttc_s: float | None
    min_distance_m: float | None
    track_id: int | None


@dataclass(slots=True)
class OwnMotionSummary:
    """How far we drove, for which part of the frames our speed is known, and the mount at the end."""

    frames: int = 0
    known: int = 0
    given: int = 0
    distance_m: float = 0.0
    mount: Mount | None = None
    _last_ns: int | None = None
    _by_picture_m: float = 0.0
    _given_m: float = 0.0
    _contradicted_s: float = 0.0

    def add(self, result: FrameResult) -> None:
        """Take in the next frame's result."""
        self.frames += 1
        dt_s = 0.0 if self._last_ns is None else (result.time_ns - self._last_ns) / NS_PER_S
        self._last_ns = result.time_ns
        speed_mps, motion = result.ego_speed_mps, result.own_motion
        if speed_mps is not None:
            self.known += 1
            self.distance_m += speed_mps * dt_s
        if motion is None:
            return
        self.mount = motion.mount
        self.given += motion.speed_source is SpeedSource.GIVEN
        by_picture_mps = motion.picture_speed_mps
        if motion.speed_source is not SpeedSource.GIVEN or speed_mps is None or by_picture_mps is None:
            return
        if speed_mps > SCALE_ABOVE_MPS:
            self._by_picture_m += by_picture_mps * dt_s
            self._given_m += speed_mps * dt_s
        elif speed_mps < STANDS_BELOW_MPS and by_picture_mps > DRIVES_ABOVE_MPS:
            self._contradicted_s += dt_s

    @property
    def scale_ratio(self) -> float | None:
        """Distance driven by the picture over that by the given speed; None if it is too short or unknown.

        The picture measures in units of the camera's height, so an error of its scale is one of all
        distances.
        """
        return self._by_picture_m / self._given_m if self._given_m >= SCALE_AFTER_M else None

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about the own motion that the user should read."""
        return (*self._contradicted_notes, *self._scale_notes)

    @property
    def _contradicted_notes(self) -> tuple[str, ...]:
        if self._contradicted_s < CONTRADICTED_S:
            return ()
        return (
            f"the given own speed says that you stand for {self._contradicted_s:.1f} s in which the "
            "picture shows that you drive: check it; if it is wrong, warnings are missing there",
        )

    @property
    def _scale_notes(self) -> tuple[str, ...]:
        ratio = self.scale_ratio
        if ratio is None or abs(ratio - 1) < SCALE_SAID:
            return ()
        word = "short" if ratio < 1 else "long"
        return (
            f"by the given own speed, the distances are {abs(ratio - 1):.0%} {word}: the camera is "
            f"{abs(1 / ratio - 1):.0%} {'higher' if ratio < 1 else 'lower'} than the calibration says, or "
            "the calibration is wrong",
        )

    def as_json(self, calibrated_pitch_rad: float) -> dict[str, Any]:
        """The JSON object in `summary.json`. The distance is None if the speed was never known."""
        mount = None if self.mount is None else asdict(self.mount)
        if mount is not None:
            mount["calibrated_pitch_rad"] = calibrated_pitch_rad
        return {
            "distance_m": self.distance_m if self.known else None,
            "speed_known_part": self.known / self.frames if self.frames else 0.0,
            "mount": mount,
            "scale_ratio": self.scale_ratio,
        }


@dataclass(slots=True)
class DriveSummary:
    """Gathers the summary of a drive while it runs: call `add` with every result.

    Attributes:
        source: name of the source.
        versions: versions of the programs that ran.
        calibrated_pitch_rad: pitch of the camera by its calibration.
        recorded: whether the source is a recording, which may have been edited, rather than a live camera.
        frames: number of frames.
        frames_with_lead: number of frames with a lead.
        unseen_s: total time between frames more than `BLIND_AFTER_S` apart, because the camera gave none or
            the computer was too busy for a live drive.
        blank_s: total time from each frame in which nothing could be seen to the next frame.
    """

    source: str
    versions: Mapping[str, str]
    calibrated_pitch_rad: float = 0.0
    recorded: bool = True
    frames: int = 0
    frames_with_lead: int = 0
    unseen_s: float = 0.0
    blank_s: float = 0.0
    _first_ns: int = 0
    _last_ns: int = 0
    _series: SeriesBuilder = field(default_factory=SeriesBuilder)
    _notes: list[tuple[float, tuple[str, ...]]] = field(default_factory=list)
    _noted: bool = False
    _blank: bool = False
    _driven: int = 0
    _driven_new: int = 0
    """Frames in which we drive, and how many of these do not repeat the previous picture."""
    _own: OwnMotionSummary = field(default_factory=OwnMotionSummary)

    def add(self, result: FrameResult) -> None:
        """Take in the next frame's result."""
        if self.frames == 0:
            self._first_ns = self._last_ns = result.time_ns
        gap_s = (result.time_ns - self._last_ns) / NS_PER_S
        if gap_s > BLIND_AFTER_S:
            self.unseen_s += gap_s
        elif self._blank:
            self.blank_s += gap_s
        self._blank = NOTHING_SEEN in result.notes
        self._last_ns = result.time_ns
        self.frames += 1
        self.frames_with_lead += result.lead_id is not None
        notes = tuple(note for note in result.notes if not note.startswith(MOMENTS))
        if notes:  # the latest wording is based on the most evidence
            start_s = self._notes.pop()[0] if self._noted else (result.time_ns - self._first_ns) / NS_PER_S
            self._notes.append((start_s, notes))
        self._noted = bool(notes)
        if (result.ego_speed_mps or 0.0) > STANDS_BELOW_MPS:  # while we stand, new pictures may look equal
            self._driven += 1
            self._driven_new += not result.repeated
        self._own.add(result)
        self._series.add(result, ())

    @property
    def warnings(self) -> list[WarningSpan]:
        """The warnings, in the order in which they start."""
        return [
            WarningSpan(
                event.kind, event.start_s, event.end_s, event.min_ttc_s, event.min_distance_m, event.track_id
            )
            for event in find_events(self._series.build())
            if event.kind in LEVEL_NAMES
        ]

    def notes_on(self, given: EgoSpeed | None) -> tuple[str, ...]:
        """Sentences about the given own speed: that it has gaps, or does not cover the drive."""
        if given is None or not given.times_s or not self.frames:
            return ()
        first_s, last_s = self._first_ns / NS_PER_S, self._last_ns / NS_PER_S
        zero_s = first_s if given.from_first_frame else 0.0
        gaps_s = given.gaps_s(first_s - zero_s, last_s - zero_s)
        if gaps_s and self._own.given < self.frames:  # of a log the speeds are missing where pictures are
            return (
                f"the given own speed is not used for {sum(gaps_s):.1f} s, as its samples there are more "
                f"than {given.longest_step_s:.1f} s apart",
            )
        if self._own.given:
            return ()
        return (
            f"the given own speed is not used: it is from {given.times_s[0]:.1f} s to "
            f"{given.times_s[-1]:.1f} s, and the drive from {first_s:.1f} s to {last_s:.1f} s on its "
            "source's clock",
        )

    @property
    def blind_s(self) -> float:
        """Total time in which no warning was possible."""
        return self.unseen_s + self.blank_s

    @property
    def notes(self) -> tuple[str, ...]:
        """The frames' notes. One that holds for many frames in a row is given once, as it was worded last."""
        return tuple(f"from {start_s:.0f} s: {note}" for start_s, notes in self._notes for note in notes)

    @property
    def all_notes(self) -> tuple[str, ...]:
        """All sentences about the drive that the user should read."""
        return (*self._rate_notes, *self.notes, *self._own.notes, *self._unseen_notes, *self._sight_notes)

    @property
    def _rate_notes(self) -> tuple[str, ...]:
        seen_s = self.duration_s - self.unseen_s
        if seen_s < RATE_TOLD_AFTER_S:
            return ()
        shown_hz = new_hz = (self.frames - 1) / seen_s
        if self._driven > RATE_TOLD_AFTER_S * shown_hz:
            new_hz *= self._driven_new / self._driven
        if new_hz >= SLOWEST_HZ:
            return ()
        repeated = f", shown as {shown_hz:.1f} by repeating them" if new_hz < shown_hz else ""
        return (
            f"{new_hz:.1f} pictures a second{repeated}: tracking is made for 10 and more; with fewer, "
            "closing speeds are uncertain, and warnings may be early, late, false or missing",
        )

    @property
    def _sight_notes(self) -> tuple[str, ...]:
        """When the pictures show too little or nothing, and when the clip is cut."""
        events, notes = find_events(self._series.build()), []
        for poor in POOR_SIGHT:
            spans = [one for one in events if one.note.startswith(poor)]
            if sum(one.end_s - one.start_s for one in spans) >= POOR_TOLD_S:
                times = _few([f"from {one.start_s:.1f} s to {one.end_s:.1f} s" for one in spans])
                notes.append(f"{times}: {spans[-1].note}")
        blank = [one for one in events if one.note == NOTHING_SEEN]  # of other times `_unseen_notes` tells
        if blank and self.blank_s >= BLANK_TOLD_S:
            times = _few([f"from {one.start_s:.1f} s to {one.end_s:.1f} s" for one in blank])
            notes.append(
                f"pictures are black or blank {times}, as with a covered lens: nothing can be seen there, "
                "so no warning was possible"
            )
        cuts = [one for one in events if one.kind == "cut"]
        if cuts:
            times = _few([f"at {one.start_s:.1f} s" for one in cuts])
            notes.append(
                f"the clip is cut {times}, as by editing: tracking starts again there; if it goes on with "
                "another camera, distances are wrong from there on: split the file there, and calibrate "
                "each part"
                if self.recorded
                else f"the picture jumps {times}, as where it is damaged or the camera is moved: tracking "
                "starts again there"
            )
        return tuple(notes)

    @property
    def _unseen_notes(self) -> tuple[str, ...]:
        if not self.unseen_s:
            return ()
        return (
            f"blind for {self.unseen_s:.1f} s of {self.duration_s:.1f} s: no picture was examined then, so "
            "no warning was possible",
        )

    @property
    def duration_s(self) -> float:
        """Time from the first frame to the last, on the source's clock."""
        return (self._last_ns - self._first_ns) / NS_PER_S

    def as_json(self, elapsed_s: float) -> dict[str, Any]:
        """The JSON object of `summary.json`; `elapsed_s` is how long the job took."""
        return {
            "source": self.source,
            "frames": self.frames,
            "duration_s": self.duration_s,
            "frames_per_second": self.frames / elapsed_s if elapsed_s > 0 else 0.0,
            "frames_with_lead": self.frames_with_lead,
            "blind_s": self.blind_s,
            "warnings": [asdict(span) for span in self.warnings],
            "notes": list(self.all_notes),
            "own_motion": self._own.as_json(self.calibrated_pitch_rad),
            "versions": dict(self.versions),
        }


def _few(times: Sequence[str]) -> str:
    """The first few of these, and how many more there are."""
    more = f" and {len(times) - MOST_SPANS} more times" if len(times) > MOST_SPANS else ""
    return ", ".join(times[:MOST_SPANS]) + more
