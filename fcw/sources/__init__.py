"""Reading drives: `open_source` gives the `Source` for a path."""

from pathlib import Path

from fcw.errors import UserError
from fcw.frame import Frame, ImageSize, Source, VideoPacket
from fcw.sources.folders.images import ImageFolderSource
from fcw.sources.folders.joined import JoinedSource
from fcw.sources.folders.listing import PICTURE_SUFFIXES, VIDEO_SUFFIXES, files_in
from fcw.sources.video import VideoSource

__all__ = [
    "Frame",
    "ImageFolderSource",
    "ImageSize",
    "JoinedSource",
    "Source",
    "VideoPacket",
    "VideoSource",
    "is_mcap",
    "open_source",
]


MCAP_SUFFIX = ".mcap"


def check_path(path: Path) -> None:
    """Check that a path can name a file.

    Raises:
        UserError: the name is too long, contains a zero byte or is not text, or access is denied.
    """
    try:
        path.stat()
        str(path).encode()
    except (FileNotFoundError, NotADirectoryError):
        return
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "its name is no UTF-8"
        mend = "make it, and its folders, readable" if isinstance(error, PermissionError) else "rename it"
        raise UserError(f"{str(path)[:200]!a}: cannot be opened ({reason}); {mend}") from None


def is_mcap(path: Path) -> bool:
    """Whether a path is an MCAP file, by its suffix."""
    return path.suffix.lower() == MCAP_SUFFIX and path.is_file()


def open_source(path: Path | str, frame_rate_hz: float | None = None, topic: str | None = None) -> Source:
    """Open a drive: a video or MCAP file, a folder of pictures or videos, or a single picture.

    Args:
        path: the file or folder.
        frame_rate_hz: pictures per second of a folder without times; a video states its own rate.
        topic: the topic of an MCAP file whose pictures are read; needed if several topics have pictures.

    Raises:
        UserError: the path does not exist, is of no known kind, or an argument does not apply to its kind.
    """
    path = Path(path)
    check_path(path)
    if topic is not None and path.exists() and not is_mcap(path):
        raise UserError(f"{path}: --topic {topic} was given, but only MCAP files have topics; leave it out")
    videos = _videos_of(path) if path.is_dir() else []
    is_picture = path.is_file() and path.suffix.lower() in PICTURE_SUFFIXES
    if is_picture or (path.is_dir() and not videos):
        return ImageFolderSource(path, frame_rate_hz)
    if not path.exists():
        raise UserError(
            f"{path}: no such file or folder; expected a video or MCAP file, "
            "a folder of pictures or of the videos of one drive, or one picture"
        )
    if not videos and not path.is_file():
        raise UserError(
            f"{path}: neither a file nor a folder, but a pipe or device; write it to a file first"
        )
    if frame_rate_hz is not None:
        raise UserError(
            f"{path}: a frame rate of {frame_rate_hz:g} was given, but "
            f"{'an MCAP file' if is_mcap(path) else 'a video'} has times; leave it out"
        )
    if is_mcap(path):
        from fcw.sources.mcap.source import open_mcap  # takes a while to load, and few need it

        return open_mcap(path, topic)
    return JoinedSource(path, videos) if videos else VideoSource(path)


def _videos_of(folder: Path) -> list[Path]:
    """The videos in a folder, which a dash camera made of one drive; none if the folder contains pictures.

    Raises:
        UserError: there is only one video: then that file is the drive, and its calibration lies beside it;
            or there are several videos and pictures too.
    """
    pictures, videos = files_in(folder, PICTURE_SUFFIXES), files_in(folder, VIDEO_SUFFIXES)
    if pictures and len(videos) > 1:
        raise UserError(
            f"{folder}: holds videos, such as {videos[0].name}, and pictures, such as {pictures[0].name}; "
            "expected one kind: move the other one into a folder of its own"
        )
    if len(videos) == 1 and not pictures:
        raise UserError(f"{folder}: no pictures in this folder, but a video; name the video: {videos[0]}")
    return [] if pictures else videos
