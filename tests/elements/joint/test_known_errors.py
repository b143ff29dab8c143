"""Motions that are known: a tolerance is kept, and a run knows the error of its own motion."""

from dataclasses import replace
from functools import cache

import pytest
import xarray as xr
from jointed import TIGHT
from known_motions import CHAOTIC, KNOWN, OUTPUT_STEP, Known

import hydrosim as hs
from hydrosim.results.ledger import REPORTED
from hydrosim.scene import Method, Solver
from tests.generators.references import motion_errors

KEPT = 1e-6  # of the range of a motion: tolerance of automatic
WITHIN = 1e-3  # of the range of a motion: what is complete and unwarned keeps
SAID = (0.3, 10.0)  # error said over true error
LOST = 0.3  # of the range of a motion: its path is lost
SMALLEST = 1e-7  # of the range of a motion: errors below are not judged
RECORDED = (0.1, 0.5, 2.0)  # s
STEPS = (0.1, 0.05, 0.02)  # s
ALL = {**KNOWN, **CHAOTIC}


@cache
def known(name: str) -> Known:
    return ALL[name]()


@cache
def ran(name: str, output_step: float, solver: Solver) -> xr.Dataset:
    made = known(name).scene
    return hs.simulate(replace(made, solver=solver).with_output(step=output_step))


def true_error(name: str, run: xr.Dataset) -> float:
    """Largest error of a motion, of its range."""
    every = round(float(run.time[1] - run.time[0]) / OUTPUT_STEP)
    exact = known(name).exact[::every][: run.sizes["time"]]
    return float(motion_errors(exact, run.position.values).max())


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_known_motions_begin_as_their_scenes(name: str) -> None:
    """The exact motion is that of the scene: a fine run agrees at first."""
    solver = Solver(Method.DOPRI5, tolerance=TIGHT)
    fine = replace(known(name).scene, duration=2.0, solver=solver)
    assert true_error(name, hs.simulate(fine)) <= 1e-9


@pytest.mark.parametrize("output_step", RECORDED)
@pytest.mark.parametrize("name", KNOWN)
def test_automatic_keeps_its_tolerance(name: str, output_step: float) -> None:
    """Over 18 periods, whatever is recorded."""
    run = ran(name, output_step, Solver(Method.AUTOMATIC, accuracy=KEPT))
    assert true_error(name, run) <= KEPT
    assert run.attrs["error_relative"] <= KEPT


@pytest.mark.parametrize("name", CHAOTIC)
def test_automatic_keeps_its_tolerance_or_tells(name: str) -> None:
    """Errors grow a millionfold, which may be more than can be afforded."""
    run = ran(name, OUTPUT_STEP, Solver(Method.AUTOMATIC, accuracy=KEPT))
    if true_error(name, run) > KEPT:
        assert run.attrs["error_relative"] > KEPT
        assert run.attrs["warnings"]


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("name", ALL)
def test_a_run_with_equal_steps_tells_a_large_error(name: str, step: float) -> None:
    """No run is complete and unwarned beyond a thousandth of the range."""
    run = ran(name, OUTPUT_STEP, Solver(Method.RK4, step))
    assert run.attrs.get("warnings") or true_error(name, run) <= WITHIN


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("name", ALL)
def test_a_run_with_equal_steps_knows_its_error(name: str, step: float) -> None:
    """Within 0.3 to 10 of the true one. Once a motion is lost, it is only said that it is."""
    run = ran(name, OUTPUT_STEP, Solver(Method.RK4, step))
    true = true_error(name, run)
    said = float(run.attrs["error_relative"])
    low, high = SAID
    if true > LOST:
        assert said > 10.0 * REPORTED
    elif max(true, said) > SMALLEST:
        assert low * true <= said <= high * true
