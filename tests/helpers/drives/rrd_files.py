"""What a rerun recording holds, read back from its file."""

from pathlib import Path

import pyarrow as pa
from rerun.chunk import RrdReader

from fcw_viz.rerun import blueprint as scene


def read_frame_times(path: Path) -> list[tuple[int, int]]:
    """Index and time of every shown frame of a recording, also of one that was cut short.

    Args:
        path: an `.rrd` file of `RerunSink`.

    Returns:
        (index, time_ns) of each row in the file's order, the time on the source's clock.
    """
    times: list[tuple[int, int]] = []
    for chunk in RrdReader(path).stream().filter(content=f"/{scene.FRAMES}"):
        rows = chunk.to_record_batch()
        indexes = rows.column(scene.FRAME_TIMELINE).cast(pa.int64()).to_pylist()
        times_ns = rows.column(scene.TIME_TIMELINE).cast(pa.int64()).to_pylist()
        times += zip(indexes, times_ns, strict=True)
    return times
