"""Blocks on a Dask cluster: same results, deaths of workers, versions, no scheduler."""

from __future__ import annotations

import functools
import json
import logging
import os
import signal
import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from fivebar_atlas.dask_executor import DaskExecutor
from fivebar_atlas.errors import ClusterError, FileError, InputError, MissingExtraError
from fivebar_atlas.executors import LostTasksError

pytest.importorskip("distributed")


def same_everywhere() -> dict[str, str]:
    return {"version": "1"}


def of_this_process(parent: int) -> dict[str, str]:
    """Return a version that only the parent has."""
    return {"version": "new" if os.getpid() == parent else "old"}


def square(number: int) -> int:
    return number * number


def square_unless_deadly(deadly: int, number: int) -> int:
    if number == deadly:
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def square_after_a_death(folder: Path, number: int) -> int:
    """Die at the first try of every fifth number."""
    mark = folder / str(number)
    if number % 5 == 0 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def fail(number: int) -> int:
    raise ValueError(f"no square of {number}")


@pytest.fixture(scope="module")
def executor() -> Iterator[DaskExecutor]:
    with DaskExecutor(same_everywhere, workers=2) as running:
        yield running


def test_every_task_comes_back_once_with_its_result(executor: DaskExecutor) -> None:
    found = list(executor.run(square, range(50)))
    assert sorted(found) == [(number, number * number) for number in range(50)]


def test_error_of_the_function_is_raised(executor: DaskExecutor) -> None:
    with pytest.raises(ValueError, match="no square of"):
        list(executor.run(fail, range(3)))
    assert len(list(executor.run(square, range(3)))) == 3


def test_tasks_of_workers_that_die_are_done_again(executor: DaskExecutor, tmp_path: Path) -> None:
    found = list(executor.run(functools.partial(square_after_a_death, tmp_path), range(12)))
    assert sorted(found) == [(number, number * number) for number in range(12)]
    assert len(list(tmp_path.iterdir())) == 3


def test_task_that_kills_every_worker_is_named_and_the_rest_is_done(executor: DaskExecutor) -> None:
    found: list[tuple[int, int]] = []
    with pytest.raises(LostTasksError) as caught:  # noqa: PT012
        for pair in executor.run(functools.partial(square_unless_deadly, 2), range(8)):
            found.append(pair)  # noqa: PERF402
    assert caught.value.tasks == [2]
    assert sorted(found) == [(number, number * number) for number in range(8) if number != 2]


def test_workers_of_another_version_are_refused() -> None:
    probe = functools.partial(of_this_process, os.getpid())
    with pytest.raises(ClusterError, match="has version old, this machine new"):
        DaskExecutor(probe, workers=1)


def test_missing_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(
        MissingExtraError, match=r"pip install 'fivebar-atlas\[cluster\]'"
    ) as caught:
        DaskExecutor(same_everywhere)
    assert caught.value.exit_code == 2


def test_unreachable_scheduler_says_how_long_it_tried() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
    with pytest.raises(ClusterError, match=rf"{address} was not reached in 1 s.*is it running"):
        DaskExecutor(same_everywhere, scheduler=address, patience=1.0)


def test_address_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="such as tcp://"):
        DaskExecutor(same_everywhere, scheduler="nonsense://", patience=1.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [(None, "there is no such file after 0.5 s"), ("{}", "holds no address"), ("x", "no address")],
)
def test_scheduler_file_without_an_address(tmp_path: Path, text: str | None, message: str) -> None:
    path = tmp_path / "scheduler.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(FileError, match=message):
        DaskExecutor(same_everywhere, scheduler_file=str(path), patience=0.5)


def test_cluster_that_runs_already_is_used_and_left_alone(
    executor: DaskExecutor, tmp_path: Path
) -> None:
    address = executor._client.scheduler.address
    path = tmp_path / "scheduler.json"
    path.write_text(json.dumps({"address": address}))
    for choice in ({"scheduler": address}, {"scheduler_file": str(path)}):
        with DaskExecutor(same_everywhere, **choice) as other:
            assert sorted(other.run(square, range(4))) == [(0, 0), (1, 1), (2, 4), (3, 9)]
    assert len(list(executor.run(square, range(4)))) == 4


def test_scheduler_that_goes_is_one_error() -> None:
    import distributed

    cluster = distributed.LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        dashboard_address=":0",
        scheduler_kwargs={"dashboard": False},
        silence_logs=logging.CRITICAL,
    )
    with DaskExecutor(same_everywhere, scheduler=cluster.scheduler_address) as other:
        found = other.run(wait_a_little, range(10_000))
        next(found)
        cluster.close()
        with pytest.raises(ClusterError, match="the scheduler has gone"):
            list(found)


def wait_a_little(number: int) -> int:
    time.sleep(0.01)
    return number


def test_worker_that_came_later_is_compared_and_named(executor: DaskExecutor) -> None:
    """Here with a probe that changes its mind once the workers have been compared."""
    address = executor._client.scheduler.address
    with DaskExecutor(same_everywhere, scheduler=address) as other:
        other._probe = functools.partial(of_this_process, os.getpid())
        with pytest.raises(ClusterError, match=r"worker tcp://\S+ has version old, this machine 1"):
            list(other.run(square, range(4)))
        other._probe = broken_probe
        with pytest.raises(
            ClusterError, match=r"tcp://\S+ cannot do the work: ValueError: no such"
        ):
            list(other.run(square, range(4)))


def broken_probe() -> dict[str, str]:
    raise ValueError("no such mechanism")
