"""Files that are there whole or not at all, and locks that end with their holder."""

from __future__ import annotations

import os
import platform
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import StoreError


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path to write to, which replaces ``path`` once that has gone well: readers find the old file or the new one."""
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".writing-") as folder:
        part = Path(folder) / path.name
        yield part
        with open(part, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(part, path)


def keep(path: Path, content: bytes) -> None:
    """Write a file so that a reader finds all of it or nothing, and a power cut does not take it back.

    Raises
    ------
    StoreError
        If it cannot be written, as on a full disk; nothing is left of it then.
    """
    part = path.with_name(f".{path.name}.{platform.node()}-{os.getpid()}.tmp")
    try:
        with open(part, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
        _flush_folder(path.parent)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise StoreError(
            f"{path.parent} cannot be written: {error.strerror}; what is finished is kept: make room and run again"
        ) from None


def _flush_folder(folder: Path) -> None:
    if os.name == "nt":  # folders cannot be opened there
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def locked(path: Path, *, shared: bool = False, wait: bool = False):
    """Whether a lock on a file could be had; it is held meanwhile, and given up by the system when the process ends.

    Parameters
    ----------
    shared : with others that share it
    wait : for others to give it up
    """
    try:
        import fcntl
    except ImportError:  # Windows: what is done twice is the same twice
        yield True
        return
    kind = (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | (0 if wait else fcntl.LOCK_NB)
    with open(path, "a") as file:
        try:
            fcntl.flock(file, kind)
        except BlockingIOError:
            yield False
            return
        yield True
