"""Nothing finished is lost, nothing wrong is read: kills, damage, a full disk, two runs at once, workers that hang or die."""

import itertools
import math
import multiprocessing
import os
import random
import resource
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import warpdamp
from warpdamp import StoreError, carry_out, collect
from warpdamp.analysis.results import write
from warpdamp.errors import ExecutorError
from warpdamp.execution import batching, dispatch, executors
from warpdamp.execution.dispatch import Abandoned, Job, run_jobs
from warpdamp.execution.executors import WorkerPool, worker_pool
from warpdamp.execution.progress import status
from warpdamp.execution.store import Store
from warpdamp.status import Status

TINY = """
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 8, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: {from: 2, to: 6, n: 10}, frequency: [40 Hz, 60 Hz, 80 Hz]}
preparation: loose
steady_state: {fewest_cycles: 12, most_cycles: 12}
"""
CASES = 30


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    path = tmp_path_factory.mktemp("survival") / "tiny.yaml"
    path.write_text(TINY)
    return path


@pytest.fixture(scope="module")
def undisturbed(tiny):
    return warpdamp.run(tiny, executor="in-process")


@pytest.fixture
def small_batches(monkeypatch):
    monkeypatch.setattr(batching, "BATCH_COST", 1.0)


START = (
    "import sys, warpdamp.execution.batching; warpdamp.execution.batching.BATCH_COST = 1.0\n"
    "from warpdamp.cli.app import app; app(sys.argv[1:], prog_name='warpdamp')"
)


def start(config, output, *more, limits=None):
    """The command line in a process of its own, one case to a batch."""
    command = [sys.executable, "-c", START, "run", config, "-o", output, "--workers", "2", *more]
    return subprocess.Popen(
        list(map(str, command)), stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, preexec_fn=limits
    )


def shards(store) -> int:
    return len(list((store / "shards").glob("*.nc")))


def until(condition, process, seconds=90):
    deadline = time.monotonic() + seconds
    while not condition():
        assert process.poll() is None, process.communicate()[1]
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_killed_twice_and_resumed(tiny, undisturbed, tmp_path, same):
    """kill -9 of the runner: its workers end, too, and what was done is kept."""
    rng = random.Random(1)
    store, done = tmp_path / "tiny", 0
    for _ in range(2):
        process = start(tiny, tmp_path)
        until(lambda: shards(store) > done + rng.randrange(3, 8), process)  # noqa: B023
        process.kill()
        process.communicate()
        done = shards(store)
    assert done < CASES
    kept = {path.name for path in (store / "shards").glob("*.nc")}
    process = start(tiny, tmp_path)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 0, said
    assert kept <= {path.name for path in (store / "shards").glob("*.nc")}
    with xr.open_dataset(tmp_path / "tiny.nc") as back:
        same(back.load(), undisturbed)
    assert not list(store.glob("*/.*.tmp"))


def test_stopped_by_hand_it_says_how_to_go_on(tiny, tmp_path):
    # a shell without job control lets its background jobs, and so these tests, ignore SIGINT
    process = start(tiny, tmp_path, limits=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    until(lambda: shards(tmp_path / "tiny") > 2, process)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "Traceback" not in said
    assert "the same command continues from there" in said
    lines = "\n".join(status(tmp_path))
    assert "cases done" in lines
    assert "no run in progress; the last run stopped: KeyboardInterrupt; run again to continue" in lines


@pytest.mark.parametrize("how", ["processes", "dask"])
def test_workers_that_are_killed(tiny, undisturbed, tmp_path, small_batches, how, same):
    if how == "dask":
        pytest.importorskip("distributed")
    killed = []

    def kill_a_worker(stage, done):
        if stage == "cases" and done > 0.1 * (1 + len(killed)) and len(killed) < 2:
            found = multiprocessing.active_children()[0].pid
            killed.append(found)
            os.kill(found, signal.SIGKILL)

    dataset = warpdamp.run(tiny, store=tmp_path, executor=how, workers=2, report=kill_a_worker)
    assert len(killed) == 2
    same(dataset, undisturbed)


def test_parts_together_are_the_whole(tiny, undisturbed, tmp_path, same):
    for k in (3, 1, 2):
        carry_out(tiny, tmp_path, part=(k, 3), executor="in-process")
        if k == 3:
            part = collect(tmp_path)
            left = part["status"] == Status.NOT_RUN
            assert 0 < left.sum() < CASES
            assert np.isnan(part["effectiveness"].where(left)).all()
    assert shards(tmp_path) == len(list((tmp_path / "shards").iterdir()))
    same(collect(tmp_path), undisturbed)


def test_an_enlarged_sweep_runs_only_what_is_new(tiny, undisturbed, tmp_path, same):
    smaller = tmp_path / "tiny.yaml"
    smaller.write_text(TINY.replace("[40 Hz, 60 Hz, 80 Hz]", "[60 Hz, 80 Hz]"))
    warpdamp.run(smaller, store=tmp_path / "store", executor="in-process")
    told = []
    carry_out(tiny, tmp_path / "store", executor="in-process", report=lambda stage, done: told.append(stage))
    assert "of 30 cases done" in "\n".join(status(tmp_path / "store"))
    finished = Store(tmp_path / "store").finished()
    assert len(finished) == CASES
    same(collect(tmp_path / "store"), undisturbed)
    told.clear()
    carry_out(tiny, tmp_path / "store", executor="in-process", report=lambda stage, done: told.append(stage))
    assert set(told) == {"modes"}  # nothing left to do


def test_damaged_shards_are_found_and_their_cases_run_again(tiny, undisturbed, tmp_path, small_batches, caplog, same):
    carry_out(tiny, tmp_path, executor="in-process")
    first, second, third, *_ = sorted((tmp_path / "shards").glob("*.nc"))
    first.write_bytes(first.read_bytes()[:1000])  # cut short
    flipped = bytearray(second.read_bytes())
    flipped[len(flipped) // 2] ^= 1  # one bit
    second.write_bytes(flipped)
    third.write_bytes(b"")
    assert (collect(tmp_path)["status"] == Status.NOT_RUN).sum() == 3
    assert "is damaged" in caplog.text
    assert "its cases count as not done" in caplog.text
    same(warpdamp.run(tiny, store=tmp_path, executor="in-process"), undisturbed)
    assert len(list((tmp_path / "damaged").iterdir())) == 3


def test_a_full_disk_is_said_and_nothing_is_lost(tiny, undisturbed, tmp_path, same):
    """No file may grow beyond a size that a shard needs: what a full disk does, at the same places."""
    store = tmp_path / "tiny"
    carry_out(tiny, store, part=(1, 3), executor="in-process")
    before = shards(store)
    assert before
    process = start(tiny, tmp_path, limits=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000)))
    _, said = process.communicate(timeout=60)
    assert process.returncode == 2
    assert "Traceback" not in said
    assert "cannot be written: File too large; finished cases are stored: free space and run again" in said
    assert shards(store) == before
    assert not list(store.glob("*/.*.tmp"))
    same(warpdamp.run(tiny, store=store, executor="in-process"), undisturbed)


def test_two_runs_in_one_folder(tiny, tmp_path):
    store = Store(tmp_path)
    with store.lock(None), pytest.raises(StoreError, match=r"another run is in progress on .*--part 1/2"):
        carry_out(tiny, tmp_path, executor="in-process")
    with store.lock((1, 2)):
        with pytest.raises(StoreError, match="another run is in progress on part 1/2"), Store(tmp_path).lock((1, 2)):
            pass
        with pytest.raises(StoreError, match="another run"), Store(tmp_path).lock(None):
            pass
        with Store(tmp_path).lock((2, 2)):
            pass
    with store.lock(None):
        pass


def test_a_case_that_fails_is_a_value(tiny, tmp_path, same):
    """One of several beds cannot be made; its cases say why, the others are as they were."""
    path = tmp_path / "study.yaml"
    path.write_text(TINY + "sweep: {product: {damper.particles.count: [8, 21]}}\n")
    dataset = warpdamp.run(path, store=tmp_path / "store", executor="in-process")
    full = dataset.sel(count=21)
    assert (full["status"] == Status.FAILED).all()
    assert np.isnan(full["effectiveness"]).all()
    assert "too many particles" in full["message"].values.ravel()[0]
    assert (dataset.sel(count=8)["status"] < Status.FAILED).all()
    assert "30 failed" in "\n".join(status(tmp_path / "store"))
    again = warpdamp.run(path, store=tmp_path / "store", executor="in-process")  # tries them again, and no more
    same(again, dataset)
    write(dataset, tmp_path / "study.nc")
    with xr.open_dataset(tmp_path / "study.nc") as back:
        same(back.load(), dataset)


def test_a_case_that_raises_does_not_take_others_along(tiny, undisturbed, monkeypatch):
    from warpdamp.damper import shake as shaking

    true = shaking.shake

    def raising(chains, criteria):
        if any(spec.index == (1, 2, 0) for chain in chains for spec in chain):
            raise ZeroDivisionError("sabotaged")
        return true(chains, criteria)

    monkeypatch.setattr(shaking, "shake", raising)
    dataset = warpdamp.run(tiny, executor="in-process")
    assert dataset["status"][1, 2, 0] == Status.FAILED
    assert dataset["message"].values[1, 2, 0] == "ZeroDivisionError: sabotaged"
    good = undisturbed["effectiveness"].where(dataset["status"] != Status.FAILED)
    xr.testing.assert_identical(dataset["effectiveness"], good.assign_attrs(undisturbed["effectiveness"].attrs))


def nap(items, alive):
    """For a worker: hang, die or answer, as the items say; what hangs shows itself in the file ``alive``."""
    for item in items:
        ends = {"rest": time.monotonic() + 3, "hang": math.inf}.get(item, 0.0)
        while time.monotonic() < ends:
            Path(alive).touch()
            time.sleep(0.02)
        if item == "die":
            os._exit(9)
    return [item.upper() for item in items]


class ClockOfWhatHangs:
    """Advances by 10 s at each look at which something hangs, and not otherwise, however busy the machine is."""

    def __init__(self, alive: Path):
        self.alive, self.now = alive, 0.0

    def __call__(self) -> float:
        if self.alive.exists():
            self.alive.unlink()
            self.now += 10.0
        return self.now


@pytest.fixture
def dispatched(tmp_path, monkeypatch):
    """Results of jobs of naps in a pool, each of at most a minute of the clock above."""
    monkeypatch.setattr(dispatch, "TICK", 0.05)
    alive = tmp_path / "alive"

    def run(naps, pool):
        def submit(job):
            return nap, job.parts, str(alive)

        clock = ClockOfWhatHangs(alive)
        return list(
            run_jobs((Job(items, 60.0) for items in naps), pool, submit, lambda busy: None, tmp_path, clock=clock)
        )

    return run


@pytest.mark.parametrize("how", ["processes", "dask"])
def test_workers_that_hang_or_die_are_replaced(how, dispatched, tmp_path):
    if how == "dask":
        pytest.importorskip("distributed")
    with worker_pool(how, 2) as pool:
        answers = dispatched([["a", "hang"], ["b", "die"], ["c"], ["d"]], pool)
    good = sorted(letter for _, answer in answers if not isinstance(answer, Abandoned) for letter in answer)
    assert good == ["A", "B", "C", "D"]
    lost = {job.parts[0]: answer.overdue for job, answer in answers if isinstance(answer, Abandoned)}
    assert lost == {"hang": True, "die": False}


def test_a_job_that_waits_for_its_worker_is_not_overdue(tmp_path, monkeypatch):
    """The limit counts from the start on a worker: here the only one is busy for three times the limit."""
    monkeypatch.setattr(dispatch, "TICK", 0.01)
    free, looks = threading.Event(), itertools.count()

    def clock():
        look = next(looks)
        if look == 3:
            free.set()
        return 100.0 * min(look, 3)

    with ThreadPoolExecutor(1) as executor:
        executor.submit(free.wait)
        job = Job(["a"], 100.0)
        answers = run_jobs(
            iter([job]),
            WorkerPool(executor, 2),
            lambda job: (nap, job.parts, ""),
            lambda busy: None,
            tmp_path,
            clock=clock,
        )
        assert list(answers) == [(job, ["A"])]


def test_a_cluster_that_loses_all_workers_is_not_taken_for_cases_that_hang(dispatched, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(executors, "COMES_BACK_WITHIN", 1.0)
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None, processes=False) as cluster,
        distributed.Client(cluster) as client,
        pytest.raises(ExecutorError, match=r"no Dask worker came back within 1 s"),
    ):
        dispatched([["rest"], ["a"]], executors.Cluster(client))


def test_an_executor_of_ones_own(tiny, undisturbed, same):
    with ThreadPoolExecutor(2) as own:
        same(warpdamp.run(tiny, executor=own, workers=2), undisturbed)


def test_an_executor_of_ones_own_that_breaks(dispatched):
    """Nothing can be done about it, and that is said instead of trying for ever."""
    with (
        ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as own,
        pytest.raises(ExecutorError, match=r"a worker died, and an executor that was passed in cannot be repaired"),
    ):
        dispatched([["die"]], WorkerPool(own, 1))


def test_the_same_by_processes_and_dask(tiny, undisturbed, same):
    same(warpdamp.run(tiny, executor="processes", workers=2), undisturbed)
    pytest.importorskip("distributed")
    same(warpdamp.run(tiny, executor="dask", workers=2), undisturbed)


@pytest.mark.parametrize(("kind", "error", "message"), [
    ("threads", ValueError, "choose from processes, in-process, dask"),
    ("tcp://127.0.0.1:9", ExecutorError, "no Dask scheduler answers"),
])  # fmt: skip
def test_who_is_not_there(tiny, kind, error, message, monkeypatch):
    if "://" in kind:
        pytest.importorskip("distributed")
    monkeypatch.setattr(executors, "ANSWERS_WITHIN", 1.0)
    with pytest.raises(error, match=message):
        warpdamp.run(tiny, executor=kind)


def test_a_folder_that_holds_no_sweep(tmp_path):
    with pytest.raises(StoreError, match="is not a folder of a sweep"):
        collect(tmp_path)
    Store(tmp_path)
    with pytest.raises(StoreError, match="holds no study"):
        collect(tmp_path)


def test_processes_end_with_their_parent():
    code = (
        "from warpdamp.execution.executors import Processes; import os, time\n"
        "pool = Processes(1); print(pool.submit(os.getpid).result(), flush=True); pool.submit(time.sleep, 600); time.sleep(600)"
    )
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    worker = int(parent.stdout.readline())
    assert Path(f"/proc/{worker}").exists() or sys.platform != "linux"
    parent.kill()
    parent.wait()
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline and Path(f"/proc/{worker}").exists():
        time.sleep(0.05)
    assert not Path(f"/proc/{worker}").exists()
