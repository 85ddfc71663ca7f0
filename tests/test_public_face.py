"""`import fcw` is quick, and has the names that are promised."""

import inspect
import subprocess
import sys
from importlib.metadata import version

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


def test_another_name_is_told_as_of_any_module():
    with pytest.raises(AttributeError, match="module 'fcw' has no attribute 'detect'"):
        _ = fcw.detect  # pyright: ignore[reportAttributeAccessIssue]


def test_importing_loads_nothing_heavy():
    code = (
        "import fcw, sys; print(*(name for name in sys.modules if name.startswith('fcw') or name == 'numpy'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["fcw"]
