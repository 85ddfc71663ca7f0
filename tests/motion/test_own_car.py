"""Cells of the own car: what stands still at the lower or upper edge while the road moves; nothing else."""

import numpy as np
import pytest
from road_pictures import HEIGHT, WIDTH, Pose, Road

from fcw.box import Box
from fcw.motion.flow.own_car import OwnCar

CELL_PX = (24, 12)
STEP_S = 0.1
BONNET = HEIGHT * 3 // 4
SHADE = HEIGHT // 4


def pictures(speed_mps, frames=30, bonnet=True, exposure=0, shade_px=0):
    road, rng = Road(3), np.random.default_rng(2)
    clutter = np.kron(rng.integers(30, 180, ((HEIGHT - BONNET) // 6, WIDTH // 8)), np.ones((6, 8)))
    for frame in range(frames):
        grey = road.picture(Pose(speed_mps * STEP_S * frame))[:, :, 1].astype(float)
        if bonnet:
            grey[BONNET:] = clutter
        grey[:shade_px] = np.tile(clutter, (4, 1))[:shade_px]
        grey += rng.normal(0, 1.0, grey.shape) + exposure * (frame % 2)
        yield round(frame * STEP_S * 1e9), np.clip(grey, 0, 255).astype(np.uint8)


def learned(shown, others=()):
    own = OwnCar((HEIGHT, WIDTH), CELL_PX)
    last = None
    for time_ns, grey in shown:
        if last is not None:
            own.look(time_ns, last, grey, others)
        last = grey
    return own.cells.reshape(-1, -(-(WIDTH // 4 - 1) // 6))


def bonnet_rows():
    return np.arange(len(learned([]))) * CELL_PX[1] >= BONNET


@pytest.mark.slow
@pytest.mark.parametrize("exposure", [0, 15])
def test_a_bonnet_is_found_and_ends_where_the_road_begins(exposure):
    cells = learned(pictures(10.0, exposure=exposure))
    assert cells[bonnet_rows()].mean() > 0.95
    assert cells[~bonnet_rows()].mean() < 0.02


@pytest.mark.slow
def test_a_road_without_one_has_none():
    assert not learned(pictures(10.0, bonnet=False)).any()


@pytest.mark.slow
@pytest.mark.parametrize("shade_px", [SHADE, HEIGHT // 2])
def test_a_sunshade_is_found_and_goes_down_to_a_third_at_most(shade_px):
    cells = learned(pictures(10.0, bonnet=False, shade_px=shade_px))
    rows = (np.arange(len(cells)) + 1) * CELL_PX[1] <= min(shade_px, HEIGHT / 3)
    assert cells[rows].mean() > 0.95
    assert cells[~rows].mean() < 0.05


@pytest.mark.slow
def test_nothing_is_learned_while_we_stand():
    assert not learned(pictures(0.0)).any()


@pytest.mark.slow
def test_a_vehicle_ahead_at_a_constant_gap_is_not_the_own_car():
    lead = Box(0, BONNET, WIDTH, HEIGHT - BONNET)
    assert not learned(pictures(10.0), others=(lead,)).any()


def test_pictures_of_any_size_have_as_many_cells_as_corners():
    from fcw.motion.flow.corners import find_corners

    for shape in ((360, 640), (187, 621), (351, 633), (96, 128)):
        grey = np.zeros(shape, np.uint8)
        assert len(OwnCar(shape, CELL_PX).cells) == len(find_corners(grey, CELL_PX).scores)
        OwnCar(shape, CELL_PX).look(0, grey, grey)
