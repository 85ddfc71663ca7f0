"""Thumbnails of a drive's moments, made once by the worker that has just run it."""

from pathlib import Path

from fcw.bounded.files import MalformedError, read_bytes
from fcw.bounded.pictures import picture_size
from fcw.errors import UserError
from fcw.files import make_folder, whole_file
from fcw.logs.events import DriveEvent, find_events
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME
from fcw.logs.pictures import LogPictures
from fcw.logs.thumbnail import THUMBNAIL_PX, thumbnail_jpeg

MOMENTS_NAME = "moments"
WORST_NAME = "worst.jpg"
MOST_THUMBNAIL_BYTES = 1 << 20
MOST_MOMENTS = 20
"""Largest number of events of a drive that get a thumbnail; the most severe ones do."""


def write_moments(folder: Path) -> int:
    """Write `worst.jpg`, the drive's worst moment or its middle, and `<start in ms>.jpg` for each event.

    Args:
        folder: folder of the drive's log. A picture that is missing in it is left out.

    Returns:
        Number of the drive's events, of every kind.

    Raises:
        UserError: the log cannot be read, or a file cannot be written, or one that is no thumbnail has the
            name of one.
    """
    log = DriveLog(folder / MCAP_NAME)
    series = log.series()
    events = sorted(find_events(series), key=lambda event: -event.severity)
    worst = [event for event in events if event.severity > 0][:MOST_MOMENTS]
    moments_s = {moment_name(event): event.peak_s for event in reversed(worst)}
    moments_s[WORST_NAME] = events[0].peak_s if events else series.duration_s / 2
    make_folder(folder / MOMENTS_NAME)
    pictures = LogPictures(log)
    try:
        for name, moment_s in sorted(moments_s.items(), key=lambda item: item[1]):
            row = series.row_at(int(series.time_ns[0]) + round(moment_s * 1e9))
            _check_replaceable(folder / MOMENTS_NAME / name)
            try:
                jpeg = thumbnail_jpeg(pictures.at(int(series.frame_index[row])))
            except UserError:
                continue
            with whole_file(folder / MOMENTS_NAME / name) as partial:
                partial.write_bytes(jpeg)
    finally:
        pictures.close()
    return len(events)


def moment_name(event: DriveEvent) -> str:
    """Name of an event's thumbnail."""
    return f"{round(event.start_s * 1000)}.jpg"


def read_moment(folder: Path, name: str) -> bytes:
    """A thumbnail as JPEG; empty if there is none."""
    try:
        data = read_bytes(folder / MOMENTS_NAME / name, MOST_THUMBNAIL_BYTES)
    except (OSError, MalformedError):
        return b""
    return data if _is_thumbnail(data) else b""


def _check_replaceable(path: Path) -> None:
    try:
        ours = _is_thumbnail(read_bytes(path, MOST_THUMBNAIL_BYTES))
    except FileNotFoundError:
        return
    except (OSError, MalformedError):
        ours = False
    if not ours:
        raise UserError(f"{path}: is there already, and is no thumbnail of a drive; move it away")


def _is_thumbnail(data: bytes) -> bool:
    """Whether it is a JPEG with the height or width of thumbnails."""
    size = picture_size(data) if data.startswith(b"\xff\xd8") else None
    return size is not None and (size[0] == THUMBNAIL_PX[0] or size[1] == THUMBNAIL_PX[1])
