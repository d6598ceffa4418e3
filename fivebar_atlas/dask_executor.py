"""Runs blocks of work on a Dask cluster: one of this machine's own, or one that is there.

The only place that knows ``dask.distributed``, which the extra ``cluster`` installs. Workers that
die are the cluster's to replace, and their tasks are done again. A task that is at work, or waits,
on a worker that dies too often is dropped by the scheduler; it is then tried once more alone,
since another one may have been to blame.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import functools
import json
import logging
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fivebar_atlas.errors import ClusterError, FileError, InputError, MissingExtraError
from fivebar_atlas.executors import Executor, LostTasksError, Result, Task, usable_cores

if TYPE_CHECKING:
    import distributed

#: How long a scheduler, and then a first worker, is waited for, in seconds.
PATIENCE = 15.0

#: Deaths of workers after which the scheduler drops a task.
DEATHS = 3

# Tasks handed to the cluster at a time for each thread of a worker: enough that none waits.
_TASKS_PER_THREAD = 3
# After so many seconds without a result it is looked whether there are workers at all.
_LOOK = 5.0
# So many looks without any worker, and the work ends.
_EMPTY_LOOKS = 12
# How often it is looked for a scheduler's file, in seconds.
_LOOK_FOR_FILE = 0.2

# What workers of our own run first: those that replace others inherit nothing of that kind.
_IGNORE_INTERRUPTS = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"

Versions = Mapping[str, str]


class DaskExecutor(Executor):
    """Runs tasks on the workers of a Dask cluster.

    Parameters
    ----------
    probe
        Returns what must be the same here and on every worker for results to be the same, such
        as versions; a function that can be pickled by its name, or a partial of one.
    scheduler
        Address of a running scheduler, ``"tcp://10.0.0.1:8786"``.
    scheduler_file
        File that a running scheduler wrote its address to. Without either a cluster of this
        machine is started, and ended with the executor.
    workers
        Number of processes of that cluster, None for one for each core.
    patience
        How long a scheduler, and then a first worker, is waited for, in seconds.

    Raises
    ------
    MissingExtraError
        If ``dask.distributed`` is not installed.
    ClusterError
        If the scheduler cannot be reached, has no workers, or workers have other versions.
    """

    def __init__(
        self,
        probe: Callable[[], Versions],
        *,
        scheduler: str | None = None,
        scheduler_file: str | None = None,
        workers: int | None = None,
        patience: float = PATIENCE,
    ) -> None:
        self._probe = probe
        self._versions = dict(probe())
        self._client, self._cluster = _connect(scheduler, scheduler_file, workers, patience)
        try:
            self._check_workers(patience)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Leave the cluster; end it if it is our own."""
        with contextlib.suppress(Exception):
            self._client.close()
        if self._cluster is not None:
            with contextlib.suppress(Exception):
                self._cluster.close()

    def run(
        self, function: Callable[[Task], Result], tasks: Iterable[Task]
    ) -> Iterator[tuple[Task, Result]]:
        """Yield each task with its result, in the order of completion."""
        waiting = iter(tasks)
        running: dict[distributed.Future, Task] = {}
        dropped: list[Task] = []
        call = functools.partial(_checked_call, self._probe, self._versions, function)
        lost = []
        try:
            while True:
                room = _TASKS_PER_THREAD * max(self._threads(), 1) - len(running)
                for task in islice(waiting, max(room, 0)):
                    running[self._submit(call, task)] = task
                if not running:
                    break
                for future in self._finished(running):
                    task = running.pop(future)
                    if _was_dropped(future):
                        dropped.append(task)
                    else:
                        yield task, _result(future)
            for task in dropped:
                future = self._submit(call, task)
                running[future] = task
                self._finished(running)
                del running[future]
                if _was_dropped(future):
                    lost.append(task)
                else:
                    yield task, _result(future)
        finally:
            if running:
                with contextlib.suppress(Exception):
                    self._client.cancel(list(running), force=True)
        if lost:
            raise LostTasksError(lost, "ended every worker that tried them")

    def _submit(self, call: Callable[[Task], Result], task: Task) -> distributed.Future:
        """Hand a task to the scheduler."""
        with _reachable():
            return self._client.submit(call, task, pure=False)

    def _threads(self) -> int:
        """Return the number of threads of all workers."""
        with _reachable():
            return sum(self._client.nthreads().values())

    def _finished(self, running: Mapping[distributed.Future, Any]) -> list[distributed.Future]:
        """Return the futures that are done, as soon as there is one.

        Raises
        ------
        ClusterError
            If there has been no worker for a while, or the scheduler has gone.
        """
        import distributed

        empty = 0
        while empty < _EMPTY_LOOKS:
            with _reachable(), contextlib.suppress(TimeoutError):
                found = distributed.wait(list(running), _LOOK, return_when="FIRST_COMPLETED")
                return list(found.done)
            empty = 0 if self._threads() else empty + 1
        raise ClusterError(f"the scheduler has had no worker for {_LOOK * _EMPTY_LOOKS:g} s")

    def _check_workers(self, patience: float) -> None:
        """Raise ClusterError unless there are workers, all of them with our versions."""
        try:
            self._client.wait_for_workers(1, timeout=patience)
        except TimeoutError:
            raise ClusterError(
                f"the scheduler at {self._client.scheduler.address} has no worker after "
                f"{patience:g} s; start one with 'dask worker'"
            ) from None
        found = self._client.run(self._probe, on_error="return")
        for address, versions in found.items():
            if isinstance(versions, BaseException):
                raise _unable(address, versions)
            _check_versions(versions, self._versions, address)


def _connect(
    scheduler: str | None, scheduler_file: str | None, workers: int | None, patience: float
) -> tuple[distributed.Client, distributed.LocalCluster | None]:
    """Return a client, and the cluster if it is our own."""
    try:
        import dask
        import distributed
    except ImportError:
        raise MissingExtraError("the executor dask", "cluster") from None
    # What happens to scheduler and workers is told by errors, not by the logs of Dask.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    if scheduler is None and scheduler_file is None:
        cluster = None
        try:
            with (
                _interrupts_ignored(),
                dask.config.set({"distributed.scheduler.allowed-failures": DEATHS}),
            ):
                cluster = distributed.LocalCluster(
                    n_workers=usable_cores() if workers is None else workers,
                    threads_per_worker=1,
                    processes=True,
                    # no pages for browsers, and whatever port is free
                    dashboard_address=":0",
                    scheduler_kwargs={"dashboard": False},
                    silence_logs=logging.CRITICAL,
                    preload=_IGNORE_INTERRUPTS,
                )
            return distributed.Client(cluster), cluster
        except (OSError, RuntimeError) as error:
            if cluster is not None:
                cluster.close()
            raise ClusterError(f"no cluster could be started on this machine: {error}") from None
    if scheduler_file is not None:
        scheduler = _address(Path(scheduler_file), patience)
    began = time.monotonic()
    try:
        with warnings.catch_warnings():
            # other versions, of which only some matter, are compared afterwards
            warnings.simplefilter("ignore")
            return distributed.Client(scheduler, timeout=patience), None
    except ValueError as error:
        raise InputError(
            "--scheduler", scheduler, f"an address such as tcp://10.0.0.1:8786 ({error})"
        ) from None
    except (OSError, TypeError, MemoryError, RuntimeError) as error:
        # the last three where something else than a scheduler answers, or tls is not set up
        where = f" (of {scheduler_file})" if scheduler_file else ""
        said = " ".join(str(error).split()) or type(error).__name__
        raise ClusterError(
            f"the scheduler {scheduler}{where} was not reached in "
            f"{time.monotonic() - began:.0f} s ({said}); is it running, is this its address and "
            "not that of its dashboard, and does no firewall stand between?"
        ) from None


@contextlib.contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Start processes that ignore interrupts, as they inherit from this one.

    An interrupt at the terminal goes to all processes, but it is the sweep that ends its workers.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _address(path: Path, patience: float) -> str:
    """Return the address in a scheduler's file, which may still be about to be written.

    Raises
    ------
    FileError
        If it does not appear, or has no address in it.
    """
    end = time.monotonic() + patience
    while True:
        try:
            return str(json.loads(path.read_text())["address"])
        except (OSError, ValueError, LookupError, TypeError) as error:
            if time.monotonic() > end:
                missing = isinstance(error, FileNotFoundError)
                what = "there is no such file" if missing else "holds no address of a scheduler"
                raise FileError(path, f"{what} after {patience:g} s") from None
        time.sleep(_LOOK_FOR_FILE)


def _checked_call(
    probe: Callable[[], Versions],
    versions: Versions,
    function: Callable[[Task], Result],
    task: Task,
) -> Result:
    """Apply the function on a worker, which may have come when the others had been checked."""
    import distributed

    address = distributed.get_worker().address
    try:
        found = probe()
    except Exception as error:
        raise _unable(address, error) from None
    _check_versions(found, versions, address)
    return function(task)


def _check_versions(found: Versions, wanted: Versions, worker: str) -> None:
    """Raise ClusterError where versions differ."""
    for name, value in wanted.items():
        if found.get(name) != value:
            raise ClusterError(
                f"the worker {worker} has {name} {found.get(name)}, this machine {value}; "
                "results would not be the same, so install the same versions on both"
            )


def _unable(worker: str, error: BaseException) -> ClusterError:
    """Return the error for a worker that cannot even say its versions."""
    return ClusterError(
        f"the worker {worker} cannot do the work: {type(error).__name__}: {error}; is the same "
        "version of this package installed there?"
    )


@contextlib.contextmanager
def _reachable() -> Iterator[None]:
    """Turn what Dask raises when the scheduler has gone into one error."""
    try:
        yield
    except (OSError, concurrent.futures.CancelledError, asyncio.CancelledError):
        raise ClusterError("the scheduler has gone") from None


def _was_dropped(future: distributed.Future) -> bool:
    """Return whether the scheduler gave a task up because its workers died."""
    import distributed

    with _reachable():
        return isinstance(future.exception(), distributed.KilledWorker)


def _result(future: distributed.Future) -> Any:
    """Return the result of a task, or raise what it raised; the cluster may forget it."""
    try:
        with _reachable():
            error = future.exception()
        if error is not None:
            raise error
        with _reachable():
            return future.result()
    finally:
        future.release()
