"""Each way to calibrate a recorded clip, on real drives whose camera is known: what 30 m read, and how sure.

    FCW_DATA=DIR PYTHONPATH=benchmarks python benchmarks/calibration/ways.py [--quick]

The truth of the Udacity pictures is the lens of the chessboards with the dashes (14.63 m, California) and the
lane lines (3.7 m apart), all clicked in the picture; that of the clips is `calibrations.txt`, from many
pictures, and that of KITTI is published. The clicks are those of a person, to about a pixel. `--quick` leaves
out the ways that look through a clip for vehicles.
"""

import argparse
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from real_drives import data_folder

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, Priors
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.lens.model import Lens
from fcw.camera.lens.solve import lens_of_chessboards
from fcw.camera.vanishing import Segment
from fcw.detection.choice import load_model, make_detector
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.self_calibration.clip import VEHICLE_HEIGHTS_M, calibrate_clip, rough_calibration
from fcw.sources import open_source
from fcw_viz.calibrate_app.document.besides.joint_fit import SPEED_SIGMA
from fcw_viz.calibrate_app.document.ways.ways import TYPICAL_LENSES
from fcw_viz.calibrate_app.proposals.drive_look import ENOUGH_S, look_at
from fcw_viz.page.pictures import Pictures

AT_M = 30.0
SIZE = ImageSize(1280, 720)
PERIOD_M, LANE_M = 14.63, Gaussian(3.7, 0.11)
DATA_SHEET = Gaussian(math.radians(58), math.radians(3))
PHONE = Gaussian(TYPICAL_LENSES[0].view_rad, TYPICAL_LENSES[0].sigma_rad)
CAR_M = VEHICLE_HEIGHTS_M["car"]


@dataclass(frozen=True)
class Clicked:
    """What somebody clicked in one picture.

    Attributes:
        name: of the clip, and the picture's number.
        left: the left lane line, near and far.
        right: the right one.
        ends: of dashes following each other, the nearest first; far ends or near ends, all alike.
        height_m: as `calibrations.txt` has it.
        even: whether the dashes keep their period; where not, the truth is of the lens and the lane alone.
    """

    name: str
    left: Segment
    right: Segment
    ends: tuple[tuple[float, float], ...]
    height_m: Gaussian
    even: bool = True


PICTURES = (
    Clicked(
        "udacity_test_video, picture 0",
        ((290.0, 684.0), (630.0, 449.0)),
        ((908.0, 566.5), (729.5, 454.5)),
        ((908.0, 566.5), (762.0, 477.3), (729.5, 454.5), (718.6, 445.7)),
        Gaussian(1.2, 0.03),
    ),
    Clicked(
        "udacity_test_small1, picture 0",
        ((266.0, 684.0), (581.0, 460.0)),
        ((890.0, 570.0), (698.5, 455.5)),
        ((890.0, 570.0), (735.5, 477.0), (698.5, 455.5)),
        Gaussian(1.19, 0.03),
    ),
    # The first dash lies beside a joint of the bridge, where their period is broken: no rule holds there.
    Clicked(
        "udacity_test_small1, picture 70",
        ((266.0, 683.0), (600.0, 444.0)),
        ((995.0, 625.2), (703.0, 458.0)),
        ((995.0, 625.2), (758.0, 490.5), (709.0, 461.6)),
        Gaussian(1.19, 0.03),
        even=False,
    ),
)
CLIPS = {
    # Horizon's row, focal length times height in px m, height: `calibrations.txt`.
    "udacity_test_video": (420.0, 1390.0, 1.2),
    "udacity_test_small1": (419.5, 1385.0, 1.19),
    "udacity_project_video_cut": (423.5, 1395.0, 1.205),
}
KITTI_FOCAL_PX, KITTI_HEIGHT_M, KITTI_HORIZON_PX = 721.538, 1.65, 176.6


HELD: list[bool] = []
"""Of each way reported, whether its interval holds the truth."""


def say(text: str) -> None:
    """A line of the report."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    data = data_folder()
    boards = [cv2.imread(str(path)) for path in sorted((data / "udacity-chessboards").rglob("*.jpg"))]
    lens = lens_of_chessboards([np.asarray(board, np.uint8) for board in boards], (9, 6)).for_image_size(SIZE)
    for picture in PICTURES:
        _ways_of_a_picture(picture, lens)
    for name, (horizon_px, scale, height_m) in CLIPS.items():
        _ways_of_a_clip(data / "clips" / f"{name}.mp4", horizon_px + scale / AT_M, height_m, options.quick)
    _known_speed(data / "kitti-odometry-03")
    say(f"\n{sum(HELD)} of {len(HELD)} inside their interval, which is to hold two of three")


def _ways_of_a_picture(picture: Clicked, lens: Lens) -> None:
    lines = (picture.left, picture.right)
    dashes = tuple(GroundPoint(PERIOD_M * k, row, column) for k, (column, row) in enumerate(picture.ends))
    paced = Evidence(points=dashes, first_unknown=True)
    road = Evidence(lines=lines, lane_width_m=LANE_M)
    both = replace(paced, lines=lines, lane_width_m=LANE_M)
    trusted = both if picture.even else road
    truth = calibrate_jointly(
        Known(
            replace(trusted, lane_width_m=Gaussian(LANE_M.value, 0.03), period_sigma_m=0.05),
            SIZE,
            Gaussian(1.25, 0.3),
            lens=lens,
        )
    )
    place = _place(truth)
    say(f"\n{picture.name}: 30 m at column {place[0]:.0f}, row {place[1]:.1f}; camera {_height(truth)}")
    height = picture.height_m
    known = Priors(DATA_SHEET)
    ways: dict[str, Callable[[], Calibration]] = {
        "dashes by rule, height": lambda: calibrate_jointly(Known(paced, SIZE, height)),
        "dashes measured, height": lambda: calibrate_jointly(
            Known(replace(paced, period_sigma_m=0.15), SIZE, height)
        ),
        "dashes by rule, height, lens by chessboards": lambda: calibrate_jointly(
            Known(paced, SIZE, height, lens=lens)
        ),
        "dashes, lane width, height, field of view": lambda: calibrate_jointly(
            Known(both, SIZE, height, priors=known)
        ),
        "lane width, height, field of view": lambda: calibrate_jointly(
            Known(road, SIZE, height, priors=known)
        ),
        "lane width, height, a phone's lens": lambda: calibrate_jointly(
            Known(road, SIZE, height, priors=Priors(PHONE))
        ),
        "lane width, height, no lens": lambda: calibrate_jointly(Known(road, SIZE, height)),
        "lane width, a car's height, lens by chessboards": lambda: calibrate_jointly(
            Known(road, SIZE, CAR_M, lens=lens)
        ),
    }
    for name, way in ways.items():
        _report(name, way, place)


def _ways_of_a_clip(path: Path, row_px: float, height_m: float, quick: bool) -> None:
    pictures = Pictures(open_source(path))
    horizon = look_at(pictures).horizon
    middle_px = (pictures.image_size.width - 1) / 2
    place = np.array([middle_px, row_px])
    said = f"row {horizon.value:.1f} ± {horizon.sigma:.1f}" if horizon else "not found"
    say(f"\n{path.stem}: 30 m at row {row_px:.1f}; the drive's horizon {said}")
    measured = Gaussian(height_m, 0.03)
    if horizon is not None:
        unknown = TYPICAL_LENSES[-1]
        for name, view, height in (
            ("horizon of the drive, height, field of view", DATA_SHEET, measured),
            ("horizon of the drive, height, a phone's lens", PHONE, measured),
            (
                "horizon of the drive, height, no lens",
                Gaussian(unknown.view_rad, unknown.sigma_rad),
                measured,
            ),
            ("horizon of the drive, a car, no lens", Gaussian(unknown.view_rad, unknown.sigma_rad), CAR_M),
        ):
            priors = Priors(view, None, horizon)
            _report(
                name,
                lambda p=priors, h=height: calibrate_jointly(Known(Evidence(), SIZE, h, priors=p)),
                place,
            )
    if quick:
        return
    for name, priors, height in (
        ("vehicles, height, field of view", Priors(DATA_SHEET), measured),
        ("vehicles, height, no lens", Priors(), measured),
        ("nothing known (a car)", Priors(), CAR_M),
    ):
        _report(name, lambda p=priors, h=height: _by_clip(path, p, h), place)


def _by_clip(path: Path, priors: Priors, height_m: Gaussian) -> Calibration:
    source = open_source(path)
    guess = rough_calibration(source.image_size, height_m.value, priors)
    detector = make_detector("acf-full", load_model("acf-full"), guess)
    known = Known(Evidence(), source.image_size, height_m, priors=priors)
    return calibrate_clip(source, detector, known).calibration


def _known_speed(folder: Path) -> None:
    """KITTI's own speed is known from its poses: with it the road's flow tells lens and height together."""
    positions_m = np.loadtxt(folder / "poses.txt").reshape(-1, 3, 4)[:, :, 3]
    speeds_mps = 10 * np.linalg.norm(np.diff(positions_m, axis=0), axis=1)
    pictures = Pictures(open_source(folder / "drive.mp4"))
    look = look_at(pictures)
    if look.horizon is None or look.scale_per_mps is None:
        say(f"\nkitti-odometry-03: {look.words}")
        return
    # The look ends when it has seen enough of a known speed.
    speed_mps = float(speeds_mps[: round(10 * ENOUGH_S)].mean())
    place = np.array([609.559, KITTI_HORIZON_PX + KITTI_FOCAL_PX * KITTI_HEIGHT_M / AT_M])
    say(f"\nkitti-odometry-03: 30 m at row {place[1]:.1f}; {speed_mps:.1f} m/s on average")
    unknown = TYPICAL_LENSES[-1]
    priors = Priors(Gaussian(unknown.view_rad, unknown.sigma_rad), None, look.horizon)
    scale = look.scale_per_mps * speed_mps
    at_speed = Evidence(scale_px_m=Gaussian(scale, SPEED_SIGMA * scale))
    size, any_height_m = pictures.image_size, Gaussian(1.5, 0.4)
    for name, evidence in (("no speed, no lens, no height", Evidence()), ("a known speed alone", at_speed)):
        _report(
            name, lambda e=evidence: calibrate_jointly(Known(e, size, any_height_m, priors=priors)), place
        )


def _place(truth: Calibration) -> np.ndarray:
    """Column and row in the picture of the road `AT_M` straight ahead."""
    straight = np.array([[truth.column_at(0.0, AT_M), truth.row_at(AT_M)]])
    way = truth.straightening
    return straight[0] if way is None else way.to_picture(straight)[0]


def _height(calibration: Calibration) -> str:
    camera: GroundPlaneCamera = calibration.camera
    return f"{camera.height_m:.2f} m high, horizon at row {camera.horizon_row_px:.1f}"


def _report(name: str, way: Callable[[], Calibration], place: np.ndarray) -> None:
    """One line: what the way reads where the road is `AT_M` away."""
    try:
        calibration = way()
    except UserError as error:
        say(f"  {name:50} {error}")
        return
    straight = calibration.straightening
    row_px = float(place[1] if straight is None else straight.to_straight(place[None])[0, 1])
    seen_m = calibration.distance_at(row_px)
    low_m, high_m = calibration.distance_interval(row_px)
    HELD.append(low_m <= AT_M <= high_m)
    holds = "inside" if HELD[-1] else "OUTSIDE"
    say(f"  {name:50} {seen_m:5.1f} m  {seen_m / AT_M - 1:+6.1%}  {low_m:5.1f} to {high_m:5.1f}  {holds}")


if __name__ == "__main__":
    main()
