"""Executors: this process, processes of this machine, a Dask cluster, or any ``concurrent.futures.Executor``.

All are a ``concurrent.futures.Executor`` behind a ``WorkerPool``, which knows how many calls it can take at a time, and
how to go on when a worker has died or hangs.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context

from ..errors import ExecutorError, MissingLibrary

ANSWERS_WITHIN = 15.0
"""Seconds within which a Dask scheduler must answer."""

COMES_BACK_WITHIN = 120.0
"""Seconds within which a Dask cluster must have its first new worker after a restart."""

LOCAL_DASK = {"distributed.scheduler.allowed-failures": 0, "distributed.deploy.lost-worker-timeout": "1 day"}
"""Dask options of a cluster started here.  This program retries what was lost with a worker, so Dask must not; and a
worker that is being restarted must not be abandoned because another restart came 15 s before."""


class WorkerPool:
    """Executor given by the user, with ``size`` calls at a time; workers that die or hang cannot be replaced."""

    def __init__(self, executor: Executor, size: int):
        self.executor, self.size = executor, size

    def submit(self, call, *arguments) -> Future:
        """Submit a call; returns its future."""
        return self.executor.submit(call, *arguments)

    def restart(self, *, hanging: bool) -> bool:
        """Recover after a death or, if ``hanging``, stop all calls; returns whether calls in progress are lost.

        Raises
        ------
        ExecutorError
            If that cannot be done from here.
        """
        if hanging or getattr(self.executor, "_broken", False):
            what = "a job is over its limit of time" if hanging else "a worker died"
            raise ExecutorError(
                f"{what}, and an executor that was passed in cannot be repaired: finished cases are stored: start again"
            )
        return False

    def stop(self) -> None:
        """Cancel what is not finished."""
        self.executor.shutdown(wait=False, cancel_futures=True)


class InProcess(Executor):
    """Executor that makes calls at once, in this process."""

    def submit(self, call, /, *arguments, **options) -> Future:
        """Make the call; the returned future is finished."""
        future: Future = Future()
        try:
            future.set_result(call(*arguments, **options))
        except Exception as error:
            future.set_exception(error)
        return future


class Processes(WorkerPool):
    """Pool of fresh processes of this machine; it is replaced when one dies or hangs."""

    def __init__(self, workers: int | None):
        self.size = workers or os.cpu_count() or 1
        self._start()

    def _start(self) -> None:
        # Warp does not promise that its runtime survives a fork
        self.executor = ProcessPoolExecutor(self.size, mp_context=get_context("spawn"), initializer=_follow_parent)

    def start(self, call) -> None:
        """Start all processes with a call each that nobody waits for."""
        for _ in range(self.size):
            self.executor.submit(call)

    def restart(self, *, hanging: bool) -> bool:
        """Replace the pool; calls in progress are lost."""
        self.stop()
        self._start()
        return True

    def stop(self) -> None:
        """Kill the processes."""
        processes = list((getattr(self.executor, "_processes", None) or {}).values())
        for process in processes:
            process.kill()
        self.executor.shutdown(wait=True, cancel_futures=True)


class Cluster(WorkerPool):
    """Pool of the workers of a Dask cluster.  Dask itself sends the work of a dead worker to another."""

    def __init__(self, client):
        self._client = client
        self.executor = client.get_executor(pure=False)

    @property
    def size(self) -> int:
        """Number of workers at the moment, one call each."""
        return max(1, len(self._client.scheduler_info(n_workers=-1)["workers"]))

    def restart(self, *, hanging: bool) -> bool:
        """Restart the workers if one hangs; after a death Dask has done what is needed.

        Raises
        ------
        ExecutorError
            If no worker comes back.
        """
        if hanging:
            self._client.restart(wait_for_workers=False)
            try:
                self._client.wait_for_workers(1, timeout=COMES_BACK_WITHIN)
            except TimeoutError:
                raise ExecutorError(
                    "a job was over its limit of time, and no Dask worker came back within "
                    f"{COMES_BACK_WITHIN:.0f} s of a restart: finished cases are stored: start again"
                ) from None
        return hanging


@contextmanager
def worker_pool(kind: str | Executor, workers: int | None) -> Iterator[WorkerPool]:
    """Pool of workers, stopped at the end of the context.

    Parameters
    ----------
    kind : "processes", "in-process", "dask" (a cluster started here), the address of a Dask scheduler, or an Executor
    workers : how many (default: the cores of this machine; of a scheduler, those it has; of an Executor, the same)

    Raises
    ------
    ValueError
        If there is no executor of this name.
    MissingLibrary
        If Dask is not installed.
    ExecutorError
        If it does not answer.
    """
    with _main_hidden():
        if isinstance(kind, Executor):
            yield WorkerPool(kind, workers or os.cpu_count() or 1)
            return
        if kind == "dask" or "://" in kind:
            with _dask(kind, workers) as client:
                yield Cluster(client)
            return
        if kind == "processes":
            pool = Processes(workers)
        elif kind == "in-process":
            pool = WorkerPool(InProcess(), 1)
        else:
            raise ValueError(
                f"there is no executor '{kind}': choose from processes, in-process, dask, or the address of a Dask "
                "scheduler, as tcp://host:8786"
            )
        try:
            yield pool
        finally:
            pool.stop()


@contextmanager
def _dask(kind: str, workers: int | None):
    try:
        from dask import config
        from distributed import Client, LocalCluster
    except ImportError:
        raise MissingLibrary("Dask is not installed: pip install 'warpdamp[cluster]'") from None
    if kind == "dask":
        with (
            config.set(LOCAL_DASK),
            LocalCluster(n_workers=workers or os.cpu_count(), threads_per_worker=1, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            yield client
        return
    try:
        client = Client(kind, timeout=ANSWERS_WITHIN)
    except OSError as error:
        raise ExecutorError(f"no Dask scheduler answers at {kind}: {error}") from None
    with client:
        client.wait_for_workers(workers or 1, timeout=600)
        yield client


@contextmanager
def _main_hidden():
    """Context in which workers do not import the script that was started.

    The workers do not need it, and a script that calls ``run`` at its top level would start itself again in every one
    of them: so it is hidden from them.
    """
    main = sys.modules["__main__"]
    hidden = {name: getattr(main, name) for name in ("__file__", "__spec__") if hasattr(main, name)}
    try:
        main.__spec__ = None
        main.__dict__.pop("__file__", None)
        yield
    finally:
        vars(main).update(hidden)


def _follow_parent() -> None:
    """Initialise a worker: it ignores Ctrl-C, which is the parent's, and ends when its parent is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def watch():
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
