"""What does an error cost, by every method, and with numpy and scipy?

Heave of the sphere in its sea, small angles, so that all solve the same equation: all methods over
their steps or tolerances, the propagation without steps, and the numpy and scipy of
`sphere_with_numpy`. Surge of the base case, its first 700 s, by the methods, with the contact that
it has and with nodes that are a hundred times as stiff. Errors are the largest
ones over the range of the motion, against a run at a fine step of the same equation; CPU times are
those of the time loop, or of the solver; of the propagation, which has none, all told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import isnan, nan
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from benchmarks import sphere_with_numpy as by_numpy
from benchmarks.report import Answer, Row
from benchmarks.scenes import FINEST, Several, compiled, motions, short_case, sphere, with_states
from benchmarks.timing import Timed, interleaved, time_all, time_loop, timed
from hydrosim import SimulationError
from hydrosim.elements import Fender, StickSlip
from hydrosim.scene import (
    ConvolutionRadiation,
    Kinematics,
    LinearScenes,
    Method,
    Scene,
    Tolerance,
)

REPEATS = 3
DURATION, RECORDED, STATES = 600.0, 3.0, 60  # s, s; of the sphere
SURGE, HEAVE = 0, 2
ASKED = 1e-4  # of the range
STEPS = {
    Method.RK2: (0.05, 0.025, 0.0125, 0.00625),
    Method.HEUN: (0.05, 0.025, 0.0125, 0.00625),
    Method.RK4: (0.2, 3 / 16, 1 / 6, 0.1, 0.05, 0.025, 0.0125),
}
"""Of the sphere [s], below the stable limits."""
BASE_STEPS = {
    Method.RK2: (0.1, 0.05, 0.025, 0.0125),
    Method.HEUN: (0.1, 0.05, 0.025, 0.0125),
    Method.RK4: (0.1, 0.05, 0.025, 0.0125),
}
STIFF, STIFF_STEPS = 100.0, {Method.RK2: (1 / 1000, 1 / 2000), Method.RK4: (1 / 700, 1 / 1400)}
"""Of K2 over that of the base case, and the steps [s] that are stable then."""
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
ADAPTIVES = (Method.DOPRI5, Method.ESDIRK4)
REFERENCE, TIGHT = 0.2 / 64, 1e-9  # s, and a tolerance
TIMES = RECORDED * np.arange(round(DURATION / RECORDED) + 1)
MEMORY, MEMORY_STEPS, MEMORY_REFERENCE = ConvolutionRadiation(length=60.0), (0.2, 0.1, 0.05), 0.0125
LAGS = (0.1, 0.05, 0.025)  # s, of the convolution by numpy
PROPAGATED, CONVOLUTION = "propagated", "rk4, convolution"
SCIPY, BY_HAND = {name: f"solve_ivp, {name}" for name in ("RK45", "DOP853")}, "numpy, rk4"
SCIPY_CONVOLUTION = "solve_ivp, RK45, convolution"
STYLES = {
    "rk2": ("#56B4E9", "o-"),
    "heun": ("#E69F00", "o-"),
    "rk4": ("#009E73", "o-"),
    "dopri5": ("#0072B2", "o-"),
    "esdirk4": ("#CC79A7", "o-"),
    PROPAGATED: ("#000000", "D"),
    CONVOLUTION: ("#009E73", "^:"),
    SCIPY["RK45"]: ("#D55E00", "s--"),
    SCIPY["DOP853"]: ("#8C2D04", "v--"),
    SCIPY_CONVOLUTION: ("#D55E00", "^:"),
    BY_HAND: ("0.45", "s--"),
}
Runs = dict[tuple[str, float], Callable[[], Timed]]


@dataclass(frozen=True)
class Trial:
    """One run: its ``setting`` is a step [s] or a tolerance; the error is over the range."""

    solver: str
    setting: float
    error: float
    seconds: float


def answer() -> Answer:
    """Errors and CPU times of the sphere and of the base case."""
    heave, heave_own = _sphere()
    surge, surge_own = _base_case()
    stiff, stiff_own = _stiff_contact()
    return Answer(
        {
            f"Sphere, {DURATION:g} s: heave": [_row(trial) for trial in heave],
            "Base case, the first 700 s: surge": [_row(trial) for trial in surge],
            f"The same with K2 {STIFF:g} times as stiff": [_row(trial) for trial in stiff],
            f"Least CPU time for an error of heave of {ASKED:g}": _compared(heave),
            f"Least CPU time for an error of surge of {ASKED:g}": _rows(_cheapest(surge)),
            f"The same with K2 {STIFF:g} times as stiff, {ASKED:g}": _rows(_cheapest(stiff)),
        },
        [
            f"References: rk4 at {REFERENCE:g} s, its own error {heave_own:.0e};"
            f" rk4 at {FINEST:g} s, its own error {surge_own:.0e};"
            f" dopri5 at a tolerance of {TIGHT:g}, its own error {stiff_own:.0e}.",
            _first_order(heave),
        ],
        _picture(
            {
                "sphere: heave": (heave, heave_own),
                "base case: surge": (surge, surge_own),
                f"K2 {STIFF:g} times as stiff: surge": (stiff, stiff_own),
            }
        ),
    )


def _sphere() -> tuple[list[Trial], float]:
    """All trials of the sphere, and the error of the reference."""
    found = interleaved({**_stepped(), **_propagated(), **_with_numpy()}, REPEATS)
    direct = interleaved({**_convolved(), **_convolved_by_numpy()}, 1)
    fine, coarse = (_motion(_ours(step=h), HEAVE) for h in (REFERENCE, 2 * REFERENCE))
    fine_direct = _motion(_direct(MEMORY_REFERENCE), HEAVE)
    trials = [*_judged(found, fine, HEAVE), *_judged(direct, fine_direct, HEAVE)]
    return trials, _largest(coarse - fine, fine) / 15


def _base_case() -> tuple[list[Trial], float]:
    """All trials of the base case, and the error of the reference."""
    runs: Runs = {
        (method, step): partial(_attempt, _short(step, method))
        for method, steps in BASE_STEPS.items()
        for step in steps
    }
    for method in ADAPTIVES:
        for relative in TOLERANCES[2:]:
            scene = _tolerant(short_case(0.1, method), relative)
            runs[method, relative] = partial(time_loop, compiled(scene, in_plane=True))
    fine, coarse = (_motion(_short(step), SURGE) for step in (FINEST, 2 * FINEST))
    found = interleaved(runs, REPEATS)
    return _judged(found, fine, SURGE), _largest(coarse - fine, fine) / 15


def _stiff_contact() -> tuple[list[Trial], float]:
    """All trials of the base case with stiff nodes, and the error of the reference."""
    runs: Runs = {
        (method, step): partial(_attempt, compiled(stiff_case(step, method), in_plane=True))
        for method, steps in STIFF_STEPS.items()
        for step in steps
    }
    for method in ADAPTIVES:
        for relative in (1e-4, 1e-5, 1e-6, 1e-7):
            scene = _tolerant(stiff_case(0.1, method), relative)
            runs[method, relative] = partial(_attempt, compiled(scene, in_plane=True))
    fine, coarse = (
        _motion(compiled(_tolerant(stiff_case(0.1, Method.DOPRI5), x), in_plane=True), SURGE)
        for x in (TIGHT, 10.0 * TIGHT)
    )
    return _judged(interleaved(runs, 1), fine, SURGE), _largest(coarse - fine, fine) / 10.0


def stiff_case(step: float, method: Method) -> Scene:
    """`short_case` with K2 `STIFF` times as stiff, recorded on a grid of these steps."""
    scene = short_case(0.1, method)
    fender = scene.forces["interface"]
    assert isinstance(fender, Fender)
    assert isinstance(fender.friction, StickSlip)
    law = replace(fender.friction, stiffness=STIFF * fender.friction.stiffness)
    forces = {**scene.forces, "interface": replace(fender, friction=law)}
    solver = replace(scene.solver, step=step)
    return replace(scene, forces=forces, solver=solver).with_output(step=1.0)


def _short(step: float, method: Method = Method.RK4) -> Several:
    """The base case, which is symmetric, in its plane."""
    return compiled(short_case(step, method), in_plane=True)


def _attempt(run: Several) -> Timed:
    """The run, or as far as it goes."""
    try:
        return time_loop(run)
    except SimulationError as error:
        return Timed(error.dataset, nan)


def _ours(**solver: Any) -> Several:
    """The sphere with these settings of the solver."""
    scene = sphere(DURATION, kinematics=Kinematics.LINEAR, output_step=RECORDED, **solver)
    return with_states(compiled(scene), STATES)


def _direct(step: float) -> Several:
    """The sphere with a convolution."""
    return compiled(sphere(DURATION, MEMORY, Kinematics.LINEAR, RECORDED, step=step))


def _stepped() -> Runs:
    runs: Runs = {
        (method, step): partial(time_loop, _ours(method=method, step=step))
        for method, steps in STEPS.items()
        for step in steps
    }
    for method in ADAPTIVES:
        for relative in TOLERANCES:
            tolerance = Tolerance(relative, relative, relative)
            settings = {"method": method, "step": 0.1, "tolerance": tolerance}
            runs[method, relative] = partial(time_loop, _ours(**settings))
    return runs


def _propagated() -> Runs:
    return {(PROPAGATED, 0.1): partial(time_all, _ours(step=0.1, linear=LinearScenes.EXACT))}


def _convolved() -> Runs:
    return {(CONVOLUTION, step): partial(time_loop, _direct(step)) for step in MEMORY_STEPS}


def _with_numpy() -> Runs:
    """`solve_ivp` over its tolerances, RK4 by hand over steps."""
    p = by_numpy.equation(_ours(step=0.1))
    runs: Runs = {}
    for method, name in SCIPY.items():
        for rtol in TOLERANCES:
            call = partial(by_numpy.by_solve_ivp, p.with_states, p.sizes.size, TIMES, method)
            runs[name, rtol] = partial(timed, partial(call, rtol=rtol, atol=rtol * p.sizes))
    p = replace(p, by_hand=True)
    for h in (0.2, 0.1, 0.05, 0.025):
        counts = round(DURATION / h), h, round(RECORDED / h)
        solve = partial(by_numpy.by_rk4, p.with_states, p.sizes.size, *counts)
        runs[BY_HAND, h] = partial(timed, solve)
    return runs


def _convolved_by_numpy() -> Runs:
    """The first-order convolution, with steps as long as its lags."""
    runs: Runs = {}
    for lag in LAGS:
        p = by_numpy.equation(_direct(lag))
        runs[SCIPY_CONVOLUTION, lag] = partial(timed, partial(_with_buffer, p))
    return runs


def _with_buffer(p: by_numpy.Equation) -> np.ndarray:
    rates = by_numpy.Convolution(p).rates
    return by_numpy.by_solve_ivp(rates, 12, TIMES, max_step=p.lag, rtol=1e-6, atol=1e-6)


def _tolerant(scene: Scene, relative: float) -> Scene:
    """With this tolerance, also in m and m/s, and of angles as if at 100 m."""
    tolerance = Tolerance(relative, relative, relative / 100)
    return replace(scene, solver=replace(scene.solver, tolerance=tolerance))


def _motion(run: Several, dof: int) -> np.ndarray:
    """Of a run that is not timed."""
    return motions(time_loop(run).result)[:, dof]


def _judged(found: Mapping[tuple[str, float], Timed], fine: np.ndarray, dof: int) -> list[Trial]:
    """Trials with their errors."""
    trials = []
    for (solver, setting), run in found.items():
        motion = _motions(run.result)[:, dof]
        error = _largest(motion - fine[: motion.size], fine)
        trials.append(Trial(str(solver), setting, error, run.seconds))
    return trials


def _motions(result: np.ndarray | xr.Dataset) -> np.ndarray:
    return result if isinstance(result, np.ndarray) else motions(result)


def _largest(difference: np.ndarray, motion: np.ndarray) -> float:
    """Over the range of the motion; NaN if the run ended before."""
    if difference.size < motion.size:
        return nan
    return float(np.abs(difference).max() / np.ptp(motion))


def _row(trial: Trial) -> Row:
    return {
        "solver": trial.solver,
        "step [s] or tolerance": f"{trial.setting:g}",
        "error of the range": "failed" if isnan(trial.error) else f"{trial.error:.1e}",
        "CPU time [s]": "-" if isnan(trial.seconds) else trial.seconds,
    }


def _lines(trials: list[Trial]) -> Iterator[tuple[str, list[Trial]]]:
    """Trials by their solver."""
    for solver in dict.fromkeys(trial.solver for trial in trials):
        yield solver, [trial for trial in trials if trial.solver == solver]


def _cheapest(trials: list[Trial]) -> dict[str, Trial]:
    """Of each solver the cheapest run with no larger an error than asked for."""
    return {
        solver: min(good, key=lambda trial: trial.seconds)
        for solver, line in _lines(trials)
        if (good := [trial for trial in line if trial.error <= ASKED])
    }


def _rows(trials: Mapping[str, Trial]) -> list[Row]:
    return [_row(trial) for trial in trials.values()]


def _compared(trials: list[Trial]) -> list[Row]:
    """The cheapest runs beside what `solve_ivp` costs."""
    least = _cheapest(trials)
    scipy = min(least[name].seconds for name in SCIPY.values() if name in least)
    return [
        {**_row(trial), "solve_ivp's over it": scipy / trial.seconds} for trial in least.values()
    ]


def _first_order(trials: list[Trial]) -> str:
    """What the best error of the first-order convolution costs."""
    best = min((t for t in trials if t.solver == SCIPY_CONVOLUTION), key=lambda t: t.error)
    ours = min(t.seconds for t in trials if t.solver == Method.RK4 and t.error <= ASKED)
    return (
        f"{SCIPY_CONVOLUTION}: {best.error:.1e} for {best.seconds / ours:.0f} times the CPU time"
        f" that rk4 needs for {ASKED:g}."
    )


def _picture(panels: Mapping[str, tuple[list[Trial], float]]) -> Figure:
    """Errors over CPU time: the sphere, the base case, and that with stiff nodes."""
    figure = Figure((15.0, 4.8), dpi=100, layout="constrained")
    for axis, (title, (trials, own)) in zip(
        figure.subplots(1, len(panels), sharey=True), panels.items(), strict=True
    ):
        _draw(axis, trials, own)
        axis.set_title(title)
    figure.axes[0].set_ylabel("largest error of the range")
    figure.legend(
        *figure.axes[0].get_legend_handles_labels(), loc="outside right center", frameon=False
    )
    return figure


def _draw(axis: Axes, trials: list[Trial], own: float) -> None:
    for solver, line in _lines(trials):
        colour, style = STYLES[solver]
        seconds, errors = [t.seconds for t in line], [t.error for t in line]
        axis.loglog(seconds, errors, style, color=colour, label=solver, markersize=4, linewidth=1.2)
    axis.axhline(own, color="0.5", linewidth=0.8, linestyle=":")
    axis.axhline(ASKED, color="0.8", linewidth=0.8)
    axis.xaxis.set_minor_formatter(NullFormatter())  # of less than a decade they would overlap
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axis.xaxis.set_major_formatter("{x:g}")
    axis.set_xlabel("CPU time [s]")
    axis.grid(alpha=0.3)
    axis.spines[["top", "right"]].set_visible(False)
