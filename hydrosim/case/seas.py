"""From the waves of a validated case to the scene's wave trains."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hydrosim import scene
from hydrosim.case import schema, waves
from hydrosim.case.components import read_components
from hydrosim.case.directional import read_directional
from hydrosim.case.elements import BuildContext
from hydrosim.case.records import read_record
from hydrosim.documents.series import read_series
from hydrosim.documents.text import Source

COPIED_TRAIN_FIELDS = ("heading", "seed", "ramp", "repeat_period", "amplitudes", "spreading")


def wave_trains(water: schema.Environment, path: Path) -> tuple[scene.WaveTrain, ...]:
    """The wave trains on the ``water`` of the case file ``path``.

    Raises InputError where a file that they need cannot be read.
    """
    return tuple(_trains(water, path))


def _trains(water: schema.Environment, path: Path) -> Iterator[scene.WaveTrain]:
    for i, train in enumerate(water.waves):
        key = "environment.waves" if len(water.waves) == 1 else f"environment.waves.{i}"
        if not isinstance(train, waves.NoWaves):
            given = {
                name: value for name, value in dict(train).items() if name in COPIED_TRAIN_FIELDS
            }
            yield scene.WaveTrain(_spectrum(train, water, BuildContext(key, path)), **given)


def _source(where: BuildContext, file: str) -> Source:
    """A data file, relative to the case file."""
    return Source(where.path.parent / file, f"{where.path}: {where.key}")


def _spectrum(
    train: waves.SomeWaves, water: schema.Environment, where: BuildContext
) -> scene.Spectrum:
    match train:
        case waves.Jonswap():
            peak = train.significant_height, train.peak_period
            return scene.Jonswap(*peak, train.peak_enhancement)
        case waves.PiersonMoskowitz():
            return scene.Jonswap(train.significant_height, train.peak_period, 1.0)
        case waves.Tma():
            peak = train.significant_height, train.peak_period
            return scene.Tma(*peak, water.water_depth, train.peak_enhancement, water.gravity)
        case waves.Torsethaugen():
            return scene.Torsethaugen(train.significant_height, train.peak_period, water.gravity)
        case waves.OchiHubble():
            return scene.OchiHubble(tuple(scene.OchiHubblePeak(**dict(p)) for p in train.peaks))
        case waves.WhiteNoise():
            band = train.lowest_frequency, train.highest_frequency
            return scene.WhiteNoise(train.significant_height, *band)
        case waves.Table():
            return _table(train, where)
        case waves.DirectionalTable():
            return read_directional(_source(where, train.file), train.select, train.x_axis)
        case waves.Regular():
            return scene.RegularWave(train.amplitude, train.period, train.phase)
        case waves.Components():
            return _given_components(train, where)
        case waves.RecordedElevation():
            series = read_record(train, where.key, where.path, "m")
            highest = train.highest_frequency or np.inf
            return scene.RecordedElevation(series.time, series.value, train.position, highest)


def _table(table: waves.Table, where: BuildContext) -> scene.SpectrumTable:
    if table.file is None:
        return scene.SpectrumTable(np.array(table.frequency), np.array(table.density))
    source = _source(where, table.file)
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
        each = read_components(_source(at_key, given.file))
    else:
        each = given
    omega = [c.frequency or 2.0 * np.pi / (c.period or np.nan) for c in each]
    heading = [train.heading if c.heading is None else c.heading for c in each]
    amplitude = [c.amplitude for c in each]
    phase = [c.phase for c in each]
    return scene.GivenComponents(*map(np.array, (omega, amplitude, phase, heading)))
