"""The waves of a case file."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, ClassVar, Literal

import pydantic

from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one, same_length
from hydrosim.files.schema_class import ByKind, SchemaClass, schema_class
from hydrosim.scene import environment
from hydrosim.scene.environment import (
    DirectedWaves,
    IrregularWaves,
    PeakedSpectrum,
    SpreadWaves,
)
from hydrosim.scene.signal import RecordedColumns


@schema_class
class JonswapSea(environment.Jonswap, SpreadWaves):
    """JONSWAP spectrum, scaled to the significant height."""


@schema_class
class PiersonMoskowitz(PeakedSpectrum, SpreadWaves):
    """JONSWAP without peak enhancement."""

    spectrum: Literal["pierson_moskowitz"] = field(kw_only=True)
    """Pierson-Moskowitz spectrum."""


@schema_class
class TmaSea(PeakedSpectrum, SpreadWaves):
    """JONSWAP limited by the environment's water depth."""

    spectrum: Literal["tma"] = field(kw_only=True)
    """TMA spectrum: JONSWAP in finite water depth."""
    peak_enhancement: of.Peak = 3.3
    """Peak enhancement factor gamma."""


@schema_class
class TorsethaugenSea(PeakedSpectrum, SpreadWaves):
    """Wind sea and swell of the North Sea."""

    spectrum: Literal["torsethaugen"] = field(kw_only=True)
    """Torsethaugen spectrum: wind sea and swell of the North Sea."""


@schema_class
class OchiHubbleSea(environment.OchiHubble, SpreadWaves):
    """Peaks of chosen sharpness: swell and wind sea."""


@schema_class
class WhiteNoiseSea(environment.WhiteNoise, SpreadWaves):
    """Constant density between two frequencies."""


@schema_class
class TableSea(SpreadWaves):
    """Densities at frequencies: lists, or the first column and another one of a text ``file``,
    each multiplied by a factor that has its unit."""

    key_rules = (
        exactly_one(
            ("frequency", "density"),
            "file",
            nothing="no table",
            expected="frequency and density, or a file",
        ),
        same_length("frequency", "density", found="{count} frequencies and {size} densities"),
    )

    spectrum: Literal["table"] = field(kw_only=True)
    """Densities at given frequencies."""
    frequency: of.Frequencies | None = None
    """Frequencies that rise."""
    density: of.WaveDensities | None = None
    """Density of wave elevation at each frequency."""
    file: pydantic.StrictStr | None = None
    """Text file whose first column is frequency, in place of the lists. Example:
    spectrum.csv."""
    column: pydantic.StrictStr | pydantic.StrictInt = 2
    """Column of the file with the densities: its name or number. Example: S."""
    frequency_factor: of.Frequency = 1.0
    """Factor of the file's frequencies, such as 1 Hz."""
    density_factor: of.WaveDensity = 1.0
    """Factor of the file's densities, such as 1 m^2/Hz."""


@schema_class
class DirectionalSea(IrregularWaves):
    """Densities over frequency and direction: a netCDF ``file`` as `wavespectra` writes it (freq in
    Hz, dir in degrees that waves come from, clockwise from north, efth in m^2/Hz/degree).

    ``select`` says which index of its other dimensions; ``x_axis`` is the compass bearing of +x.
    """

    spectrum: Literal["directional_table"] = field(kw_only=True)
    """Densities over frequency and direction."""
    file: pydantic.StrictStr
    """File (netCDF) with the density efth over freq and dir, as wavespectra writes it. Example:
    spectra.nc."""
    select: dict[pydantic.StrictStr, pydantic.StrictInt] = field(default_factory=dict)
    """Index of each other dimension of the file, such as time. Example: {time: 3}."""
    x_axis: of.Angle = field(kw_only=True)
    """Compass bearing of the x axis of the earth frame."""


@schema_class
class Regular(environment.RegularWave, DirectedWaves):
    """One regular wave."""


def _components_form(value: object) -> str:
    return "file" if isinstance(value, dict | ComponentsFile) else "list"


@schema_class
class Component(SchemaClass):
    """One of given components: it goes to the ``heading`` of them all if it has none of its own."""

    key_rules = (exactly_one("period", "frequency", nothing="neither"),)

    amplitude: of.Height
    """Amplitude, half of the wave height."""
    period: of.Period | None = None
    """Period of the component, in place of frequency."""
    frequency: of.Frequency | None = None
    """Frequency of the component, in place of period."""
    phase: of.Angle = 0.0
    """Phase of the elevation at the origin."""
    heading: of.Angle | None = None
    """Direction that the component goes to. Without it that of the whole train."""


@schema_class
class ComponentsFile(SchemaClass):
    """A text ``file`` with a line for each component, and columns named as the keys of one."""

    file: pydantic.StrictStr
    """Text file with a line for each component and columns named frequency or period,
    amplitude, phase, heading. Example: components.csv."""


@schema_class
class Components(DirectedWaves):
    """Given components, in a list or in a file; on the grid of ``repeat_period`` if all are
    multiples of it, as random seas are, else summed one by one."""

    spectrum: Literal["components"] = field(kw_only=True)
    """Given components."""
    components: Annotated[
        Annotated[ComponentsFile, pydantic.Tag("file")]
        | Annotated[
            tuple[Component, ...], pydantic.AfterValidator(of.require_entries), pydantic.Tag("list")
        ],
        pydantic.Discriminator(_components_form),
    ]
    """List of components, or a mapping with their file."""
    repeat_period: of.Period = 10800.0
    """Time that all periods divide, if the components are to be summed by FFT."""


@schema_class
class RecordedSea(RecordedColumns, DirectedWaves):
    """A measured elevation over the time of the run, at ``position``; what is above
    ``highest_frequency`` is left out."""

    spectrum: Literal["recorded"] = field(kw_only=True)
    """Measured elevation."""
    position: of.Position = (0.0, 0.0)
    """Place x, y of the measurement in the earth frame. Example: [70 m, 0 m]."""
    highest_frequency: of.Frequency | None = None
    """Frequency above which the record is left out."""


@schema_class
class NoWaves(SchemaClass):
    """No waves; the other keys may stay, so that one word turns the waves of a case off."""

    __pydantic_config__: ClassVar = pydantic.ConfigDict(extra="ignore")
    spectrum: Literal["none"] = field(kw_only=True)
    """No waves."""


SomeWaves = (
    JonswapSea
    | PiersonMoskowitz
    | TmaSea
    | TorsethaugenSea
    | OchiHubbleSea
    | WhiteNoiseSea
    | TableSea
    | DirectionalSea
    | Regular
    | Components
    | RecordedSea
)
Train = Annotated[SomeWaves | NoWaves, ByKind("spectrum")]


def _list_of_one(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


Waves = Annotated[tuple[Train, ...], of.one_or_more(Train, _list_of_one)]
"""One mapping, or a list of them."""
