"""The pictures and videos of a folder."""

import re
from collections.abc import Collection
from pathlib import Path

PICTURE_SUFFIXES = (".jpg", ".jpeg", ".png", ".webp", ".bmp")
_MPEG_SUFFIXES = (".3gp", ".m2ts", ".m4v", ".mov", ".mp4", ".mpeg", ".mpg", ".mts", ".ts")
VIDEO_SUFFIXES = frozenset((*_MPEG_SUFFIXES, ".asf", ".avi", ".flv", ".mkv", ".webm", ".wmv"))
"""By which a folder's videos are found; a video that is named may have any."""


def files_in(folder: Path, suffixes: Collection[str]) -> list[Path]:
    """Files of some kinds in the natural order of their names: `2.png` is before `10.png`.

    Hidden files are left out: macOS puts a `._0.png`, which is no picture, beside `0.png` on cards.
    """
    files = (file for file in folder.iterdir() if file.suffix.lower() in suffixes)
    return sorted((file for file in files if not file.name.startswith(".")), key=_natural_key)


def _natural_key(file: Path) -> list[tuple[int, int, str]]:
    """Sorts runs of digits as numbers and the rest as text."""
    parts = re.split(r"([0-9]+)", file.name)
    return [(0, int(part), "") if index % 2 else (1, 0, part) for index, part in enumerate(parts)]
