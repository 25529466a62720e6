"""Store of finished cases on disk: immutable shards, whose union is what is done.

A shard is a small netCDF file that holds the cases of one batch.  It is written aside, flushed to disk and renamed, and
its name is the hash of its content: a shard that was cut short or altered is detected, moved aside, and its cases run
again.  Shards do not know which study they belong to; cases are found by their keys.
"""

from __future__ import annotations

import hashlib
import logging
import os
import platform
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import StoreError
from ..files import keep, locked
from ..status import FIRST_UNFINISHED
from ..variables import INTEGERS
from ..version import PHYSICS_VERSION, __version__

_log = logging.getLogger(__name__)

KEY = 16  # bytes


@dataclass
class Finished:
    """Finished cases: their keys (n,), values by name (n,), and messages (n,)."""

    keys: np.ndarray = field(default_factory=lambda: np.zeros(0, f"S{KEY}"))
    values: dict[str, np.ndarray] = field(default_factory=dict)
    messages: np.ndarray = field(default_factory=lambda: np.zeros(0, object))

    def __len__(self) -> int:
        return len(self.keys)

    def rows(self, keys: np.ndarray) -> np.ndarray:
        """Row of each key, (n,); -1 where it is missing."""
        if not len(self):
            return np.full(len(keys), -1)
        at = np.searchsorted(self.keys, keys)
        at[at == len(self)] = 0
        return np.where(self.keys[at] == keys, at, -1)

    @property
    def status(self) -> np.ndarray:
        """Numbers of ``warpdamp.status.Status``, (n,)."""
        return self.values.get("status", np.zeros(0, np.int64))


class Store:
    """Store of shards in a folder.

    Parameters
    ----------
    folder : Path
        Made if it is not there.
    """

    def __init__(self, folder):
        self.folder = Path(folder)
        for name in ("shards", "runs", "logs"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)

    @classmethod
    def existing(cls, folder) -> Store:
        """Store in a folder, or the only one below it, or that of the first look (``--quick``) beside it.

        Raises
        ------
        StoreError
            If there is none, or several.
        """
        folder = Path(folder)
        if (folder / "shards").is_dir():
            return cls(folder)
        if (quick := folder.with_name(f"{folder.name}-quick") / "shards").is_dir() and folder.name:
            return cls(quick.parent)
        below = sorted(path.parent for path in folder.glob("*/shards"))
        if len(below) == 1:
            return cls(below[0])
        which = f"name one of {', '.join(map(str, below))}" if below else "give the folder that warpdamp run -o made"
        raise StoreError(f"{folder}: is not a folder of a sweep: {which}")

    def write(self, rows: list[tuple[bytes, dict]]) -> Path:
        """Write cases, given as (key, values), to one shard, whole or not at all; returns its path.

        Raises
        ------
        StoreError
            If it cannot be written, as on a full disk.
        """
        content = _packed(rows)
        path = self.folder / "shards" / _name(content)
        keep(path, content)
        return path

    def read(self, names: tuple[str, ...] | None = None, *, repair: bool = False) -> Finished:
        """Read the union of all shards; of a case with several rows, the one that got furthest.

        Parameters
        ----------
        names : values to read (default: all)
        repair : move damaged shards aside
        """
        parts = [_unpacked(content, names) for content in self._contents(repair)]
        if not parts:
            return Finished()
        columns = dict.fromkeys(name for part in parts for name in part.values)
        values = {
            name: np.concatenate([part.values.get(name, _missing(name, len(part))) for part in parts])
            for name in columns
        }
        union = Finished(
            np.concatenate([part.keys for part in parts]), values, np.concatenate([part.messages for part in parts])
        )
        return _each_once(union)

    @property
    def is_empty(self) -> bool:
        """Whether there are no shards."""
        return not any((self.folder / "shards").glob("*.nc"))

    def finished(self, *, repair: bool = False) -> np.ndarray:
        """Keys of the cases that ended by themselves, sorted; others are run again."""
        stored = self.read(("status",), repair=repair)
        return stored.keys[stored.status < FIRST_UNFINISHED]

    def _contents(self, repair: bool) -> Iterator[bytes]:
        for path in sorted((self.folder / "shards").glob("*.nc")):
            try:
                content = path.read_bytes()
            except FileNotFoundError:
                continue  # another process moved it aside
            if _name(content) == path.name:
                yield content
                continue
            where = "its cases count as not done"
            if repair:
                aside = self.folder / "damaged"
                aside.mkdir(exist_ok=True)
                os.replace(path, aside / path.name)
                where = f"moved to {aside}; its cases are run again"
            _log.warning("%s is damaged (its content is not what was written): %s", path, where)

    def remove_leftovers(self) -> None:
        """Remove temporary files of killed writers; only while no other run is in progress."""
        for path in [*self.folder.glob("*/.*.tmp"), *self.folder.glob(".*.tmp")]:
            path.unlink(missing_ok=True)

    @contextmanager
    def lock(self, part: tuple[int, int] | None):
        """Hold the folder, or one part of it, during a run.

        The system releases it when the process ends, however it ends.

        Raises
        ------
        StoreError
            If another run holds it.
        """
        with locked(self.folder / ".lock", shared=part is not None) as free:
            if not free:
                raise StoreError(self._held())
            if part is None:
                self.remove_leftovers()
                yield
                return
            with locked(self.folder / f".lock-{part[0]}-of-{part[1]}", shared=False) as free:
                if not free:
                    raise StoreError(self._held(f"part {part[0]}/{part[1]} of "))
                yield

    def _held(self, what: str = "") -> str:
        return (
            f"another run is in progress on {what}{self.folder} (see warpdamp status {self.folder}): wait, stop it, "
            "or share the work, each run with its own --part, as --part 1/2 and --part 2/2"
        )

    def in_use(self) -> bool:
        """Whether a run is in progress in the folder."""
        with locked(self.folder / ".lock", shared=False) as free:
            return not free


def _name(content: bytes) -> str:
    return f"{hashlib.sha256(content).hexdigest()[:32]}.nc"


def _missing(name: str, n: int) -> np.ndarray:
    return np.full(n, -1, np.int64) if name in INTEGERS else np.full(n, np.nan)


def _packed(rows: list[tuple[bytes, dict]]) -> bytes:
    """Content of a shard."""
    from netCDF4 import Dataset

    names = dict.fromkeys(name for _, values in rows for name in values if name != "message")
    file = Dataset("shard.nc", "w", memory=4096)
    file.createDimension("case", len(rows))
    file.createDimension("key", KEY)
    file.setncatts({"warpdamp": __version__, "physics": PHYSICS_VERSION, "written": f"{time.time():.3f}"})
    file.setncatts({"host": platform.node(), "process": os.getpid()})
    keys = np.frombuffer(b"".join(key.ljust(KEY, b"\0") for key, _ in rows), np.uint8).reshape(-1, KEY)
    file.createVariable("key", "u1", ("case", "key"))[:] = keys
    for name in names:
        whole = name in INTEGERS
        column = np.array([values.get(name, -1 if whole else np.nan) for _, values in rows])
        file.createVariable(name, "i8" if whole else "f8", ("case",))[:] = column
    messages = file.createVariable("message", str, ("case",))
    for k, (_, values) in enumerate(rows):
        messages[k] = values.get("message", "")
    return bytes(file.close())


def _unpacked(content: bytes, names) -> Finished:
    from netCDF4 import Dataset

    with Dataset("shard.nc", memory=content) as file:
        file.set_auto_mask(False)
        keys = np.ascontiguousarray(file["key"][:]).view(f"S{KEY}").ravel()
        stored = [name for name in file.variables if name not in ("key", "message")]
        values = {name: file[name][:] for name in stored if names is None or name in names}
        messages = np.full(len(keys), "", object)
        if names is None:
            messages[:] = file["message"][:]
    return Finished(keys, values, messages)


def _each_once(cases: Finished) -> Finished:
    """Cases sorted by key; of several with one key, the one that got furthest."""
    order = np.lexsort((cases.status, cases.keys))
    keys = cases.keys[order]
    first = np.concatenate([[True], keys[1:] != keys[:-1]])
    chosen = order[first]
    return Finished(cases.keys[chosen], {name: v[chosen] for name, v in cases.values.items()}, cases.messages[chosen])
