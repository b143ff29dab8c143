"""Sentences and tables of analyses: linear response, mooring lines, ballast and decay tests."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees, isfinite, isnan, pi
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.analysis.line import LineResponse, StillLine, angle_at_fairlead
from hydrosim.dofs import DOFS
from hydrosim.elements.line.shape import REASONS
from hydrosim.elements.roll_decay import DecayFit, Interval
from hydrosim.files import document_nodes
from hydrosim.files.display_units import DEFAULT, Units, unit_of_dof, units_of
from hydrosim.files.document import Document
from hydrosim.report.sentences.sections import lines_of, title_of
from hydrosim.scene import Scene, TankTable

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.analysis.ballast import Condition, PumpPlan, TankState

MAX_SHARES = 3
"""Coordinates that a mode is described by."""
MIN_SHARE = 0.05
"""Of the energy of a mode: coordinates with less are left out."""
ROUNDING_BELOW = 1e-10
RESPONSE_COLUMNS = {
    "at rest": "position_at_rest",
    "mean drift": "mean_drift_offset",
    "std in sea": "response_std",
    "std in gusts": "gust_std",
    "maximum in sea": "response_maximum",
    "Tz": "response_period",
}


def linear_document(analysis: xr.Dataset, raos: bool = False) -> Document:
    """Motions, natural modes and, if so asked, ``raos`` over the period."""
    remarks = document_nodes.warnings(lines_of(analysis, "remarks"))
    nodes = [*remarks, _motion_table(analysis), _mode_table(analysis)]
    nodes += [*_rao_tables(analysis), *_joint_rao_tables(analysis)] if raos else []
    return Document(title_of(analysis), nodes, units=units_of(analysis.attrs))


def _motion_table(analysis: xr.Dataset) -> document_nodes.Table:
    columns = {
        name: variable for name, variable in RESPONSE_COLUMNS.items() if variable in analysis
    }
    waves = range(analysis.sizes.get("wave", 0))
    rows: list[document_nodes.Row] = []
    for body in map(str, analysis.body.values):
        for dof in map(str, analysis.dof.values):
            at = analysis.sel(body=body, dof=dof)
            figures = [_statistic_value(at, variable, dof) for variable in columns.values()]
            harmonics = [
                _harmonic_cell(at.isel(wave=k), "regular", unit_of_dof(dof)) for k in waves
            ]
            rows.append([f"{body} {dof}", *figures, *harmonics])
    return document_nodes.Table(
        ("motion", *columns, *(_wave_text(analysis, k) for k in waves)), rows, "Motions"
    )


def _wave_text(analysis: xr.Dataset, k: int) -> str:
    at = analysis.isel(wave=k)
    where = f"wave of {float(at.wave_period):g} s to {degrees(float(at.wave_heading)):g} deg"
    return f"{where}: amplitude, phase"


def _statistic_value(at: xr.Dataset, variable: str, dof: str) -> document_nodes.Value:
    number = float(at[variable])
    if variable == "response_period":
        return document_nodes.Value(number, "s")
    return document_nodes.Value(0.0 if abs(number) <= ROUNDING_BELOW else number, unit_of_dof(dof))


def _mode_table(analysis: xr.Dataset) -> document_nodes.Node:
    if not analysis.sizes["mode"]:
        return document_nodes.Sentence(
            "There are no natural modes: friction at rest, drives and joints hold all motions."
        )
    head = ("mode", "natural period", "damped period", "damping ratio", "moves")
    modes = {str(mode): analysis.sel(mode=mode) for mode in analysis.mode.values}
    rows = [[mode, *_decay_cells(at), _motion_text(at)] for mode, at in modes.items()]
    return document_nodes.Table(head, rows, "Natural modes")


def _decay_cells(at: xr.Dataset) -> document_nodes.Row:
    """Periods and damping of a mode, or what it is instead."""
    kind = str(at.mode_kind.values)
    if kind == "free":
        return ["free", "", ""]
    natural = float(at.natural_period)
    period: document_nodes.Cell = (
        document_nodes.Value(natural, "s") if isfinite(natural) else "none"
    )
    if kind != "oscillating":
        return [period, kind, ""]
    return [
        period,
        document_nodes.Value(float(at.damped_period), "s"),
        document_nodes.Value(float(at.damping_ratio), "", 3),
    ]


def _motion_text(at: xr.Dataset) -> str:
    """The coordinates that have most of the energy of a mode."""
    share = at.mode_share.stack(coordinate=("body", "dof"))
    largest = share.sortby(share, ascending=False)[:MAX_SHARES]
    several = at.body.size > 1
    parts = [
        (float(value), f"{f'{body} ' if several else ''}{dof}")
        for (body, dof), value in zip(largest.coordinate.values, largest.values, strict=True)
    ]
    if "joint_mode_share" in at:
        joints = zip(at.joint_mode_share.values, at.joint_motion.values, strict=True)
        parts += [(float(value), str(name)) for value, name in joints]
    parts = sorted(parts, key=lambda part: -part[0])[:MAX_SHARES]
    return ", ".join(f"{name} {value:.0%}" for value, name in parts if value >= MIN_SHARE)


def _rao_tables(analysis: xr.Dataset) -> document_nodes.Nodes:
    """RAOs over the period, a table for each body and heading; motions that no wave excites are
    left out."""
    for body in map(str, analysis.body.values):
        for heading in analysis.heading.values:
            at = analysis.sel(body=body, heading=heading)
            moving = [
                d for d in DOFS if d in at.dof and float(at.rao_amplitude.sel(dof=d).max()) > 0.0
            ]
            rows = [
                _rao_cells(at.sel(frequency=omega), moving) for omega in at.frequency.values[::-1]
            ]
            title = f"RAOs of {body}, waves to {degrees(float(heading)):g} deg: amplitude, phase"
            yield document_nodes.Table(("period", *moving), rows, title)


def _joint_rao_tables(analysis: xr.Dataset) -> document_nodes.Nodes:
    """RAOs of the motions of joints over the period, a table for each heading."""
    for heading in analysis.heading.values if "joint_motion" in analysis.dims else ():
        at = analysis.sel(heading=heading)
        names = list(map(str, at.joint_motion.values))
        rows = [
            [
                document_nodes.Value(2.0 * pi / float(omega), "s"),
                *(
                    _harmonic_cell(
                        at.sel(frequency=omega, joint_motion=name),
                        "joint_rao",
                        _unit_of_motion(name),
                    )
                    for name in names
                ),
            ]
            for omega in at.frequency.values[::-1]
        ]
        title = f"RAOs in joints, waves to {degrees(float(heading)):g} deg: amplitude, phase"
        yield document_nodes.Table(("period", *names), rows, title)


def _unit_of_motion(joint_motion: str) -> str:
    """Unit of the RAO of a motion of a joint."""
    return "m/m" if joint_motion.endswith("offset") else "rad/m"


def _rao_cells(at: xr.Dataset, moving: list[str]) -> document_nodes.Row:
    of = [_harmonic_cell(at.sel(dof=dof), "rao", f"{unit_of_dof(dof)}/m") for dof in moving]
    return [document_nodes.Value(2.0 * pi / float(at.frequency), "s"), *of]


def _harmonic_cell(at: xr.Dataset, name: str, unit: str) -> document_nodes.Cell:
    """Amplitude and phase lead; no phase of what does not move."""
    size = float(at[f"{name}_amplitude"])
    phase = document_nodes.Value(float(at[f"{name}_phase"]), "rad", 3)
    return (
        document_nodes.Sentence("{}, {}", [document_nodes.Value(size, unit), phase])
        if size
        else "0"
    )


# Mooring lines by themselves: at rest, and over offsets of their fairleads.

AT_REST_COLUMNS = (
    *("line", "to", "tension", "horizontal pull", "down at fairlead", "angle below level"),
    *("anchor tension", "grounded", "length"),
)
GAP_TEXT = "A dash is where the line has no shape: "
FRICTION_NOTE = (
    "With friction on the seabed the pull has no potential. It depends on the place alone here, as"
    " if the fairlead had come there from slack."
)


def line_document(
    title: str,
    lines: Sequence[StillLine],
    responses: Sequence[LineResponse],
    units: Units = DEFAULT,
    left_out: Sequence[str] = (),
) -> Document:
    """The lines at rest, and the ``responses`` of one of them; before them what is ``left_out`` of
    their file."""
    nodes: list[document_nodes.Node] = [
        *document_nodes.warnings(left_out),
        *_unsolved_lines(lines),
        document_nodes.Table(AT_REST_COLUMNS, [_row_at_rest(line) for line in lines], "At rest"),
    ]
    if any(line.friction > 0.0 for line in lines):
        nodes.append(document_nodes.Sentence(FRICTION_NOTE, detail=True))
    for response in responses:
        nodes.append(_offset_table(response))
        nodes += [document_nodes.Sentence(f"{GAP_TEXT}{reason}.") for reason in response.reasons]
    return Document(title, nodes, units=units)


def _unsolved_lines(lines: Sequence[StillLine]) -> Iterator[document_nodes.Verdict]:
    for line in lines:
        pull = line.end_forces()
        if not pull.converged:
            yield document_nodes.Verdict(
                document_nodes.Outcome.BAD, f"line {line.name} has no shape: {REASONS[pull.reason]}"
            )


def _row_at_rest(line: StillLine) -> document_nodes.Row:
    pull = line.end_forces()
    return [
        line.name,
        document_nodes.Value(line.heading, "rad"),
        *document_nodes.value_cells((np.hypot(pull.H, pull.V), pull.H, pull.V), "N"),
        document_nodes.Value(angle_at_fairlead(pull), "rad"),
        document_nodes.Value(float(np.hypot(pull.anchor_H, pull.anchor_V)), "N"),
        *document_nodes.value_cells((line.grounded_length(pull), line.length), "m"),
    ]


def _offset_table(response: LineResponse) -> document_nodes.Table:
    way = "upward" if response.up else "away from the anchor"
    head = (
        *("offset", "tension", "horizontal pull", "down at fairlead", "anchor tension"),
        *("stiffness", "grounded"),
    )
    columns = (
        *(response.offsets, response.tension, response.horizontal, response.vertical),
        *(response.anchor, response.stiffness, response.grounded),
    )
    units = ("m", "N", "N", "N", "N", "N/m", "m")
    cells = (document_nodes.value_cells(*of) for of in zip(columns, units, strict=True))
    rows = list(zip(*cells, strict=True))
    return document_nodes.Table(head, rows, f"Offset of the fairlead {way}")


# The loading condition of bodies with tanks, and plans of their pumps.

COMMON_HEEL_RAD = 2e-3
"""Heel that any body has [rad]."""
COORDINATES = ("x", "y", "z")


def ballast_document(
    scene: Scene,
    conditions: Sequence[Condition],
    time: float,
    angle: float | None = None,
    plan: PumpPlan | None = None,
    waiting: Sequence[str] = (),
) -> Document:
    """What bodies weigh and how they float at a ``time`` [s], with what free surfaces take at an
    ``angle`` of heel [rad]; a ``plan`` of their pumps; pumps that are ``waiting`` for events."""
    nodes: list[document_nodes.Node] = [*_shallow_surfaces(conditions)]
    nodes += [] if angle is None else _upright_walls(conditions, angle)
    if waiting:
        text = "These pumps wait for events and are taken as not started: {}."
        nodes.append(document_nodes.warning(text, [", ".join(waiting)]))
    for condition in conditions:
        nodes += [
            document_nodes.Heading(f"{condition.body.name} at {time:g} s"),
            *_describe_condition(condition, angle),
        ]
    nodes += [] if plan is None else _pump_plan(plan)
    return Document(scene.title, nodes, units=units_of(scene.source))


def _describe_condition(condition: Condition, angle: float | None) -> document_nodes.Nodes:
    """What a body weighs and how it floats; its tanks; its mass matrix."""
    weights = (("lightship", condition.lightship), ("with its tanks", condition.loading))
    rows: list[document_nodes.Row] = [
        [name, _mass_value(x.mass), *_length_values(x.centre)] for name, x in weights
    ]
    yield document_nodes.Table(("", "mass", *COORDINATES), rows)
    heave, heel, trim = condition.position[2:5]
    at_rest: document_nodes.Row = [
        _length_value(round(heave, 4)),
        *(_angle_value(round(x, 6)) for x in (heel, trim)),
    ]
    yield document_nodes.Table(("", "heave", "heel", "trim"), [["at rest", *at_rest]])
    yield _metacentric_table(condition, angle)
    head = ("tank", "level", "mass", "filled", "free to a heel", "free to a trim")
    yield document_nodes.Table(head, [_tank_cells(tank) for tank in condition.tanks])
    origin = np.array(condition.body.centre_of_gravity)
    matrix = condition.loading._replace(centre=condition.loading.centre - origin).matrix
    rows = [[dof, *(_four_digits(x) for x in row)] for dof, row in zip(DOFS, matrix, strict=True)]
    title = "Mass matrix about the body's origin [kg, kg m, kg m^2]"
    yield document_nodes.Table(("", *DOFS), rows, title, detail=True)


def _metacentric_table(condition: Condition, angle: float | None) -> document_nodes.Table:
    """Metacentric heights in heel and trim, and what free surfaces take of them."""
    head = ["", "GM", "taken by free surfaces"]
    columns = [condition.metacentric, condition.loss]
    if angle is not None:
        head.append(f"taken at {np.degrees(angle):g} deg of heel")
        columns.append(np.array([condition.secant, np.nan]))
    rows = zip(("heel", "trim"), np.transpose([*columns, condition.held]), strict=True)
    cells: list[document_nodes.Row] = [[of, *(_length_value(x) for x in row)] for of, row in rows]
    return document_nodes.Table(
        [*head, "with lines and contacts"], cells, "Metacentric heights at rest"
    )


def _tank_cells(tank: TankState) -> document_nodes.Row:
    reach = ("" if isnan(x) else _angle_value(x) for x in tank.reach)
    filled = document_nodes.Value(tank.filled, "share")
    return [tank.tank.name, _length_value(tank.level), _mass_value(tank.mass), filled, *reach]


def _pump_plan(plan: PumpPlan) -> document_nodes.Nodes:
    heave, heel, trim = plan.position[0, 2:5]
    parts: list[document_nodes.Part] = [
        document_nodes.Value(plan.within, "s", 6),
        _length_value(heave),
        _angle_value(heel),
        _angle_value(trim),
    ]
    yield document_nodes.Heading("Plan of the pumps")
    yield document_nodes.Sentence(
        "After {} the body is at rest at heave {}, heel {}, trim {}.", parts
    )
    runs = zip(plan.pumps, plan.rate, plan.mass, strict=True)
    rows: list[document_nodes.Row] = [
        [name, document_nodes.Value(rate, "kg/s", 5), _mass_value(mass)]
        for name, rate, mass in runs
    ]
    yield document_nodes.Table(("pump", "rate", "mass"), rows)


def _shallow_surfaces(conditions: Sequence[Condition]) -> document_nodes.Nodes:
    """Free surfaces that meet bottom or top at once: GM is another beyond."""
    for condition in conditions:
        for tank in condition.tanks:
            if 0.0 < tank.reach[0] < COMMON_HEEL_RAD:
                yield document_nodes.warning(
                    "{}: its surface meets bottom or top at {} of heel. GM is the slope at rest. At"
                    " a larger heel the free surface takes less: see --heel.",
                    [_key_text(condition, tank), _angle_value(tank.reach[0], 2)],
                )


def _upright_walls(conditions: Sequence[Condition], angle: float) -> document_nodes.Nodes:
    """Tables, whose walls are upright also where the surface meets bottom or top."""
    for condition in conditions:
        for tank in condition.tanks:
            if isinstance(tank.tank.shape, TankTable) and abs(angle) > tank.reach[0]:
                yield document_nodes.warning(
                    "{}: a table has upright walls at every heel, but its surface meets bottom or"
                    " top at {}. It takes less than is printed. Give it as a box or a mesh.",
                    [_key_text(condition, tank), _angle_value(tank.reach[0], 3)],
                )


def _key_text(of: Condition, tank: TankState) -> str:
    return f"bodies.{of.body.name}.tanks.{tank.tank.name}"


def _mass_value(value: float) -> document_nodes.Value:
    return document_nodes.Value(float(value), "kg", 6)


def _length_value(value: float) -> document_nodes.Value:
    return document_nodes.Value(float(value), "m")


def _length_values(values: np.ndarray) -> list[document_nodes.Value]:
    return document_nodes.value_cells(values, "m")


def _angle_value(value: float, digits: int = 3) -> document_nodes.Value:
    return document_nodes.Value(float(value), "rad", digits)


def _four_digits(value: float) -> str:
    return f"{value:.4g}".replace("e+0", "e").replace("e+", "e")


# A fit of decay tests: damping with intervals, natural period, and keys for a case.

TERMS = (("p1", "1/s"), ("p2", "1/rad"), ("p3", "s/rad^2"))
MAX_RATIO_ROWS = 5
"""Rows of damping ratios, from the smallest to the largest recorded roll."""
COEFFICIENT_DIGITS = 5
CASE_UNITS = ("s^-1", "rad^-1", "s/rad^2")
"""Units in a case file."""


def calibration_document(fit: DecayFit) -> Document:
    """Damping of the decays, how well the records tell it, and where the equation does not fit."""
    doubts = [document_nodes.warning("{}", [text]) for text in fit.doubts]
    notes = [document_nodes.Sentence("{}.", [note]) for decay in fit.decays for note in decay.notes]
    nodes = [
        *doubts,
        _term_table(fit),
        _undetermined_terms(fit),
        _ratio_table(fit),
        _record_table(fit),
        *notes,
    ]
    return Document("Decay of roll", nodes)


def keys_of(fit: DecayFit, body: str) -> list[str]:
    """Lines of a force element with the fitted damping, as in a case file."""
    values = zip((name for name, _ in TERMS), fit.damping, CASE_UNITS, strict=True)
    return [
        "forces:",
        "  roll_damping:",
        "    type: viscous_roll",
        f"    body: {body}",
        *(f"    {name}: {value:.6g} {unit}" for name, value, unit in values),
        f"    period: {fit.period.value:.6g} s",
    ]


def _term_table(fit: DecayFit) -> document_nodes.Table:
    rows = [
        _term_cells(f"{name} [{unit}]", fit.terms.interval(k), fit.damping[k])
        for k, (name, unit) in enumerate(TERMS)
    ]
    rows.append(_term_cells("natural period [s]", fit.period, fit.period.value))
    rows.append(_term_cells("cubic restoring [1/rad^2]", fit.restoring, fit.restoring.value))
    return document_nodes.Table(("", "fitted", "90 % from", "to", "for use"), rows, "Fit")


def _term_cells(name: str, interval: Interval, used: float) -> document_nodes.Row:
    return [name, *(f"{x:.{COEFFICIENT_DIGITS}g}" for x in (*interval, used))]


def _undetermined_terms(fit: DecayFit) -> document_nodes.Node:
    """Terms that the records do not tell from zero."""
    names = [name for k, (name, _) in enumerate(TERMS) if fit.terms.interval(k).includes_zero]
    if not names:
        return document_nodes.Sentence("The records tell p1, p2 and p3 from zero.", [])
    text = (
        "The records do not tell {} from zero. The damping of all terms together is known better:"
        " see the ratios. No term for use is negative."
    )
    return document_nodes.Sentence(text, [", ".join(names)])


def _ratio_table(fit: DecayFit) -> document_nodes.Table:
    rows = []
    for amplitude in np.linspace(*fit.amplitudes, MAX_RATIO_ROWS):
        ratios = (*fit.terms.damping_ratio(amplitude), fit.used_ratio(amplitude))
        cells = document_nodes.value_cells(ratios, "share", 3)
        rows.append([document_nodes.Value(amplitude, "rad", 3), *cells])
    head = ("amplitude", "damping ratio", "90 % from", "to", "for use")
    return document_nodes.Table(head, rows, "Equivalent linear damping, of critical")


def _record_table(fit: DecayFit) -> document_nodes.Table:
    rows: list[document_nodes.Row] = [
        [
            decay.called,
            *document_nodes.value_cells(decay.time[[0, -1]], "s"),
            *document_nodes.value_cells((decay.size, deviation), "rad", 3),
        ]
        for decay, deviation in zip(fit.decays, fit.deviations, strict=True)
    ]
    head = ("record", "from", "to", "largest roll", "std of residuals")
    return document_nodes.Table(head, rows, "Records")
