"""How does the error of the base case fall with the step, through contact, stick and slip?

Its first 700 s, by all methods with fixed steps, with steps cut at events and without. Errors are
the largest ones of surge, against rk4 at a step of 0.4/128 s; the error of that run itself is
estimated from the one at twice its step by Richardson's rule.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isnan, log2, nan

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.base_case import FINEST, RECORDED, motions, short_case, touches
from benchmarks.report import Answer, Row
from hydrosim import SimulationError, simulate
from hydrosim.integrate import RK4
from hydrosim.scene import Method

STEPS = [RECORDED / 2**k for k in range(6)]  # s
COLOURS = {Method.RK2: "#0072B2", Method.HEUN: "#E69F00", Method.RK4: "#009E73"}
UNCUT = ", no events"  # of the name of a line: steps are not cut at events
Runs = dict[tuple[Method, bool], list[xr.Dataset]]
Values = dict[str, list[float]]
"""Lines by their names: a value per step, NaN where the run failed."""


def answer() -> Answer:
    """Errors and orders, energies, and how far the fenders have slipped."""
    reference, coarser = simulate(short_case(FINEST)), simulate(short_case(2 * FINEST))
    runs = {
        (method, events): [_run(step, method, events) for step in STEPS]
        for method in COLOURS
        for events in (True, False)
    }
    contact = touches(reference)
    before = _values(
        {key: found for key, found in runs.items() if key[1]},
        lambda run: _error(run, reference, ~contact),
    )
    after = _values(runs, lambda run: _error(run, reference, contact))
    own = _error(coarser, reference, contact) / (2**RK4.order - 1)
    return Answer(
        {
            "Largest error of surge [m] until the first contact (observed order)": _orders(before),
            "Largest error of surge [m] after it (observed order)": _orders(after),
            "Energy residual over the integral of |wave power|": _table(_values(runs, _residual)),
            "Slipped by the fender that slips most until 700 s [m]": _table(
                _values(runs, _slipped)
            ),
        },
        [
            f"Reference: rk4 at {FINEST:g} s, its own error of surge about {own:.0e} m; slipped"
            f" {_slipped(reference):.5f} m.",
        ],
        _picture(before, after, own),
    )


def _run(step: float, method: Method, events: bool) -> xr.Dataset:
    """The run, or what there is of it if it failed."""
    try:
        return simulate(short_case(step, method, events))
    except SimulationError as error:
        return error.dataset


def _values(runs: Runs, measure: Callable[[xr.Dataset], float]) -> Values:
    return {
        method + ("" if events else UNCUT): [measure(run) for run in found]
        for (method, events), found in runs.items()
    }


def _error(run: xr.Dataset, reference: xr.Dataset, where: np.ndarray) -> float:
    """Largest error of surge [m] at the records ``where`` (nt,); NaN if the run ended before."""
    if where[run.sizes["time"] :].any():
        return nan
    chosen = np.flatnonzero(where)
    return float(np.abs(motions(run)[chosen, 0] - motions(reference)[chosen, 0]).max())


def _residual(run: xr.Dataset) -> float:
    complete = run.attrs["status"] == "complete"
    residual, scale = np.abs(run.energy_residual).max(), run.energy_wave_absolute[-1]
    return float(residual / scale) if complete else nan


def _slipped(run: xr.Dataset) -> float:
    complete = run.attrs["status"] == "complete"
    return float(run.fender_slip_distance[-1].max()) if complete else nan


def _table(values: Values) -> list[Row]:
    """A row per step, a column per line."""
    return [
        {"step [s]": f"{step:g}", **{name: _text(line[k]) for name, line in values.items()}}
        for k, step in enumerate(STEPS)
    ]


def _orders(errors: Values) -> list[Row]:
    """The same with the order from the step before, all steps being halves of each other."""
    return [
        {"step [s]": f"{step:g}", **{name: _with_order(line, k) for name, line in errors.items()}}
        for k, step in enumerate(STEPS)
    ]


def _with_order(line: list[float], k: int) -> str:
    if k == 0 or isnan(line[k - 1]) or isnan(line[k]):
        return _text(line[k])
    return f"{_text(line[k])} ({log2(line[k - 1] / line[k]):.1f})"


def _text(value: float) -> str:
    return "failed" if isnan(value) else f"{value:.4g}" if value > 1e-2 else f"{value:.1e}"


def _picture(before: Values, after: Values, own: float) -> Figure:
    """Errors against the step: until the first contact, and after it."""
    figure = Figure((10.0, 4.6), dpi=100, layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    _draw(left, before)
    _draw(right, after)
    right.axhline(own, color="0.5", linewidth=0.8, linestyle=":")
    note = {"textcoords": "offset points", "fontsize": "small", "color": "0.4"}
    right.annotate("the reference's own error", (STEPS[-1], own), (0, 4), **note)
    left.legend(loc="upper left", fontsize="small", frameon=False)
    right.legend(loc="center right", fontsize="small", frameon=False)
    left.set_title("until the first contact")
    right.set_title("after it: touching, slipping, sticking")
    left.set_ylabel("largest error of surge [m]")
    return figure


def _draw(axis: Axes, errors: Values) -> None:
    """Lines of errors, with their orders between the two finest steps."""
    for name, line in errors.items():
        style, colour = "s--" if UNCUT in name else "o-", COLOURS[Method(name.removesuffix(UNCUT))]
        label = f"{name}: order {log2(line[-2] / line[-1]):.1f}"
        axis.loglog(STEPS, line, style, color=colour, label=label, markersize=4, linewidth=1.2)
    axis.set_xlabel("step [s]")
    axis.grid(alpha=0.3)
    axis.spines[["top", "right"]].set_visible(False)
    axis.set_xticks(STEPS, labels=[f"{step:g}" for step in STEPS])
    axis.minorticks_off()
