"""Follows one vehicle by its looks, and decides when it is lost.

The picture is compared with a stored patch, not with the previous frame, so that errors do not add up. A new
patch is stored when the vehicle has grown or turned too much for the old one.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from fcw.box import Box
from fcw.tracking.picture.patch import (
    Found,
    Patch,
    Picture,
    Pose,
    find_patch,
    likeness,
    search_patch,
    take_patch,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowingSettings:
    """How vehicles are followed by the picture, and how long without the detector.

    Attributes:
        most: the largest number of vehicles that are followed, the nearest ones. It bounds the time per
            frame.
        least_share: the least fraction of the points in the picture that must agree on one motion.
        least_share_alike: the same if the patch as a whole was found, as the background in it may have moved.
        few_points: a patch with fewer corners than this may be found by its correlation alone. A vehicle far
            away or in the dark has few corners. 9, 12 and 16 gave the same gaps on each of four clips.
        renewed_left: a new patch is stored when a smaller fraction of the points than this is left.
        renewed_ratio: a new patch is stored when the vehicle has become larger or smaller by this factor.
        renewed_s: a new patch is stored after this time while the detector sees the vehicle, because the
            detector's box tells which pixels are the vehicle's.
        least_likeness: correlation with the patch at the last detection below which something else is being
            followed. It is checked every `compared_s` while the vehicle is carried.
        pitch_rad: largest error of the lower edge due to pitch and bumps.
        uneven: largest additional error of the lower edge, as a fraction of the box's height.
        compared_s: see `least_likeness`.
        regained_likeness: correlation from which a lost vehicle is followed again.
        still_rad: a patch that is carried for `still_s` and moves by less than this in the picture is not on
            the road, but a reflection or dirt on the windscreen. Every car pitches and sways more: on seven
            clips vehicles moved by at least 1.6 mrad within a second, a reflection by 1.0.
        still_s: see `still_rad`.
        driving_mps: least own speed for `still_rad`, as a lead is stationary while we stand behind it.
        floor_sigma: 1-sigma of the log growth, in addition to the scatter of the points.
        credit: a vehicle is carried for at most this many times as long as the detector saw it.
        longest_s: the longest time for which any vehicle is carried.
    """

    most: int = 5
    least_share: float = 0.5
    least_share_alike: float = 0.3
    few_points: int = 12
    renewed_left: float = 0.7
    renewed_ratio: float = 1.25
    renewed_s: float = 0.7
    least_likeness: float = 0.5
    compared_s: float = 0.3
    regained_likeness: float = 0.7
    pitch_rad: float = math.radians(2.0)
    uneven: float = 0.15
    still_rad: float = 0.0013
    still_s: float = 1.0
    driving_mps: float = 3.0
    floor_sigma: float = 0.003
    credit: float = 10.0
    longest_s: float = 15.0


class Moved(NamedTuple):
    """A vehicle found again by its looks.

    Attributes:
        box: its box in the new picture.
        log_growth: logarithm of its size over its size when its patch was stored.
        sigma: 1-sigma of `log_growth`; inf if the patch had too few corners to measure it.
    """

    box: Box
    log_growth: float
    sigma: float


class Follower:
    """Follows one vehicle.

    Args:
        settings: see `FollowingSettings`.
    """

    def __init__(self, settings: FollowingSettings) -> None:
        self._settings = settings
        self._patch: Patch | None = None
        self._pose = Pose(0.0, 0.0, 1.0)
        self._anchor: Patch | None = None
        self._anchor_pose = self._pose
        self._taken_ns = self._compared_ns = 0
        self._left = 1.0

    def follow(self, image: Picture, before: Box, predicted: Box) -> Moved | None:
        """Find it in the next picture; None if it is not seen there, or no patch is stored.

        Args:
            image: (height, width, 3) BGR.
            before: its box in the previous picture.
            predicted: its predicted box in this picture.
        """
        anchored = self._anchor_pose.moved(before, predicted)
        if self._patch is None:
            self._anchor_pose = anchored
            return None
        expected = self._pose.moved(before, predicted)
        found = self._find(image, self._patch, expected)
        if found is None:
            self._pose, self._anchor_pose, self._left = expected, anchored, 0.0
            return None
        if isinstance(found, Pose):
            self._pose, self._left, sigma = found, 0.0, math.inf
        else:
            self._pose, self._left = found.pose, found.growth.agree / len(self._patch.points)
            sigma = math.hypot(self._settings.floor_sigma, found.growth.log_scale_sigma)
        box = expected.carried(predicted, self._pose)
        self._anchor_pose = anchored.moved(predicted, box)
        return Moved(box, math.log(self._pose.zoom / self._patch.pose.zoom), sigma)

    def _find(self, image: Picture, patch: Patch, expected: Pose) -> Found | Pose | None:
        """Where it is and how it has grown; only where it is if there are too few corners."""
        found = find_patch(image, patch, expected)
        if found is not None and found.share >= self._settings.least_share:
            return found
        jumped = search_patch(image, patch, expected)
        if jumped is None:
            return None
        found = find_patch(image, patch, jumped)
        if found is not None and found.share >= self._settings.least_share_alike:
            return found
        return jumped if len(patch.points) < self._settings.few_points else None

    def forget(self) -> None:
        """Forget the patch, so that the vehicle is no longer followed."""
        self._patch = None

    def remember(self, image: Picture, box: Box, time_ns: int, detected: bool) -> bool:
        """Store a new patch if the old one is no longer good; returns whether it did.

        Args:
            image: the picture into which it was last followed.
            box: its box there.
            time_ns: time of the picture.
            detected: whether the detector found it there, so that the box was not carried.
        """
        settings, patch = self._settings, self._patch
        due = patch is None or self._is_due(patch, time_ns, detected)
        long_since = self._left > 0 and time_ns - self._compared_ns >= settings.compared_s * 1e9
        if not detected and (due or long_since):
            self._compared_ns = time_ns
            if not self._is_alike(image, settings.least_likeness if patch else settings.regained_likeness):
                self._patch = None
                return False
        if not due:
            return False
        taken = take_patch(image, box)
        if taken is None:
            return False
        self._patch, self._pose, self._taken_ns, self._left = taken, taken.pose, time_ns, 1.0
        if detected:
            self._anchor, self._anchor_pose = taken, taken.pose
        return True

    def _is_due(self, patch: Patch, time_ns: int, detected: bool) -> bool:
        settings = self._settings
        if detected and (time_ns - self._taken_ns) / 1e9 >= settings.renewed_s:
            return True
        if self._left == 0.0:
            return detected
        ratio = self._pose.zoom / patch.pose.zoom
        return self._left < settings.renewed_left or not (
            1 / settings.renewed_ratio <= ratio <= settings.renewed_ratio
        )

    def _is_alike(self, image: Picture, least: float) -> bool:
        """Whether it still looks as it did when the detector last saw it, as far as it is in the picture."""
        if self._anchor is None:
            return False
        alike = likeness(image, self._anchor, self._anchor_pose)
        return self._patch is not None if alike is None else alike >= least
