"""Crafted labels, truth and people's words by the name of their format in `readers.py`."""

import json
from collections.abc import Callable, Iterable


def _labels(good: bytes) -> list[bytes]:
    def changed(change: Callable[[dict], object]) -> bytes:
        document = json.loads(good)
        change(document)
        return json.dumps(document).encode()

    def image(**fields: object) -> bytes:
        return changed(lambda document: document["images"][0].update(fields))

    def annotation(**fields: object) -> bytes:
        return changed(lambda document: document["annotations"][0].update(fields))

    names = [
        "",
        ".",
        "..",
        "/etc/passwd",
        "\u0000",
        "a\u0000b",
        "a\nb",
        "//host/share/1.jpg",
        "1.jpg/",
        "é" * 300,
        None,
        1,
    ]
    boxes = [[], [1, 2, 3], [1, 2, 3, 4, 5], [1, 2, -3, -4], [1, 2, 0, 0], ["1", "2", "3", "4"], [None] * 4]
    boxes += [[1e308, 1e308, 1e308, 1e308], [True] * 4, {"x": 1}, "1 2 3 4", [[1, 2, 3, 4]], [1e-320] * 4]
    return [
        *(image(file_name=name) for name in names),
        *(image(id=value) for value in ([], {}, None, "a", 1.5, -1, 2**62)),
        *(image(width=value, height=value) for value in (0, -1, 10**9, "64", 1.5, None)),
        *(image(fps=value) for value in (0, -1, "x", 1e308)),
        *(image(frame=value) for value in (-1, 1.5, "0", 2**62)),
        *(image(clip=value) for value in ("", "..", "../..", "\u0000", 5, [], "a" * 300)),
        *(annotation(bbox=box) for box in boxes),
        *(annotation(rear_box=box) for box in boxes),
        *(annotation(image_id=value) for value in ([], {}, 99, None, "0")),
        *(annotation(category_id=value) for value in ([], {}, 99, None, "car", 1e300)),
        *(annotation(ignore=value) for value in ("yes", 2, None, [])),
        annotation(track_id=[]),
        annotation(occluded={"a": 1}),
        annotation(distance_m="far"),
        changed(lambda document: document.update(categories=[{"id": [], "name": {}}])),
        changed(lambda document: document.update(categories="cars")),
        changed(lambda document: document.update(categories=[{"id": 1, "name": "\ud800"}])),
        changed(lambda document: document.update(images={})),
        changed(lambda document: document.update(images=[1, None, "a"])),
        changed(lambda document: document.update(annotations=[1, None, "a"])),
        changed(lambda document: document["images"].extend(document["images"])),
        changed(lambda document: document.update(images=[])),
        changed(lambda document: document.pop("annotations")),
    ]


def _kitti(good: bytes) -> list[bytes]:
    line = good.splitlines()[0]
    words = line.split()
    changed = [
        b" ".join([*words[:at], value, *words[at + 1 :]]) for at in range(17) for value in (b"nan", b"-1e308")
    ]
    return [
        *(one + b"\n" + good for one in changed),
        good.replace(b"1 Car", b"-1 Car"),
        good.replace(b"1 Car", b"1.5 Car"),
        good.replace(b"Car", b"\xff"),
        good.replace(b"Car", b"[/x]"),
        good.replace(b"20.0", b"0"),
        good.replace(b"20.0", b"-20"),
        good.replace(b"560 230", b"500 180"),
        line + b" 1 2 3\n",
        b" ".join(words[:5]),
        good * 3,
        b"0 1 Car\n" * 200_000,
    ]


def _poses(good: bytes) -> list[bytes]:
    return [
        good.replace(b"1 0 0 0", b"nan 0 0 0"),
        good.replace(b"1 0 0 0", b"0 0 0 0"),
        good.replace(b"1 0 0 0", b"1e308 0 0 1e308"),
        good.replace(b" 0", b""),
        b"1\n" * 5,
        good.replace(b" ", b","),
        b"0 " * 12 + b"\n",
        (b"0 " * 12 + b"\n") * 100_000,
    ]


def _table(good: bytes) -> list[bytes]:
    changes = [
        (b"1280x720", b"1280"),
        (b"1280x720", b"0x0"),
        (b"1280x720", b"1280x720x3"),
        (b"1280x720", b"1e3x1e3"),
        (b"1.3", b"nan"),
        (b"1.3", b"-1.3"),
        (b"6:640", b"6:640:1:2"),
        (b"6:640", b"6"),
        (b"6:640", b"0:640"),
        (b"6:640", b"nan:nan"),
        (b"15:520 30:480", b""),
        (b"clip", b"../../x"),
        (b"clip", b"\x00"),
    ]
    return [*(good.replace(old, new) for old, new in changes), good * 2, b"clip\n", b"#\n"]


def _times(_good: bytes) -> list[bytes]:
    lines = [
        b"0.1\n0.0",
        b"0\n0",
        b"-1\n0",
        b"nan\n1",
        b"0",
        b"0\n1\n2",
        b"1e3\n2e3",
        b"0,0\n0,1",
        b"0x1\n0x2",
    ]
    lines += [b"2011-09-26 13:02:25\n2011-09-26 13:02:24", b"2011-02-30 13:02:25\n2011-03-01 13:02:25"]
    lines += [
        b"0001-01-01 00:00:00\n9999-12-31 23:59:59",
        b"2011-09-26 25:61:61\n1",
        b"0\n2011-09-26 13:02:25",
    ]
    lines += [
        "٠.٠\n٠.١".encode(),
        b"0.0\n9223372036.9",
        b"0\x0c0\n1",
        b"\xe2\x80\xa80\n1",
        b"0\n0.0000000001",
    ]
    return lines


def _truth(good: bytes) -> list[bytes]:
    head, *rows = good.splitlines()
    cells = rows[0].split(b",")
    changed = [
        b",".join([*cells[:at], value, *cells[at + 1 :]])
        for at in range(len(cells))
        for value in (b"nan", b"x", b"")
    ]
    return [
        *(b"\n".join([head, one, *rows[1:]]) for one in changed),
        head,
        b"\n".join([head, *rows[::-1]]),
        b"\n".join([head, *rows * 2]),
        good.replace(b",", b";"),
        head.upper() + b"\n" + b"\n".join(rows),
    ]


def _review(good: bytes) -> list[bytes]:
    head, entry = good.splitlines()
    fields = json.loads(entry)

    def entries(*changes: dict[str, object]) -> bytes:
        return b"\n".join([head, *(json.dumps(fields | change).encode() for change in changes)]) + b"\n"

    def taken_back(one: str, other: str) -> dict[str, object]:
        return {"id": one, "said": "TakenBack", "entry_id": other, "text": None, "time_s": None}

    def bare(change: dict[str, object]) -> bytes:
        return json.dumps({k: v for k, v in (fields | change).items() if v is not None}).encode()

    chain = [bare(taken_back(str(k), str(k - 1))) for k in range(2, 6000)]
    return [
        *(entries({"id": value}) for value in (1, None, "", "\u0000", "a" * 100_000)),
        *(
            entries({"time": value})
            for value in ("99999-01-01T00:00:00.000000Z", "x", 5, None, "9999-12-31T23:59:59.999999Z")
        ),
        *(entries({"person": value}) for value in ("", "\u001b[2J", 5, "bob", "a" * 5000)),
        *(entries({"said": value}) for value in ("Nothing", None, 5, "__class__", "BoxEdit")),
        *(entries({"time_s": value}) for value in (float("nan"), float("inf"), -1, "1", True, 1e308)),
        *(entries({"text": value}) for value in ("<script>alert(1)</script>", "\u202e", "x" * 1_000_000, 5)),
        entries({}, {}, {}),
        b"\n".join([head, bare(taken_back("1", "1"))]) + b"\n",
        b"\n".join([head, bare(taken_back("1", "2")), bare(taken_back("2", "1"))]) + b"\n",
        b"\n".join([head, entry, *chain]) + b"\n",
        head + b"\n" + head + b"\n" + entry + b"\n",
        head.replace(b"1,", b"99,") + b"\n" + entry + b"\n",
        head.replace(b'"x"', b"5") + b"\n" + entry + b"\n",
        entry + b"\n" + head + b"\n",
        head + b"\n" + (entry + b"\n") * 20_000,
    ]


def _journal(good: bytes) -> list[bytes]:
    head = json.loads(good)

    def lines(*values: object, start: object = None) -> bytes:
        first = head if start is None else head | {"start": start}
        return b"".join(json.dumps(one).encode() + b"\n" for one in (first, *values))

    person = {"time": "2026-01-01T00:00:00", "person": "a"}
    return [
        lines({"undo": True} | person),
        lines(*[{"undo": True} | person] * 5000),
        lines({"redo": True} | person),
        lines({"edits": []} | person),
        lines({"edits": [{"edit": "AddPoint", "distance_m": 1e308, "row_px": -1e308}]} | person),
        lines({"edits": [{"edit": "DeletePoint", "point_id": 99}]} | person),
        lines({"edits": [[]] * 1000} | person),
        lines({"saved": 5}),
        lines({"page": "javascript:alert(1)"}),
        lines({"page": [1]}),
        lines(start={}),
        lines(start=[]),
        lines(start={"image_size": {"width": 0, "height": 0}}),
        json.dumps(head | {"fcw_calibration_journal_version": True}).encode() + b"\n",
        json.dumps(head | {"fcw_calibration_journal_version": 1.0}).encode() + b"\n",
    ]


BY_NAME: dict[str, Callable[[bytes], Iterable[bytes]]] = {
    "labels.json": _labels,
    "0000.txt": _kitti,
    "poses.txt": _poses,
    "calibrations.txt": _table,
    "truth.csv": _truth,
    "timestamps.txt": _times,
    "drive.review.anna.jsonl": _review,
    "j.calibration.work.jsonl": _journal,
}
