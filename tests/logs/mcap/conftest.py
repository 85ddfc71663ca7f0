"""A whole log to cut, kill and mend."""

from pathlib import Path

import pytest

from fcw.logs.mcap.writer import McapSink


@pytest.fixture
def whole_log(tmp_path, header, short_drive) -> Path:
    path = tmp_path / "drive.mcap"
    sink = McapSink(path)
    sink.open(header)
    for result, packets in short_drive:
        sink.write(result, packets)
    sink.close()
    return path
