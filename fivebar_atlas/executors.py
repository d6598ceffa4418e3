"""Where blocks of work run: on the threads of this machine.

Sweeps know only :class:`Executor`, so that one that runs blocks on a cluster can take the
place of :class:`ThreadExecutor`.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from typing import TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")

#: Tasks handed to the pool at a time for each thread: enough that no thread waits while
#: results are stored, few enough that finished results do not pile up in memory.
_TASKS_PER_THREAD = 2


class Executor(ABC):
    """Applies a function to tasks, several at a time."""

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
