"""Small damage to files: what a bad disk, a bad program or a bad person does to them."""

import random

NASTY = [
    b"\x00", b"\xff\xfe", b"\xed\xa0\x80", b"\xef\xbb\xbf", b"'", b'"', b"\\", b"#", b":", b"- ", b"\t",
    b"\r",    b"nan", b"inf", b"-inf", b"1e999", b"-1e308", b"1e-320", b"-1", b"0", b"9" * 19, b"9" * 400,
    b"-" + b"9" * 5000, b"0x" + b"f" * 40, b"1:1:1:1", b"2024-13-45", b"null", b"~", b"true", b"{}", b"[]",
    b"[" * 2000, b"{" * 2000, b'{"a":' * 500, b"&a [*a]", b"*a", b"!!python/name:os.system", b"<<: *a",
    b"!!binary ////", b"\xc2\xb2", b"<!DOCTYPE a>", b"<a>" * 200, b"&b;", b",,,,", b"x" * 140_000, b"%s%n",
    b"../../etc/passwd", b"[/x]", b"\x1b[2J",
]  # fmt: skip
"""Texts that readers stumble over."""


def mutated(data: bytes, dice: random.Random) -> bytes:
    """The data with one to three damages."""
    for _ in range(dice.randint(1, 3)):
        data = dice.choice((_flip, _cut, _insert, _replace_word, _repeat, _drop, _swap_lines))(data, dice)
    return data


def _place(data: bytes, dice: random.Random) -> int:
    return dice.randrange(len(data) + 1)


def _flip(data: bytes, dice: random.Random) -> bytes:
    damaged = bytearray(data)
    for _ in range(dice.choice((1, 4, 64))):
        if damaged:
            damaged[dice.randrange(len(damaged))] = dice.randrange(256)
    return bytes(damaged)


def _cut(data: bytes, dice: random.Random) -> bytes:
    return data[: _place(data, dice)]


def _insert(data: bytes, dice: random.Random) -> bytes:
    at = _place(data, dice)
    return data[:at] + dice.choice(NASTY) + data[at:]


def _replace_word(data: bytes, dice: random.Random) -> bytes:
    """A word between separators becomes something else."""
    separators = b" ,:\n\"'[]{}()<>="
    places = [at for at, byte in enumerate(data[:50_000]) if byte in separators]
    if len(places) < 2:
        return _insert(data, dice)
    index = dice.randrange(len(places) - 1)
    return data[: places[index] + 1] + dice.choice(NASTY) + data[places[index + 1] :]


def _repeat(data: bytes, dice: random.Random) -> bytes:
    start, end = sorted((_place(data, dice), _place(data, dice)))
    return data[:end] + data[start:end][:100_000] * dice.randint(1, 5) + data[end:]


def _drop(data: bytes, dice: random.Random) -> bytes:
    start = _place(data, dice)
    return data[:start] + data[start + dice.choice((1, 4, 100)) :]


def _swap_lines(data: bytes, dice: random.Random) -> bytes:
    lines = data.split(b"\n")
    dice.shuffle(lines)
    return b"\n".join(lines)
