"""Models for the memory of radiated waves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

LENGTH = 100.0
"""Length of the memory [s] if none is given."""


class RadiationModel(StrEnum):
    """Models for the memory of the radiated waves, each with its defaults."""

    AUTOMATIC = "automatic"
    STATE_SPACE = "state_space"
    CONVOLUTION = "convolution"
    NONE = "none"


@dataclass(frozen=True)
class AutomaticRadiation:
    """State-space models where they suffice, convolution elsewhere.

    Each group of coupled motions gets extra states if its passive fit is within the relative
    ``tolerance``, and otherwise the memory integral. A run that starts from another run keeps that
    run's choice.

    The functions are tabulated every ``step`` [s] to ``length`` [s], or to `LENGTH` if none is
    given, but not longer than the frequencies of the database resolve.
    """

    tolerance: float = 3e-4
    length: float | None = None
    step: float = 0.1


@dataclass(frozen=True)
class StateSpaceRadiation:
    """Extra states: a rational fit of the retardation functions within a relative ``tolerance``.
    Groups whose nearest passive fit has more than ten times this error use the memory integral.

    The functions are tabulated every ``step`` [s] to ``length`` [s], or to `LENGTH` if none is
    given, but not longer than the frequencies of the database resolve.
    """

    tolerance: float = 3e-4
    length: float | None = None
    step: float = 0.1


@dataclass(frozen=True)
class ConvolutionRadiation:
    """The memory integral over ``length`` [s], or `LENGTH` if none is given, but not longer than
    the frequencies of the database resolve. ``step`` [s] is the step of the table, not of the
    run."""

    length: float | None = None
    step: float = 0.1


@dataclass(frozen=True)
class ConstantRadiation:
    """No memory: added mass and damping of one ``period`` [s]."""

    period: float


Radiation = AutomaticRadiation | StateSpaceRadiation | ConvolutionRadiation | ConstantRadiation


BY_NAME: Mapping[RadiationModel, Radiation | None] = {
    RadiationModel.AUTOMATIC: AutomaticRadiation(),
    RadiationModel.STATE_SPACE: StateSpaceRadiation(),
    RadiationModel.CONVOLUTION: ConvolutionRadiation(),
    RadiationModel.NONE: None,
}
