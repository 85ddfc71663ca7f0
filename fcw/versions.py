"""What results were made with: versions, as logs record them, and the machine, as benchmarks print it."""

import os
import platform
from importlib.metadata import version
from pathlib import Path

from fcw import __version__

_LIBRARIES = ("numpy", "scipy", "opencv-python-headless", "numba", "av", "mcap", "rerun-sdk")


def versions() -> dict[str, str]:
    """Version by name."""
    return {"fcw": __version__, "python": platform.python_version()} | {
        name: version(name) for name in _LIBRARIES
    }


def machine() -> str:
    """The processor's name and the number of cores."""
    name = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                name = line.split(":", 1)[1].strip()
                break
    return f"{name}, {os.cpu_count()} cores"
