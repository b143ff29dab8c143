"""What a study file may say of limits of operation, as pydantic models."""

from __future__ import annotations

from math import degrees
from typing import Annotated, Self

from pydantic import Field, StrictStr, model_validator

from hydrosim.documents import quantities as of
from hydrosim.documents.units import Quantity, problem

MAX_HEIGHTS = 1000
FULL_TURN_RAD = 6.2832  # rad


class Heights(of.SchemaModel):
    """Significant heights among which a limit is looked for: from the first to the last, so far
    ``apart``."""

    low: of.Length = Field(alias="from")
    """Lowest significant height."""
    high: of.Length = Field(alias="to")
    """Highest significant height."""
    apart: of.LineLength
    """Step between heights."""

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        if not 0.0 < self.low < self.high or self.high - self.low < self.apart:
            found_text = f"from {self.low:g} to {self.high:g} m, {self.apart:g} m apart"
            raise problem(found_text, "heights above zero that rise, two or more")
        if (self.high - self.low) / self.apart > MAX_HEIGHTS:
            count = (self.high - self.low) / self.apart
            raise problem(f"{count:,.0f} heights", f"{MAX_HEIGHTS:,} or fewer")
        return self

    def values(self) -> list[float]:
        """All heights [m]."""
        count = int((self.high - self.low) / self.apart + 1e-9) + 1
        return [self.low + k * self.apart for k in range(count)]


class SwellFile(of.SchemaModel):
    """A swell beside the wind sea: JONSWAP, with its own heading."""

    significant_height: of.Height
    """Significant height of the swell."""
    peak_period: of.Period
    """Peak period of the swell."""
    heading: of.Angle
    """Direction that the swell goes to."""


class Operation(of.SchemaModel):
    """What weather an operation needs: its ``planned`` time and the contingency, as long again if
    it is not given; factors of a table ``alpha`` by planned time and significant height."""

    planned: of.Period
    """Planned time of the operation."""
    contingency: of.Span | None = None
    """Contingency time. Without it as long as the planned time."""
    alpha: AlphaFile | None = None
    """Table of alpha factors."""


class AlphaFile(of.SchemaModel):
    """A table of alpha factors: ``source`` says which, with its edition; a row of ``factors`` for
    planned times up to each of ``planned``, a column for each of the ``heights`` of the limit."""

    source: StrictStr
    """Document and edition that the factors are from. Example: Company standard 12, 2024."""
    planned: tuple[of.Period, ...]
    """Planned times that the rows go up to."""
    heights: tuple[of.Length, ...]
    """Significant heights of the columns."""
    factors: tuple[tuple[of.Factor, ...], ...]
    """A row of factors for each planned time."""

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        sizes = {len(row) for row in self.factors}
        if sizes != {len(self.heights)} or len(self.factors) != len(self.planned):
            raise problem(
                f"{len(self.factors)} rows of {', '.join(map(str, sorted(sizes)))} factors",
                f"{len(self.planned)} rows of {len(self.heights)}, as there are times and heights",
            )
        for values in (self.planned, self.heights):
            if list(values) != sorted(set(values)):
                raise problem(f"{', '.join(f'{v:g}' for v in values)}", "values that rise")
        if (most := max(max(row) for row in self.factors)) > 1.0:
            raise problem(f"a factor of {most:g}", "factors of 1 or less")
        return self


class Operability(of.SchemaModel):
    """In which seas the criteria hold with a ``probability``: heights, peak periods, headings, and
    swells beside; the weather that there is, in files, and the ``bearing`` of the x axis, clockwise
    from north, by which a hindcast's directions become headings."""

    heights: Heights
    """Significant heights among which the limit is looked for."""
    peak_periods: Annotated[tuple[of.Period, ...], Field(min_length=1)]
    """Peak periods of the wind sea."""
    headings: tuple[of.Angle, ...] = ()
    """Directions that the wind sea goes to. Without them that of the case."""
    swells: tuple[SwellFile, ...] = ()
    """Swells beside the wind sea."""
    probability: Annotated[float, Quantity("probability", "", "90 %", above=0, at_most=0.999)] = 0.9
    """Probability with which criteria must hold."""
    scatter: StrictStr | None = None
    """File with a scatter diagram of heights and periods. Example: scatter.csv."""
    hindcast: StrictStr | None = None
    """File with a hindcast of seas over time. Example: hindcast.nc."""
    bearing: of.Angle | None = None
    """Compass bearing of the x axis, by which directions of the hindcast become headings."""
    operation: Operation | None = None
    """Time that the operation takes, for the wait for weather."""

    @model_validator(mode="after")
    def _check_periods(self) -> Self:
        turned = [degrees(heading) for heading in self.headings]
        for name, each in (("peak_periods", self.peak_periods), ("headings", turned)):
            if list(each) != sorted(set(each)):
                found_text = f"{name} {', '.join(f'{v:g}' for v in each)}"
                raise problem(f"{found_text}{' deg' * (name == 'headings')}", "values that rise")
        if self.hindcast is not None and self.operation is None:
            raise problem("a hindcast and no operation", "operation: {planned: 24 hour}")
        if self.bearing is not None and abs(self.bearing) > FULL_TURN_RAD:
            found_text = f"a bearing of {degrees(self.bearing):g} deg"
            raise problem(found_text, "one within a turn; a number without a unit is in rad")
        if self.hindcast is None and self.bearing is not None:
            raise problem("a bearing and no hindcast", "hindcast: FILE, whose directions it turns")
        return self
