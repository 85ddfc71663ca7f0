"""What a batch costs beside its drives: many tasks that do nothing, through client, scheduler and workers.

    python benchmarks/batch/scheduler_load.py [--tasks 10000] [--workers 2]

Prints the processor time of the process that holds client and scheduler, and the wall time, a task; its
resident memory over the tasks; and how the tables are written of so many records.
"""

import argparse
import resource
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
from rich import print  # noqa: A004

from fcw.batch.cluster import connected, run_tasks
from fcw.batch.drives import BatchDrive
from fcw.batch.identity import BatchOptions, Identity
from fcw.batch.ledger import Record, State
from fcw.batch.tables import DRIVE_COLUMNS
from fcw.batch.work import Task
from fcw.logs.export.table import write_parquet
from fcw.versions import machine

ROWS = 10


def nothing(task: Task) -> Record:
    return replace(task.record(State.DONE), frames=1)


def resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--tasks", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    print(machine())
    options = BatchOptions()
    tasks = [
        Task(
            BatchDrive(f"d{number:06d}", Path(f"/drives/van-{number % 100}/{number}.mp4"), "van", None),
            Identity(f"{number:064x}", "", "", options),
            Path("/out"),
        )
        for number in range(arguments.tasks)
    ]
    records: list[Record] = []
    with connected(workers=arguments.workers) as client:
        client.wait_for_workers(arguments.workers)
        start_s, start_cpu_s = time.perf_counter(), time.process_time()
        for record in run_tasks(client, tasks, lambda *_: None, nothing):
            records.append(record)
            if len(records) % (arguments.tasks // ROWS) == 0:
                print(f"{len(records):8} tasks  {resident_mb():7.1f} MB")
        wall_s, cpu_s = time.perf_counter() - start_s, time.process_time() - start_cpu_s
    each = 1000 / arguments.tasks
    print(f"{wall_s * each:.2f} ms a task; {cpu_s * each:.2f} ms of processor time of client and scheduler")
    assert len({record.name for record in records}) == arguments.tasks
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drives.parquet"
        start_s = time.process_time()
        write_parquet(path, DRIVE_COLUMNS, records)
        print(
            f"table of {pq.read_table(path).num_rows} drives: {path.stat().st_size / arguments.tasks:.0f} "
            f"bytes and {(time.process_time() - start_s) * each:.3f} ms a drive"
        )


if __name__ == "__main__":
    main()
