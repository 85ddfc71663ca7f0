"""Workers, scheduler and client killed while a batch runs; then it is run again.

    python benchmarks/batch/faults.py [--drives 20] [--frames 60] [--workers 2]

Kills a worker ten times and then the scheduler during the first batch, the client itself during the second,
and lets the third run to its end. Prints after each what is done, and at the end whether all are, none twice
and none lost. Kills only processes that it started, by their numbers.
"""

import argparse
import json
import os
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import pyarrow.parquet as pq
from cluster import FCW, Cluster, write_drives
from rich import print  # noqa: A004

from fcw.batch.ledger import RECORD_NAME

KILLS = 10
PATIENCE_S = 300.0


def finished(out: Path) -> dict[str, int]:
    """When each drive that is done was."""
    return {path.parent.name: path.stat().st_mtime_ns for path in out.glob(f"*/{RECORD_NAME}")}


def begin(drives: Path, out: Path, cluster: Cluster) -> subprocess.Popen[bytes]:
    command = [*FCW, "batch", str(drives), "--out", str(out), "--detector", "acf"]
    return subprocess.Popen(
        [*command, "--scheduler", cluster.address, "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )


def kill_workers(cluster: Cluster, client: subprocess.Popen[bytes], out: Path) -> int:
    """One worker after the other, each time when another drive was begun."""
    killed: set[int] = set()
    begun: set[str] = set()
    while len(killed) < KILLS and client.poll() is None:
        now = {path.parent.name for path in out.glob("*/.fcw.lock")} - begun - finished(out).keys()
        alive = [pid for pid in cluster.worker_processes() if pid not in killed]
        if now and alive:
            begun |= {min(now)}
            os.kill(alive[len(killed) % len(alive)], signal.SIGKILL)
            killed.add(alive[len(killed) % len(alive)])
        time.sleep(0.1)
    return len(killed)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--drives", type=int, default=20)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        drives, out = folder / "drives", folder / "out"
        write_drives(drives, arguments.drives, arguments.frames)
        cluster = Cluster(folder, arguments.workers)
        cluster.start()
        try:
            client = begin(drives, out, cluster)
            print(f"workers killed: {kill_workers(cluster, client, out)}; done: {len(finished(out))}")
            if client.poll() is None:
                cluster.kill_scheduler()
                killed_s = time.perf_counter()
                try:
                    code = client.wait(PATIENCE_S)
                    print(
                        f"scheduler killed; the batch ended by itself after "
                        f"{time.perf_counter() - killed_s:.0f} s, exit code {code}"
                    )
                except subprocess.TimeoutExpired:
                    client.kill()
                    print(f"scheduler killed; the batch still waited after {PATIENCE_S:.0f} s")
            cluster.stop()
            after_first = finished(out)
            print(f"done after the first batch: {len(after_first)} of {arguments.drives}")

            cluster.start()
            client = begin(drives, out, cluster)
            while client.poll() is None and len(finished(out)) < len(after_first) + 2:
                time.sleep(0.1)
            client.kill()
            client.wait()
            after_second = finished(out)
            print(f"client killed; done: {len(after_second)}")

            client = begin(drives, out, cluster)
            told, _ = client.communicate()
        finally:
            cluster.stop()
        records = json.loads(told)
        states = [record["state"] for record in records]
        again = [name for name, time_ns in after_second.items() if finished(out)[name] != time_ns]
        events = pq.read_table(out / "events.parquet").to_pylist()
        distinct = {(event["drive"], event["kind"], event["start_s"]) for event in events}
        print(f"third batch: exit code {client.returncode}, {states.count('done')} of {len(states)} done")
        twice = len(events) - len(distinct)
        print(f"run again though done: {len(again)}; events {len(events)}, of them twice {twice}")
        print(f"drives in the table: {pq.read_table(out / 'drives.parquet').num_rows}")


if __name__ == "__main__":
    main()
