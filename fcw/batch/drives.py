"""Finds the drives of a batch, their names and their calibrations."""

import errno
import os
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath

from fcw.batch.remote import Place, RemoteFile, files_below, place_of
from fcw.bounded.files import MalformedError, read_text
from fcw.bounded.formats import csv_rows
from fcw.camera.file import CALIBRATION_SUFFIX, FOLDER_CALIBRATION
from fcw.errors import UserError
from fcw.logs.names import FAILED_MCAP_NAME, MCAP_NAME, TRUTH_LOG_NAME
from fcw.sources import MCAP_SUFFIX
from fcw.sources.folders.listing import VIDEO_SUFFIXES

TRACK_SUFFIXES = ".gpx", ".GPX"
"""Some cameras write names in capitals."""
TABLE_COLUMNS = ("camera", "calibration")
TOPIC_COLUMN = "topic"
"""Optional column of the table, for MCAP files with several cameras."""


@dataclass(frozen=True, slots=True)
class BatchDrive:
    """A drive to run.

    Attributes:
        name: name of its folder in the folder of the batch.
        source: video or MCAP file, or folder of the videos of one drive.
        camera: name of the folder that contains it.
        calibration: its calibration file; None if there is none, except perhaps inside an MCAP file.
        track: the GPX file beside it, which gives the own speed; None if there is none.
        topic: topic of an MCAP file whose pictures are read; None if only one topic has pictures.
        lacking_table: the table of calibrations without a line for its camera; None if there is no such
            table.
    """

    name: str
    source: Place
    camera: str
    calibration: Place | None
    track: Place | None = None
    topic: str | None = None
    lacking_table: Path | None = None

    @property
    def is_calibrated(self) -> bool:
        """Whether it can be run; for an MCAP file, only opening it tells."""
        return self.calibration is not None or _is_mcap(self.source)


@dataclass(frozen=True, slots=True)
class _OfCamera:
    """A line of the table: calibration of a camera, and topic of its MCAP files; empty if not given."""

    calibration: Path
    topic: str


def find_batch_drives(
    paths: Sequence[Path | str],
    calibration: Path | None = None,
    topic: str | None = None,
    join_files: bool = False,
) -> list[BatchDrive]:
    """The drives under some paths, each once, sorted by name.

    Args:
        paths: videos, MCAP files, and folders, which are searched recursively; a text may also be a URL of
            these that fsspec can read.
        calibration: a calibration file for all drives without their own; or a CSV table with the columns
            `camera`, `calibration` and optionally `topic`, in which the name of a drive's folder is looked
            up.
        topic: topic of MCAP files whose pictures are read; a topic in the table takes precedence.
        join_files: whether the videos in one folder are one drive.

    Raises:
        UserError: a path does not exist or contains no drive, the table is not valid, a store cannot be read,
            or files in a store were to be joined.
    """
    sources: list[Place] = []
    listed: set[RemoteFile] = set()
    named: set[RemoteFile] = set()
    for path in paths:
        place = place_of(path)
        if isinstance(place, Path):
            found_here = _sources(place)
            sources += _joined(found_here) if join_files else found_here
        elif join_files:
            raise UserError(f"{place.url}: --join-files takes folders of this computer; leave it out")
        else:
            found, is_file = files_below(place.url)
            if is_file:
                named |= set(found)
            elif not any(_is_drive(file.path) for file in found):
                raise _none_in(place.url)
            listed |= set(found)
            sources += [file for file in found if is_file or _is_drive(file.path)]
    sources = _each_once(sources)
    table = _table(calibration) if calibration is not None else {}
    drives = []
    for name, source in zip(_names(sources), sources, strict=True):
        camera = _pure(source).parent.name
        line = table.get(camera)
        given = calibration if not table else line and line.calibration
        if isinstance(source, Path):
            inside = (f"{{}}/{FOLDER_CALIBRATION}",) if source.is_dir() else ()
            own = _beside_path(source, "{}" + CALIBRATION_SUFFIX, *inside, FOLDER_CALIBRATION)
            track = _beside_path(source, *(f"{{}}{suffix}" for suffix in TRACK_SUFFIXES))
        else:
            stem = source.path.stem
            own = _beside(source, (f"{stem}{CALIBRATION_SUFFIX}", FOLDER_CALIBRATION), listed, named)
            track = _beside(source, [f"{stem}{suffix}" for suffix in TRACK_SUFFIXES], listed, named)
        named_topic = (line and line.topic) or topic
        lacking_table = calibration if table and line is None else None
        drives.append(
            BatchDrive(
                name,
                source,
                camera,
                own or given,
                track,
                named_topic if _is_mcap(source) else None,
                lacking_table,
            )
        )
    return sorted(drives, key=lambda drive: drive.name)


def _pure(place: Place) -> PurePath:
    return place if isinstance(place, Path) else place.path


def _plain_name(place: Place) -> str:
    """The name of a folder, or of a file without its suffix."""
    return place.name if isinstance(place, Path) and place.is_dir() else _pure(place).stem


def _is_mcap(place: Place) -> bool:
    return _pure(place).suffix.lower() == MCAP_SUFFIX


def _is_drive(path: PurePath) -> bool:
    return (
        path.suffix.lower() in VIDEO_SUFFIXES | {MCAP_SUFFIX}
        # What `fcw run` and `fcw simulate` wrote.
        and path.name not in (MCAP_NAME, FAILED_MCAP_NAME, TRUTH_LOG_NAME)
        and not path.name.startswith(".")
    )


def _none_in(folder: object) -> UserError:
    return UserError(
        f"{folder}: no drive in this folder or below it; expected videos "
        f"({', '.join(sorted(VIDEO_SUFFIXES))}) or MCAP files"
    )


def _sources(path: Path) -> list[Path]:
    if not path.exists():
        raise UserError(
            f"{path}: no such file or folder; expected a video, an MCAP file, or a folder of them"
        )
    # The name of a link's folder is the link's; what ".." is of a link, only the system knows.
    path = path.resolve() if ".." in path.parts else path.absolute()
    if path.is_file():
        return [path]
    found = [file for file in _files_below(path) if _is_drive(file) and (file.is_file() or _dangles(file))]
    if not found:
        raise _none_in(path)
    return sorted(found)


def _joined(files: Sequence[Path]) -> list[Path]:
    """The same files, with a folder in place of its videos if it contains several."""
    counts = Counter(file.parent for file in files if not _is_mcap(file))
    places = (file.parent if counts[file.parent] > 1 and not _is_mcap(file) else file for file in files)
    return list(dict.fromkeys(places))


def _files_below(path: Path) -> Iterator[Path]:
    """All files below a folder, also through links; each folder once, by its own path if it has one here."""
    folders, visited = [path], set[tuple[int, int]]()
    while folders:
        for place, names, files in os.walk(folders.pop(0)):
            folder = Path(place)
            state = folder.stat()
            if (state.st_dev, state.st_ino) in visited:
                names.clear()
                continue
            visited.add((state.st_dev, state.st_ino))
            folders += [folder / name for name in sorted(names) if (folder / name).is_symlink()]
            yield from (folder / name for name in files)


def _dangles(path: Path) -> bool:
    """Whether it is a link to nothing."""
    return path.is_symlink() and not path.exists()


def _each_once(sources: Iterable[Place]) -> list[Place]:
    """The sources without duplicates of the same file; a file takes precedence over links to it."""
    found: dict[Place | str, Place] = {}
    for source in sources:
        key = os.path.realpath(source) if isinstance(source, Path) else source
        there = found.setdefault(key, source)
        if isinstance(source, Path) and isinstance(there, Path) and there.is_symlink():
            found[key] = there if source.is_symlink() else source
    return list(found.values())


def _names(sources: Sequence[Place]) -> list[str]:
    """The names of the drives without suffix; equal names get the folders above as a prefix."""
    depth = 1
    plain, paths = [_plain_name(source) for source in sources], [_pure(source) for source in sources]
    names = plain
    while len(set(names)) < len(names) and depth < max(len(path.parts) for path in paths):
        depth += 1
        counts = Counter(names)
        names = [
            "-".join((*path.parts[-depth:-1], end)) if counts[name] > 1 else name
            for name, path, end in zip(names, paths, plain, strict=True)
        ]
    counts = Counter(names)  # a.mp4 beside a.mkv
    return [path.name if counts[name] > 1 else name for name, path in zip(names, paths, strict=True)]


def _beside_path(source: Path, *names: str) -> Path | None:
    """The first of these files beside a drive, or else beside the file that a link leads to.

    The name of the drive replaces `{}`.
    """
    drives = (source, Path(os.path.realpath(source)))
    paths = (drive.parent / name.replace("{}", _plain_name(drive)) for drive in drives for name in names)
    return next((path for path in paths if _is_file(path)), None)


def _is_file(path: Path) -> bool:
    """Whether it is one; beside a drive with a long name there may be none with a longer."""
    try:
        return path.is_file()
    except OSError as error:
        if error.errno != errno.ENAMETOOLONG:
            raise
        return False


def _beside(
    source: RemoteFile,
    names: Sequence[str],
    listed: Collection[RemoteFile],
    named: Collection[RemoteFile],
) -> RemoteFile | None:
    """The first of these files that exists; the store is asked only beside a file that was named itself."""
    for name in names:
        file = source.beside(name)
        if file in listed or (source in named and file.exists()):
            return file
    return None


def _table(path: Path) -> dict[str, _OfCamera]:
    """The lines of the table by camera; empty if the path is a calibration itself."""
    if path.suffix.lower() != ".csv":
        if not path.is_file():
            raise UserError(
                f"--calibration {path}: no such file; expected a calibration or a CSV table of them"
            )
        return {}
    try:
        lines = ((line, [cell.strip() for cell in row]) for line, row in csv_rows(read_text(path)))
        (_, head), *rows = [*lines] or [(0, [])]
        if not set(TABLE_COLUMNS) <= set(head):
            raise UserError(
                f"{path}: columns {', '.join(head or ('none',))}; expected {' and '.join(TABLE_COLUMNS)}"
            )
        columns = [*TABLE_COLUMNS, *({TOPIC_COLUMN} & set(head))]
        at = [head.index(name) for name in columns]
        if short := [line for line, row in rows if len(row) <= max(at)]:
            raise UserError(f"{path}, line {short[0]}: too few columns; expected {', '.join(head)}")
        cells = dict.fromkeys(tuple(row[column] for column in at) for _, row in rows)
        counts = Counter(camera for camera, *_ in cells)
        if unlike := [camera for camera, count in counts.items() if count > 1]:
            raise UserError(f"{path}: camera {unlike[0]} has {counts[unlike[0]]} unlike lines; keep one")
        table = {
            camera: _OfCamera(path.parent / calibration, "".join(topic))
            for camera, calibration, *topic in cells
        }
    except (OSError, MalformedError) as error:
        raise UserError(
            f"{path}: cannot read this table ({error}); expected CSV with a line a camera"
        ) from error
    for camera, line in table.items():
        if not line.calibration.is_file():
            raise UserError(
                f"{path}: {line.calibration} of camera {camera} is not there; expected a calibration file"
            )
    if not table:
        raise UserError(f"{path}: the table names no camera; expected a line for each")
    return table
