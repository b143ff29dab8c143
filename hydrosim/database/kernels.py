"""Table of the retardation functions of a database."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.database.database import HydroDatabase, Real
from hydrosim.database.netcdf import dof_names
from hydrosim.files.outputs import Output
from hydrosim.water.radiation.retardation import (
    diagonal_scale,
    resolved_length,
    retardation,
    retardation_function,
)

SIGNIFICANT_FRACTION = 1e-6  # of the diagonal functions: pairs below this are rounding
RETARDATION_UNITS = ("N/m", "N/rad", "N m/rad")  # unit of K, by the number of rotations in the pair


class Kernel(NamedTuple):
    """A function of ``time`` (nt,) [s] for a pair of degrees of freedom, its name and unit; and the
    added mass at infinite frequency."""

    name: str
    unit: str
    values: Real
    added_mass_infinite: float


def kernels(db: HydroDatabase, length: float, step: float) -> tuple[Real, list[Kernel], str]:
    """Times, and K(t) = 2/pi int B cos(w t) dw of the pairs that radiate, about the database's
    reference points, with the resolved length of memory. K_ij = K_ji, so one of them is given."""
    functions_by_pair = retardation(
        db.frequency, db.added_mass, db.radiation_damping, length=length, step=step
    )
    mean = (db.radiation_damping + db.radiation_damping.swapaxes(1, 2)) / 2
    K, names = (
        retardation_function(db.frequency, mean, functions_by_pair.time),
        dof_names(db.bodies),
    )
    scale = diagonal_scale(K)
    seen = np.abs(K).max(axis=0) > SIGNIFICANT_FRACTION * np.outer(scale, scale)
    functions = [
        Kernel(
            f"{names[i]} {names[j]}",
            RETARDATION_UNITS[int(i % 6 > 2) + int(j % 6 > 2)],
            K[:, i, j],
            float(functions_by_pair.added_mass_infinite[i, j]),
        )
        for i, j in np.argwhere(np.triu(seen))
    ]
    report = str(functions_by_pair.report)
    if length > (resolved := resolved_length(db.frequency)):
        apart = f"{np.pi / resolved:.3g} rad/s apart"
        report += f"\nfrequencies {apart} resolve {resolved:.3g} s: later values are an echo"
    return functions_by_pair.time, functions, report


def write_table(db: HydroDatabase, time: Real, functions: list[Kernel], output: Output) -> None:
    """Write comma-separated columns with names and units, below comment lines with #."""
    points = "; ".join(", ".join(f"{x:g}" for x in point) for point in db.reference_point)
    heading = [
        f"# {output.mark}",
        f"# retardation functions K(t) = 2/pi int B(w) cos(w t) dw, about {points} m",
        "# added mass at infinite frequency (SI): "
        + ", ".join(
            f"{function.name} {function.added_mass_infinite:.6g}" for function in functions
        ),
        ",".join(["time", *(function.name for function in functions)]),
        ",".join(["[s]", *(f"[{function.unit}]" for function in functions)]),
    ]
    rows = np.column_stack([time, *(function.values for function in functions)])
    with output.write_complete() as path:
        np.savetxt(path, rows, "%.9g", ",", header="\n".join(heading), comments="", encoding="utf8")
