"""A short drive made long: the packets of a video, again and again."""

from pathlib import Path

import av
from av.error import FFmpegError

from fcw.errors import UserError


def repeat_packets(clip: Path, out: Path, duration_s: float) -> None:
    """Write a clip into one file as often as a duration asks for, at least once, its packets as they are.

    Raises:
        UserError: its packets have no times, or cannot be copied.
    """
    try:
        _repeat(clip, out, duration_s)
    except (FFmpegError, ValueError) as error:
        raise UserError(
            f"{clip}: cannot be repeated to {duration_s:g} s ({error}); measure it as it is with --shortest 0"
        ) from error


def _repeat(clip: Path, out: Path, duration_s: float) -> None:
    with av.open(str(clip)) as source, av.open(str(out), "w") as target:
        stream = source.streams.video[0]
        copy = target.add_stream_from_template(stream)
        packets = [(bytes(p), p.pts, p.dts, p.is_keyframe) for p in source.demux(stream) if p.size]
        times = sorted(pts for _, pts, _, _ in packets if pts is not None)
        if len(times) < 2 or stream.time_base is None:
            raise ValueError("its pictures have no times, or there is only one")
        length = times[-1] - times[0] + (times[-1] - times[0]) // (len(times) - 1)
        for repeat in range(round(duration_s / float(length * stream.time_base)) or 1):
            for data, pts, dts, keyframe in packets:
                packet = av.Packet(data)
                packet.pts = None if pts is None else pts + repeat * length
                packet.dts = None if dts is None else dts + repeat * length
                packet.time_base, packet.stream, packet.is_keyframe = stream.time_base, copy, keyframe
                target.mux(packet)
