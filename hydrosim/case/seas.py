"""From the waves of a validated case, and files of components or spectra, to wave trains."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import ValidationError

from hydrosim import scene
from hydrosim.case import schema, waves
from hydrosim.case.waves import Component
from hydrosim.files import text
from hydrosim.files.messages import validation_problems
from hydrosim.files.series import read_series
from hydrosim.scene import DirectionalTable
from hydrosim.scene.force import BuildContext
from hydrosim.scene.signal import read_record

if TYPE_CHECKING:
    import xarray as xr

# Components of a sea from a text file, a line for each.

COLUMN_UNITS = {
    "frequency": "rad/s",
    "period": "s",
    "amplitude": "m",
    "phase": "rad",
    "heading": "rad",
}
"""Of the columns, where the file says none."""
ANGLES = ("phase", "heading")
EXPECTED = "frequency [rad/s] or period [s], amplitude [m], and if wanted phase and heading [rad]"


def read_components(source: text.Source) -> tuple[Component, ...]:
    """The components in a text file with the columns frequency or period, amplitude, phase and
    heading, in the units that their names say: "frequency [Hz]". InputError says what is wrong."""
    source.head(1)
    table = text.parse(source, first="a component")
    columns = dict(_table_columns(source, table))
    return tuple(
        _wave_component(source, dict(zip(columns, map(float, row), strict=True)), line)
        for line, row in zip(table.lines, np.transpose([*columns.values()]), strict=True)
    )


def _table_columns(source: text.Source, table: text.TextTable) -> Iterator[tuple[str, np.ndarray]]:
    """Each column by its name, in SI; those of other names are refused, not passed over."""
    names = [text.name_and_unit(name)[0].strip().lower() for name in table.names]
    unknown = [name for name in names if name not in COLUMN_UNITS]
    if unknown or len({*names}) < len(names) or not names:
        column_names = ", ".join(table.names) or "no names of columns"
        source.wrong(f"found {column_names}; expected the columns {EXPECTED}, each once")
    for k, name in enumerate(names):
        unit = text.unit_of_column(table, k)
        values = table.rows[:, k]
        if name in ANGLES and unit is None and np.abs(values).max() > 2.0 * np.pi:
            source.wrong(
                f"found a {name} of {np.abs(values).max():g} and no unit: degrees or radians? Name"
                f" the column {name} [deg] or {name} [rad]"
            )
        yield name, values * _unit_scale(source, name, unit or COLUMN_UNITS[name])


def _unit_scale(source: text.Source, name: str, unit: str) -> float:
    """What a number in a unit is multiplied with to be in SI."""
    others = {"amplitude": 1.0} | ({} if name == "frequency" else {"period": 1.0})
    unit_component = _wave_component(source, {**others, name: f"1 {unit}"})
    return float(getattr(unit_component, name))


def _wave_component(
    source: text.Source, values: dict[str, Any], line: int | None = None
) -> Component:
    """A component with these values, which are checked as those in a case file are."""
    readers: dict[int | str, Any] = {}
    try:
        component: Component = Component.model_validate(values, context=readers)
    except ValidationError as error:
        problem = next(validation_problems(error, values, readers))
        source.wrong(": ".join([*map(str, problem.keys), problem.text]), line)
    return component


# Spectra over frequency and direction from netCDF, in the layout of the package wavespectra.

LAYOUT = "efth over freq [Hz] and dir [degrees]"
_TURN = 2.0 * np.pi


def read_directional(
    source: text.Source, select: Mapping[str, int], x_axis: float
) -> DirectionalTable:
    """The spectrum in a netCDF file, at the indices ``select`` of its other dimensions.

    In the file: efth [m^2/Hz/degree] over freq [Hz] and dir [degrees], the direction that waves
    come from, clockwise from north, or go to, if the attributes of dir say so. ``x_axis`` [rad] is
    the compass bearing of +x, pi / 2 if +x is east, so that waves from dir go to the heading
    x_axis - dir - pi. A circle may be closed (0 and 360). Raises InputError where the file has
    another layout, or values that are negative or not numbers.
    """
    efth = text.without_repeats(source, _read_spectra(source, select))
    bearing = np.radians(efth["dir"].values.astype(float))
    if text.is_heading(source, "dir", efth["dir"].attrs):
        bearing += np.pi
    frequency = _TURN * efth["freq"].values.astype(float)
    density = efth.transpose("freq", "dir").values.astype(float) * np.degrees(1.0) / _TURN
    if not np.all(density >= 0.0):
        source.wrong("found densities that are negative or missing; expected none; select others")
    if frequency.size < 2 or np.any(np.diff(frequency) <= 0.0) or frequency[0] < 0.0:
        source.wrong("found frequencies that do not rise; expected two or more that do")
    heading, order = _order_headings(source, x_axis - bearing - np.pi)
    return DirectionalTable(frequency, heading, density[:, order])


def _read_spectra(source: text.Source, select: Mapping[str, int]) -> xr.DataArray:
    import xarray as xr

    try:
        data = xr.load_dataset(source.file, engine="netcdf4", decode_times=False)
    except (OSError, ValueError, RuntimeError) as error:
        source.wrong(f"cannot be read as netCDF ({error}); expected {LAYOUT}")
    if "efth" not in data or not {"freq", "dir"} <= {*data["efth"].dims}:
        source.wrong(f"found the variables {', '.join(map(str, data))}; expected {LAYOUT}")
    efth = data["efth"]
    if not {"freq", "dir"} <= {*efth.coords}:
        source.wrong(f"found no values of freq or dir; expected {LAYOUT}")
    text.check_spectral_units(source, efth)
    if "rad" in (units := str(efth.attrs.get("units", ""))):
        source.wrong(f"found efth in {units}; expected m^2/Hz/degree")
    others = {str(dim): efth.sizes[dim] for dim in efth.dims if dim not in ("freq", "dir")}
    for dim, size in others.items():
        index = select.get(dim, 0 if size == 1 else size)
        if not -size <= index < size:
            source.wrong(f"found {size} of {dim}; expected one; select: {{{dim}: 0}} is the first")
        efth = efth.isel({dim: index})
    if unknown := [dim for dim in select if dim not in others]:
        source.unknown("dimension", unknown[0], list(others))
    return efth


def _order_headings(source: text.Source, heading: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Headings that rise, equally far apart, from the one after the widest gap, and their order."""
    order = np.argsort(np.mod(heading, _TURN))
    angle = np.mod(heading[order], _TURN)
    gaps = np.diff(angle, append=angle[0] + _TURN)
    first = int(np.argmax(gaps)) + 1
    order, angle = np.roll(order, -first), np.unwrap(np.roll(angle, -first))
    steps = np.diff(angle)
    if steps.size == 0 or np.ptp(steps) > 1e-6 or steps.min() <= 0.0:
        apart = ", ".join(f"{step:.4g}" for step in np.unique(np.degrees(steps).round(4))[:4])
        found_text = (
            f"directions unequally far apart ({apart} deg)" if apart else "one direction alone"
        )
        source.wrong(f"found {found_text}; expected equal steps of two or more")
    return angle, order


def wave_trains(water: schema.EnvironmentEntry, path: Path) -> tuple[scene.WaveTrain, ...]:
    """The wave trains on the ``water`` of the case file ``path``.

    Raises InputError where a file that they need cannot be read.
    """
    return tuple(_build_trains(water, path))


def _build_trains(water: schema.EnvironmentEntry, path: Path) -> Iterator[scene.WaveTrain]:
    for i, train in enumerate(water.waves):
        key = "environment.waves" if len(water.waves) == 1 else f"environment.waves.{i}"
        if not isinstance(train, waves.NoWaves):
            spectrum = _build_spectrum(train, water, BuildContext(key, path))
            yield scene.WaveTrain.build_from(train, spectrum=spectrum)


def _open_source(where: BuildContext, file: str) -> text.Source:
    """A data file, relative to the case file."""
    return text.Source(where.path.parent / file, f"{where.path}: {where.key}")


def _build_spectrum(
    train: waves.SomeWaves, water: schema.EnvironmentEntry, where: BuildContext
) -> scene.Spectrum:
    match train:
        case scene.Jonswap():
            return scene.Jonswap.build_from(train)
        case waves.PiersonMoskowitz():
            return scene.Jonswap.build_from(train, spectrum="jonswap", peak_enhancement=1.0)
        case waves.TmaSea():
            return scene.Tma.build_from(train, water_depth=water.water_depth, gravity=water.gravity)
        case waves.TorsethaugenSea():
            return scene.Torsethaugen.build_from(train, gravity=water.gravity)
        case scene.OchiHubble():
            return scene.OchiHubble.build_from(train)
        case scene.WhiteNoise():
            return scene.WhiteNoise.build_from(train)
        case scene.RegularWave():
            return scene.RegularWave.build_from(train)
        case waves.TableSea():
            return _read_spectrum_table(train, where)
        case waves.DirectionalSea():
            return read_directional(_open_source(where, train.file), train.select, train.x_axis)
        case waves.Components():
            return _given_components(train, where)
        case waves.RecordedSea():
            series = read_record(train, where.key, where.path, "m")
            highest = train.highest_frequency or np.inf
            return scene.RecordedElevation(series.time, series.value, train.position, highest)


def _read_spectrum_table(table: waves.TableSea, where: BuildContext) -> scene.SpectrumTable:
    if table.file is None:
        return scene.SpectrumTable(np.array(table.frequency), np.array(table.density))
    source = _open_source(where, table.file)
    series = read_series(source, [table.column])
    if (least := min(series.value.min(), series.time[0])) < 0.0:
        source.wrong(f"found {least:g}; expected frequencies and densities that are not negative")
    return scene.SpectrumTable(
        table.frequency_factor * series.time, table.density_factor * series.value
    )


def _given_components(train: waves.Components, where: BuildContext) -> scene.GivenComponents:
    given = train.components
    if isinstance(given, waves.ComponentsFile):
        at_key = BuildContext(f"{where.key}.components", where.path)
        components = read_components(_open_source(at_key, given.file))
    else:
        components = given
    omega = [c.frequency or 2.0 * np.pi / (c.period or np.nan) for c in components]
    heading = [train.heading if c.heading is None else c.heading for c in components]
    amplitude = [c.amplitude for c in components]
    phase = [c.phase for c in components]
    return scene.GivenComponents(*map(np.array, (omega, amplitude, phase, heading)))
