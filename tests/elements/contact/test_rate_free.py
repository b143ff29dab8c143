"""Slip without dampers: the node trails on the kinetic cone, in any direction of the plane."""

from functools import lru_cache

import numpy as np
import pytest
import xarray as xr
from in_plane import Driven, integrate_in_plane
from markers import few
from modes_apart import ModalMotion
from scenes import block, scene, with_step

import hydrosim as hs
from hydrosim.scene import Environment, Method, Scene, Stream, Tolerance

SHORT, LONG = hs.StickSlip(0.3, 0.2, 5e6, 0.0), hs.StickSlip(0.3, 0.2, 5e5, 0.0)
FIGURES = {
    "circle": Driven(LONG, 1e5, (2.0, 2.0), (0.7, 0.7), (0.0, np.pi / 2)),
    "Lissajous 1:2": Driven(LONG, 1e5, (1.0, 0.6), (0.7, 1.4), (0.0, 0.3)),
    "Lissajous 1:2, mostly in stick": Driven(LONG, 1e6, (1.0, 0.6), (0.7, 1.4), (0.0, 0.3)),
    "Lissajous 3:2, a line at times": Driven(LONG, 2e5, (1.0, 0.8), (1.5, 1.0), (0.0, 0.0)),
    "Lissajous 1:2, a short drawbar": Driven(SHORT, 1e5, (1.0, 0.6), (0.7, 1.4), (0.0, 0.3)),
}
STEPS = (0.0125, 0.00625)  # s


@lru_cache
def exact(driven: Driven, times: bytes) -> ModalMotion:
    """At the times, once for all runs."""
    return integrate_in_plane(driven, np.frombuffer(times))


def trail(driven: Driven, run: xr.Dataset) -> float:
    """How far the node is from where it should be at the worst, over the drawbar."""
    law, there = driven.law, exact(driven, run.time.values.tobytes())
    assert run.solver_events == len(there.events)
    node = driven.place(run.time.values) - there.states[:, :2]
    apart = np.linalg.norm(run.fender_node.values[:, 0, :2] - node, axis=1)
    return float(apart.max() * law.stiffness / (law.kinetic * driven.normal))


@pytest.mark.parametrize("name", few(FIGURES, 3))
def test_a_driven_node_against_an_independent_integration(name: str, figure) -> None:
    """The drawbar of 4 mm turns in 3 ms: these steps are longer, and the order is there."""
    driven = FIGURES[name]
    there = driven.scene(0.05)
    found = [trail(driven, hs.simulate(with_step(there, h))) for h in STEPS]
    order = np.log2(found[0] / found[1])
    figure("order", order)
    assert order > 3.8
    figure("largest error over the drawbar", found[1])
    assert found[1] < 1e-4
    tight = Tolerance(1e-9, 1e-9, 1e-9)
    adaptive = with_step(there, 0.05, method=Method.DOPRI5, tolerance=tight)
    assert trail(driven, hs.simulate(adaptive)) < 1e-8


@pytest.mark.slow
def test_steps_far_longer_than_the_drawbar_turns_in(figure) -> None:
    """0.05 s are 16 times as long: the direction is late as it should be."""
    driven = FIGURES["Lissajous 1:2, a short drawbar"]
    found = [trail(driven, hs.simulate(driven.scene(h))) for h in (0.05, 0.025)]
    figure("error over the drawbar at 0.05 s", found[0])
    assert found[0] < 0.05  # of a drawbar; it is 2 beyond the stable steps of the node itself
    assert found[1] < 0.5 * found[0]


def windy(**solver: object) -> Scene:
    """A body in surge blown against an oblique plane: it slides aslant to the plane's axes."""
    law = hs.StickSlip(0.14, 0.12, 1.9e8, 0.0)
    curve = hs.NormalCurve(np.array([0.0, 0.03, 0.06, 0.09]), np.array([0.0, 2e6, 8.4e6, 2e7]))
    plane = hs.Plane((-0.75, 13.0, 5.4), (-0.13, -0.99, 0.085))
    headings = np.radians([0.0, 90.0, 180.0, 270.0])
    surge = 4300.0 * np.array([1.0, 0.0, -1.0, 0.0])
    wind = hs.WindLoad("block", (0.0, 0.0, 0.0), headings, surge, 0.0 * surge, 0.0 * surge)
    fender = hs.Fender("block", np.array([[0.46, 2.5, -3.9]]), plane, curve, law)
    forces = {"fender": fender, "wind": wind}
    dry = scene(block(3.8e6, ("surge",)), forces, 52.0, 0.1, **solver)
    return Scene(**{**vars(dry), "environment": Environment(wind=Stream(18.0))})


def test_an_oblique_plane_keeps_the_order_and_the_ledger(figure) -> None:
    """What is left open is what rk4 takes from a swing of the stuck node, (h w)^6 / 72 of its
    energy a step with h w = 0.36 at 0.05 s: 4e2 J of 4e6 J in the first one, of 6e7 J in all."""
    tight = Tolerance(1e-11, 1e-11, 1e-13)
    exact = hs.simulate(windy(method=Method.DOPRI5, tolerance=tight)).position.values[:, 0, 0]
    steps = (0.1, 0.05, 0.025, 0.0125)
    runs = [hs.simulate(windy(step=h)) for h in steps]
    errors = [np.abs(run.position.values[:, 0, 0] - exact).max() / np.ptp(exact) for run in runs]
    orders = np.diff(np.log(errors)) / np.diff(np.log(steps))
    for h, error, run in zip(steps, errors, runs, strict=True):
        figure(f"error at {h:g} s", error)
        figure(f"ledger at {h:g} s", run.energy_residual_relative)
    assert np.all(orders > 3.8)
    assert runs[1].energy_residual_relative < 1e-5
    assert runs[2].energy_residual_relative < 1e-6
