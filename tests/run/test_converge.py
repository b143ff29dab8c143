"""Convergence studies: observed orders, the reference's own error, refusals."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenes import in_contact

from hydrosim.elements import LinearMooring
from hydrosim.errors import InputError
from hydrosim.report.charts.analysis import draw_work_precision
from hydrosim.scene import Body, Method, Scene, Solver, Unstable
from hydrosim.study.converge import common_multiple, converge, to_dataset

Figure = Callable[[str, float], None]


def oscillator() -> Scene:
    """1 kg on 4 N/m, released at 1 m: x = cos 2t."""
    spring = LinearMooring("block", 4.0 * np.eye(6))
    body = Body("block", 1.0, np.eye(3), dofs=("surge",), position=(1.0, 0, 0, 0, 0, 0))
    return Scene("oscillator", 6.0, (body,), forces={"spring": spring}, solver=Solver())


def test_orders_and_errors_of_an_oscillator(tmp_path: Path) -> None:
    study = converge(oscillator(), [Method.RK2, Method.RK4], [0.1, 0.05, 0.025], [1e-6])
    trials = {(t.method, t.setting): t for t in study.trials}
    for method, order in ((Method.RK2, 2), (Method.RK4, 4)):
        fine = trials[method, 0.025].order(trials[method, 0.05])
        assert fine == pytest.approx(order, abs=0.1)
    # leading error of rk4 on x' = i w x: phase error (w h)^4 / 120 per radian
    expected = 2.0 * 6.0 * (2 * 0.025) ** 4 / 120
    assert trials[Method.RK4, 0.025].motion == pytest.approx(expected, rel=0.1)
    own = 2.0 * 6.0 * (2 * 0.00625) ** 4 / 120
    assert study.reference_error == pytest.approx(own, rel=0.2)
    dataset = to_dataset(study, "oscillator")
    draw_work_precision(dataset, tmp_path / "study.png")
    assert (tmp_path / "study.png").stat().st_size > 10_000


def test_adaptive_error_follows_the_tolerance() -> None:
    """Over four decades of the tolerance, on a smooth motion."""
    tolerances = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8]
    scene = oscillator().with_output(step=3.0)
    study = converge(scene, [Method.DOPRI5], [0.005], tolerances)
    errors = np.array([t.motion for t in study.trials])
    slope = np.polyfit(np.log10(tolerances), np.log10(errors), 1)[0]
    assert 0.7 < slope < 1.2


def test_adaptive_error_follows_the_tolerance_through_contact(figure: Figure) -> None:
    """Over three decades, with the contact modes changing more than forty times. Looser tolerances
    may miss a contact shorter than their steps; at 1e-10 the error is that of 1e-9, 4e-11 m, which
    is what the table of waves leaves."""
    tolerances = [1e-6, 1e-7, 1e-8, 1e-9]
    study = converge(in_contact(60.0), [Method.DOPRI5], [0.01], tolerances)
    errors = np.array([t.motion for t in study.trials])
    slope = np.polyfit(np.log10(tolerances), np.log10(errors), 1)[0]
    figure("power of the tolerance", slope)
    figure("largest error over tolerance", (errors / tolerances).max())
    assert 0.7 < slope < 1.2
    assert np.all(errors < 2 * np.array(tolerances))


def test_order_four_through_contact() -> None:
    """The barge knocking against the topside, with stick and slip: events keep rk4's order."""
    study = converge(in_contact(60.0), [Method.RK4], [0.1, 0.05, 0.025], [])
    coarse, middle, fine = study.trials
    assert fine.order(coarse) > 3.4
    assert fine.motion < 1e-5
    assert middle.energy < 1e-4


def test_a_step_that_is_refused_is_a_result() -> None:
    """2 rad/s by rk4 is stable to 2.83 / 2 s; a larger step does not end the study."""
    solver = Solver(unstable=Unstable.ERROR)
    study = converge(replace(oscillator(), solver=solver), [Method.RK4], [1.5, 0.1], [])
    refused, run = study.trials
    assert np.isnan(refused.motion)
    assert refused.remark.startswith("solver.step 1.5 s: largest stable step 1.4")
    assert np.isfinite(run.motion)


def test_steps_without_a_common_multiple_are_refused() -> None:
    assert common_multiple([0.2, 0.1, 0.05], 0.5) == pytest.approx(0.4)
    with pytest.raises(InputError, match="without a common multiple"):
        common_multiple([0.1, 0.0314159265], 0.5)
