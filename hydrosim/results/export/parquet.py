"""Parquet: ``time`` and a column for each channel under its own name. The metadata of the file has,
under ``channels`` as JSON, the unit, the description and the meanings of mode numbers of each
column. Every reader of Parquet gives these metadata, not only Arrow.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hydrosim.results.export.table import ExportColumn, ExportTable


def write(table: ExportTable, path: Path, mark: str) -> None:
    """Write the columns of a table as Parquet."""
    import pyarrow as pa
    from pyarrow import parquet

    arrays = {"time": table.time} | {column.name: column.values for column in table.columns}
    said = {name: str(value) for name, value in table.attributes.items()}
    said["channels"] = json.dumps(
        {"time": {"units": "s"}}
        | {column.name: _column_attributes(column) for column in table.columns}
    )
    columns = pa.table({name: pa.array(values) for name, values in arrays.items()})
    with parquet.ParquetWriter(path, columns.schema, store_schema=False) as file:
        file.write_table(columns)
        # last, because `outputs` looks for it there
        file.add_key_value_metadata({**said, "source": mark})


def _column_attributes(column: ExportColumn) -> dict[str, str]:
    attributes = {"units": column.unit, "long_name": column.what, "flag_meanings": column.meanings}
    return {key: text for key, text in attributes.items() if text}
