"""A stand-in for viser's panel."""

from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock


class Parts:
    """Keeps the HTML that is put in it; whatever else is put there goes nowhere."""

    def __init__(self) -> None:
        self.added: list[Any] = []

    def add_html(self, content: str, visible: bool = True) -> Any:
        self.added.append(SimpleNamespace(content=content, visible=visible))
        return self.added[-1]

    def __getattr__(self, name: str) -> Any:
        return MagicMock()

    @property
    def html(self) -> str:
        return "".join(part.content for part in self.added)
