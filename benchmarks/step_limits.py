"""Is the largest stable step that is said before a run the one at which runs diverge?

Scenes of `tests.generators.stable_steps`, which says how the step is observed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.report import Answer, Row
from hydrosim.scene import ConvolutionRadiation, Scene
from tests.generators.stable_steps import (
    observed,
    predicted,
    random_scene,
    refused,
    with_radiation,
)

SCENES, CONVOLVED = 40, 5


def answer() -> Answer:
    """Predicted against observed steps of all scenes."""
    scenes = [random_scene(seed) for seed in range(SCENES)]
    convolved = [with_radiation(scene, ConvolutionRadiation()) for scene in scenes[:CONVOLVED]]
    rows = [_row("state space", scenes), _row("convolution", convolved)]
    return Answer({"Steps at which runs begin to diverge, rk4": rows})


def _row(radiation: str, scenes: Sequence[Scene]) -> Row:
    ratio = np.array([observed(scene) / predicted(scene) for scene in scenes])
    return {
        "radiation": radiation,
        "scenes": len(scenes),
        "observed over predicted step": f"{ratio.min():.3f} to {ratio.max():.3f}",
        "within 5 %": int((np.abs(ratio - 1.0) <= 0.05).sum()),
        "refused at 0.95 of it": sum(map(refused, scenes)),
    }
