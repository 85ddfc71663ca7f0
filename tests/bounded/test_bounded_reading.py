"""Bounds on what others wrote: each is passed by a small file, and is said."""

import contextlib
import io
import json
import os
import struct
import zipfile
from pathlib import Path

import cv2
import lz4.frame
import numpy as np
import pytest
import yaml
import zstandard
from hypothesis import given
from hypothesis import strategies as st

from fcw.bounded import arrays
from fcw.bounded.arrays import npz_arrays
from fcw.bounded.files import MalformedError, read_bytes, read_text
from fcw.bounded.formats import MOST_YAML_BYTES, csv_rows, json_value, xml_root, yaml_value
from fcw.bounded.mcap_chunks import check_chunks
from fcw.bounded.pictures import decode_picture, picture_size
from fcw.errors import UserError

LAUGHS = "a: &a [1,1,1,1,1,1,1,1,1]\n" + "".join(
    f"{new}: &{new} [{','.join([f'*{old}'] * 9)}]\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[" * 100_000, "too deeply"),
        ("[" * 51 + "]" * 51, "too deeply"),
        ('{"a": ' * 400 + "1" + "}" * 400, "too deeply"),
        ("1" * 400, "400 digits"),
        ("1" * 5000, "5000 digits"),
        ("[" + "," * 12_000_001, "more than"),
        (r'"\ud800"', "incomplete character"),
        ("{", "Expecting"),
    ],
)
def test_json_that_would_grow_or_break_is_refused(text: str, why: str):
    with pytest.raises(MalformedError, match=why):
        json_value(text)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (LAUGHS, "anchors"),
        ("a: &a [*a]", "anchors"),
        ("[" * 51 + "]" * 51, "too deeply"),
        ("[" * 20_000, "too deeply"),
        ("a: " + "1" * 400, "400 digits"),
        ("a: 0x" + "f" * 50, "digits"),
        ("a: " + ":".join(["1"] * 5000), "digits"),
        ("a: 2024-13-45", "month"),
        ("a: !!int ''", "index out of range"),
        ("x" * (MOST_YAML_BYTES + 1), "larger"),
        ("a: !!python/object/apply:os.system [ls]", "could not determine a constructor"),
        ("? {a: 1}\n: 2", "unhashable"),
    ],
)
def test_yaml_that_would_grow_or_break_is_refused(text: str, why: str):
    with pytest.raises(MalformedError, match=why):
        yaml_value(text)


@given(
    st.recursive(
        st.none()
        | st.booleans()
        | st.integers(-(2**63) + 1, 2**63 - 1)
        | st.floats(allow_nan=False)
        | st.text(),
        lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
        max_leaves=20,
    )
)
def test_what_is_within_the_limits_is_read_as_usual(value: object):
    assert json_value(json.dumps(value)) == value


@given(st.text())
def test_any_text_raises_at_most_the_one_error(text: str):
    for read in (json_value, yaml_value, lambda text: list(csv_rows(text))):
        with contextlib.suppress(MalformedError):
            read(text)


def test_yaml_of_the_program_is_read_as_pyyaml_reads_it():
    text = (Path(__file__).parents[2] / "recordings" / "demo" / "drive.calibration.yaml").read_text()
    assert yaml_value(text) == yaml.safe_load(text)


def test_yaml_that_is_none_is_told_with_its_place_and_without_a_copy_of_the_line():
    with pytest.raises(
        MalformedError, match=r"^expected ',' or ']', but got '<stream end>', line 2, column 5$"
    ):
        yaml_value("a: [1,\nb: 2")
    with pytest.raises(MalformedError, match=r"^mapping values are not allowed here, line 2, column 9$"):
        yaml_value("height_m: 1.2\n  row_px: 7")


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b'<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "document type"),
        ('<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>'.encode("utf-16"), "document type"),
        (b"<a>" * 60, "too deeply"),
        (b'<?xml version="1.0" encoding="no-such"?><a/>', "unknown encoding"),
        (b'<?xml version="1.0" encoding="utf-7"?><a/>', "."),
        (b"<a>", "no element found"),
        (b"<a>" + b"<b/>" * 2_000_000 + b"</a>", "more than 2000000 tags"),
    ],
)
def test_xml_that_would_grow_or_break_is_refused(data: bytes, why: str):
    with pytest.raises(MalformedError, match=why):
        xml_root(data)


def test_a_csv_field_of_any_length_is_no_traceback():
    with pytest.raises(MalformedError, match="field larger"):
        list(csv_rows("a,b\n" + "x" * 140_000))
    assert list(csv_rows("a,b\n\n1, 2\n")) == [(1, ["a", "b"]), (3, ["1", "2"])]


@pytest.mark.skipif(os.name != "posix", reason="pipes are POSIX's")
def test_only_regular_files_of_a_size_are_read(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero")):
        with pytest.raises(MalformedError, match="not a regular file"):
            read_bytes(path, 10)
    (tmp_path / "file").write_bytes(b"\xef\xbb\xbfabc")
    assert read_text(tmp_path / "file") == "abc"
    with pytest.raises(MalformedError, match="larger than"):
        read_bytes(tmp_path / "file", 5)
    (tmp_path / "file").write_bytes(b"ab\xff")
    with pytest.raises(MalformedError, match="not UTF-8 at byte 2"):
        read_text(tmp_path / "file")


def npz(**members: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(f"{name}.npy", data)
    return buffer.getvalue()


def npy(array: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


@pytest.mark.slow
def test_archives_of_arrays_are_read_and_bombs_are_not_unpacked():
    array = np.arange(6, dtype=np.float32).reshape(2, 3)
    assert (npz_arrays(npz(a=npy(array)))["a"] == array).all()
    bomb = npz(a=npy(np.zeros(65 << 20, np.float32)))
    assert len(bomb) < 1 << 20
    with pytest.raises(MalformedError, match="unpacks to more than 256 MB"):
        npz_arrays(bomb)
    huge = npy(array).replace(b"(2, 3)", b"(2, 9)")
    with pytest.raises(MalformedError, match="does not have the length"):
        npz_arrays(npz(a=huge))
    with pytest.raises(MalformedError, match="Python objects"):
        npz_arrays(npz(a=npy(np.array([{}], object))))
    for data in (b"", b"PK\x03\x04", npy(array), npz(a=b"no array")):
        with pytest.raises(MalformedError, match="not an archive of arrays"):
            npz_arrays(data)


@pytest.mark.parametrize(
    "array",
    [
        np.arange(6, dtype=np.float32).reshape(2, 3),
        np.frombuffer(b"look", np.uint8),
        np.array(2.5),
        np.zeros((0,)),
    ],
)
def test_reading_an_ordinary_array_leaves_the_filters_of_warnings_to_other_threads(
    array: np.ndarray, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(arrays, "warnings", None)  # whoever asks it for anything fails
    assert np.array_equal(npz_arrays(npz(a=npy(array)))["a"], array)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp", ".webp"])
def test_a_picture_states_its_size_and_one_that_states_another_is_not_decoded(suffix: str):
    image = np.random.default_rng(1).integers(0, 256, (48, 64, 3), np.uint8)
    data = cv2.imencode(suffix, image)[1].tobytes()
    assert picture_size(data) == (64, 48)
    decoded = decode_picture(data)
    assert decoded is not None
    assert decoded.shape == (48, 64, 3)
    for end in range(40):
        decode_picture(data[:end])


def test_a_png_whose_part_states_more_than_there_is_is_not_decoded():
    png = cv2.imencode(".png", np.zeros((48, 64, 3), np.uint8))[1].tobytes()
    at = png.index(b"IDAT") - 4
    longer = png[:at] + struct.pack(">I", 0xAC002000) + png[at + 4 :]
    assert decode_picture(longer) is None
    assert decode_picture(png + b"what a camera adds") is not None


def test_a_picture_that_states_a_huge_size_is_not_decoded():
    png = bytearray(cv2.imencode(".png", np.zeros((4, 4, 3), np.uint8))[1].tobytes())
    png[16:24] = struct.pack(">II", 100_000, 100_000)
    bmp = bytearray(cv2.imencode(".bmp", np.zeros((4, 4, 3), np.uint8))[1].tobytes())
    bmp[18:26] = struct.pack("<ii", 100_000, -100_000)
    for data in (png, bmp, b"GIF89a\xff\xff\xff\xff", b""):
        assert decode_picture(bytes(data)) is None


MCAP_MAGIC = b"\x89MCAP0\r\n"


def mcap_chunk(stated: int, frame: bytes, name: bytes = b"zstd") -> bytes:
    content = struct.pack("<QQQII", 0, 1, stated, 0, len(name)) + name + struct.pack("<Q", len(frame)) + frame
    return struct.pack("<BQ", 6, len(content)) + content


def test_a_chunk_that_unpacks_to_much_is_named_before_it_is_unpacked(tmp_path: Path):
    bombs = [
        mcap_chunk(10, zstandard.compress(bytes(257 << 20))),
        mcap_chunk(1 << 40, b"", b"lz4"),
        *(
            mcap_chunk(10, lz4.frame.compress(bytes(257 << 20), **options), b"lz4")
            for options in ({"store_size": False}, {"block_size": 7, "block_checksum": True})
        ),
    ]
    path = tmp_path / "drive.mcap"
    for data in bombs:
        with pytest.raises(UserError, match="chunk at byte 8 unpacks to more than 256 MB"):
            check_chunks(path, io.BytesIO(MCAP_MAGIC + data))
    for data in (mcap_chunk(1000, zstandard.compress(bytes(1000))), b"", b"\x06\xff"):
        check_chunks(path, io.BytesIO(MCAP_MAGIC + data))


@pytest.mark.parametrize("block_size", [4, 7])
@pytest.mark.parametrize("content", [bytes(200 << 20), os.urandom(5 << 20)], ids=["packed", "stored"])
def test_an_lz4_chunk_is_taken_for_no_more_than_a_block_above_what_it_holds(content: bytes, block_size: int):
    frame = lz4.frame.compress(content, block_size=block_size)
    check_chunks(Path("drive.mcap"), io.BytesIO(MCAP_MAGIC + mcap_chunk(len(content), frame, b"lz4")))


def test_chunks_that_are_each_within_the_bound_may_not_unpack_to_much_together():
    chunk = mcap_chunk(250 << 20, zstandard.compress(bytes(250 << 20)))
    check_chunks(Path("drive.mcap"), io.BytesIO(MCAP_MAGIC + chunk * 4))
    with pytest.raises(UserError, match=r"drive.mcap: its \d+ kB unpack to 1250 MB"):
        check_chunks(Path("drive.mcap"), io.BytesIO(MCAP_MAGIC + chunk * 5))
    real = mcap_chunk(250 << 20, os.urandom(3 << 20))  # 83 times: however long, it opens
    check_chunks(Path("drive.mcap"), io.BytesIO(MCAP_MAGIC + real * 5))


def mcap_record(opcode: int, content: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(content)) + content


def mcap_footer(summary_start: int) -> bytes:
    return mcap_record(2, struct.pack("<QQI", summary_start, 0, 0)) + MCAP_MAGIC


@pytest.mark.parametrize("leader", ["chunk index", "attachment index", "metadata index", "summary"])
def test_a_chunk_inside_an_attachment_is_looked_at_where_an_index_leads_there(leader: str):
    # Attachment: log and create time, name and media type, data with its length, checksum.
    head = struct.pack("<QQIIQ", 0, 0, 0, 0, 0)
    hidden_at = len(MCAP_MAGIC) + 9 + len(head)

    def hiding(chunk: bytes) -> io.BytesIO:
        attachment = mcap_record(9, head + chunk + bytes(4))
        start = len(MCAP_MAGIC) + len(attachment)
        if leader == "summary":
            return io.BytesIO(MCAP_MAGIC + attachment + mcap_footer(hidden_at))
        index = {
            "chunk index": mcap_record(8, struct.pack("<QQQQ", 0, 1, hidden_at, len(chunk)) + bytes(32)),
            "attachment index": mcap_record(0x0A, struct.pack("<QQ", hidden_at, len(chunk)) + bytes(32)),
            "metadata index": mcap_record(0x0D, struct.pack("<QQ", hidden_at, len(chunk)) + bytes(4)),
        }[leader]
        return io.BytesIO(MCAP_MAGIC + attachment + index + mcap_footer(start))

    with pytest.raises(UserError, match=f"chunk at byte {hidden_at} unpacks to more than 256 MB"):
        check_chunks(Path("drive.mcap"), hiding(mcap_chunk(10, zstandard.compress(bytes(257 << 20)))))
    check_chunks(Path("drive.mcap"), hiding(mcap_chunk(1000, zstandard.compress(bytes(1000)))))
