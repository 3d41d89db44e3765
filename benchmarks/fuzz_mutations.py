"""What may become of a file on its way: bits, lines, numbers and structure that its writer never wrote."""

from __future__ import annotations

import json
import random
import re
import struct
from collections.abc import Callable
from typing import Any

NUMBER = re.compile(rb"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?(?![\w.])")
QUOTED = re.compile(rb'"[^"\n]*"')
ENTRY = re.compile(rb"(?m)(?<== ).*$")

NUMBERS = (
    *("0", "-0.0", "-1", "1", "2", "0.5", "nan", "NaN", "inf", "-inf", "Infinity", "1e308", "-1e308", "1e11", "1e-320"),
    *("100000000000", "-3.7", "1.5", "9" * 30, "9" * 400, "9" * 5000, "0x" + "f" * 3000, "1e", "--1", "1_0", "1,5"),
)
"""Instead of a number."""

OTHERS = (
    *('""', '"x"', "true", "[]", "{}", "[1, 2]", "[[]]", "{a = 1}", '{"a": 1}', "null", "1979-05-27", "[nan]"),
    *('"\\u0000"', '"\\u001b[31m"', '"../../x"', '"/dev/zero"', '"' + "y" * 100_000 + '"', "[" * 2000 + "]" * 2000),
)
"""Instead of any value."""

STRANGE = (
    b"\x00",
    b"\xff",
    b"\xe9",
    b"\x1b[2J",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\r",
    b"\x85",
    b"\xe2\x80\xa8",
    b"\t\t",
)
"""Bytes that no sound text has there."""

LONGEST = 5_000_000
"""Of a file with a line many times over. [B]"""

WORDS = (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x10000000, 9, 0x00010000)
"""Instead of four bytes of a binary file: a count, a length, an offset."""

DOUBLES = (0.0, -1.0, float("nan"), float("inf"), 1e308, -1e308, 1e11, 1e-320, -0.5, 2.0)
"""Instead of eight bytes."""


def _flip(data: bytearray, rng: random.Random) -> bytearray:
    for _ in range(rng.choice((1, 1, 2, 8))):
        if data:
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return data


def _cut(data: bytearray, rng: random.Random) -> bytearray:
    return data[: rng.randrange(len(data) + 1)]


def _drop(data: bytearray, rng: random.Random) -> bytearray:
    start = rng.randrange(len(data) + 1)
    del data[start : start + rng.choice((1, 8, 64, 1000))]
    return data


def _again(data: bytearray, rng: random.Random) -> bytearray:
    start, size, at = rng.randrange(len(data) + 1), rng.choice((1, 8, 64, 1000)), rng.randrange(len(data) + 1)
    data[at:at] = data[start : start + size]
    return data


def _strange(data: bytearray, rng: random.Random) -> bytearray:
    at = rng.choice((0, rng.randrange(len(data) + 1)))
    data[at:at] = rng.choice(STRANGE)
    return data


def _word(data: bytearray, rng: random.Random) -> bytearray:
    at = rng.randrange(max(len(data) // 4, 1)) * 4
    if rng.random() < 0.5:  # most of what steers a reader stands at the beginning
        at = rng.randrange(max(min(len(data), 4096) // 4, 1)) * 4
    data[at : at + 4] = struct.pack(rng.choice((">I", "<I")), rng.choice(WORDS))
    return data


def _double(data: bytearray, rng: random.Random) -> bytearray:
    at = rng.randrange(max(len(data) // 4, 1)) * 4
    data[at : at + 8] = struct.pack(rng.choice((">d", "<d")), rng.choice(DOUBLES))
    return data


def _line(data: bytearray, rng: random.Random) -> bytearray:
    lines = data.split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(4):
        case 0:
            del lines[i]
        case 1:
            lines.insert(j, lines[i])
        case 2:
            lines[i], lines[j] = lines[j], lines[i]
        case _:
            lines[i] = lines[i] * min(rng.choice((2, 10_000)), LONGEST // max(len(lines[i]), 1) + 1)
    return bytearray(b"\n".join(lines)[:LONGEST])


def _ends(data: bytearray, rng: random.Random) -> bytearray:
    return bytearray(data.replace(b"\n", rng.choice((b"\r\n", b"\r", b"\n\n", b""))))


def _swapped(pattern: re.Pattern[bytes], instead: tuple[str, ...]) -> Callable[[bytearray, random.Random], bytearray]:
    def swap(data: bytearray, rng: random.Random) -> bytearray:
        found = list(pattern.finditer(data))
        if not found:
            return _flip(data, rng)
        one = rng.choice(found)
        data[one.start() : one.end()] = rng.choice(instead).encode()
        return data

    return swap


def _places(tree: Any) -> list[tuple[Any, Any]]:
    """Every entry of a tree of JSON, as its container and its key."""
    found = []
    for key in list(tree) if isinstance(tree, dict) else range(len(tree)) if isinstance(tree, list) else ():
        found += [(tree, key), *_places(tree[key])]
    return found


VALUES: tuple[Any, ...] = (
    *(0, -1, 1.5, 1e11, 10**11, 10**30, 1e308, float("nan"), float("inf"), True, None, "", "x", [], {}, [1], {"a": 1}),
    *("\x00", "\x1b[31m", "y" * 10_000, "../../x", "<script>", "=1+1", -0.0, 10**400, [[[[]]]]),
)


def _tree(data: bytearray, rng: random.Random) -> bytearray:
    """An entry of a JSON document, or of a line of one, is another, is gone, or has another name."""
    lines = [bytes(data)]
    try:
        tree = json.loads(lines[0])
    except (ValueError, RecursionError):
        lines = data.split(b"\n")
        at = rng.randrange(len(lines))
        try:
            tree = json.loads(lines[at])
        except (ValueError, RecursionError):
            return _swapped(NUMBER, NUMBERS)(data, rng)
    else:
        at = 0
    places = _places(tree)
    if not places:
        return _flip(data, rng)
    container, key = rng.choice(places)
    match rng.randrange(6):
        case 0:
            del container[key]
        case 1:
            other, name = rng.choice(places)
            container[key] = json.loads(json.dumps(other[name])) if name in other or isinstance(name, int) else 0
        case 2 if isinstance(container, dict):
            container[rng.choice(("", "x", "\x00", "__proto__", "y" * 1000))] = container.pop(key)
        case _:
            container[key] = rng.choice(VALUES)
    lines[at] = json.dumps(tree).encode()
    return bytearray(b"\n".join(lines))


BYTES = (_flip, _cut, _drop, _again, _strange)
TEXT = (*BYTES, _line, _ends, _swapped(ENTRY, (*NUMBERS, *OTHERS)), _swapped(QUOTED, OTHERS), _tree, _tree)
TEXT += (_swapped(NUMBER, NUMBERS),) * 4
BINARY = (*BYTES, _word, _word, _word, _double, _double)


def mutated(sound: bytes, rng: random.Random) -> bytes:
    """A file with one to three things wrong."""
    kinds = TEXT if sound[:3] not in (b"CDF", b"\x89HD", b"PK\x03") else BINARY
    data = bytearray(sound)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        data = rng.choice(kinds)(data, rng)
    return bytes(data)
