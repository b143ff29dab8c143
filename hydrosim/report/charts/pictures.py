"""Pictures of a run (overview, motions, contacts, lines, tanks, energies), drawn to files.

Absent parts of a scene (fenders, waves, a degree of freedom that moves) have no panel. A picture
without panels is not drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hydrosim.case.tables import plain, seas
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.files.display_units import DisplayUnit, unit_of_dof, units_of
from hydrosim.files.outputs import Output, make_folder, save_picture
from hydrosim.files.series import units_along
from hydrosim.report.charts.panels import (
    COLOURS,
    MAX_LINES_PER_PANEL,
    Panel,
    PictureFrame,
    Series,
    ShadedPhase,
    TimeWindow,
    coarse,
    lines,
    merge_equal_lines,
    mode_strips,
    peak,
    picture,
    separate_panels,
)
from hydrosim.results.channels import (
    COORDINATE_LINKS,
    channel_names,
    channel_series,
    group_by_size,
    match_channels,
)
from hydrosim.results.phases import Phase as Named
from hydrosim.results.phases import is_operation, transferred_fraction
from hydrosim.statistics.results import crawl

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

NEGLIGIBLE_MOTION = 1e-6  # m or rad: smaller motions count as none
NEGLIGIBLE_LOAD_RATIO = 1e-9  # of the largest load of a joint
LITTLE = 1e-3  # of the largest friction: smaller components along an axis are not drawn
# contacts or lines with panels of their own; if there are more, each group or element has a panel
MANY = 12
MOTION_DOFS = {"displacement": DOFS[:3], "rotation": DOFS[3:]}


def overview(run: xr.Dataset) -> list[Panel]:
    """Panels of the overview."""
    panels = [*_motions_together(run), *_elevation_panels(run)]
    if "fender" in run.dims:
        panels += [
            _line_panel(run, "normal force", "N", _series_by_fender(run, run.fender_normal_force))
        ]
        panels += [_mode_panel(run), *_crawl_panels(run)]
    if "spring" in run.dims:
        panels += _load_panels(run, "tension", "N", _series_by_spring(run.spring_tension))
    for dim in ("line", "winch", "compensator"):
        if dim in run.dims:
            series = _series_by_spring(run[f"{dim}_tension"], dim)
            panels += _load_panels(run, "tension", "N", series)
    panels += [
        *_joint_motions(run),
        *_panels_by_unit(run, "drive_force", "drive force"),
        *_link_panels(run),
    ]
    return [*panels, *_utilisation_panels(run)]


def motions(run: xr.Dataset) -> list[Panel]:
    """Panels for each degree of freedom that moves, with all bodies, and for the waves."""
    single, order = run.sizes["body"] == 1, _labels_of_dim(run, "body")
    panels = []
    for dof, bodies in _moving_dofs(run).items():
        positions = {"" if single else body: _position_of_body(run, body, dof) for body in bodies}
        panels.append(_line_panel(run, dof, unit_of_dof(dof), positions, [] if single else order))
    return [*panels, *_elevation_panels(run)]


def fender_forces(run: xr.Dataset) -> list[Panel]:
    """Panels of the normal force of each contact point, with its friction components beside it."""
    if "fender" not in run.dims:
        return []
    time, order = run.time.values, _labels_of_dim(run, "axis")
    normal = _contact_lines(run, run.fender_normal_force)
    axes = {axis: _contact_lines(run, run.fender_friction.sel(axis=axis)) for axis in order}
    together = {
        name: np.hstack([normal[name], *(values[name] for values in axes.values())])
        for name in normal
    }
    merged = [(", ".join(group), group[0]) for group, _ in merge_equal_lines(together)]
    shown = units_of(run.attrs).display_unit("N")
    left = separate_panels(
        time, "normal force", shown, {name: normal[first] for name, first in merged}
    )
    by_contact = [{axis: values[first] for axis, values in axes.items()} for _, first in merged]
    right = _component_panels(time, "friction", shown, by_contact)
    return [panel for row in zip(left, right, strict=True) for panel in row]


def contact(run: xr.Dataset) -> list[Panel]:
    """Panels of modes, compression, path length and slip of the contact points."""
    if "fender" not in run.dims:
        return []
    by = {"compression": ("m", run.fender_compression.clip(min=0.0))}
    then = {
        "slip distance": ("m", run.fender_slip_distance),
        "friction loss": ("J", run.fender_dissipated),
    }
    return [
        _mode_panel(run),
        *(
            _line_panel(run, name, unit, _series_by_fender(run, x))
            for name, (unit, x) in by.items()
        ),
        *_crawl_panels(run),
        *(
            _line_panel(run, name, unit, _series_by_fender(run, x))
            for name, (unit, x) in then.items()
        ),
    ]


def transfer(run: xr.Dataset) -> list[Panel]:
    """Panels of a transfer of weight between groups of contacts: its fraction, loads,
    clearances."""
    if "contact_weight" not in run.coords:
        return []
    share, load = transferred_fraction(run), run.contact_load
    groups = share.contact_group.values
    taken = run.isel(fender=np.isin(run.fender_group.values, groups))
    gaps = -taken.fender_compression.clip(max=0.0)
    return [
        _line_panel(
            run, "transferred", "1", {g: share.sel(contact_group=g).values for g in groups}
        ),
        _line_panel(run, "load", "N", {g: load.sel(contact_group=g).values for g in groups}),
        _line_panel(
            run, "load of each group", "N", _series_by_fender(taken, taken.fender_normal_force)
        ),
        _line_panel(run, "gap", "m", _series_by_fender(taken, gaps)),
        *_clearance_panels(run),
    ]


def tensions(run: xr.Dataset) -> list[Panel]:
    """Panels of the tension of each line, all over one range, of the loads of struts and torsion
    springs, of absorbed powers, and of the utilisation of capacities."""
    links = list(_link_panels(run))
    dims = [dim for dim in ("spring", "line", "winch", "compensator") if dim in run.dims]
    if not dims:
        return [*links, *_utilisation_panels(run)] if links else []
    tension: dict[str, np.ndarray] = {}
    for dim in dims:
        tension |= _contact_lines(run, run[f"{dim}_tension"], dim)
    shown = units_of(run.attrs).display_unit("N")
    return [
        *separate_panels(run.time.values, "tension", shown, tension),
        *links,
        *_utilisation_panels(run),
    ]


def joints(run: xr.Dataset) -> list[Panel]:
    """Panels of the motions of joints, of what acts in them, and of their loads."""
    if "joint" not in run.dims:
        return []
    acting = _panels_by_unit(run, "joint_motion_force", "spring, damping, stops and friction")
    return [*_joint_motions(run), *acting, *_joint_loads(run)]


def tanks(run: xr.Dataset) -> list[Panel]:
    """Panels of tank levels and pump rates."""
    variables = {"tank": ("tank_level", "level", "m"), "pump": ("pump_rate", "pumped", "kg/s")}
    return [
        _line_panel(
            run,
            label,
            unit,
            {name: run[of].sel({dim: name}).values for name in _labels_of_dim(run, dim)},
        )
        for dim, (of, label, unit) in variables.items()
        if of in run and run.sizes[dim]
    ]


def energies(run: xr.Dataset) -> list[Panel]:
    """Panels of the energy balance: energy held, work, losses, residual."""
    panels = [_line_panel(run, "kinetic energy", "J", {"": run.energy_kinetic.values})]
    for part, label in {"stored": "stored", "work": "work done", "dissipated": "lost"}.items():
        start = f"energy_{part}_"
        stores = {
            name.removeprefix(start).replace("_", " "): run[name].values
            for name in map(str, run.data_vars)
            if name.startswith(start) and run[name].values.any()
        }
        panels += [_line_panel(run, label, "J", stores)] if stores else []
    return [*panels, _line_panel(run, "residual", "J", {"": run.energy_residual.values})]


PICTURES: dict[str, Callable[[xr.Dataset], list[Panel]]] = {
    "": overview,
    "_motions": motions,
    "_forces": fender_forces,
    "_contact": contact,
    "_transfer": transfer,
    "_tensions": tensions,
    "_joints": joints,
    "_tanks": tanks,
    "_energies": energies,
}
"""All pictures of a run, by the suffix of their file names."""


def channels(run: xr.Dataset, chosen: Sequence[str]) -> list[Panel]:
    """Panels of channels by name: channels of one kind and unit share a panel; many channels have
    one each."""
    kinds: dict[tuple[str, str], dict[str, np.ndarray]] = {}
    for name in chosen:
        values, unit = channel_series(run, name)
        kind, _, of = name.partition(".")
        kinds.setdefault((kind.replace("_", " "), unit), {})[of.replace(".", " ")] = values
    panels: list[Panel] = []
    for (kind, unit), series in kinds.items():
        several = separate_panels(
            run.time.values, kind, units_of(run.attrs).display_unit(unit), series
        )
        panels += (
            several
            if len(merge_equal_lines(series)) > MAX_LINES_PER_PANEL
            else [_line_panel(run, kind, unit, series)]
        )
    return panels


def _line_panel(
    run: xr.Dataset, label: str, unit: str, series: Series, order: Sequence[str] = ()
) -> Panel:
    """A panel of lines in SI ``unit``, in the unit that the run is read in."""
    return lines(run.time.values, label, units_of(run.attrs).display_unit(unit), series, order)


def _load_panels(run: xr.Dataset, label: str, unit: str, series: Series) -> Iterator[Panel]:
    """Panels of lines; small ones have a panel of their own beside large ones."""
    for group in group_by_size(series):
        yield _line_panel(run, label, unit, group, [*series])


def _component_panels(
    time: np.ndarray, label: str, shown: DisplayUnit, panels: Sequence[Series]
) -> Iterator[Panel]:
    """A panel for each contact or line, with the same components, without components that are small
    throughout. All have the prefix that suits the largest value."""
    order, largest = [*panels[0]], max(peak(panel) for panel in panels)
    acting = [a for a in order if any(peak({a: x[a]}) > LITTLE * largest for x in panels)]
    alone = len(acting) < 2
    label = f"{label} {acting[0]}" if len(acting) == 1 else label
    for panel in panels:
        drawn = {"" if alone else axis: panel[axis] for axis in acting or order[:1]}
        yield lines(time, label, shown, drawn, [] if alone else order)


def _motions_together(run: xr.Dataset) -> Iterator[Panel]:
    """For each body, a panel of all translations and a panel of all rotations."""
    moving = _moving_dofs(run)
    for body in _labels_of_dim(run, "body"):
        for kind, dofs in MOTION_DOFS.items():
            moving_dofs = [dof for dof in dofs if body in moving.get(dof, ())]
            of = f"{body}\n" if run.sizes["body"] > 1 else ""
            if len(moving_dofs) == 1:
                position = {"": _position_of_body(run, body, moving_dofs[0])}
                yield _line_panel(
                    run, f"{of}{moving_dofs[0]}", unit_of_dof(moving_dofs[0]), position
                )
            elif moving_dofs:
                positions = {dof: _position_of_body(run, body, dof) for dof in moving_dofs}
                yield _line_panel(run, f"{of}{kind}", unit_of_dof(moving_dofs[0]), positions, dofs)


def _moving_dofs(run: xr.Dataset) -> dict[str, list[str]]:
    """Bodies that move in each degree of freedom; all bodies if none moves at all."""
    reach = run.position.max("time") - run.position.min("time")
    moves = reach > NEGLIGIBLE_MOTION
    moves = moves if moves.values.any() else reach >= 0.0
    return {
        str(dof): [str(body) for body in run.body.values[moves.sel(dof=dof).values]]
        for dof in run.dof.values
        if moves.sel(dof=dof).values.any()
    }


def _position_of_body(run: xr.Dataset, body: str, dof: str) -> np.ndarray:
    return np.asarray(run.position.sel(body=body, dof=dof).values)


def _elevation_panels(run: xr.Dataset) -> Iterator[Panel]:
    if run.wave_elevation.values.any():
        yield _line_panel(run, "wave elevation", "m", {"": run.wave_elevation.values})
    if "wind_speed" in run:
        yield _line_panel(run, "wind speed", "m/s", {"": run.wind_speed.values})


def _utilisation_panels(run: xr.Dataset) -> Iterator[Panel]:
    """Panels of forces over capacities; a fully used capacity is at 1."""
    utilisations = {
        n.partition(".")[2]: channel_series(run, n)[0]
        for n in channel_names(run)
        if n.startswith("utilisation.")
    }
    if utilisations:
        yield _line_panel(run, "utilisation", "1", utilisations)


def _joint_motions(run: xr.Dataset) -> Iterator[Panel]:
    return _panels_by_unit(run, "joint_position", "joint motion")


def _joint_loads(run: xr.Dataset) -> Iterator[Panel]:
    """Sizes of the forces and moments of joints, without those that are rounding."""
    parts = {("joint force", "N"): DOFS[:3], ("joint moment", "N m"): DOFS[3:]}
    loads = {
        of: np.sqrt(np.square(run.joint_force.sel(dof=list(dofs))).sum("dof"))
        for of, dofs in parts.items()
    }
    largest = max(float(size.max()) for size in loads.values())
    for (label, unit), size in loads.items():
        if float(size.max()) > NEGLIGIBLE_LOAD_RATIO * largest:
            yield _line_panel(run, label, unit, _lines_of(size, "joint"))


def _panels_by_unit(run: xr.Dataset, name: str, label: str) -> Iterator[Panel]:
    """A panel of a variable of joint motions, drives or links along lines, and one about axes."""
    if name not in run or not run[name].values.any():
        return
    every = _lines_of(run[name], str(run[name].dims[-1]))
    units = units_along(run, name)
    for unit in dict.fromkeys(units.values()):
        yield _line_panel(run, label, unit, {n: x for n, x in every.items() if units[n] == unit})


def _link_panels(run: xr.Dataset) -> Iterator[Panel]:
    """Loads of links, and powers of power take-offs."""
    for dim in COORDINATE_LINKS:
        yield from _panels_by_unit(run, f"{dim}_load", f"{dim.replace('_', ' ')} load")
    for name, dim, label, unit in (
        ("strut_force", "strut", "strut force", "N"),
        ("winch_length", "winch", "length off the drum", "m"),
        ("compensator_stroke", "compensator", "stroke", "m"),
        ("torsion_moment", "torsion_spring", "torsion moment", "N m"),
        ("pto_power", "pto", "absorbed power", "W"),
    ):
        if dim in run.dims:
            yield from _load_panels(run, label, unit, _lines_of(run[name], dim))


def _clearance_panels(run: xr.Dataset) -> Iterator[Panel]:
    if "gap" in run.dims:
        clearances = {
            name: run.clearance.sel(gap=name).values for name in _labels_of_dim(run, "gap")
        }
        yield _line_panel(run, "clearance", "m", clearances)


def _mode_panel(run: xr.Dataset) -> Panel:
    return mode_strips(run.time.values, _lines_of(run.fender_mode, "fender"))


def _crawl_panels(run: xr.Dataset) -> Iterator[Panel]:
    """Path length of the contact nodes since the start, along axes where it exceeds rounding. While
    open, a node stays at the point of last contact."""
    gone = crawl(run)
    by_axis = {axis: gone.sel(axis=axis) for axis in _labels_of_dim(run, "axis")}
    largest = max(peak({"": x.values}) for x in by_axis.values())
    for axis, x in by_axis.items():
        if peak({"": x.values}) > NEGLIGIBLE_MOTION * largest:
            yield _line_panel(run, f"crawl {axis}", "m", _series_by_fender(run, x))


def _series_by_fender(run: xr.Dataset, values: xr.DataArray) -> Series:
    """A line for each contact point; for each group if there are more than one panel can show."""
    lines = _lines_of(values, "fender")
    return (
        lines
        if len(merge_equal_lines(lines)) <= MAX_LINES_PER_PANEL
        else _series_by_group(run, values)
    )


def _series_by_spring(values: xr.DataArray, dim: str = "spring") -> Series:
    """Lines as they are, because tensions are smooth; if there are very many, a band from the
    smallest to the largest."""
    lines = _lines_of(values, dim)
    return (
        lines
        if len(lines) <= len(COLOURS)
        else {f"{len(lines)} lines": np.array([*lines.values()])}
    )


def _contact_lines(run: xr.Dataset, values: xr.DataArray, dim: str = "fender") -> Series:
    """A line for each contact; for each group if there are very many."""
    many = run.sizes[dim] > MANY and dim == "fender"
    return _series_by_group(run, values) if many else _lines_of(values, dim)


def _series_by_group(run: xr.Dataset, values: xr.DataArray) -> Series:
    """Several lines (n, nt) for each group of contact points."""
    of = run.fender_group.values
    lines = {str(group): values.values.T[of == group] for group in dict.fromkeys(of)}
    return {f"{name}, {len(x)} contacts": x for name, x in lines.items()}


def _lines_of(values: xr.DataArray, dim: str) -> dict[str, np.ndarray]:
    return {str(name): values.sel({dim: name}).values for name in values[dim].values}


def _labels_of_dim(run: xr.Dataset, dim: str) -> list[str]:
    return [str(name) for name in run[dim].values] if dim in run.coords else []


# `draw` writes the pictures of a run to files; `figure` returns one of them.

LEGEND_COLUMNS = {"_forces": 2}
ALWAYS = TimeWindow()


class Format(StrEnum):
    """Formats of pictures."""

    PNG = "png"
    SVG = "svg"
    PDF = "pdf"


@dataclass(frozen=True)
class View:
    """Selection for the pictures of a run: the time, the channels (default: the usual ones), and
    the format."""

    window: TimeWindow = ALWAYS
    channels: Sequence[str] = ()
    format: Format = Format.PNG

    def pictures(self) -> dict[str, str]:
        """Names of all possible files, by the suffix after the name of the run."""
        suffixes = ["_channels"] if self.channels else [*PICTURES]
        return {suffix: f"{suffix}.{self.format}" for suffix in suffixes}


DEFAULT_VIEW = View()


def draw(
    run: xr.Dataset,
    folder: Path,
    stem: str,
    origin: Path | None = None,
    overwrite: bool = False,
    view: View = DEFAULT_VIEW,
) -> list[Path]:
    """Write the pictures of ``run`` and return their paths. ``stem``.png is the overview;
    ``stem``_motions.png and so on are the details; ``stem``_channels.png shows requested channels.
    Raises InputError if the folder cannot be made, if a picture would replace a file that is no
    earlier picture of the run ``origin``, or if the run has fewer than two records in the
    window."""
    _check_window(run, view.window)
    outputs = picture_outputs(folder, stem, origin, overwrite, view)
    suffixes_and_outputs = zip(view.pictures(), outputs, strict=True)
    drawn = (
        (_panels_of_picture(run, suffix, view), suffix, output)
        for suffix, output in suffixes_and_outputs
    )
    return [
        save_picture(picture(panels, _picture_frame(run, suffix, view.window)), output)
        for panels, suffix, output in drawn
        if panels
    ]


def picture_outputs(
    folder: Path,
    stem: str,
    origin: Path | None = None,
    overwrite: bool = False,
    view: View = DEFAULT_VIEW,
) -> list[Output]:
    """Outputs for all possible pictures of a run; raises as `draw` does."""
    make_folder(folder)
    made_of = origin or folder / f"{stem}.nc"
    paths = [folder / f"{stem}{name}" for name in view.pictures().values()]
    return [
        Output(path, "picture", made_of, (made_of,), overwrite, "pictures").checked_output()
        for path in paths
    ]


def figure(run: xr.Dataset, name: str = "overview", window: TimeWindow = ALWAYS) -> Figure:
    """Picture of a run by its name, such as "overview" or "motions". Raises InputError if there is
    no such picture, or if the run has no data for it."""
    suffix, panels = _panels_by_name(run, name)
    _check_window(run, window)
    return picture(panels, _picture_frame(run, suffix, window))


def picture_names() -> list[str]:
    """Names of all pictures of runs."""
    return [panels.__name__ for panels in PICTURES.values()]


def draw_on_axes(run: xr.Dataset, name: str, axes: Axes | Sequence[Axes]) -> Figure:
    """Draw the panels of a picture on axes of matplotlib, one each; return their figure. Raises
    InputError for another number of axes."""
    return _draw_panels(_panels_by_name(run, name)[1], axes)


def draw_channels(
    run: xr.Dataset, patterns: Sequence[str], axes: Axes | Sequence[Axes] | None = None
) -> Figure:
    """Draw channels that patterns match in a new figure, or on ``axes`` as `draw_on_axes` does."""
    panels = channels(run, match_channels(channel_names(run), patterns, "channels"))
    if axes is None:
        return picture(panels, _picture_frame(run, "_channels", ALWAYS))
    return _draw_panels(panels, axes)


def _draw_panels(panels: Sequence[Panel], axes: Axes | Sequence[Axes]) -> Figure:
    places = np.atleast_1d(np.asarray(axes, object)).ravel()
    if len(places) != len(panels):
        raise InputError(
            f"ax: found {len(places)} axes; expected {len(panels)}, one for each panel:"
            f" figure, ax = plt.subplots({len(panels)})."
        )
    for axis, panel in zip(places, panels, strict=True):
        panel.draw(axis, ALWAYS)
        axis.set_xlabel("time [s]")
    return places[0].figure


def _panels_by_name(run: xr.Dataset, name: str) -> tuple[str, list[Panel]]:
    """Suffix and panels of a picture; InputError if there is none, or no data for it."""
    suffixes = {of.__name__: suffix for suffix, of in PICTURES.items()}
    panels = PICTURES[suffixes[name]](run) if name in suffixes else []
    if not panels:
        there = [name for name, suffix in suffixes.items() if PICTURES[suffix](run)]
        raise InputError(f"picture: found {name!r}; expected one of {', '.join(there)}.")
    return suffixes[name], panels


def phases(run: xr.Dataset) -> tuple[list[ShadedPhase], str]:
    """Phases of the first group of contacts that goes through an operation, and its name; None if
    there is no such group."""
    if "contact_phase" not in run:
        return [], ""
    time = run.time.values
    codes = run.contact_phase.transpose("contact_group", "time").values
    for group, of in zip(run.contact_group.values, codes, strict=True):
        starts = np.flatnonzero(np.diff(of, prepend=-1))
        if is_operation(of):
            ends = [*time[starts[1:]], time[-1]]
            kinds = [Named(of[k]).name.lower().replace("_", " ") for k in starts]
            shaded = [
                ShadedPhase(*ends_of_phase)
                for ends_of_phase in zip(kinds, time[starts], ends, strict=True)
            ]
            return shaded, str(group)
    return [], ""


def _panels_of_picture(run: xr.Dataset, suffix: str, view: View) -> list[Panel]:
    return channels(run, view.channels) if view.channels else PICTURES[suffix](run)


def _picture_frame(run: xr.Dataset, suffix: str, window: TimeWindow) -> PictureFrame:
    title = run.attrs.get("title", "")
    status = run.attrs.get("status", "complete")
    title = title if status == "complete" else f"{title} ({status})"
    remarks = seas(plain(str(run.attrs.get("case_resolved", ""))))
    if length := coarse(run.time.values, window):
        remarks.append(f"bands: smallest to largest of each {length:g} s; lines: mean")
    shaded, group = phases(run)
    phases_text = ", ".join(f"{phase.name} to {phase.end:.0f} s" for phase in shaded[:-1])
    under = [f"phases of {group}: {phases_text}, then {shaded[-1].name}"] if shaded else []
    return PictureFrame(
        title,
        [*filter(None, ["; ".join(remarks)]), *under],
        window,
        shaded,
        LEGEND_COLUMNS.get(suffix, 1),
    )


def _check_window(run: xr.Dataset, window: TimeWindow) -> None:
    time = run.time.values
    if time[window.record_slice(time)].size < 2:
        raise InputError(
            f"start, end: found {window.start:g} to {window.end:g} s, with fewer than two"
            " recorded times of the run; expected a longer part of"
            f" {time[0]:g} to {time[-1]:g} s."
        )
