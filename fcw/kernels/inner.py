"""Kernels that other kernels call, with flags of the compiler that numba has no option for."""

from collections.abc import Callable
from typing import Any

from fcw.kernels.jit import kernel


def inner_kernel(*, no_alias: bool = False, from_python: bool = False) -> Callable[[Callable[..., Any]], Any]:
    """Decorator like `kernel`, for functions that other kernels call.

    The function is always inlined into its callers. Otherwise, a process that compiles the kernels would call
    the function's own code, and one that loads them from the cache the copy in the caller, which was
    optimised twice and rounds differently.

    Args:
        no_alias: whether no two of its arrays overlap, as with C's `restrict`. Without it, compiled loops
            first check whether memory that is written may be read again. Before a loop over 32 elements, that
            takes as long as the loop. numba sets this flag for its own ufuncs.
        from_python: whether Python calls it, too. If not, no wrapper for Python's arguments is compiled,
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
