"""Both drive logs in the hands of others: rerun's own tools, and boxes that meet what the pictures show."""

import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.ImageAnnotations_pb2 import ImageAnnotations
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_doctor import complaints
from rerun.chunk import RrdReader

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import Frame, ImageSize
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult
from fcw.sources import open_source
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.rerun import blueprint as scene
from fcw_viz.rerun.log import RerunSink

SIZE = ImageSize(320, 180)
FRAMES, PERIOD_NS = 150, 40_000_000
DARK, BRIGHT = 30, 255
CAMERA = GroundPlaneCamera(0.03, 400.0, 85.0, 1.3, 160.0)
Edges = tuple[float, float, float, float]
"""Left, top, right and bottom, counted from the corner of the top-left pixel."""


@dataclass(frozen=True)
class Logs:
    """The two logs of one drive, and which pixels were painted: first and last column, first and last row."""

    mcap: Path
    rrd: Path
    painted: list[tuple[int, int, int, int]]


def mark(index: int) -> tuple[int, int, int, int]:
    """Pixels painted in a picture; they move and grow by odd and even steps."""
    left, top = 20 + index, 30 + index // 3
    return left, left + 40 + index // 2, top, top + 30 + index // 4


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Logs:
    folder = tmp_path_factory.mktemp("marks")
    header = DriveHeader(
        source="marks",
        image_size=SIZE,
        frame_rate_hz=25.0,
        calibration=Calibration.from_camera(CAMERA, SIZE, reference_offset_m=1.5),
        relays_video=False,
        detector="acf",
        model_sha256="",
        versions={"fcw": "0"},
    )
    sinks = (McapSink(folder / "drive.mcap"), RerunSink(folder / "drive.rrd"))
    encoder = VideoEncoder(SIZE, 25.0)
    for sink in sinks:
        sink.open(header)
    for index in range(FRAMES):
        first_column, last_column, first_row, last_row = mark(index)
        image = np.full((SIZE.height, SIZE.width, 3), DARK, np.uint8)
        image[first_row : last_row + 1, first_column : last_column + 1] = BRIGHT
        # Our boxes count from the centre of the top-left pixel: a pixel's edges are half a pixel from it.
        width, height = last_column - first_column + 1, last_row - first_row + 1
        box = Box(first_column - 0.5, first_row - 0.5, width, height)
        track = Track(7, box, 9.0, 20.0, 19.0, 21.0, 0.3, 8.0, 0.4, 2.5, 3.0, SeenBy.DETECTOR, True)
        loud = FRAMES // 3 <= index < FRAMES // 2
        warning = (
            WarningState(WarningLevel.CAUTION, 7, "ttc", 2.5) if loud else WarningState(WarningLevel.NONE)
        )
        result = FrameResult(index, index * PERIOD_NS, (Detection(box, 9.0),), (track,), 7, warning, 20.0)
        packets = encoder.encode(Frame(index, index * PERIOD_NS, image))
        for sink in sinks:
            sink.write(result, packets)
    for sink in sinks:
        sink.close()
    encoder.close()
    return Logs(folder / "drive.mcap", folder / "drive.rrd", [mark(index) for index in range(FRAMES)])


def seen_edges(path: Path) -> list[Edges]:
    """Where the mark stands in the pictures that decode from the log's own video."""
    edges = []
    for frame in open_source(path).frames():
        bright = frame.image[..., 1] > (DARK + BRIGHT) / 2
        columns, rows = np.flatnonzero(bright.any(axis=0)), np.flatnonzero(bright.any(axis=1))
        edges.append((columns[0], rows[0], columns[-1] + 1, rows[-1] + 1))
    return edges


def foxglove_edges(path: Path) -> list[Edges]:
    """The annotated boxes; Foxglove counts from the top-left corner of the top-left pixel.

    https://docs.foxglove.dev/docs/visualization/message-schemas/points-annotation
    """
    edges = []
    with path.open("rb") as file:
        for _, _, message in make_reader(file).iter_messages("/camera/annotations"):
            (box,) = (p for p in ImageAnnotations.FromString(message.data).points if p.type == p.LINE_LOOP)
            columns, rows = [point.x for point in box.points], [point.y for point in box.points]
            edges.append((min(columns), min(rows), max(columns), max(rows)))
    return edges


def rerun_edges(path: Path) -> list[Edges]:
    """The boxes over the picture; rerun counts from the same corner (seen in a screenshot, to 0.1 px)."""
    edges = []
    for chunk in RrdReader(path).stream().filter(content=f"/{scene.IMAGE_VEHICLES}"):
        rows = chunk.to_record_batch()
        columns = (rows.column(f"Boxes2D:{name}").to_pylist() for name in ("centers", "half_sizes"))
        for ((x, y),), ((half_width, half_height),) in zip(*columns, strict=True):
            edges.append((x - half_width, y - half_height, x + half_width, y + half_height))
    return edges


def test_boxes_meet_the_marks_in_foxglove_and_in_rerun(logs: Logs) -> None:
    seen = np.array(seen_edges(logs.mcap))
    painted = np.array([(left, top, right + 1, bottom + 1) for left, right, top, bottom in logs.painted])
    assert len(seen) == FRAMES
    assert np.array_equal(seen, painted)  # the video keeps the marks where they were painted
    foxglove, rerun = np.array(foxglove_edges(logs.mcap)), np.array(rerun_edges(logs.rrd))
    assert np.abs(foxglove - seen).max() <= 0.01
    assert np.abs(rerun - seen).max() <= 0.01


def rerun(*arguments: str) -> str:
    """All that rerun's command line says, without colours; run as a module it has no exit code."""
    command = [sys.executable, "-m", "rerun_cli", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr)


def test_rerun_finds_no_fault_in_the_mcap_log(logs: Logs) -> None:
    words = rerun("mcap", "check", str(logs.mcap), "--full")
    states = re.findall(r"^(\w+) +\d+ +\d+ +(/\S+) +(.*)$", words, re.MULTILINE)
    assert {topic for _, topic, _ in states} >= {"/camera/image", "/fcw/frame", "/camera/annotations"}
    assert all((state, issues.strip()) == ("ok", "—") for state, _, issues in states), words


def test_rerun_converts_the_mcap_log_whole(logs: Logs, tmp_path: Path) -> None:
    converted = tmp_path / "converted.rrd"
    words = rerun("mcap", "convert", str(logs.mcap), "-o", str(converted), "--application-id", "marks")
    assert "WARN" not in words
    assert "ERROR" not in words
    words = rerun("rrd", "verify", str(converted))
    assert "verified without error" in words
    rows: dict[str, int] = {}
    for chunk in RrdReader(converted).stream():
        entity = str(chunk.entity_path)
        rows[entity] = rows.get(entity, 0) + chunk.num_rows
    for topic in ("/camera/image", "/fcw/frame", "/camera/annotations", "/scene"):
        assert rows[topic] >= FRAMES


def test_rerun_verifies_its_own_recording(logs: Logs) -> None:
    words = rerun("rrd", "verify", str(logs.rrd))
    assert "1 file verified without error" in words


def test_the_statistics_of_the_mcap_log_are_true(logs: Logs) -> None:
    assert complaints(logs.mcap) == []


def test_the_checks_of_the_file_find_faults(tmp_path: Path, logs: Logs) -> None:
    """A file of others with times that step back, and ours with a wrong count and another summary."""
    path = tmp_path / "back.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        topic = writer.register_channel("/a", "json", writer.register_schema("a", "jsonschema", b"{}"))
        for time_ns in (5, 3):
            writer.add_message(topic, time_ns, b"{}", time_ns)
        writer.finish()
    assert complaints(path) == ["times step back in a channel"]
    data = bytearray(logs.mcap.read_bytes())
    count = FRAMES.to_bytes(8, "little")
    data[data.rindex(count)] += 1  # in the statistics, which come last
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(data)
    assert "footer: CRC of the summary" in complaints(broken)
