"""Causes of the motion of a body in the stages of a run that records impulses
(`hydrosim.results.output`): mean forces, works and displacements by element, contact mode and
direction.

The mean force of a row in a stage is its impulse over the duration. The sum of mean forces is the
change of momentum over the duration. For friction in slip, with the time T in which a point slips
and the mean E over that time,

    int f dt = -mu_k T (E[N] E[d] + Cov(N, d)) - int C3 |v2| d dt

so it has a mean for three reasons. The point slips longer one way (`DIRECTION`). It is pressed
harder while it slips one way (`COVARIANCE`). It slips further one way (`SLIP_DAMPING`: C3). The
part by which a law gives less than mu_k N is `OTHER`. In `STICK`, friction holds the point. A
direction in which a body does not move at all is held: its `REACTION` balances the other forces.
Forces of joints whose motions are coordinates are not integrated: on bodies of such a run,
`JOINT_REACTIONS` is what the other forces lack.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.results.dataset import KIND, ResultKind
from hydrosim.results.phases import CONTACT_WEIGHT, STAGE_TIME, STAGES, Phase
from hydrosim.results.variables import describe_coordinates, quantity_attributes

if TYPE_CHECKING:
    import xarray as xr

DIRECTION_AXES = {"surge": "x", "sway": "y", "heave": "z"}
SHOWN_FRACTION = 1e-6
"""fraction of the largest value, below which a row is not shown"""
REQUIRED_VARIABLES = ("impulse", "work", "momentum")
IMPULSES_HINT = "expected a run with output: {impulses: true}, as of hydrosim run CASE.yaml --set"
IMPULSES_HINT += " output.impulses=true"
STICK, DIRECTION, COVARIANCE, SLIP_DAMPING, OTHER = FRICTION_PARTS = (
    *("stick", "direction of slip", "load with direction"),
    *("slip damping", "below mu_k N"),
)
REACTION = "reaction of held directions"
JOINT_REACTIONS = "reactions of joints"
WHOLE_RUN, IN_CONTACT = "whole run", "in contact"
EXPLAINED_PHASES = tuple(phase.name.lower().replace("_", " ") for phase in Phase)
VARIABLE_LABELS = {
    "span_begin": ("beginning of the stage", "s"),
    "span_end": ("end of the stage", "s"),
    "mean_force": ("mean force, mean moment", "N or N m"),
    "force_work": ("work of the force by degree of freedom", "J"),
    "momentum_rate": ("change of momentum over the duration", "N or N m"),
    "unbalanced": ("mean forces minus the change of momentum over the duration", "N or N m"),
    "work_missing": ("works of all forces minus the change of kinetic energy", "J"),
    "displacement": ("displacement over the stage", "m or rad"),
    "mode_share": ("fraction of the time in a contact mode", "1"),
    "mode_friction": ("mean over the stage of friction in a contact mode", "N"),
    "mode_press": ("mean over the stage of the normal force in a contact mode", "N"),
    "mode_moved": ("displacement of the point along the plane in a contact mode", "m"),
    "mode_work": ("work of friction on the body in a contact mode", "J"),
    "slip_mean_load": ("mean normal force in slip", "N"),
    "slip_mean_direction": ("mean direction of slip", "1"),
    "slip_covariance": ("covariance of normal force and direction of slip", "N"),
    "friction_part": ("mean of friction over the stage, by its cause", "N"),
    "slip_ahead": ("displacement of the node in slip towards the positive axis", "m"),
    "slip_astern": ("displacement of the node in slip towards the negative axis", "m"),
    "load_ahead": ("mean normal force in slip towards the positive axis", "N"),
    "load_astern": ("mean normal force in slip towards the negative axis", "N"),
}
"""Long names and units of the explained variables."""


class ExplainedStage(NamedTuple):
    """A stage with its name, from the output time ``begin`` to ``end``; None if there is none."""

    name: str
    begin: int | None
    end: int | None


def explain_run(run: xr.Dataset, start: float = -np.inf, until: float = np.inf) -> xr.Dataset:
    """Variables of `VARIABLE_LABELS` for every stage (span, ...) from ``start`` to ``until`` [s].
    They are NaN if a run has no such stage, or a contact no slip in it.

    Raises InputError if the run has no impulses, or fewer than two output times in the interval."""
    import xarray as xr  # slow to load

    missing = [name for name in REQUIRED_VARIABLES if name not in run]
    if missing:
        raise InputError(f"found a run without {', '.join(missing)}; {IMPULSES_HINT}.")
    run = run.sel(time=slice(start, until))
    if run.time.size < 2:
        text = f"found {run.time.size} output times from {start:g} to {until:g} s"
        raise InputError(f"{text}; expected two or more.")
    explained = [_explain_stage(run, stage) for stage in stages(run)]
    explanations = xr.concat(explained, "span", join="exact").drop_vars("time", errors="ignore")
    for name, (what, unit) in VARIABLE_LABELS.items():
        if name in explanations:
            explanations[name].attrs = quantity_attributes(what, unit)
    describe_coordinates(explanations)
    explanations.attrs[KIND] = ResultKind.EXPLANATION.value
    return explanations


def explanations_of_runs(runs: xr.Dataset) -> xr.Dataset:
    """Explained variables of each run in a file of many runs. Raises InputError if the runs have no
    impulses."""
    if "mean_force" not in runs:
        raise InputError(f"found runs without impulses; {IMPULSES_HINT}, or a study with the same.")
    groups = [name for name in ("fender_group", "fender_kinetic") if name in runs]
    explanations = runs.set_coords(groups)[[name for name in VARIABLE_LABELS if name in runs]]
    return explanations.load().assign_attrs({KIND: ResultKind.EXPLANATION.value})


def stages(run: xr.Dataset) -> Iterator[ExplainedStage]:
    """Stages: the whole run, the phases of each group of contacts, and the time from its first
    contact on."""
    yield ExplainedStage(WHOLE_RUN, 0, run.time.size - 1)
    groups = run.contact_group.values if "contact_group" in run.dims else ()
    for group in groups:
        of = run.contact_phase.sel(contact_group=group).values
        prefix = f"{group}: " if len(groups) > 1 else ""
        for phase, name in zip(Phase, EXPLAINED_PHASES, strict=True):
            yield _stage_while(f"{prefix}{name}", of == phase)
        yield _stage_while(f"{prefix}{IN_CONTACT}", of > Phase.MOORED)
        if (
            CONTACT_WEIGHT in run.coords
            and float(run[CONTACT_WEIGHT].sel(contact_group=group)) > 0.0
        ):
            yield from _transfer_stages(run, group, prefix)


def _transfer_stages(run: xr.Dataset, group: str, prefix: str) -> Iterator[ExplainedStage]:
    """Stages between the stages of a transfer of weight."""
    times = run[STAGE_TIME].sel(contact_group=group, stage=list(STAGES)).values
    at = [int(np.searchsorted(run.time.values, t)) if np.isfinite(t) else None for t in times]
    for k, name in enumerate(STAGES[1:]):
        begin, end = at[k : k + 2]
        is_inside = begin is not None and end is not None and begin < end < run.time.size
        ends = (begin, end) if is_inside else (None, None)
        yield ExplainedStage(f"{prefix}{STAGES[k]} to {name}", *ends)


def _stage_while(name: str, during: np.ndarray) -> ExplainedStage:
    """Stage from the first to the last time at which a condition holds."""
    at = np.flatnonzero(during)
    if at.size == 0 or at[0] == during.size - 1:
        return ExplainedStage(name, None, None)
    return ExplainedStage(name, int(at[0]), min(int(at[-1]) + 1, during.size - 1))


def _explain_stage(run: xr.Dataset, stage: ExplainedStage) -> xr.Dataset:
    """Variables of one stage."""
    import xarray as xr  # slow to load

    begin, end = stage.begin or 0, stage.end or 0
    d = run[_integral_names(run)].isel(time=end) - run[_integral_names(run)].isel(time=begin)
    ends = run.time.values[[begin, end]]
    time = float(np.diff(ends)[0]) or np.nan
    still = run.position.max("time") == run.position.min("time")
    lacking = d.momentum - d.impulse.sum("force")
    held = lacking.where(still, 0.0).expand_dims(force=[REACTION])
    joined = lacking.where(~still & _has_trees(run), 0.0).expand_dims(force=[JOINT_REACTIONS])
    reaction = xr.concat([held, joined], "force")
    variables = {
        "span_begin": xr.DataArray(ends[0]),
        "span_end": xr.DataArray(ends[1]),
        "mean_force": xr.concat([d.impulse, reaction], "force") / time,
        "force_work": xr.concat([d.work, 0.0 * reaction], "force"),
        "momentum_rate": d.momentum / time,
        "unbalanced": (d.impulse.sum("force") + reaction.sum("force") - d.momentum) / time,
        "work_missing": d.work.sum() - d.energy_kinetic,
        "displacement": d.position,
        **(_contact_variables(d, run, time) if "contact_time" in d else {}),
    }
    explanation = xr.Dataset(variables) if stage.end else xr.Dataset(variables).where(False)
    named = explanation.rename(axis="direction") if "axis" in explanation.dims else explanation
    return named.assign_coords(span=stage.name)


def _has_trees(run: xr.Dataset) -> bool:
    """Whether a run has joints whose motions are coordinates. With tanks, flows take momentum as
    well, so that the part of the joints is not known."""
    locks = set(run.lock.values) if "lock" in run.coords else set()
    joints = set(run.joint.values) if "joint" in run.coords else set()
    return bool(joints - locks) and "tank_level" not in run


def _integral_names(run: xr.Dataset) -> list[str]:
    names = (str(name) for name in run.data_vars)
    contact = [n for n in names if n.startswith("slip_") or n in CONTACTS]
    return ["position", "energy_kinetic", *REQUIRED_VARIABLES, *contact]


CONTACTS = {
    *("contact_time", "contact_impulse", "contact_press", "contact_friction"),
    *("contact_moved", "contact_friction_work", "contact_press_work"),
}


def _contact_variables(d: xr.Dataset, run: xr.Dataset, time: float) -> dict[str, xr.DataArray]:
    """Variables of the contacts in a stage of this ``time`` [s], from the changes ``d``."""
    import xarray as xr  # slow to load

    slipped = d.contact_time.sel(contact_mode="slip", drop=True)
    slipped = slipped.where(slipped > 0.0)
    load = d.contact_impulse.sel(contact_mode="slip", drop=True) / slipped
    direction = d.slip_direction / slipped
    covariance = d.slip_load / slipped - load * direction
    friction = d.contact_friction.sel(contact_mode=["stick", "slip"]) / time
    pressed = -run.fender_kinetic * slipped / time
    parts = {
        STICK: friction.sel(contact_mode="stick", drop=True),
        DIRECTION: (pressed * load * direction).fillna(0.0),
        COVARIANCE: (pressed * covariance).fillna(0.0),
        SLIP_DAMPING: -d.slip_damping / time,
    }
    parts[OTHER] = friction.sum("contact_mode") - sum(parts.values())
    part = xr.concat(
        list(parts.values()), xr.DataArray(list(FRICTION_PARTS), dims="part", name="part")
    )
    return {
        "mode_share": d.contact_time / time,
        "mode_friction": d.contact_friction / time,
        "mode_press": d.contact_press / time,
        "mode_moved": d.contact_moved,
        "mode_work": d.contact_friction_work,
        "slip_mean_load": load,
        "slip_mean_direction": direction,
        "slip_covariance": covariance,
        "friction_part": part.transpose("part", "fender", "axis"),
        **_slip_by_sign(d),
    }


def _slip_by_sign(d: xr.Dataset) -> dict[str, xr.DataArray]:
    """Slip towards the positive and the negative axes, separately."""
    ahead, load = d.slip_direction_ahead, d.slip_load_ahead
    astern, other = ahead - d.slip_direction, load - d.slip_load
    return {
        "slip_ahead": d.slip_moved_ahead,
        "slip_astern": d.slip_moved - d.slip_moved_ahead,
        "load_ahead": load / ahead.where(ahead > 0.0),
        "load_astern": other / astern.where(astern > 0.0),
    }


def stages_with_values(values: xr.DataArray) -> list[str]:
    """Stages that have values."""
    has_values = values.notnull().any([dim for dim in values.dims if dim != "span"])
    return [str(span) for span in has_values.span.values[has_values.values]]


def significant_entries(values: xr.DataArray, dim: str, share: float = SHOWN_FRACTION) -> list[str]:
    """Entries of a dimension that somewhere exceed a fraction of the largest value."""
    largest = abs(values).max([d for d in values.dims if d != dim])
    return [str(name) for name in values[dim].values[largest.values > share * float(largest.max())]]
