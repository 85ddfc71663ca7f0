"""What `fcw run` is told on the command line."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

if TYPE_CHECKING:
    from fcw.job import DriveJob

RECORDINGS = Path("recordings")


@dataclass(frozen=True, slots=True)
class RunCommand:
    """Find the vehicles ahead, measure their distance, warn, and write drive.mcap and drive.rrd."""

    source: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="SOURCE")]
    """Video or MCAP file, or folder of pictures; with --live also a camera: its number, /dev/video0, or an
    rtsp or http address."""
    calibration: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Calibration file; by default `<name>.calibration.yaml` beside the source, else that in an MCAP file."""
    topic: Annotated[str | None, tyro.conf.arg(metavar="TOPIC")] = None
    """Of an MCAP file: the pictures to run on; needed where it has several topics of pictures."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="FOLDER")] = None
    """Folder for the logs and summary.json; by default recordings/<name>, of a camera with the time. Earlier
    logs there are replaced."""
    detector: Annotated[str, tyro.conf.arg(metavar="net|acf|acf-full|onnx:FILE")] = "net"
    """net: small nets judge what boosted trees propose where the calibration allows a vehicle; acf: the trees
    alone, in a third of the time, find fewer near vehicles; acf-full: the whole picture; onnx: a YOLO net."""
    detector_classes: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME|NUMBER ...")] = ()
    """Which classes of the ONNX model are vehicles; by default its cars, trucks and buses."""
    ego_speed: Annotated[str | None, tyro.conf.arg(metavar="MPS|FILE")] = None
    """Own speed: metres per second, a CSV file with the columns time_s and speed_mps, or a GPX track; by
    default what an MCAP file says of it."""
    warning_policy: Annotated[str, tyro.conf.arg(metavar="NAME")] = "timely-braking"
    """When to warn: timely-braking, ttc, headway, required-deceleration, euro-ncap-driver, rss."""
    no_own_motion: bool = False
    """Leave out own speed, yaw rate, mount and lane lines by the picture."""
    warning_timing: Literal["early", "normal", "late"] = "normal"
    """How early: for a driver who takes half a second more to react, or 0.4 s less."""
    frame_rate: Annotated[float | None, tyro.conf.arg(metavar="HZ")] = None
    """Frames per second of a folder of pictures without time stamps."""
    units: Literal["metric", "imperial"] = "metric"
    """Units of the distances that people are shown."""
    live: bool = False
    """Show the drive in the browser while it runs, at its own rate, with warnings that are heard; then review
    it there. Pictures are left out rather than late."""
    port: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """With --live: port of the page on this computer; by default 8080, or the next free one."""
    no_open: bool = False
    """With --live: do not open a browser; the address is printed."""
    json: bool = False
    """Print the summary as JSON on stdout, alone."""


def job_of(command: RunCommand, source: Path, out: Path | None = None) -> "DriveJob":
    """What the command asks for.

    Args:
        command: as it was typed.
        source: of the drive.
        out: where its logs go; None for what was typed, or the default.
    """
    from fcw.job import DriveJob

    return DriveJob(
        source=source,
        out=out or command.out or RECORDINGS / (source.stem or source.resolve().name),
        calibration=command.calibration,
        topic=command.topic,
        detector=command.detector,
        detector_classes=command.detector_classes,
        ego_speed=command.ego_speed,
        warning_policy=command.warning_policy,
        warning_timing=command.warning_timing,
        imperial=command.units == "imperial",
        frame_rate_hz=command.frame_rate,
        own_motion=not command.no_own_motion,
    )
