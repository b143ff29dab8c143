"""A section in a wave flume against its experiment (`cases/flume`): held, and free on a rig with
springs and dry friction. Nothing is fitted."""

from collections.abc import Callable

import numpy as np
import pytest

from cases.flume import comparison as flume
from hydrosim.report.evidence import Feature, Kind

EXPERIMENT = "Sundsdal et al. 2025"
FREE = (Feature.WAVES, Feature.RADIATION, Feature.JOINTS)
ROLL_RESONANCE = (5.0, 5.5)  # rad/s
BREAKING = 9.0  # rad/s: waves above are so steep that they break


@pytest.fixture(scope="module")
def held() -> list[flume.FixedLoads]:
    """The held section at 14 frequencies."""
    return flume.fixed_loads()


@pytest.fixture(scope="module")
def free() -> list[flume.FreeMotions]:
    """The free section in 8 waves."""
    return flume.free_motions()


def largest_distance(free: list[flume.FreeMotions], name: str) -> float:
    """How far values are outside of the range of the instruments, with the middle friction."""
    return max(abs(each.distances(name)[1]) for each in free)


def test_the_records_are_whole() -> None:
    """The camera failed in one. A window has whole periods before waves are back."""
    fixed, free = flume.records("fixed"), flume.records("free")
    assert (fixed.sizes["run"], free.sizes["run"]) == (34, 13)
    dead = [
        str(free.run.values[row])
        for row in range(free.sizes["run"])
        if np.isnan(flume.measured_harmonic(free.isel(run=row), "Heave")[0])
    ]
    assert dead == ["3102_4"]
    for row in range(fixed.sizes["run"]):
        record = fixed.isel(run=row)
        end, periods = flume.window(record)
        ramp_end = flume.MODEL_PLACE / record.group_velocity + 5 * record.period
        assert end - periods * record.period >= ramp_end - 0.05
        assert end <= record.time.max()


def test_a_harmonic_is_that_of_whole_periods() -> None:
    """Of a series that is known, with a harmonic above it."""
    time = np.arange(0.0, 20.0, 0.025)
    angle = 2.0 * np.pi * time / 1.3
    values = 0.4 + 2.0 * np.cos(angle + 0.3) + 0.7 * np.cos(2.0 * angle)
    mean, first = flume.harmonic(time, values, 1.3, 17.9, 4)
    assert mean == pytest.approx(0.4, abs=1e-9)
    assert first == pytest.approx(2.0 * np.exp(0.3j), abs=1e-9)


@pytest.mark.parametrize(("k", "name"), [(0, "sway"), (1, "heave")])
def test_loads_of_waves(
    held: list[flume.FixedLoads], k: int, name: str, validated: Callable[..., None]
) -> None:
    claim = f"section held in a flume, {name} load at 12 frequencies, rms"
    validated(Kind.EXPERIMENT, claim, EXPERIMENT, flume.rms_errors(held)[k], 0.05, Feature.WAVES)


def test_drift_of_the_held_section(
    held: list[flume.FixedLoads], validated: Callable[..., None]
) -> None:
    """At 5.86 rad/s it is 10 % off, elsewhere less than 8 %."""
    errors = np.abs(flume.drift_errors(held))
    assert errors.size == 4
    assert np.sort(errors)[-2] < 0.08
    claim = "section held in a flume, mean drift at 4 frequencies from 5.8 to 8 rad/s"
    validated(Kind.EXPERIMENT, claim, EXPERIMENT, errors.max(), 0.11, Feature.MEAN_DRIFT)


@pytest.mark.parametrize(("name", "limit"), [("heave", 0.03), ("roll", 0.08)])
def test_amplitudes_are_those_of_the_instruments(
    free: list[flume.FreeMotions], name: str, limit: float, validated: Callable[..., None]
) -> None:
    """Camera and accelerometers; the resonance of roll is among the waves."""
    waves = [each for each in free if each.frequency < BREAKING]
    assert len(waves) == 7
    claim = f"section on its rig, {name} in 7 waves, outside of both instruments"
    error = largest_distance(waves, name)
    validated(Kind.EXPERIMENT, claim, EXPERIMENT, error, limit, *FREE)


def test_mean_force_with_friction(
    free: list[flume.FreeMotions], validated: Callable[..., None]
) -> None:
    """Away from the resonance of roll. The range of the friction hardly matters."""
    low, high = ROLL_RESONANCE
    waves = [each for each in free if not low < each.frequency < high]
    assert len(waves) == 5
    assert [each.distances("force")[1] for each in waves].count(0.0) == 3
    for each in waves[1:]:
        assert np.ptp(each.computed["force"]) < 0.02 * each.computed["force"][1]
    claim = "section on its rig with friction, mean force in 5 waves, outside of three sensors"
    error = largest_distance(waves, "force")
    validated(Kind.EXPERIMENT, claim, EXPERIMENT, error, 0.12, Feature.NEWMAN, *FREE)


def test_natural_periods(validated: Callable[..., None]) -> None:
    """Waves of the sway period are longer than the flume, whose ends are closed: sway is slower in
    open water."""
    periods = {name: x / flume.PERIODS[name] - 1.0 for name, x in flume.natural_periods().items()}
    assert 0.10 < periods.pop("sway") < 0.18
    claim = "section on its rig, periods of heave, roll, and roll with sway held"
    error = max(abs(x) for x in periods.values())
    validated(Kind.EXPERIMENT, claim, EXPERIMENT, error, 0.015, Feature.RADIATION, Feature.JOINTS)
