"""The one-dimensional model of hydrosim against the independent code `plasterk`, which is exact
between two samples."""

from __future__ import annotations

from collections.abc import Mapping

from cases.reverse_float_over.thesis.one_dimension import VARIANTS as OF_MODEL
from cases.reverse_float_over.thesis.one_dimension import Settings, independent, simulated

TABLE = "One-dimensional model against an independent code"
VARIANTS: Mapping[str, Mapping[str, object]] = OF_MODEL
STEPS = (0.1, 0.025)  # s, that of the case and a quarter of it


def figures(variant: str, seed: int) -> dict[str, float]:
    """Difference in surge at 2000 s [m], by step."""
    settings = Settings(**VARIANTS[variant])  # type: ignore[arg-type]
    reference = float(independent(settings, seed)[-1, 0])
    return {f"apart_{step:g}": abs(_end(settings, seed, step) - reference) for step in STEPS}


def _end(settings: Settings, seed: int, step: float) -> float:
    return float(simulated(settings, seed, step).position.isel(body=0).sel(dof="surge")[-1])
