"""Forward collision warning from one dash camera: the science and the pipeline.

The names below are what a program that uses this package needs; each is imported when it is first used.
`examples/` shows them at work. A drive, run and read back:

    import fcw
    from pathlib import Path

    job = fcw.DriveJob(source=Path("drive.mp4"), out=Path("out"))  # drive.calibration.yaml lies beside it
    outcome = fcw.run_drive(job)
    for result in fcw.read_drive("out").results():
        print(result.time_ns, result.lead, result.warning.level)

A detector or a warning policy of your own goes into the job: `DriveJob(..., detector=mine)`.

Conventions, kept everywhere in this package:

- Pixels: u right, v down; the centre of the top-left pixel is (0, 0). Boxes are x, y, w, h; the
  ground contact row of a vehicle is the bottom edge of its box.
- Vehicle axes after ISO 8855: x forward, y left, z up. Metres, seconds, radians.
- Distance is along the ground from the reference of the calibration: the camera, or the front
  bumper where the calibration states a reference offset.
- Time is in nanoseconds from the source's own clock, never a frame count.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fcw.box import Box
    from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
    from fcw.camera.file import read_calibration, write_calibration
    from fcw.camera.solve import calibrate
    from fcw.detection.detector import Detection, Detector
    from fcw.errors import UserError
    from fcw.frame import Frame, ImageSize, Source, VideoPacket
    from fcw.job import DriveJob, DriveOutcome, run_drive
    from fcw.logs.mcap.reader import DriveLog, read_drive
    from fcw.logs.records import DriveHeader, FrameResult, Sink
    from fcw.sources import open_source
    from fcw.threat.threat import Threat
    from fcw.tracking.types import Track
    from fcw.versions import __version__
    from fcw.warning.ego_speed import EgoSpeed
    from fcw.warning.types import WarningLevel, WarningPolicy, WarningState

__all__ = [
    "Box",
    "Calibration",
    "Detection",
    "Detector",
    "DriveHeader",
    "DriveJob",
    "DriveLog",
    "DriveOutcome",
    "EgoSpeed",
    "Frame",
    "FrameResult",
    "Gaussian",
    "GroundPoint",
    "ImageSize",
    "Sink",
    "Source",
    "Threat",
    "Track",
    "UserError",
    "VideoPacket",
    "WarningLevel",
    "WarningPolicy",
    "WarningState",
    "__version__",
    "calibrate",
    "open_source",
    "read_calibration",
    "read_drive",
    "run_drive",
    "write_calibration",
]

_HOMES = {
    "fcw.box": "Box",
    "fcw.camera.calibration": "Calibration Gaussian GroundPoint",
    "fcw.camera.file": "read_calibration write_calibration",
    "fcw.camera.solve": "calibrate",
    "fcw.detection.detector": "Detection Detector",
    "fcw.errors": "UserError",
    "fcw.frame": "Frame ImageSize Source VideoPacket",
    "fcw.job": "DriveJob DriveOutcome run_drive",
    "fcw.logs.mcap.reader": "DriveLog read_drive",
    "fcw.logs.records": "DriveHeader FrameResult Sink",
    "fcw.sources": "open_source",
    "fcw.threat.threat": "Threat",
    "fcw.tracking.types": "Track",
    "fcw.versions": "__version__",
    "fcw.warning.ego_speed": "EgoSpeed",
    "fcw.warning.types": "WarningLevel WarningPolicy WarningState",
}
"""Where the names live: the imports above, for when the program runs."""


def __getattr__(name: str) -> object:
    for module, names in _HOMES.items():
        if name in names.split():
            value = globals()[name] = getattr(import_module(module), name)
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
