"""The detections of a piece, kept between the process that finds them and the one that follows them."""

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.arrays import npz_arrays
from fcw.bounded.files import MalformedError
from fcw.box import Box
from fcw.detection.asking import vehicles_in
from fcw.detection.detector import Detection
from fcw.detection.schedule import SearchSchedule
from fcw.files import whole_file
from fcw.frame import Frame
from fcw.job import DriveJob, prepare_drive
from fcw.motion.aiming import aim_at, take_aim
from fcw.pieces.plan import Piece, PieceSource
from fcw.threads import one_opencv_thread
from fcw.tracking.tracker import Tracker

SAMPLED_ROWS = 16
"""A picture is told from another by every so many-th of its rows."""
COLUMNS = 6
"""Of a box that is kept."""


@dataclass(frozen=True, slots=True, eq=False)
class PieceDetections:
    """What was found in N frames, those that were searched: M boxes.

    Attributes:
        key: of what was run; see `find_in_piece`.
        times_ns: (N,) of the frames.
        checksums: (N,) of their pictures.
        counts: (N,) boxes of each.
        boxes: (M, 6) x, y, w, h, score and whether it is faint, in the order of the frames, best score first.
    """

    key: str
    times_ns: NDArray[np.int64]
    checksums: NDArray[np.int64]
    counts: NDArray[np.int64]
    boxes: NDArray[np.float64]

    def write(self, path: Path) -> None:
        """Keep it in a file, whole or not at all."""
        key = np.frombuffer(self.key.encode(), np.uint8)
        with whole_file(path) as partial:
            np.savez(
                partial,
                key=key,
                times_ns=self.times_ns,
                checksums=self.checksums,
                counts=self.counts,
                boxes=self.boxes,
            )

    @staticmethod
    def read(path: Path) -> "PieceDetections":
        """What `write` wrote.

        Raises:
            OSError: it cannot be read.
            MalformedError: it is something else, or damaged.
        """
        try:
            arrays = npz_arrays(path)
            key = arrays.pop("key").tobytes().decode()
            found = PieceDetections(key, **arrays)
            if found.boxes.shape[1:] != (COLUMNS,):
                raise MalformedError(f"no detections of a piece (boxes of the shape {found.boxes.shape})")
            return found
        except (KeyError, TypeError, UnicodeDecodeError) as error:
            raise MalformedError(f"no detections of a piece ({error})") from error

    def by_time(self) -> dict[int, tuple[int, tuple[Detection, ...]]]:
        """Checksum and detections of each frame."""
        ends = np.cumsum(self.counts).tolist()
        found = [Detection(Box(*row[:4]), row[4], bool(row[5])) for row in self.boxes.tolist()]
        starts = [0, *ends[:-1]]
        return {
            time_ns: (checksum, tuple(found[start:end]))
            for time_ns, checksum, start, end in zip(
                self.times_ns.tolist(), self.checksums.tolist(), starts, ends, strict=True
            )
        }


def find_in_piece(job: DriveJob, piece: Piece, path: Path, key: str = "") -> Path:
    """Find the vehicles in the frames of a piece that are to be searched.

    Args:
        job: the whole drive's.
        piece: which part of it.
        path: where the detections go.
        key: names source, calibration, options and pieces. A file that has the same one is taken as it is;
            empty looks in any case.

    Returns:
        The path.

    Raises:
        UserError: the source, the calibration or an option is wrong, or the file cannot be written.
    """
    if key and _key_of(path) == key:
        return path
    prepared = prepare_drive(job)
    detector = prepared.detectors[0]
    take_aim(detector, aim_at(Tracker(prepared.header.calibration).believed_mount))
    schedule = SearchSchedule(prepared.source.frame_rate_hz, prepared.job.search_hz)
    times_ns, checksums, counts, rows = [], [], [], []
    with one_opencv_thread():
        for frame in PieceSource(prepared.source, piece).frames():
            if not schedule.searches(frame.time_ns):
                continue
            found = vehicles_in(detector, frame)
            times_ns.append(frame.time_ns)
            checksums.append(_checksum(frame))
            counts.append(len(found))
            rows += [(one.box.x, one.box.y, one.box.w, one.box.h, one.score, one.faint) for one in found]
    path.parent.mkdir(parents=True, exist_ok=True)
    PieceDetections(
        key,
        np.array(times_ns, np.int64),
        np.array(checksums, np.int64),
        np.array(counts, np.int64),
        np.array(rows, np.float64).reshape(-1, COLUMNS),
    ).write(path)
    return path


class KnownDetections:
    """Says what was found in each frame of a drive, as its pieces come in; see `Stages.known`.

    Where a piece has no such frame, or the picture there was another one (a damaged file is decoded otherwise
    from its middle on), it says nothing, and the frame is looked at again.

    Args:
        pieces: in order.
        await_piece: gives the file of a piece, once it is there; None where it will not come.
    """

    def __init__(self, pieces: Sequence[Piece], await_piece: Callable[[Piece], Path | None]) -> None:
        self._left = list(pieces)
        self._await = await_piece
        self._found: dict[int, tuple[int, tuple[Detection, ...]]] = {}
        self._ends_ns: int | None = -(1 << 63)

    def __call__(self, frame: Frame) -> tuple[Detection, ...] | None:
        """What was found in a frame; frames come in the order of their times."""
        while self._ends_ns is not None and frame.time_ns >= self._ends_ns:
            piece = self._left.pop(0)
            self._ends_ns = piece.ends_ns
            path = self._await(piece)
            self._found = {} if path is None else PieceDetections.read(path).by_time()
        checksum, found = self._found.get(frame.time_ns, (None, ()))
        return found if checksum == _checksum(frame) else None


def _checksum(frame: Frame) -> int:
    return zlib.crc32(frame.image[::SAMPLED_ROWS].tobytes())


def _key_of(path: Path) -> str:
    """Of a file that is there; empty where none is that can be read."""
    try:
        return PieceDetections.read(path).key
    except (OSError, MalformedError):
        return ""
