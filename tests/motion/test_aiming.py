"""Where vehicles are looked for follows what is believed of the camera, in a way that no thread changes."""

import math

import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.acf import AcfDetector, AcfSettings
from fcw.detection.choice import load_model, make_detector
from fcw.detection.detector import Aim, AimedDetector
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.detection.net.detector import NetDetector
from fcw.frame import ImageSize
from fcw.motion.aiming import Aims, aim_at, take_aim
from fcw.motion.state import Mount
from fcw.tracking.tracker import Tracker

SIZE = ImageSize(1280, 720)
CALIBRATION = Calibration.from_camera(GroundPlaneCamera(0.03, 1100.0, 359.5, 1.3, 639.5), SIZE)


def mount(pitch_deg: float, sigma_deg: float = 0.2) -> Mount:
    return Mount(pitch_rad=math.radians(pitch_deg), pitch_sigma_rad=math.radians(sigma_deg))


def pitches_deg(aims: Aims, count: int) -> list[float]:
    return [round(math.degrees(aims.next().pitch_rad), 6) for _ in range(count)]


def test_the_aim_of_a_frame_is_the_belief_a_fixed_number_of_frames_before() -> None:
    aims = Aims(mount(1.0), lag=3)
    for _ in range(2):
        aims.believe(mount(1.0))
    aims.believe(mount(4.0))
    assert pitches_deg(aims, 6) == [1.0] * 5 + [4.0]


@pytest.mark.parametrize(
    ("pitch_deg", "sigma_deg", "followed"), [(1.9, 0.1, False), (2.3, 0.7, False), (2.3, 0.3, True)]
)
def test_only_what_is_far_off_and_sure_is_followed(
    pitch_deg: float, sigma_deg: float, followed: bool
) -> None:
    aims = Aims(mount(1.0, 0.3), lag=0)
    aims.believe(mount(pitch_deg, sigma_deg))
    assert pitches_deg(aims, 1) == [pitch_deg if followed else 1.0]


def test_a_camera_that_is_less_known_is_looked_through_with_more_tolerance() -> None:
    tolerances = [aim_at(mount(1.0, sigma_deg)).tolerance_rad for sigma_deg in (0.1, 0.7, 1.0, 5.0)]
    assert tolerances == pytest.approx([math.radians(angle) for angle in (1, 1, 2, 3)])
    aims = Aims(mount(1.0, 5.0), lag=0)
    aims.believe(mount(1.2, 0.5))
    assert aims.next() == aim_at(mount(1.2, 0.5))


def test_a_calibrated_camera_is_looked_through_as_it_was_calibrated() -> None:
    first = aim_at(Tracker(CALIBRATION).believed_mount)
    assert first.pitch_rad == pytest.approx(0.03)
    assert math.degrees(first.tolerance_rad) == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["acf", "net"])
def test_an_aim_beyond_the_picture_leaves_the_detector_as_it_was(name: str) -> None:
    detector = make_detector(name, load_model(name), CALIBRATION)
    assert isinstance(detector, (AcfDetector, NetDetector))
    before = detector.windows_per_frame
    take_aim(detector, Aim(math.radians(-60), math.radians(1)))
    assert detector.windows_per_frame == before
    take_aim(detector, Aim(0.03, math.radians(3)))
    assert detector.windows_per_frame > before


def test_plain_acf_looks_everywhere_and_takes_no_aim() -> None:
    detector = make_detector("acf-full", load_model("acf-full"), CALIBRATION)
    assert not isinstance(detector, AimedDetector)
    take_aim(detector, Aim(0.03, 0.02))


def test_a_tolerance_that_was_set_is_the_least_one() -> None:
    set_by_hand = AcfSettings(pitch_tolerance_rad=math.radians(2))
    model = Model.load(SHIPPED_MODEL_PATH)
    detector = AcfDetector(model, CALIBRATION, set_by_hand)
    before = detector.windows_per_frame
    detector.aim(Aim(CALIBRATION.camera.pitch_rad, math.radians(1)))
    assert detector.windows_per_frame == before
    detector.aim(Aim(CALIBRATION.camera.pitch_rad, math.radians(3)))
    assert detector.windows_per_frame > before
