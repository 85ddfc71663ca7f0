"""Reads a camera, which is a device of this computer or a network stream, with FFmpeg's libraries."""

import re
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlsplit

import av
import numpy as np
from av.container import InputContainer
from av.error import FFmpegError, InvalidDataError
from av.packet import Packet
from av.video.codeccontext import VideoCodecContext
from av.video.frame import VideoFrame
from av.video.stream import VideoStream

from fcw.bounded.pictures import DECODER_OPTIONS
from fcw.errors import UserError
from fcw.frame import FALLBACK_RATE_HZ, Frame, ImageSize
from fcw.logs.decoded import bgr
from fcw.sources.decoding import to_ns
from fcw.sources.orientation import orientation, squaring
from fcw.units import NS_PER_S

OPEN_TIMEOUT_S, READ_TIMEOUT_S = 10.0, 10.0
RETURNS_WITHIN_S = 60.0
"""How long a lost camera is tried again. After a loss of power, a camera takes half a minute to return."""
LONGEST_PAUSE_S = 5
"""Longest pause between two tries; the first ones come after 1, 2, 3 and 4 s."""
CONNECTING = "the camera is gone; connecting again"
DEVICE_FORMATS = {"linux": "v4l2", "darwin": "avfoundation"}
"""FFmpeg's input formats for the cameras of a computer, which are numbered."""
OWN_CLOCKS = ("rtsp", "mpegts", "flv", "hls", "video4linux2,v4l2", "avfoundation")
"""Inputs whose times come from the camera's own clock, even if the network delivers pictures in bursts. For
other inputs FFmpeg only counts frames, so the time of arrival is better."""
PLAYLISTS = ("hls", "dash")
"""Inputs whose stated size is the size of a list, not of the drive."""
CLOCK_SET_NS = NS_PER_S
"""If a camera's clock goes back by more than this, or ahead of the time that passed by more than this, it was
set, as by a time server. Times then continue from the last one."""
STRICT_OPTIONS = {"err_detect": "explode"}
"""Without it, FFmpeg decodes a damaged JPEG as if it were whole, grey or shifted after the damage."""
STREAM_OPTIONS = {"flags": "low_delay", "rtsp_transport": "tcp"}
DEFAULT_PORTS = {"rtsp": 554, "http": 80, "https": 443, "rtmp": 1935}
_NOT_FOR_NAMES = re.compile(r"[^A-Za-z0-9._-]+")


def is_camera(address: str) -> bool:
    """Whether an address names a camera: a number, a video device, or a URL."""
    return address.isdecimal() or address.startswith("/dev/video") or "://" in address


def camera_name(address: str) -> str:
    """A camera's name in logs and file names; for a URL its host, port and path, without the password."""
    if address.isdecimal() or "://" not in address:
        return f"camera-{address.removeprefix('/dev/video')}"
    try:
        url = urlsplit(address)
        # One host may have several cameras, each at a port of its own.
        port = "" if url.port in (None, DEFAULT_PORTS.get(url.scheme)) else f"-{url.port}"
    except ValueError as error:
        raise UserError(f"{address}: no address of a camera ({error}); expected rtsp://HOST/PATH") from None
    return _NOT_FOR_NAMES.sub("-", f"{url.hostname or ''}{port}{url.path}").strip("-") or "camera"


class CameraSource:
    """Gives the pictures of a camera from the moment at which they are asked for, without an end.

    Attributes:
        name: `camera-0`, or host, port and path of a URL.
        image_size: size of the first picture, and of all others.
        frame_count: None, because a camera has no end.
        frame_rate_hz: pictures per second as the camera states them.
        relays_video: False, because few cameras give packets that a log can hold.
        notes: why the pictures ended.
        trouble: why no picture comes now, or will come any more; empty while pictures come.
        recorded: whether the stream is a recording after all, which comes as fast as the network allows.
    """

    frame_count = None
    relays_video = False

    def __init__(self, address: str, wanted_size: ImageSize | None = None) -> None:
        """Open the camera and read its first picture.

        Args:
            address: a number, `/dev/video0`, or a URL that FFmpeg knows (rtsp, http ...).
            wanted_size: requested from a device, which may offer several; a stream has only one.

        Raises:
            UserError: there is no camera at the address, or it gives no picture.
        """
        self._address, self._wanted_size = address, wanted_size
        self.name = camera_name(address)
        self.notes: tuple[str, ...] = ()
        self.trouble, self._strict = "", False
        with self._opened() as (container, stream):
            try:
                packet, first = next(self._pictures(container, stream), (None, None))
            except FFmpegError as error:
                raise UserError(f"{self.name}: the camera gives no picture ({error.strerror})") from error
            if packet is None or first is None:
                raise UserError(f"{self.name}: the camera gives no picture that can be decoded")
            self._strict = _is_whole_jpeg(packet, stream)
            (self._square, _), (self._orient, _) = squaring(stream, first), orientation(first)
            blank = np.empty((first.height, first.width, 1), np.uint8)
            height, width = self._orient(self._square(blank)).shape[:2]
            self.image_size = ImageSize(width, height)
            self.frame_rate_hz = float(stream.average_rate or stream.guessed_rate or FALLBACK_RATE_HZ)
            self.recorded = container.duration is not None

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Pictures as they come, with times that begin at 0.

        A lost connection is opened again if that succeeds within `RETURNS_WITHIN_S`; times continue.

        Args:
            start_ns: earlier pictures are left out.
        """
        self.notes, self.trouble = (), ""
        times, index, tries, lost, lost_s = _Times(), 0, 0, "", 0.0
        ends = self.recorded
        while True:
            try:
                with self._opened() as (container, stream):
                    kind = container.format.name
                    times.connected(self.recorded or kind in OWN_CLOCKS, self.recorded)
                    ends = self.recorded or (container.size > 0 and kind not in PLAYLISTS)
                    for _, picture in self._pictures(container, stream):
                        image = self._orient(self._square(bgr(picture)))
                        if (size := ImageSize(image.shape[1], image.shape[0])) != self.image_size:
                            self._end(f"its pictures are {size} now, no longer {self.image_size}")
                            return
                        stamp_ns = None if picture.pts is None else to_ns(picture.pts, stream)
                        time_ns, tries, self.trouble = times.of(stamp_ns), 0, ""
                        if start_ns is None or time_ns >= start_ns:
                            yield Frame(index, time_ns, image)
                        index += 1
                if ends:
                    return
                reason = "its stream has ended"
            except FFmpegError as error:
                reason = error.strerror
            except UserError:
                reason = "nothing answers there"
            if tries == 0:
                lost, lost_s = reason, time.monotonic()
            if ends:  # a new connection would play the file from its start
                self._end(f"the camera is gone ({lost})")
                return
            if time.monotonic() - lost_s >= RETURNS_WITHIN_S:
                self._end(f"the camera is gone ({lost}) and did not come back in {RETURNS_WITHIN_S:.0f} s")
                return
            self.trouble, tries = CONNECTING, tries + 1
            time.sleep(min(tries, LONGEST_PAUSE_S))

    def _end(self, reason: str) -> None:
        """Record why no more pictures will come."""
        self.trouble, self.notes = reason, (f"{self.name}: {reason}",)

    def _pictures(
        self, container: InputContainer, stream: VideoStream
    ) -> Iterator[tuple[Packet, VideoFrame]]:
        """Decoded pictures and their packets, without those that FFmpeg reports as damaged."""
        for packet in container.demux(stream):
            try:
                pictures = packet.decode()
            except InvalidDataError:
                continue
            yield from ((packet, picture) for picture in pictures if not picture.is_corrupt)

    @contextmanager
    def _opened(self) -> Iterator[tuple[InputContainer, VideoStream]]:
        file, format_name, options = self._where()
        try:
            container = av.open(
                file, format=format_name, options=options, timeout=(OPEN_TIMEOUT_S, READ_TIMEOUT_S)
            )
        except (FFmpegError, ValueError) as error:
            reason = error.strerror if isinstance(error, FFmpegError) else str(error)
            size = f" with pictures of {self._wanted_size}" if self._wanted_size and format_name else ""
            raise UserError(
                f"{self.name}: no camera there{size} ({reason}); expected the number of a camera, "
                "/dev/video0, or an rtsp or http address that gives video"
            ) from error
        with container:
            if not container.streams.video:
                raise UserError(f"{self.name}: no video in what the address gives; expected a camera's")
            stream = container.streams.video[0]
            stream.codec_context.options = DECODER_OPTIONS | (STRICT_OPTIONS if self._strict else {})
            stream.thread_type = "SLICE"  # frame threads would hold pictures back
            yield container, stream

    def _where(self) -> tuple[str, str | None, dict[str, str]]:
        """What FFmpeg opens: the file, its input format and the options."""
        if "://" in self._address:
            return self._address, None, STREAM_OPTIONS
        format_name = DEVICE_FORMATS.get(sys.platform)
        if format_name is None:
            raise UserError(
                f"{self._address}: cameras of this computer are read on Linux and macOS only; "
                "expected an rtsp or http address"
            )
        options = {"video_size": str(self._wanted_size)} if self._wanted_size else {}
        number = self._address.removeprefix("/dev/video")
        return (f"/dev/video{number}" if format_name == "v4l2" else number), format_name, options


def _is_whole_jpeg(packet: Packet, stream: VideoStream) -> bool:
    """Whether the strict decoder accepts a packet as a JPEG; some cameras send only slightly faulty ones."""
    if stream.codec_context.name != "mjpeg":
        return False
    decoder = VideoCodecContext.create("mjpeg", "r")
    decoder.options = DECODER_OPTIONS | STRICT_OPTIONS
    try:
        return bool(decoder.decode(packet) or decoder.decode(None))
    except FFmpegError:
        return False


class _Times:
    """Times of a camera's pictures from 0, by the camera's own clock if it has one, else by their arrival.

    Across a loss of the connection, times continue by our clock.
    """

    def __init__(self) -> None:
        self._first_s: float | None = None
        self._last_s, self._last_ns = 0.0, -1
        self._own_clock = self._recorded = False
        self._zero_ns: int | None = None
        """What the camera's clock shows at time 0; None until the first picture of the connection."""

    def connected(self, own_clock: bool, recorded: bool) -> None:
        """Begin a new connection, with or without a clock of its own, recorded or in real time."""
        self._own_clock, self._recorded, self._zero_ns = own_clock, recorded, None

    def of(self, stamp_ns: int | None) -> int:
        """The time of the picture that has just come, given its time on the camera's clock."""
        now_s = time.monotonic()
        if self._first_s is None:
            self._first_s = self._last_s = now_s
        time_ns = round((now_s - self._first_s) * NS_PER_S)
        if self._own_clock and stamp_ns is not None:
            passed_ns = round((now_s - self._last_s) * NS_PER_S)
            goes_on_ns = max(self._last_ns, 0) + passed_ns
            time_ns = goes_on_ns if self._zero_ns is None else stamp_ns - self._zero_ns
            step_ns = time_ns - self._last_ns
            # A recording comes as fast as the network allows.
            sprang = not self._recorded and step_ns > passed_ns + CLOCK_SET_NS
            if self._last_ns >= 0 and (sprang or step_ns < -CLOCK_SET_NS):
                time_ns = goes_on_ns
            self._zero_ns = stamp_ns - time_ns
        time_ns = max(time_ns, self._last_ns + 1)
        self._last_s, self._last_ns = now_s, time_ns
        return time_ns
