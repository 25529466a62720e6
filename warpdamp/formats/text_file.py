"""Text of files in any of the usual encodings.

UTF-8, UTF-16 and UTF-32 by their byte order marks, UTF-16 without one, otherwise Windows-1252.
"""

from __future__ import annotations

import codecs
from pathlib import Path

from ..errors import UsageError

MARKS = (  # that of UTF-32 begins with that of UTF-16
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


class TableError(UsageError):
    """A text file or table that cannot be read: the file, the line and the remedy."""


def read_text(file: Path) -> str:
    """Text of a file in any of the usual encodings.

    Raises
    ------
    TableError
        If there is no such file, it cannot be read, or it holds no text.
    """
    try:
        content = Path(file).read_bytes()
    except FileNotFoundError:
        raise TableError(f"there is no file {file}") from None
    except OSError as error:
        raise TableError(f"{file}: cannot be read: {error.strerror or error}") from None
    return decode(content, file)


def decode(content: bytes, file) -> str:
    """Text of some bytes: by their mark, else UTF-8, UTF-16 where every other byte is zero, Windows-1252.

    Raises
    ------
    TableError
        If they are none of these.
    """
    for encoding in _encodings(content):
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    known = "UTF-8, UTF-16 nor Windows-1252"
    raise TableError(f"{file}:{_undecodable_line(content)}: is neither {known} text: save the file as UTF-8 text")


def _encodings(content: bytes) -> tuple[str, ...]:
    for mark, encoding in MARKS:
        if content.startswith(mark):
            return (encoding,)
    start = content[:400]
    if start and start[1::2].count(0) > 0.4 * len(start[1::2]) and start[::2].count(0) == 0:
        return ("utf-16-le",)
    if start and start[::2].count(0) > 0.4 * len(start[::2]) and start[1::2].count(0) == 0:
        return ("utf-16-be",)
    return ("utf-8", "cp1252")


def _undecodable_line(content: bytes) -> int:
    """The line with the first byte that neither UTF-8 nor Windows-1252 text has."""
    unknown = b"\0\x81\x8d\x8f\x90\x9d"
    first = min((at for at in map(content.find, (bytes([byte]) for byte in unknown)) if at >= 0), default=0)
    return content.count(b"\n", 0, first) + 1
