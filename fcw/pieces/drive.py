"""A drive whose vehicles are found in pieces at the same time, and followed in one go."""

import shutil
import threading
from collections.abc import Callable
from concurrent.futures import Executor, wait
from dataclasses import replace
from pathlib import Path

from fcw.job import DriveJob, DriveOutcome, PreparedDrive, prepare_drive
from fcw.logs.records import FrameResult
from fcw.pieces.detections import KnownDetections, find_in_piece
from fcw.pieces.plan import Piece, plan_pieces

PIECES_NAME = ".pieces"
"""Folder in the drive's, for the time of the run."""
LOOKS_EVERY_S = 0.5
"""While it waits for a piece, whether it is to stop."""


def run_in_pieces(
    job: DriveJob,
    piece_s: float,
    executor: Executor,
    key: str = "",
    prepared: PreparedDrive | None = None,
    stop: threading.Event | None = None,
    on_result: Callable[[FrameResult], None] = lambda result: None,
) -> DriveOutcome:
    """Run a drive as `fcw.job.run_drive` does, with the work of detection spread.

    Log, summary and events are the same. The caller's process decodes, follows and writes, a fifth of the
    work with the default detector; the pictures are decoded a second time where they are searched.

    Args:
        job: what to run; it goes to other processes, so a detector or a policy of one's own must be one that
            can be pickled. There each piece is searched in one thread.
        piece_s: about so long each piece is.
        executor: of processes that see the same files: a `ProcessPoolExecutor` whose start method is spawn,
            or that of a Dask client.
        key: names what is run. Detections that an earlier run with the same one left in the job's folder are
            taken, and those of a run that breaks off stay there. Empty looks at all anew.
        prepared: the job with everything loaded, where it is.
        stop: once set, the frames under way are finished, and the log is closed.
        on_result: called after each frame was written.

    Raises:
        UserError: as `run_drive`.
    """
    job = replace(job, detection_threads=1)
    # The process that follows decodes beside that, as the last frames wait for nothing else.
    prepared = prepared or prepare_drive(job)
    prepared = replace(prepared, job=replace(prepared.job, detection_threads=1))
    pieces = plan_pieces(prepared.source, piece_s)
    folder = job.out / PIECES_NAME
    paths = {piece: folder / f"{piece.number:04d}.npz" for piece in pieces}
    running = {
        piece: executor.submit(find_in_piece, job, piece, path, key and f"{key} {piece}")
        for piece, path in paths.items()
    }
    stop = stop or threading.Event()

    def await_piece(piece: Piece) -> Path | None:
        while not stop.is_set():
            # What the search itself raises may be a TimeoutError, too, as of a network's disk.
            if wait((running[piece],), LOOKS_EVERY_S).done:
                return running[piece].result()
        return None

    try:
        outcome = prepared.run(stop=stop, on_result=on_result, known=KnownDetections(pieces, await_piece))
    finally:
        for future in running.values():
            future.cancel()
    shutil.rmtree(folder, ignore_errors=True)
    return outcome
