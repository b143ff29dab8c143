"""A few steps of a scene, to see before many runs whether it has what is asked of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from hydrosim.documents.units import Scale, factor
from hydrosim.errors import HydrosimError, InputError
from hydrosim.statistics.figures import Figure, figure_of
from hydrosim.studies.run.simulation import simulate

if TYPE_CHECKING:
    from hydrosim.scene import Scene

STEPS = 4  # of output


def check_figures(file: Path, scene: Scene, figures: Sequence[Figure]) -> dict[str, str]:
    """The units of the ``figures`` that a study ``file`` asks of runs like that of the ``scene``;
    none where it cannot be run, which its own run will say. Raises InputError where a run has no
    such channel."""
    if not figures or scene.initial is not None:
        return {}
    short = replace(scene, duration=min(scene.duration, STEPS * scene.output_step))
    try:
        run = simulate(short)
    except HydrosimError:
        return {}
    units = {}
    for figure in figures:
        try:
            units[figure.name] = str(figure_of(run, figure).attrs["units"])
        except InputError as error:
            raise InputError(f"{file}: {figure.name}: {error}") from None
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
