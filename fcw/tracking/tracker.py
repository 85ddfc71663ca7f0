"""Vehicles followed from frame to frame: association, births and deaths, and the lead."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box, shared_area
from fcw.camera.calibration import Calibration, Gaussian
from fcw.detection.detector import Detection
from fcw.motion.bend.turn import Turn
from fcw.motion.mount import MountNote
from fcw.motion.state import Mount, OwnPath
from fcw.tracking.association import WHOLE, Edges, associate, free_edges
from fcw.tracking.belief.doubts import Doubts
from fcw.tracking.followed import SHORTEST_STEP_S, Followed
from fcw.tracking.horizon import MountWatch, RulerReading
from fcw.tracking.lead import path_curvature_per_m, select_lead
from fcw.tracking.lead_speed import with_own_speed, without_own_speed
from fcw.tracking.own_speed import OwnSpeed
from fcw.tracking.picture.follower import Moved
from fcw.tracking.range.filter import RangeFilter
from fcw.tracking.range.state import RangeState
from fcw.tracking.settings import TrackerSettings
from fcw.tracking.types import SeenBy, Track

HIDDEN_PART = 0.75
"""A vehicle of which more is behind another one's box is not carried on."""
HIDDEN_PART_NEARER = 0.35
NEARER_RATIO = 0.8
"""And of which more is behind a vehicle so many times as near: what is seen there is that one's."""


class Tracker:
    """Follows the vehicles of one drive.

    Args:
        calibration: for the size of the pictures the detections come from.
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
        """Own speed in m/s that other vehicles are judged by; held for a while where none is told."""
        return None if self._own.speed_mps is None else Gaussian(self._own.speed_mps, self._own.sigma_mps)

    @property
    def reference_offset_m(self) -> float:
        """How far the reference of distances is ahead of the camera."""
        return self._calibration.reference_offset_m

    @property
    def believed_mount(self) -> Mount:
        """Where the camera looks, as vehicles and own motion tell it by now."""
        return self._range.mount

    @property
    def mount(self) -> MountWatch:
        """Whether the camera still looks where it did when it was calibrated, and what to tell if not."""
        return self._mount

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should know of the camera by now."""
        note = self._mount_note.text or self._mount.note
        return () if note is None else (note,)

    def begin_anew(self) -> None:
        """After a cut: forget the vehicles and the own speed; what is believed of the mount stays."""
        self._keep([False] * len(self._followed))
        self._doubts = Doubts(self._settings.belief, self._calibration.image_size.width)
        self._own, self._lead_id = OwnSpeed(), None

    def update(
        self,
        time_ns: int,
        detections: Sequence[Detection] | None,
        ego_speed_mps: float | None = None,
        yaw_rate_radps: float | None = None,
        image: NDArray[np.uint8] | None = None,
        path: OwnPath | None = None,
        mount: Mount | None = None,
        ego_speed_sigma_mps: float | None = None,
        turn: Turn | None = None,
        body_pitch_rad: Gaussian | None = None,
    ) -> tuple[Track, ...]:
        """Take one frame's detections.

        Args:
            time_ns: of the frame; intervals between frames may vary.
            detections: of the frame; None where it was not searched: then the vehicles move on, carried by
                the picture where it is given, and none counts as missed.
            ego_speed_mps: own speed, which tells oncoming and standing vehicles; None when unknown.
            yaw_rate_radps: how fast we turn, positive to the left, which bends the own path; None when
                unknown, then it is straight.
            image: (height, width, 3) BGR, the frame's own; None where there are boxes alone. With it the
                vehicles the detector misses are carried by their looks.
            path: our own, which is taken for that of speed and yaw rate; None where these are all there is.
            mount: of the camera as the picture tells it, which ranging goes by; None where it tells nothing.
            ego_speed_sigma_mps: 1-sigma of the own speed where it was measured; None or 0 where it was given.
            turn: our turning now, beside the path ahead, by which what is ahead sweeps across the picture;
                None takes the path to bend as we turn, and the sweep for a motion of the vehicles.
            body_pitch_rad: how much lower the camera looks now than its mount does, by the picture; None
                where it does not tell.

        Returns:
            The confirmed tracks in the order of their ids, coasting ones among them.

        Raises:
            ValueError: `time_ns` is before the last frame's.
        """
        if self._time_ns is not None and time_ns < self._time_ns:
            raise ValueError(f"frame time went back from {self._time_ns} to {time_ns} ns")
        dt_s = 0.0 if self._time_ns is None else (time_ns - self._time_ns) / 1e9
        self._time_ns = time_ns
        oldest_ns = time_ns - round(self._settings.coast_s * 1e9)
        self._keep([followed.last_ns >= oldest_ns for followed in self._followed])
        own_gain_mps = self._own.update(dt_s, ego_speed_mps, ego_speed_sigma_mps or 0.0)
        ego_speed_mps = self._own.speed_mps
        if path is None:
            path = OwnPath(curvature_per_m=path_curvature_per_m(ego_speed_mps, yaw_rate_radps))
        self._unsearched_s += dt_s
        search_s = None if detections is None else self._unsearched_s
        before = [followed.box for followed in self._followed]
        growths = self._range.predict(dt_s, own_gain_mps, path, self._own.gain_sigma_mps, body_pitch_rad)
        if mount is not None:
            self._range.take_mount(mount.pitch_rad, mount.pitch_sigma_rad, dt_s)
        turn_radps = None if turn is None else turn.rate_radps(path)
        for followed, growth in zip(self._followed, growths, strict=True):
            followed.predict(time_ns, dt_s, growth, search_s, turn_radps)
        moved = {} if image is None else self._carry(time_ns, image, before)
        detections = detections or ()
        pairs = self._associate(detections)
        unused = {index for index, detection in enumerate(detections) if not detection.faint}
        # What is doubtful hides nobody.
        doubted = {index for slot, index in pairs if self._followed[slot].doubtful}
        certain = [one.box for index, one in enumerate(detections) if not (one.faint or index in doubted)]
        free = {slot: self._free_edges(detections[index].box, certain) for slot, index in pairs}
        views = {
            slot: self._followed[slot].view_of(time_ns, detections[index].box, free[slot])
            for slot, index in pairs
        }
        self._range.update(
            [(slot, box) for slot, (box, _) in views.items()],
            max(self._unsearched_s, SHORTEST_STEP_S),
            {slot: edges for slot, (_, edges) in views.items()},
            [slot for slot, followed in enumerate(self._followed) if followed.doubtful],
        )
        if search_s is not None:
            for slot, followed in enumerate(self._followed):
                followed.free = free.get(slot, WHOLE)
        # The looks of what comes out from behind another vehicle seem to grow.
        grown = [
            (slot, *one[1:])
            for slot, one in moved.items()
            if math.isfinite(one.sigma) and self._followed[slot].free == WHOLE
        ]
        self._range.take_growths(grown, max(dt_s, SHORTEST_STEP_S))
        whole = [
            (slot, box)
            for slot, (box, edges) in views.items()
            if edges == WHOLE and not self._range.boxed_part(slot).log_part
        ]
        self._mount.update(self._rulers(whole), dt_s)
        self._mount_note.update(self._range.mount, dt_s)
        for slot, index in pairs:
            found = detections[index]
            self._followed[slot].correct(time_ns, views[slot][0], found.score, found.faint)
            unused.discard(index)
        if image is not None and search_s is not None:
            self._remember(image, time_ns)
        for followed in self._followed:
            followed.settle(time_ns)
        if search_s is not None:
            self._unsearched_s = 0.0
        for slot, followed in enumerate(self._followed):
            followed.state = self._state(slot)
            followed.place_across(self._range.focal_px, path, self._range.boxed_part(slot).news)
        self._keep([followed.is_worth_keeping() for followed in self._followed])
        for index in sorted(unused):
            self._start(time_ns, detections[index], certain, ego_speed_mps, path, turn_radps)
        self._doubts.update(time_ns, self._followed, image)
        tracks = tuple(
            followed.track(time_ns, path, turn) for followed in self._followed if followed.confirmed
        )
        own_sigma_mps = self._own.sigma_mps if ego_speed_sigma_mps is None else ego_speed_sigma_mps
        lead = select_lead(tracks, ego_speed_mps, own_sigma_mps)
        self._lead_id = lead.track_id if lead else None
        return tracks

    def _associate(self, detections: Sequence[Detection]) -> list[tuple[int, int]]:
        """Which vehicle, by slot, was found where.

        Boxes go to vehicles that are believed before those that are not yet: a second box of a vehicle begins
        a track that would take its first one from it. Faint boxes go to vehicles that are not found
        otherwise, or to none (both as in ByteTrack, Zhang et al. 2022).
        """
        settings, pairs = self._settings, list[tuple[int, int]]()
        slots = range(len(self._followed))
        believed = [slot for slot in slots if self._followed[slot].confirmed]
        new = [slot for slot in slots if not self._followed[slot].confirmed]
        for wanted, faint, least_iou in (
            (believed, False, 0.0),
            (new, False, 0.0),
            (slots, True, settings.faint_iou),
        ):
            taken, used = {slot for slot, _ in pairs}, {index for _, index in pairs}
            free = [slot for slot in wanted if slot not in taken]
            found = [
                index
                for index, detection in enumerate(detections)
                if detection.faint == faint and index not in used
            ]
            matched = associate(
                [self._followed[slot].box for slot in free],
                [detections[index].box for index in found],
                self._calibration.image_size,
                settings,
                least_iou,
            )
            pairs += [(free[row], found[column]) for row, column in matched]
        return sorted(pairs)

    def _carry(self, time_ns: int, image: NDArray[np.uint8], before: Sequence[Box]) -> dict[int, Moved]:
        """Find the vehicles in the picture, by slot, and move their boxes there."""
        moved = {}
        own_mps, slowest_mps = self._own.speed_mps, self._settings.following.driving_mps
        we_drive = own_mps is not None and own_mps >= slowest_mps
        for slot, followed in enumerate(self._followed):
            one = followed.looks.follow(image, before[slot], followed.box)
            if one is not None and followed.carry(time_ns, one, we_drive):
                moved[slot] = one
        return moved

    def _remember(self, image: NDArray[np.uint8], time_ns: int) -> None:
        """Take the looks of the lead and the nearest vehicles for the next pictures."""
        found = [followed for followed in self._followed if followed.seen_by == SeenBy.DETECTOR]
        hidden = set()
        for slot, followed in enumerate(self._followed):
            unfound = followed.seen_by != SeenBy.DETECTOR
            if unfound and any(_hides(other, followed) for other in found):
                # Its looks are another's by now: it is where it should be, until it is found again.
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
        """What the vehicles that are believed say of the mount."""
        readings = []
        for slot, box in boxes:
            followed = self._followed[slot]
            ruler = self._range.ruler(slot, box) if followed.confirmed else None
            if ruler is not None:
                readings.append(RulerReading((followed.track_id, self._range.kind(slot)), *ruler))
        return readings

    def _keep(self, worth: Sequence[bool]) -> None:
        """Forget the vehicles that are not worth it; slots of the range filter are places in the list."""
        if not all(worth):
            self._range.keep([slot for slot, keep in enumerate(worth) if keep])
            self._followed = [followed for followed, keep in zip(self._followed, worth, strict=True) if keep]

    def _state(self, slot: int) -> RangeState:
        """What is believed of a vehicle, with what the own speed says of it."""
        state, prior = self._range.state(slot), self._settings.speed_prior
        if self._own.speed_mps is None:
            return without_own_speed(state, prior)
        return with_own_speed(state, self._own.speed_mps, prior, self._own.sigma_mps)

    def _free_edges(self, box: Box, others: Sequence[Box]) -> Edges:
        return free_edges(box, others, self._calibration.camera, self._settings.model.rears[0].length_m)

    def _start(
        self,
        time_ns: int,
        detection: Detection,
        others: Sequence[Box],
        ego_speed_mps: float | None,
        path: OwnPath,
        turn_radps: float | None,
    ) -> None:
        """Begin a track, where the box gives a first distance."""
        if self._range.add(detection.box, ego_speed_mps, self._free_edges(detection.box, others)):
            state = self._state(self._range.count - 1)
            self._followed.append(
                Followed(
                    self._next_id,
                    time_ns,
                    detection,
                    state,
                    self._calibration,
                    self._settings,
                    self._range.focal_px,
                    path,
                    turn_radps,
                )
            )
            self._next_id += 1


def _hides(found: Followed, carried: Followed) -> bool:
    """Whether a vehicle that was found stands in front of one that was not, or the latter is a part of it."""
    box, other = found.box, carried.box
    inside = shared_area(box, other) / (other.w * other.h)
    nearer = found.state.distance_m < NEARER_RATIO * carried.state.distance_m
    return box.w > other.w and inside > (HIDDEN_PART_NEARER if nearer else HIDDEN_PART)
