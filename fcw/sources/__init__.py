"""Drives to read: `open_source` gives a `Source` for a path."""

from pathlib import Path

from fcw.errors import UserError
from fcw.sources.frame import Frame, ImageSize, Source, VideoPacket
from fcw.sources.images import PICTURE_SUFFIXES, ImageFolderSource
from fcw.sources.video import VideoSource

__all__ = ["Frame", "ImageFolderSource", "ImageSize", "Source", "VideoPacket", "VideoSource", "open_source"]


def open_source(path: Path | str, frame_rate_hz: float | None = None) -> Source:
    """Open a drive, whatever kind it is: a video file, a folder of pictures or a single picture.

    Args:
        path: the file or folder.
        frame_rate_hz: pictures per second of a folder without times; a video states its own.

    Raises:
        UserError: nothing is there, or it is none of these kinds.
    """
    path = Path(path)
    if path.is_dir() or (path.is_file() and path.suffix.lower() in PICTURE_SUFFIXES):
        return ImageFolderSource(path, frame_rate_hz)
    if not path.exists():
        raise UserError(
            f"{path}: no such file or folder; expected a video file or a folder of pictures, or one picture"
        )
    if frame_rate_hz is not None:
        raise UserError(
            f"{path}: a frame rate of {frame_rate_hz:g} was given, but a video has times; leave it out"
        )
    return VideoSource(path)
