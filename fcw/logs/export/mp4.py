"""Writes the video of a drive as MP4, with an overlay or with the log's own packets as they are."""

import io
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.files import whole_file
from fcw.frame import FALLBACK_RATE_HZ, Frame, VideoPacket
from fcw.logs.encode import VideoEncoder
from fcw.logs.export.clip import DriveClip
from fcw.logs.pictures import LogPictures
from fcw.logs.records import FrameResult
from fcw.units import NS_PER_S

Draw = Callable[[NDArray[np.uint8], FrameResult], None]
"""Draws over a (height, width, 3) BGR picture, in place."""

TICKS_PER_S = 90_000
"""MP4's usual clock, in which 24, 25, 29.97, 30, 50, 59.94 and 60 frames a second are whole ticks."""


def write_overlay_mp4(path: Path, clip: DriveClip, draw: Draw, on_frame: Callable[[], None]) -> int:
    """Encode the pictures of a drive with something drawn over them, as H.264 that browsers can play.

    Of an incomplete log, the existing pictures are written.

    Args:
        path: the file.
        clip: the drive or a range of it.
        draw: draws over each picture.
        on_frame: called after each frame.

    Returns:
        The number of pictures.

    Raises:
        UserError: the log has no pictures, or the file cannot be written.
    """
    return _write(path, clip, _drawn_packets(clip, draw, on_frame))


def write_relayed_mp4(path: Path, clip: DriveClip, on_frame: Callable[[], None]) -> int:
    """Write the log's own video packets, bit for bit; the first frame of the clip must be at a keyframe.

    Returns:
        The number of packets, which is larger than that of frames if some only feed the decoder.

    Raises:
        UserError: the log has no pictures, or the file cannot be written.
    """
    return _write(path, clip, _own_packets(clip, on_frame))


def _drawn_packets(clip: DriveClip, draw: Draw, on_frame: Callable[[], None]) -> Iterator[VideoPacket]:
    header, pictures = clip.log.header, LogPictures(clip.log)
    encoder = VideoEncoder(header.image_size, header.frame_rate_hz)
    try:
        for result in clip.results():
            try:
                image = np.ascontiguousarray(pictures.at(result.index))
            except UserError:
                if clip.log.complete:
                    raise
                return  # of a torn log the last results have no pictures any more
            draw(image, result)
            yield from encoder.encode(Frame(result.index, result.time_ns, image))
            on_frame()
    finally:
        encoder.close()
        pictures.close()


def _own_packets(clip: DriveClip, on_frame: Callable[[], None]) -> Iterator[VideoPacket]:
    started = False
    for _, packets in clip.entries():
        for packet in packets:
            started |= packet.keyframe
            if started:
                yield packet
        on_frame()


def _write(path: Path, clip: DriveClip, packets: Iterator[VideoPacket]) -> int:
    """Write packets, the first of which is a keyframe, as MP4 with the index first.

    Pictures whose times step back, as with a recorder's clock, are in a log only to feed the decoder. MP4
    needs rising times, so that they are shown for one tick.
    """
    first = next(packets, None) if len(clip.log.series().keyframe_ns) else None
    if first is None:
        raise UserError(f"{clip.log.path}: the log holds no pictures; there is no video to write")
    rate_hz, start_ns = clip.log.header.frame_rate_hz or FALLBACK_RATE_HZ, int(clip.times_ns[0])
    count, last, last_ticks = 1, first, _ticks(first.time_ns - start_ns)
    with (
        whole_file(path) as partial,
        av.open(io.BytesIO(first.data), format="h264") as sample,  # tells size, profile and parameter sets
        av.open(f"file:{partial}", "w", format="mp4", options={"movflags": "faststart"}) as container,
    ):
        stream = container.add_stream_from_template(sample.streams.video[0])
        stream.time_base = Fraction(1, TICKS_PER_S)

        def mux(packet: VideoPacket, ticks: int, duration_ticks: int) -> None:
            muxed = av.Packet(packet.data)
            muxed.stream, muxed.time_base = stream, Fraction(1, TICKS_PER_S)
            # Logs and our own encoder have no B frames, so packets are decoded in the order of presentation.
            # Those that only feed the decoder have times below 0, which an edit list keeps from being shown.
            muxed.pts = muxed.dts = ticks
            muxed.duration = duration_ticks
            muxed.is_keyframe = packet.keyframe
            container.mux(muxed)

        for packet in packets:
            ticks = max(_ticks(packet.time_ns - start_ns), last_ticks + 1)
            mux(last, last_ticks, ticks - last_ticks)
            last, last_ticks = packet, ticks
            count += 1
        mux(last, last_ticks, round(TICKS_PER_S / rate_hz))
    return count


def _ticks(time_ns: int) -> int:
    return round(time_ns * TICKS_PER_S / NS_PER_S)
