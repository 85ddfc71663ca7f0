"""The folder of real drives that some benchmarks read."""

import os
import sys
from pathlib import Path


def data_folder() -> Path:
    """The folder that FCW_DATA names; where it names none, that is said and the program ends."""
    named = os.environ.get("FCW_DATA")
    if not named:
        sys.exit("FCW_DATA is not set: set it to the folder of real drives")
    folder = Path(named)
    if not folder.is_dir():
        sys.exit(f"FCW_DATA: {folder}: no such folder; set it to the folder of real drives")
    return folder
