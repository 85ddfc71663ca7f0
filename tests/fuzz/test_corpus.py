"""Crafted and damaged inputs of every format, in a process of their own: see `soak.py`."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

SOAK = Path(__file__).with_name("soak.py")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="the watch over time and memory is POSIX's")
def test_a_thousand_bad_inputs_end_with_a_result_or_one_message_soon_and_in_little_memory():
    # `make soak` tries all command lines.
    command = [sys.executable, str(SOAK), "--seconds", "5", "--seed", "1", "--every", "3"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    result = json.loads(ended.stdout)
    assert result["failures"] == []
    assert result["inputs"] >= 1000
    assert result["peak_mb"] < 1000
    assert ended.returncode == 0
