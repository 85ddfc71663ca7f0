"""A camera: a device of this computer, or a stream on the network, by FFmpeg's libraries."""

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
"""A camera that is gone is looked for so long: one that had lost its power takes half a minute."""
LONGEST_PAUSE_S = 5
"""Between two looks; the first ones come after 1, 2, 3 and 4 s."""
CONNECTING = "the camera is gone; connecting again"
DEVICE_FORMATS = {"linux": "v4l2", "darwin": "avfoundation"}
"""FFmpeg's inputs for the cameras of a computer, which count them."""
OWN_CLOCKS = ("rtsp", "mpegts", "flv", "hls", "video4linux2,v4l2", "avfoundation")
"""Inputs whose times are the camera's own, whatever bursts the network makes of them; for others FFmpeg
counts frames, and the arrival says more."""
PLAYLISTS = ("hls", "dash")
"""Inputs whose size is that of a list, not of the drive."""
CLOCK_SET_NS = NS_PER_S
"""A clock that goes back by more, or forward by so much more than the next picture took to come, was set
anew, as by a time server: later times go on from the last one."""
STRICT_OPTIONS = {"err_detect": "explode"}
"""Else FFmpeg's decoder gives a damaged JPEG as if it were whole, grey or shifted from the damage on."""
STREAM_OPTIONS = {"flags": "low_delay", "rtsp_transport": "tcp"}
DEFAULT_PORTS = {"rtsp": 554, "http": 80, "https": 443, "rtmp": 1935}
_NOT_FOR_NAMES = re.compile(r"[^A-Za-z0-9._-]+")


def is_camera(address: str) -> bool:
    """Whether an address is that of a camera: a number, a video device, or a URL."""
    return address.isdecimal() or address.startswith("/dev/video") or "://" in address


def camera_name(address: str) -> str:
    """What a camera is called in logs and file names: of a URL host, port and path, and no password."""
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
    """Pictures of a camera from the moment on at which they are asked for; there is no end.

    Attributes:
        name: `camera-0`, or host, port and path of a URL.
        image_size: of the first picture.
        frame_count: None, as a camera has no end.
        frame_rate_hz: as the camera states it.
        relays_video: False, as few cameras give what a log can hold.
        notes: why the pictures ended.
        trouble: why no picture comes at present, or any more; empty while they come.
        recorded: whether the stream is a recording after all, which the network gives as fast as it can.
    """

    frame_count = None
    relays_video = False

    def __init__(self, address: str, wanted_size: ImageSize | None = None) -> None:
        """Look at the first picture.

        Args:
            address: a number, `/dev/video0`, or a URL that FFmpeg knows (rtsp, http ...).
            wanted_size: asked of a device, which has several; a stream has the one that it has.

        Raises:
            UserError: there is no camera there, or it gives no picture.
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
        """Pictures as they come; times begin with 0 at the first one.

        Where the connection is lost a new one is made, for `RETURNS_WITHIN_S`; times go on.

        Args:
            start_ns: those before it are left out.
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
            if ends:  # of a file a new connection would begin anew
                self._end(f"the camera is gone ({lost})")
                return
            if time.monotonic() - lost_s >= RETURNS_WITHIN_S:
                self._end(f"the camera is gone ({lost}) and did not come back in {RETURNS_WITHIN_S:.0f} s")
                return
            self.trouble, tries = CONNECTING, tries + 1
            time.sleep(min(tries, LONGEST_PAUSE_S))

    def _end(self, reason: str) -> None:
        """Say why no picture will come any more."""
        self.trouble, self.notes = reason, (f"{self.name}: {reason}",)

    def _pictures(
        self, container: InputContainer, stream: VideoStream
    ) -> Iterator[tuple[Packet, VideoFrame]]:
        """Decoded pictures and their packets; damaged ones are left out, as far as FFmpeg tells."""
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
        """What FFmpeg opens: the file, its input format, options."""
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
    """Whether a packet is a JPEG without fault to the strict decoder: some cameras' all have one."""
    if stream.codec_context.name != "mjpeg":
        return False
    decoder = VideoCodecContext.create("mjpeg", "r")
    decoder.options = DECODER_OPTIONS | STRICT_OPTIONS
    try:
        return bool(decoder.decode(packet) or decoder.decode(None))
    except FFmpegError:
        return False


class _Times:
    """Times of a camera's pictures, from 0 on: by its own clock if it has one, else by their arrival.

    Over each loss of the connection they go on by our clock.
    """

    def __init__(self) -> None:
        self._first_s: float | None = None
        self._last_s, self._last_ns = 0.0, -1
        self._own_clock = self._recorded = False
        self._zero_ns: int | None = None
        """What the camera's clock shows at time 0; None until a picture tells."""

    def connected(self, own_clock: bool, recorded: bool) -> None:
        """Pictures of a new connection follow, with a clock of their own or without, in real time or not."""
        self._own_clock, self._recorded, self._zero_ns = own_clock, recorded, None

    def of(self, stamp_ns: int | None) -> int:
        """Time of the picture that came just now, by what the camera's clock says of it."""
        now_s = time.monotonic()
        if self._first_s is None:
            self._first_s = self._last_s = now_s
        time_ns = round((now_s - self._first_s) * NS_PER_S)
        if self._own_clock and stamp_ns is not None:
            passed_ns = round((now_s - self._last_s) * NS_PER_S)
            goes_on_ns = max(self._last_ns, 0) + passed_ns
            time_ns = goes_on_ns if self._zero_ns is None else stamp_ns - self._zero_ns
            step_ns = time_ns - self._last_ns
            # A recording comes as fast as the network gives it.
            sprang = not self._recorded and step_ns > passed_ns + CLOCK_SET_NS
            if self._last_ns >= 0 and (sprang or step_ns < -CLOCK_SET_NS):
                time_ns = goes_on_ns
            self._zero_ns = stamp_ns - time_ns
        time_ns = max(time_ns, self._last_ns + 1)
        self._last_s, self._last_ns = now_s, time_ns
        return time_ns
