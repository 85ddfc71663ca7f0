"""One vehicle followed by its looks, and when it is lost.

Its patch is compared with the one remembered, not with that of the frame before: errors do not add up while
it looks the same. A new one is remembered where the vehicle has grown or turned too much for the old one.
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
        most: the most vehicles that are followed, the nearest ones; it bounds the time of a frame.
        least_share: the smallest part of the points in the picture that must agree on one motion.
        least_share_alike: the same if the patch as a whole was found: the background in it may have moved on.
        few_points: if the corners are not found, a patch with fewer of them than this is searched as a whole:
            a vehicle far away or in the dark has few. 9, 12 and 16 gave the same gaps on each of four clips.
        renewed_left: the looks are remembered anew when a smaller part of all points than this is left.
        renewed_ratio: so they are when the vehicle has become this many times larger or smaller.
        renewed_s: so they are after this time while the detector sees it: its box says what belongs to the
            vehicle.
        least_likeness: correlation with the looks at the last detection, below which something else is
            followed. They are compared every `compared_s` while the vehicle is carried.
        pitch_rad: largest pitch, with bumps, by which the lower edge may be off the road.
        uneven: largest part of its height by which it may be off in addition.
        compared_s: see `least_likeness`.
        regained_likeness: correlation from which a vehicle that was lost is followed again.
        still_rad: what is carried for `still_s` and moves by less than this in the picture is not on the
            road, but a reflection in the windscreen, or dirt. Every car nods and sways more: on seven clips
            vehicles moved by at least 1.6 mrad within a second, a reflection by 1.0.
        still_s: see `still_rad`.
        driving_mps: least own speed for `still_rad`; a lead that we stand behind stands still.
        floor_sigma: 1-sigma of the logarithm of the growth, in addition to the scatter of the points.
        credit: the longest time for which a vehicle is carried, in times for which the detector saw it.
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
        log_growth: logarithm of its size over that when its looks were remembered.
        sigma: 1-sigma of that; inf where it was found as large as expected, by too few corners to tell.
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
        """Find it in the next picture; None where it is not seen there, or nothing is remembered.

        Args:
            image: (height, width, 3) BGR.
            before: its box in the picture before.
            predicted: and where it is expected in this one.
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
        """Where it is and how it has grown; its place alone where its corners are too few for that."""
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
        """Forget its looks, so that it is followed no more."""
        self._patch = None

    def remember(self, image: Picture, box: Box, time_ns: int, detected: bool) -> bool:
        """Take its looks from this picture where the old ones no longer serve; returns whether it did.

        Args:
            image: the picture into which it was last followed.
            box: its box there.
            time_ns: of the picture.
            detected: whether the detector saw it, so that the box is not carried.
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
        """Whether it looks as it did when the detector last saw it, as far as that is in the picture."""
        if self._anchor is None:
            return False
        alike = likeness(image, self._anchor, self._anchor_pose)
        return self._patch is not None if alike is None else alike >= least
