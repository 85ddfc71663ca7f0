"""Writes tables as CSV and Parquet."""

import csv
from collections.abc import Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import TypeVar

from fcw.errors import UserError
from fcw.files import whole_file
from fcw.logs.export.columns import Column

Row = TypeVar("Row")
ROWS_PER_GROUP = 65_536
"""Rows per group of a Parquet file: about ten minutes on a motorway, and some MB in memory."""


def write_csv(path: Path, columns: Sequence[Column[Row]], rows: Iterable[Row]) -> int:
    """Write a table as CSV (RFC 4180, UTF-8, with a line of names) and return the number of its rows.

    Numbers have all their digits, an unbounded one is `inf`, truth values are `true` and `false`, and missing
    values are empty.

    Raises:
        UserError: the file cannot be written.
    """
    count = 0
    with whole_file(path) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([column.name for column in columns])
        for row in rows:
            writer.writerow([_cell(column.value(row)) for column in columns])
            count += 1
    return count


def write_parquet(path: Path, columns: Sequence[Column[Row]], rows: Iterable[Row]) -> int:
    """Write a table as Parquet and return the number of its rows; unit and meaning are metadata of a field.

    Raises:
        UserError: pyarrow is not installed, or the file cannot be written.
    """
    with whole_file(path) as partial:
        return fill_parquet(partial, columns, rows)


def fill_parquet(path: Path, columns: Sequence[Column[Row]], rows: Iterable[Row]) -> int:
    """The same as `write_parquet`, into a partial file that the caller completes.

    Raises:
        UserError: pyarrow is not installed.
        OSError: the file cannot be written.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise UserError(
            "--format parquet: needs pyarrow, which is not installed; install it with "
            "`pip install 'fcw[parquet]'`, or choose --format csv"
        ) from None
    schema = pa.schema(
        [
            pa.field(
                column.name,
                getattr(pa, column.kind)() if column.kind != "bool" else pa.bool_(),
                metadata={"unit": column.unit, "meaning": column.meaning},
            )
            for column in columns
        ]
    )
    count = 0
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        rows = iter(rows)
        while group := list(islice(rows, ROWS_PER_GROUP)):
            arrays = [
                pa.array([column.value(row) for row in group], field.type)
                for column, field in zip(columns, schema, strict=True)
            ]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
            count += len(group)
    return count


def _cell(value: str | int | float | bool | None) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value)
