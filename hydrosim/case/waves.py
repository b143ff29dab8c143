"""The waves of a case file as pydantic models."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    StrictInt,
    StrictStr,
    Tag,
    model_validator,
)

from hydrosim.case.signals import Recorded
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import Strict
from hydrosim.documents.units import problem
from hydrosim.scene import Amplitudes


class Growing(Strict):
    """What all waves have: the time that they take to grow."""

    ramp: of.Span = 0.0


class Directed(Growing):
    """What all waves of one mean direction have: where they go to."""

    heading: of.Angle = 0.0


class Irregular(Growing):
    """What all random seas have: a ``seed``, the time after which they repeat themselves, and how
    their amplitudes are drawn."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 1
    repeat_period: of.Period = 10800.0
    amplitudes: Amplitudes = Amplitudes.DETERMINISTIC


class Spread(Irregular, Directed):
    """What random seas of one mean direction have: ``spreading`` is the exponent s of directions
    distributed as cos^2s of half the angle to the heading, one for each frequency."""

    spreading: of.Sharpness | None = None


class Peaked(Spread):
    """What random seas of one height and one peak have."""

    significant_height: of.Height
    peak_period: of.Period


class Jonswap(Peaked):
    """JONSWAP spectrum, scaled to the significant height."""

    spectrum: Literal["jonswap"]
    peak_enhancement: of.Peak = 3.3


class PiersonMoskowitz(Peaked):
    """JONSWAP without peak enhancement."""

    spectrum: Literal["pierson_moskowitz"]


class Tma(Peaked):
    """JONSWAP limited by the environment's water depth."""

    spectrum: Literal["tma"]
    peak_enhancement: of.Peak = 3.3


class Torsethaugen(Peaked):
    """Wind sea and swell of the North Sea."""

    spectrum: Literal["torsethaugen"]


class OchiHubblePeak(Strict):
    """One peak; ``shape`` is lambda."""

    significant_height: of.Height
    peak_period: of.Period
    shape: of.Sharpness = 1.0


class OchiHubble(Spread):
    """Peaks of chosen sharpness: swell and wind sea."""

    spectrum: Literal["ochi_hubble"]
    peaks: Annotated[tuple[OchiHubblePeak, ...], AfterValidator(of.some)]


class WhiteNoise(Spread):
    """Constant density between two frequencies."""

    spectrum: Literal["white_noise"]
    significant_height: of.Height
    lowest_frequency: of.Frequency
    highest_frequency: of.Frequency

    @model_validator(mode="after")
    def _check_band(self) -> Self:
        low = self.lowest_frequency
        high = self.highest_frequency
        if low >= high:
            raise problem(f"a band from {low:g} to {high:g} rad/s", "lowest below highest")
        return self


class Table(Spread):
    """Densities at frequencies: lists, or the first column and another one of a text ``file``,
    each multiplied by a factor that has its unit."""

    spectrum: Literal["table"]
    frequency: of.Frequencies | None = None
    density: of.WaveDensities | None = None
    file: StrictStr | None = None
    column: StrictStr | StrictInt = 2
    frequency_factor: of.Frequency = 1.0
    density_factor: of.WaveDensity = 1.0

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        given = self.given("frequency", "density", "file")
        if given not in (["frequency", "density"], ["file"]):
            raise problem(" and ".join(given) or "no table", "frequency and density, or a file")
        if self.frequency and self.density and len(self.frequency) != len(self.density):
            found = f"{len(self.frequency)} frequencies and {len(self.density)} densities"
            raise problem(found, "a density for each frequency")
        return self


class DirectionalTable(Irregular):
    """Densities over frequency and direction: a netCDF ``file`` as `wavespectra` writes it (freq in
    Hz, dir in degrees that waves come from, clockwise from north, efth in m^2/Hz/degree).

    ``select`` says which index of its other dimensions; ``x_axis`` is the compass bearing of +x.
    """

    spectrum: Literal["directional_table"]
    file: StrictStr
    select: dict[StrictStr, StrictInt] = Field(default_factory=dict)
    x_axis: of.Angle


class Regular(Directed):
    """One regular wave."""

    spectrum: Literal["regular"]
    amplitude: of.Height
    period: of.Period
    phase: of.Angle = 0.0


def _components(value: object) -> str:
    return "file" if isinstance(value, dict | BaseModel) else "list"


class Component(Strict):
    """One of given components: it goes to the ``heading`` of them all if it has none of its own."""

    amplitude: of.Height
    period: of.Period | None = None
    frequency: of.Frequency | None = None
    phase: of.Angle = 0.0
    heading: of.Angle | None = None

    @model_validator(mode="after")
    def _check_frequency(self) -> Self:
        given = self.given("period", "frequency")
        if len(given) != 1:
            raise problem(" and ".join(given) or "neither", "either period or frequency")
        return self


class ComponentsFile(Strict):
    """A text ``file`` with a line for each component, and columns named as the keys of one."""

    file: StrictStr


class Components(Directed):
    """Given components, in a list or in a file; on the grid of ``repeat_period`` if all are
    multiples of it, as random seas are, else summed one by one."""

    spectrum: Literal["components"]
    components: Annotated[
        Annotated[ComponentsFile, Tag("file")]
        | Annotated[tuple[Component, ...], AfterValidator(of.some), Tag("list")],
        Discriminator(_components),
    ]
    repeat_period: of.Period = 10800.0


class RecordedElevation(Recorded, Directed):
    """A measured elevation over the time of the run, at ``position``; what is above
    ``highest_frequency`` is left out."""

    spectrum: Literal["recorded"]
    position: of.Position = (0.0, 0.0)
    highest_frequency: of.Frequency | None = None


class NoWaves(Strict):
    """No waves; the other keys may stay, so that one word turns the waves of a case off."""

    model_config = ConfigDict(extra="ignore")
    spectrum: Literal["none"]


SomeWaves = (
    Jonswap
    | PiersonMoskowitz
    | Tma
    | Torsethaugen
    | OchiHubble
    | WhiteNoise
    | Table
    | DirectionalTable
    | Regular
    | Components
    | RecordedElevation
)
Train = Annotated[SomeWaves | NoWaves, Discriminator("spectrum")]


def _listed(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


Waves = Annotated[tuple[Train, ...], of.one_or_more(Train, _listed)]
"""One mapping, or a list of them."""
