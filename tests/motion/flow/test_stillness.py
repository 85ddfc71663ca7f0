"""Standing is believed of a picture that stays, not of one that a codec repeats for a moment."""

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.motion.estimator import MotionEstimator

SIZE = ImageSize(640, 360)
CALIBRATION = Calibration.from_camera(GroundPlaneCamera(0.03, 500.0, 179.5, 1.3, 319.5), SIZE)


def told(pictures):
    """(N,) speed of each picture, 20 a second; NaN where it is unknown."""
    own, rng = MotionEstimator(CALIBRATION), np.random.default_rng(0)
    speeds = []
    for index, picture in enumerate(pictures):
        noisy = np.clip(picture + rng.normal(0, 1.5, picture.shape), 0, 255).astype(np.uint8)
        speed_mps = own.update(index * 50_000_000, np.repeat(noisy[:, :, None], 3, axis=2)).speed_mps
        speeds.append(np.nan if speed_mps is None else speed_mps)
    return np.array(speeds)


def scene(seed):
    """(height, width) blobs that can be followed anywhere."""
    rng = np.random.default_rng(seed)
    return np.kron(rng.uniform(40, 215, (SIZE.height // 6, SIZE.width // 8 + 1)), np.ones((6, 8)))[:, :640]


def test_a_picture_that_stays_stands():
    speeds = told([scene(1)] * 40)
    assert np.nanmax(speeds) < 0.5
    assert np.isfinite(speeds[20:]).all()


def test_a_picture_of_which_a_codec_repeats_most_for_half_a_second_does_not_stand():
    """A tenth of its blocks is drawn anew at a time, so that none is older than half a second."""
    rng, picture, pictures = np.random.default_rng(2), scene(0), []
    where = rng.integers(0, 10, (SIZE.height // 24, SIZE.width // 32))
    where = np.kron(where, np.ones((24, 32), int))
    for index in range(60):
        picture = np.where(where == index % 10, scene(index), picture)
        pictures.append(picture)
    assert np.isnan(told(pictures)).all()
