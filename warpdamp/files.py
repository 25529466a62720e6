"""Files written whole or not at all, locks that end with their holder, and the folder of caches."""

from __future__ import annotations

import os
import platform
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import platformdirs

from .errors import StoreError, UsageError


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Temporary path that replaces ``path`` once writing has succeeded: readers find the old file or the new one."""
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
            f"{path.parent} cannot be written: {error.strerror}; finished cases are stored: free space and run again"
        ) from None


@contextmanager
def netcdf_errors(path: Path) -> Iterator[None]:
    """Context in which what a library of netCDF raises on a file becomes a ``UsageError``."""
    try:
        yield
    except FileNotFoundError:
        raise UsageError(f"there is no file {path}") from None
    except (ValueError, OSError, RuntimeError, AttributeError):  # not netCDF at all, cut off, damaged inside
        raise UsageError(f"{path}: is no netCDF file, or a damaged one") from None


def _flush_folder(folder: Path) -> None:
    if os.name == "nt":  # folders cannot be opened there
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def locked(path: Path, *, shared: bool = False, wait: bool = False) -> Iterator[bool]:
    """Lock on a file, held in this context; yields whether it was obtained.  The system frees it with the process.

    Parameters
    ----------
    path : Path
        A file for the lock alone.
    shared : bool
        With others that share it.
    wait : bool
        For others to release it.
    """
    from filelock import ReadWriteLock, Timeout  # imports asyncio: half the time that reading a configuration takes

    lock = ReadWriteLock(path, is_singleton=False)
    try:
        (lock.acquire_read if shared else lock.acquire_write)(blocking=wait)
    except Timeout:
        yield False
        return
    try:
        yield True
    finally:
        lock.release()
        lock.close()


def cache_path(kind: str) -> Path:
    """Path of a folder of the cache: in ``$WARPDAMP_CACHE``, or in the user's cache folder."""
    return Path(os.environ.get("WARPDAMP_CACHE") or platformdirs.user_cache_path("warpdamp")) / kind


def cache_folder(kind: str) -> Path:
    """Folder of files that can be made again: in ``$WARPDAMP_CACHE``, or in the user's cache folder.

    Parameters
    ----------
    kind : str
        ``beds``, ``kernels``, or another name of a folder in it.

    Raises
    ------
    StoreError
        If the folder cannot be written; names the variable that moves it.
    """
    folder = cache_path(kind)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        usable = os.access(folder, os.W_OK | os.X_OK)
    except OSError:
        usable = False
    if not usable:
        raise StoreError(
            f"{folder}: this folder of the cache cannot be written: set WARPDAMP_CACHE to a folder that can (beds, "
            "compiled kernels and measured speeds are kept in it)"
        )
    return folder
