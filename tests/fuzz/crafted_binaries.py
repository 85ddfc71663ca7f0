"""Crafted pictures, archives, nets, logs and videos by the name of their format in `readers.py`."""

import io
import struct
import warnings
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator

import numpy as np


def _png(good: bytes) -> list[bytes]:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    def picture(width: int, height: int, depth: int, colour: int, data: bytes, *more: bytes) -> bytes:
        head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0))
        return b"\x89PNG\r\n\x1a\n" + head + b"".join(more) + chunk(b"IDAT", data) + chunk(b"IEND", b"")

    rows = zlib.compress(bytes(49 * 64 * 8))
    return [
        picture(0, 0, 8, 2, rows),
        picture(64, 48, 16, 6, rows),
        picture(64, 48, 8, 3, rows),
        picture(64, 48, 8, 3, rows, chunk(b"PLTE", bytes(3))),
        picture(64, 48, 3, 7, rows),
        picture(64, 48, 8, 2, zlib.compress(bytes(64 << 20))),
        picture(64, 48, 8, 2, rows, chunk(b"iCCP", b"a\0\0" + zlib.compress(bytes(64 << 20)))),
        picture(64, 48, 8, 2, rows, chunk(b"zTXt", b"a\0\0" + zlib.compress(bytes(64 << 20)))),
        picture(64, 48, 8, 2, rows, chunk(b"eXIf", b"II*\0\x08\0\0\0" + b"\xff" * 40)),
        picture(64, 48, 8, 2, rows, chunk(b"acTL", struct.pack(">II", 2**31 - 1, 0))),
        picture(16384, 3072, 1, 0, zlib.compress(bytes(3072 * 2049))),
        picture(16384, 3073, 1, 0, zlib.compress(bytes(3073 * 2049))),
        picture(2**31 - 1, 1, 8, 0, b""),
        good[:-12],
        good[:40],
        good.replace(b"IDAT", b"IDAX"),
        good[:8] + struct.pack(">I", 2**31 - 1) + good[12:],
        good[:33] + struct.pack(">I", 0xAC002000) + good[37:],
    ]


def _jpeg(good: bytes) -> list[bytes]:
    exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0%c\0\0\0\x08\0\0\0"

    def with_exif(data: bytes) -> bytes:
        return good[:2] + b"\xff\xe1" + struct.pack(">H", len(data) + 2) + data + good[2:]

    at = good.index(b"\xff\xc0") + 5
    return [
        *(with_exif(exif % turned) for turned in (0, 3, 6, 8, 255)),
        with_exif(b"Exif\0\0MM\0*\xff\xff\xff\xff"),
        *(
            good[:at] + struct.pack(">HH", *size) + good[at + 4 :]
            for size in ((0, 0), (48, 0), (65535, 1000))
        ),
        good[: at + 4] + b"\x04" + good[at + 5 :],
        good.replace(b"\xff\xc0", b"\xff\xc2"),
        good.replace(b"\xff\xc0", b"\xff\xc9"),
        good.replace(b"\xff\xd9", b""),
        good[:2] + b"\xff\xfe\x00\x00" + good[2:],
        good[:2] + b"\xff\xfe\xff\xff" + bytes(65533) + good[2:],
        b"\xff\xd8" + b"\xff" * 1_000_000,
        b"\xff\xd8" + b"\xff\xe0\x00\x02" * 1_000_000,
        b"GIF89a" + bytes(100),
        b"<svg xmlns='http://www.w3.org/2000/svg'><image href='/etc/passwd'/></svg>",
    ]


def _bmp(good: bytes) -> list[bytes]:
    def with_field(form: str, at: int, *values: int) -> bytes:
        return good[:at] + struct.pack(form, *values) + good[at + struct.calcsize(form) :]

    return [
        *(
            with_field("<ii", 18, *size)
            for size in ((64, -48), (-64, 48), (0, 0), (64, -(2**31)), (16000, 4000))
        ),
        *(with_field("<H", 28, bits) for bits in (0, 1, 4, 16, 32, 65535)),
        *(with_field("<I", 30, way) for way in (1, 2, 3, 4, 99)),
        with_field("<I", 10, 2**32 - 1),
        with_field("<I", 14, 2**32 - 1),
        with_field("<I", 14, 12),
        with_field("<I", 46, 2**32 - 1),
    ]


def _webp(good: bytes) -> list[bytes]:
    wide = b"RIFF" + struct.pack("<I", 30) + b"WEBPVP8X" + struct.pack("<II", 10, 0x12) + b"\x3f\0\0\x2f\0\0"
    return [
        wide,
        wide + b"ANIM" + struct.pack("<IIH", 6, 0, 0) + b"ANMF" + struct.pack("<I", 2**32 - 2),
        wide + good[12:],
        b"RIFF" + struct.pack("<I", 2**32 - 1) + good[8:],
        good[:12] + b"VP8L" + good[16:],
        good[:26] + struct.pack("<HH", 16383, 4000) + good[30:],
    ]


def _archive(good: bytes) -> Iterator[bytes]:
    """Each when it is asked for: of a model with many arrays they are half a gigabyte."""
    with np.load(io.BytesIO(good)) as archive:
        arrays = {name: archive[name] for name in archive.files}

    def saved(**changes: np.ndarray) -> bytes:
        buffer = io.BytesIO()
        np.savez(buffer, allow_pickle=False, **(arrays | changes))
        return buffer.getvalue()

    def zipped(members: dict[str, bytes], way: int = zipfile.ZIP_STORED) -> bytes:
        buffer = io.BytesIO()
        with warnings.catch_warnings(), zipfile.ZipFile(buffer, "w", way) as archive:
            warnings.simplefilter("ignore")
            for name, data in members.items():
                archive.writestr(name, data)
        return buffer.getvalue()

    def npy(header: bytes, version: bytes = b"\x01\x00") -> bytes:
        length = struct.pack("<H" if version == b"\x01\x00" else "<I", len(header))
        return b"\x93NUMPY" + version + length + header

    headers = [
        b"{'descr': '<f4', 'fortran_order': False, 'shape': (4611686018427387904, 4)}\n",
        b"{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}\n",
        b"{'descr': '<f4', 'fortran_order': False, 'shape': (True,)}\n",
        b"{'descr': '<f4', 'fortran_order': False, 'shape': (0, 9223372036854775807)}\n",
        b"{'descr': '<f4', 'fortran_order': 1, 'shape': " + b"(" + b"1," * 100 + b")}\n",
        b"{'descr': '|V2147483647', 'fortran_order': False, 'shape': (0,)}\n",
        b"{'descr': '|S0', 'fortran_order': False, 'shape': (1000000000,)}\n",
        b"{'descr': '|O', 'fortran_order': False, 'shape': (1,)}\n",
        b"{'descr': [('a', '<f4', (1000000, 1000000))], 'fortran_order': False, 'shape': (0,)}\n",
        b"{'descr': '<M8[as]', 'fortran_order': False, 'shape': ()}\n",
        b"__import__('os').system('true')\n",
        b"{" * 300 + b"\n",
        b"-" * 60_000 + b"1\n",
    ]
    first = next(iter(arrays))
    wrong = [
        np.full(array.shape, np.nan).astype(array.dtype) if array.dtype.kind == "f" else array[:0]
        for array in arrays.values()
    ]
    yield from (saved(**{name: value}) for name, value in zip(arrays, wrong, strict=True))
    yield from (saved(**{name: np.array(["text"])}) for name in arrays)
    yield from (
        saved(**{name: array.astype(np.complex128)})
        for name, array in arrays.items()
        if array.dtype.kind == "f"
    )
    yield from (
        saved(**{name: np.full(array.shape, np.iinfo(array.dtype).max)})
        for name, array in arrays.items()
        if array.dtype.kind in "iu"
    )
    yield from (saved(**{name: array[..., None]}) for name, array in arrays.items())
    yield from (zipped({f"{first}.npy": npy(header)}) for header in headers)
    yield from (
        zipped({f"{first}.npy": npy(headers[0], b"\x03\x00")}),
        zipped({f"{first}.npy": npy(b"", b"\x09\x00")}),
        zipped({"../../../x.npy": b"\x93NUMPY"}),
        zipped({"a/" * 1000 + ".npy": b""}),
        zipped({f"{k}.npy": npy(headers[7]) for k in range(3000)}),
        zipped({first: good, f"{first}.npy": good}, zipfile.ZIP_LZMA),
        good[:-40],
        good[:100] + good,
        good.replace(b"PK\x03\x04\x14\x00\x00\x00", b"PK\x03\x04\x14\x00\x01\x00"),
        good.replace(b"PK\x01\x02", b"PK\x01\x03", 1),
    )


def _log(good: bytes) -> list[bytes]:
    magic = b"\x89MCAP0\r\n"

    def record(kind: int, content: bytes) -> bytes:
        return struct.pack("<BQ", kind, len(content)) + content

    def chunk(name: bytes, size: int, data: bytes) -> bytes:
        head = struct.pack("<QQQII", 0, 1, size, 0, len(name)) + name
        return record(6, head + struct.pack("<Q", len(data)) + data)

    def text(value: bytes) -> bytes:
        return struct.pack("<I", len(value)) + value

    start = magic + record(1, text(b"") + text(b""))
    footer_at = len(good) - 8 - 20
    schema = record(
        3, struct.pack("<H", 1) + text(b"fcw.FrameResult") + text(b"protobuf") + struct.pack("<I", 0)
    )
    channel = record(
        4, struct.pack("<HH", 1, 1) + text(b"/fcw/result") + text(b"protobuf") + struct.pack("<I", 0)
    )
    message = record(5, struct.pack("<HIQQ", 1, 0, 2**64 - 1, 2**64 - 1) + b"\xff" * 50)
    nested = chunk(b"", 0, b"")
    for _ in range(200):
        nested = chunk(b"", len(nested), nested)
    return [
        start,
        start + record(1, text(b"") + text(b"")) * 10_000,
        start + schema + channel + message,
        start + channel + message,
        start + message * 1000,
        start + nested,
        start + chunk(b"lz4", 64 << 20, b"\x04\x22\x4d\x18" + bytes(50)),
        start + chunk(b"lz4", 100, b"\x04\x22\x4d\x18" + bytes(50)),
        start + chunk(b"x" * 100_000, 10, b""),
        start + chunk(b"zstd", 10, b"\x28\xb5\x2f\xfd\x00\x58" + bytes(10)),
        start + chunk(b"", 10, schema),
        start + struct.pack("<BQ", 6, 2**63) + bytes(100),
        start + struct.pack("<BQ", 9, 2**64 - 1) + bytes(100),
        start
        + record(9, struct.pack("<QQ", 0, 0) + text(b"../../x") + text(b"") + struct.pack("<QI", 2**62, 0)),
        start + record(12, text(b"fcw") + struct.pack("<I", 2**32 - 1)),
        start + record(200, bytes(1000)) * 1000,
        start + record(0, b"") * 100_000,
        good[:footer_at] + struct.pack("<QQI", 9, 9, 0) + magic,
        good[:footer_at] + struct.pack("<QQI", 2**63, 2**63, 0) + magic,
        good[:footer_at] + struct.pack("<QQI", footer_at, 0, 0) + magic,
        good[:-8] + good,
        good + good,
        good[: len(good) // 2] + good[8:],
        good.replace(b"zstd", b"lz4\0"),
        good.replace(b"protobuf", b"flatbuff"),
        good.replace(b"ros2msg", b"ros2idl"),
        good.replace(b"foxglove.", b"foxg\x1b[2J."),
        good.replace(b"rgb8", b"\x00\x00\x00\x00"),
        good.replace(b"rgb8", b"32FC"),
        good.replace(b"jpeg", b"tiff"),
        good.replace(b"encoding", b"encoded."),
        good.replace(b"nanos", b"names"),
        good.replace(b"/camera", b"/\xff\xfe\xfd\xfc\xfb\xfa"),
    ]


def _video(good: bytes) -> list[bytes]:
    def box(kind: bytes, content: bytes = b"") -> bytes:
        return struct.pack(">I", len(content) + 8) + kind + content

    head = box(b"ftyp", b"isom\0\0\2\0isom")
    deep = b""
    for _ in range(2000):
        deep = box(b"moov", deep)
    return [
        b"ffconcat version 1.0\nfile /etc/passwd\n",
        b"ffconcat version 1.0\nfile 'http://127.0.0.1:9/x.mp4'\n",
        b"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nfile:///etc/passwd\n#EXT-X-ENDLIST\n",
        b"v=0\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=video 5004 RTP/AVP 96\na=rtpmap:96 H264/90000\n",
        b"<MPD xmlns='urn:mpeg:dash:schema:mpd:2011'><Period><BaseURL>file:///etc/</BaseURL></Period></MPD>",
        b"[Script Info]\nScriptType: v4.00\n",
        b"RIFF" + struct.pack("<I", 2**32 - 1) + b"AVI LIST" + bytes(64),
        b"\x1a\x45\xdf\xa3\xff" + bytes(200),
        b"\x1a\x45\xdf\xa3\x01\xff\xff\xff\xff\xff\xff\xff" + bytes(200),
        b"\x47" + (b"\x47" + bytes(187)) * 2000,
        b"\0\0\1\xba" + bytes(5000),
        b"FLV\x01\x05\0\0\0\x09" + bytes(1000),
        b"OggS" + bytes(1000),
        b"\x00\x00\x00\x01\x67" + b"\xff" * 2000,
        b"GIF89a\xff\xff\xff\xff" + bytes(500),
        b"P6\n65535 65535\n255\n",
        b"#!/bin/sh\ntrue\n",
        head,
        head + deep,
        head + struct.pack(">I", 1) + b"moov" + struct.pack(">Q", 2**63),
        head + box(b"moov", box(b"mvhd", bytes(100)) + box(b"trak") * 20_000),
        good.replace(b"avc1", b"hev1"),
        good.replace(b"avc1", b"xxxx"),
        good.replace(b"vide", b"soun"),
        good.replace(b"stts", b"free", 1),
        good.replace(b"avcC", b"free"),
        good[: len(good) // 2],
        good[:-1000] + bytes(1000),
    ]


BY_NAME: dict[str, Callable[[bytes], Iterable[bytes]]] = {
    "1.png": _png,
    "1.jpg": _jpeg,
    "1.bmp": _bmp,
    "1.webp": _webp,
    "m.npz": _archive,
    "n.npz": _archive,
    "drive.mcap": _log,
    "others.mcap": _log,
    "raw.mcap": _log,
    "drive.mp4": _video,
}
