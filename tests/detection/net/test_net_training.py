"""Vehicles as the net learns them, and background that is none."""

import importlib
import itertools
import sys

import cv2
import numpy as np
import pytest
from calibrate_helpers import DEMO_DRIVE
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.camera.file import read_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.net.glance import Glance
from fcw.detection.net.look import LOOK_PX
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel
from fcw.detection.net.training import background
from fcw.detection.net.training.background import Background, BackgroundSettings, mined, without_vehicle
from fcw.detection.net.training.batches import BatchSettings, draw_batch
from fcw.detection.net.training.framing import Framing, misplaced, well_framed
from fcw.detection.net.training.lottery import Lottery
from fcw.detection.net.training.vehicles import (
    BOTTOM_PX,
    MIDDLE_PX,
    STORED_PX,
    Circumstances,
    Seen,
    Standing,
    Vehicles,
    cut_at_bottom,
    cut_at_side,
    drawing_weights,
    hidden_by,
    with_lamps,
)
from fcw.detection.net.windows import WINDOW_UNITS, boxes_of
from fcw.detection.training.dataset import NO_BOX, LabelledImage, TrainingImage
from fcw.detection.training.looks import BRIGHTNESS, Looks, vary_looks
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.sources import open_source
from fcw_viz.cli import main


def seen(width: float = 40.0, height: float = 40.0, brightness: int = 200) -> Seen:
    """A bright vehicle on black."""
    picture = np.zeros((STORED_PX, STORED_PX, 3), np.uint8)
    left, top = round(MIDDLE_PX - width / 2), round(BOTTOM_PX - height)
    picture[top : round(BOTTOM_PX), left : round(MIDDLE_PX + width / 2)] = brightness
    return Seen(picture, Standing(MIDDLE_PX, BOTTOM_PX, width, height))


@given(st.integers(0, 10_000), st.integers(17, 22), st.integers(17, 22))
def test_the_offsets_learnt_say_where_the_vehicle_is_in_the_window(seed, half_width, half_height):
    window, offsets = well_framed(
        seen(2 * half_width, 2 * half_height), Framing(), np.random.default_rng(seed)
    )
    unit_px = LOOK_PX / WINDOW_UNITS
    expected = np.array([[32 * unit_px - 0.5, 52 * unit_px - 0.5, 40 * unit_px]])
    ((x, y, w, h),) = boxes_of(expected, offsets[None])
    rows, columns = np.nonzero(window[..., 0] > 100)
    found = columns.min() - 0.5, rows.min() - 0.5, columns.max() + 0.5, rows.max() + 0.5
    assert found == pytest.approx(np.clip((x, y, x + w, y + h), -0.5, LOOK_PX - 0.5), abs=1.6)


def test_what_is_cut_at_a_side_has_the_box_of_what_is_left():
    cut = cut_at_side(seen(), 0.25, left=True)
    assert cut.standing == Standing(MIDDLE_PX + 5, BOTTOM_PX, 30.0, 40.0)
    edge = int(MIDDLE_PX - 10)
    assert np.all(cut.picture[:, :edge] == cut.picture[:, edge : edge + 1])


def test_what_is_cut_at_the_bottom_has_the_box_of_what_is_left():
    cut = cut_at_bottom(seen(), 0.25, np.random.default_rng(0))
    assert cut.standing == Standing(MIDDLE_PX, BOTTOM_PX - 10, 40.0, 30.0)


@given(st.integers(0, 1000), st.floats(0.1, 0.45))
def test_a_vehicle_in_front_hides_that_part_of_the_width_and_not_more(seed, part):
    hidden = hidden_by(seen(brightness=90), seen(), part, np.random.default_rng(seed))
    assert hidden.standing == seen().standing
    row = hidden.picture[int(BOTTOM_PX) - 2, int(MIDDLE_PX - 20) : int(MIDDLE_PX + 20), 0]
    assert np.mean(row < 150) == pytest.approx(part, abs=0.08)


def test_lamps_shine_red_on_both_sides():
    lit = with_lamps(seen(brightness=20), np.random.default_rng(1))
    red = lit.picture[..., 2].astype(int) - lit.picture[..., 1]
    rows, columns = np.nonzero(red > 30)
    assert columns.min() < MIDDLE_PX - 5
    assert columns.max() > MIDDLE_PX + 5
    assert np.all(rows < BOTTOM_PX)


@given(st.integers(0, 1000))
def test_misplaced_windows_are_windows(seed):
    assert misplaced(seen(), Framing(), np.random.default_rng(seed)).shape == (LOOK_PX, LOOK_PX, 3)


def labelled(tmp_path, clip: str, boxes: int) -> TrainingImage:
    path = tmp_path / f"{clip}.png"
    cv2.imwrite(str(path), np.full((120, 200, 3), 90, np.uint8))
    image = LabelledImage(
        path,
        clip,
        ImageSize(200, 120),
        np.tile([60.0, 40.0, 40.0, 40.0], (boxes, 1)),
        np.zeros(boxes, bool),
        np.tile(NO_BOX, (boxes, 1)),
    )
    camera = GroundPlaneCamera(
        height_m=1.3, pitch_rad=0.0, focal_y_px=200.0, principal_row_px=40.0, principal_column_px=100.0
    )
    return TrainingImage(image, Calibration.from_camera(camera, ImageSize(200, 120)))


def test_the_many_vehicles_of_one_clip_do_not_rule():
    weights = drawing_weights(["many"] * 60 + ["few"] * 15)
    # Each of 60 counts sqrt(15 / 60) = half as much as each of 15.
    assert weights[0] / weights[-1] == pytest.approx(0.5)


def test_a_lottery_draws_in_proportion_to_weights():
    lottery, random = Lottery([1.0, 0.0, 3.0]), np.random.default_rng(0)
    drawn = np.bincount([lottery.draw(random) for _ in range(4000)], minlength=3)
    assert drawn[1] == 0
    assert drawn[2] / drawn[0] == pytest.approx(3.0, rel=0.15)


def test_windows_on_vehicles_or_on_what_may_be_one_are_no_background(tmp_path):
    image = labelled(tmp_path, "one", 1).labelled
    boxes = np.array([[62.0, 42.0, 40.0, 40.0], [130.0, 42.0, 40.0, 40.0]])
    assert without_vehicle(boxes, image).tolist() == [False, True]


def test_what_a_glance_sees_beside_vehicles_is_background_and_where_there_is_none_it_says_so(tmp_path):
    (frame,) = itertools.islice(open_source(DEMO_DRIVE).frames(31_000_000_000), 1)
    calibration = read_calibration(DEMO_DRIVE.with_name("drive.calibration.yaml"))
    cv2.imwrite(str(tmp_path / "picture.png"), frame.image)
    size, model = calibration.image_size, NetModel.load(SHIPPED_NET_PATH)

    def count(ignored: NDArray[np.float64], settings: BackgroundSettings) -> int:
        nothing = np.tile(NO_BOX, (len(ignored), 1))
        image = LabelledImage(
            tmp_path / "picture.png", "demo", size, ignored, np.ones(len(ignored), bool), nothing
        )
        return len(mined([TrainingImage(image, calibration)], model.glance, settings, Looks()))

    few = BackgroundSettings(count=3)
    assert count(np.zeros((0, 4)), few) == 6  # of the picture and of what it might look like
    with pytest.raises(UserError, match="nothing but vehicles"):
        count(np.array([[0.0, 0.0, size.width, size.height]]), few)


def test_background_is_not_what_the_band_for_wide_lenses_shows(tmp_path, monkeypatch):
    picture = np.random.default_rng(0).integers(0, 255, (720, 1280, 3), np.uint8)
    cv2.imwrite(str(tmp_path / "picture.png"), picture)
    size = ImageSize(1280, 720)
    wide = Calibration.from_camera(GroundPlaneCamera(0.02, 500.0, 359.5, 1.3, 639.5), size)
    nobody = np.zeros((0, 4))
    image = LabelledImage(tmp_path / "picture.png", "wide", size, nobody, np.zeros(0, bool), nobody)
    shown = []

    class Watched(Glance):
        def at(self, pyramid, bands):
            shown.append([band.shown.width for band in bands])
            return super().at(pyramid, bands)

    monkeypatch.setattr(background, "Glance", Watched)
    model, settings = NetModel.load(SHIPPED_NET_PATH), BackgroundSettings(least_logit=-20.0)
    mined([TrainingImage(image, wide)], model.glance, settings, Looks())
    assert shown == [[224, 448, 896]] * 2


def test_what_looks_more_like_a_vehicle_is_drawn_more_often():
    dark, bright = (np.full((63, 63, 3), v, np.uint8) for v in (0, 255))
    background, random = Background([dark, bright], np.array([3.0, 1.0])), np.random.default_rng(0)
    # Lights are set into some; the windows' own brightness is that of most of their pixels.
    drawn = [np.median(background.draw(random)) > 127 for _ in range(2000)]
    assert np.mean(drawn) == pytest.approx(0.25, abs=0.04)


def test_a_batch_has_vehicles_in_place_first_with_their_offsets(tmp_path):
    vehicles = Vehicles([labelled(tmp_path, "one", 3)], Circumstances())
    background = Background([*np.zeros((4, 63, 63, 3), np.uint8)], np.ones(4))
    settings = BatchSettings(count=40, vehicle_part=0.5)
    batch = draw_batch(vehicles, background, settings, np.random.default_rng(0))
    assert batch.windows.shape == (40, LOOK_PX, LOOK_PX, 3)
    assert batch.vehicle.tolist() == [1.0] * 20 + [0.0] * 20
    assert np.all(np.any(batch.offsets != 0, axis=1) == (batch.vehicle == 1))


def test_brightness_alone_leaves_grey_grey():
    grey = np.full((8, 8, 3), 120, np.uint8)
    still = Looks(
        **dict.fromkeys(("gamma", "colour_gain", "recoloured_part", "grey_part"), 0.0)
        | {"hazy_part": 0.0, "dark_part": 0.0, "noisy_part": 0.0}
    )
    assert np.array_equal(vary_looks(grey, still, np.random.default_rng(0)), grey)
    assert vary_looks(grey, BRIGHTNESS, np.random.default_rng(0)).shape == grey.shape


def test_without_pytorch_training_the_net_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    for name in ("pytorch", "network"):
        monkeypatch.delitem(sys.modules, f"fcw.detection.net.training.{name}", raising=False)
    with pytest.raises(UserError, match=r"pip install 'fcw\[train\]'"):
        importlib.import_module("fcw.detection.net.training.network")


@pytest.mark.parametrize("option", [("--score-threshold", "1.0"), ("--start-from", str(SHIPPED_NET_PATH))])
def test_the_other_detector_takes_no_options_of_the_net(option, tmp_path, capsys):
    command = ["train", "--data", str(tmp_path), "--out", str(tmp_path / "model.npz")]
    assert main([*command, *option]) == 2
    assert "--detector net" in capsys.readouterr().err


def test_what_is_no_model_is_named_before_anything_is_learnt(tmp_path, capsys):
    other = tmp_path / "other.npz"
    other.write_text("no model")
    command = ["train", "--data", str(tmp_path), "--out", str(tmp_path / "model.npz"), "--detector", "net"]
    assert main([*command, "--start-from", str(other)]) == 2
    assert f"{other}: not a model of the net" in capsys.readouterr().err
    assert not (tmp_path / "model.npz").exists()
