"""How the detector's kernels are compiled: without the interpreter's lock, kept on disk where possible."""

from collections.abc import Callable
from typing import Any

import numba


def kernel() -> Callable[[Callable[..., Any]], Any]:
    """Decorator: compile a function at its first use, for the types it is then called with.

    nogil lets frames be worked on in several threads; fastmath lets LLVM vectorise. The machine code is
    cached beside the source or in numba's cache folder; where neither can be written to (a read-only install
    without a home folder) numba refuses, and the kernel is compiled anew in each process.
    """

    def compiled(function: Callable[..., Any]) -> Any:  # noqa: ANN401 - numba's own type
        options = {"nogil": True, "fastmath": True, "error_model": "numpy"}
        try:
            return numba.njit(cache=True, **options)(function)
        except RuntimeError:  # "cannot cache function ...: no locator available"
            return numba.njit(**options)(function)

    return compiled
