"""The options of `fcw calibrate`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from fcw.camera.prior_sigmas import TAPE_ERROR


@dataclass(frozen=True, slots=True)
class CalibrateCommand:
    """Calibrate the camera from points of the road at known distances.

    With a source alone it opens a page in the browser, where the points are clicked. Three points are
    enough; more points, and what else is known of the camera, make it better. One point should be far away:
    three near ones leave the far distances open.
    """

    source: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[SOURCE]")] = None
    """Video or MCAP file, picture, or folder of pictures to click in; the calibration is saved beside it."""
    topic: Annotated[str | None, tyro.conf.arg(metavar="TOPIC")] = None
    """Of an MCAP file: the pictures to click in; needed where it has several topics of pictures."""
    points: Annotated[tuple[str, ...], tyro.conf.arg(metavar="D:V[:U] ...")] = ()
    """Points of the road: distance in metres from the reference, row, and column where known."""
    from_drive: Annotated[Path | None, tyro.conf.arg(metavar="DRIVE")] = None
    """Make what a drive of `fcw run` believed of the mount at its end the calibration, saved to --save."""
    from_clip: bool = False
    """Without any mark: calibrate SOURCE, a recorded clip, by the vehicles ahead and the way that it drives,
    beside whatever else is said. Rough unless the lens's field of view and the height are said too."""
    vehicle_class: Literal["car", "van", "lorry"] = "car"
    """With --from-clip and no --height: what the camera is in."""
    speed: Annotated[float | None, tyro.conf.arg(metavar="MPS")] = None
    """With --from-clip: mean speed over the clip; the height follows from it."""
    image_size: Annotated[str | None, tyro.conf.arg(metavar="WxH")] = None
    """Size of the picture that the points were clicked in; not needed with a source."""
    height: Annotated[float | None, tyro.conf.arg(metavar="METRES")] = None
    """Height of the camera above the road in metres."""
    reference_offset: float = 0.0
    """Metres from the camera forward to where the distances start (front bumper); 0 is the camera itself."""
    row_sigma: float = 1.0
    """Standard deviation of a clicked row in pixels."""
    tape_error: float = TAPE_ERROR
    """Standard deviation of the taped distances, all together, as a part of them."""
    exact: bool = False
    """With --points: the paper's closed solution of three free points and nothing else."""
    field_of_view: Annotated[str | None, tyro.conf.arg(metavar="DEG[:SIGMA]")] = None
    """Horizontal field of view of the whole picture in degrees, known this well (3 degrees unless said)."""
    principal_row: Annotated[str | None, tyro.conf.arg(metavar="PX[:SIGMA]")] = None
    """Row of the lens's axis; unless said the picture's middle, to 3 % of its height."""
    horizon_row: Annotated[str | None, tyro.conf.arg(metavar="PX[:SIGMA]")] = None
    """Row of the horizon, e.g. where straight lane lines meet (known to 2 pixels unless said)."""
    lens: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Intrinsics and distortion of the lens: a camera_info of ROS, a camchain of Kalibr, OpenCV's YAML."""
    lane_line: Annotated[tuple[str, ...], tyro.conf.arg(metavar="U:V:U:V ...")] = ()
    """Straight lines along the road, each by column and row of two or more points: they tell where the camera
    looks (yaw, horizon, and with points or a third line the roll)."""
    lane_width: Annotated[str | None, tyro.conf.arg(metavar="M[:SIGMA]")] = None
    """Between the first two of the lane lines, in metres (known to 3 % unless said)."""
    horizon_line: Annotated[str | None, tyro.conf.arg(metavar="U:V:U:V")] = None
    """Two points of the horizon: they tell the camera's roll."""
    dashes: Annotated[tuple[str, ...], tyro.conf.arg(metavar="V[:U] ...")] = ()
    """Near ends of dashes following each other, the nearest first: rows, and columns where known. The first
    one's distance need not be known, but the period must (--dash-period) and the height."""
    dash_period: Annotated[float | None, tyro.conf.arg(metavar="METRES")] = None
    """From one dash's near end to the next one's."""
    height_sigma: Annotated[float | None, tyro.conf.arg(metavar="METRES")] = None
    """How well --height is known; 2 % unless said. Only ways without taped points need it."""
    save: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Calibration file to write; with a source by default `<name>.calibration.yaml` beside it."""
    export: Annotated[
        tuple[Literal["camera_info", "kalibr"], Path] | None, tyro.conf.arg(metavar="FORMAT FILE")
    ] = None
    """Also write the intrinsics for other tools: `camera_info FILE` (ROS) or `kalibr FILE`."""
    units: Literal["metric", "imperial"] = "metric"
    """Units of the distances shown; input is in metres always."""
    json: bool = False
    """Print the result as JSON on stdout, alone."""
    port: int = 8080
    """Port of the page; the next free one where it is taken."""
    no_open: bool = False
    """Do not open the page in the browser, only print its address."""
    dark: bool = False
    """Begin with the page's dark colours."""
