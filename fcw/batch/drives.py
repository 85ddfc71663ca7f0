"""Which drives a batch has, what they are called, and which calibration each has."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fcw.bounded.files import MalformedError, read_text
from fcw.bounded.formats import csv_rows
from fcw.camera.file import default_path
from fcw.errors import UserError
from fcw.logs.names import MCAP_NAME
from fcw.sources import MCAP_SUFFIX
from fcw.sources.images import VIDEO_SUFFIXES

FOLDER_CALIBRATION = "calibration.yaml"
"""Of all drives of a folder that have none of their own."""
TABLE_COLUMNS = ("camera", "calibration")


@dataclass(frozen=True, slots=True)
class BatchDrive:
    """A drive to run.

    Attributes:
        name: of its folder in the batch's.
        source: video or MCAP file.
        camera: the name of the folder that holds it.
        calibration: its file; None where there is none but, perhaps, in an MCAP file itself.
    """

    name: str
    source: Path
    camera: str
    calibration: Path | None

    @property
    def is_calibrated(self) -> bool:
        """Whether it can be run; of an MCAP file that shows when it is opened."""
        return self.calibration is not None or self.source.suffix.lower() == MCAP_SUFFIX


def find_batch_drives(paths: Sequence[Path], calibration: Path | None = None) -> list[BatchDrive]:
    """The drives that some paths stand for, each once, in the order of their names.

    Args:
        paths: videos, MCAP files, and folders, which are searched with all folders below.
        calibration: a file for all drives that have none; or a CSV table with the columns `camera` and
            `calibration`, of which a drive takes the line with the name of its folder.

    Raises:
        UserError: a path does not exist or holds no drive, or the table is none.
    """
    sources = list(dict.fromkeys(source.resolve() for path in paths for source in _sources(path)))
    table = _table(calibration) if calibration is not None else {}
    names = _names(sources)
    return sorted(
        (
            BatchDrive(name, source, source.parent.name, _calibration(source, calibration, table))
            for name, source in zip(names, sources, strict=True)
        ),
        key=lambda drive: drive.name,
    )


def _sources(path: Path) -> list[Path]:
    if not path.exists():
        raise UserError(
            f"{path}: no such file or folder; expected a video, an MCAP file, or a folder of them"
        )
    if path.is_file():
        return [path]
    found = sorted(
        file
        for file in path.rglob("*")
        if file.suffix.lower() in VIDEO_SUFFIXES | {MCAP_SUFFIX}
        and file.name != MCAP_NAME  # what `fcw run` wrote
        and not file.name.startswith(".")
        and file.is_file()
    )
    if not found:
        raise UserError(
            f"{path}: no drive in this folder or below it; expected videos "
            f"({', '.join(sorted(VIDEO_SUFFIXES))}) or MCAP files"
        )
    return found


def _names(sources: Sequence[Path]) -> list[str]:
    """The files' names without suffix; where two are alike, the folders above go before them."""
    depth = 1
    names = [source.stem for source in sources]
    while len(set(names)) < len(names) and depth < max(len(source.parts) for source in sources):
        depth += 1
        counts = Counter(names)
        names = [
            "-".join((*source.parts[-depth:-1], source.stem)) if counts[name] > 1 else name
            for name, source in zip(names, sources, strict=True)
        ]
    counts = Counter(names)  # a.mp4 beside a.mkv
    return [source.name if counts[name] > 1 else name for name, source in zip(names, sources, strict=True)]


def _calibration(source: Path, given: Path | None, table: dict[str, Path]) -> Path | None:
    of_camera = table.get(source.parent.name)
    for path in (default_path(source), source.parent / FOLDER_CALIBRATION, of_camera):
        if path is not None and path.is_file():
            return path
    return given if not table else None


def _table(path: Path) -> dict[str, Path]:
    """Calibration by camera; empty where the path is a calibration itself."""
    if path.suffix.lower() != ".csv":
        if not path.is_file():
            raise UserError(
                f"--calibration {path}: no such file; expected a calibration or a CSV table of them"
            )
        return {}
    try:
        (_, head), *rows = [*csv_rows(read_text(path))] or [(0, [])]
        if not set(TABLE_COLUMNS) <= set(head):
            raise UserError(
                f"{path}: columns {', '.join(head or ('none',))}; expected {' and '.join(TABLE_COLUMNS)}"
            )
        at = [head.index(name) for name in TABLE_COLUMNS]
        if short := [line for line, row in rows if len(row) <= max(at)]:
            raise UserError(f"{path}, line {short[0]}: too few columns; expected {', '.join(head)}")
        table = {row[at[0]]: path.parent / row[at[1]] for _, row in rows}
    except (OSError, MalformedError) as error:
        raise UserError(
            f"{path}: cannot read this table ({error}); expected CSV with a line a camera"
        ) from error
    for camera, calibration in table.items():
        if not calibration.is_file():
            raise UserError(
                f"{path}: {calibration} of camera {camera} is not there; expected a calibration file"
            )
    if not table:
        raise UserError(f"{path}: the table names no camera; expected a line for each")
    return table
