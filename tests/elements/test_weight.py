"""Weight as a force of its own: against closed forms, its own potential, and balance at rest."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import block, heave, motion, moving, scene, scene_of, steady, with_body

import hydrosim as hs
from hydrosim.elements.hydrostatics import add_weight, add_weight_energy
from hydrosim.errors import InputError
from hydrosim.integrate.dynamics import new_work
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Kinematics, LinearScenes, Weight

MASS, STIFFNESS, G = 3e3, 4e4, 9.81


def hung(**solver: object) -> hs.Scene:
    """A block held up by a spring at the place at rest, with its weight, let go there."""
    from hydrosim.elements import LinearMooring

    body = block(MASS, dofs=["heave"], weight=Weight.CARRIED)
    stiffness = np.diag([0.0, 0.0, STIFFNESS, 0.0, 0.0, 0.0])
    return scene(body, {"line": LinearMooring("block", stiffness)}, 20.0, 0.01, **solver)


@pytest.mark.parametrize("linear", LinearScenes)
def test_a_weight_on_a_spring_swings_about_its_sag(linear, validated):
    """z = -(m g / k) (1 - cos w t), stepped (rk4: 200 periods of (w h)^4 / 120) and propagated."""
    run = hs.simulate(hung(linear=linear))
    w = np.sqrt(STIFFNESS / MASS)
    expected = -MASS * G / STIFFNESS * (1.0 - np.cos(w * run.time.values))
    error = np.abs(heave(run) - expected).max() / (MASS * G / STIFFNESS * w * 20.0)
    claim = "weight that swings on a spring, of its sag, for each radian"
    validated(Kind.CLOSED_FORM, claim, "mg/k (1 - cos ωt)", error, 2e-7, Feature.WEIGHT)
    assert_allclose(run.force_weight[:, 0, 2], -MASS * G, rtol=1e-15)
    fall = run.energy_stored_weight - run.energy_stored_weight[0]
    assert_allclose(fall, MASS * G * heave(run), rtol=1e-12, atol=1e-6)
    assert np.abs(run.energy_residual).max() <= 1e-6 * run.energy_kinetic.max()


@pytest.mark.parametrize("kinematics", Kinematics)
def test_power_of_weight_is_what_its_potential_loses(kinematics: Kinematics) -> None:
    """F v = -dU/dt by central differences, off the origin, with fluids, at any angles."""
    rng = np.random.default_rng(8)
    carried = block(MASS, weight=Weight.CARRIED)
    still = scene(carried, {"push": steady(heave=1.0)}, 1.0, 1.0, kinematics=kinematics)
    model = hs.compile_scene(still).model
    work = new_work(model)
    contents, q, u = work.contents, 0.4 * rng.normal(size=6), rng.normal(size=6)
    contents.moment[:] = 1e3 * rng.normal(size=3)
    contents.surface[:] = [[3e3, 8e2, 4e3]]

    def stored(q: np.ndarray) -> float:
        out = np.zeros(model.rows)
        place_bodies(q, u, model.bodies, work.motion)
        add_weight_energy(work.motion, model.bodies, model.weights, contents, out)
        return float(out.sum())

    h = 1e-5
    loss = -(stored(q + h * u) - stored(q - h * u)) / (2.0 * h)
    wrench = np.zeros((model.rows, 6))
    place_bodies(q, u, model.bodies, work.motion)
    add_weight(work.motion, model.bodies, model.weights, contents, wrench)
    assert_allclose(wrench.sum(axis=0) @ work.motion.velocity, loss, rtol=1e-8)
    assert_allclose(wrench[-1, 5], 0.0, atol=1e-9)  # nothing turns it about the vertical


def test_a_hull_that_carries_what_it_displaces_moves_as_if_balanced() -> None:
    """Weight and buoyancy at rest cancel to rounding of 1.5e9 N."""
    balanced = replace(scene_of("base"), duration=60.0)
    db = balanced.bodies[0].hydrodynamics
    balanced = with_body(balanced, mass=float(db.water_density * db.volume[0]))
    carried = with_body(balanced, weight=Weight.CARRIED)
    runs = [motion(hs.simulate(each)) for each in (balanced, carried)]
    assert np.abs(runs[1] - runs[0]).max() <= 1e-10 * np.abs(runs[0]).max()


def test_a_hull_too_heavy_by_a_percent_rests_so_much_deeper() -> None:
    """(m - rho V) g / C33, m of the database's volume; at rest by Newton's method."""
    from hydrosim.linear.equilibrium import equilibrium

    base = scene_of("free_floating")
    db = base.bodies[0].hydrodynamics
    displaced = float(db.water_density * db.volume[0])
    body = replace(base.bodies[0], mass=1.01 * displaced, weight=Weight.CARRIED)
    compiled = hs.compile_scene(replace(base, bodies=(body,), environment=_calm(base)))
    rest = equilibrium(compiled.model, compiled.state, 0.0, body.mass * G)
    C = compiled.model.stiffness[0]
    expected = np.linalg.solve(C[2:5, 2:5], [-0.01 * displaced * G, 0.0, 0.0])
    assert_allclose(rest.position[0, 2:5], expected, rtol=1e-6, atol=1e-9)


def _calm(base: hs.Scene) -> object:
    return replace(base.environment, waves=())


def test_what_nothing_carries_is_refused() -> None:
    """Alone, with a damper, and hung on a body that nothing carries; carried by a held one."""
    from hydrosim.elements import LinearDamping, Spring

    loose, other = block(MASS, weight=Weight.CARRIED), block(MASS, name="other")
    damper = {"damper": LinearDamping("block", damping=np.eye(6))}
    curve = (np.array([0.0, 1.0]), np.array([0.0, 1e5]))
    line = {
        "line": Spring(
            "block", (0, 0, 1.0), (0, 0, 0), 1.0, curve=hs.TensionCurve(*curve), anchor_body="other"
        )
    }
    for bodies, forces in (([loose], {}), ([loose], damper), ([loose, other], line)):
        with pytest.raises(InputError, match=r"bodies\.block\.weight: found carried, but nothing"):
            hs.compile_scene(scene(bodies, forces, 1.0, 0.1))
    held = replace(other, dofs=(), position=moving(heave=5.0))
    hs.compile_scene(scene([loose, held], line, 1.0, 0.1))
