"""Read a log into pandas: how the time to collision and the distance of the lead went together.

    python examples/05_a_log_in_pandas.py [DRIVE]

DRIVE is a folder of `fcw run`, by default recordings/demo/out (`fcw demo`). `fcw export --format parquet`
writes the same and more to a file.
"""

import sys
from pathlib import Path

import pandas as pd

import fcw

here = Path(__file__).parents[1] / "recordings" / "demo" / "out"
results = fcw.read_drive(Path(sys.argv[1]) if len(sys.argv) > 1 else here).results()
rows = [
    (result.time_ns / 1e9, result.lead.distance_m, result.lead.closing_speed_mps, result.lead.ttc_s)
    for result in results
    if result.lead is not None
]
leads = pd.DataFrame(rows, columns=["time_s", "distance_m", "closing_speed_mps", "ttc_s"])
bands = leads.groupby(pd.cut(leads["distance_m"], [0, 10, 20, 30, 50, 80]), observed=True)
print(bands[["closing_speed_mps", "ttc_s"]].agg(["count", "min", "median"]).to_string())
