"""The loop keeps the order of the frames, closes every log whatever happens, and leaves no thread behind."""

import math
import os
import random
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Aim, Detection
from fcw.frame import Frame, ImageSize, VideoPacket
from fcw.logs.records import NOTHING_SEEN, DriveHeader, FrameResult
from fcw.motion.state import Mount
from fcw.pipeline import FRAMES_IN_FLIGHT, Stages, run_pipeline
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track
from fcw.warning.policies import make_policy

SIZE = ImageSize(64, 48)
CALIBRATION = Calibration.from_camera(GroundPlaneCamera(0.03, 60.0, 23.5, 1.2, 31.5), SIZE)
FRAME_NS = 40_000_000

overlapped_or_not = pytest.mark.parametrize("one_thread", [False, True], ids=["overlapped", "one thread"])


class CountingSource:
    """Frames whose pixels are their index, or that of the first one of so many alike, each with a packet."""

    name = "counting"
    image_size = SIZE
    frame_rate_hz = 25.0
    notes = ()

    def __init__(
        self, count: int, relays_video: bool = True, fails_at: int | None = None, times: int = 1
    ) -> None:
        self.frame_count, self._times = count, times
        self.relays_video, self._fails_at = relays_video, fails_at

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for index in range(self.frame_count):
            if index == self._fails_at:
                raise OSError("the disk is gone")
            image = np.full((SIZE.height, SIZE.width, 3), index - index % self._times, np.uint8)
            time_ns = index * FRAME_NS
            packet = VideoPacket(b"%d" % index, time_ns, index == 0, shown=True)
            yield Frame(index, time_ns, image, (packet,) if self.relays_video else ())


class UnevenDetector:
    """Says which picture it saw, after a wait that puts the threads out of step."""

    name = "uneven"

    def __init__(self, seed: int, fails_at: int | None = None) -> None:
        self._random = random.Random(seed)
        self._fails_at = fails_at

    def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
        index = int(image[0, 0, 0])
        if index == self._fails_at:
            raise RuntimeError("detector broke")
        time.sleep(self._random.uniform(0, 0.004))
        return (Detection(Box(index, 30, 8, 6), float(index)),)


class MemorySink:
    """Keeps what it is given; can refuse to open, or to write from some frame on."""

    def __init__(self, refuses_open: bool = False, fails_at: int | None = None) -> None:
        self.results: list[FrameResult] = []
        self.packets: list[VideoPacket] = []
        self.opened = 0
        self.closed = 0
        self._refuses_open = refuses_open
        self._fails_at = fails_at

    def open(self, header: DriveHeader) -> None:
        if self._refuses_open:
            raise OSError("read-only")
        self.opened += 1

    def write(self, result: FrameResult, packets: Sequence[VideoPacket]) -> None:
        if result.index == self._fails_at:
            raise OSError("no space left")
        self.results.append(result)
        self.packets.extend(packets)

    def close(self) -> None:
        self.closed += 1


def run(
    source: CountingSource,
    sinks: Sequence[MemorySink],
    detectors: Sequence[UnevenDetector] = (UnevenDetector(1), UnevenDetector(2), UnevenDetector(3)),
    tracker: Tracker | None = None,
    stop: threading.Event | None = None,
    stop_after: int | None = None,
    **options: Any,
) -> None:
    header = DriveHeader(
        source.name, SIZE, source.frame_rate_hz, CALIBRATION, source.relays_video, "uneven", "", {}
    )

    def on_result(result: FrameResult) -> None:
        if stop is not None and result.index == stop_after:
            stop.set()

    threads_before = set(threading.enumerate())
    try:
        tracker = tracker or Tracker(CALIBRATION)
        stages = Stages(detectors, tracker, make_policy(), None, sinks, **options)
        run_pipeline(source, stages, header, stop, on_result)
    finally:
        assert set(threading.enumerate()) <= threads_before


@overlapped_or_not
def test_every_sink_gets_every_frame_in_order_with_its_own_detections_and_packets(one_thread: bool) -> None:
    sinks = [MemorySink(), MemorySink()]
    run(CountingSource(100), sinks, one_thread=one_thread)
    for sink in sinks:
        assert [result.index for result in sink.results] == list(range(100))
        assert [result.time_ns for result in sink.results] == [i * FRAME_NS for i in range(100)]
        assert [result.detections[0].score for result in sink.results] == list(range(100))
        assert [packet.data for packet in sink.packets] == [b"%d" % i for i in range(100)]
        assert sink.closed == 1


@overlapped_or_not
def test_of_a_fast_drive_every_second_picture_is_searched_until_every_one_is_wanted(one_thread: bool) -> None:
    sink, tracker = MemorySink(), WantingTracker(CALIBRATION, from_frame=20)
    run(CountingSource(40), [sink], tracker=tracker, one_thread=one_thread, search_hz=12.0)
    searched = [index for index in range(40) if index % 2 == 0 or index >= 20]
    assert [result.index for result in sink.results if result.searched] == searched
    assert [[found.score for found in result.detections] for result in sink.results] == [
        [index] if index in searched else [] for index in range(40)
    ]
    assert [index for index, found in enumerate(tracker.asked) if found is not None] == searched
    assert [packet.data for packet in sink.packets] == [b"%d" % i for i in range(40)]


class WantingTracker(Tracker):
    """Wants every frame to be searched from one on, and remembers which detections it was given."""

    def __init__(self, calibration: Calibration, from_frame: int) -> None:
        super().__init__(calibration)
        self.asked: list[Sequence[Detection] | None] = []
        self._from = from_frame

    @property
    def wants_search(self) -> bool:
        return len(self.asked) >= self._from

    def update(
        self, time_ns: int, detections: Sequence[Detection] | None, *rest: Any, **named: Any
    ) -> tuple[Track, ...]:
        self.asked.append(detections)
        return super().update(time_ns, detections, *rest, **named)


@overlapped_or_not
def test_a_picture_in_which_nothing_can_be_seen_is_noted_at_its_frame(one_thread: bool) -> None:
    sink = MemorySink()
    run(HalfCovered(20), [sink], one_thread=one_thread)
    assert [NOTHING_SEEN in result.notes for result in sink.results] == [True] * 10 + [False] * 10


@overlapped_or_not
def test_what_is_shown_once_more_is_not_looked_at_and_nothing_moves(one_thread: bool) -> None:
    sink, tracker = MemorySink(), WantingTracker(CALIBRATION, from_frame=0)
    run(CountingSource(40, times=2), [sink], tracker=tracker, one_thread=one_thread)
    again = [index for index, result in enumerate(sink.results) if result.repeated]
    assert again == list(range(9, 40, 2))  # after four new ones
    assert len(tracker.asked) == 40 - len(again)
    for index in again:
        at_it = {"index": index, "time_ns": index * FRAME_NS, "searched": False, "repeated": True}
        assert sink.results[index] == replace(sink.results[index - 1], detections=(), **at_it)
    assert [packet.data for packet in sink.packets] == [b"%d" % i for i in range(40)]


class HalfCovered(CountingSource):
    """Shows something from the tenth picture on."""

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for frame in super().frames(start_ns):
            frame.image[:24, 4:] += 90 * (frame.index >= 10)
            yield frame


class FaintDetector(UnevenDetector):
    """Sees something else that may be a vehicle, beside what the other one sees."""

    def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
        return (*super().detect(image), Detection(Box(40, 30, 8, 6), -1.0, faint=True))


def test_what_is_faint_is_the_trackers_alone() -> None:
    """No page and no export shows for a vehicle what is none."""
    sink, other = MemorySink(), MemorySink()
    run(CountingSource(20), [sink], [FaintDetector(1)])
    run(CountingSource(20), [other])
    assert sink.results == other.results


@overlapped_or_not
def test_video_that_cannot_be_relayed_is_encoded_once_with_a_packet_for_each_frame(one_thread: bool) -> None:
    sinks = [MemorySink(), MemorySink()]
    run(CountingSource(30, relays_video=False), sinks, one_thread=one_thread)
    assert [packet.time_ns for packet in sinks[0].packets] == [i * FRAME_NS for i in range(30)]
    assert all(a is b for a, b in zip(sinks[0].packets, sinks[1].packets, strict=True))


@overlapped_or_not
def test_a_stop_ends_early_with_complete_logs(one_thread: bool) -> None:
    sink, stop = MemorySink(), threading.Event()
    run(CountingSource(10_000), [sink], stop=stop, stop_after=20, one_thread=one_thread)
    assert 21 <= len(sink.results) < 200
    assert [result.index for result in sink.results] == list(range(len(sink.results)))
    assert sink.closed == 1


@overlapped_or_not
def test_a_drive_that_ran_to_its_end_does_not_look_interrupted(one_thread: bool) -> None:
    stop = threading.Event()
    run(CountingSource(10), [MemorySink()], stop=stop, one_thread=one_thread)
    assert not stop.is_set()


@overlapped_or_not
def test_a_drive_without_frames_leaves_closed_logs(one_thread: bool) -> None:
    sink = MemorySink()
    run(CountingSource(0), [sink], one_thread=one_thread)
    assert (sink.opened, sink.closed, sink.results) == (1, 1, [])


@overlapped_or_not
def test_a_failing_detector_is_raised_and_the_logs_hold_what_came_before(one_thread: bool) -> None:
    sink = MemorySink()
    with pytest.raises(RuntimeError, match="detector broke"):
        run(CountingSource(100), [sink], [UnevenDetector(1, fails_at=40)], one_thread=one_thread)
    assert [result.index for result in sink.results] == list(range(40))
    assert sink.closed == 1


class LargePictures(CountingSource):
    """Pictures of a folder or of ROS, which take the encoder longer than this detector takes to look."""

    image_size = ImageSize(640, 360)

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        noise = np.random.default_rng(1).integers(0, 256, (360, 640, 3), np.uint8)
        for frame in super().frames(start_ns):
            image = np.roll(noise, 16 * frame.index, axis=1)
            image[0, 0, 0] = frame.index
            yield replace(frame, image=image)


FAILS_WHILE_ENCODING = """
from test_pipeline import *

for _ in range(3):
    sink = MemorySink()
    with pytest.raises(RuntimeError, match="detector broke"):
        run(LargePictures(40, relays_video=False), [sink], [UnevenDetector(1, fails_at=20)])
    assert [result.index for result in sink.results] == list(range(20)), sink.results
    with pytest.raises(OSError, match="no space left"):
        run(LargePictures(40, relays_video=False), [MemorySink(fails_at=3)])
"""


@pytest.mark.slow
def test_what_fails_while_pictures_are_encoded_is_raised_and_the_process_lives() -> None:
    """In a process of its own: libx264 would take this one with it."""
    ended = subprocess.run(
        [sys.executable, "-c", FAILS_WHILE_ENCODING],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr


@overlapped_or_not
def test_a_failing_source_is_raised_after_the_frames_that_could_be_read_were_written(
    one_thread: bool,
) -> None:
    sink = MemorySink()
    with pytest.raises(OSError, match="disk is gone"):
        run(CountingSource(100, fails_at=50), [sink], one_thread=one_thread)
    assert [result.index for result in sink.results] == list(range(50))
    assert sink.closed == 1


@overlapped_or_not
def test_when_one_log_cannot_be_written_the_other_is_closed_all_the_same(one_thread: bool) -> None:
    good, full = MemorySink(), MemorySink(fails_at=10)
    with pytest.raises(OSError, match="no space"):
        run(CountingSource(10_000), [good, full], one_thread=one_thread)
    assert len(good.results) == 11
    assert (good.closed, full.closed) == (1, 1)


@overlapped_or_not
def test_when_one_log_cannot_be_opened_the_one_already_open_is_closed(one_thread: bool) -> None:
    first, refused = MemorySink(), MemorySink(refuses_open=True)
    with pytest.raises(OSError, match="read-only"):
        run(CountingSource(5), [first, refused], one_thread=one_thread)
    assert (first.closed, refused.closed) == (1, 0)


class AimedUneven(UnevenDetector):
    """Tells how far down it was to look, in the score."""

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._pitch_rad = 0.0

    def aim(self, aim: Aim) -> None:
        self._pitch_rad = aim.pitch_rad

    def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
        (found,) = super().detect(image)
        return (Detection(found.box, round(math.degrees(self._pitch_rad), 3)),)


class TurningTracker(Tracker):
    """Believes from frame 20 on that the camera looks 3 degrees farther up."""

    frames = 0

    def update(self, *arguments: Any, **named: Any) -> tuple[Track, ...]:
        self.frames += 1
        return super().update(*arguments, **named)

    @property
    def believed_mount(self) -> Mount:
        return Mount(pitch_rad=math.radians(1.0 if self.frames <= 20 else -2.0), pitch_sigma_rad=0.005)


@overlapped_or_not
@pytest.mark.parametrize("known", [False, True])
def test_what_is_believed_of_the_camera_counts_from_the_same_frame_in_any_number_of_threads(
    one_thread: bool, known: bool
) -> None:
    """And what was found before, elsewhere in the picture, no longer does."""
    sink, tracker = MemorySink(), TurningTracker(CALIBRATION)
    earlier = (Detection(Box(1, 30, 8, 6), 99.0),) if known else None
    detectors = [AimedUneven(seed) for seed in range(3)]
    run(CountingSource(60), [sink], detectors, tracker, known=lambda _: earlier, one_thread=one_thread)
    turned = 20 + FRAMES_IN_FLIGHT
    first = 99.0 if known else 1.0
    assert [result.detections[0].score for result in sink.results] == [first] * turned + [-2.0] * (
        60 - turned
    )


class WatchedSource(CountingSource):
    """Notes how many of its frames were under way at most."""

    def __init__(self, sink: MemorySink) -> None:
        super().__init__(100)
        self._sink, self.ahead = sink, 0

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for frame in super().frames(start_ns):
            self.ahead = max(self.ahead, frame.index + 1 - len(self._sink.results))
            yield frame


@pytest.mark.parametrize("frames_in_flight", [1, 2, 5])
def test_no_more_frames_are_read_ahead_than_are_wanted_under_way(frames_in_flight: int) -> None:
    sink = MemorySink()
    source = WatchedSource(sink)
    run(source, [sink], frames_in_flight=frames_in_flight)
    assert len(sink.results) == 100
    assert source.ahead == frames_in_flight


@pytest.mark.parametrize("size", [ImageSize(3840, 2160), ImageSize(5312, 2988)], ids=str)
def test_pictures_under_way_hold_no_more_than_100_mb(size: ImageSize) -> None:
    sink = MemorySink()
    source = WatchedSource(sink)
    source.image_size = size
    run(source, [sink])
    assert len(sink.results) == 100
    assert source.ahead * size.width * size.height * 3 <= 100e6
