"""Current and wind of a case file as pydantic models, and what they are in a scene."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from hydrosim import scene
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import same_length
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.units import problem
from hydrosim.scene import Amplitudes, WindLaw


class CurrentTable(SchemaModel):
    """Current at some depths, with straight lines between."""

    key_rules = (same_length("depth", "speed", "heading", each="depth"),)

    depth: Annotated[tuple[of.Length, ...], AfterValidator(of.require_start_at_zero), of.RISING]
    """Depths below the still water, which rise from 0. Example: [0 m, 50 m, 100 m]."""
    speed: Annotated[tuple[of.FlowSpeed, ...], AfterValidator(of.require_entries)]
    """Speed at each depth. Example: [1 m/s, 0.6 m/s, 0.3 m/s]."""
    heading: tuple[of.Angle, ...] | None = None
    """Direction that the current goes to at each depth, in place of the heading of the current.
    Example: [0 deg, 20 deg, 40 deg]."""


class CurrentPower(SchemaModel):
    """Power law of the height above the sea bed."""

    exponent: of.ProfileExponent
    """Exponent of the power law, such as 1/7 of tidal currents. Example: 0.143."""
    depth: Annotated[float, of.Quantity("depth", "m", "100 m", above=0)] | None = None
    """Depth at which the current ends. Without it, that of the water."""


def _form_of_current(value: object) -> str:
    power = isinstance(value, CurrentPower) or (isinstance(value, dict) and "exponent" in value)
    return "power law" if power else "table"


_SPEEDS: dict[str, Any] = {"anyOf": [{"required": ["speed"]}, {"required": ["profile"]}]}


class Current(SchemaModel):
    """Steady current, and where it goes to."""

    model_config = ConfigDict(json_schema_extra=_SPEEDS)
    speed: of.FlowSpeed | None = None
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
        table = self.profile if isinstance(self.profile, CurrentTable) else None
        if (table is None) == (self.speed is None):
            found_text = "no speed" if table is None else "a speed and a table of speeds"
            raise problem(found_text, "speed, or those in the table of profile")
        if table is not None and table.heading and self.heading != 0.0:
            raise problem("a heading and a table of headings", "one of them")
        return self


class WindPower(SchemaModel):
    """Power law of the height above the water."""

    exponent: of.ProfileExponent
    """Exponent of the power law over the height. Example: 0.11."""


def _form_of_wind(value: object) -> str:
    return "power law" if isinstance(value, dict | WindPower) else "name"


class GustsEntry(SchemaModel):
    """Gusts along the mean wind, drawn from a spectrum."""

    spectrum: Literal["npd", "iso", "api", "ochi_shin"]
    """Spectrum of the gusts. NPD and ISO 19901-1 are the same."""
    seed: Annotated[int, Field(strict=True, ge=0)] = 1
    """Number that the random phases are drawn with. Example: 7."""
    lowest_frequency: of.Frequency = scene.Gusts.lowest
    """Lowest frequency of the gusts. The default is 1/600 Hz."""
    highest_frequency: of.Frequency = scene.Gusts.highest
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
        low = self.lowest_frequency
        high = self.highest_frequency
        if low >= high:
            raise problem(f"a band from {low:g} to {high:g} rad/s", "lowest below highest")
        if not 1.0 <= self.averaging <= 3600.0:
            found_text = f"an averaging time of {self.averaging:g} s"
            raise problem(found_text, "1 s to 1 hour, for which there is a formula")
        return self

    def build(self) -> scene.Gusts:
        """The gusts of a scene."""
        name = "npd" if self.spectrum == "iso" else self.spectrum
        return scene.Gusts(
            spectrum=scene.GustSpectrum(name),
            seed=self.seed,
            lowest=self.lowest_frequency,
            highest=self.highest_frequency,
            averaging=self.averaging,
            ramp=self.ramp,
            repeat_period=self.repeat_period,
            amplitudes=self.amplitudes,
        )


class Wind(SchemaModel):
    """Wind, and where it goes to."""

    speed: of.FlowSpeed
    """Mean speed of the wind: of one hour if there are gusts, unless they say otherwise."""
    heading: of.Angle = 0.0
    """Direction that the wind goes to, counter-clockwise from the x axis of the earth."""
    height: Annotated[float, of.Quantity("height", "m", "10 m", at_least=1)] = 10.0
    """Height above the water at which the wind has this speed."""
    profile: Annotated[
        Annotated[Literal["npd", "none"], Tag("name")] | Annotated[WindPower, Tag("power law")],
        Discriminator(_form_of_wind),
    ] = "none"
    """Wind over the height: npd, none, or a power law. Without a profile the wind is the same at
    all heights."""
    gusts: GustsEntry | None = None
    """Gusts about the mean. Without them the wind is steady."""

    @model_validator(mode="after")
    def _check_wind(self) -> Self:
        if self.profile == "none" and self.height != 10.0:
            found_text = f"a height of {self.height:g} m and no profile"
            raise problem(found_text, "a profile, which says how the wind changes over the height")
        if self.gusts is not None and self.speed == 0.0:
            raise problem("gusts and a speed of 0", "a mean wind that they are about")
        return self

    def build_profile(self) -> scene.WindProfile | None:
        """The profile of a scene."""
        if self.profile == "none":
            return None
        if isinstance(self.profile, WindPower):
            return scene.WindProfile(WindLaw.POWER, self.height, self.profile.exponent)
        return scene.WindProfile(WindLaw.NPD, self.height)


def current_of(
    current: Current | None, water_depth: float, key: str
) -> tuple[scene.Stream, scene.CurrentProfile | None]:
    """The current of a scene, and its profile. Raises InputError if a power law has no depth."""
    if current is None:
        return scene.Stream(), None
    if isinstance(current.profile, CurrentTable):
        return _build_table(current, current.profile)
    assert current.speed is not None
    stream = scene.Stream(current.speed, current.heading)
    if current.profile is None:
        return stream, None
    from hydrosim.water.current import power_profile  # loads numba

    depth = current.profile.depth or water_depth
    return stream, power_profile(current.profile.exponent, depth, key)


def _build_table(
    current: Current, table: CurrentTable
) -> tuple[scene.Stream, scene.CurrentProfile]:
    """A stream with the largest speed of a table, and the table relative to it."""
    largest = max(table.speed)
    headings = table.heading or (current.heading,) * len(table.depth)
    factor = tuple(speed / largest if largest else 1.0 for speed in table.speed)
    turn = tuple(heading - headings[0] for heading in headings)
    stream = scene.Stream(largest, headings[0])
    return stream, scene.CurrentProfile(table.depth, factor, turn)


def with_streams(
    water: scene.Environment, current: Current | None, wind: Wind | None, key: str
) -> scene.Environment:
    """The ``water`` of a scene with its current and its wind. ``key`` is that of the environment in
    the case file."""
    stream, profile = current_of(current, water.water_depth, f"{key}.current.profile")
    environment = replace(water, current=stream, current_profile=profile)
    if wind is None:
        return environment
    return replace(
        environment,
        wind=scene.Stream(wind.speed, wind.heading),
        wind_profile=wind.build_profile(),
        gusts=None if wind.gusts is None else wind.gusts.build(),
    )
