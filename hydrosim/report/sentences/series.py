"""Charts of a run: its motions, waves, contacts and forces over time, and the energy ledger."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydrosim.dofs import DOFS
from hydrosim.files.document_nodes import Chart, Node, Table, Value
from hydrosim.files.series import unit_of
from hydrosim.results.channels import channel_names, group_by_size
from hydrosim.results.channels import channel_series as channel
from hydrosim.results.phases import CONTACT_WEIGHT, GROUP_IMPULSE, transferred_fraction
from hydrosim.statistics.results import crawl

CHART_ROUNDING_FRACTION = 1e-9
"""Of the largest of a chart's lines: what is less throughout is rounding."""
LOAD_UNITS = {"N", "N m", "W"}
"""Units of charts in which small lines have an axis of their own."""
CHARTS_NOTE = (
    "Drag over a chart to look closer, double-click to see all; all charts follow. By keyboard:"
    " arrows move the cursor, + and - look closer and wider, 0 shows all. A name in a legend hides"
    " its line."
)
ENERGY_LABELS = {"stored": "stored", "work": "work done", "dissipated": "lost"}


class Motions(NamedTuple):
    """Charts of the translations and of the rotations of a variable over body and degree of
    freedom: what they are called, and their SI units."""

    title: str
    linear: str
    angular: str


class LineChart(NamedTuple):
    """A chart of a variable over time and one dimension."""

    dim: str
    title: str
    unit: str


DISPLACEMENTS = Motions("", "m", "rad")
VELOCITIES = Motions("velocity ", "m/s", "rad/s")
JOINT_LOADS = Motions("force ", "N", "N m")
MAIN_CHARTS = {
    "fender_normal_force": LineChart("fender", "Normal force of contacts", "N"),
    "spring_tension": LineChart("spring", "Tension of lines", "N"),
    "line_tension": LineChart("line", "Tension of catenaries at the fairlead", "N"),
    "winch_tension": LineChart("winch", "Tension of winches", "N"),
    "compensator_tension": LineChart("compensator", "Tension of compensators", "N"),
    "strut_force": LineChart("strut", "Force of struts", "N"),
    "torsion_moment": LineChart("torsion_spring", "Moment of torsion springs", "N m"),
    "pto_power": LineChart("pto", "Power of power take-offs", "W"),
    "clearance": LineChart("gap", "Clearances", "m"),
    "tank_level": LineChart("tank", "Levels of tanks", "m"),
    "slow_draught": LineChart("body", "Slow draught", "m"),
}
FOLDED_CHARTS = {
    "contact_load": LineChart("contact_group", "Load of groups of contacts", "N"),
    "fender_compression": LineChart("fender", "Compression of contacts, negative when open", "m"),
    "fender_slip_distance": LineChart("fender", "Distance slipped", "m"),
    "line_anchor_tension": LineChart("line", "Tension of catenaries at the anchor", "N"),
    "line_grounded": LineChart("line", "Length of catenaries on the seabed", "m"),
    "winch_length": LineChart("winch", "Length off the drums of winches", "m"),
    "winch_speed": LineChart("winch", "Speed of pay-out of winches", "m/s"),
    "compensator_stroke": LineChart("compensator", "Stroke of compensators", "m"),
    "strut_length": LineChart("strut", "Length of struts", "m"),
    "torsion_angle": LineChart("torsion_spring", "Twist of torsion springs", "rad"),
    "guide_force": LineChart("guide", "Force of guides", "N"),
    "pump_rate": LineChart("pump", "Pump rates", "kg/s"),
    "wave_elevation_at_probe": LineChart("probe", "Waves at probes", "m"),
}


def main_charts(run: xr.Dataset) -> Iterator[Chart]:
    """What people look at first."""
    for body in map(str, run.body.values):
        yield from _motions(run.position, body, DISPLACEMENTS, "displacement", "rotation")
    if np.any(run.wave_elevation):
        yield Chart("Wave elevation at the origin", "m", {"wave": _over_time(run.wave_elevation)})
    if "wind_speed" in run:
        yield Chart("Wind speed at 10 m", "m/s", {"wind": _over_time(run.wind_speed)})
    if "fender_mode" in run:
        yield Chart(
            "Contact modes", "share of time", _series_by_label(run, "fender_mode", "fender"), True
        )
    yield from _of_joints(run, "joint_position", "Motions of joints")
    yield from _lines(run, MAIN_CHARTS)
    used = {n: channel(run, n)[0] for n in channel_names(run) if n.startswith("utilisation.")}
    yield from _without_rounding(Chart("Utilisation of capacities", "1", used))
    if "fender_node" in run:
        gone = crawl(run)
        for axis in map(str, gone.axis.values):
            lost_by_fender = _series_by_label(
                gone.sel(axis=axis).to_dataset(name="gone"), "gone", "fender"
            )
            yield from _without_rounding(
                Chart(f"Crawl of contact points in {axis}", "m", lost_by_fender)
            )
    if CONTACT_WEIGHT in run.coords and GROUP_IMPULSE in run:
        share = transferred_fraction(run).to_dataset(name="share")
        lost_by_fender = _series_by_label(share, "share", "contact_group")
        yield Chart("Share of the weight transferred", "share", lost_by_fender)


def more_charts(run: xr.Dataset) -> Iterator[Chart]:
    """What is folded away: velocities, forces one by one, and more of the contacts."""
    yield from _lines(run, FOLDED_CHARTS, folded=True)
    yield from _of_joints(run, "joint_velocity", "Rates of joints", folded=True)
    title = "Springs, damping, stops and friction in joints"
    yield from _of_joints(run, "joint_motion_force", title, folded=True)
    for joint in map(str, run.joint.values) if "joint_force" in run else ():
        load = run.joint_force.rename(joint="body")
        of = JOINT_LOADS._replace(title=f"load of joint {joint}: ")
        yield from _motions(load, joint, of, "force", "moment", True)
    for axis in map(str, run.axis.values) if "fender_friction" in run else ():
        friction = _series_by_label(run.sel(axis=axis), "fender_friction", "fender")
        yield from _without_rounding(
            Chart(f"Friction of contacts in {axis}", "N", friction, folded=True)
        )
    for body in map(str, run.body.values):
        if "velocity" in run:
            yield from _motions(
                run.velocity, body, VELOCITIES, "of translation", "of rotation", True
            )
        for row in sorted(str(name) for name in run.data_vars if str(name).startswith("force_")):
            of = JOINT_LOADS._replace(title=f"{row.removeprefix('force_').replace('_', ' ')}, ")
            yield from _motions(run[row], body, of, "force", "moment", True)


def energies(run: xr.Dataset) -> Iterator[Chart]:
    """The ledger over time."""
    yield Chart("Kinetic energy", "J", {"kinetic": run.energy_kinetic.values}, folded=True)
    for part, label in ENERGY_LABELS.items():
        energies_by_name = {
            name: run[f"energy_{part}_{name}"].values for name in _ledger_names(run, part)
        }
        yield from _without_rounding(Chart(f"Energy {label}", "J", energies_by_name, folded=True))
    residual = {"residual": run.energy_residual.values}
    yield Chart("Residual of the ledger", "J", residual, folded=True)


def ledger(run: xr.Dataset) -> Iterator[Node]:
    """What became of the energy from start to end."""
    if run.time.size < 1:
        return
    kinetic = run.energy_kinetic.values
    rows = [("kinetic", Value(float(kinetic[-1]), "J"), "held at the end")]
    for part, label in ENERGY_LABELS.items():
        for name in _ledger_names(run, part):
            value = float(run[f"energy_{part}_{name}"].values[-1])
            rows.append((name.replace("_", " "), Value(value, "J"), label))
    last = float(run.energy_residual.values[-1])
    rows.append(("residual", Value(last, "J"), "not accounted for"))
    yield Table(("energy", "at the end", "what it is, since the start"), rows)


def _ledger_names(run: xr.Dataset, part: str) -> list[str]:
    start = f"energy_{part}_"
    names = (str(name) for name in run.data_vars if str(name).startswith(start))
    return [name.removeprefix(start) for name in names if run[name].any()]


def _motions(
    of: xr.DataArray, body: str, how: Motions, linear: str, angular: str, folded: bool = False
) -> Iterator[Chart]:
    body_motions = of.sel(body=body)
    for label, dofs, unit in (
        (linear, DOFS[:3], how.linear),
        (angular, DOFS[3:], how.angular),
    ):
        series = {dof: _over_time(body_motions.sel(dof=dof)) for dof in dofs}
        title = f"{body}: {how.title}{label}"
        yield from _without_rounding(Chart(title, unit, series, folded=folded))


def _of_joints(run: xr.Dataset, name: str, title: str, folded: bool = False) -> Iterator[Chart]:
    """A chart of a variable of joint motions for slides, and one for turns."""
    if name not in run:
        return
    units = {n: unit_of(run[name].attrs, [n]) for n in map(str, run.joint_motion.values)}
    every = _series_by_label(run, name, "joint_motion")
    for unit in dict.fromkeys(units.values()):
        alike = {n: x for n, x in every.items() if units[n] == unit}
        yield from _without_rounding(Chart(title, unit, alike, folded=folded))


def _lines(run: xr.Dataset, table: dict[str, LineChart], folded: bool = False) -> Iterator[Chart]:
    for name, of in table.items():
        if name in run and run[name].dims:
            series = _series_by_label(run, name, of.dim)
            groups = group_by_size(series) if of.unit in LOAD_UNITS else [series]
            for k, group in enumerate(groups):
                title = f"{of.title}: {_names(group)}" if k else of.title
                yield from _without_rounding(Chart(title, of.unit, group, folded=folded))


def _names(series: Mapping[str, np.ndarray]) -> str:
    """Names of series, or the first of many."""
    first, *others = series
    return f"{first} and {len(others)} more" if len(others) > 1 else ", ".join(series)


def _without_rounding(chart: Chart) -> Iterator[Chart]:
    """The chart of those lines that are more than rounding; none where there is none."""
    peaks = {name: _peak(values) for name, values in chart.series.items()}
    least = CHART_ROUNDING_FRACTION * max(peaks.values(), default=0.0)
    visible = {name: values for name, values in chart.series.items() if peaks[name] > least}
    if visible:
        yield replace(chart, series=visible)


def _peak(values: np.ndarray) -> float:
    return float(np.abs(np.nan_to_num(values)).max(initial=0.0))


def _series_by_label(run: xr.Dataset, name: str, dim: str) -> dict[str, np.ndarray]:
    return {str(label): _over_time(run[name].sel({dim: label})) for label in run[dim].values}


def _over_time(values: xr.DataArray) -> np.ndarray:
    return np.asarray(values.values)
