"""What is said of a scene before it runs."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from dry_scenes import block

from hydrosim.compiling.notes import OUTSIDE_REFUSED, OUTSIDE_WARNED, range_warnings
from hydrosim.errors import InputError
from hydrosim.scene import Environment, WaveForces, WaveTrain, WhiteNoise
from hydrosim.waves import sea

NOISE = WaveTrain(WhiteNoise(1.0, 0.5, 1.5))  # a band of 1 rad/s: shares of it are frequencies


def said(share: float, **forces: bool) -> list[str]:
    """Of a sea with a share of its energy above a database's frequencies."""
    body = replace(block(1.0), wave_forces=WaveForces(**forces))
    database = SimpleNamespace(frequency=np.array([0.1, 1.5 - share]))
    return list(range_warnings(sea(Environment(waves=(NOISE,))), body, database))


def test_energy_outside_a_database() -> None:
    # the last 0.1 % is cut off, and a component is 0.06 % of the energy
    assert said(0.5 * OUTSIDE_WARNED) == []
    (warning,) = said(0.8 * OUTSIDE_REFUSED)
    assert "of the waves' energy is outside the frequencies of the database of block" in warning
    with pytest.raises(InputError, match=r"environment\.waves: .* expected at most .* Use a data"):
        said(1.2 * OUTSIDE_REFUSED + 1e-3)
    assert said(0.9, first_order=False) == []
