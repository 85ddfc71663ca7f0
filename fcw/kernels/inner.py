"""Kernels that other kernels call, with two flags of the compiler that numba has no option for."""

from collections.abc import Callable
from typing import Any

from fcw.kernels.jit import kernel


def inner_kernel(*, no_alias: bool = False, from_python: bool = False) -> Callable[[Callable[..., Any]], Any]:
    """Decorator: as `kernel`, for what other kernels call.

    It is always put into its callers. Otherwise a process that compiles them calls the callee's own code, and
    one that loads them the copy in the caller, which was optimised twice and rounds otherwise.

    Args:
        no_alias: no two arrays given to it overlap, as C's `restrict` says. Otherwise compiled loops ask
            before they start whether what is written may be read again, which before loops over 32 elements
            takes as long as the loop. numba sets this flag for its own ufuncs.
        from_python: Python calls it too. Otherwise nothing is compiled that would take Python's arguments,
            which for kernels with many arrays takes longer than the kernel.
    """

    def compiled(function: Callable[..., Any]) -> Any:  # noqa: ANN401 - numba's own type
        def with_flags(flags: Any) -> Any:  # noqa: ANN401
            flags.noalias, flags.forceinline = no_alias, True
            flags.no_cpython_wrapper = flags.no_cfunc_wrapper = not from_python
            return flags

        dispatcher = kernel()(function)
        if hasattr(dispatcher, "_compiler"):  # not where NUMBA_DISABLE_JIT leaves the function as it is
            dispatcher._compiler._customize_flags = with_flags
        return dispatcher

    return compiled
