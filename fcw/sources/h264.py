"""What must be known of an H.264 access unit before it is relayed: ITU-T H.264, clause 7.3 and Annex B."""

from dataclasses import dataclass

_START_CODE = b"\x00\x00\x01"
_SLICE, _IDR_SLICE, _SPS, _PPS = 1, 5, 7, 8
_B_SLICE = 1
_HEVC_PARAMETER_SETS = 32
"""The first NAL unit type of H.265 that is not a slice (ITU-T H.265, table 7-1)."""
_SLICE_HEADER_BYTES = 16
"""More than enough for the first two Exp-Golomb numbers of a slice header, of at most 32 bits each."""


@dataclass(frozen=True, slots=True)
class AccessUnit:
    """The properties of one encoded picture that decide whether it can be relayed.

    Attributes:
        idr: whether decoding can start at it.
        parameter_sets: whether it contains its own SPS and PPS.
        bidirectional: whether its first slice is a B slice.
    """

    idr: bool
    parameter_sets: bool
    bidirectional: bool


def inspect(annex_b: bytes) -> AccessUnit | None:
    """Read an access unit in Annex B form up to its first slice; None if it contains no slice."""
    kinds: set[int] = set()
    start = annex_b.find(_START_CODE)
    while start >= 0 and start + 3 < len(annex_b):
        header = start + 3
        kind = annex_b[header] & 0x1F
        if kind in (_SLICE, _IDR_SLICE):
            slice_type = _slice_type(annex_b[header + 1 : header + 1 + _SLICE_HEADER_BYTES])
            return AccessUnit(kind == _IDR_SLICE, {_SPS, _PPS} <= kinds, slice_type == _B_SLICE)
        kinds.add(kind)
        start = annex_b.find(_START_CODE, header)
    return None


def is_annex_b(data: bytes) -> bool:
    """Whether a packet begins with a start code, and not with a length as in an MP4 file."""
    return data.startswith((_START_CODE, b"\0" + _START_CODE))


def holds_picture(annex_b: bytes, codec: str) -> bool:
    """Whether a packet in Annex B form contains a slice of a picture; True for codecs unknown here."""
    if codec == "h264":
        return inspect(annex_b) is not None
    if codec != "hevc":
        return True
    start = annex_b.find(_START_CODE)
    while start >= 0 and start + 3 < len(annex_b):
        if annex_b[start + 3] >> 1 & 0x3F < _HEVC_PARAMETER_SETS:
            return True
        start = annex_b.find(_START_CODE, start + 3)
    return False


def _slice_type(slice_header: bytes) -> int:
    """`slice_type` modulo 5 (table 7-6), the second number after first_mb_in_slice."""
    bits = f"{int.from_bytes(slice_header):0{8 * len(slice_header)}b}"
    number, position = 0, 0
    for _ in range(2):
        zeros = bits.find("1", position) - position
        if zeros < 0:
            return _B_SLICE  # not readable: the careful answer, which stops relaying
        position += zeros
        number = int(bits[position : position + zeros + 1], 2) - 1
        position += zeros + 1
    return number % 5
