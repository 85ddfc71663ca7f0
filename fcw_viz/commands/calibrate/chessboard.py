"""`fcw calibrate --chessboard`: the lens from pictures of a chessboard, as a file."""

import math
import re

import yaml

from fcw.bounded.pictures import read_picture
from fcw.camera.lens.model import Lens
from fcw.camera.lens.solve import lens_of_chessboards
from fcw.errors import UserError
from fcw.files import write_whole
from fcw.sources.folders.listing import PICTURE_SUFFIXES
from fcw_viz.commands.calibrate.options import CalibrateCommand
from fcw_viz.console import RESULTS, print_json

MOST_PICTURES = 200


def run_calibrate_chessboard(command: CalibrateCommand, board: str) -> int:
    """Compute and write the lens; returns the exit code.

    Raises:
        UserError: no source, no such board, or too few pictures show the whole of it.
    """
    size = re.fullmatch(r"(\d+)x(\d+)", board)
    if size is None or min(int(part) for part in size.groups()) < 3:
        raise UserError(f"--chessboard {board}: expected its inner corners across and down, such as 9x6")
    if command.source is None:
        raise UserError("--chessboard: name the folder of pictures that show the board")
    if not command.source.is_dir():
        raise UserError(f"{command.source}: not a folder of pictures of the board, which --chessboard takes")
    # Cameras crop such pictures by a pixel now and then, which a drive's may not.
    files = sorted(file for file in command.source.iterdir() if file.suffix.lower() in PICTURE_SUFFIXES)
    read = (read_picture(file) for file in files[:MOST_PICTURES])
    pictures = [picture for picture in read if picture is not None]
    if not pictures:
        raise UserError(
            f"{command.source}: no picture in this folder that can be read; expected pictures "
            f"({', '.join(sorted(PICTURE_SUFFIXES))}) of the board"
        )
    lens = lens_of_chessboards(pictures, (int(size[1]), int(size[2])))
    beside = command.source.parent / f"{command.source.resolve().name}.lens.yaml"  # `.` has no name
    save = command.save or beside
    write_whole(save, _camera_info(lens))
    view_deg = math.degrees(2 * math.atan(lens.image_size.width / 2 / lens.focal_x_px))
    if command.json:
        print_json({"saved": str(save), "field_of_view_deg": view_deg, "coefficients": lens.coefficients})
    else:
        RESULTS.print(
            f"{save}: a lens of {view_deg:.1f} degrees from side to side, k1 {lens.coefficients[0]:.3f}, "
            f"from {len(pictures)} pictures; take it with --lens, or import it in the page",
            soft_wrap=True,
        )
    return 0


def _camera_info(lens: Lens) -> str:
    """The lens as ROS has it (sensor_msgs/CameraInfo, as YAML)."""
    return yaml.safe_dump(
        {
            "image_width": lens.image_size.width,
            "image_height": lens.image_size.height,
            "camera_name": "camera",
            "camera_matrix": {"rows": 3, "cols": 3, "data": lens.matrix.ravel().tolist()},
            "distortion_model": "plumb_bob",
            "distortion_coefficients": {"rows": 1, "cols": 5, "data": list(lens.coefficients)},
        },
        sort_keys=False,
    )
