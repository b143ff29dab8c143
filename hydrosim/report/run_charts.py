"""Charts of a run over time: which lines share a chart, in which unit, and what they are called.

Pages draw these charts, and pictures arrange the same ones. A run has no chart of what its scene
lacks (contacts, waves, a degree of freedom that moves).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.elements.kind import Topic
from hydrosim.files.document_nodes import Chart, ChartLine, Nodes, ShadedPhase, Table, Value
from hydrosim.files.series import units_along
from hydrosim.results import phases
from hydrosim.results.channels import channel_names, channel_series, group_by_size
from hydrosim.results.variables import TENSIONS, VARIABLES
from hydrosim.statistics.results import crawl

if TYPE_CHECKING:
    import xarray as xr

CHARTS_NOTE = (
    "Drag over a chart to look closer, double-click to see all; all charts follow. By keyboard:"
    " arrows move the cursor, + and - look closer and wider, 0 shows all. A name in a legend hides"
    " its line."
)
NEGLIGIBLE_MOTION = 1e-6
"""In m or rad: smaller motions count as none; of the largest crawl, that along other axes."""
ROUNDING_FRACTION = 1e-9
"""Of the largest line of a chart, or of the largest load of a joint: what is less is rounding."""
LOAD_UNITS = ("N", "N m", "W")
"""Units of charts in which small lines have an axis of their own."""
ENERGY_LABELS = {"stored": "stored", "work": "work done", "dissipated": "lost"}
LOAD_LABELS = ("force", "moment")
LOAD_OF_DOF = ("N", "N m")


def charts_named(run: xr.Dataset, names: Iterable[str]) -> list[Chart]:
    """Those charts of a run, of variables and of `DERIVED`, that show more than zeros."""
    every = (
        chart
        for name in names
        for chart in (DERIVED[name][1](run) if name in DERIVED else _charts_of_variable(run, name))
    )
    return [chart for chart in every if chart.modes or chart.peak > 0.0]


def charts_about(run: xr.Dataset, first: int, end: int) -> list[Chart]:
    """Charts of a run from the `Topic` ``first`` up to, and without, the ``end``."""
    return charts_named(run, [name for name, rank in RANKS.items() if first <= rank < end])


def page_charts(run: xr.Dataset) -> list[Chart]:
    """All charts of a run but those of its energies; more of them are folded than open."""
    folded = charts_about(run, Topic.DETAILS, Topic.END)
    return [
        *charts_about(run, Topic.MOTIONS, Topic.DETAILS),
        *(replace(chart, folded=True) for chart in folded),
    ]


def _charts_of_variable(run: xr.Dataset, name: str) -> Iterator[Chart]:
    """Charts of lines of one unit; of loads, small ones have a chart of their own."""
    title, quantity, _ = VARIABLES[name].chart
    if not title or name not in run or not run[name].dims:
        return
    lines = _lines_along(run[name])
    unit = VARIABLES[name].units
    units = units_along(run, name) if " or " in unit else dict.fromkeys(lines, unit)
    groups = _contact_groups(run) if "fender" in run[name].dims else {}
    order = [] if "fender" in run[name].dims else [*lines]
    if name in TENSIONS.values():
        groups = dict.fromkeys(lines, "")
    for unit in dict.fromkeys(units.values()):
        alike = {label: line for label, line in lines.items() if units[label] == unit}
        yield from _split_by_size(Chart(title, quantity, unit, alike, "", order, groups))


def _split_by_size(chart: Chart) -> Iterator[Chart]:
    if chart.unit not in LOAD_UNITS:
        yield chart
        return
    values = {name: line.y for name, line in chart.lines.items()}
    for k, group in enumerate(group_by_size(values)):
        title = f"{chart.title}: {_names_text([*group])}" if k else chart.title
        yield replace(chart, title=title, lines={name: chart.lines[name] for name in group})


def _names_text(names: Sequence[str]) -> str:
    """Names of lines, or the first of many."""
    return f"{names[0]} and {len(names) - 1} more" if len(names) > 2 else ", ".join(names)


def _contact_groups(run: xr.Dataset) -> dict[str, str]:
    """The group of each contact; none in a run without groups."""
    if "fender_group" not in run.coords:
        return {}
    return dict(zip(map(str, run.fender.values), map(str, run.fender_group.values), strict=True))


def _lines_along(values: xr.DataArray) -> dict[str, ChartLine]:
    """Lines by the labels of the dimension besides time; without it, the quantity itself."""
    dims = [dim for dim in values.dims if dim != "time"]
    if not dims:
        return {"": ChartLine(values.values)}
    labels = values[dims[0]].values
    return {str(label): ChartLine(values.sel({dims[0]: label}).values) for label in labels}


def contact_chart(
    run: xr.Dataset, quantity: str, unit: str, values: xr.DataArray, title: str = "", axis: str = ""
) -> Chart:
    """A line for each contact, of ``values`` over time and contacts along an ``axis``."""
    return Chart(title, quantity, unit, _lines_along(values), axis, groups=_contact_groups(run))


# Motions, and other variables over degrees of freedom.


def motion_charts(run: xr.Dataset) -> Iterator[Chart]:
    """The translations and the rotations of each body that moves; all if none moves at all."""
    bodies = [*map(str, run.body.values)]
    moves = bool((np.abs(run.position.values) >= NEGLIGIBLE_MOTION).any())
    least = NEGLIGIBLE_MOTION if moves else 0.0
    for body in bodies:
        subject = body if len(bodies) > 1 else ""
        charts = _dof_charts(
            run.position.sel(body=body),
            f"{body}: ",
            ("displacement", "rotation"),
            ("m", "rad"),
            subject,
            least,
        )
        for chart in charts:
            names = [*chart.lines]
            if len(names) == 1 and not subject:
                (line,) = chart.lines.values()
                yield replace(chart, quantity=names[0], lines={"": line})
            else:
                yield chart


def _dof_charts(
    values: xr.DataArray,
    title: str,
    quantities: tuple[str, str],
    units: tuple[str, str],
    subject: str = "",
    least: float = np.finfo(float).tiny,
) -> Iterator[Chart]:
    """Charts of the translations and of the rotations, without lines that are rounding or below the
    ``least``."""
    for quantity, dofs, unit in zip(quantities, (DOFS[:3], DOFS[3:]), units, strict=True):
        lines = {dof: ChartLine(values.sel(dof=dof).values) for dof in dofs}
        chart = Chart(f"{title}{quantity}", quantity, unit, lines, subject, dofs)
        limit = max(ROUNDING_FRACTION * chart.peak, least)
        visible = {dof: line for dof, line in lines.items() if line.peak >= limit}
        if visible:
            yield replace(chart, lines=visible)


def _velocity_charts(run: xr.Dataset) -> Iterator[Chart]:
    for body in run.body.values if "velocity" in run else ():
        kinds = ("velocity of translation", "velocity of rotation")
        yield from _dof_charts(run.velocity.sel(body=body), f"{body}: ", kinds, ("m/s", "rad/s"))


def _force_charts(run: xr.Dataset) -> Iterator[Chart]:
    """Forces on each body, by what exerts them."""
    names = sorted(str(name) for name in run.data_vars if str(name).startswith("force_"))
    for body in run.body.values:
        for name in names:
            title = f"{body}: {name.removeprefix('force_').replace('_', ' ')}, "
            yield from _dof_charts(run[name].sel(body=body), title, LOAD_LABELS, LOAD_OF_DOF)


def _joint_component_charts(run: xr.Dataset) -> Iterator[Chart]:
    for joint in run.joint.values if "joint_force" in run else ():
        title = f"{joint}: load of joint {joint}: "
        load = run.joint_force.sel(joint=joint)
        yield from _dof_charts(load, title, LOAD_LABELS, LOAD_OF_DOF)


def _joint_load_charts(run: xr.Dataset) -> Iterator[Chart]:
    """Sizes of the forces and moments of joints, without those that are rounding."""
    if "joint_force" not in run:
        return
    parts = zip(LOAD_LABELS, (DOFS[:3], DOFS[3:]), LOAD_OF_DOF, strict=True)
    charts = []
    for label, dofs, unit in parts:
        size = np.sqrt(np.square(run.joint_force.sel(dof=list(dofs))).sum("dof"))
        title = f"Size of the {label} of joints"
        charts.append(Chart(title, f"joint {label}", unit, _lines_along(size)))
    least = ROUNDING_FRACTION * max(chart.peak for chart in charts)
    yield from (chart for chart in charts if chart.peak > least)


# Contacts: modes, compression, crawl, friction, transfer of weight.


def _mode_charts(run: xr.Dataset) -> Iterator[Chart]:
    if "fender_mode" in run:
        lines = _lines_along(run.fender_mode)
        yield Chart("Contact modes", "mode", "share of time", lines, modes=True)


def _compression_charts(run: xr.Dataset) -> Iterator[Chart]:
    if "fender_compression" in run:
        values = run.fender_compression.clip(min=0.0)
        yield contact_chart(run, "compression", "m", values, "Compression of contacts")


def _gap_charts(run: xr.Dataset) -> Iterator[Chart]:
    if "fender_compression" in run:
        values = -run.fender_compression.clip(max=0.0)
        yield contact_chart(run, "gap", "m", values, "Gap of open contacts")


def _crawl_charts(run: xr.Dataset) -> Iterator[Chart]:
    """Path length of the contact nodes since the start, along axes where it exceeds rounding. While
    open, a node stays at the point of last contact."""
    if "fender_node" not in run:
        return
    paths = crawl(run)
    charts = [
        contact_chart(
            run, f"crawl {axis}", "m", paths.sel(axis=axis), f"Crawl of contact points in {axis}"
        )
        for axis in map(str, run.axis.values)
    ]
    least = NEGLIGIBLE_MOTION * max(chart.peak for chart in charts)
    yield from (chart for chart in charts if chart.peak > least)


def friction_charts(run: xr.Dataset) -> Iterator[Chart]:
    """Friction along each axis."""
    for axis in map(str, run.axis.values) if "fender_friction" in run else ():
        title = f"Friction of contacts in {axis}"
        friction = run.fender_friction.sel(axis=axis)
        yield contact_chart(run, "friction", "N", friction, title, axis)


def _transfer_charts(run: xr.Dataset) -> Iterator[Chart]:
    if phases.CONTACT_WEIGHT in run.coords and phases.GROUP_IMPULSE in run:
        lines = _lines_along(phases.transferred_fraction(run))
        yield Chart("Share of the weight transferred", "transferred", "share", lines)


def _utilisation_charts(run: xr.Dataset) -> Iterator[Chart]:
    """Forces over capacities; a fully used capacity is at 1."""
    lines = {
        name.partition(".")[2]: ChartLine(channel_series(run, name)[0])
        for name in channel_names(run)
        if name.startswith("utilisation.")
    }
    if lines:
        yield Chart("Utilisation of capacities", "utilisation", "1", lines)


def shaded_phases(run: xr.Dataset) -> tuple[list[ShadedPhase], str]:
    """Phases of the first group of contacts that goes through an operation, and what they are in
    words; none if there is no such group."""
    if "contact_phase" not in run:
        return [], ""
    time = run.time.values
    codes = run.contact_phase.transpose("contact_group", "time").values
    for group, of in zip(run.contact_group.values, codes, strict=True):
        if phases.is_operation(of):
            starts = np.flatnonzero(np.diff(of, prepend=-1))
            names = [phases.Phase(of[k]).name.lower().replace("_", " ") for k in starts]
            ends = [*time[starts[1:]], time[-1]]
            shaded = [*map(ShadedPhase, names, time[starts], ends)]
            words = ", ".join(f"{phase.name} to {phase.end:.0f} s" for phase in shaded[:-1])
            return shaded, f"phases of {group}: {words}, then {shaded[-1].name}"
    return [], ""


# The ledger.


def energy_charts(run: xr.Dataset) -> list[Chart]:
    """The ledger over time: energy held, work, losses, residual."""
    kinetic = {"": ChartLine(run.energy_kinetic.values)}
    charts = [Chart("Kinetic energy", "kinetic energy", "J", kinetic, folded=True)]
    for part, label in ENERGY_LABELS.items():
        lines = {
            name.replace("_", " "): ChartLine(run[f"energy_{part}_{name}"].values)
            for name in ledger_names(run, part)
        }
        charts += [Chart(f"Energy {label}", label, "J", lines, folded=True)] if lines else []
    residual = {"": ChartLine(run.energy_residual.values)}
    return [*charts, Chart("Residual of the ledger", "residual", "J", residual, folded=True)]


def ledger_nodes(run: xr.Dataset) -> Nodes:
    """What became of the energy from start to end."""
    if run.time.size < 1:
        return
    kinetic = run.energy_kinetic.values
    rows = [("kinetic", Value(float(kinetic[-1]), "J"), "held at the end")]
    for part, label in ENERGY_LABELS.items():
        for name in ledger_names(run, part):
            value = float(run[f"energy_{part}_{name}"].values[-1])
            rows.append((name.replace("_", " "), Value(value, "J"), label))
    last = float(run.energy_residual.values[-1])
    rows.append(("residual", Value(last, "J"), "not accounted for"))
    yield Table(("energy", "at the end", "what it is, since the start"), rows)


def ledger_names(run: xr.Dataset, part: str) -> list[str]:
    """Names of the energies of a part of the ledger that are not zero throughout."""
    start = f"energy_{part}_"
    names = (str(name) for name in run.data_vars if str(name).startswith(start))
    return [name.removeprefix(start) for name in names if run[name].values.any()]


DERIVED: Mapping[str, tuple[int, Callable[[xr.Dataset], Iterable[Chart]]]] = {
    "motions": (Topic.MOTIONS, motion_charts),
    "fender_mode": (Topic.CONTACTS + 1, _mode_charts),
    "crawl": (Topic.CONTACTS + 2, _crawl_charts),
    "utilisation": (Topic.CAPACITIES, _utilisation_charts),
    "transferred": (Topic.CLEARANCES + 3, _transfer_charts),
    "compression": (Topic.DETAILS + 1, _compression_charts),
    "gap": (Topic.DETAILS + 2, _gap_charts),
    "joint_loads": (Topic.DETAILS + 13, _joint_load_charts),
    "joint_components": (Topic.DETAILS + 14, _joint_component_charts),
    "friction": (Topic.DETAILS + 15, friction_charts),
    "velocities": (Topic.DETAILS + 16, _velocity_charts),
    "forces": (Topic.DETAILS + 17, _force_charts),
}
"""Charts by name that are not of one variable, with their ranks."""
RANKS = {name: variable.chart.rank for name, variable in VARIABLES.items()}
RANKS |= {name: rank for name, (rank, _) in DERIVED.items()}
RANKS = dict(sorted(RANKS.items(), key=itemgetter(1)))
"""The rank of each chart, in their order."""


# Arrangements of charts that pictures have.


def chart_each_line(chart: Chart) -> Iterator[Chart]:
    """A chart for each line, named as its subject."""
    for name, line in chart.lines.items():
        yield replace(chart, lines={"": line}, subject=name)


def chart_by_line(charts: Sequence[Chart], quantity: str = "") -> Iterator[Chart]:
    """A chart for each name of lines, with the line of that name of every chart, by the subjects
    of these. Its quantity is the name, if no other ``quantity`` is given."""
    units = {name or c.quantity: c.unit for c in charts for name in c.lines}
    order = list(dict.fromkeys(chart.subject for chart in charts))
    for name, unit in units.items():
        lines = {
            chart.subject: line
            for chart in charts
            for label, line in chart.lines.items()
            if (label or chart.quantity) == name
        }
        yield Chart(name, quantity or name, unit, lines, order=order)


def channel_charts(run: xr.Dataset, names: Sequence[str]) -> list[Chart]:
    """Charts of channels by name: channels of one kind and unit share a chart."""
    kinds: dict[tuple[str, str], dict[str, ChartLine]] = {}
    for name in names:
        values, unit = channel_series(run, name)
        kind, _, selection = name.partition(".")
        lines = kinds.setdefault((kind.replace("_", " "), unit), {})
        lines[selection.replace(".", " ")] = ChartLine(values)
    return [Chart(kind, kind, unit, lines) for (kind, unit), lines in kinds.items()]
