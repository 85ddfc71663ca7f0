"""What `fcw run` is told on the command line."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from fcw.detection.schedule import DEFAULT_SEARCH_HZ
from fcw.errors import UserError

if TYPE_CHECKING:
    from fcw.job import DriveJob

RECORDINGS = Path("recordings")


@dataclass(frozen=True, slots=True)
class RunCommand:
    """Find the vehicles ahead, measure their distance, warn, and write drive.mcap and drive.rrd."""

    source: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="SOURCE")]
    """Video or MCAP file, or folder of pictures or of the videos of one drive; with --live also a camera: its
    number, /dev/video0, or an rtsp or http address."""
    calibration: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Calibration file. Default: `<name>.calibration.yaml` beside the source, else `calibration.yaml` in its
    folder, else the one in an MCAP file."""
    topic: Annotated[str | None, tyro.conf.arg(metavar="TOPIC")] = None
    """Image topic of an MCAP file; needed if the file has more than one."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="FOLDER")] = None
    """Folder for the logs and summary.json. Default: recordings/<name>, for a camera with the time added to
    the name. Earlier logs in it are replaced."""
    detector: Annotated[str, tyro.conf.arg(metavar="net|acf|acf-full|onnx:FILE")] = "net"
    """net: two small neural nets, the first for a quick search, the second for a closer look. acf: boosted
    trees; a little faster, but they find fewer near vehicles. acf-full: the same trees, on the whole picture.
    onnx: a YOLO net."""
    detector_classes: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME|NUMBER ...")] = ()
    """Classes of the ONNX model that count as vehicles. Default: cars, vans, trucks and buses."""
    model: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Model file written by `fcw train`, for net, acf or acf-full. Default: the shipped one."""
    search_rate: Annotated[float, tyro.conf.arg(metavar="HZ")] = DEFAULT_SEARCH_HZ
    """Search at least this many pictures a second for vehicles: with 12, every second picture of a video with
    30. In the others, vehicles are followed by their appearance. While a vehicle is new or may become
    dangerous, every picture is searched. 0: always search every picture."""
    ego_speed: Annotated[str | None, tyro.conf.arg(metavar="MPS|FILE")] = None
    """Own speed: a number in metres per second, a CSV file with the columns time_s and speed_mps, or a GPX
    track. Default: the speed in an MCAP file, if it has one."""
    warning_policy: Annotated[str, tyro.conf.arg(metavar="NAME")] = "timely-braking"
    """When to warn: timely-braking, ttc, headway, required-deceleration, euro-ncap-driver, rss."""
    no_own_motion: bool = False
    """Do not estimate own speed, yaw rate, camera pose and lane lines from the picture."""
    warning_timing: Literal["early", "normal", "late"] = "normal"
    """early: for drivers who need 0.5 s longer to react; late: for drivers who need 0.4 s less."""
    frame_rate: Annotated[float | None, tyro.conf.arg(metavar="HZ")] = None
    """Frames per second, for a folder of pictures without time stamps."""
    units: Literal["metric", "imperial"] = "metric"
    """Units of the distances shown."""
    no_rerun_log: bool = False
    """Do not write drive.rrd, which holds the pictures a second time; `fcw review --rerun` and `fcw export
    --format rrd` can make it later from drive.mcap."""
    live: bool = False
    """Show the drive in the browser while it runs, in real time and with audible warnings; then review it
    there. Frames are skipped if the computer is too slow, never shown late."""
    port: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """With --live: port of the page on this computer. Default: 8080, or the next free one."""
    no_open: bool = False
    """With --live: do not open a browser, only print the address."""
    json: bool = False
    """Print the summary as JSON, and nothing else on stdout."""


def job_of(command: RunCommand, source: Path, out: Path | None = None) -> "DriveJob":
    """What the command asks for.

    Args:
        command: as it was typed.
        source: of the drive.
        out: where its logs go; None for what was typed, or the default.

    Raises:
        UserError: a value is none of its option's.
    """
    from fcw.job import DriveJob

    if command.search_rate < 0:
        expected = "pictures a second, e.g. 12, or 0 to search every one"
        raise UserError(f"--search-rate {command.search_rate:g}: expected {expected}")
    name = source.stem if source.is_file() else source.resolve().name  # a folder's may be 2026.05.01, or `..`
    return DriveJob(
        source=source,
        out=out or command.out or RECORDINGS / name,
        calibration=command.calibration,
        topic=command.topic,
        detector=command.detector,
        detector_classes=command.detector_classes,
        model=command.model,
        search_hz=command.search_rate,
        ego_speed=command.ego_speed,
        warning_policy=command.warning_policy,
        warning_timing=command.warning_timing,
        imperial=command.units == "imperial",
        frame_rate_hz=command.frame_rate,
        own_motion=not command.no_own_motion,
    )
