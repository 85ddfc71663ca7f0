"""Writes a drive, or a range of it, as a separate log, in MCAP or the format of any other `Sink`."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fcw.logs.export.clip import DriveClip
from fcw.logs.records import Sink
from fcw.units import NS_PER_S


def with_its_keyframe(clip: DriveClip) -> tuple[DriveClip, float]:
    """The clip from the keyframe at or before its start, because its pictures decode only from there.

    Returns:
        The clip, and how many seconds earlier it starts.
    """
    series, start_ns = clip.log.series(), int(clip.times_ns[0])
    keyframe_ns = series.keyframe_before(start_ns)
    if keyframe_ns is None:  # a log without pictures
        return clip, 0.0
    all_ns = series.time_ns
    times_ns = all_ns[(all_ns >= keyframe_ns) & (all_ns <= clip.times_ns[-1])]
    longer = DriveClip(clip.name, clip.log, clip.first_ns, np.asarray(times_ns, np.int64))
    return longer, (start_ns - int(times_ns[0])) / NS_PER_S


def replay(clip: DriveClip, sink: Sink, on_frame: Callable[[], None]) -> int:
    """Write the header, results and video packets of a clip to a sink, and close it.

    Results keep their numbers and times. Packets before the keyframe of the first frame are left out.

    Args:
        clip: the clip; see `with_its_keyframe`.
        sink: the sink.
        on_frame: called after each frame.

    Returns:
        The number of frames.

    Raises:
        UserError: the log is damaged, or the sink cannot be written.
    """
    frames, header = 0, clip.log.header
    if header.gpx and header.gpx_begins_ns is None and clip.times_ns[0] > clip.first_ns:
        header = replace(header, gpx_begins_ns=clip.first_ns)
    sink.open(header)
    try:
        for result, packets in clip.entries():
            if frames == 0:
                first = next((i for i, packet in enumerate(packets) if packet.keyframe), 0)
                packets = packets[first:]
            sink.write(result, packets)
            frames += 1
            on_frame()
    finally:
        sink.close()
    return frames
