"""The limit said before a run is where runs diverge: a few scenes of `benchmarks.step_limits`."""

from __future__ import annotations

import pytest
from markers import few

from hydrosim.scene import ConvolutionRadiation
from tests.generators.stable_steps import (
    PLACES,
    diverges,
    predicted,
    put,
    random_scene,
    refused,
    with_radiation,
)


@pytest.mark.parametrize("convolved", [False, True])
@pytest.mark.parametrize("seed", few([0, 16], 1))
@pytest.mark.slow
def test_runs_diverge_where_it_is_said(seed: int, convolved: bool) -> None:
    """Limits of a contact node and of a friction slope: 5 % below none diverges, above one does."""
    scene = random_scene(seed)
    if convolved:
        scene = with_radiation(scene, ConvolutionRadiation())
    step = predicted(scene)
    placed = [put(scene, place) for place in PLACES]
    assert not any(diverges(each, 0.95 * step) for each in placed)
    assert any(diverges(each, 1.05 * step) for each in placed)
    assert not refused(scene)
