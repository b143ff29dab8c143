"""A few steps of a scene, to see before many runs whether it has what is asked of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from hydrosim.documents.units import Scale, factor
from hydrosim.errors import HydrosimError, InputError
from hydrosim.statistics.figures import RequestedStatistic
from hydrosim.statistics.results import RunResults
from hydrosim.studies.run.asked import NotAskable
from hydrosim.studies.run.simulation import simulate

if TYPE_CHECKING:
    from hydrosim.scene import Scene

TRIAL_STEPS = 4  # of output


def check_figures(
    file: Path, scenes: Sequence[Scene], figures: Sequence[RequestedStatistic]
) -> dict[str, str]:
    """The units of the ``figures`` that a study ``file`` asks of runs like those of the ``scenes``,
    of which some may lack some; none where no scene can be run, which its own run will say. Raises
    InputError where no run has such a channel, or a case of the study has not those of its own
    criteria."""
    units: dict[str, str] = {}
    refused: dict[str, str] = {}
    for scene in scenes:
        left = [figure for figure in figures if figure.name not in units]
        if not left or scene.initial is not None:
            break
        for name, unit in _try_figures(scene, left).items():
            if isinstance(unit, InputError):
                refused.setdefault(name, f"{file}: {name}: {unit}")
            else:
                units[name] = unit
    for name, message in refused.items():
        if name not in units:
            raise InputError(message)
    return units


def _try_figures(
    scene: Scene, figures: Sequence[RequestedStatistic]
) -> dict[str, str | InputError]:
    """The unit of each figure in a few steps of a scene, or why there is none; nothing where the
    scene cannot be run."""
    short = replace(scene, duration=min(scene.duration, TRIAL_STEPS * scene.output_step))
    try:
        run = simulate(short)
    except NotAskable:
        raise
    except HydrosimError:
        return {}
    units: dict[str, str | InputError] = {}
    results = RunResults(run)
    for figure in figures:
        try:
            units[figure.name] = str(figure.evaluate(results).attrs["units"])
        except InputError as error:
            units[figure.name] = error
    return units


def check_units(
    file: Path, bounds: Mapping[str, tuple[str, Scale]], units: Mapping[str, str]
) -> None:
    """Refuse bounds of figures, by key of the study ``file``, of another kind than the figures,
    whose ``units`` are known."""
    for key, (figure, bound) in bounds.items():
        if figure not in units or bound.unit is None:
            continue
        what = "limit" if key.endswith("limit") else "width"
        unit = "" if units[figure] == "1" else units[figure]
        try:
            factor(bound.unit, unit)
        except ValueError as error:
            raise InputError(
                f'{file}: {key}: found "{bound.text}"; expected a {what} in'
                f" {unit or 'plain numbers'}, which {figure} has; {error}"
            ) from None
