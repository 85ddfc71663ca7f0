"""No command writes onto what it reads: every output of a command line against every input of it."""

import dataclasses
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from fcw.errors import UserError
from fcw.files import check_replaceable

OUTPUT_FIELDS = frozenset({"out", "save", "export", "detections", "samples", "report"})
"""Options that name what is written; everything else that names a file names an input."""
KEPT_SUFFIXES = frozenset(
    {".jpg", ".jpeg", ".png", ".webp", ".bmp", ".mp4", ".mkv", ".avi", ".mov", ".mcap", ".rrd"}
    | {".json", ".jsonl", ".txt", ".gpx", ".onnx", ".npz"}
)
"""In a folder that is read, a file of such a kind is never replaced."""


def check_outputs(command: object) -> None:
    """See that no output option of a command names one of its inputs, by whatever path or link, or a device.

    Args:
        command: its dataclass, perhaps with others in its fields.

    Raises:
        UserError: one does.
    """
    fields = list(_paths(command))
    inputs = [path for name, path in fields if name not in OUTPUT_FIELDS]
    for name, output in fields:
        if name in OUTPUT_FIELDS and not output.is_dir():
            check_replaceable(output)
        if name not in OUTPUT_FIELDS or not output.is_file():
            continue
        for read in inputs:
            if _is_same(output, read) or (
                output.suffix.lower() in KEPT_SUFFIXES
                and read.is_dir()
                and output.resolve().is_relative_to(read.resolve())
            ):
                what = "the drive itself" if read.suffix == ".mcap" else "what is read, or part of it"
                raise UserError(
                    f"--{name} {output}: this is {what}, and would be overwritten; choose another file"
                )


def _paths(value: object, name: str = "") -> Iterator[tuple[str, Path]]:
    """The paths in a command's fields, each with its field's name."""
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from _paths(getattr(value, field.name), field.name)
    elif isinstance(value, tuple):
        for one in value:
            yield from _paths(one, name)
    elif isinstance(value, Path):
        yield name, value
    elif isinstance(value, str) and value:
        # A detector is `onnx:FILE`; other texts (a source, a speed, a scenario) may be a file's path.
        path = Path(value.removeprefix("onnx:"))
        with suppress(OSError, ValueError):
            if path.exists():
                yield name, path


def _is_same(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:
        return False
