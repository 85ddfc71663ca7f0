"""A drive in pieces is the drive in one go."""

import dataclasses
import errno
import filecmp
import threading
from concurrent.futures import Executor, Future
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from video_making import write_short_drive

from fcw.bounded.files import MalformedError
from fcw.box import Box
from fcw.detection.detector import Detection
from fcw.errors import UserError
from fcw.frame import Frame
from fcw.job import DriveJob, prepare_drive, run_drive
from fcw.pieces.detections import KnownDetections, PieceDetections, find_in_piece
from fcw.pieces.drive import PIECES_NAME, run_in_pieces
from fcw.pieces.plan import Piece, PieceSource, plan_pieces


class AtOnce(Executor):
    """Runs what it is given there and then."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture(scope="module")
def job(tmp_path_factory) -> DriveJob:
    folder = tmp_path_factory.mktemp("drive")
    source = write_short_drive(folder / "drive.mp4")
    return DriveJob(source, folder / "whole", detector="acf", detection_threads=1)


@pytest.mark.slow
@pytest.mark.parametrize("search_hz", [0.0, 12.0])
def test_the_log_is_that_of_the_whole_drive_in_one_thread_to_the_byte(job, search_hz):
    job = dataclasses.replace(job, search_hz=search_hz)
    whole = run_drive(dataclasses.replace(job, detection_threads=0))
    pieces = dataclasses.replace(job, out=job.out.with_name("pieces"))
    told = run_in_pieces(pieces, 0.4, AtOnce())
    assert filecmp.cmp(job.out / "drive.mcap", pieces.out / "drive.mcap", shallow=False)
    differing = {"frames_per_second"}
    assert {k: v for k, v in told.summary.items() if k not in differing} == {
        k: v for k, v in whole.summary.items() if k not in differing
    }
    assert not (pieces.out / PIECES_NAME).exists()


class TimesOut(AtOnce):
    """Its processes read from a disk that does not answer."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        future.set_exception(TimeoutError(errno.ETIMEDOUT, "Connection timed out"))
        return future


def test_a_search_that_runs_out_of_time_ends_the_run(job, tmp_path):
    stop = threading.Event()
    watchdog = threading.Timer(30.0, stop.set)
    watchdog.start()
    try:
        with pytest.raises(TimeoutError, match="Connection"):
            run_in_pieces(dataclasses.replace(job, out=tmp_path / "out"), 0.4, TimesOut(), stop=stop)
    finally:
        watchdog.cancel()


@pytest.mark.slow
def test_pieces_together_have_every_frame_once(job):
    source = prepare_drive(job).source
    times_ns = [frame.time_ns for frame in source.frames()]
    pieces = plan_pieces(source, 0.3)
    assert len(pieces) == 5
    found = [[frame.time_ns for frame in PieceSource(source, piece).frames()] for piece in pieces]
    assert [time_ns for piece in found for time_ns in piece] == times_ns
    assert all(found)


class Own:
    """A detector of one's own, which finds nothing."""

    name = "own"

    def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
        return ()


@pytest.mark.slow
def test_a_piece_is_searched_as_often_as_the_drive_and_always_by_a_detector_of_ones_own(job, tmp_path):
    job = dataclasses.replace(job, search_hz=12.0)
    times_ns = [frame.time_ns for frame in prepare_drive(job).source.frames()]
    whole = Piece(0, None, None)
    searched = PieceDetections.read(find_in_piece(job, whole, tmp_path / "0.npz")).times_ns
    assert searched.tolist() == times_ns[::2]
    own = dataclasses.replace(job, detector=Own())
    assert PieceDetections.read(find_in_piece(own, whole, tmp_path / "1.npz")).times_ns.tolist() == times_ns


@pytest.mark.slow
def test_what_was_found_is_kept_for_the_next_run_by_its_key(job, tmp_path):
    piece, path = Piece(0, None, 100_000_000), tmp_path / "0.npz"
    find_in_piece(job, piece, path, "a")
    before = path.stat().st_mtime_ns
    find_in_piece(job, piece, path, "a")
    assert path.stat().st_mtime_ns == before
    path.write_bytes(path.read_bytes()[:-50])  # torn
    find_in_piece(job, piece, path, "a")
    assert PieceDetections.read(path).key == "a"
    find_in_piece(job, piece, path, "b")
    assert PieceDetections.read(path).key == "b"


def kept(folder, columns):
    """A file of one frame with a clear box and a faint one."""
    boxes = np.array([[10.0, 20.0, 30.0, 24.0, 5.5, 0.0], [60.0, 22.0, 20.0, 16.0, 2.5, 1.0]])[:, :columns]
    found = PieceDetections("a", np.array([7]), np.array([0]), np.array([2]), boxes)
    found.write(folder / "0.npz")
    return folder / "0.npz"


def test_what_is_faint_is_faint_in_the_process_that_follows(tmp_path):
    (_, found) = PieceDetections.read(kept(tmp_path, 6)).by_time()[7]
    clear = Detection(Box(10.0, 20.0, 30.0, 24.0), 5.5)
    assert found == (clear, Detection(Box(60.0, 22.0, 20.0, 16.0), 2.5, faint=True))


def test_a_file_of_an_earlier_form_is_not_read(tmp_path):
    with pytest.raises(MalformedError, match="boxes of the shape"):
        PieceDetections.read(kept(tmp_path, 5))


@pytest.mark.slow
def test_another_picture_at_that_time_is_looked_at_again(job, tmp_path):
    piece = Piece(0, None, 100_000_000)
    find_in_piece(job, piece, tmp_path / "0.npz")
    frames = list(PieceSource(prepare_drive(job).source, piece).frames())
    known = KnownDetections([piece, Piece(1, 100_000_000, None)], lambda _: tmp_path / "0.npz")
    assert known(frames[0]) is not None
    assert known(dataclasses.replace(frames[1], image=255 - frames[1].image)) is None
    assert known(frames[2]) == prepare_drive(job).detectors[0].detect(frames[2].image)
    assert known(Frame(99, 200_000_000, frames[0].image)) is None


class Empty:
    """A source that has a length and no picture to see."""

    def __init__(self, frames: int, rate_hz: float, first_ns: int) -> None:
        self.frame_count, self.frame_rate_hz, self._first_ns = frames, rate_hz, first_ns
        self.name, self.image_size, self.relays_video, self.notes = "", None, False, ()

    def frames(self, start_ns: int | None = None):
        yield Frame(0, self._first_ns, None)  # pyright: ignore[reportArgumentType]


@given(
    frames=st.integers(1, 500_000),
    rate_hz=st.floats(10, 240),
    piece_s=st.floats(100, 5000),
    first_ns=st.integers(-(10**9), 10**18),
)
def test_pieces_follow_each_other_and_are_of_one_length(frames, rate_hz, piece_s, first_ns):
    source = Empty(frames, rate_hz, first_ns)
    pieces = plan_pieces(source, piece_s)  # pyright: ignore[reportArgumentType]
    assert (pieces[0].begins_ns, pieces[-1].ends_ns) == (None, None)
    assert all(a.ends_ns == b.begins_ns for a, b in pairwise(pieces))
    assert [piece.number for piece in pieces] == list(range(len(pieces)))
    if len(pieces) > 1:
        length_s = frames / rate_hz / len(pieces)
        assert piece_s / 1.5 <= length_s <= piece_s * 1.5
        assert pieces[1].begins_ns == pytest.approx(first_ns + length_s * 1e9, abs=2)


def test_a_piece_of_no_length_is_refused():
    with pytest.raises(UserError, match="expected more than 0 s"):
        plan_pieces(Empty(10, 10, 0), 0)  # pyright: ignore[reportArgumentType]
