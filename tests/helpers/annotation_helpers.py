"""What the tests of annotations share: anything a person can say, and drives to say it of."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from hypothesis import strategies as st

from fcw.annotation.records import (
    REASONS,
    BoxEdit,
    Entry,
    EventReference,
    FrameConfirmed,
    Judgement,
    LabelledBox,
    MissedEvent,
    Note,
    Said,
    TakenBack,
    Verdict,
)
from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import Frame, ImageSize
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState

SIZE = ImageSize(320, 180)
CAMERA = GroundPlaneCamera(0.03, 250.0, 89.5, 1.3, 159.5)
FRAME_NS = 100_000_000

WARNED = EventReference("warning", 7, 1.0, 1.9)

seconds = st.floats(0, 3600)
words = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=8)
spans = st.tuples(seconds, seconds).map(sorted)
references = st.builds(
    lambda kind, track_id, span: EventReference(kind, track_id, span[0], span[1]),
    st.sampled_from(["warning", "caution", "near miss"]),
    st.none() | st.integers(1, 3),
    spans,
)
verdicts = st.sampled_from(Judgement).flatmap(
    lambda judgement: st.builds(
        Verdict,
        st.just(WARNED) | references,
        st.just(judgement),
        st.sampled_from((None, *REASONS[judgement])),
        words,
    )
)
pixels = st.floats(-1e4, 1e4)
sides = st.floats(0.01, 1e4)
labels = st.builds(
    LabelledBox, st.builds(Box, pixels, pixels, sides, sides), st.none() | st.integers(1, 9), st.booleans()
)
frames = st.integers(0, 2)
sayings: st.SearchStrategy[Said] = st.one_of(
    verdicts,
    st.builds(
        lambda span, text, level: MissedEvent(span[0], span[1], text, level),
        spans,
        words,
        st.sampled_from([level for level in WarningLevel if level]),
    ),
    st.builds(Note, seconds, words.filter(str.strip)),
    st.builds(BoxEdit, frames, st.sampled_from(["track 1", "track 2", "new 1"]), st.none() | labels),
    st.builds(FrameConfirmed, frames),
)


@st.composite
def histories(draw: st.DrawFn) -> list[Entry[Said]]:
    """Entries of two people in the order in which they were said; some take back earlier ones."""
    entries: list[Entry[Said]] = []
    for number in range(draw(st.integers(0, 12))):
        said = draw(sayings)
        if entries and draw(st.booleans()):
            said = TakenBack(draw(st.sampled_from(entries)).entry_id)
        person = draw(st.sampled_from(["Ann", "Bo"]))
        entries.append(Entry(f"{number:02}", f"2026-11-20T10:00:{number:02}.000000Z", person, said))
    return entries


def frame_result(index: int, level: WarningLevel = WarningLevel.NONE, *boxes: Box) -> FrameResult:
    """A frame with vehicles 7, 8, ... at boxes; the first of them is the lead."""
    boxes = boxes or (Box(140, 100, 40, 30),)
    tracks = tuple(
        Track(7 + i, box, 9.5, 20.0, 19.0, 21.2, 0.25, 8.0, 0.4, 2.5, 3.0, SeenBy.DETECTOR, i == 0)
        for i, box in enumerate(boxes)
    )
    state = WarningState(level, 7, "ttc", 2.5, 3.2, None) if level else WarningState(level)
    detections = tuple(Detection(box, 9.5) for box in boxes)
    return FrameResult(index, index * FRAME_NS, detections, tracks, 7, state, 22.0)


def write_log(
    path: Path,
    results: Sequence[FrameResult],
    images: Sequence[np.ndarray] | None = None,
    detector: str = "acf",
) -> DriveLog:
    """A drive log of 10 frames a second, of grey pictures where none are given."""
    encoder = VideoEncoder(SIZE, 10.0)
    header = DriveHeader(
        source="drive.mp4",
        image_size=SIZE,
        frame_rate_hz=10.0,
        calibration=Calibration.from_camera(CAMERA, SIZE),
        relays_video=False,
        detector=detector,
        model_sha256="ab" * 32,
        versions={"fcw": "0.1.0"},
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    sink = McapSink(path)
    sink.open(header)
    grey = np.full((SIZE.height, SIZE.width, 3), 128, np.uint8)
    for number, result in enumerate(results):
        image = grey if images is None else images[number]
        sink.write(result, encoder.encode(Frame(result.index, result.time_ns, image, ())))
    sink.close()
    return DriveLog(path)


def warned_drive(path: Path) -> DriveLog:
    """Four seconds; vehicle 7 is warned of from 1.0 to 1.9 s."""
    warned = range(10, 20)
    return write_log(path, [frame_result(i, WarningLevel(3 * (i in warned))) for i in range(40)])
