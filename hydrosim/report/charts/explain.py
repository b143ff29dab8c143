"""Pictures of `hydrosim show --why` (forces and displacement by contact mode) and of a comparison.

For many runs the former shows means over the stages, with intervals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from textwrap import fill, shorten
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrosim.files.display_units import Units, units_of
from hydrosim.files.document_layout import name_with_unit
from hydrosim.files.document_nodes import Chart, ChartLine
from hydrosim.files.outputs import Output, save_picture
from hydrosim.report import run_charts
from hydrosim.report.charts.panels import (
    COLOURS,
    PLAIN_NUMBER_POWERS,
    STYLES,
    PictureFrame,
    new_figure,
    picture,
    style_axis,
    thin_records,
)
from hydrosim.report.sentences.comparison import channel_charts, channel_errors
from hydrosim.statistics import explain
from hydrosim.statistics.effects import seed_spread

if TYPE_CHECKING:
    import xarray as xr

LITTLE = 1e-3  # of the largest impulse: less is not drawn
MAX_GROUP_NAME_LETTERS = 9  # letters of a group's name that fit beside a panel
MAX_TITLE_LETTERS = 100  # letters of a line of the title


def draw_explained(
    run: xr.Dataset,
    explanations: xr.Dataset,
    body: str,
    direction: str,
    output: Path | Output,
    name: str = "",
) -> Path:
    """Draw a run, or many runs, with its ``explanations``."""
    if "run" in explanations.dims:
        units = units_of(run.attrs)
        figure = _draw_runs(explanations, body, direction, units)
        title = ", ".join(part for part in (str(run.attrs.get("title", "")), name) if part)
        means = f"means over {explanations.sizes['run']} runs with intervals of 90 %"
        figure.suptitle(
            "\n".join(
                fill(t, MAX_TITLE_LETTERS) for t in (title, f"{body} in {direction}: {means}")
            )
        )
        return save_picture(figure, output)
    charts = [
        *_push_charts(run, body, direction),
        *_contact_charts(run, explain.DIRECTION_AXES[direction]),
    ]
    title = f"{run.attrs.get('title', '')}: {body} in {direction}"
    figure = picture(charts, PictureFrame(run.time.values, units_of(run.attrs), title))
    for axis in figure.axes:
        for end in np.unique(
            explanations.span_begin.values[np.isfinite(explanations.span_begin.values)]
        ):
            axis.axvline(end, color="#888888", linewidth=0.6)
    return save_picture(figure, output)


def _push_charts(run: xr.Dataset, body: str, direction: str) -> Iterator[Chart]:
    """The position of the body, and the impulses of all forces on it."""
    at = {"body": body, "dof": direction}
    yield _chart(direction, "m", {"": run.position.sel(at)})
    gained = run.impulse.sel(at) - run.impulse.sel(at).isel(time=0)
    matters = explain.significant_entries(gained, "force", LITTLE)
    pushes = {str(name).replace("_", " "): gained.sel(force=name) for name in matters}
    if pushes:
        yield _chart("impulses", "N s", pushes)


def _contact_charts(run: xr.Dataset, axis: str) -> Iterator[Chart]:
    """Of each group: impulses of friction, displacement of its points in each mode, and modes."""
    if "contact_friction" not in run:
        return
    along = run.sel(axis=axis)
    groups = list(dict.fromkeys(run.fender_group.values))
    for group in groups:
        of = f" {group}"[:MAX_GROUP_NAME_LETTERS] if len(groups) > 1 else ""
        group_forces = along.sel(fender=run.fender_group == group)
        friction = group_forces.contact_friction.sum("fender")
        ahead = -(group_forces.fender_kinetic * group_forces.slip_load_ahead).sum("fender")
        slip = friction.sel(contact_mode="slip")
        impulses = {
            "stick": friction.sel(contact_mode="stick"),
            "slip towards +": ahead,
            "slip towards -": slip - ahead,
        }
        yield _chart(f"friction{of}", "N s", impulses)
        moved = group_forces.contact_moved.mean("fender")
        moved_by_mode = {str(m): moved.sel(contact_mode=m) for m in run.contact_mode.values}
        yield _chart(f"moved{of}", "m", moved_by_mode)
    yield from run_charts.charts_named(run, ["fender_mode"])


def _chart(quantity: str, unit: str, lines: Mapping[str, xr.DataArray]) -> Chart:
    over_time = {name: ChartLine(values.values) for name, values in lines.items()}
    return Chart(quantity, quantity, unit, over_time)


def _draw_runs(explanations: xr.Dataset, body: str, direction: str, units: Units) -> Figure:
    """Bars of means over runs, of mean forces and, where there are contacts, of friction and
    displacements."""
    force, length = units.display_unit("N"), units.display_unit("m")
    mean = explanations.mean_force.sel(body=body, dof=direction)
    kinds = [(force.factor * mean, "force", name_with_unit("mean force", force.unit))]
    if "friction_part" in explanations:
        along = explanations.sel(direction=explain.DIRECTION_AXES[direction])
        part = along.friction_part.sum("fender").sel(part=list(explain.FRICTION_PARTS))
        moved = along.mode_moved.mean("fender")
        kinds += [
            (force.factor * part, "part", name_with_unit("mean friction", force.unit)),
            (length.factor * moved, "contact_mode", name_with_unit("moved in a mode", length.unit)),
        ]
    figure = new_figure(11.0, 1.5 + 2.2 * len(kinds))
    axes = figure.subplots(len(kinds), 1, squeeze=False)[:, 0]
    for axis, (values, dim, label) in zip(axes, kinds, strict=True):
        _draw_bars(axis, values, dim, label)
    return figure


def _draw_bars(axis: Axes, values: xr.DataArray, dim: str, label: str) -> None:
    """Draw a group of bars for each stage, with one bar for each entry of ``dim`` that matters."""
    stages = explain.stages_with_values(values)
    shown = explain.significant_entries(values, dim, LITTLE)
    width = 0.8 / max(len(shown), 1)
    for k, name in enumerate(shown):
        spreads = [seed_spread(values.sel({dim: name, "span": stage}).values) for stage in stages]
        place = np.arange(len(stages)) + (k - 0.5 * len(shown) + 0.5) * width
        axis.bar(
            place,
            [x.mean for x in spreads],
            width,
            yerr=np.nan_to_num([x.high - x.mean for x in spreads]),
            label=str(name).replace("_", " "),
            color=STYLES[k % len(STYLES)].colour,
            ecolor="0.5",
            capsize=2,
        )
    axis.set_xticks(np.arange(len(stages)), labels=stages)
    axis.set_ylabel(label)
    axis.axhline(0.0, color="0.3", linewidth=0.8)
    style_axis(axis)
    axis.grid(False, axis="x")
    if shown:
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05), frameon=False, fontsize="small")


# Comparison: run and recording together, their difference, a close-up at the largest one.

CHANNELS = 8  # in a picture
MAX_LABEL_LETTERS = 11  # letters of a line beside an axis
COMPARISON_WIDTH_INCH, CHANNEL_HEIGHT_INCH = (
    11.0,
    2.3,
)  # inches of the picture, and of a channel in it
MIN_CLOSE_UP_TIMES, CLOSE_UP_FRACTION = (
    120,
    0.04,
)  # times in a close-up, at least, and its fraction of all times


def draw_comparison(comparison: xr.Dataset, title: str, output: Path | Output) -> None:
    """Write the picture of the channels. If there are more than `CHANNELS`, it shows those with the
    largest difference."""
    furthest = sorted(np.argsort(-channel_errors(comparison), kind="stable")[:CHANNELS])
    drawn = [comparison.isel(channel=k) for k in furthest]
    more = comparison.sizes["channel"] - len(drawn)
    title += f"; {more} channels with smaller differences are not drawn" if more else ""
    figure = new_figure(COMPARISON_WIDTH_INCH, CHANNEL_HEIGHT_INCH * len(drawn) + 0.8, title)
    ratios = {"width_ratios": [3, 1], "height_ratios": [2, 1] * len(drawn)}
    axes = figure.subplots(2 * len(drawn), 2, gridspec_kw=ratios)
    for row, channel in enumerate(drawn):
        charts, close_up = channel_charts(channel), _close_up(channel)
        for axis_row, chart in zip(axes[2 * row : 2 * row + 2], charts, strict=True):
            shown = units_of(comparison.attrs).display_unit(chart.unit)
            for axis, part in zip(axis_row, (slice(None), close_up), strict=True):
                _draw_part(axis, channel.time.values[part], chart, part, shown.factor)
            axis_row[0].set_ylabel(
                fill(name_with_unit(chart.quantity, shown.unit), MAX_LABEL_LETTERS)
            )
        over, close = axes[2 * row]
        over.set_title(shorten(charts[0].title, 110), loc="left", fontsize="medium")
        close.set_title("where it is largest", loc="left", fontsize="small")
        for axis in (over, close):
            axis.tick_params(labelbottom=False)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    figure.align_ylabels(axes[:, 0])
    lines, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside upper right", ncols=2, frameon=False)
    save_picture(figure, output)


def _close_up(channel: xr.Dataset) -> slice:
    """The records about the largest difference."""
    time = channel.time.values
    count = max(MIN_CLOSE_UP_TIMES, int(CLOSE_UP_FRACTION * time.size))
    first = int(np.searchsorted(time, float(channel.peak_time))) - count // 2
    first = max(min(first, time.size - count), 0)
    return slice(first, first + count)


def _draw_part(axis: Axes, time: np.ndarray, chart: Chart, part: slice, factor: float) -> None:
    """Draw a part of the lines of a chart; a single line is grey."""
    looks = zip(COLOURS, ("-", "--"), strict=False) if len(chart.lines) > 1 else [("0.3", "-")]
    for (name, line), (colour, dash) in zip(chart.lines.items(), looks, strict=True):
        places = thin_records(time, factor * line.y[part])
        axis.plot(*places, dash, color=colour, linewidth=0.9, label=name)
    axis.margins(x=0.0)
    style_axis(axis)
    axis.ticklabel_format(axis="y", scilimits=PLAIN_NUMBER_POWERS, useOffset=False)
