"""One pass over a video file with FFmpeg's libraries, which survives damage and counts it."""

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import av
from av.bitstream import BitStreamFilterContext
from av.container import InputContainer
from av.error import FFmpegError
from av.packet import Packet
from av.stream import Disposition
from av.video.frame import VideoFrame
from av.video.stream import VideoStream

from fcw.bounded.pictures import DECODER_OPTIONS, check_drive_size
from fcw.errors import UserError
from fcw.frame import VideoPacket
from fcw.sources import h264
from fcw.units import NS_PER_S

_SEEK_MARGINS_S = (0, 10)
"""In containers without an index, a seek may land after the keyframe; then seek again so much earlier."""


@contextmanager
def opened(path: Path) -> Iterator[tuple[InputContainer, VideoStream]]:
    """Open a file: its demuxer and its first stream of moving pictures.

    Decoding uses slice threads only. Frame threads are faster if a picture is one slice, but a decoder that
    uses them and is dropped before it is flushed waits for ever.

    Raises:
        UserError: the file is not a video, its codec is unknown here, or its pictures are too large.
    """
    try:
        # A name may look like a URL (12:30:05.mp4), and a playlist may name one.
        container = av.open(
            f"file:{path}",
            options={"protocol_whitelist": "file"},
            metadata_errors="replace",  # cameras write all encodings
        )
    except (FFmpegError, UnicodeError, ValueError) as error:
        raise UserError(
            f"{path}: not a readable video ({getattr(error, 'strerror', None) or error}); "
            "expected a video such as MP4, MKV or AVI. "
            "A recording that was cut off may lack its index: repair it first"
        ) from error
    with container:
        if _is_still_or_text(container.format.name):
            raise UserError(
                f"{path}: one picture or a text, not a video; "
                "expected a video file or the folder that holds the pictures"
            )
        streams = moving_pictures(container)
        if not streams:
            kinds = ", ".join(sorted({stream.type for stream in container.streams})) or "nothing"
            raise UserError(
                f"{path}: no video stream in it (it holds: {kinds}); expected a video of the road ahead"
            )
        stream = streams[0]
        if stream.codec_context is None:
            raise UserError(
                f"{path}: no decoder for the codec of its video stream; "
                "convert it first, for instance to H.264: `ffmpeg -i IN -c:v libx264 OUT.mp4`"
            )
        codec = stream.codec_context
        if codec.width and codec.height:  # else only the first picture tells
            check_drive_size(path, codec.width, codec.height)
        codec.options = DECODER_OPTIONS
        stream.thread_type = "SLICE"
        yield container, stream


def moving_pictures(container: InputContainer) -> list[VideoStream]:
    """The video streams of a file, without attached still pictures such as covers."""
    return [s for s in container.streams.video if not s.disposition & Disposition.attached_pic]


class Decoding:
    """One pass over an opened file.

    Attributes:
        packets_read: number of packets read from the file.
        undecodable: number of packets that the decoder refused.
        error: why reading stopped before the end of the file; None if it did not.
    """

    def __init__(
        self, container: InputContainer, stream: VideoStream, *, relay: bool = False, sought: bool = False
    ) -> None:
        """Start at the container's position; after a seek, at the next keyframe. `relay` keeps packets."""
        self.packets_read = 0
        self.undecodable = 0
        self.error: str | None = None
        self._skip_to_keyframe = sought
        self._container = container
        self._stream = stream
        self._annex_b = annex_b_filter(stream) if relay else None
        self._pending: deque[tuple[bytes, int, bool]] = deque()

    def packets(self) -> Iterator[Packet]:
        """Packets up to the end, or up to where the file can no longer be read."""
        try:
            for packet in self._container.demux(self._stream):
                self._skip_to_keyframe &= not packet.is_keyframe
                if packet.size and not self._skip_to_keyframe:
                    self.packets_read += 1
                    yield packet
        except FFmpegError as error:
            self.error = str(error.strerror)

    def pictures(self) -> Iterator[VideoFrame]:
        """All pictures that decode and are meant to be shown, in presentation order."""
        for packet in self.packets():
            try:
                pictures = self._stream.decode(packet)
            except FFmpegError:
                self.undecodable += 1
                pictures = []
            if self._annex_b is not None and packet.pts is not None:
                time_ns, keyframe = to_ns(packet.pts, self._stream), packet.is_keyframe
                data = in_annex_b(self._annex_b, packet)
                if data:
                    self._pending.append((data, time_ns, keyframe))
            yield from pictures
        try:
            yield from self._stream.decode(None)
        except FFmpegError:
            self.undecodable += 1

    def take_packets(self, time_ns: int) -> tuple[VideoPacket, ...]:
        """Packets up to the one shown at `time_ns`, in decoding order; none if there is no such packet."""
        if all(packet_ns != time_ns for _, packet_ns, _ in self._pending):
            return ()
        taken: list[VideoPacket] = []
        while not taken or not taken[-1].shown:
            data, packet_ns, keyframe = self._pending.popleft()
            taken.append(VideoPacket(data, packet_ns, keyframe, shown=packet_ns == time_ns))
        return tuple(taken)


def seek_before(container: InputContainer, stream: VideoStream, time_ns: int) -> bool:
    """Seek to a packet from which the picture at `time_ns` can be decoded; False if there is none."""
    for margin_s in _SEEK_MARGINS_S:
        target = to_pts(time_ns - margin_s * NS_PER_S, stream)
        try:
            container.seek(target, stream=stream)
            key = next((packet for packet in container.demux(stream) if packet.is_keyframe), None)
            if key is not None and key.pts is not None and to_ns(key.pts, stream) <= time_ns:
                container.seek(target, stream=stream)
                return True
        except FFmpegError:
            continue
    return False


def announced_packets(container: InputContainer, stream: VideoStream) -> int:
    """Number of packets in the whole file; 0 if unknown.

    For MP4 it is that of the index, to which edit lists have been applied.
    """
    return len(stream.index_entries) if "mp4" in container.format.name else stream.frames


def annex_b_filter(stream: VideoStream) -> BitStreamFilterContext | None:
    """FFmpeg's filter to H.264 in Annex B form, with parameter sets before each IDR picture.

    None if the stream's own parameter sets are damaged.
    """
    try:
        return BitStreamFilterContext("h264_mp4toannexb", stream)
    except FFmpegError:
        return None


def in_annex_b(annex_b: BitStreamFilterContext, packet: Packet) -> bytes:
    """A packet's data in Annex B form; empty if the packet is damaged. Empties the packet."""
    try:
        return b"".join(bytes(part) for part in annex_b.filter(packet))
    except FFmpegError:
        return b""


def is_plain_picture(annex_b: BitStreamFilterContext, packet: Packet) -> bool:
    """Whether a log can hold a packet as it is. Empties the packet.

    It must contain no B slice. A keyframe must be an IDR picture with its parameter sets. A packet that is
    too damaged to read does not matter: it is not relayed.
    """
    keyframe = packet.is_keyframe
    data = in_annex_b(annex_b, packet)
    if not data:
        return True
    unit = h264.inspect(data)
    if unit is None or unit.bidirectional:
        return False
    return (unit.idr and unit.parameter_sets) if keyframe else True


def to_ns(pts: int, stream: VideoStream) -> int:
    """Convert stream ticks to nanoseconds, rounded to the nearest, in integer arithmetic."""
    num, den = _time_base(stream)
    return (2 * pts * num * NS_PER_S + den) // (2 * den)


def to_pts(time_ns: int, stream: VideoStream) -> int:
    """The last stream tick at or before a time."""
    num, den = _time_base(stream)
    return time_ns * den // (num * NS_PER_S)


def _time_base(stream: VideoStream) -> tuple[int, int]:
    base = stream.time_base
    if base is None:
        raise ValueError("a demuxed stream without a time base")
    return base.numerator, base.denominator


def _is_still_or_text(demuxer: str) -> bool:
    """Whether FFmpeg made a "video" of a still picture or of a text file."""
    return demuxer in ("image2", "tty") or demuxer.endswith("_pipe")
