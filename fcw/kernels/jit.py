"""How the detector's kernels are compiled: without the interpreter's lock, and kept on disk."""

import contextlib
import functools
import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType
from typing import Any

import numba
import numpy as np
from numba.core import config
from numba.core.codegen import get_host_cpu_features
from numba.core.compiler_lock import global_compiler_lock
from numpy.typing import NDArray

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


def in_whole_registers(features: str) -> str | None:
    """What the compiler is told of a processor with 512 bit registers; None for others, which it knows best.

    For most of them LLVM keeps to half of each register: early ones slowed down by more than was won. The
    detector's kernels win: a picture's proposals took 0.8 of the time on a Cascade Lake, its nets the same.

    Args:
        features: of the processor, as LLVM names them.
    """
    return f"{features},-prefer-256-bit" if "+avx512f" in features.split(",") else None


def _use_whole_registers() -> None:
    """For all that is compiled in this process, unless numba was told of a processor or compiled before."""
    settings: Any = config  # its attributes are made when it is loaded
    if settings.CPU_FEATURES is None and settings.CPU_NAME is None:
        settings.CPU_FEATURES = in_whole_registers(get_host_cpu_features())


_use_whole_registers()


def kernel() -> Callable[[Callable[..., Any]], Any]:
    """Decorator: compile a function at its first use, for the types it is then called with.

    nogil lets frames be worked on in several threads; fastmath lets LLVM vectorise. The machine code is
    kept beside the source, or in the user's cache folder. Where neither can be written to (a read-only
    install without a home folder) numba refuses; then it is kept in the folder for temporary files, and only
    where that is not safe either is the kernel compiled anew in each process.

    What is kept is used as long as no file in the source's room (`fcw/detection` with the rooms in it, say)
    and none here changes: numba itself looks at the one file alone, and would run code with the constants
    and callees that another file had at the time. Processes that want the same kernel at once wait for the
    one that compiles it.
    """

    def compiled(function: FunctionType) -> Any:  # noqa: ANN401 - numba's own type
        options = {"nogil": True, "fastmath": True, "error_model": "numpy"}
        try:
            return _cached(function, options)
        except RuntimeError:  # "cannot cache function ...: no locator available"
            folder = private_temporary_folder()
        if folder is None:
            return numba.njit(**options)(function)
        settings: Any = config  # its attributes are made when it is loaded
        before, settings.CACHE_DIR = settings.CACHE_DIR, str(folder)  # read once, for this function
        try:
            return _cached(function, options)
        except RuntimeError:
            return numba.njit(**options)(function)
        finally:
            settings.CACHE_DIR = before

    return compiled


def _cached(function: FunctionType, options: dict[str, Any]) -> Any:  # noqa: ANN401 - numba's own type
    dispatcher: Any = numba.njit(cache=True, **options)(function)
    source = Path(function.__code__.co_filename)
    dispatcher._cache._cache_file._source_stamp = _digest_of_sources(_room(source.parent))  # no public way
    compile_or_load = dispatcher.compile

    def compile_alone(signature: Any) -> Any:  # noqa: ANN401 - numba's own type
        with _alone_with(source):
            return compile_or_load(signature)

    dispatcher.compile = compile_alone
    return dispatcher


_locked: set[Path] = set()
"""Files that this process holds now, while a thread has numba's own lock."""


@contextlib.contextmanager
def _alone_with(source: Path) -> Iterator[None]:
    """No other process compiles this file's kernels, or keeps them.

    numba does not keep processes apart: they would all compile the same, and may mix up what they keep of
    one kernel for different types. A kernel's compilation compiles those that it calls, within.
    """
    with global_compiler_lock:  # of this process's threads
        if fcntl is None or source in _locked:
            yield
            return
        with contextlib.ExitStack() as stack:
            with contextlib.suppress(OSError):  # a file system without locks, or no file
                file = stack.enter_context(source.open("rb"))
                fcntl.flock(file, fcntl.LOCK_EX)
                stack.callback(fcntl.flock, file, fcntl.LOCK_UN)  # a forked child may hold the file open
            _locked.add(source)
            stack.callback(_locked.remove, source)
            yield


def _room(folder: Path) -> Path:
    """The room of its package that a folder lies in: the one just below the outermost package."""
    while (folder.parent.parent / "__init__.py").is_file():
        folder = folder.parent
    return folder


@functools.cache
def _digest_of_sources(room: Path) -> bytes:
    digest = hashlib.sha256()
    for folder in (room, Path(__file__).parent):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.digest()


def rows_of_bytes(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A (height, width, 3) picture as (height, 3 * width), copied where it is not contiguous.

    Of one type for every caller, and so for one compiled kernel: read-only, and contiguous.
    """
    rows = np.ascontiguousarray(picture).reshape(len(picture), -1)
    rows.flags.writeable = False
    return rows


def private_temporary_folder() -> Path | None:
    """A folder among the temporary files that this user alone can write to; None where there is none.

    What is loaded from it is run: in a folder that all users share, another one may have made it before us.
    """
    user = os.getuid() if hasattr(os, "getuid") else None
    try:
        temporary = Path(tempfile.gettempdir())  # OSError where there is none at all
        folder = temporary / ("fcw-kernels" if user is None else f"fcw-kernels-{user}")
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except OSError:
        return None
    if user is None:  # Windows: temporary files are the user's own
        return folder
    own = status.st_uid == user and not status.st_mode & 0o077 and not folder.is_symlink()
    return folder if own else None
