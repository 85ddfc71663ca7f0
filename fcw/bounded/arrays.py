"""NumPy archives (`.npz`) of others: their members' headers are read before anything is unpacked."""

import io
import math
import re
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.files import MalformedError, read_bytes

MOST_ARCHIVE_BYTES = 256 << 20
MOST_UNPACKED_BYTES = 256 << 20
"""Of all arrays together; the largest model of ours has 6 MB."""
ORDINARY_HEADER = re.compile(
    rb"\x93NUMPY[\1\2]\0(?s:.{2}|.{4})"
    rb"\{'descr': '[<>|=]?[a-zA-Z]\d+', 'fortran_order': (True|False), 'shape': \([\d, ]*\), \} *\n"
)
"""Of an array of numbers, as NumPy writes it. Nothing in it makes Python warn, so the process's filters of
warnings need not be changed: no two threads can do that at once, and models are read in threads."""


def npz_arrays(source: Path | bytes) -> dict[str, NDArray[Any]]:
    """All arrays of an archive, by their names.

    Raises:
        OSError: the file is not there, or cannot be read.
        MalformedError: it is not an archive of arrays of numbers, damaged, or larger than it may be.
    """
    data = source if isinstance(source, bytes) else read_bytes(source, MOST_ARCHIVE_BYTES)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if sum(member.file_size for member in members) > MOST_UNPACKED_BYTES:
                raise MalformedError(f"unpacks to more than {MOST_UNPACKED_BYTES >> 20} MB")
            return {member.filename.removesuffix(".npy"): _array(archive, member) for member in members}
    except MalformedError:
        raise
    except (
        zipfile.BadZipFile,
        zlib.error,
        tokenize.TokenError,
        ValueError,
        EOFError,
        OSError,
        RuntimeError,
        NotImplementedError,
        KeyError,
        TypeError,
        SyntaxError,
        MemoryError,
        OverflowError,
        UnicodeError,
    ) as error:
        raise MalformedError(f"not an archive of arrays ({error})") from error


def take(arrays: dict[str, NDArray[Any]], names: Iterable[str]) -> None:
    """That an archive has these arrays.

    Raises:
        MalformedError: naming those that are missing.
    """
    if missing := [name for name in names if name not in arrays]:
        raise MalformedError(f"missing: {', '.join(missing)}")


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[Any]:
    with archive.open(member) as file:
        content = file.read(member.file_size)
    stream = io.BytesIO(content)
    version = np.lib.format.read_magic(stream)
    read_header = (
        np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    )
    if ORDINARY_HEADER.match(content):
        shape, by_columns, dtype = read_header(stream)
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of Python, about what a header that is none looks like
            shape, by_columns, dtype = read_header(stream)
    if dtype.hasobject:
        raise MalformedError(f"{member.filename} contains Python objects")
    if math.prod(shape) * dtype.itemsize != len(content) - stream.tell():
        raise MalformedError(f"{member.filename} does not have the length that it states")
    order = "F" if by_columns else "C"
    return np.frombuffer(bytearray(content), dtype, offset=stream.tell()).reshape(shape, order=order)
