"""`import fcw` is quick, and has the names that are promised."""

import inspect
import subprocess
import sys
from importlib.metadata import version
from typing import get_args, get_type_hints

import pytest

import fcw


@pytest.mark.parametrize("name", fcw.__all__)
def test_every_name_is_there_and_documented(name: str):
    thing = getattr(fcw, name)
    if name == "__version__":
        assert thing == version("fcw")
    else:
        assert inspect.getdoc(thing)
        assert thing.__name__ == name
        assert thing is getattr(sys.modules[thing.__module__], name)


def test_all_names_are_listed():
    assert sorted(fcw.__all__) == dir(fcw)
    promised = {name for names in fcw._HOMES.values() for name in names.split()}
    assert promised == set(fcw.__all__)


@pytest.mark.parametrize("seam", [fcw.Source, fcw.Detector, fcw.WarningPolicy, fcw.Sink])
def test_whoever_writes_a_part_of_their_own_finds_all_that_it_takes_and_gives(seam: type):
    hints: list[object] = []
    for member in vars(seam).values():
        function = member.fget if isinstance(member, property) else member
        if inspect.isfunction(function) and function.__module__ == seam.__module__:
            hints += get_type_hints(function).values()
    taken = {kind for hint in hints for kind in (hint, *get_args(hint)) if inspect.isclass(kind)}
    ours = {kind.__name__ for kind in taken if kind.__module__.startswith("fcw")}
    assert ours
    assert ours <= set(fcw.__all__)


def test_another_name_is_told_as_of_any_module():
    with pytest.raises(AttributeError, match="module 'fcw' has no attribute 'detect'"):
        _ = fcw.detect  # pyright: ignore[reportAttributeAccessIssue]


def test_importing_loads_nothing_heavy():
    code = (
        "import fcw, sys; print(*(name for name in sys.modules if name.startswith('fcw') or name == 'numpy'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["fcw"]
