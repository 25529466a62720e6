"""Damages of files: every one follows from a random generator, so that any of a long series can be made again."""

from __future__ import annotations

import numpy as np

PIECES = (
    "", " ", ",", ";", "\t", "\n", "\r", "\r\n", "\0", "\ufeff", "é", "\u00a0", "-", "-1", "    -1\n", "0", "1.5", "1e400", "1e-320",
    "nan", "inf", "1e", "D+00", "9" * 20, "9" * 30, "9" * 400, "1 1/4", "7 800", "0,52", "in", "mm", "kg", "N", "dB", "rad/s", "(m/s",
    "^99", "/0", "%", "#", "$", "*", "[", "{", "'", '"', ":", "- ", "&a", "*a", "!!", "Re", "Phase", "    55\n", "    58", "   164",
    "    58b     1     2          11        9999", "*" * 200, "(" * 200,
)  # fmt: skip
"""What a damaged file may hold: marks, numbers and units out of place, heads of datasets, ends of lines."""
STRETCHES = (0, 1, 2, 10, 13, 81, 400, 100000)
"""Lengths that are lost, doubled or moved; 13 is a field of a universal file, 81 a line."""


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """Bytes with one to four damages."""
    for _ in range(int(rng.choice([1, 1, 1, 2, 4]))):
        content = DAMAGES[int(rng.integers(len(DAMAGES)))](content, rng) if content else b"1"
    return content


def _stretch(content: bytes, rng) -> tuple[bytes, bytes, bytes]:
    """What stands before a stretch, the stretch, and what stands behind it."""
    start = int(rng.integers(len(content)))
    stop = start + int(rng.choice(STRETCHES))
    return content[:start], content[start:stop], content[stop:]


def _cut(content, rng):
    before, _, behind = _stretch(content, rng)
    return before + behind


def _end(content, rng):
    return _stretch(content, rng)[0]


def _double(content, rng):
    before, part, behind = _stretch(content, rng)
    return before + part + part[:400] + behind


def _move(content, rng):
    before, part, behind = _stretch(content, rng)
    to = int(rng.integers(len(before) + 1))
    return before[:to] + part + before[to:] + behind


def _noise(content, rng):
    before, part, behind = _stretch(content, rng)
    return before + rng.bytes(min(len(part), 80)) + behind


def _insert(content, rng):
    before, part, behind = _stretch(content, rng)
    return before + _piece(rng) + part + behind


def _overwrite(content, rng):
    before, part, behind = _stretch(content, rng)
    piece = _piece(rng)
    return before + piece + (part + behind)[len(piece) :]


def _digit(content, rng):
    """Another digit, sign or blank in place of a digit nearby."""
    at = int(rng.integers(len(content)))
    near = range(max(0, at - 200), min(len(content), at + 200))
    digits = [place for place in near if content[place : place + 1].isdigit()]
    if not digits:
        return _insert(content, rng)
    place = int(rng.choice(digits))
    return content[:place] + b"0123456789- "[(k := int(rng.integers(12))) : k + 1] + content[place + 1 :]


def _line(content, rng):
    """A line replaced, exchanged with another, or doubled somewhere else."""
    lines = content.split(b"\n")
    j, k = (int(n) for n in rng.integers(len(lines), size=2))
    match int(rng.integers(3)):
        case 0:
            lines[j] = _piece(rng)
        case 1:
            lines[j], lines[k] = lines[k], lines[j]
        case _:
            lines[j:j] = [lines[k]]
    return b"\n".join(lines)


def _field(content, rng):
    lines = content.split(b"\n")
    j = int(rng.integers(len(lines)))
    fields = lines[j].split(b" ")
    fields[int(rng.integers(len(fields)))] = _piece(rng)
    lines[j] = b" ".join(fields)
    return b"\n".join(lines)


def _piece(rng) -> bytes:
    return str(rng.choice(PIECES)).encode("utf-8" if rng.random() < 0.7 else "utf-16")


DAMAGES = (_cut, _end, _double, _move, _noise, _insert, _overwrite, *[_digit] * 6, _line, _field)
"""Digits count six times: a wrong number in a file that stays readable goes deepest."""
