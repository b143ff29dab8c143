"""Fits of decay tests: they find what made decays were made with, and say where they do not fit."""

from pathlib import Path

import numpy as np
import pytest
from made_decays import Law, draw, draw_no_decay, noise, roll_of, try_fit

from hydrosim.elements.decay_records import decay_of, read_decay
from hydrosim.elements.roll_decay import DecayProblem, fit_decays, fit_files
from hydrosim.errors import InputError

LAW = Law(0.03, 0.15, 0.4, 12.0)
TIME = np.arange(0.0, 150.0, 0.1)
ROLL = roll_of(LAW, TIME, 0.25)


def test_a_decay_without_noise_gives_what_it_was_made_with() -> None:
    found = fit_decays([decay_of(TIME, ROLL + 0.02)])
    assert found.terms.values == pytest.approx(LAW[:3], rel=1e-5)
    assert found.period.value == pytest.approx(12.0, rel=1e-7)
    assert found.damping == pytest.approx(found.terms.values)
    assert found.modelled[0] == pytest.approx(found.decays[0].angle, abs=1e-7)
    assert found.doubts == ()


def test_damping_is_right_or_refused_and_intervals_hold_as_often_as_they_say() -> None:
    """36 made decays; the benchmark `decay_intervals` has 500. Five intervals of 36 decays are not
    independent: their mean share varies by 0.03."""
    outcomes = [try_fit(draw(seed)) for seed in range(110_000, 110_036)]
    fitted = [outcome for outcome in outcomes if not outcome.refusal]
    assert len(fitted) >= 30
    assert max(abs(outcome.error) for outcome in fitted) < 0.15
    assert 0.85 < np.mean([outcome.holds for outcome in fitted]) < 0.97


@pytest.mark.slow
def test_each_interval_holds_as_often_as_it_says() -> None:
    """150 made decays, with the bounds that 99.9 % of counts keep where each holds with 90 %."""
    outcomes = [try_fit(draw(seed)) for seed in range(120_000, 120_150)]
    holds = np.mean([outcome.holds for outcome in outcomes if not outcome.refusal], axis=0)
    assert holds.min() > 0.81
    assert holds.max() < 0.97


def test_terms_for_use_are_found_far_from_those_that_are_fitted() -> None:
    """Five periods in waves: p2 is fitted below zero, and p3 at seventy times its truth."""
    assert abs(try_fit(draw(80_111)).error) < 0.15


def test_records_that_are_no_decays_are_refused() -> None:
    for seed in range(110_000, 110_012):
        made = draw_no_decay(seed)
        assert try_fit(made).refusal, made.disturbance


def test_correlated_noise_widens_intervals() -> None:
    """Noise of a memory of half a second has seven times the density of white noise of its size at
    the frequency of roll: the interval must be about 2.6 times as wide."""
    rng = np.random.default_rng(3)
    white, red = (
        fit_decays([decay_of(TIME, ROLL + 0.003 * noise(rng, TIME.size, 0.1, memory))])
        for memory in (0.0, 0.5)
    )
    w = 2.0 * np.pi / 12.0
    a = np.exp(-0.1 / 0.5)
    expected = np.sqrt((1.0 - a * a) / abs(1.0 - a * np.exp(-1j * w * 0.1)) ** 2)
    width = [np.sqrt(each.terms.covariance[0, 0]) for each in (white, red)]
    assert width[1] / width[0] == pytest.approx(expected, rel=0.15)


def test_several_decays_together_tell_more() -> None:
    """Four records of the same law, from other angles, with other means and noise."""
    rng = np.random.default_rng(4)
    decays = []
    for start, deviation in ((0.25, 2e-3), (-0.2, 1e-3), (0.1, 2e-3), (0.3, 4e-3)):
        angle = roll_of(LAW, TIME, start) + start / 10 + deviation * rng.normal(size=TIME.size)
        decays.append(decay_of(TIME, angle))
    alone, together = fit_decays(decays[:1]), fit_decays(decays)
    widths = [np.sqrt(np.diag(each.terms.covariance)) for each in (alone, together)]
    assert (widths[1] < 0.8 * widths[0]).all()
    away = (together.terms.values - LAW[:3]) / widths[1]
    assert np.abs(away).max() < 3.0
    assert together.deviations == pytest.approx([2e-3, 1e-3, 2e-3, 4e-3], rel=0.1)


def test_terms_that_are_not_there_are_not_told() -> None:
    rng = np.random.default_rng(5)
    law = Law(0.04, 0.0, 0.0, 12.0)
    found = fit_decays([decay_of(TIME, roll_of(law, TIME, 0.2) + 2e-3 * rng.normal(size=1500))])
    assert not found.terms.interval(0).includes_zero
    assert found.terms.interval(1).includes_zero
    assert found.terms.interval(2).includes_zero
    assert min(found.damping) >= 0.0


def test_a_restoring_that_is_not_linear_is_fitted() -> None:
    rng = np.random.default_rng(6)
    law = LAW._replace(cubic=-0.5)
    decay = decay_of(TIME, roll_of(law, TIME, 0.25) + 1e-3 * rng.normal(size=TIME.size))
    fit = fit_decays([decay])
    assert fit.doubts == ()
    assert fit.restoring.low < -0.5 < fit.restoring.high
    assert fit.terms.interval(0).low < LAW.p1 < fit.terms.interval(0).high


@pytest.mark.parametrize("periods", [5, 33])
def test_waves_that_remain_in_the_basin_leave_the_damping(periods: int) -> None:
    """A regular wave near the natural period forces the roll, as in the record of a public test:
    p1 0.0189 1/s, p2 0.55 1/rad, period 6.352 s, softening restoring."""
    law = Law(0.0189, 0.55, 0.0, 6.352, -1.2)
    time = np.arange(0.0, periods * law.period, 0.166)
    angle = roll_of(law, time, np.radians(-8.1), force=np.radians(0.3) * 0.02)
    angle += np.radians(-0.3 + 0.01 * np.random.default_rng(1).normal(size=time.size))
    fit = fit_decays([decay_of(time, angle)])
    residuals = [m - d.angle for m, d in zip(fit.modelled, fit.decays, strict=True)]
    assert np.std(residuals) < 0.005 * fit.size
    for amplitude in np.linspace(*fit.amplitudes, 3)[1:]:
        assert fit.used_ratio(amplitude) == pytest.approx(law.damping_ratio(amplitude), rel=0.1)


@pytest.mark.parametrize("term", range(3))
def test_one_term_alone_is_found(term: int) -> None:
    """Linear, quadratic or cubic damping alone: the terms for use have what the law has."""
    rng = np.random.default_rng(9)
    terms = np.zeros(3)
    terms[term] = (0.05, 0.4, 3.0)[term]
    law = Law(*terms.tolist(), 12.0)
    fit = fit_decays([decay_of(TIME, roll_of(law, TIME, 0.25) + 5e-4 * rng.normal(size=1500))])
    for amplitude in np.linspace(*fit.amplitudes, 4):
        assert fit.used_ratio(amplitude) == pytest.approx(law.damping_ratio(amplitude), rel=0.03)


def test_terms_for_use_leave_hardly_more_than_all_terms() -> None:
    """No term for use is negative, and the residuals are those of the fit with all terms."""
    rng = np.random.default_rng(10)
    roll = roll_of(Law(0.05, 0.0, 0.0, 12.0), TIME, 0.2)
    decay = decay_of(TIME, roll + rng.normal(size=1500) / 500)
    fit = fit_decays([decay])
    assert fit.terms.values.min() < 0.0
    assert min(fit.damping) >= 0.0
    problem = DecayProblem([decay])
    plain = np.std(problem.residuals(problem.solve().parameters)[0])
    assert fit.deviations[0] <= 1.01 * plain


def test_a_motion_that_does_not_follow_the_equation_is_doubted() -> None:
    """Dry friction of the model's bearing: it stops with a rest of its roll."""
    rng = np.random.default_rng(7)
    envelope = np.maximum(1.0 - TIME / 100.0, 0.0)
    angle = 0.2 * envelope * np.cos(2.0 * np.pi * TIME / 12.0)
    found = fit_decays([decay_of(TIME, angle + 2e-4 * rng.normal(size=TIME.size))])
    assert any("fit" in doubt for doubt in found.doubts)


def test_a_record_that_is_held_begins_after_the_release() -> None:
    held = np.arange(0.0, 30.0, 0.1)
    time = np.concatenate([held, 30.0 + TIME])
    angle = np.concatenate([np.full(held.size, ROLL[0]), ROLL])
    decay = decay_of(time, angle)
    assert 30.0 < decay.time[0] < 33.0
    assert fit_decays([decay]).terms.values == pytest.approx(LAW[:3], rel=1e-4)


def written(path: Path, heading: str, *columns: np.ndarray) -> Path:
    np.savetxt(path, np.transpose(columns), "%.9g", ",", header=heading, comments="")
    return path


def test_files_of_any_unit_and_name(tmp_path: Path) -> None:
    degrees = written(tmp_path / "a.csv", "t [s], Barge roll (deg)", TIME, np.degrees(ROLL))
    plain = written(tmp_path / "b.csv", "t, phi", TIME, ROLL)
    one, other = fit_files([degrees]), fit_files([plain], "phi", "rad")
    assert one.terms.values == pytest.approx(other.terms.values, rel=1e-5)
    begun = read_decay(degrees, "2", start=20.0, end=100.0)
    assert (begun.time[0], begun.time[-1]) == pytest.approx((20.0, 100.0))


def test_roll_of_a_run_is_its_position(tmp_path: Path) -> None:
    names = "time [s], position.barge.roll [rad], velocity.barge.roll [rad/s]"
    one = written(tmp_path / "one.csv", names, TIME, ROLL, np.gradient(ROLL, TIME))
    assert np.all(read_decay(one).angle == read_decay(one, "2").angle)
    two = written(tmp_path / "two.csv", f"{names}, position.crane.roll [rad]", TIME, *3 * [ROLL])
    with pytest.raises(InputError, match=r"one of: position\.barge\.roll \[rad\], position\.c"):
        read_decay(two)


GROWING = np.exp(0.02 * TIME) * 0.01 * np.cos(0.5 * TIME)


@pytest.mark.parametrize(
    ("heading", "angle", "said"),
    [
        ("time [s], pitch [deg]", ROLL, "found no column .roll.; expected one of"),
        ("time [s], roll", ROLL, "column roll without a unit; expected roll in deg or rad"),
        ("time [s], roll [m]", ROLL, "column roll \\[m\\] in m; expected an angle"),
        ("time [min], roll [rad]", ROLL, "times in min; expected the time in s"),
        ("time [s], roll [rad]", 0.1 - 1e-5 * TIME, "expected a roll that oscillates|periods"),
        (
            "time [s], roll [deg]",
            1e301 * ROLL,
            "found a roll of .*deg at .* s; expected angles within 180 deg",
        ),
        ("time [s], roll [rad]", GROWING, "expected a roll that decays|at least 2 periods"),
    ],
)
def test_what_is_no_decay_is_refused(tmp_path, heading, angle, said):
    path = written(tmp_path / "decay.csv", heading, TIME, angle)
    with pytest.raises(InputError, match=rf"decay\.csv.*({said})"):
        fit_files([path])


def test_undamped_roll_is_refused() -> None:
    rng = np.random.default_rng(8)
    steady = 0.1 * np.cos(0.5 * TIME) + 1e-3 * rng.normal(size=TIME.size)
    with pytest.raises(InputError, match=r"expected a roll that decays, above 0"):
        fit_decays([decay_of(TIME, steady)])


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        (TIME < 3.0, "30 values; expected at least 40"),
        (TIME < 20.0, "expected at least 2 periods"),
        ((TIME < 50.0) | (TIME > 60.0), "gaps or unequal steps, at 6"),
        (np.arange(TIME.size) % 30 == 0, "values in a period; expected at least 8"),
    ],
)
def test_what_is_too_short_or_coarse_is_refused(kept: np.ndarray, said: str) -> None:
    with pytest.raises(InputError, match=said):
        decay_of(TIME[kept], ROLL[kept])


def test_fine_records_are_thinned_and_long_ones_end() -> None:
    time = np.linspace(0.0, 1000.0, 100_001)
    steady = decay_of(time, 0.1 * np.exp(-0.002 * time) * np.cos(time))
    assert steady.time.size < 40_000
    assert any("thinned to means of 3" in note for note in steady.notes)
    decayed = decay_of(time, 0.1 * np.exp(-0.02 * time) * np.cos(time))
    assert any("below 5 % of the largest" in note for note in decayed.notes)
    assert decayed.time[-1] == pytest.approx(np.log(20.0) / 0.02, abs=7.0)
