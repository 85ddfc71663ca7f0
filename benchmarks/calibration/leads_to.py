"""Where drives lead to, by their pictures alone, against the horizons of `calibrations.txt`.

    FCW_DATA=DIR PYTHONPATH=benchmarks python benchmarks/calibration/leads_to.py [--piece-s 5]

Whole clips, and pieces of them. Nothing is known of the camera, and no vehicle is left out. Errors are in
degrees, with the field of view that is guessed for any camera.
"""

import argparse
import math
import sys
from collections.abc import Iterable, Sequence

import numpy as np
from real_drives import data_folder

from fcw.camera.calibration import Calibration
from fcw.detection.training.own_data import read_calibration_table
from fcw.motion.travel.direction import TravelDirection
from fcw.motion.travel.tracks import FollowedPoints, PointTracks
from fcw.self_calibration.clip import rough_calibration
from fcw.sources import open_source


def main() -> None:
    """Print errors, of whole clips and of pieces."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--piece-s", type=float, default=5.0, help="length of the pieces")
    piece_s = parser.parse_args().piece_s
    data = data_folder()
    table = read_calibration_table(data / "calibrations.txt")
    of_pieces: list[tuple[float, float]] = []
    pieces = 0
    sys.stdout.write("clip: row of the horizon, as found, error and sigma in degrees\n")
    for path in sorted((data / "clips").glob("*.mp4")):
        truth = table[path.stem]
        source = open_source(path)
        tracks = PointTracks(source.image_size.width)
        for frame in source.frames():
            tracks.update(frame.time_ns / 1e9, frame.image)
        found = error_of(tracks.pictures, tracks.factor, truth)
        words = "not told" if found is None else f"{found[0]:+.2f} ± {found[1]:.2f}"
        sys.stdout.write(f"{path.stem}: {truth.horizon_row_px:.1f}, {words}\n")
        for piece in pieces_of(tracks.pictures, piece_s):
            pieces += 1
            of_piece = error_of(piece, tracks.factor, truth)
            if of_piece is not None:
                of_pieces.append(of_piece)
    errors, sigmas = np.array(of_pieces).T
    sys.stdout.write(
        f"pieces of {piece_s:g} s: {len(errors)} of {pieces} tell it; error "
        f"{np.median(np.abs(errors)):.2f} in the median, {np.quantile(np.abs(errors), 0.9):.2f} in 9 of 10; "
        f"inside 1 sigma {100 * np.mean(np.abs(errors) < sigmas):.0f} %, 2 sigmas "
        f"{100 * np.mean(np.abs(errors) < 2 * sigmas):.0f} %\n"
    )


def pieces_of(pictures: Sequence[FollowedPoints], piece_s: float) -> Iterable[Sequence[FollowedPoints]]:
    """Whole pieces, one after the other."""
    times_s = np.array([picture.time_s for picture in pictures])
    for begin_s in np.arange(times_s[0], times_s[-1] - piece_s, piece_s).tolist():
        inside = np.flatnonzero((times_s >= begin_s) & (times_s < begin_s + piece_s))
        yield [pictures[index] for index in inside.tolist()]


def error_of(
    pictures: Sequence[FollowedPoints], factor: int, truth: Calibration
) -> tuple[float, float] | None:
    """Error and sigma of the horizon in degrees, positive where it is found too low; None where not told."""
    camera = rough_calibration(truth.image_size, truth.camera.height_m).camera
    travel = TravelDirection(camera, factor)
    for picture in pictures:
        travel.update(picture, ())
    found = travel.told()
    if found is None:
        return None
    row = found[1]
    return (
        math.degrees((row.value - truth.horizon_row_px) / camera.focal_y_px),
        math.degrees(row.sigma / camera.focal_y_px),
    )


if __name__ == "__main__":
    main()
