"""Damage to nested dictionaries, to text and to bytes; all drawn from one `random.Random`, to be repeated at will."""

from __future__ import annotations

import contextlib
import copy
import json
import math
from random import Random
from typing import Any

VALUES: list[Any] = [
    *(None, True, 0, -1, 1, 3, 1e-300, -1e300, math.inf, -math.inf, math.nan, 10**30, 10**5000),
    *("", " ", "1", "0.3 mm", "1e999 m", "-0 %", "1 furlong", "nan", "0x10", "plate", "1" * 300, "\x00", "a\nb"),
    *([], [[]], {}, {"": {}}, {"time": [], "value": []}, [1.0, 2.0], b"\xff", object()),
]
"""What a value is replaced by."""

NAMES = ["", "extra", "float", "plate", "Curve[K]", "function-wrap[x]", "__class__"]
"""Keys that are added: some are called like pydantic's own names for the branches of a union."""

TOKENS = [
    *("[", "]", "[[", "]]", "[[obstacles]]\n", "{", "}", "=", '"', '"""', "'", ",", "\n", "\r", "#", "\\", "\\u0000"),
    *("\\ud800", "\x00", "\ufeff", "nan", "-inf", "1e999", "0x" + "f" * 5000, "1" + "0" * 5000, "1979-05-27T07:32:00Z"),
    *("\nx = " + "[" * 3000, "\nx = " + "{a=" * 3000, "\nx = 0x" + "f" * 5000, "[" * 3000, "{a=" * 1000, "a." * 3000),
    *("true", "é", "٣"),
]
"""What is put into text: TOML's own signs, numbers beyond all bounds, depths beyond all stacks."""


def mutate_dictionary(data: dict, random: Random) -> dict:
    """A copy with one to four places replaced, removed, renamed, doubled or swapped."""
    data = copy.deepcopy(data)
    for _ in range(random.randint(1, 4)):
        places = list(_places(data))
        container, key = random.choice(places)
        if isinstance(container, dict) and key not in container:
            continue  # an earlier change took it away
        match random.randrange(6):
            case 0:
                container[key] = copy.deepcopy(random.choice(VALUES)) if random.random() < 0.9 else object()
            case 1:
                del container[key]
            case 2 if isinstance(container, dict):
                container[mutate_text(str(key), random)] = container.pop(key)
            case 3 if isinstance(container, dict):
                container[
                    random.choice(["", "extra", "float", "plate", "Curve[K]", "function-wrap[x]", "__class__"])
                ] = 1
            case 4:
                other, name = random.choice(places)
                with contextlib.suppress(LookupError):  # an earlier change took it away
                    container[key] = copy.deepcopy(other[name])
            case _:
                container[key] = [copy.deepcopy(container[key])] * random.choice([0, 1, 2, 3, 500])
    return data


def _places(data: Any):
    """(container, key) of everything inside nested dictionaries and lists."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        yield data, key
        if isinstance(value, (dict, list)):
            yield from _places(value)


def mutate_text(text: str, random: Random) -> str:
    """Text with one to four pieces inserted, removed, doubled or moved."""
    for _ in range(random.randint(1, 4)):
        start, end = _slice(len(text), random)
        piece = text[start:end]
        text = random.choice(
            [
                text[:start] + random.choice(TOKENS) + text[start:],
                text[:start] + random.choice(TOKENS) + text[end:],
                text[:start] + text[end:],
                text[:end] + piece + text[end:],
                text[:start]
                + chr(random.choice([random.randrange(128), random.randrange(0xD7FF)]))
                + text[start + 1 :],
                text[:start],
            ]
        )
    return text


def mutate_bytes(data: bytes, random: Random) -> bytes:
    """Bytes with one to four bits flipped, bytes replaced, pieces removed, doubled or cut off. Never the same bytes."""
    while True:
        damaged = bytearray(data)
        for _ in range(random.randint(1, 4)):
            start, end = _slice(len(damaged), random)
            match random.randrange(6):
                case 0 | 1 if start < len(damaged):
                    damaged[start] ^= 1 << random.randrange(8)
                case 2 if start < len(damaged):
                    damaged[start] = random.randrange(256)
                case 3:
                    del damaged[start:end]
                case 4:
                    damaged[end:end] = damaged[start:end] or random.randbytes(8)
                case _:
                    del damaged[start:]
        if damaged != data:
            return bytes(damaged)


def damaged_file(name: str, sound: bytes, random: Random) -> bytes:
    """Contents of a file, damaged so that they mean something else: JSON does not mind another blank."""
    while True:
        damaged = mutate_bytes(sound, random)
        if not name.endswith(".json"):
            return damaged
        try:
            if json.loads(damaged) != json.loads(sound):
                return damaged
        except (ValueError, RecursionError):
            return damaged


def _slice(length: int, random: Random) -> tuple[int, int]:
    start = random.randint(0, length)
    return start, min(length, start + random.choice([0, 1, 2, 8, 40, 400]))
