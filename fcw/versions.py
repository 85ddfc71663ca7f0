"""Versions of the program and of the libraries that shape its results, as logs record them."""

import platform
from importlib.metadata import version

from fcw import __version__

_LIBRARIES = ("numpy", "scipy", "opencv-python-headless", "numba", "av", "mcap", "rerun-sdk")


def versions() -> dict[str, str]:
    """Version by name."""
    return {"fcw": __version__, "python": platform.python_version()} | {
        name: version(name) for name in _LIBRARIES
    }
