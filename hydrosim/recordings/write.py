"""`write_recording`: channels of a run as a text table for other programs.

Layout: comment lines with #, a line of names, a line of units in brackets, and a line for each
time. Columns are right-aligned, of fixed width, and at least two blanks apart (names may contain
single blanks). So the file can be read by position or by blanks. The first column is the time.
Numbers have 17 significant digits by default, which restore each number to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import scipy
import xarray as xr

from hydrosim.documents.series import select
from hydrosim.documents.text import Source, escape_unprintable
from hydrosim.outputs import Output, as_output

EXACT = 17  # significant digits that distinguish any two float64
GAP = 2  # blanks between columns, at least


def write_recording(
    run: xr.Dataset,
    target: Path | Output,
    channels: Sequence[str],
    step: float | None = None,
    digits: int = EXACT,
    shown: Callable[[str], tuple[str, float]] | None = None,
) -> None:
    """Write ``channels`` ("position.barge.heave") of a run to a text file, at the run's
    times or at every ``step`` [s] from its start on, there by cubic splines. ``shown`` gives for an
    SI unit the unit to write, and what numbers in SI are multiplied by; without it all is in SI.

    The file appears under its name when it is complete. Raises InputError for unknown channels.
    """
    output = as_output(target, "recording")
    columns = [select(Source(output.path), run, channel) for channel in channels]
    time, rows = run.time.values, np.stack([values for values, _ in columns], axis=1)
    if step is not None:
        at = time[0] + step * np.arange(int((time[-1] - time[0]) / step * (1.0 + 1e-12)) + 1)
        time, rows = at, scipy.interpolate.CubicSpline(time, rows)(at)
    names = ["time", *map(escape_unprintable, channels)]
    said = [unit for _, unit in columns]
    if shown is not None:
        rows = rows * np.array([shown(unit)[1] for unit in said])
        said = [shown(unit)[0] for unit in said]
    units = [f"[{escape_unprintable(unit)}]" for unit in ("s", *said)]
    text = "SI and radians" if shown is None else "units of the case"
    number = digits + 7  # sign, point and exponent are 7 at most
    widths = [
        GAP + max(number, len(name), len(unit)) for name, unit in zip(names, units, strict=True)
    ]
    heading = [
        f"# {escape_unprintable(str(run.attrs.get('title', '')))}".rstrip(),
        f"# {output.mark}; {text}; {digits} significant digits",
        *("".join(map(str.rjust, row, widths)) for row in (names, units)),
    ]
    with output.write_complete() as path:
        np.savetxt(
            path,
            np.column_stack([time, rows]),
            fmt=[f"%{width}.{digits - 1}e" for width in widths],
            delimiter="",
            header="\n".join(heading),
            comments="",
            encoding="utf-8",
        )
