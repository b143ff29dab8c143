"""What does the synthesis of wave loads cost, and how does it grow with the duration?

H-851 in a sea of as many components as the repeat period asks for, six degrees of freedom (waves to
45 degrees), the table on the stage grid of a step of 0.1 s: first order alone, with Newman's
approximation, and with the full difference-frequency QTF.
"""

from __future__ import annotations

import tracemalloc
from statistics import median
from time import process_time

import numpy as np

from benchmarks.report import ROOT, Answer, Row
from hydrosim.database import HydroDatabase, all_headings, load
from hydrosim.scene import Environment, Jonswap, SecondOrder, WaveForces, WaveTrain
from hydrosim.waves import WaveBody, sea, wave_loads_model

REPEATS = 5
HOURS = (0.75, 1.5, 3.0, 6.0)
SEA = Jonswap(significant_height=1.5, peak_period=8.0)
WANTED = (SecondOrder.NONE, SecondOrder.NEWMAN, SecondOrder.QTF)


def answer() -> Answer:
    """CPU time, memory and size of the tables."""
    database = all_headings(load(ROOT / "hydro_db" / "h851.nc"))
    rows = [_row(database, hours, wanted) for wanted in WANTED for hours in HOURS]
    return Answer({f"Synthesis, medians of {REPEATS}": rows})


def _row(database: HydroDatabase, hours: float, wanted: SecondOrder) -> Row:
    duration = 3600.0 * hours
    train = WaveTrain(SEA, heading=np.radians(45.0), repeat_period=duration)
    water = Environment(waves=(train,))
    forces = WaveForces(second_order=wanted)
    body = WaveBody(database, (0.0, 0.0), forces, 0, np.ones(6, dtype=bool))

    def made() -> tuple[float, int]:
        begin = process_time()
        model = wave_loads_model(sea(water), [body], 0.0, 0.05, duration)
        return process_time() - begin, model.values.nbytes

    seconds, size = zip(*(made() for _ in range(REPEATS)), strict=True)
    tracemalloc.start()
    made()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return {
        "second order": str(wanted),
        "duration [h]": hours,
        "components": int(sea(water)[0].omega.size),
        "CPU time [s]": median(seconds),
        "peak memory [MB]": peak / 1e6,
        "of it tables [MB]": size[0] / 1e6,
    }
