"""How much hypothesis searches."""

from typing import Any

from hypothesis import settings

USUAL = 100


def examples(count: int, **more: Any) -> settings:
    """So many examples in `make test`; in `make check`, which searches less, so much fewer."""
    return settings(max_examples=max(1, count * settings().max_examples // USUAL), **more)
