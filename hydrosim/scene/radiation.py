"""How the memory of radiated waves is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

LENGTH = 100.0
"""Of a memory where no length is given [s]."""


class RadiationModel(StrEnum):
    """How the memory of the radiated waves is computed, with the defaults of each way."""

    AUTOMATIC = "automatic"
    STATE_SPACE = "state_space"
    CONVOLUTION = "convolution"
    NONE = "none"


@dataclass(frozen=True)
class AutomaticRadiation:
    """Extra states for each group of coupled motions whose passive fit holds the ``tolerance``, and
    the memory integral itself for the others; a run that starts from another takes what that has.

    The functions are tabulated to ``length`` [s], or `LENGTH` if there is none, but no longer than
    the frequencies of the database resolve; every ``step`` [s].
    """

    tolerance: float = 3e-4
    length: float | None = None
    step: float = 0.1


@dataclass(frozen=True)
class StateSpaceRadiation:
    """Extra states: a rational fit of the retardation functions within a relative ``tolerance``;
    the memory integral itself for groups whose nearest passive fit is ten times as far off.

    The functions are tabulated to ``length`` [s], or `LENGTH` if there is none, but no longer than
    the frequencies of the database resolve; every ``step`` [s].
    """

    tolerance: float = 3e-4
    length: float | None = None
    step: float = 0.1


@dataclass(frozen=True)
class ConvolutionRadiation:
    """The memory integral itself over ``length`` [s], or `LENGTH` if there is none, but no longer
    than the frequencies of the database resolve; the table's ``step`` [s] is not the run's."""

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
