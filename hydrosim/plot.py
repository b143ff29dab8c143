"""Pictures of a run: one overview, and one each of motions, fender forces, contact and energies.

Every picture is a stack of panels over a common time axis. What a scene does not have (fenders,
waves, a degree of freedom that moves) has no panel, and a picture without panels is not drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import cycle
from math import floor, log10
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hydrosim.errors import InputError

Panel = Callable[[Axes], None]
Series = Mapping[str, np.ndarray]

WIDTH, HEIGHT, DPI = 10.0, 1.6, 100  # inches of a picture and of one of its panels; dots per inch
PIXELS = 800  # about as many as a panel is wide
BANDS = 250  # columns of the modes' bands
STILL = 1e-6  # m or rad: what moves less does not move
ALIKE = 1e-6  # of their size: lines that differ less are drawn once
PREFIXES = {0: "", 3: "k", 6: "M", 9: "G"}
# Colours of Okabe & Ito (2008), which the colour-blind can tell apart, then again dashed.
BLUE, ORANGE, GREEN, PURPLE, SKY, RED, BLACK = (
    *("#0072B2", "#E69F00", "#009E73", "#CC79A7"),
    *("#56B4E9", "#D55E00", "#000000"),
)
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, RED, BLACK)
STYLES = [(colour, dash) for dash in ("-", "--", ":") for colour in COLOURS]
MODES = {2: ("slip", ORANGE), 1: ("stick", BLUE), 0: ("open", "#DDDDDD")}  # from the bottom up


def open_run(path: Path) -> xr.Dataset:
    """The dataset of a run in the netCDF file ``path``; raises InputError if it is not one."""
    remedy = "expected the result of `hydrosim run`, such as run.nc."
    if path.is_dir():
        raise InputError(f"{path}: is a directory; {remedy}")
    if not path.exists():
        raise InputError(f"{path}: there is no such file; {remedy}")
    try:
        run = xr.load_dataset(path, engine="netcdf4")
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read as netCDF ({error}); {remedy}") from None
    missing = [name for name in ("position", "energy_kinetic") if name not in run]
    if missing or run.sizes["time"] == 0:
        raise InputError(f"{path}: is netCDF without {missing or 'records'}; {remedy}")
    return run


def draw(run: xr.Dataset, folder: Path, stem: str) -> list[Path]:
    """Write the pictures of ``run`` as PNG: ``stem``.png is the overview, ``stem``_motions.png and
    so on are the details. Returns their paths; raises InputError if the folder cannot be made."""
    pictures = {
        "": overview(run),
        "_motions": motions(run),
        "_forces": fender_forces(run),
        "_contact": contact(run),
        "_energies": energies(run),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made as a folder for pictures ({error}).") from None
    paths = []
    for suffix, panels in pictures.items():
        if panels:
            paths.append(folder / f"{stem}{suffix}.png")
            picture(panels, run).savefig(paths[-1])
    return paths


def picture(panels: Sequence[Panel], run: xr.Dataset) -> Figure:
    """The panels above each other, under the title of the run."""
    figure = Figure((WIDTH, HEIGHT * len(panels) + 0.8), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(panels), sharex=True, squeeze=False)[:, 0]
    for axis, panel in zip(axes, panels, strict=True):
        panel(axis)
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    axes[-1].set(xlabel="time [s]", xlim=_span(run))
    figure.align_ylabels(axes)
    status = run.attrs.get("status", "complete")
    remark = "" if status == "complete" else f" ({status})"
    figure.suptitle(f"{run.attrs.get('title', '')}{remark}")
    return figure


def overview(run: xr.Dataset) -> list[Panel]:
    """What happened, in one picture."""
    return [*_motions_together(run), *_elevation(run), *_normal(run), *_modes(run), *_crawl(run)]


def motions(run: xr.Dataset) -> list[Panel]:
    """A panel for each degree of freedom that moves, with all bodies, and the waves."""
    panels = [
        _lines(run, dof, _unit(dof), {b: _position(run, b, dof) for b in bodies})
        for dof, bodies in _moving(run).items()
    ]
    return [*panels, *_elevation(run)]


def fender_forces(run: xr.Dataset) -> list[Panel]:
    """Normal force and friction."""
    return [*_normal(run), *_along_axes(run, run.fender_friction, "friction", "N")]


def contact(run: xr.Dataset) -> list[Panel]:
    """Modes, compression, and how far the contact points have gone and slipped."""
    if "fender" not in run.dims:
        return []
    return [
        *_modes(run),
        _lines(run, "compression", "m", _by_fender(run.fender_compression.clip(min=0.0))),
        *_crawl(run),
        _lines(run, "slip distance", "m", _by_fender(run.fender_slip_distance)),
        _lines(run, "friction loss", "J", _by_fender(run.fender_dissipated)),
    ]


def energies(run: xr.Dataset) -> list[Panel]:
    """The ledger: what is held, what was put in, what was lost, what is left over."""
    panels = [_lines(run, "kinetic", "J", {"kinetic": run.energy_kinetic.values})]
    for prefix, label in (("stored", "stored"), ("work", "work done"), ("dissipated", "lost")):
        start = f"energy_{prefix}_"
        series = {
            name.removeprefix(start).replace("_", " "): run[name].values
            for name in map(str, run.data_vars)
            if name.startswith(start) and run[name].any()
        }
        panels += [_lines(run, label, "J", series)] if series else []
    return [*panels, _lines(run, "residual", "J", {"residual": run.energy_residual.values})]


def _motions_together(run: xr.Dataset) -> Iterator[Panel]:
    """All translations in one panel, all rotations in another."""
    for label, unit in (("displacement", "m"), ("rotation", "deg")):
        series = {
            dof if run.sizes["body"] == 1 else f"{body} {dof}": _position(run, body, dof)
            for dof, bodies in _moving(run).items()
            for body in bodies
            if _unit(dof) == unit
        }
        if series:
            yield _lines(run, label, unit, series)


def _elevation(run: xr.Dataset) -> Iterator[Panel]:
    if run.wave_elevation.any():
        yield _lines(run, "wave elevation", "m", {"elevation": run.wave_elevation.values})


def _normal(run: xr.Dataset) -> Iterator[Panel]:
    if "fender" in run.dims:
        yield _lines(run, "normal force", "N", _by_fender(run.fender_normal_force))


def _modes(run: xr.Dataset) -> Iterator[Panel]:
    if "fender" in run.dims:
        yield partial(_bands, run)


def _crawl(run: xr.Dataset) -> Iterator[Panel]:
    """Where the contact nodes are, from where they were at the start, while they touch."""
    if "fender" in run.dims:
        gone = (run.fender_node - run.fender_node[0]).where(run.fender_mode > 0)
        yield from _along_axes(run, gone, "crawl", "m")


def _along_axes(run: xr.Dataset, vectors: xr.DataArray, label: str, unit: str) -> Iterator[Panel]:
    """A panel for each axis along which the vectors of the fenders are not zero."""
    for axis in run.axis.values:
        component = vectors.sel(axis=axis)
        if np.nanmax(np.abs(component), initial=0.0) > STILL:
            yield _lines(run, f"{label} {axis}", unit, _by_fender(component))


def _by_fender(values: xr.DataArray) -> Series:
    return {str(name): values.sel(fender=name).values for name in values.fender.values}


def _moving(run: xr.Dataset) -> dict[str, list[str]]:
    """The bodies that move in each degree of freedom; all of them where nothing moves at all."""
    reach = run.position.max("time") - run.position.min("time")
    moves = reach > STILL if (reach > STILL).any() else reach > -1.0
    return {
        str(dof): [str(body) for body in run.body.values[moves.sel(dof=dof)]]
        for dof in run.dof.values
        if moves.sel(dof=dof).any()
    }


def _unit(dof: str) -> str:
    return "deg" if dof in ("roll", "pitch", "yaw") else "m"


def _position(run: xr.Dataset, body: str, dof: str) -> np.ndarray:
    values = run.position.sel(body=body, dof=dof).values
    return np.degrees(values) if _unit(dof) == "deg" else values


def _span(run: xr.Dataset) -> tuple[float, float]:
    first, last = float(run.time[0]), float(run.time[-1])
    return first, last if last > first else first + 1.0


def _lines(run: xr.Dataset, label: str, unit: str, series: Series) -> Panel:
    """A panel of lines; lines that are alike are drawn once, with all their names."""
    peak = max(float(np.nanmax(np.abs(v), initial=0.0)) for v in series.values())
    factor, prefix = _prefix(peak) if unit in ("N", "J") else (1.0, "")
    scaled = {name: values / factor for name, values in _merged(series, peak).items()}
    return partial(_plot_lines, run.time.values, f"{label} [{prefix}{unit}]", scaled)


def _plot_lines(time: np.ndarray, label: str, series: Series, axis: Axes) -> None:
    for (name, values), (colour, dash) in zip(series.items(), cycle(STYLES)):
        axis.plot(*thinned(time, values), dash, color=colour, linewidth=0.9, label=name)
    axis.set_ylabel(label)
    if len(series) > 1:
        _legend(axis)


def _legend(axis: Axes) -> None:
    """Beside the panel, where it hides nothing."""
    legend = axis.legend(
        loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize="small"
    )
    for handle in legend.get_lines():
        handle.set_linewidth(2.0)


def _prefix(peak: float) -> tuple[float, str]:
    """Factor and prefix of the unit for numbers up to ``peak``."""
    power = min(max(3 * floor(log10(peak) / 3), 0), 9) if peak > 0.0 else 0
    return 10.0**power, PREFIXES[power]


def _merged(series: Series, peak: float) -> dict[str, np.ndarray]:
    """Lines that are alike under one name, "barge 1, barge 2"."""
    groups: list[tuple[list[str], np.ndarray]] = []
    for name, values in series.items():
        for names, first in groups:
            if np.allclose(values, first, rtol=0.0, atol=ALIKE * peak, equal_nan=True):
                names.append(name)
                break
        else:
            groups.append(([name], values))
    return {", ".join(names): values for names, values in groups}


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and the largest value in each of `PIXELS` bins, in their order in time: a line
    through them looks like that through all."""
    size = -(-time.size // PIXELS)
    if size <= 2:
        return time, values
    pad = (0, -time.size % size)
    bins = np.pad(values, pad, mode="edge").reshape(-1, size)
    columns = np.sort([bins.argmin(axis=1), bins.argmax(axis=1)], axis=0)
    at = np.unique(np.minimum(columns + size * np.arange(len(bins)), time.size - 1))
    return time[at], values[at]


def _bands(run: xr.Dataset, axis: Axes) -> None:
    """A band for each fender; its height is divided by the share of time spent in each mode."""
    time, modes = run.time.values, run.fender_mode.values
    edges = np.unique(np.linspace(0, len(time) - 1, BANDS + 1).astype(int))
    counts = np.diff(edges)
    for row in range(modes.shape[1]):
        base = np.full(counts.size, row + 0.1)
        for mode, (name, colour) in MODES.items():
            share = np.add.reduceat((modes[:-1, row] == mode).astype(float), edges[:-1]) / counts
            top = base + 0.8 * share
            axis.stairs(
                *(top, time[edges]),
                baseline=base,
                fill=True,
                color=colour,
                label=name if row == 0 else None,
            )
            base = top
    axis.set_yticks(np.arange(modes.shape[1]) + 0.5, labels=[str(f) for f in run.fender.values])
    axis.set_ylabel("mode")
    _legend(axis)
