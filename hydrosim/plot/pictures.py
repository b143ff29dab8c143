"""The pictures of a run: one overview, and one each of motions, fender forces, contact, energies.

What a scene does not have (fenders, waves, a degree of freedom that moves) has no panel, and a
picture without panels is not drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from hydrosim.errors import InputError
from hydrosim.outputs import Output, save_picture
from hydrosim.plot.panels import Panel, Series, apart, bands, lines, peak, picture
from hydrosim.results.contact import crawl
from hydrosim.results.stages import transferred

STILL = 1e-6  # m or rad: what moves less does not move
ROTATIONS = ("roll", "pitch", "yaw")


def draw(
    run: xr.Dataset, folder: Path, stem: str, origin: Path | None = None, overwrite: bool = False
) -> list[Path]:
    """Write the pictures of ``run`` as PNG: ``stem``.png is the overview, ``stem``_motions.png and
    so on are the details. Returns their paths; raises InputError if the folder cannot be made, or
    where other files than earlier pictures of the same run, ``origin``, have these names."""
    outputs = planned(folder, stem, origin, overwrite)
    drawn = zip(outputs, (of(run) for of in PICTURES.values()), strict=True)
    return [
        save_picture(picture(panels, _title(run)), output) for output, panels in drawn if panels
    ]


def planned(
    folder: Path, stem: str, origin: Path | None = None, overwrite: bool = False
) -> list[Output]:
    """All pictures that there can be of a run; raises as `draw` does."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made as a folder for pictures ({error}).") from None
    made_of = origin or folder / f"{stem}.nc"
    paths = [folder / f"{stem}{suffix}.png" for suffix in PICTURES]
    return [
        Output(path, "picture", made_of, (made_of,), overwrite, "pictures").checked()
        for path in paths
    ]


def figure(run: xr.Dataset, name: str = "overview") -> Figure:
    """One of the pictures of a run by its name, "overview", "motions"; InputError if there is none
    of that name, or the run has nothing that it shows."""
    known = {of.__name__: of for of in PICTURES.values()}
    panels = known[name](run) if name in known else []
    if not panels:
        there = [each for each, of in known.items() if of(run)]
        raise InputError(f"picture: found {name!r}; expected one of {', '.join(there)}.")
    return picture(panels, _title(run))


def overview(run: xr.Dataset) -> list[Panel]:
    """What happened, in one picture."""
    panels = [*_motions_together(run), *_elevation(run)]
    if "fender" in run.dims:
        panels += [_lines(run, "normal force", "N", _by_fender(run.fender_normal_force))]
        panels += [_modes(run), *_crawl(run)]
    return panels


def motions(run: xr.Dataset) -> list[Panel]:
    """A panel for each degree of freedom that moves, with all bodies, and the waves."""
    single = run.sizes["body"] == 1
    panels = [
        _lines(run, dof, _unit(dof), {"" if single else b: _position(run, b, dof) for b in bodies})
        for dof, bodies in _moving(run).items()
    ]
    return [*panels, *_elevation(run)]


def fender_forces(run: xr.Dataset) -> list[Panel]:
    """Normal force and friction, a panel for each contact point."""
    if "fender" not in run.dims:
        return []
    time = run.time.values
    panels = [*apart(time, "normal force", "N", _by_fender(run.fender_normal_force))]
    for axis, component in _components(run.fender_friction):
        panels += apart(time, f"friction {axis}", "N", component)
    return panels


def contact(run: xr.Dataset) -> list[Panel]:
    """Modes, compression, and how far the contact points have gone and slipped."""
    if "fender" not in run.dims:
        return []
    return [
        _modes(run),
        _lines(run, "compression", "m", _by_fender(run.fender_compression.clip(min=0.0))),
        *_crawl(run),
        _lines(run, "slip distance", "m", _by_fender(run.fender_slip_distance)),
        _lines(run, "friction loss", "J", _by_fender(run.fender_dissipated)),
    ]


def transfer(run: xr.Dataset) -> list[Panel]:
    """Of a weight that goes from one group of contacts to another: its share, loads, clearances."""
    if "contact_weight" not in run.coords:
        return []
    share, load = transferred(run), run.contact_load
    groups = share.contact_group.values
    gaps = -run.fender_compression.sel(fender=run.fender_group.isin(groups)).clip(max=0.0)
    panels = [
        _lines(run, "transferred", "1", {g: share.sel(contact_group=g).values for g in groups}),
        _lines(run, "load", "N", {g: load.sel(contact_group=g).values for g in groups}),
        _lines(
            run, "load of each", "N", _by_fender(run.fender_normal_force.sel(fender=gaps.fender))
        ),
        _lines(run, "gap", "m", _by_fender(gaps)),
    ]
    return [*panels, *_clearances(run)]


def _clearances(run: xr.Dataset) -> Iterator[Panel]:
    if "gap" in run.dims:
        each = {str(name): run.clearance.sel(gap=name).values for name in run.gap.values}
        yield _lines(run, "clearance", "m", each)


def energies(run: xr.Dataset) -> list[Panel]:
    """The ledger: what is held, what was put in, what was lost, what cannot be accounted for."""
    panels = [_lines(run, "kinetic energy", "J", {"": run.energy_kinetic.values})]
    for part, label in {"stored": "stored", "work": "work done", "dissipated": "lost"}.items():
        start = f"energy_{part}_"
        series = {
            name.removeprefix(start).replace("_", " "): run[name].values
            for name in map(str, run.data_vars)
            if name.startswith(start) and run[name].any()
        }
        panels += [_lines(run, label, "J", series)] if series else []
    return [*panels, _lines(run, "residual", "J", {"": run.energy_residual.values})]


PICTURES: dict[str, Callable[[xr.Dataset], list[Panel]]] = {
    "": overview,
    "_motions": motions,
    "_forces": fender_forces,
    "_contact": contact,
    "_transfer": transfer,
    "_energies": energies,
}
"""What can be drawn of a run, by what is added to its name."""


def _title(run: xr.Dataset) -> str:
    title, status = run.attrs.get("title", ""), run.attrs.get("status", "complete")
    return title if status == "complete" else f"{title} ({status})"


def _lines(run: xr.Dataset, label: str, unit: str, series: Series) -> Panel:
    return lines(run.time.values, label, unit, series)


def _motions_together(run: xr.Dataset) -> Iterator[Panel]:
    """All translations in one panel, all rotations in another."""
    for label, unit in {"displacement": "m", "rotation": "deg"}.items():
        series = {
            dof if run.sizes["body"] == 1 else f"{body} {dof}": _position(run, body, dof)
            for dof, bodies in _moving(run).items()
            for body in bodies
            if _unit(dof) == unit
        }
        if len(series) == 1:
            yield from (_lines(run, name, unit, {"": values}) for name, values in series.items())
        elif series:
            yield _lines(run, label, unit, series)


def _moving(run: xr.Dataset) -> dict[str, list[str]]:
    """The bodies that move in each degree of freedom; all of them where nothing moves at all."""
    reach = run.position.max("time") - run.position.min("time")
    moves = reach > STILL if (reach > STILL).any() else reach >= 0.0
    return {
        str(dof): [str(body) for body in run.body.values[moves.sel(dof=dof)]]
        for dof in run.dof.values
        if moves.sel(dof=dof).any()
    }


def _position(run: xr.Dataset, body: str, dof: str) -> np.ndarray:
    values = run.position.sel(body=body, dof=dof).values
    return np.degrees(values) if dof in ROTATIONS else values


def _unit(dof: str) -> str:
    return "deg" if dof in ROTATIONS else "m"


def _elevation(run: xr.Dataset) -> Iterator[Panel]:
    if run.wave_elevation.any():
        yield _lines(run, "wave elevation", "m", {"": run.wave_elevation.values})


def _modes(run: xr.Dataset) -> Panel:
    return bands(run.time.values, _by_fender(run.fender_mode))


def _crawl(run: xr.Dataset) -> Iterator[Panel]:
    """How far the contact nodes have gone since the start; while open, where they last touched."""
    for axis, component in _components(crawl(run)):
        yield _lines(run, f"crawl {axis}", "m", component)


def _components(vectors: xr.DataArray) -> Iterator[tuple[str, Series]]:
    """The axes along which vectors of the fenders are not zero but for rounding, with the lines."""
    by_axis = {str(axis): _by_fender(vectors.sel(axis=axis)) for axis in vectors.axis.values}
    largest = max(peak(series) for series in by_axis.values())
    for axis, series in by_axis.items():
        if peak(series) > STILL * largest:
            yield axis, series


def _by_fender(values: xr.DataArray) -> Series:
    return {str(name): values.sel(fender=name).values for name in values.fender.values}
