"""Pictures of `hydrosim show --why` (forces and displacement by contact mode) and of a comparison.

For many runs the former shows means over the stages, with intervals."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from textwrap import fill, shorten
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hydrosim.compare.comparison import ChannelResult, Comparison
from hydrosim.files.display_units import DEFAULT, DisplayUnit, Units, units_of
from hydrosim.files.outputs import Output, save_picture
from hydrosim.report.charts.panels import (
    COLOURS,
    DPI,
    PLAIN_NUMBER_POWERS,
    STYLES,
    Panel,
    axis_label,
    lines,
    mode_strips,
    picture,
    thin_records,
    wrap_title,
)
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
        return save_picture(figure, output, dpi=100)
    panels = [
        *_push_panels(run, body, direction),
        *_contact_panels(run, explain.DIRECTION_AXES[direction]),
    ]
    figure = picture(panels, f"{run.attrs.get('title', '')}: {body} in {direction}")
    for axis in figure.axes:
        for end in np.unique(
            explanations.span_begin.values[np.isfinite(explanations.span_begin.values)]
        ):
            axis.axvline(end, color="#888888", linewidth=0.6)
    return save_picture(figure, output)


def _push_panels(run: xr.Dataset, body: str, direction: str) -> Iterator[Panel]:
    """Panels of the position of the body, and of the impulses of all forces on it."""
    units = units_of(run.attrs)
    time = run.time.values
    at = {"body": body, "dof": direction}
    yield lines(time, direction, units.display_unit("m"), {"": run.position.sel(at).values})
    gained = run.impulse.sel(at) - run.impulse.sel(at).isel(time=0)
    matters = explain.significant_entries(gained, "force", LITTLE)
    pushes = {str(name).replace("_", " "): gained.sel(force=name).values for name in matters}
    if pushes:
        yield lines(time, "impulses", units.display_unit("N s"), pushes)


def _contact_panels(run: xr.Dataset, axis: str) -> Iterator[Panel]:
    """Panels for each group: impulses of friction, displacement of its points in each mode, and
    modes."""
    if "contact_friction" not in run:
        return
    units = units_of(run.attrs)
    time = run.time.values
    all_ = run.sel(axis=axis)
    groups = list(dict.fromkeys(run.fender_group.values))
    for group in groups:
        of = f" {group}"[:MAX_GROUP_NAME_LETTERS] if len(groups) > 1 else ""
        group_forces = all_.sel(fender=run.fender_group == group)
        friction = group_forces.contact_friction.sum("fender")
        ahead = -(group_forces.fender_kinetic * group_forces.slip_load_ahead).sum("fender")
        slip = friction.sel(contact_mode="slip")
        impulses = {
            "stick": friction.sel(contact_mode="stick"),
            "slip towards +": ahead,
            "slip towards -": slip - ahead,
        }
        made = {name: x.values for name, x in impulses.items()}
        yield lines(time, f"friction{of}", units.display_unit("N s"), made)
        moved = group_forces.contact_moved.mean("fender")
        moved_by_mode = {str(m): moved.sel(contact_mode=m).values for m in run.contact_mode.values}
        yield lines(time, f"moved{of}", units.display_unit("m"), moved_by_mode)
    yield mode_strips(
        time, {str(f): run.fender_mode.sel(fender=f).values for f in run.fender.values}
    )


def _draw_runs(explanations: xr.Dataset, body: str, direction: str, units: Units) -> Figure:
    """Bars of means over runs, of mean forces and, where there are contacts, of friction and
    displacements."""
    force, length = units.display_unit("N"), units.display_unit("m")
    mean = explanations.mean_force.sel(body=body, dof=direction)
    kinds = [(force.factor * mean, "force", axis_label("mean force", force.unit))]
    if "friction_part" in explanations:
        along = explanations.sel(direction=explain.DIRECTION_AXES[direction])
        part = along.friction_part.sum("fender").sel(part=list(explain.FRICTION_PARTS))
        moved = along.mode_moved.mean("fender")
        kinds += [
            (force.factor * part, "part", axis_label("mean friction", force.unit)),
            (length.factor * moved, "contact_mode", axis_label("moved in a mode", length.unit)),
        ]
    figure = Figure(figsize=(11.0, 1.5 + 2.2 * len(kinds)), layout="constrained")
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
    axis.grid(axis="y", alpha=0.3)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)
    if shown:
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05), frameon=False, fontsize="small")


# Comparison: run and recording together, their difference, a close-up at the largest one.

CHANNELS = 8  # in a picture
COMPARISON_WIDTH_INCH, CHANNEL_HEIGHT_INCH = (
    11.0,
    2.3,
)  # inches of the picture, and of a channel in it
MIN_CLOSE_UP_TIMES, CLOSE_UP_FRACTION = (
    120,
    0.04,
)  # times in a close-up, at least, and its fraction of all times


def draw_comparison(
    comparison: Comparison, title: str, output: Path | Output, units: Units = DEFAULT
) -> None:
    """Write the picture of the channels. If there are more than `CHANNELS`, it shows those with the
    largest difference."""
    furthest = sorted(comparison.results, key=lambda name: -comparison.results[name].error)[
        :CHANNELS
    ]
    shown = [result for name, result in comparison.results.items() if name in furthest]
    more = len(comparison.results) - len(shown)
    figure = Figure(
        (COMPARISON_WIDTH_INCH, CHANNEL_HEIGHT_INCH * len(shown) + 0.8),
        dpi=DPI,
        layout="constrained",
    )
    FigureCanvasAgg(figure)
    figure.suptitle(
        wrap_title(
            f"{title}; {more} channels with smaller differences are not drawn" if more else title,
            figure.get_figwidth(),
        )
    )
    ratios = {"width_ratios": [3, 1], "height_ratios": [2, 1] * len(shown)}
    axes = figure.subplots(2 * len(shown), 2, gridspec_kw=ratios)
    for row, result in enumerate(shown):
        over, under = axes[2 * row], axes[2 * row + 1]
        read = units.display_unit(result.pair.unit)
        _draw_channel(over[0], under[0], comparison.overlap.time, result, read)
        _close(over[1], under[1], comparison.overlap.time, result, read.factor)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    figure.align_ylabels(axes[:, 0])
    lines, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside upper right", ncols=2, frameon=False)
    save_picture(figure, output)


def _draw_channel(
    over: Axes, under: Axes, time: np.ndarray, result: ChannelResult, shown: DisplayUnit
) -> None:
    name = result.pair.channel.replace("_", " ").replace(".", ", ")
    _draw_part(over, under, time, result, shown.factor)
    over.set_title(shorten(f"{name}: {result.verdict}", 110), loc="left", fontsize="medium")
    over.set_ylabel(f"[{shown.unit}]" if shown.unit else "")
    under.set_ylabel(axis_label("difference\n", shown.unit))


def _close(over: Axes, under: Axes, time: np.ndarray, result: ChannelResult, factor: float) -> None:
    count = max(MIN_CLOSE_UP_TIMES, int(CLOSE_UP_FRACTION * time.size))
    first = int(np.searchsorted(time, result.figures.peak_time)) - count // 2
    first = max(min(first, time.size - count), 0)
    _draw_part(over, under, time, result, factor, slice(first, first + count))
    over.set_title("where it is largest", loc="left", fontsize="small")


def _draw_part(
    over: Axes,
    under: Axes,
    time: np.ndarray,
    result: ChannelResult,
    factor: float,
    part: slice = slice(None),
) -> None:
    """Draw both series above, and their difference below."""
    ours = factor * result.pair.ours[part]
    recorded = factor * result.pair.recorded[part]
    for name, values, dash in (("ours", ours, "-"), ("recorded", recorded, "--")):
        colour = COLOURS[name == "recorded"]
        over.plot(*thin_records(time[part], values), dash, color=colour, linewidth=0.9, label=name)
    under.plot(*thin_records(time[part], ours - recorded), color="0.3", linewidth=0.8)
    over.tick_params(labelbottom=False)
    for axis in (over, under):
        axis.margins(x=0.0)
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
        axis.ticklabel_format(axis="y", scilimits=PLAIN_NUMBER_POWERS, useOffset=False)
