"""What waves outside a database's frequencies would do, on a box whose loads have a closed form."""

from dataclasses import replace

import numpy as np
import pytest
from known_box import box_at, froude_krylov

from hydrosim.scene import Environment, Jonswap, WaveTrain
from hydrosim.water.components import sea
from hydrosim.water.database_limits import shares_outside

ROUND = np.arange(0.0, 360.0, 2.5)


@pytest.mark.parametrize("highest", [1.6, 1.8, 2.2, 2.5])
def test_loads_of_the_box_above_its_frequencies(highest: float) -> None:
    """In a sea of 5 s, with up to a quarter of its energy above, the share of the forces is that of
    the closed form within a factor of 1.5: ends and sides add up by turns."""
    waves = sea(Environment(waves=(WaveTrain(Jonswap(1.0, 5.0)),)))[0]
    box = box_at(np.arange(0.02, highest + 1e-9, 0.02), np.degrees(np.radians(ROUND)))
    load = np.mean(np.abs(froude_krylov(waves.omega, box.heading)) ** 2, axis=1).sum(axis=1)
    energy, above = load * waves.amplitude**2, waves.omega > highest
    found = shares_outside(box, [waves])
    exact = energy[above].sum() / energy.sum()
    assert found.loads is not None
    assert exact / 1.5 < found.loads < 1.5 * exact
    assert found.above == pytest.approx(
        np.sum(waves.amplitude[above] ** 2) / np.sum(waves.amplitude**2)
    )
    assert found.share == found.loads


def test_nothing_is_known_of_loads_that_do_not_fall() -> None:
    """Garbage at the end of the band, or too few frequencies."""
    waves = sea(Environment(waves=(WaveTrain(Jonswap(1.0, 5.0)),)))
    box = box_at(np.arange(0.02, 1.801, 0.02), ROUND)
    rising = replace(box, excitation=box.excitation * box.frequency[:, None, None] ** 8)
    for database in (rising, box_at(np.array([0.5, 1.0, 1.8]), ROUND)):
        found = shares_outside(database, waves)
        assert found.loads is None
        assert found.share == found.below + found.above > 0.1
