"""No command writes onto what it reads, onto another of its outputs, or onto a file of another kind."""

import dataclasses
from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import combinations
from pathlib import Path

from fcw.errors import UserError
from fcw.files import CALIBRATION, check_kind, check_replaceable, is_same_file

OUTPUT_FIELDS = frozenset({"out", "save", "export", "detections", "samples", "report"})
"""Options that name what is written; everything else that names a file names an input."""
KEPT_SUFFIXES = frozenset(
    {".jpg", ".jpeg", ".png", ".webp", ".bmp", ".mp4", ".mkv", ".avi", ".mov", ".mcap", ".rrd"}
    | {".json", ".jsonl", ".txt", ".gpx", ".onnx", ".npz"}
)
"""In a folder that is read, a file of such a kind is never replaced."""
LENS = "lens of ROS or Kalibr", (b"camera_matrix", b"intrinsics")
KINDS: Mapping[str, tuple[str, tuple[bytes, ...]]] = {
    "save": CALIBRATION,
    "export": LENS,
    "detections": ("list of COCO results", (b'[{"image_id"', b"[]")),
    "samples": ("table of measured vehicles", (b"sequence,frame,track,",)),
}
"""Of the outputs that replace an earlier file without being told to, what they are; the others see to it
themselves."""


def check_outputs(command: object) -> None:
    """See that no output option of a command names an input, another output, or a file of another kind.

    Args:
        command: its dataclass, perhaps with others in its fields.

    Raises:
        UserError: one does, by whatever path or link, or names a device.
    """
    fields = list(_paths(command))
    inputs = [path for name, path in fields if name not in OUTPUT_FIELDS]
    for name, output in fields:
        if name in OUTPUT_FIELDS and not output.is_dir():
            check_replaceable(output)
        if name not in OUTPUT_FIELDS or not output.is_file():
            continue
        for read in inputs:
            if is_same_file(output, read) or (
                output.suffix.lower() in KEPT_SUFFIXES
                and read.is_dir()
                and output.resolve().is_relative_to(read.resolve())
            ):
                what = "the drive itself" if read.suffix == ".mcap" else "what is read, or part of it"
                raise UserError(
                    f"--{name} {output}: this is {what}, and would be overwritten; choose another file"
                )
    outputs = [(name, path) for name, path in fields if name in OUTPUT_FIELDS]
    check_distinct(*outputs)
    for name, output in outputs:
        kind = LENS if name == "save" and getattr(command, "chessboard", None) else KINDS.get(name)
        if kind is not None:
            check_kind(output, *kind)


def check_distinct(*outputs: tuple[str, Path]) -> None:
    """See that no two of a command's outputs, each with its option, are one file.

    Raises:
        UserError: two are.
    """
    for (name, path), (other, other_path) in combinations(outputs, 2):
        if path.resolve() == other_path.resolve() or is_same_file(path, other_path):
            raise UserError(f"--{name} {path}: --{other} is written there too; choose another file")


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
