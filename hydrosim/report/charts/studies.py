"""Pictures of studies: figures over parameters with scatter over seeds, and limits of operation.

A plan of one parameter is a line with bands, of two parameters a heat map, of one parameter at a
time a tornado chart. Values without an order are points with bars. Samples are points, and Sobol's
indices are bars. Values that are lists or long texts become letters with a key.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from textwrap import fill, shorten
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator

from hydrosim.errors import InputError
from hydrosim.files.display_units import DisplayUnit, units_of
from hydrosim.files.document_layout import digits_of, letter_of, name_with_unit, value_text
from hydrosim.files.document_nodes import Chart
from hydrosim.files.outputs import Output, save_picture
from hydrosim.report.charts.panels import COLOURS, new_figure, style_axis
from hydrosim.report.sentences.limits import NO_LIMIT, limit_chart
from hydrosim.report.sentences.study import effect_chart, numeric_axis
from hydrosim.statistics import effects
from hydrosim.statistics.effects import EffectRow, PlanRuns, SeedSpread

if TYPE_CHECKING:
    import xarray as xr

MAX_LETTERS_OF_NAME = 12
MAX_LETTERS_OF_ALL_NAMES = 54
MAX_LETTERS_OF_MEANING = 240
LETTERS_OF_KEY_LINE = 42


class ValueNames:
    """Names of values beside axes. Values that are too long for an axis get letters, the same ones
    in all panels of a picture; `key` says what they mean."""

    def __init__(self) -> None:
        self._letters: dict[str, str] = {}

    def names_of(self, values: Sequence[object]) -> list[str]:
        """A name for each of the ``values``, which stand beside one axis."""
        texts = [value_text(value) for value in values]
        room = min(MAX_LETTERS_OF_NAME, max(4, MAX_LETTERS_OF_ALL_NAMES // max(len(texts), 1)))
        if all(len(text) <= room for text in texts):
            return texts
        return [self._letters.setdefault(text, letter_of(len(self._letters))) for text in texts]

    def key(self) -> list[str]:
        """Each letter with its value, in lines that fit beside a picture."""
        return [
            fill(
                f"{letter}: {shorten(text, MAX_LETTERS_OF_MEANING, placeholder=' ...')}",
                LETTERS_OF_KEY_LINE,
            )
            for text, letter in self._letters.items()
        ]


DECADES = 1.5  # ratio of values above which their axis is logarithmic
EFFECT_PANEL_INCH = (5.0, 3.6)  # inches of a panel
KEY_WIDTH = 3.4  # inches of the key of letters beside the panels
LINE_HEIGHT, HEIGHT_OF_TITLE = 0.17, 1.0  # inches of a line of the key, of what is above it
TALLEST, WIDEST = 3, 3  # panels above each other, until there are so many beside each other


def draw_study(runs: xr.Dataset, output: Output) -> list[Path]:
    """Draw a picture for each plan of the file of ``runs``; its name is that of ``output`` with the
    plan."""
    return [save_picture(page(plan), place) for plan, place in planned_of(runs, output)]


def planned_of(runs: xr.Dataset, output: Output) -> list[tuple[PlanRuns, Output]]:
    """Plans with something to draw, and their outputs. Raises InputError if there are none, or if a
    picture must not be replaced."""
    plans_and_outputs, form = [], output.path.suffix if output.path.suffix != ".nc" else ".png"
    for plan in effects.plans(runs):
        stem = f"{output.path.stem}_{plan.name}" if plan.name else output.path.stem
        if plan.figures:
            place = output.output_at(output.path.with_name(f"{stem}{form}"), "picture")
            plans_and_outputs.append((plan, place.checked_output()))
    if not plans_and_outputs:
        raise InputError(
            f"{output.origin}: its study has no figures to draw. Add some to the study: figures:"
            f" {{NAME: {{channel: .., statistic: ..}}}}."
        )
    return plans_and_outputs


def page(plan: PlanRuns) -> Figure:
    """Picture of a plan: a panel for each figure; for samples, a panel for each figure and
    parameter."""
    draw = _chart_of_plan(plan)
    columns = len(plan.parameters) if draw is _draw_points else 1
    across = columns if draw is _draw_points else _column_count(len(plan.figures))
    down = -(-columns * len(plan.figures) // across)
    title = str(runs_title(plan.runs))
    title = f"{title}: {_words_of_name(plan.name)}" if plan.name else title
    width, height = EFFECT_PANEL_INCH
    figure = new_figure(width * max(across, 1.3), height * down, title)
    panels = figure.subplots(down, across, squeeze=False).ravel()
    drawn = panels[: columns * len(plan.figures)]
    for spare in panels[drawn.size :]:
        spare.remove()
    names = ValueNames()
    for name, axes in zip(plan.figures, drawn.reshape(-1, columns).tolist(), strict=True):
        draw(axes, plan, name, names)
        for axis in axes:
            style_axis(axis)
    _add_shared_legend(figure, drawn[0])
    _add_letter_key(figure, names.key())
    return figure


def _column_count(figures: int) -> int:
    """How many panels stand beside each other, so that a picture of many fits a page."""
    return min(-(-figures // TALLEST), WIDEST)


def _add_shared_legend(figure: Figure, axis: Axes) -> None:
    """One legend for all panels, below them, where it hides nothing."""
    lines, names = axis.get_legend_handles_labels()
    if names:
        figure.legend(lines, names, loc="outside lower center", ncols=len(names), frameon=False)


def _add_letter_key(figure: Figure, key: Sequence[str]) -> None:
    """Beside the panels, write what the letters of values mean."""
    if key:
        lines = sum(1 + text.count("\n") for text in key)
        height = LINE_HEIGHT * (lines + 0.5 * len(key)) + HEIGHT_OF_TITLE
        figure.set_size_inches(
            figure.get_figwidth() + KEY_WIDTH, max(figure.get_figheight(), height)
        )
        blank = [Line2D([], [], linestyle="none") for _ in key]
        look: dict[str, Any] = {"handlelength": 0.0, "handletextpad": 0.0, "fontsize": "small"}
        figure.legend(blank, key, loc="outside right center", frameon=False, **look)


def _words_of_name(name: str) -> str:
    return name.replace("_", " ")


def runs_title(runs: xr.Dataset) -> str:
    """Name of the file of runs."""
    return str(runs.attrs.get("title", "study"))


def _chart_of_plan(plan: PlanRuns) -> Callable[[Sequence[Axes], PlanRuns, str, ValueNames], None]:
    if plan.design == "sobol_indices":
        return _draw_bars
    if plan.design in effects.SAMPLED_DESIGNS:
        return _draw_points
    if not plan.parameters:
        return _draw_by_seed
    if plan.design == "one_at_a_time":
        return _draw_tornado
    return _draw_heat_map if len(plan.parameters) == 2 else _draw_band


def _quantity_label(plan: PlanRuns, figure: str) -> str:
    return name_with_unit(_words_of_name(figure), _display_unit(plan, figure).unit)


def _parameter_label(plan: PlanRuns, parameter: str) -> str:
    """The last two words of a key, and its unit."""
    return name_with_unit(plan.short(parameter), _display_unit(plan, plan.axis(parameter)).unit)


def _display_unit(plan: PlanRuns, name: str) -> DisplayUnit:
    """In which unit a figure or the coordinate of a parameter is read."""
    return units_of(plan.runs.attrs).display_unit(plan.unit(name))


def _read_values(plan: PlanRuns, name: str, values: Any) -> Any:
    """A value of a figure or a parameter, or many, in the unit that it is read in. Texts stay."""
    kind = np.asarray(values).dtype.kind
    return _display_unit(plan, name).factor * values if kind == "f" else values


def _effect_rows(plan: PlanRuns, figure: str) -> list[EffectRow]:
    """The rows of a figure, in the units that they are read in."""
    factor = _display_unit(plan, figure).factor
    return [
        row._replace(
            values={name: _read_values(plan, name, value) for name, value in row.values.items()},
            spread=SeedSpread(row.spread.n, *(factor * value for value in row.spread[1:])),
        )
        for row in effects.rows(plan)
        if row.figure == figure
    ]


def _draw_by_seed(axes: Sequence[Axes], plan: PlanRuns, figure: str, names: ValueNames) -> None:
    """Draw a plan that varies seeds only: each seed, the mean with its interval, and the band of 90
    % of the seeds."""
    axis, (row,) = axes[0], _effect_rows(plan, figure)
    seeds = plan.runs["seed"].values if "seed" in plan.runs else np.arange(row.runs.size)
    seed_numbers = seeds if seeds.ndim == 1 else seeds[:, 0]
    s = row.spread
    axis.axhspan(s.another_low, s.another_high, color=COLOURS[0], alpha=0.15, label="90 % of seeds")
    axis.axhspan(s.low, s.high, color=COLOURS[0], alpha=0.35, label="mean, 90 %")
    axis.axhline(s.mean, color=COLOURS[0])
    axis.plot(seed_numbers, _read_values(plan, figure, plan.runs[figure].values), ".", color="0.4")
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    axis.set_xlabel("seed")
    axis.set_ylabel(_quantity_label(plan, figure))


def _draw_band(axes: Sequence[Axes], plan: PlanRuns, figure: str, names: ValueNames) -> None:
    """Draw the mean over the values with its interval, and the band of 90 % of the seeds. A line
    joins numbers; other values have no order, so they are points with bars. Several parameters are
    in the order of their combinations."""
    rows, axis = [row for row in effects.rows(plan) if row.figure == figure], axes[0]
    numeric = numeric_axis(plan) if len(plan.parameters) == 1 else ""
    (line,) = effect_chart(plan, rows, numeric).lines.values()
    x = _read_values(plan, numeric, line.x) if numeric else line.x
    mean, low, high, wide = (
        _read_values(plan, figure, of) for of in (line.y, line.low, line.high, line.wide)
    )
    if numeric:
        _scale_axis(x, axis)
        axis.fill_between(x, *wide, color=COLOURS[0], alpha=0.15, label="90 % of seeds")
    else:
        size = wide[1] - wide[0]
        axis.bar(x, size, 0.5, wide[0], color=COLOURS[0], alpha=0.15, label="90 % of seeds")
    if np.isnan(mean).all():
        axis.text(0.5, 0.5, "no run has a value", transform=axis.transAxes, ha="center")
    look: dict[str, Any] = {"color": COLOURS[0], "marker": "o", "capsize": 3}
    look["linestyle"] = "-" if numeric else "none"
    axis.errorbar(x, mean, np.abs([low - mean, high - mean]), label="mean, 90 %", **look)
    for place, values in zip(x, line.values, strict=True):
        runs = _read_values(plan, figure, values)
        axis.plot(np.full(runs.size, place), runs, ".", color="0.4", markersize=3)
    if not numeric:
        every = [[*row.values.values()] for row in _effect_rows(plan, figure)]
        combined = [v[0] if len(v) == 1 else ", ".join(map(value_text, v)) for v in every]
        axis.set_xticks(x, names.names_of(combined))
        axis.set_xlim(-0.6, x.size - 0.4)
    axis.set_ylabel(_quantity_label(plan, figure))
    axis.set_xlabel(", ".join(_parameter_label(plan, parameter) for parameter in plan.parameters))


def _scale_axis(x: np.ndarray, axis: Axes) -> None:
    """Make an axis logarithmic if its numbers span decades."""
    above = x[x > 0.0]
    if above.size and (x >= 0.0).all() and np.log10(above.max() / above.min()) > DECADES:
        zero = (x == 0.0).any()
        axis.set_xscale("symlog" if zero else "log", **({"linthresh": above.min()} if zero else {}))
        axis.xaxis.set_major_locator(FixedLocator(np.unique(x).tolist()))
        axis.xaxis.set_major_formatter(lambda value, _: digits_of(value))
        axis.xaxis.set_minor_locator(NullLocator())


def _draw_heat_map(axes: Sequence[Axes], plan: PlanRuns, figure: str, names: ValueNames) -> None:
    """Draw the mean over the values of two parameters."""
    rows, axis = _effect_rows(plan, figure), axes[0]
    first, second = (plan.axis(parameter) for parameter in plan.parameters)
    x, y = ([*dict.fromkeys(row.values[name] for row in rows)] for name in (first, second))
    mean = np.full((len(y), len(x)), np.nan)
    for row in rows:
        mean[y.index(row.values[second]), x.index(row.values[first])] = row.spread.mean
    image = axis.imshow(mean, origin="lower", aspect="auto", cmap="viridis")
    finite = mean[np.isfinite(mean)]
    bright = finite.min() + 0.6 * np.ptp(finite) if finite.size else np.nan
    for (j, i), value in np.ndenumerate(mean):
        text = f"{value:.3g}" if np.isfinite(value) else "no value"
        colour = "white" if value < bright else "black"
        axis.text(i, j, text, ha="center", va="center", color=colour, fontsize="small")
    for set_ticks, values in ((axis.set_xticks, x), (axis.set_yticks, y)):
        set_ticks(range(len(values)), names.names_of(values))
    x_parameter, y_parameter = plan.parameters
    axis.set_xlabel(_parameter_label(plan, x_parameter))
    axis.set_ylabel(_parameter_label(plan, y_parameter))
    axis.figure.colorbar(image, ax=axis, label=f"mean {_quantity_label(plan, figure)}")


def _draw_tornado(axes: Sequence[Axes], plan: PlanRuns, figure: str, names: ValueNames) -> None:
    """Draw a bar from the smallest to the largest mean of each parameter, including that of the
    case, the widest on top."""
    rows, axis = _effect_rows(plan, figure), axes[0]
    base = next(row.spread.mean for row in rows if not row.values["varied"])
    bars: list[tuple[float, float, list[EffectRow], str]] = []
    for parameter in plan.parameters:
        varied = [row for row in rows if row.values["varied"] == parameter and row.spread.n]
        varied.sort(key=lambda row: row.spread.mean)
        means = [row.spread.mean for row in varied] or [base]
        bars.append((np.fmin(base, means[0]), np.fmax(base, means[-1]), varied, parameter))
    bars.sort(key=lambda bar: bar[1] - bar[0])
    for k, (low, high, varied, parameter) in enumerate(bars):
        axis.barh(k, high - low, left=low, color=COLOURS[0], alpha=0.6)
        for row in (*varied[:1], *varied[1:][-1:]):
            value, mean = row.values[plan.axis(parameter)], row.spread.mean
            text = f"{value:.3g}" if isinstance(value, float) else names.names_of([value])[0]
            is_lower = mean < base or (row is varied[0] and len(varied) > 1)
            side = "right" if is_lower else "left"
            axis.text(mean, k, f" {text} ", ha=side, va="center", fontsize="small")
        if not varied and np.isfinite(base):
            axis.text(base, k, " no run has a value", va="center", fontsize="small")
    axis.axvline(base, color="0.3")
    axis.use_sticky_edges = False
    axis.margins(x=0.2)
    axis.set_yticks(range(len(bars)), [_parameter_label(plan, bar[3]) for bar in bars])
    axis.set_xlabel(f"mean {_quantity_label(plan, figure)}, line: the case")


def _draw_points(axes: Sequence[Axes], plan: PlanRuns, figure: str, names: ValueNames) -> None:
    for axis, parameter in zip(axes, plan.parameters, strict=True):
        name = plan.axis(parameter)
        x = _read_values(plan, name, plan.runs[name].values)
        y = _read_values(plan, figure, plan.runs[figure].values)
        axis.plot(x, y, ".", color=COLOURS[0])
        axis.set_xlabel(_parameter_label(plan, parameter))
    axes[0].set_ylabel(_quantity_label(plan, figure))


def _draw_bars(axes: Sequence[Axes], plan: PlanRuns, figure: str, names: ValueNames) -> None:
    """Draw first-order and total indices with their intervals."""
    axis = axes[0]
    sobol_indices = [index for index in effects.indices(plan) if index.figure == figure]
    for shift, kind, colour in ((-0.2, "first", COLOURS[0]), (0.2, "total", COLOURS[1])):
        value, low, high = np.array([getattr(index, kind) for index in sobol_indices]).T
        label = "alone" if kind == "first" else "with all interactions"
        y = np.arange(len(sobol_indices)) + shift
        sure = np.clip([value - low, high - value], 0.0, None)
        axis.barh(y, value, 0.35, xerr=sure, color=colour, label=label, capsize=3)
    axis.set_yticks(
        range(len(sobol_indices)),
        [_parameter_label(plan, index.parameter) for index in sobol_indices],
    )
    axis.set_xlabel(f"share of the variance of {_words_of_name(figure)}")


# Limits: significant height over peak period, with the governing criterion.

MARKS = "osD^vP*X"
STYLES = ("-", (0, (6, 2)), (0, (2, 2)), (0, (6, 2, 1, 2)))
"""Of lines after each other, so that one under another is seen."""
OPEN_MARKS = dict(zip(NO_LIMIT.values(), "v^", strict=True))
"""Marks of seas whose limit is on a side of the heights."""
OPERABILITY_PANEL_INCH = (7.5, 3.6)  # inches of a panel


def draw_limits(limits: xr.Dataset, output: Path | Output) -> None:
    """Draw a panel for each stage, with a line and its interval for each heading and swell. The
    marker at each point shows the criterion that governs there."""
    stages = [str(stage) for stage in limits.stage.values]
    share = f"{limits.attrs['probability']:.3g} of the seas meet all criteria"
    title = f"{limits.attrs['title']}: limits up to which {share}"
    width, height = OPERABILITY_PANEL_INCH
    figure = new_figure(width, height * len(stages) + 0.4, title)
    axes = figure.subplots(len(stages), 1, squeeze=False, sharex=True)[:, 0]
    names = sorted({str(name) for name in limits.governing.values.ravel() if name})
    for axis, stage in zip(axes, stages, strict=True):
        draw_limit_chart(axis, limit_chart(limits.sel(stage=stage)), names)
        axis.set_title(stage if len(stages) > 1 else "", loc="left", fontsize="medium")
    axes[-1].set_xlabel("peak period [s]")
    save_picture(figure, output)


def draw_limit_chart(axis: Axes, chart: Chart, names: Sequence[str]) -> None:
    """Draw limits, marked by which of the criteria of these ``names`` governs. A sea without a
    limit within the heights has no point on a line but an open mark at the first or the last
    height."""
    marks = {f"governed by {n}": MARKS[k % len(MARKS)] for k, n in enumerate(names)} | OPEN_MARKS
    for k, (label, line) in enumerate(chart.lines.items()):
        colour, dash = COLOURS[k % len(COLOURS)], STYLES[k % len(STYLES)]
        if line.low.size:
            axis.fill_between(line.x, line.low, line.high, color=colour, alpha=0.15)
        axis.plot(line.x, line.y, color=colour, linestyle=dash, label=label)
        size = 6.0 + 3.0 * (len(chart.lines) - k)
        for remark, mark in marks.items():
            of = np.array(line.remarks) == remark
            look: dict[str, Any] = {"color": colour}
            values = line.y
            if remark in OPEN_MARKS:
                look |= {"fillstyle": "none", "markersize": size}
                values = line.bounds
            axis.plot(line.x[of], values[of], mark, **look)
    remarks = {remark for line in chart.lines.values() for remark in line.remarks}
    for remark, mark in marks.items():
        if remark in remarks or remark not in OPEN_MARKS:
            style = "none" if remark in OPEN_MARKS else "full"
            axis.plot([], [], mark, color="0.3", fillstyle=style, label=remark)
    axis.set_ylabel(name_with_unit(chart.quantity, chart.unit))
    axis.set_ylim(bottom=0.0)
    style_axis(axis)
    axis.legend(frameon=False, fontsize="small")
