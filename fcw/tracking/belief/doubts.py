"""Which vehicles are believed: what appears from nothing near us must earn it before it may hide another.

A vehicle comes into the picture from afar, from its sides, from behind another vehicle, or was there at the
start. A near box that appears elsewhere is a vehicle that the detector found late, or none: a reflection, the
own bonnet, a logo, plain road. It is believed once it was seen for a while, sooner if it moves against us;
and not while it is hardly ever detected, nor while somebody is seen through it, as vehicles are opaque, nor
where it, or its lower part, stands still in the picture. Until it was well found all this holds for what was
believed, too: what was there at the start may have been none.
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
"""What was hidden is found this near beside what hid it, as a part of that one's width."""
FOOT_PART = 1 / 3
"""The lower part of a box stands still where the road is boxed with our own dashboard, or a picture within a
picture, in which something moves. Within 25 m of the cameras of 77 strangers' clips it stood still of no
vehicle, also where their pictures were made dark and compressed hard (a third as bright, crf 40), and of two
that were none, each of which was the lead nearly all the time. A half would miss one."""


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
        """By track, since when it earns belief; None where it is believed."""
        self._lost: list[tuple[int, Box]] = []
        """Time and place of believed vehicles that are followed no more."""
        self._places: dict[int, tuple[bool, Box]] = {}
        self._through_ns: dict[tuple[int, int], int] = {}
        """When the detector found, where one track would hide it, another: by the two of them."""
        self._well_found: set[int] = set()
        """Vehicles that the detector found for so long that nothing is doubted any more."""

    def update(self, time_ns: int, followed: Sequence[Followed], image: NDArray[np.uint8] | None) -> None:
        """Decide of every vehicle whether it is doubtful.

        Args:
            time_ns: of the frame.
            followed: the vehicles, as they are now.
            image: the frame's own; None where there is none.
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
        """Whether it came from where vehicles come from."""
        settings, box = self._settings, one.box
        assert self._first_ns is not None
        margin_px = settings.side_part * self._width_px
        return (
            time_ns - self._first_ns <= settings.start_s * 1e9
            or one.state.distance_m >= settings.far_m
            or box.x <= margin_px - 0.5
            or box.right >= self._width_px - 0.5 - margin_px
            or any(_touch(box, lost) for _, lost in self._lost)
            # From behind a nearer vehicle.
            or any(
                other is not one
                and self._since_ns.get(other.track_id, 0) is None
                and other.state.distance_m < one.state.distance_m
                and _touch(box, other.box)
                for other in followed
            )
        )

    def _is_none_after_all(self, one: Followed, followed: Sequence[Followed]) -> bool:
        """Whether what was believed, and was never well found, is hardly detected, or seen through."""
        if one.track_id in self._well_found or one.state.distance_m >= self._settings.far_m:
            return False
        return one.found_lately < self._settings.kept_part or any(
            other.track_id in self._well_found and self._shows_through(one, other) for other in followed
        )

    def _look_through(self, time_ns: int, followed: Sequence[Followed]) -> None:
        """Take who was found where a nearer one would hide it.

        Found before that one came there it says nothing: who cuts in hides the lead from that moment on.
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
        """Whether another vehicle that is believed was just seen where this one would hide it."""
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
    """The lower part of a box, as far as the picture shows it."""
    foot_px = FOOT_PART * (min(box.bottom, height_px) - box.y)
    return Box(box.x, min(box.bottom, height_px) - foot_px, box.w, foot_px)


def _touch(box: Box, other: Box) -> bool:
    """Whether a box is at another one, or came out from behind it since the frame before."""
    pad_px = BESIDE_PART * other.w
    return shared_area(box, Box(other.x - pad_px, other.y, other.w + 2 * pad_px, other.h)) > 0


def _inside(box: Box, other: Box) -> float:
    """How much of a box is inside another one."""
    return shared_area(box, other) / (box.w * box.h)
