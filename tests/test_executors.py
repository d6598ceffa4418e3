"""Executors: every task once, in any order, and an orderly end when something goes wrong."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from fivebar_atlas.executors import ThreadExecutor, usable_cores


@pytest.mark.parametrize("threads", [1, 2, 5, None])
def test_every_task_is_run_once(threads: int | None) -> None:
    finished = dict(ThreadExecutor(threads).run(lambda task: task * task, range(100)))
    assert finished == {task: task * task for task in range(100)}


def test_nothing_to_do() -> None:
    assert list(ThreadExecutor(3).run(lambda task: task, [])) == []


def test_results_come_as_they_are_finished() -> None:
    second_is_done = threading.Event()

    def work(task: int) -> int:
        if task == 0:
            assert second_is_done.wait(30)
        return task

    order = []
    for task, _ in ThreadExecutor(2).run(work, [0, 1]):
        order.append(task)
        second_is_done.set()
    assert order == [1, 0]


def test_tasks_run_at_the_same_time() -> None:
    meeting = threading.Barrier(3, timeout=30)
    results = ThreadExecutor(3).run(lambda _: meeting.wait() >= 0, range(3))
    assert [result for _, result in results] == [True] * 3


def test_tasks_are_taken_as_they_are_needed() -> None:
    """A million blocks must not sit in a queue."""
    taken = 0

    def tasks() -> Iterator[int]:
        nonlocal taken
        while taken < 1000:
            taken += 1
            yield taken

    results = ThreadExecutor(2).run(lambda task: task, tasks())
    next(results)
    assert taken <= 10
    results.close()  # type: ignore[attr-defined]
    assert taken <= 10


def test_a_failing_task_ends_the_run_with_its_error() -> None:
    started = []

    def work(task: int) -> int:
        started.append(task)
        if task == 3:
            raise ValueError("three")
        return task

    with pytest.raises(ValueError, match="three"):
        list(ThreadExecutor(1).run(work, range(1000)))
    assert len(started) < 10


def test_an_interrupt_drops_what_has_not_started() -> None:
    started = []

    def work(task: int) -> int:
        started.append(task)
        return task

    def interrupted() -> None:
        for _ in ThreadExecutor(2).run(work, range(1000)):
            raise KeyboardInterrupt

    before = set(threading.enumerate())
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    for thread in set(threading.enumerate()) - before:
        thread.join(30)
        assert not thread.is_alive()
    assert len(started) < 20


def test_an_interrupt_waits_for_nobody() -> None:
    go = threading.Event()

    def interrupted() -> None:
        for task, _ in ThreadExecutor(2).run(lambda task: task == 0 or go.wait(60), range(9)):
            assert task == 0
            raise KeyboardInterrupt

    before = set(threading.enumerate())
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not go.is_set()
    go.set()
    for thread in set(threading.enumerate()) - before:
        thread.join(30)
        assert not thread.is_alive()


def test_default_is_one_thread_a_core() -> None:
    assert ThreadExecutor().threads == usable_cores() >= 1
