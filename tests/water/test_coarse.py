"""What is lost between the headings of a database: the estimate against databases with more."""

import warnings
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scenes import ROOT

from hydrosim.database import all_headings, load
from hydrosim.scene import Environment, Jonswap, WaveTrain
from hydrosim.water.components import WaveComponents, sea
from hydrosim.water.database_limits import lost_between_headings
from hydrosim.water.transfer import excitation_at


@dataclass(frozen=True, eq=False)
class Loads:
    """First-order transfer functions of a database."""

    source: str
    frequency: np.ndarray
    heading: np.ndarray
    excitation: np.ndarray
    mean_drift: None = None

    def only(self, kept: np.ndarray | slice) -> "Loads":
        """Those of some headings."""
        return replace(self, heading=self.heading[kept], excitation=self.excitation[:, kept])


def shipped(name: str) -> Loads:
    """Those of a shipped database all round the circle, headings rising."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        db = all_headings(load(ROOT / "hydro_db" / f"{name}.nc"))
    found = Loads(db.source, db.frequency, np.mod(db.heading, 2.0 * np.pi), db.excitation[..., :6])
    return found.only(np.argsort(found.heading))


def waves_of(period: float) -> tuple[WaveComponents, ...]:
    return sea(Environment(waves=(WaveTrain(Jonswap(2.0, period), repeat_period=600.0),)))


def missed(coarse: Loads, fine: Loads, waves: WaveComponents) -> np.ndarray:
    """Root mean square of what the coarse one misses at headings that only the fine one has, of
    forces and of moments."""
    some = np.flatnonzero(waves.amplitude > 0.01 * waves.amplitude.max())[::5]
    omega, weight = waves.omega[some], waves.amplitude[some] ** 2
    error, size = np.zeros((2, 2))
    for heading in np.setdiff1d(fine.heading, coarse.heading):
        to = np.full(omega.size, heading)
        found, expected = (excitation_at(loads, to, omega) for loads in (coarse, fine))
        for total, x in ((error, found - expected), (size, expected)):
            total += weight @ (np.abs(x) ** 2).reshape(-1, 2, 3).sum(axis=2)
    return np.asarray(np.sqrt(error / size))


@pytest.mark.parametrize(
    ("name", "second", "period"),
    [
        ("h851", 12, 10.0),
        ("h851", 12, 14.0),
        ("two_barges", 2, 5.0),
        ("two_barges", 3, 6.0),
        ("box", 2, 8.0),
    ],
)
def test_the_estimate_is_what_more_headings_show(name: str, second: int, period: float) -> None:
    """A barge of 260 m, two of 40 m and a box of 100 m, with a part of their headings: within a
    factor of 1.6. The estimate continues the fall of the last four harmonics."""
    fine, (waves,) = shipped(name), waves_of(period)
    coarse = fine.only(slice(None, None, second))
    found = lost_between_headings(coarse, [waves])
    assert found is not None
    expected = missed(coarse, fine, waves)
    assert 0.005 < expected.max() < 0.7
    assert 1 / 1.6 < max(found) / expected.max() < 1.6


def test_what_is_fine_enough_is_called_so() -> None:
    """A sphere's loads have one harmonic; the two barges have headings every 10 deg."""
    for name in ("sphere", "two_barges"):
        found = lost_between_headings(shipped(name), waves_of(8.0))
        assert found is not None
        assert max(found) < 0.005


def test_uneven_headings_are_not_judged() -> None:
    loads = shipped("h851")
    uneven = loads.only(np.arange(loads.heading.size) != 3)
    assert lost_between_headings(uneven, waves_of(8.0)) is None
