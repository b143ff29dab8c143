"""What a run comes down to, in a few lines for the terminal."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr


def lines(run: xr.Dataset) -> Iterator[str]:
    """Title, status, speed, motions, contact and energy residual of a run."""
    a = run.attrs
    yield str(a["title"])
    yield f"status    {a['status']}, {float(run.time[-1]) if run.time.size else 0.0:g} s simulated"
    speed = a["solver_steps"] / max(a["wall_time"], 1e-9)
    yield (
        f"solver    {a['solver_method']}, {a['solver_steps']:,} steps, {a['solver_events']:,}"
        f" events, {a['wall_time']:.2f} s ({speed:,.0f} steps/s)"
    )
    for body in run.body.values:
        yield from _motions(run, str(body))
    if "fender" in run.dims:
        yield from _contact(run)
    for warning in str(a.get("warnings", "")).splitlines():
        yield f"[yellow]warning[/]   {warning}"
    yield f"energy    residual {a['energy_residual_relative']:.1e} of the integral of |wave power|"


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
