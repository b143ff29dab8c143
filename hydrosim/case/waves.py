"""The waves of a case file as pydantic models."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import pydantic

from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one, same_length
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import ByKind
from hydrosim.files.units import problem
from hydrosim.scene import Amplitudes, OchiHubblePeak
from hydrosim.scene.signal import RecordedColumns


class Growing(SchemaModel):
    """What all waves have: the time that they take to grow."""

    ramp: of.Span = 0.0
    """Time over which the waves grow from zero."""


class Directed(Growing):
    """What all waves of one mean direction have: where they go to."""

    heading: of.Angle = 0.0
    """Direction that the waves go to, counter-clockwise from the x axis of the earth."""


class Irregular(Growing):
    """What all random seas have: a ``seed``, the time after which they repeat themselves, and how
    their amplitudes are drawn."""

    seed: Annotated[int, pydantic.Field(strict=True, ge=0)] = 1
    """Number that the random phases are drawn with. Example: 7."""
    repeat_period: of.Period = 10800.0
    """Time after which the sea repeats. A run must not be longer."""
    amplitudes: Amplitudes = Amplitudes.DETERMINISTIC
    """Whether the amplitudes of components follow from the spectrum, or are Rayleigh distributed
    about it."""


class Spread(Irregular, Directed):
    """What random seas of one mean direction have: ``spreading`` is the exponent s of directions
    distributed as cos^2s of half the angle to the heading, one for each frequency."""

    spreading: of.Sharpness | None = None
    """Exponent s of directions that are distributed as cos^2s of half the angle to the heading.
    Without it the sea is long-crested."""


class Peaked(Spread):
    """What random seas of one height and one peak have."""

    significant_height: of.Height
    """Significant wave height Hs."""
    peak_period: of.Period
    """Period Tp of the peak of the spectrum."""


class JonswapSea(Peaked):
    """JONSWAP spectrum, scaled to the significant height."""

    spectrum: Literal["jonswap"]
    """JONSWAP spectrum."""
    peak_enhancement: of.Peak = 3.3
    """Peak enhancement factor gamma."""


class PiersonMoskowitz(Peaked):
    """JONSWAP without peak enhancement."""

    spectrum: Literal["pierson_moskowitz"]
    """Pierson-Moskowitz spectrum."""


class TmaSea(Peaked):
    """JONSWAP limited by the environment's water depth."""

    spectrum: Literal["tma"]
    """TMA spectrum: JONSWAP in finite water depth."""
    peak_enhancement: of.Peak = 3.3
    """Peak enhancement factor gamma."""


class TorsethaugenSea(Peaked):
    """Wind sea and swell of the North Sea."""

    spectrum: Literal["torsethaugen"]
    """Torsethaugen spectrum: wind sea and swell of the North Sea."""


class OchiHubbleSea(Spread):
    """Peaks of chosen sharpness: swell and wind sea."""

    spectrum: Literal["ochi_hubble"]
    """Ochi-Hubble spectrum."""
    peaks: Annotated[tuple[OchiHubblePeak, ...], pydantic.AfterValidator(of.require_entries)]
    """Peaks of the spectrum, such as swell and wind sea."""


class WhiteNoiseSea(Spread):
    """Constant density between two frequencies."""

    spectrum: Literal["white_noise"]
    """Constant density between two frequencies."""
    significant_height: of.Height
    """Significant wave height Hs."""
    lowest_frequency: of.Frequency
    """Lowest frequency with waves."""
    highest_frequency: of.Frequency
    """Highest frequency with waves."""

    @pydantic.model_validator(mode="after")
    def _check_band(self) -> Self:
        low = self.lowest_frequency
        high = self.highest_frequency
        if low >= high:
            raise problem(f"a band from {low:g} to {high:g} rad/s", "lowest below highest")
        return self


class TableSea(Spread):
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

    spectrum: Literal["table"]
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


class DirectionalSea(Irregular):
    """Densities over frequency and direction: a netCDF ``file`` as `wavespectra` writes it (freq in
    Hz, dir in degrees that waves come from, clockwise from north, efth in m^2/Hz/degree).

    ``select`` says which index of its other dimensions; ``x_axis`` is the compass bearing of +x.
    """

    spectrum: Literal["directional_table"]
    """Densities over frequency and direction."""
    file: pydantic.StrictStr
    """File (netCDF) with the density efth over freq and dir, as wavespectra writes it. Example:
    spectra.nc."""
    select: dict[pydantic.StrictStr, pydantic.StrictInt] = pydantic.Field(default_factory=dict)
    """Index of each other dimension of the file, such as time. Example: {time: 3}."""
    x_axis: of.Angle
    """Compass bearing of the x axis of the earth frame."""


class Regular(Directed):
    """One regular wave."""

    spectrum: Literal["regular"]
    """One regular wave."""
    amplitude: of.Height
    """Amplitude, half of the wave height."""
    period: of.Period
    """Wave period."""
    phase: of.Angle = 0.0
    """Phase of the elevation at the origin."""


def _components_form(value: object) -> str:
    return "file" if isinstance(value, dict | pydantic.BaseModel) else "list"


class Component(SchemaModel):
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


class ComponentsFile(SchemaModel):
    """A text ``file`` with a line for each component, and columns named as the keys of one."""

    file: pydantic.StrictStr
    """Text file with a line for each component and columns named frequency or period,
    amplitude, phase, heading. Example: components.csv."""


class Components(Directed):
    """Given components, in a list or in a file; on the grid of ``repeat_period`` if all are
    multiples of it, as random seas are, else summed one by one."""

    spectrum: Literal["components"]
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


class RecordedSea(RecordedColumns, Directed):
    """A measured elevation over the time of the run, at ``position``; what is above
    ``highest_frequency`` is left out."""

    spectrum: Literal["recorded"]
    """Measured elevation."""
    position: of.Position = (0.0, 0.0)
    """Place x, y of the measurement in the earth frame. Example: [70 m, 0 m]."""
    highest_frequency: of.Frequency | None = None
    """Frequency above which the record is left out."""


class NoWaves(SchemaModel):
    """No waves; the other keys may stay, so that one word turns the waves of a case off."""

    model_config = pydantic.ConfigDict(extra="ignore")
    spectrum: Literal["none"]
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
