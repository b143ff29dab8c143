"""MATLAB, version 5: columns ``time`` and one variable for each channel. The rows of ``channels``
give the name of the variable, the name of the channel, the unit, a description, and the meanings of
mode numbers.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hydrosim.results.export.table import ExportTable, identifiers

MAX_MATLAB_NAME_LETTERS = 63  # valid name of a variable


def write(table: ExportTable, path: Path, mark: str) -> None:
    """Write the columns of a table for MATLAB."""
    from scipy.io import savemat

    own = ("source", "time", "channels", "run")
    named = list(identifiers(table.columns, MAX_MATLAB_NAME_LETTERS, *own))
    rows = [[name, c.name, c.unit, c.what, c.meanings] for name, c in named]
    said = {name: str(value) for name, value in table.attributes.items()}
    variables = {
        "source": mark,
        "time": table.time,
        "channels": np.array(rows, dtype=object),
        "run": said,
        **{name: column.values for name, column in named},
    }
    savemat(path, variables, appendmat=False, long_field_names=True, oned_as="column")
