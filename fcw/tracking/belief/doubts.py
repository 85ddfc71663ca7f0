"""Which vehicles are believed: one that appears from nothing near us must earn it before it hides another.

A real vehicle comes into the picture from afar, from the sides, from behind another vehicle, or was there at
the start. A near box that appears anywhere else is a vehicle that the detector found late, or no vehicle: a
reflection, our own bonnet, a logo, plain road. It is believed after it was seen for a while, and sooner if it
moves relative to us. It is not believed while it is hardly ever detected, while another vehicle is seen
through it, as vehicles are opaque, or if it or its lower part is stationary in the picture. These rules also
apply to believed vehicles until they were found well, because a box that was there at the start may be no
vehicle either.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box, shared_area
from fcw.tracking.belief.settings import BeliefSettings
from fcw.tracking.belief.still_picture import StillPicture
from fcw.tracking.followed import Followed
from fcw.tracking.types import SeenBy

BESIDE_PART = 0.25
"""A vehicle that was hidden appears within this distance beside the one that hid it, as a fraction of its
width."""
FOOT_PART = 1 / 3
"""Lower part of a box that must not be stationary in the picture. It is stationary if our own dashboard or a
picture within the picture is boxed together with moving road. Within 25 m of the cameras of 77 strangers'
clips, it was stationary for no vehicle, even if the pictures were darkened and strongly compressed (a third
as bright, crf 40), and for two objects that were no vehicles, each of which was the lead nearly all the time.
With a half, one of these would be missed."""


class Doubts:
    """Judges the vehicles of one drive.

    Args:
        settings: see `BeliefSettings`.
        image_width_px: of the pictures.
    """

    def __init__(self, settings: BeliefSettings, image_width_px: int) -> None:
        self._settings = settings
        self._width_px = image_width_px
        self._still = StillPicture(settings.still)
        self._still_feet = StillPicture(settings.still)
        self._first_ns: int | None = None
        self._since_ns: dict[int, int | None] = {}
        """By track, since when it has been earning belief; None if it is believed."""
        self._lost: list[tuple[int, Box]] = []
        """Time and box of believed vehicles that are no longer tracked."""
        self._places: dict[int, tuple[bool, Box]] = {}
        self._through_ns: dict[tuple[int, int], int] = {}
        """By a pair of tracks, when the detector last found the second where the first would hide it."""
        self._well_found: set[int] = set()
        """Vehicles that the detector has found for so long that they are no longer doubted."""

    def update(self, time_ns: int, followed: Sequence[Followed], image: NDArray[np.uint8] | None) -> None:
        """Decide for every vehicle whether it is doubtful.

        Args:
            time_ns: time of the frame.
            followed: the vehicles in their present state.
            image: the frame's picture; None if there is none.
        """
        if self._first_ns is None:
            self._first_ns = time_ns
        settings, ids = self._settings, {one.track_id for one in followed}
        self._lost = [
            *((at_ns, box) for at_ns, box in self._lost if time_ns - at_ns < settings.remembered_s * 1e9),
            *((time_ns, box) for number, (sure, box) in self._places.items() if sure and number not in ids),
        ]
        self._since_ns = {number: since for number, since in self._since_ns.items() if number in ids}
        for one in followed:
            if one.track_id not in self._since_ns:
                self._since_ns[one.track_id] = None if self._is_announced(time_ns, one, followed) else time_ns
        self._well_found &= ids
        for one in followed:
            if one.found_s >= settings.well_found_s and one.found_part >= settings.well_found_part:
                self._well_found.add(one.track_id)
        self._look_through(time_ns, followed)
        for one in followed:
            since_ns = self._since_ns[one.track_id]
            if since_ns is None:
                if self._is_none_after_all(one, followed):
                    self._since_ns[one.track_id] = time_ns
            elif any(self._shows_through(one, other) for other in followed):
                self._since_ns[one.track_id] = time_ns
            elif one.seen_by is SeenBy.DETECTOR and self._has_earned(one, (time_ns - since_ns) / 1e9):
                self._since_ns[one.track_id] = None
        still = set()
        if image is not None:
            still = self._still.update(time_ns, image, {one.track_id: one.box for one in followed})
            near = [one for one in followed if one.state.distance_m < settings.far_m]
            feet = {one.track_id: _foot(one.box, image.shape[0]) for one in near}
            # Where all of it stands it may be a vehicle that stands as we do, and is believed once it moves.
            for number in self._still_feet.update(time_ns, image, feet) - still:
                self._since_ns[number] = time_ns
        for one in followed:
            one.doubtful = self._since_ns[one.track_id] is not None or one.track_id in still
        self._places = {one.track_id: (one.confirmed and not one.doubtful, one.box) for one in followed}

    def _is_announced(self, time_ns: int, one: Followed, followed: Sequence[Followed]) -> bool:
        """Whether it appeared where vehicles come into the picture."""
        settings, box = self._settings, one.box
        assert self._first_ns is not None
        margin_px = settings.side_part * self._width_px
        return (
            time_ns - self._first_ns <= settings.start_s * 1e9
            or one.state.distance_m >= settings.far_m
            or box.x <= margin_px - 0.5
            or box.right >= self._width_px - 0.5 - margin_px
            or any(_touch(box, lost) for _, lost in self._lost)
            # It came out from behind a nearer vehicle.
            or any(
                other is not one
                and self._since_ns.get(other.track_id, 0) is None
                and other.state.distance_m < one.state.distance_m
                and _touch(box, other.box)
                for other in followed
            )
        )

    def _is_none_after_all(self, one: Followed, followed: Sequence[Followed]) -> bool:
        """Whether a believed vehicle that was never found well is hardly detected now, or seen through."""
        if one.track_id in self._well_found or one.state.distance_m >= self._settings.far_m:
            return False
        return one.found_lately < self._settings.kept_part or any(
            other.track_id in self._well_found and self._shows_through(one, other) for other in followed
        )

    def _look_through(self, time_ns: int, followed: Sequence[Followed]) -> None:
        """Record which vehicles were found in this frame where a nearer one would hide them.

        Only this frame's detections count: a vehicle that cuts in hides the lead from that moment on.
        """
        settings = self._settings
        latest_ns = time_ns - settings.through_s * 1e9
        self._through_ns = {pair: at_ns for pair, at_ns in self._through_ns.items() if at_ns >= latest_ns}
        for other in followed:
            if other.detected_ns != time_ns:
                continue
            for one in followed:
                farther = other.state.distance_m > settings.through_ratio * one.state.distance_m
                if one is not other and farther and _inside(other.box, one.box) >= settings.through_part:
                    self._through_ns[one.track_id, other.track_id] = time_ns

    def _shows_through(self, one: Followed, other: Followed) -> bool:
        """Whether another believed vehicle was just seen where this one would hide it."""
        believed = other.confirmed and self._since_ns[other.track_id] is None
        return believed and (one.track_id, other.track_id) in self._through_ns

    def _has_earned(self, one: Followed, seen_s: float) -> bool:
        settings, state = self._settings, one.state
        if one.found_lately < settings.earned_part or one.box.w >= settings.filling_part * self._width_px:
            return False
        speed_mps, sigma_mps = abs(state.closing_speed_mps), state.closing_speed_sigma_at_distance_mps
        if speed_mps <= max(settings.moving_sigmas * sigma_mps, settings.moving_mps):
            return seen_s >= settings.earned_still_s
        surely = speed_mps > settings.surely_sigmas * sigma_mps
        return seen_s >= (settings.earned_surely_s if surely else settings.earned_s)


def _foot(box: Box, height_px: int) -> Box:
    """The lower part of a box, within the picture."""
    foot_px = FOOT_PART * (min(box.bottom, height_px) - box.y)
    return Box(box.x, min(box.bottom, height_px) - foot_px, box.w, foot_px)


def _touch(box: Box, other: Box) -> bool:
    """Whether a box touches another one, or came out from behind it since the previous frame."""
    pad_px = BESIDE_PART * other.w
    return shared_area(box, Box(other.x - pad_px, other.y, other.w + 2 * pad_px, other.h)) > 0


def _inside(box: Box, other: Box) -> float:
    """Fraction of a box that is inside another one."""
    return shared_area(box, other) / (box.w * box.h)
