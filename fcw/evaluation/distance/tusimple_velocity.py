"""Single boxes of the TuSimple velocity challenge against lidar: ranging without any history."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fcw.bounded.files import read_text
from fcw.bounded.formats import MOST_JSON_BYTES, json_value
from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.errors import UserError
from fcw.evaluation.distance.kitti import CONSTANT_WIDTH_M, RangeErrors, distance_by_width_m, range_errors
from fcw.evaluation.distance.kitti_tracking import FARTHEST_M, IN_PATH_M, NEAREST_M
from fcw.frame import ImageSize
from fcw.tracking.range.filter import RangeFilter
from fcw.tracking.range.model import RangeModel
from fcw.tracking.ranging import BoxNoise

IMAGE_SIZE = ImageSize(1280, 720)
FOCAL_PX, PRINCIPAL_ROW_PX, PRINCIPAL_COLUMN_PX = 710.37, 376.26, 675.58
CAMERA_HEIGHT_M = 1.80
"""Published with the challenge."""
HORIZON_ROW_PX = 338.0
"""Fitted on these very labels, as if rears stood on the lower edges: the camera is pitched down by 3 degrees,
which nobody published. With tyres 0.75 m ahead of the rears it is 339."""
DRAWN_EDGE_SIGMA_PX = 2.0
"""People drew these boxes."""


@dataclass(frozen=True, slots=True)
class SingleBoxEvaluation:
    """Relative errors on single boxes in the own path, by method: tracker, row, width."""

    errors: dict[str, RangeErrors]


def evaluate_single_boxes(path: Path, seed: int) -> SingleBoxEvaluation:
    """What the range filter makes of one box, beside its row alone and a constant width.

    Raises:
        UserError: the file is missing or not as expected.
    """
    pitch_rad = math.atan((PRINCIPAL_ROW_PX - HORIZON_ROW_PX) / FOCAL_PX)
    camera = GroundPlaneCamera(pitch_rad, FOCAL_PX, PRINCIPAL_ROW_PX, CAMERA_HEIGHT_M, PRINCIPAL_COLUMN_PX)
    calibration = Calibration.from_camera(camera, IMAGE_SIZE)
    noise = BoxNoise(
        edge_floor_px=DRAWN_EDGE_SIGMA_PX,
        edge_fraction=0.0,
        width_bias_sigma=0.0,
    )
    relative: dict[str, list[float]] = {"tracker": [], "row": [], "width": []}
    for box, distance_m in _vehicles(path):
        range_filter = RangeFilter(calibration, noise, RangeModel())
        if not range_filter.add(box, None):
            continue
        estimates = {
            "tracker": range_filter.state(0).distance_m,
            "row": float(calibration.distance_at(box.bottom)),
            "width": distance_by_width_m(calibration, box, CONSTANT_WIDTH_M),
        }
        for name, estimate_m in estimates.items():
            relative[name].append(abs(estimate_m / distance_m - 1))
    # Each box is of another clip: its own track.
    errors = {
        name: range_errors(np.array(values), np.arange(len(values)), seed)
        for name, values in relative.items()
    }
    return SingleBoxEvaluation(errors)


def _vehicles(path: Path) -> list[tuple[Box, float]]:
    """Boxes in the own path with their lidar range."""
    try:
        clips = json_value(read_text(path, MOST_JSON_BYTES))
        found = []
        for clip in clips:
            for vehicle in clip:
                edges, (forward_m, right_m) = vehicle["bbox"], vehicle["position"]
                if abs(right_m) > IN_PATH_M or not NEAREST_M <= forward_m <= FARTHEST_M:
                    continue
                width, height = edges["right"] - edges["left"], edges["bottom"] - edges["top"]
                found.append((Box(edges["left"], edges["top"], width, height), float(forward_m)))
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror}); expected gt.json of TuSimple") from None
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise UserError(
            f"{path}: not as the TuSimple velocity challenge writes gt.json ({error!r}); "
            "expected a list of clips, each a list of vehicles with bbox and position"
        ) from None
    return found
