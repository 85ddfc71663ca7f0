"""Telling the compiler that the arrays of a kernel do not overlap, which numba has no option for."""

from typing import Any


def no_alias(compiled: Any) -> Any:  # noqa: ANN401 - numba's own type
    """Decorator, above `kernel()`: no two arrays given to the kernel overlap, as C's `restrict` says.

    Without it compiled loops ask before they start whether what is written may be read again. Before loops
    over 32 elements that takes as long as the loop itself. numba sets this for its own ufuncs, by the flag
    set here; a kernel already loaded from the cache is not concerned.
    """

    def with_flag(flags: Any) -> Any:  # noqa: ANN401
        flags.noalias = True
        return flags

    compiled._compiler._customize_flags = with_flag
    return compiled
