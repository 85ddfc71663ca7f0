"""A short drive made long: the packets of a video, again and again."""

from pathlib import Path

import av


def repeat_packets(clip: Path, out: Path, duration_s: float) -> None:
    """Write a clip into one file as often as a duration asks for, at least once, its packets as they are.

    Raises:
        av.FFmpegError: the file cannot be read, or its packets do not go into a file of `out`'s kind.
    """
    with av.open(str(clip)) as source, av.open(str(out), "w") as target:
        stream = source.streams.video[0]
        copy = target.add_stream_from_template(stream)
        assert stream.time_base is not None
        packets = [(bytes(p), p.pts, p.dts, p.is_keyframe) for p in source.demux(stream) if p.size]
        times = sorted(pts for _, pts, _, _ in packets if pts is not None)
        length = times[-1] - times[0] + (times[-1] - times[0]) // (len(times) - 1)
        for repeat in range(round(duration_s / float(length * stream.time_base)) or 1):
            for data, pts, dts, keyframe in packets:
                packet = av.Packet(data)
                packet.pts = None if pts is None else pts + repeat * length
                packet.dts = None if dts is None else dts + repeat * length
                packet.time_base, packet.stream, packet.is_keyframe = stream.time_base, copy, keyframe
                target.mux(packet)
