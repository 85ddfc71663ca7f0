"""Two made drives to export."""

from pathlib import Path
from typing import Any

import pytest
from marked_drives import FRAMES, RATE_HZ, SIZE, marked_picture, result_of

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import Frame
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader
from fcw_viz.rerun.log import RerunSink


@pytest.fixture(scope="session")
def entries() -> list[Any]:
    encoder = VideoEncoder(SIZE, RATE_HZ)
    drive = []
    for index in range(FRAMES):
        result = result_of(index)
        drive.append((result, encoder.encode(Frame(index, result.time_ns, marked_picture(index)))))
    encoder.close()
    return drive


@pytest.fixture(scope="session")
def header() -> DriveHeader:
    camera = GroundPlaneCamera(0.03, 1000.0, 350.0, 1.4, 640.0)
    calibration = Calibration.from_camera(camera, SIZE, reference_offset_m=1.7)
    return DriveHeader("drive.mp4", SIZE, RATE_HZ, calibration, False, "acf", "ab" * 32, {"fcw": "0.1.0"})


@pytest.fixture(scope="module")
def drives(entries, header, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of two drives of `fcw run`: their logs in MCAP and for rerun."""
    folder = tmp_path_factory.mktemp("drives")
    for name in ("monday", "tuesday"):
        (folder / name).mkdir()
        for sink in (McapSink(folder / name / "drive.mcap"), RerunSink(folder / name / "drive.rrd")):
            sink.open(header)
            for result, packets in entries:
                sink.write(result, packets)
            sink.close()
    return folder
