"""Pictures of a run (overview, motions, contacts, lines, tanks, energies), drawn to files.

Absent parts of a scene (fenders, waves, a degree of freedom that moves) have no panel. A picture
without panels is not drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hydrosim.case.tables import seas
from hydrosim.dofs import DOFS
from hydrosim.elements.kind import Topic
from hydrosim.errors import InputError
from hydrosim.files.display_units import units_of
from hydrosim.files.document_nodes import Chart, ChartLine
from hydrosim.files.outputs import Output, make_folder, save_picture
from hydrosim.report import run_charts
from hydrosim.report.charts.panels import (
    MAX_LINES_PER_PANEL,
    PictureFrame,
    TimeWindow,
    coarse,
    draw_chart,
    group_lines,
    merge_equal_lines,
    picture,
)
from hydrosim.report.sentences.sections import case_data
from hydrosim.results.channels import channel_names, match_channels
from hydrosim.results.phases import CONTACT_WEIGHT
from hydrosim.results.variables import TENSIONS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

LITTLE = 1e-3  # of the largest friction: smaller components along an axis are not drawn
MANY = 12  # contacts with panels of their own; if there are more, each group has a panel


def overview(run: xr.Dataset) -> list[Chart]:
    """What people look at first."""
    return run_charts.charts_about(run, Topic.MOTIONS, Topic.CLEARANCES)


def motions(run: xr.Dataset) -> list[Chart]:
    """Each degree of freedom that moves, with all bodies, and the waves."""
    by_dof = run_charts.chart_by_line([*run_charts.motion_charts(run)])
    waves = run_charts.charts_about(run, Topic.WATER, Topic.CONTACTS)
    return [*sorted(by_dof, key=lambda chart: DOFS.index(chart.quantity)), *waves]


def fender_forces(run: xr.Dataset) -> list[Chart]:
    """The normal force of each contact point, with its friction components beside it."""
    if "fender" not in run.dims:
        return []
    normal = run_charts.contact_chart(run, "normal force", "N", run.fender_normal_force)
    normal, *friction = (
        group_lines(chart, MANY) for chart in (normal, *run_charts.friction_charts(run))
    )
    together = {
        name: ChartLine(np.hstack([line.y, *(chart.lines[name].y for chart in friction)]))
        for name, line in normal.lines.items()
    }
    merged = {names[0]: ", ".join(names) for names, _ in merge_equal_lines(together)}
    normal, *friction = (
        replace(chart, lines={text: chart.lines[name] for name, text in merged.items()})
        for chart in (normal, *friction)
    )
    least = LITTLE * max(chart.peak for chart in friction)
    acting = [chart for chart in friction if chart.peak > least] or friction[:1]
    quantity = "friction"
    if len(acting) == 1:
        quantity = f"friction {acting[0].subject}"
        acting = [replace(acting[0], subject="")]
    left = run_charts.chart_each_line(normal)
    right = run_charts.chart_by_line(acting, quantity)
    return [chart for row in zip(left, right, strict=True) for chart in row]


def contact(run: xr.Dataset) -> list[Chart]:
    """Modes, compression, path length and slip of the contact points."""
    names = ("fender_mode", "compression", "crawl", "fender_slip_distance", "fender_dissipated")
    return run_charts.charts_named(run, names) if "fender" in run.dims else []


def transfer(run: xr.Dataset) -> list[Chart]:
    """A transfer of weight between groups of contacts: its fraction, loads, clearances."""
    if CONTACT_WEIGHT not in run.coords:
        return []
    groups = run.contact_group.values[run[CONTACT_WEIGHT].values > 0.0]
    taken = run.isel(fender=np.isin(run.fender_group.values, groups))
    names = ("transferred", "contact_load", "fender_normal_force", "gap", "clearance")
    return run_charts.charts_named(taken, names)


def tensions(run: xr.Dataset) -> list[Chart]:
    """The tension of each line, all over one range, loads of struts and torsion springs, absorbed
    powers, and the utilisation of capacities."""
    loads: list[Chart] = []
    for name in TENSIONS.values():
        charts = run_charts.charts_named(run, [name])
        lines = (line for chart in charts for line in run_charts.chart_each_line(chart))
        loads += sorted(lines, key=lambda line: line.order.index(line.subject))
    loads += run_charts.charts_about(run, Topic.COORDINATES, Topic.CAPACITIES)
    return [*loads, *run_charts.charts_named(run, ["utilisation"])] if loads else []


def joints(run: xr.Dataset) -> list[Chart]:
    """Motions of joints, what acts in them, and their loads."""
    names = ("joint_position", "joint_motion_force", "joint_loads")
    return run_charts.charts_named(run, names) if "joint" in run.dims else []


def tanks(run: xr.Dataset) -> list[Chart]:
    """Tank levels and pump rates."""
    return run_charts.charts_named(run, ("tank_level", "pump_rate"))


def energies(run: xr.Dataset) -> list[Chart]:
    """The energy balance: energy held, work, losses, residual."""
    return run_charts.energy_charts(run)


PICTURES: dict[str, Callable[[xr.Dataset], list[Chart]]] = {
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


def channels(run: xr.Dataset, chosen: Sequence[str]) -> list[Chart]:
    """Channels by name: channels of one kind and unit share a panel; many have one each."""
    return [
        panel
        for chart in run_charts.channel_charts(run, chosen)
        for panel in (
            run_charts.chart_each_line(chart)
            if len(merge_equal_lines(chart.lines)) > MAX_LINES_PER_PANEL
            else [chart]
        )
    ]


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
    """Selection for the pictures of a run: the time, the channels (default: the usual ones), the
    format, and whether the picture of channels has the name of the run alone."""

    window: TimeWindow = ALWAYS
    channels: Sequence[str] = ()
    format: Format = Format.PNG
    is_one_file: bool = False

    def pictures(self) -> dict[str, str]:
        """Names of all possible files, by the suffix after the name of the run."""
        suffixes = ["_channels"] if self.channels else [*PICTURES]
        if self.is_one_file:
            return dict.fromkeys(suffixes, f".{self.format}")
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
    charts = (_charts_of_picture(run, suffix, view) for suffix in view.pictures())
    return [
        save_picture(picture(drawn, _picture_frame(run, suffix, view.window)), output)
        for drawn, suffix, output in zip(charts, view.pictures(), outputs, strict=True)
        if drawn
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
    suffix, charts = _charts_by_name(run, name)
    _check_window(run, window)
    return picture(charts, _picture_frame(run, suffix, window))


def picture_names() -> list[str]:
    """Names of all pictures of runs."""
    return [charts.__name__ for charts in PICTURES.values()]


def draw_on_axes(run: xr.Dataset, name: str, axes: Axes | Sequence[Axes]) -> Figure:
    """Draw the panels of a picture on axes of matplotlib, one each; return their figure. Raises
    InputError for another number of axes."""
    return _draw_charts(run, _charts_by_name(run, name)[1], axes)


def draw_channels(
    run: xr.Dataset, patterns: Sequence[str], axes: Axes | Sequence[Axes] | None = None
) -> Figure:
    """Draw channels that patterns match in a new figure, or on ``axes`` as `draw_on_axes` does."""
    charts = channels(run, match_channels(channel_names(run), patterns, "channels"))
    if axes is None:
        return picture(charts, _picture_frame(run, "_channels", ALWAYS))
    return _draw_charts(run, charts, axes)


def _draw_charts(run: xr.Dataset, charts: Sequence[Chart], axes: Axes | Sequence[Axes]) -> Figure:
    places = np.atleast_1d(np.asarray(axes, object)).ravel()
    if len(places) != len(charts):
        raise InputError(
            f"ax: found {len(places)} axes; expected {len(charts)}, one for each panel:"
            f" figure, ax = plt.subplots({len(charts)})."
        )
    frame = PictureFrame(run.time.values, units_of(run.attrs))
    for axis, chart in zip(places, charts, strict=True):
        draw_chart(axis, chart, frame)
        axis.set_xlabel("time [s]")
    return places[0].figure


def _charts_by_name(run: xr.Dataset, name: str) -> tuple[str, list[Chart]]:
    """Suffix and charts of a picture; InputError if there is none, or no data for it."""
    suffixes = {of.__name__: suffix for suffix, of in PICTURES.items()}
    charts = PICTURES[suffixes[name]](run) if name in suffixes else []
    if not charts:
        there = [name for name, suffix in suffixes.items() if PICTURES[suffix](run)]
        hint = f" Channels are drawn by plot.channels({name!r})." if "." in name else ""
        raise InputError(f"picture: found {name!r}; expected one of {', '.join(there)}.{hint}")
    return suffixes[name], charts


def _charts_of_picture(run: xr.Dataset, suffix: str, view: View) -> list[Chart]:
    return channels(run, view.channels) if view.channels else PICTURES[suffix](run)


def _picture_frame(run: xr.Dataset, suffix: str, window: TimeWindow) -> PictureFrame:
    title = run.attrs.get("title", "")
    status = run.attrs.get("status", "complete")
    title = title if status == "complete" else f"{title} ({status})"
    remarks = seas(case_data(run))
    if length := coarse(run.time.values, window):
        remarks.append(f"bands: smallest to largest of each {length:g} s; lines: mean")
    shaded, phases_text = run_charts.shaded_phases(run)
    return PictureFrame(
        run.time.values,
        units_of(run.attrs),
        title,
        list(filter(None, ["; ".join(remarks), phases_text])),
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
