"""A field that goes while something is typed in it."""

from collections.abc import Iterator

import pytest
import viser

from fcw_viz.calibrate_app.fields import NumberField
from fcw_viz.calibrate_app.quantities import DISTANCE


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", verbose=False)
    yield server
    server.stop()


def typed(field: NumberField, text: str) -> NumberField:
    field.handle.value = text
    field._keys += 1
    return field


def test_a_field_may_be_removed_by_what_it_commits(server: viser.ViserServer):
    committed: list[float | None] = []

    def commit(value: float | None) -> None:
        committed.append(value)
        field.remove()

    field = NumberField(server.gui, "Distance", DISTANCE, lambda work: work(), commit)
    typed(field, "12.5").flush()
    assert committed == [12.5]


def test_what_is_typed_in_a_field_that_was_removed_is_for_nothing(server: viser.ViserServer):
    committed: list[float | None] = []
    field = NumberField(server.gui, "Distance", DISTANCE, lambda work: work(), committed.append)
    typed(field, "12.5").remove()
    field.flush()
    assert committed == []
