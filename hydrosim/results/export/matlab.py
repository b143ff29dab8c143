"""MATLAB, version 5: ``time`` and a variable for each channel, columns both; ``channels`` says in
its rows the name of the variable, that of the channel, the unit, what it is, and what the numbers
of a mode mean.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hydrosim.results.export.table import Table, identifiers

LONGEST = 63  # a name of a variable


def write(table: Table, path: Path, mark: str) -> None:
    """Write the columns of a table for MATLAB."""
    from scipy.io import savemat

    own = ("source", "time", "channels", "run")
    named = list(identifiers(table.columns, LONGEST, *own))
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
