"""How the detector's kernels are compiled: without the interpreter's lock, kept on disk where possible."""

from collections.abc import Callable
from typing import Any

import numba


def kernel(*signature: Any) -> Callable[[Callable[..., Any]], Any]:  # noqa: ANN401 - numba's own types
    """Decorator: compile at import for one signature, or at the first use where none is given.

    nogil lets frames be worked on in several threads; fastmath lets LLVM vectorise. The machine code is
    cached beside the source or in numba's cache folder; where neither can be written to (a read-only install
    without a home folder) numba refuses, and the kernel is compiled anew in each process.
    """

    def compile_kernel(function: Callable[..., Any]) -> Any:  # noqa: ANN401
        options = {"nogil": True, "fastmath": True, "error_model": "numpy"}
        try:
            return numba.njit(*signature, cache=True, **options)(function)
        except RuntimeError:  # "cannot cache function ...: no locator available"
            return numba.njit(*signature, **options)(function)

    return compile_kernel
