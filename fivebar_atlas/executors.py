"""Where blocks of work run: here, on the threads of this machine.

Sweeps know only :class:`Executor`, so that the one of :mod:`dask_executor`, which runs blocks on a
cluster, can take the place of :class:`ThreadExecutor`.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from types import TracebackType
from typing import Any, Self, TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")

#: Tasks handed to the pool at a time for each thread: enough that no thread waits while
#: results are stored, few enough that finished results do not pile up in memory.
_TASKS_PER_THREAD = 2


class LostTasksError(Exception):
    """Tasks that could not be finished, although everything else was.

    Attributes
    ----------
    tasks
        The tasks.
    reason
        What happened to them, as a phrase.
    """

    def __init__(self, tasks: Sequence[Any], reason: str) -> None:
        super().__init__(f"{len(tasks)} tasks: {reason}")
        self.tasks = tasks
        self.reason = reason


class Executor(ABC):
    """Applies a function to tasks, several at a time; a context manager, which closes it."""

    def close(self) -> None:  # noqa: B027
        """Give back what the executor holds; here nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    @abstractmethod
    def run(
        self, function: Callable[[Task], Result], tasks: Iterable[Task]
    ) -> Iterator[tuple[Task, Result]]:
        """Yield each task with its result as soon as it is finished, in any order.

        Parameters
        ----------
        function
            Depends on its task only, so that the results do not depend on the executor.
        tasks
            The tasks, started in this order.

        Yields
        ------
        tuple
            A task and what the function returned for it.

        Raises
        ------
        LostTasksError
            After all others, if tasks took the process they ran in with them.
        Exception
            Whatever the function raises. Tasks that have not been started by then, or
            when the iterator is closed or interrupted, are dropped; nobody waits for
            those at work, and nobody gets their results.
        """


class ThreadExecutor(Executor):
    """Runs tasks on threads; they share the cores as far as the function releases the GIL.

    Parameters
    ----------
    threads
        Number of threads, None for one for each core this process may use.
    """

    def __init__(self, threads: int | None = None) -> None:
        self.threads = usable_cores() if threads is None else threads

    def run(
        self, function: Callable[[Task], Result], tasks: Iterable[Task]
    ) -> Iterator[tuple[Task, Result]]:
        """Yield each task with its result, in the order of completion."""
        waiting = iter(tasks)
        running: dict[Future[Result], Task] = {}
        pool = ThreadPoolExecutor(self.threads, thread_name_prefix="sweep")
        try:
            while True:
                room = _TASKS_PER_THREAD * self.threads - len(running)
                for task in islice(waiting, room):
                    running[pool.submit(function, task)] = task
                if not running:
                    return
                finished, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in finished:
                    yield running.pop(future), future.result()
        finally:
            # A thread cannot be stopped: one at work goes on to the end of its task.
            pool.shutdown(wait=False, cancel_futures=True)


def usable_cores() -> int:
    """Return the number of cores this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
