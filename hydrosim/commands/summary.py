"""What a run comes down to, in a few lines for the terminal."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from rich.markup import escape
from rich.table import Table

from hydrosim.forces.trigger import BEFORE
from hydrosim.results.stages import stage_lines, stages
from hydrosim.scene import RadiationModel
from hydrosim.studies.run.converge import Study

AUTOMATIC = f"{RadiationModel.AUTOMATIC}: "


def lines(run: xr.Dataset) -> Iterator[str]:
    """Title, status, speed, motions, contact and energy residual of a run."""
    a = run.attrs
    yield str(a["title"])
    if "initial_run" in a:
        yield f"start     {a['initial_run']} at {a['initial_time']:g} s"
    simulated = np.ptp(run.time.values) if run.time.size else 0.0
    yield f"status    {a['status']}, {simulated:g} s simulated"
    speed = a["solver_steps"] / max(a["wall_time"], 1e-9)
    steps = (
        f"{a['solver_method']}, {a['solver_steps']:,} steps, {a['solver_events']:,}"
        f" events, {a['wall_time']:.2f} s ({speed:,.0f} steps/s)"
    )
    exact = f"{a.get('solver_linear')}, {a['wall_time']:.2f} s"
    yield f"solver    {steps if a['solver_steps'] else exact}"
    for body in run.body.values:
        yield from _motions(run, str(body))
    if "fender" in run.dims:
        yield from _contact(run)
        yield from stage_lines(xr.Dataset(stages(run)))
    if "spring" in run.dims:
        yield from _springs(run)
    if "gap" in run.dims:
        yield from _clearances(run)
    if "trigger" in run.dims:
        yield from _waiting(run)
    for body, model in _automatic(run):
        yield f"radiation {body}: {model}"
    for line in str(a.get("radiation_errors", "")).splitlines():
        yield f"radiation {line}"
    for warning in str(a.get("warnings", "")).splitlines():
        yield f"warning   {warning}"
    yield f"energy    residual {a['energy_residual_relative']:.1e} of the energy exchanged"


def _waiting(run: xr.Dataset) -> Iterator[str]:
    """Elements and pumps that have not begun by the end."""
    for name in run.trigger.values[np.all(run.trigger_stage.values == BEFORE, axis=0)]:
        yield f"{name:12s} has not begun: what it waits for did not come"


def _automatic(run: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Bodies and what was chosen for their radiation, once for those of one database."""
    models = {str(body): str(run.attrs.get(f"radiation_{body}", "")) for body in run.body.values}
    chosen = {model: body for body, model in models.items() if model.startswith(AUTOMATIC)}
    for model, body in chosen.items():
        yield body, model


def _motions(run: xr.Dataset, body: str) -> Iterator[str]:
    position = run.position.sel(body=body)
    for dof in run.dof.values:
        x, unit = position.sel(dof=dof).values, "m"
        if not np.any(x):
            continue
        if dof in ("roll", "pitch", "yaw"):
            x, unit = np.degrees(x), "deg"
        yield (
            f"{body:9s} {dof:6s} mean {x.mean():.3f}, std {x.std():.3f}, min {x.min():.3f},"
            f" max {x.max():.3f}, end {x[-1]:.3f} {unit}"
        )


def _contact(run: xr.Dataset) -> Iterator[str]:
    modes, time = run.fender_mode.values, run.time.values
    for i, name in enumerate(run.fender.values):
        touching = np.flatnonzero(modes[:, i] > 0)
        if touching.size == 0:
            yield f"{name:12s} no contact"
            continue
        share = [np.mean(modes[touching[0] :, i] == mode) for mode in range(3)]
        yield (
            f"{name:12s} first contact {time[touching[0]]:.1f} s; then open {share[0]:.0%},"
            f" stick {share[1]:.0%}, slip {share[2]:.0%};"
            f" slipped {float(run.fender_slip_distance[-1, i]):.3f} m"
        )


def _springs(run: xr.Dataset) -> Iterator[str]:
    for name in run.spring.values:
        line = run.sel(spring=name)
        tension, slack = line.spring_tension.values / 1e3, float(np.mean(line.spring_mode == 0))
        yield (
            f"{name:12s} tension mean {tension.mean():.1f}, max {tension.max():.1f} kN;"
            f" slack {slack:.0%}"
        )


def _clearances(run: xr.Dataset) -> Iterator[str]:
    for name in run.gap.values:
        gap = run.clearance.sel(gap=name).values
        yield f"{name:12s} clearance min {gap.min():.3f}, end {gap[-1]:.3f} m"


def convergence(study: Study) -> Table:
    """Table of a convergence study."""
    reference = f"reference: rk4 at {study.reference_step:g} s"
    table = Table(title=f"{reference}, its own error {study.reference_error:.1e} m")
    for heading in ("method", "setting", "motion [m]", "order", "crawl [m]", "energy"):
        table.add_column(escape(heading), justify="left" if heading == "method" else "right")
    table.add_column("evaluations", justify="right")
    table.add_column(escape("time [s]"), justify="right")
    last = None
    for trial in study.trials:
        same = last is not None and last.method is trial.method
        order = trial.order(last) if last is not None and same else np.nan
        figures = (f"{trial.motion:.1e}", "" if np.isnan(order) else f"{order:.1f}")
        costs = (f"{trial.evaluations:,}", f"{trial.seconds:.2f}")
        if trial.remark:
            figures, costs = ("failed", ""), ("", "")
        last = trial
        errors = (f"{trial.crawl:.1e}", f"{trial.energy:.1e}")
        table.add_row(str(trial.method), f"{trial.setting:g}", *figures, *errors, *costs)
    return table
