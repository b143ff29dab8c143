"""Environment of a scene: spectra and seas, current, wind, gusts and water."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    model_validator,
)

from hydrosim.files import quantities as of
from hydrosim.files.key_rules import same_length
from hydrosim.files.schema_class import PythonObject, ReadAs, SchemaClass, schema_class
from hydrosim.files.units import Quantity, problem

WaterDepth = Annotated[float, ReadAs(of.Depth, lambda value: value == np.inf)]
"""In Python it may be the number infinity."""

# Seas: spectra, regular waves, components and recorded elevations.


@schema_class
class PeakedSpectrum(SchemaClass):
    """What spectra of one height and one peak have."""

    significant_height: of.Height
    """Significant wave height Hs."""
    peak_period: of.Period
    """Period Tp of the peak of the spectrum."""


@schema_class
class Jonswap(PeakedSpectrum):
    """JONSWAP spectrum (Hasselmann et al. 1973), scaled to the significant height."""

    spectrum: Literal["jonswap"] = field(default="jonswap", kw_only=True)
    """JONSWAP spectrum."""
    peak_enhancement: of.Peak = 3.3
    """Peak enhancement factor gamma."""


@schema_class
class Tma(PeakedSpectrum):
    """JONSWAP spectrum limited by a ``water_depth`` [m] (Bouws et al. 1985), scaled to the
    significant height; ``gravity`` [m/s^2]."""

    water_depth: WaterDepth
    peak_enhancement: of.Peak = 3.3
    """Peak enhancement factor gamma."""
    gravity: of.Gravity = 9.81


@schema_class
class OchiHubblePeak(SchemaClass):
    """One peak; ``shape`` is lambda."""

    significant_height: of.Height
    """Significant height of this peak alone."""
    peak_period: of.Period
    """Period of this peak."""
    shape: of.Sharpness = 1.0
    """Sharpness lambda of this peak."""


@schema_class
class OchiHubble(SchemaClass):
    """Peaks of chosen sharpness: swell and wind sea (Ochi and Hubble 1976, with two of them)."""

    spectrum: Literal["ochi_hubble"] = field(default="ochi_hubble", kw_only=True)
    """Ochi-Hubble spectrum."""
    peaks: Annotated[tuple[OchiHubblePeak, ...], AfterValidator(of.require_entries)]
    """Peaks of the spectrum, such as swell and wind sea."""


@schema_class
class Torsethaugen(PeakedSpectrum):
    """Wind sea and swell (Torsethaugen and Haver 2004, the simplified form), for the North Sea;
    ``gravity`` [m/s^2]."""

    gravity: of.Gravity = 9.81


def check_band(low: float, high: float) -> None:
    """Raises a problem for a band of frequencies [rad/s] whose lowest is not below the highest."""
    if low >= high:
        raise problem(f"a band from {low:g} to {high:g} rad/s", "lowest below highest")


@schema_class
class WhiteNoise(SchemaClass):
    """Constant density between two frequencies."""

    spectrum: Literal["white_noise"] = field(default="white_noise", kw_only=True)
    """Constant density between two frequencies."""
    significant_height: of.Height
    """Significant wave height Hs."""
    lowest_frequency: of.Frequency
    """Lowest frequency with waves."""
    highest_frequency: of.Frequency
    """Highest frequency with waves."""

    @model_validator(mode="after")
    def _check_band(self) -> Self:
        check_band(self.lowest_frequency, self.highest_frequency)
        return self


@dataclass(frozen=True, eq=False)
class SpectrumTable:
    """``density`` (nf,) [m^2 s/rad] at rising ``frequency`` (nf,) [rad/s], linear between them and
    zero outside."""

    frequency: np.ndarray
    density: np.ndarray


@dataclass(frozen=True, eq=False)
class DirectionalTable:
    """``density`` (nf, nh) [m^2 s/rad^2] at rising ``frequency`` (nf,) [rad/s] and rising, equally
    spaced ``heading`` (nh,) [rad], the direction of propagation. It is linear between frequencies,
    and constant over the sector around each heading."""

    frequency: np.ndarray
    heading: np.ndarray
    density: np.ndarray


@schema_class
class RegularWave(SchemaClass):
    """One Airy wave: amplitude * cos(2 pi t / period + phase) at the earth's origin."""

    spectrum: Literal["regular"] = field(default="regular", kw_only=True)
    """One regular wave."""
    amplitude: of.Height
    """Amplitude, half of the wave height."""
    period: of.Period
    """Wave period."""
    phase: of.Angle = 0.0
    """Phase of the elevation at the origin."""


@dataclass(frozen=True, eq=False)
class GivenComponents:
    """Airy waves amplitude * cos(omega t + phase) at the earth's origin: ``omega`` [rad/s],
    ``amplitude`` [m], ``phase`` [rad] and ``heading`` [rad] are (n,) each."""

    omega: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    heading: np.ndarray


@dataclass(frozen=True, eq=False)
class RecordedElevation:
    """``elevation`` (n,) [m] at equally spaced ``time`` (n,) [s] of the run, measured at
    ``position`` x, y [m]. Its mean and its content above ``highest_frequency`` [rad/s] are
    removed."""

    time: np.ndarray
    elevation: np.ndarray
    position: tuple[float, float] = (0.0, 0.0)
    highest_frequency: float = np.inf


Density = Jonswap | Tma | OchiHubble | Torsethaugen | WhiteNoise | SpectrumTable | DirectionalTable
"""Spectra from which a random sea is drawn."""


Spectrum = Density | RegularWave | GivenComponents | RecordedElevation


class Amplitudes(StrEnum):
    """Amplitudes of the components of a random sea: sqrt(2 S dw), or Rayleigh distributed about
    that, which makes the sea Gaussian."""

    DETERMINISTIC = "deterministic"
    RAYLEIGH = "rayleigh"


@schema_class
class GrowingWaves(SchemaClass):
    """What all waves have: the time that they take to grow."""

    ramp: of.Span = field(default=0.0, kw_only=True)
    """Time over which the waves grow from zero."""


@schema_class
class DirectedWaves(GrowingWaves):
    """What all waves of one mean direction have: where they go to."""

    heading: of.Angle = field(default=0.0, kw_only=True)
    """Direction that the waves go to, counter-clockwise from the x axis of the earth."""


@schema_class
class IrregularWaves(GrowingWaves):
    """What all random seas have. The components of a sea are 2 pi / ``repeat_period`` apart, so
    that it does not depend on the duration."""

    seed: Annotated[int, Field(strict=True, ge=0)] = field(default=1, kw_only=True)
    """Number that the random phases are drawn with. Example: 7."""
    repeat_period: of.Period = field(default=10800.0, kw_only=True)
    """Time after which the sea repeats. A run must not be longer."""
    amplitudes: Amplitudes = field(default=Amplitudes.DETERMINISTIC, kw_only=True)
    """Whether the amplitudes of components follow from the spectrum, or are Rayleigh distributed
    about it."""


@schema_class
class SpreadWaves(IrregularWaves, DirectedWaves):
    """What random seas of one mean direction have: ``spreading`` is the exponent s of directions
    distributed as cos^2s of half the angle to the heading, one for each frequency."""

    spreading: of.Sharpness | None = field(default=None, kw_only=True)
    """Exponent s of directions that are distributed as cos^2s of half the angle to the heading.
    Without it the sea is long-crested."""


@schema_class
class WaveTrain(SpreadWaves):
    """Waves of one spectrum and one mean direction. `GivenComponents` and `DirectionalTable` have
    headings of their own."""

    positional: ClassVar[tuple[str, ...]] = (
        *("spectrum", "heading", "seed", "ramp", "repeat_period", "amplitudes", "spreading"),
    )

    spectrum: Annotated[Spectrum, PythonObject(Spectrum)] = field(kw_only=True)


# Current and wind.


@schema_class
class Stream(SchemaClass):
    """Current or wind, which is steady and uniform."""

    has_valid_defaults: ClassVar[bool] = True

    speed: of.FlowSpeed = 0.0
    """Speed of the stream."""
    heading: of.Angle = 0.0
    """Direction that the stream goes to, counter-clockwise from the x axis of the earth."""

    @property
    def top_speed(self) -> float:
        """Its largest speed [m/s]."""
        return self.speed

    @property
    def direction(self) -> float:
        """Where it goes to at the surface [rad]."""
        return self.heading


@schema_class
class CurrentTable(SchemaClass):
    """Current at some depths. The components of its velocity are linear between them, and constant
    below the last."""

    key_rules = (same_length("depth", "speed", "heading", each="depth"),)

    depth: Annotated[tuple[of.Length, ...], AfterValidator(of.require_start_at_zero), of.RISING]
    """Depths below the still water, which rise from 0. Example: [0 m, 50 m, 100 m]."""
    speed: Annotated[tuple[of.FlowSpeed, ...], AfterValidator(of.require_entries)]
    """Speed at each depth. Example: [1 m/s, 0.6 m/s, 0.3 m/s]."""
    heading: tuple[of.Angle, ...] | None = None
    """Direction that the current goes to at each depth, in place of the heading of the current.
    Example: [0 deg, 20 deg, 40 deg]."""


@schema_class
class CurrentPower(SchemaClass):
    """Power law of the height above the sea bed."""

    exponent: of.ProfileExponent
    """Exponent of the power law, such as 1/7 of tidal currents. Example: 0.143."""
    depth: Annotated[float, Quantity("depth", "m", "100 m", above=0)] | None = None
    """Depth at which the current ends. Without it, that of the water."""


def _form_of_current(value: object) -> str:
    power = isinstance(value, CurrentPower) or (isinstance(value, dict) and "exponent" in value)
    return "power law" if power else "table"


@schema_class
class Current(Stream):
    """Steady current, and where it goes to."""

    __pydantic_config__: ClassVar = ConfigDict(
        json_schema_extra={"anyOf": [{"required": ["speed"]}, {"required": ["profile"]}]}
    )
    has_valid_defaults: ClassVar[bool] = False
    speed: of.FlowSpeed | None = None  # type: ignore[assignment]
    """Speed of the current; with a power law that at the surface."""
    heading: of.Angle = 0.0
    """Direction that the current goes to, counter-clockwise from the x axis of the earth."""
    profile: (
        Annotated[
            Annotated[CurrentTable, Tag("table")] | Annotated[CurrentPower, Tag("power law")],
            Discriminator(_form_of_current),
        ]
        | None
    ) = None
    """Current over the depth: a table or a power law. Without it the current is uniform."""

    @model_validator(mode="after")
    def _check_profile(self) -> Self:
        if (self.table is None) == (self.speed is None):
            found_text = "no speed" if self.table is None else "a speed and a table of speeds"
            raise problem(found_text, "speed, or those in the table of profile")
        if self.table is not None and self.table.heading and self.heading != 0.0:
            raise problem("a heading and a table of headings", "one of them")
        return self

    @property
    def table(self) -> CurrentTable | None:
        """Its table over the depth, if it has one."""
        return self.profile if isinstance(self.profile, CurrentTable) else None

    @property
    def top_speed(self) -> float:
        return max(self.table.speed) if self.table else self.speed or 0.0

    @property
    def direction(self) -> float:
        return self.table.heading[0] if self.table and self.table.heading else self.heading


@schema_class
class WindPower(SchemaClass):
    """Power law of the height above the water."""

    exponent: of.ProfileExponent
    """Exponent of the power law over the height. Example: 0.11."""


def _form_of_wind(value: object) -> str:
    return "power law" if isinstance(value, dict | WindPower) else "name"


class GustSpectrum(StrEnum):
    """Spectrum of gusts, see `hydrosim.water.wind`."""

    NPD = "npd"
    API = "api"
    OCHI_SHIN = "ochi_shin"


GustName = Literal["npd", "iso", "api", "ochi_shin"]


def _gust_spectrum(name: str) -> GustSpectrum:
    return GustSpectrum("npd" if name == "iso" else name)


@schema_class
class Gusts(SchemaClass):
    """Gusts along the mean wind, drawn from a spectrum. Their phases are independent of those of
    waves with the same seed."""

    spectrum: Annotated[GustSpectrum, ReadAs(GustName, GustSpectrum, _gust_spectrum)]
    """Spectrum of the gusts. NPD and ISO 19901-1 are the same."""
    seed: Annotated[int, Field(strict=True, ge=0)] = 1
    """Number that the random phases are drawn with. Example: 7."""
    lowest_frequency: of.Frequency = 2.0 * np.pi / 600.0
    """Lowest frequency of the gusts. The default is 1/600 Hz."""
    highest_frequency: of.Frequency = np.pi
    """Highest frequency of the gusts. The default is 0.5 Hz."""
    averaging: of.Period = 3600.0
    """Time over which the speed of the wind is a mean: one hour or less. Example: 10 min."""
    ramp: of.Span = 0.0
    """Time over which the gusts grow from zero."""
    repeat_period: of.Period = 10800.0
    """Time after which the gusts repeat. A run must not be longer."""
    amplitudes: Amplitudes = Amplitudes.DETERMINISTIC
    """Whether the amplitudes of components follow from the spectrum, or are Rayleigh distributed
    about it."""

    @model_validator(mode="after")
    def _check_values(self) -> Self:
        check_band(self.lowest_frequency, self.highest_frequency)
        if not 1.0 <= self.averaging <= 3600.0:
            found_text = f"an averaging time of {self.averaging:g} s"
            raise problem(found_text, "1 s to 1 hour, for which there is a formula")
        return self


@schema_class
class Wind(Stream):
    """Wind, and where it goes to."""

    has_valid_defaults: ClassVar[bool] = False

    speed: of.FlowSpeed = field()
    """Mean speed of the wind: of one hour if there are gusts, unless they say otherwise."""
    heading: of.Angle = 0.0
    """Direction that the wind goes to, counter-clockwise from the x axis of the earth."""
    height: Annotated[float, Quantity("height", "m", "10 m", at_least=1)] = 10.0
    """Height above the water at which the wind has this speed."""
    profile: Annotated[
        Annotated[Literal["npd", "none"], Tag("name")] | Annotated[WindPower, Tag("power law")],
        Discriminator(_form_of_wind),
    ] = "none"
    """Wind over the height: npd, none, or a power law. Without a profile the wind is the same at
    all heights."""
    gusts: Gusts | None = None
    """Gusts about the mean. Without them the wind is steady."""

    @model_validator(mode="after")
    def _check_wind(self) -> Self:
        if self.profile == "none" and self.height != 10.0:
            found_text = f"a height of {self.height:g} m and no profile"
            raise problem(found_text, "a profile, which says how the wind changes over the height")
        if self.gusts is not None and self.speed == 0.0:
            raise problem("gusts and a speed of 0", "a mean wind that they are about")
        return self


@schema_class
class WaterProperties(SchemaClass):
    """The water of a scene."""

    has_valid_defaults: ClassVar[bool] = True

    water_depth: of.Depth = np.inf
    """Depth of the water, or infinite."""
    water_density: of.Density = 1025.0
    """Density of the water."""
    gravity: of.Gravity = 9.81
    """Acceleration of gravity."""


def _take_stream(cls: type[Stream]) -> BeforeValidator:
    """Annotation: a plain `Stream` is one of ``cls`` too."""
    return BeforeValidator(lambda x: cls.build_from(x) if type(x) is Stream else x)


@schema_class
class Environment(WaterProperties):
    """Water and the waves on it. ``current`` and ``wind`` act through force elements alone and do
    not change the waves. In Python there may be no gravity."""

    water_depth: WaterDepth = np.inf
    gravity: of.GravityOrNone = 9.81
    waves: tuple[Annotated[WaveTrain, PythonObject(WaveTrain)], ...] = ()
    current: Annotated[Current, _take_stream(Current)] = Current.build_from(Stream())
    wind: Annotated[Wind, _take_stream(Wind)] = Wind.build_from(Stream())

    @property
    def gusts(self) -> Gusts | None:
        """The gusts of the wind."""
        return self.wind.gusts

    @property
    def seeds(self) -> list[int]:
        """The seeds of all wave trains, and of the gusts if there are any."""
        gust_seeds = [] if self.gusts is None else [self.gusts.seed]
        return [*(train.seed for train in self.waves), *gust_seeds]

    def with_seed(self, seed: int) -> Environment:
        """The same waves and gusts, drawn from another seed. They stay independent of each
        other."""
        waves = tuple(replace(train, seed=seed) for train in self.waves)
        gusts = None if self.gusts is None else replace(self.gusts, seed=seed)
        return replace(self, waves=waves, wind=Wind.build_from(self.wind, gusts=gusts))

    def without_waves(self) -> Environment:
        """The same in calm water; two environments that differ in waves and seeds alone are then
        equal."""
        return replace(self.with_seed(0), waves=())
