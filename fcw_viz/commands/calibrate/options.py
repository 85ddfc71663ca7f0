"""The options of `fcw calibrate`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from fcw.camera.prior_sigmas import TAPE_ERROR


@dataclass(frozen=True, slots=True)
class CalibrateCommand:
    """Calibrate the camera from points on the road at known distances, or from anything else you know.

    With only a source, it opens a page in the browser. The page asks what you have: three points at known
    distances are enough, and so is a recorded clip if you know the height and the kind of the camera.
    Anything else you know makes the result better. One point should be far away: near points alone leave
    far distances uncertain.
    """

    source: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[SOURCE]")] = None
    """Video or MCAP file, picture, or folder of pictures or of the videos of one drive, to click in; the
    calibration is saved beside it."""
    topic: Annotated[str | None, tyro.conf.arg(metavar="TOPIC")] = None
    """Image topic of an MCAP file; needed if the file has more than one."""
    points: Annotated[tuple[str, ...], tyro.conf.arg(metavar="D:V[:U] ...")] = ()
    """Points on the road: distance from the reference in metres, row, and column if known."""
    from_drive: Annotated[Path | None, tyro.conf.arg(metavar="DRIVE")] = None
    """Save as a calibration the camera pose that `fcw run` had estimated by the end of this drive (with
    --save)."""
    from_clip: bool = False
    """Calibrate a recorded clip without any marks, from the vehicles ahead and the motion of the camera. The
    result is rough unless you also give --field-of-view and --height."""
    vehicle_class: Literal["car", "van", "lorry"] = "car"
    """With --from-clip and without --height: the vehicle that carries the camera."""
    speed: Annotated[float | None, tyro.conf.arg(metavar="MPS")] = None
    """With --from-clip: mean speed over the clip, from which the height is computed."""
    image_size: Annotated[str | None, tyro.conf.arg(metavar="WxH")] = None
    """Size of the picture in which the rows were read; not needed with a source."""
    height: Annotated[float | None, tyro.conf.arg(metavar="METRES")] = None
    """Height of the camera above the road in metres; not needed with --rectangle-sides or --plate."""
    reference_offset: Annotated[float, tyro.conf.arg(metavar="METRES")] = 0.0
    """Metres from the camera forward to where the distances start (front bumper); 0 is the camera itself."""
    row_sigma: Annotated[float, tyro.conf.arg(metavar="PX")] = 1.0
    """Standard deviation of a clicked row in pixels."""
    tape_error: Annotated[float, tyro.conf.arg(metavar="PART")] = TAPE_ERROR
    """Relative standard deviation of the tape measure, common to all distances: 0.01 is 1 %."""
    exact: bool = False
    """With --points: the paper's closed-form solution from three points, without any prior."""
    field_of_view: Annotated[str | None, tyro.conf.arg(metavar="DEG[:SIGMA]")] = None
    """Horizontal field of view in degrees, and its standard deviation (3 by default)."""
    principal_row: Annotated[str | None, tyro.conf.arg(metavar="PX[:SIGMA]")] = None
    """Row of the optical axis, and its standard deviation. Default: the middle row, and 3 % of the picture's
    height."""
    horizon_row: Annotated[str | None, tyro.conf.arg(metavar="PX[:SIGMA]")] = None
    """Row of the horizon, where straight lane lines meet, and its standard deviation (default 2)."""
    lens: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Intrinsics and distortion of the lens: a ROS camera_info, a Kalibr camchain or an OpenCV YAML file."""
    chessboard: Annotated[str | None, tyro.conf.arg(metavar="AxB")] = None
    """Compute the lens from SOURCE, a folder of pictures of one chessboard with AxB inner corners, such as
    9x6. Writes a camera_info file for --lens to --save (`<folder>.lens.yaml` beside it by default)."""
    lane_line: Annotated[tuple[str, ...], tyro.conf.arg(metavar="U:V:U:V ...")] = ()
    """Straight lines along the road, each given by columns and rows of two or more points. They give yaw and
    horizon and, together with points on both sides, the roll."""
    lane_width: Annotated[str | None, tyro.conf.arg(metavar="M[:SIGMA]")] = None
    """Distance between the first two lane lines in metres, and its standard deviation (default 3 %)."""
    horizon_line: Annotated[str | None, tyro.conf.arg(metavar="U:V:U:V")] = None
    """Two points on the horizon; they give the roll of the camera."""
    dashes: Annotated[tuple[str, ...], tyro.conf.arg(metavar="V[:U] ...")] = ()
    """Near ends of consecutive dashes, the nearest first: rows, and columns if known. Needs --dash-period and
    --height; the distance of the first dash is not needed."""
    dash_period: Annotated[float | None, tyro.conf.arg(metavar="METRES")] = None
    """Distance from the near end of one dash to that of the next."""
    rectangle: Annotated[tuple[str, ...], tyro.conf.arg(metavar="U:V:U:V:U:V:U:V ...")] = ()
    """Rectangles painted on the road, such as a parking bay, each given by columns and rows of its four
    corners in turn. They give pitch, roll and focal length; with --rectangle-sides also the height."""
    rectangle_sides: Annotated[tuple[str, ...], tyro.conf.arg(metavar="AxB ...")] = ()
    """Sides of each --rectangle in metres: from its first corner to the second, and on to the third. One may
    be left out (2.5x or x5). Each may have its standard deviation (2.5:0.1x5:0.2; 0.02 by default)."""
    rectangle_along: bool = False
    """The sides of each --rectangle lie along and across the direction of travel; they then give the yaw."""
    plate: Annotated[tuple[str, ...], tyro.conf.arg(metavar="U:V:U:V:U:V ...")] = ()
    """Number plates of vehicles ahead, each given by columns and rows of its two ends and of the place where
    a rear tyre of that vehicle meets the road. Two or more, near and far, give height and horizon."""
    plate_width: Annotated[str, tyro.conf.arg(metavar="eu|us|jp|au|M[:SIGMA]")] = "eu"
    """Width of the plates: by country (0.520 m in the EU and Britain, 0.305 in the USA, 0.330 in Japan, 0.372
    in Australia), or in metres with its standard deviation."""
    height_sigma: Annotated[float | None, tyro.conf.arg(metavar="METRES")] = None
    """Standard deviation of --height (default 2 %). Used only without taped points."""
    save: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Calibration file to write. With a source the default is `<name>.calibration.yaml` beside it."""
    export: Annotated[
        tuple[Literal["camera_info", "kalibr"], Path] | None, tyro.conf.arg(metavar="FORMAT FILE")
    ] = None
    """Also write the intrinsics for other tools: `camera_info FILE` (ROS) or `kalibr FILE`."""
    units: Literal["metric", "imperial"] = "metric"
    """Units of the distances shown. Input is always in metres."""
    json: bool = False
    """Print the result as JSON, and nothing else on stdout."""
    port: Annotated[int, tyro.conf.arg(metavar="N")] = 8080
    """Port of the page. If it is taken, the next free one is used."""
    no_open: bool = False
    """Do not open the page in the browser, only print its address."""
    dark: bool = False
    """Start with dark colours."""
