"""A recorded clip without a tape measure: what its distances are worth on drives whose truth is known."""

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from fcw.camera.calibration import Gaussian
from fcw.frame import ImageSize
from fcw.sources import open_source
from fcw_viz.calibrate_app.document.document import Belief, Document
from fcw_viz.calibrate_app.document.solution import calibration_of
from fcw_viz.calibrate_app.document.ways.height import MEASURED_SIGMA_M, TYPICAL_HEIGHTS
from fcw_viz.calibrate_app.document.ways.ways import TYPICAL_LENSES, middle_row
from fcw_viz.calibrate_app.proposals.drive_look import look_at
from fcw_viz.page.pictures import Pictures

LOGGER = logging.getLogger(__name__)
"""`pytest --log-cli-level=INFO` tells the numbers."""
AT_M = 30.0


@dataclass(frozen=True, slots=True)
class Drive:
    """A clip and what is known of it; the row of a distance is horizon + focal length * height / distance."""

    path: str
    height_m: float
    view_deg: float
    horizon_px: float
    focal_times_height: float

    @property
    def row_px(self) -> float:
        """Of the road at `AT_M`."""
        return self.horizon_px + self.focal_times_height / AT_M


DRIVES = (
    # calibrations.txt: from lane lines and dashes; the lens from the chessboards, f = 1157 px.
    Drive("clips/udacity_test_video.mp4", 1.2, 57.9, 420.0, 1390.0),
    Drive("clips/udacity_test_small1.mp4", 1.19, 57.9, 419.5, 1385.0),
    Drive("clips/udacity_project_video_cut.mp4", 1.205, 57.9, 423.5, 1395.0),
    # Published: f = 721.5 px, h = 1.65 m.
    Drive("kitti-odometry-03/drive.mp4", 1.65, 81.4, 176.6, 721.5 * 1.65),
)


def say(horizon: Gaussian, size: ImageSize, height: Sequence[float], lens: Sequence[float]) -> Document:
    return Document(
        size,
        height_m=height[0],
        height_sigma_m=height[1],
        field_of_view=Belief(Gaussian(lens[0], lens[1])),
        principal_row=middle_row(size),
        horizon=Belief(horizon),
        way="clip",
    )


@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: Path(drive.path).stem)
def test_a_clip_is_worth_what_its_interval_says(data_dir: Path, drive: Drive):
    pictures = Pictures(open_source(data_dir / drive.path))
    horizon = look_at(pictures).horizon
    assert horizon is not None
    unknown = TYPICAL_LENSES[-1]
    car = TYPICAL_HEIGHTS[0]
    measured = (drive.height_m, MEASURED_SIGMA_M)
    said = {
        "height measured, lens by its data sheet": (
            measured,
            (math.radians(drive.view_deg), math.radians(3)),
        ),
        "height measured, lens unknown": (measured, (unknown.view_rad, unknown.sigma_rad)),
    }
    if abs(drive.height_m - car.height_m) < car.sigma_m:  # KITTI's camera stands on the roof
        said["nothing measured, an ordinary car"] = (
            (car.height_m, car.sigma_m),
            (unknown.view_rad, unknown.sigma_rad),
        )
    for name, (height, lens) in said.items():
        calibration = calibration_of(say(horizon, pictures.image_size, height, lens))
        assert calibration is not None
        seen_m = calibration.distance_at(drive.row_px)
        low_m, high_m = calibration.distance_interval(drive.row_px)
        LOGGER.info("%s: %s: 30 m reads %.1f (%.1f to %.1f)", drive.path, name, seen_m, low_m, high_m)
        half = max(high_m - seen_m, seen_m - low_m)
        assert abs(seen_m - AT_M) < 2 * half, name
        if lens[1] < math.radians(4):
            assert abs(seen_m / AT_M - 1) < 0.1
