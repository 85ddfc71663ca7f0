"""A vehicle's looks are found again where they are, as large as they are, or not at all."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from searching import examples

from fcw.box import Box
from fcw.tracking.picture.follower import Follower, FollowingSettings
from fcw.tracking.picture.patch import find_patch, likeness, search_patch, take_patch

WIDTH, HEIGHT = 640, 360


def smooth_noise(seed, sigma_px, height=HEIGHT, width=WIDTH):
    noise = np.random.default_rng(seed).standard_normal((height, width, 3))
    smooth = cv2.GaussianBlur(noise, (0, 0), sigma_px)
    return np.clip(128 + 45 * smooth / smooth.std(), 0, 255).astype(np.uint8)


REAR = smooth_noise(1, 8.0, 300, 400)
ROAD = smooth_noise(2, 4.0)


def picture(box, light=1.0, rear=REAR, road=ROAD):
    """A rear that fills the box, before a background."""
    matrix = np.array([[box.w / 400, 0.0, box.x], [0.0, box.h / 300, box.y]])
    size = (road.shape[1], road.shape[0])
    painted = cv2.warpAffine(rear, matrix, size, flags=cv2.INTER_AREA)
    cover = cv2.warpAffine(np.ones(rear.shape[:2], np.float32), matrix, size)[..., None]
    return np.clip((painted * cover + road * (1 - cover)) * light, 0, 255).astype(np.uint8)


def moved(box, growth, shift_x=0.0, shift_y=0.0):
    w, h = box.w * growth, box.h * growth
    return Box(box.center_x + shift_x - w / 2, box.y + box.h / 2 + shift_y - h / 2, w, h)


@examples(30)
@given(
    width=st.floats(60, 300),
    growth=st.floats(0.93, 1.08),
    x=st.floats(-0.05, 0.05),
    y=st.floats(-0.05, 0.05),
    light=st.floats(0.5, 1.1),
)
def test_growth_and_place_are_measured_in_any_size_and_light(width, growth, x, y, light):
    box = Box(300 - width / 2, 180 - width * 3 / 8, width, width * 3 / 4)
    there = moved(box, growth, x * width, y * width)
    patch = take_patch(picture(box), box)
    assert patch is not None
    found = find_patch(picture(there, light), patch, patch.pose)
    assert found is not None
    assert found.share > 0.7
    carried = patch.pose.carried(box, found.pose)
    assert math.log(carried.w / box.w) == pytest.approx(math.log(growth), abs=0.008)
    assert carried.center_x == pytest.approx(there.center_x, abs=0.01 * width)
    assert carried.bottom == pytest.approx(there.bottom, abs=0.01 * width)


def test_what_has_jumped_by_a_bump_is_searched_and_found():
    box = Box(280, 150, 80, 60)
    there = moved(box, 1.0, 3.0, 18.0)
    patch = take_patch(picture(box), box)
    assert patch is not None
    pose = search_patch(picture(there), patch, patch.pose)
    assert pose is not None
    carried = patch.pose.carried(box, pose)
    assert (carried.center_x, carried.bottom) == pytest.approx((there.center_x, there.bottom), abs=1.5)
    assert search_patch(smooth_noise(7, 6.0), patch, patch.pose) is None


def test_a_small_one_without_corners_is_found_as_a_whole_but_its_growth_is_not_known():
    # A dark blob with a bright window, in the noise of a night.
    blob = np.full((300, 400, 3), 40, np.uint8)
    blob[60:140, 80:320] = 200
    box, there = Box(300.0, 180.0, 24.0, 18.0), Box(302.0, 181.0, 24.0, 18.0)
    asphalt = np.full_like(ROAD, 110)
    rng = np.random.default_rng(5)

    def noisy(at):
        clean = picture(at, rear=blob, road=asphalt).astype(float)
        return np.clip(clean + 14 * rng.standard_normal(clean.shape[:2])[..., None], 0, 255).astype(np.uint8)

    for _ in range(10):
        follower = Follower(FollowingSettings())
        follower.remember(noisy(box), box, 0, detected=True)
        one = follower.follow(noisy(there), box, box)
        assert one is not None
        assert math.isinf(one.sigma)
        assert (one.box.center_x, one.box.bottom) == pytest.approx((there.center_x, there.bottom), abs=1.0)


def test_a_patch_is_like_itself_and_unlike_others():
    box = Box(280, 150, 80, 60)
    patch = take_patch(picture(box), box)
    assert patch is not None
    dark, other = picture(box, 0.6), picture(box, rear=smooth_noise(5, 8.0, 300, 400))
    assert likeness(dark, patch, patch.pose) == pytest.approx(1.0, abs=0.02)
    assert likeness(other, patch, patch.pose) == pytest.approx(0.0, abs=0.4)
    assert likeness(dark, patch, patch.pose._replace(x=-1000.0)) is None


def test_what_has_no_looks_is_not_followed():
    assert take_patch(np.full((HEIGHT, WIDTH, 3), 250, np.uint8), Box(280, 150, 80, 60)) is None
    assert take_patch(ROAD, Box(630, 150, 80, 60)) is None  # almost out of the picture


def following(boxes, pictures):
    """Follow without any detection but the first; where it was found, None where it was not.

    It is expected to grow as it did before, as the tracker's filter does.
    """
    follower, box, growth, found = Follower(FollowingSettings()), boxes[0], 1.0, []
    follower.remember(pictures[0], box, 0, detected=True)
    for k, image in enumerate(pictures[1:], 1):
        predicted = moved(box, growth)
        one = follower.follow(image, box, predicted)
        found.append(one)
        growth = growth if one is None else one.box.w / box.w
        box = predicted if one is None else one.box
        follower.remember(image, box, k * 33_000_000, detected=False)
    return found


def test_it_is_followed_until_it_fills_the_picture_and_beyond():
    # From an eighth of the picture's width to one and a half times it, its lower edge long out of it.
    boxes = [moved(Box(280, 150, 80, 60), math.exp(0.05 * k), 0.0, 1.5 * k) for k in range(50)]
    found = following(boxes, [picture(box) for box in boxes])
    assert boxes[-1].w > 1.4 * WIDTH
    assert boxes[-1].bottom > HEIGHT + 200
    for one, box in zip(found, boxes[1:], strict=True):
        assert one is not None
        assert one.box.w == pytest.approx(box.w, rel=0.05)
        assert one.box.center_x == pytest.approx(box.center_x, abs=0.04 * box.w)


def test_it_is_lost_when_something_else_is_in_its_place():
    boxes = [Box(280, 150, 80, 60)] * 12
    others = [picture(box, rear=smooth_noise(20 + k, 8.0, 300, 400)) for k, box in enumerate(boxes[6:])]
    found = following(boxes, [picture(box) for box in boxes[:6]] + others)
    assert all(one is not None for one in found[:5])
    assert not any(one is not None for one in found[5:])


def test_glare_of_some_frames_does_not_end_it():
    boxes = [moved(Box(280, 150, 80, 60), math.exp(0.01 * k)) for k in range(20)]
    pictures = [picture(box) for box in boxes]
    pictures[8:12] = [np.full_like(ROAD, 254)] * 4
    found = following(boxes, pictures)
    assert not any(one is not None for one in found[7:11])
    assert found[-1] is not None
    assert found[-1].box.w == pytest.approx(boxes[-1].w, rel=0.03)


def test_what_is_not_it_is_not_taken_for_its_looks_while_it_is_carried():
    # It changes slowly into something else: no step is large, but it ends unlike what was detected.
    box, other = Box(280, 150, 80, 60), smooth_noise(9, 8.0, 300, 400)
    parts = np.linspace(0.0, 1.0, 40)
    pictures = [picture(box, rear=cv2.addWeighted(REAR, 1 - part, other, part, 0)) for part in parts]
    found = following([box] * 40, pictures)
    assert found[0] is not None
    assert found[-1] is None
