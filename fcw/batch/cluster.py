"""Drives as tasks of a Dask cluster, on this machine or an existing one."""

import logging
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, cast

from fcw.batch.ledger import Record, State
from fcw.batch.work import Task, run_task
from fcw.errors import UserError
from fcw.threads import available_cores

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from distributed import Client, Future

TOPIC = "fcw-progress"
CONNECT_S = 10
ENOUGH_DRIVES = 2
"""With so many drives for each worker, drives are not split into pieces: that would decode them twice, and no
worker is idle anyway."""
PIECES_FIRST = 10
"""Dask's priority: pieces of drives that have begun go before drives that have not."""

MEMORY_GIVEN_BACK = "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_"
"""With Dask's default, a worker returns the memory of each picture to the system and asks for it again, which
takes a third more time."""

OnProgress = Callable[[str, int, int | None, int], None]
"""Name of a drive, frames done, how many there are, and warnings by then."""


@contextmanager
def connected(scheduler: str | None = None, workers: int | None = None) -> "Iterator[Client]":
    """A client of a cluster; a cluster that was made for it ends with the context.

    Args:
        scheduler: address of a running scheduler, whose workers see the same files under the same paths; None
            makes a cluster on this machine.
        workers: number of processes of that cluster, each with one thread; by default one for each core.

    Raises:
        UserError: Dask is not installed, or no scheduler answers at the address.
    """
    try:
        import dask.config
        from distributed import Client, LocalCluster
    except ImportError:
        raise UserError(
            "fcw batch: needs Dask, which is not installed; install it with `pip install 'fcw[batch]'`"
        ) from None
    if scheduler is not None:
        try:
            client = Client(scheduler, timeout=CONNECT_S)
        except (OSError, ValueError) as error:
            raise UserError(
                f"--scheduler {scheduler}: nothing answers there ({error}); expected the address that "
                "`dask scheduler` prints, e.g. tcp://127.0.0.1:8786"
            ) from error
        with client:
            yield client
        return
    with (
        dask.config.set({MEMORY_GIVEN_BACK: None}),
        LocalCluster(
            n_workers=workers or available_cores(),
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


def run_tasks(
    client: "Client",
    tasks: Sequence[Task],
    on_progress: OnProgress,
    work: Callable[[Task], Record] | None = None,
) -> Iterator[Record]:
    """Run drives, as many at once as there are workers, and yield each record as soon as it is ready.

    If a worker dies, another one runs its drive again, as often as Dask allows
    (`distributed.scheduler.allowed-failures`).

    Args:
        client: client of the cluster.
        tasks: the drives.
        on_progress: called about once a second for each running drive, in a thread of the client.
        work: what a worker does with a task; None runs the drive.
    """
    from distributed import as_completed

    client.subscribe_topic(TOPIC, lambda event: on_progress(*event[1]))
    threads = sum(cast(dict[str, int], client.nthreads()).values())
    if len(tasks) >= ENOUGH_DRIVES * max(threads, 1):
        tasks = [replace(task, piece_s=None) for task in tasks]
    batch = secrets.token_hex(8)  # another batch of the same drives has another folder
    keys = [f"fcw-{batch}-{task.identity.key}" for task in tasks]
    submitted = client.map(work or _on_worker, tasks, key=keys, pure=False)
    futures: dict[Future, Task] = dict(zip(submitted, tasks, strict=True))
    del submitted
    try:
        for ended in as_completed(list(futures), raise_errors=False).batches():
            # Fetched together: each fetch asks the scheduler, whatever it brings.
            finished = [future for future in ended if future.status == "finished"]
            records = dict(zip(finished, cast(list[Record], client.gather(finished)), strict=True))
            for future in ended:
                task = futures.pop(future)  # the scheduler forgets what nobody holds
                yield records.get(future) or _record(task, future)
    finally:
        client.unsubscribe_topic(TOPIC)
        client.cancel(list(futures))


def _on_worker(task: Task) -> Record:
    from distributed import get_worker

    worker = get_worker()
    worker.log_event(TOPIC, (task.drive.name, 0, None, 0))
    return run_task(
        task,
        lambda done, total, warnings: worker.log_event(TOPIC, (task.drive.name, done, total, warnings)),
        _executor_of_cluster,
    )


@contextmanager
def _executor_of_cluster() -> "Iterator[Executor]":
    """For a task that waits for others: the worker meanwhile runs these in its stead."""
    from dask.base import annotate
    from distributed import worker_client

    with worker_client() as client, annotate(priority=PIECES_FIRST):
        yield client.get_executor(pure=False)


def _record(task: Task, future: "Future") -> Record:
    if future.status == "finished":
        return future.result()
    if future.status == "error":
        from distributed.scheduler import KilledWorker

        error = future.exception()
        if isinstance(error, KilledWorker):
            reason = "its worker died again and again (killed, or out of memory); run the batch again"
            return task.record(State.LOST, reason)
        return task.record(State.FAILED, f"a fault of this program: {type(error).__name__}: {error}")
    return task.record(State.LOST, "the scheduler went away; run the batch again")
