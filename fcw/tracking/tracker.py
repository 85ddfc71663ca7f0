"""Vehicles followed from frame to frame: association, births and deaths, and the lead."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box, shared_area
from fcw.camera.calibration import Calibration, Gaussian
from fcw.detection.detector import Detection
from fcw.motion.bend.turn import turn_of
from fcw.motion.ego import NOTHING_KNOWN, Ego
from fcw.motion.flow.cuts import Follows
from fcw.motion.mount import MountNote
from fcw.motion.state import Mount, OwnPath
from fcw.tracking.association import WHOLE, Edges, free_edges, match_detections
from fcw.tracking.belief.doubts import Doubts
from fcw.tracking.followed import SHORTEST_STEP_S, Followed
from fcw.tracking.horizon import MountWatch, RulerReading
from fcw.tracking.lead import select_lead
from fcw.tracking.lead_speed import with_own_speed, without_own_speed
from fcw.tracking.own_speed import OwnSpeed
from fcw.tracking.picture.follower import Moved
from fcw.tracking.range.filter import RangeFilter
from fcw.tracking.range.state import RangeState
from fcw.tracking.settings import TrackerSettings
from fcw.tracking.types import SeenBy, Track

HIDDEN_PART = 0.75
"""A vehicle is not carried on if more than this part of its box is inside another one's."""
HIDDEN_PART_NEARER = 0.35
NEARER_RATIO = 0.8
"""`HIDDEN_PART_NEARER` replaces `HIDDEN_PART` if the other's distance is below this fraction of the
vehicle's, because the pixels there then belong to the other one."""


class _View(NamedTuple):
    """A vehicle that was found in a frame.

    Attributes:
        slot: the vehicle's index in the list.
        detection: its detection.
        box: box of the whole vehicle; see `Followed.view_of`.
        edges: which edges of `box` were seen.
        free: edges beyond which the vehicle does not continue; see `free_edges`.
    """

    slot: int
    detection: Detection
    box: Box
    edges: Edges
    free: Edges


class _Assigned(NamedTuple):
    """The detections of a frame, assigned to vehicles.

    Attributes:
        views: the vehicles that were found again.
        new: detections that belong to no vehicle yet.
        certain: boxes that are certain enough to hide another vehicle.
    """

    views: list[_View]
    new: list[Detection]
    certain: list[Box]


class Tracker:
    """Follows the vehicles of one drive.

    Args:
        calibration: calibration for the image size of the detections.
        settings: see `TrackerSettings`.
    """

    def __init__(self, calibration: Calibration, settings: TrackerSettings | None = None) -> None:
        self._calibration = calibration
        self._settings = settings or TrackerSettings()
        self._range = RangeFilter(calibration, self._settings.box_noise, self._settings.model)
        self._mount = MountWatch(self._range.calibration_sigma_rad, self._settings.mount)
        self._mount_note = MountNote(calibration, self._range.calibration_sigma_rad)
        self._doubts = Doubts(self._settings.belief, calibration.image_size.width)
        self._followed: list[Followed] = []
        self._time_ns: int | None = None
        self._unsearched_s = 0.0
        self._own = OwnSpeed()
        self._next_id = 1
        self._lead_id: int | None = None

    @property
    def lead_id(self) -> int | None:
        """Id of the lead among the tracks of the last update; None when the own path is free."""
        return self._lead_id

    @property
    def wants_search(self) -> bool:
        """Whether the next frame should be searched: a vehicle is new, or we may soon be at its rear."""
        return any(followed.wants_search() for followed in self._followed)

    @property
    def own_speed(self) -> Gaussian | None:
        """Own speed in m/s that other vehicles are judged by. The last known one is held for a while."""
        return None if self._own.speed_mps is None else Gaussian(self._own.speed_mps, self._own.sigma_mps)

    @property
    def reference_offset_m(self) -> float:
        """How far the point from which distances are measured is ahead of the camera."""
        return self._calibration.reference_offset_m

    @property
    def believed_mount(self) -> Mount:
        """The current estimate of where the camera looks, from vehicles and own motion."""
        return self._range.mount

    @property
    def mount(self) -> MountWatch:
        """Watches whether the camera still looks where it did when it was calibrated."""
        return self._mount

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about the camera that the user should read."""
        note = self._mount_note.text or self._mount.note
        return () if note is None else (note,)

    def update(
        self,
        time_ns: int,
        detections: Sequence[Detection] | None,
        ego: Ego = NOTHING_KNOWN,
        image: NDArray[np.uint8] | None = None,
    ) -> tuple[Track, ...]:
        """Update with one frame.

        After a cut, all tracks begin anew. A picture that is unlike those before it is ignored.

        Args:
            time_ns: time of the frame; intervals between frames may vary.
            detections: vehicles found in it. None if it was not searched: the vehicles are then predicted,
                or carried by the picture if it is given, and none counts as missed.
            ego: own motion and path. The speed identifies oncoming and standing vehicles. The yaw rate tells
                how much of the motion across the picture is due to our own turning. The mount is used for
                ranging.
            image: the frame's picture, (height, width, 3) BGR; None if there are only boxes. With it,
                vehicles that the detector misses are carried by their looks.

        Returns:
            The confirmed tracks in the order of their ids, including coasting ones.

        Raises:
            ValueError: `time_ns` is before the last frame's.
        """
        if ego.follows is Follows.AFTER_CUT:
            self._begin_anew()
        if ego.follows is Follows.UNLIKE:
            detections = image = None
        dt_s = self._go_on_to(time_ns)
        searched = detections is not None
        before = [followed.box for followed in self._followed]
        self._predict(time_ns, dt_s, searched, ego)
        moved = {} if image is None else self._carry(time_ns, image, before)
        found = self._assign(time_ns, detections or ())
        self._measure(found, moved, dt_s, searched)
        self._correct(time_ns, found)
        if image is not None and searched:
            self._remember(image, time_ns)
        if searched:
            self._unsearched_s = 0.0
        self._settle(time_ns, ego.path)
        for detection in found.new:
            self._start(time_ns, detection, found.certain, ego)
        self._doubts.update(time_ns, self._followed, image)
        return self._tracks(time_ns, ego)

    def _begin_anew(self) -> None:
        """After a cut, forget the vehicles and the own speed, but keep the estimate of the mount."""
        self._keep([False] * len(self._followed))
        self._doubts = Doubts(self._settings.belief, self._calibration.image_size.width)
        self._own, self._lead_id = OwnSpeed(), None

    def _go_on_to(self, time_ns: int) -> float:
        """Advance to a frame and forget vehicles not seen for long; returns the time since the last frame."""
        if self._time_ns is not None and time_ns < self._time_ns:
            raise ValueError(f"frame time went back from {self._time_ns} to {time_ns} ns")
        dt_s = 0.0 if self._time_ns is None else (time_ns - self._time_ns) / 1e9
        self._time_ns = time_ns
        self._unsearched_s += dt_s
        oldest_ns = time_ns - round(self._settings.coast_s * 1e9)
        self._keep([followed.last_ns >= oldest_ns for followed in self._followed])
        return dt_s

    def _predict(self, time_ns: int, dt_s: float, searched: bool, ego: Ego) -> None:
        """Predict where the vehicles are in this frame, and how large."""
        motion = ego.motion
        own_gain_mps = self._own.update(dt_s, motion.speed_mps, motion.speed_sigma_mps or 0.0)
        growths = self._range.predict(
            dt_s, own_gain_mps, ego.path, self._own.gain_sigma_mps, ego.body_pitch_rad
        )
        if motion.mount is not None:
            self._range.take_mount(motion.mount.pitch_rad, motion.mount.pitch_sigma_rad, dt_s)
        search_s, turn_radps = self._unsearched_s if searched else None, _turn_radps(ego)
        for followed, growth in zip(self._followed, growths, strict=True):
            followed.predict(time_ns, dt_s, growth, search_s, turn_radps)

    def _assign(self, time_ns: int, detections: Sequence[Detection]) -> _Assigned:
        """Assign the detections to vehicles."""
        pairs = match_detections(
            [followed.box for followed in self._followed],
            [followed.confirmed for followed in self._followed],
            detections,
            self._calibration.image_size,
            self._settings,
        )
        taken = {index for _, index in pairs}
        # A doubtful vehicle hides no other one.
        doubted = {index for slot, index in pairs if self._followed[slot].doubtful}
        certain = [one.box for index, one in enumerate(detections) if not (one.faint or index in doubted)]
        views = []
        for slot, index in pairs:
            free = self._free_edges(detections[index].box, certain)
            box, edges = self._followed[slot].view_of(time_ns, detections[index].box, free)
            views.append(_View(slot, detections[index], box, edges, free))
        new = [one for index, one in enumerate(detections) if not (one.faint or index in taken)]
        return _Assigned(views, new, certain)

    def _measure(self, found: _Assigned, moved: dict[int, Moved], dt_s: float, searched: bool) -> None:
        """Update distances and mount with what the frame shows."""
        self._range.update(
            [(view.slot, view.box) for view in found.views],
            max(self._unsearched_s, SHORTEST_STEP_S),
            {view.slot: view.edges for view in found.views},
            [slot for slot, followed in enumerate(self._followed) if followed.doubtful],
        )
        if searched:
            free = {view.slot: view.free for view in found.views}
            for slot, followed in enumerate(self._followed):
                followed.free = free.get(slot, WHOLE)
        # A vehicle that comes out from behind another one only seems to grow.
        grown = [
            (slot, one.log_growth, one.sigma)
            for slot, one in moved.items()
            if math.isfinite(one.sigma) and self._followed[slot].free == WHOLE
        ]
        self._range.take_growths(grown, max(dt_s, SHORTEST_STEP_S))
        whole = [
            (view.slot, view.box)
            for view in found.views
            if view.edges == WHOLE and not self._range.boxed_part(view.slot).log_part
        ]
        self._mount.update(self._rulers(whole), dt_s)
        self._mount_note.update(self._range.mount, dt_s)

    def _correct(self, time_ns: int, found: _Assigned) -> None:
        """Move the boxes to where the vehicles were found."""
        for view in found.views:
            self._followed[view.slot].correct(time_ns, view.box, view.detection.score, view.detection.faint)

    def _settle(self, time_ns: int, path: OwnPath) -> None:
        """Update the state of the vehicles after this frame, and forget those that are not worth keeping."""
        for slot, followed in enumerate(self._followed):
            followed.settle(time_ns)
            followed.state = self._state(slot)
            followed.place_across(self._range.focal_px, path, self._range.boxed_part(slot).news)
        self._keep([followed.is_worth_keeping() for followed in self._followed])

    def _tracks(self, time_ns: int, ego: Ego) -> tuple[Track, ...]:
        """The confirmed tracks; also selects the lead among them."""
        turn, sigma_mps = turn_of(ego.motion), ego.motion.speed_sigma_mps
        tracks = tuple(
            followed.track(time_ns, ego.path, turn) for followed in self._followed if followed.confirmed
        )
        own_sigma_mps = self._own.sigma_mps if sigma_mps is None else sigma_mps
        lead = select_lead(tracks, self._own.speed_mps, own_sigma_mps)
        self._lead_id = lead.track_id if lead else None
        return tracks

    def _carry(self, time_ns: int, image: NDArray[np.uint8], before: Sequence[Box]) -> dict[int, Moved]:
        """Follow the vehicles' image patches into this picture, and move their boxes; the moves, by slot."""
        moved = {}
        own_mps, slowest_mps = self._own.speed_mps, self._settings.following.driving_mps
        we_drive = own_mps is not None and own_mps >= slowest_mps
        for slot, followed in enumerate(self._followed):
            one = followed.looks.follow(image, before[slot], followed.box)
            if one is not None and followed.carry(time_ns, one, we_drive):
                moved[slot] = one
        return moved

    def _remember(self, image: NDArray[np.uint8], time_ns: int) -> None:
        """Store the looks of the lead and the nearest vehicles, to follow them in the next pictures."""
        found = [followed for followed in self._followed if followed.seen_by == SeenBy.DETECTOR]
        hidden = set()
        for slot, followed in enumerate(self._followed):
            unfound = followed.seen_by != SeenBy.DETECTOR
            if unfound and any(_hides(other, followed) for other in found):
                # The pixels in its box belong to another vehicle by now. Predict it until it is found again.
                followed.lose()
                hidden.add(slot)
        believed = [
            slot for slot, followed in enumerate(self._followed) if followed.confirmed and slot not in hidden
        ]
        believed.sort(
            key=lambda slot: (
                self._followed[slot].track_id != self._lead_id,
                self._followed[slot].state.distance_m,
            )
        )
        most = self._settings.following.most
        for slot in believed[most:]:
            self._followed[slot].looks.forget()
        for slot in believed[:most]:
            followed = self._followed[slot]
            detected = followed.seen_by == SeenBy.DETECTOR
            if followed.looks.remember(image, followed.box, time_ns, detected):
                self._range.begin_growth(slot)

    def _rulers(self, boxes: Sequence[tuple[int, Box]]) -> list[RulerReading]:
        """What the confirmed vehicles tell about the mount."""
        readings = []
        for slot, box in boxes:
            followed = self._followed[slot]
            ruler = self._range.ruler(slot, box) if followed.confirmed else None
            if ruler is not None:
                readings.append(RulerReading((followed.track_id, self._range.kind(slot)), *ruler))
        return readings

    def _keep(self, worth: Sequence[bool]) -> None:
        """Forget vehicles. A vehicle has the same index in this list and in the range filter."""
        if not all(worth):
            self._range.keep([slot for slot, keep in enumerate(worth) if keep])
            self._followed = [followed for followed, keep in zip(self._followed, worth, strict=True) if keep]

    def _state(self, slot: int) -> RangeState:
        """Range state of a vehicle, combined with what the own speed tells about it."""
        state, prior = self._range.state(slot), self._settings.speed_prior
        if self._own.speed_mps is None:
            return without_own_speed(state, prior)
        return with_own_speed(state, self._own.speed_mps, prior, self._own.sigma_mps)

    def _free_edges(self, box: Box, others: Sequence[Box]) -> Edges:
        return free_edges(box, others, self._calibration.camera, self._settings.model.rears[0].length_m)

    def _start(self, time_ns: int, detection: Detection, others: Sequence[Box], ego: Ego) -> None:
        """Begin a track if the box gives a first distance."""
        if self._range.add(detection.box, self._own.speed_mps, self._free_edges(detection.box, others)):
            followed = Followed(
                self._next_id,
                time_ns,
                detection,
                self._state(self._range.count - 1),
                self._calibration,
                self._settings,
                self._range.focal_px,
                ego.path,
                _turn_radps(ego),
            )
            self._followed.append(followed)
            self._next_id += 1


def _turn_radps(ego: Ego) -> float | None:
    """Our yaw rate, positive to the left; None when unknown."""
    turn = turn_of(ego.motion)
    return None if turn is None else turn.rate_radps(ego.path)


def _hides(found: Followed, carried: Followed) -> bool:
    """Whether a vehicle that was found hides one that was not, or the latter is only a part of it."""
    box, other = found.box, carried.box
    inside = shared_area(box, other) / (other.w * other.h)
    nearer = found.state.distance_m < NEARER_RATIO * carried.state.distance_m
    return box.w > other.w and inside > (HIDDEN_PART_NEARER if nearer else HIDDEN_PART)
