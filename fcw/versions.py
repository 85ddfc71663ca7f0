"""What results were made with: versions, as logs record them, and the machine, as benchmarks print it."""

import os
import platform
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

__version__ = "0.1.0"
"""Of this program."""
_LIBRARIES = ("numpy", "scipy", "opencv-python-headless", "numba", "av", "mcap", "rerun-sdk")
_EXTRAS = ("onnxruntime",)


def versions() -> dict[str, str]:
    """Version by name; of extras where they are installed."""
    found = {"fcw": __version__, "python": platform.python_version()}
    found |= {name: version(name) for name in _LIBRARIES}
    for name in _EXTRAS:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def machine() -> str:
    """The processor's name and the number of cores."""
    name = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                name = line.split(":", 1)[1].strip()
                break
    return f"{name}, {os.cpu_count()} cores"
