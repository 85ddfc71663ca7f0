"""Tidying ends when its page ends."""

import threading

import pytest

from fcw_viz.page import tidying


class _ClearedLate(threading.Event):
    """Its page is stopped at the worst moment: between the end of the pause and `clear`."""

    def __init__(self, stop: threading.Event) -> None:
        super().__init__()
        self._stop = stop

    def clear(self) -> None:
        self._stop.set()
        super().clear()


def test_it_ends_when_its_page_is_stopped_just_as_a_tab_is_tidied_up_after(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(tidying, "PAUSE_S", 0.0)
    tidy = tidying.Tidying()
    tidy._told, waited_for = _ClearedLate(tidy._stop), tidy._told
    waited_for.set()  # the thread goes on to the other one at its next turn
    tidy.tell()
    tidy._thread.join(60)
    assert not tidy._thread.is_alive()
