"""Impulses and works that ride along: they sum to the changes of momentum and energy; what contacts
did, mode by mode, is the force of their element, and friction in slip is mu_k N along the slip."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scenes import FLOOR, block, moving, on_floor, scene, steady, table, with_step

import hydrosim as hs
from hydrosim.elements import Harmonic
from hydrosim.results.channels import channel_names, channel_series
from hydrosim.scene import LinearScenes, Scene, Start
from hydrosim.statistics.explain import COVARIANCE, DIRECTION, SLIP_DAMPING, WHOLE_RUN, explain_run

MASS, WEIGHT = 1e5, 9.81e5
MU_S, MU_K, C3 = 0.3, 0.2, 4e4
FEET = ((3.0, 2.0, -1.0), (3.0, -2.0, -1.0), (-3.0, 0.0, -1.0))
LAW = hs.StickSlip(MU_S, MU_K, stiffness=2e7, damping=4e5, slip_damping=C3)
ROUNDING = 1e-12  # of the largest of what is added


def sliding() -> Scene:
    """A block on three feet, shaken in two directions on a deck that floats on springs: it sticks,
    slips round corners, lifts a foot, and turns."""
    top = block(MASS, name="top", position=moving(heave=-WEIGHT / 3e7))
    deck = block(8e5, name="deck", location=(0.0, 0.0))
    held, lossy = np.diag([4e5, 5e5, 4e6, 8e7, 8e7, 2e7]), np.diag([2e5, 2e5, 2e6, 2e7, 2e7, 5e6])
    shake = {
        "surge": Harmonic(4.2e5, 2.9, phase=0.3),
        "sway": Harmonic(2.1e5, 1.7, mean=3e4),
        "pitch": Harmonic(2.4e6, 2.3, phase=1.0),
    }
    forces = {
        "weight": steady("top", heave=-WEIGHT),
        "feet": on_floor(1e7, LAW, FEET, hs.Plane((0, 0, -1.0), (0, 0, 1), "deck"), "top"),
        "springs": hs.LinearMooring("deck", held, lossy),
        "carried": steady("deck", heave=WEIGHT),
        "shake": hs.AppliedForce("top", (0.0, 0.0, 0.5), shake),
    }
    found = scene((top, deck), forces, 12.0, 0.1, step=0.01)
    return found.with_output(impulses=True, accelerations=True)


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return hs.simulate(sliding())


def gained(run: xr.Dataset) -> xr.Dataset:
    """What all integrals have come to."""
    return run.isel(time=-1) - run.isel(time=0)


def test_the_scene_has_all_modes(run: xr.Dataset) -> None:
    assert (gained(run).contact_time.sum("fender") > 0.2).all()
    np.testing.assert_allclose(gained(run).contact_time.sum("contact_mode"), 12.0, rtol=1e-12)


def test_impulses_are_the_change_of_momentum(run: xr.Dataset) -> None:
    """Linear momentum of each body, and its angular momentum about its centre of gravity, to the
    error of rk4; which falls with its order."""

    def missing(run: xr.Dataset) -> np.ndarray:
        d = gained(run)
        return np.abs((d.impulse.sum("force") - d.momentum).values) / (MASS * np.array([1.0] * 6))

    assert missing(run)[:, :3].max() < 1e-9  # m/s: the same sums, by the same weights
    coarse, fine = missing(run)[:, 3:], missing(hs.simulate(with_step(sliding(), 0.005)))[:, 3:]
    assert coarse.max() < 1e-5
    assert fine.max() < 0.2 * coarse.max()


def test_works_are_the_change_of_energy(run: xr.Dataset) -> None:
    """To the error of the integration, as what the ledger leaves, another sum of the same by what
    is stored and lost."""
    for each, share in ((run, 2e-5), (hs.simulate(with_step(sliding(), 0.0025)), 1e-7)):
        d, exchanged = gained(each), float(np.abs(np.diff(each.energy_kinetic)).sum())
        assert abs(float(d.work.sum()) - float(d.energy_kinetic)) < share * exchanged
        assert abs(float(d.energy_residual)) < share * exchanged


def test_contacts_are_the_force_of_their_element(run: xr.Dataset) -> None:
    d = gained(run)
    both = (d.contact_press + d.contact_friction).sum(["fender", "contact_mode"])
    whole = d.impulse.sel(force="feet")
    for body, sign in (("top", 1.0), ("deck", -1.0)):
        own = whole.sel(body=body, dof=["surge", "sway", "heave"]).values
        np.testing.assert_allclose(sign * both.values, own, atol=ROUNDING * 12 * WEIGHT)
    works = float(d.contact_press_work.sum() + d.contact_friction_work.sum())
    assert works == pytest.approx(float(d.work.sel(force="feet").sum()), rel=1e-9)


def test_friction_in_slip(run: xr.Dataset) -> None:
    """mu_k times the integral of N d, and C3 times the slip, which is that of the node."""
    d = gained(run)
    slip = d.contact_friction.sel(contact_mode="slip")
    expected = -MU_K * d.slip_load - d.slip_damping
    np.testing.assert_allclose(slip.values, expected.values, atol=ROUNDING * 12 * WEIGHT)
    np.testing.assert_allclose(d.slip_damping.values, C3 * d.slip_moved.values, rtol=1e-9)
    found = explain_run(run).sel(span=WHOLE_RUN)
    parts = found.friction_part.sel(part=[DIRECTION, COVARIANCE, SLIP_DAMPING]).sum("part")
    told = 12.0 * parts.transpose("fender", "direction").values  # N s, with E[N], E[d], Cov(N, d)
    np.testing.assert_allclose(told, slip.values, atol=ROUNDING * 12 * WEIGHT)
    np.testing.assert_allclose(run.fender_kinetic, MU_K)


def test_slip_is_where_the_node_goes() -> None:
    """On a plane at rest the node moves in slip alone."""
    forces = dict(
        sliding().forces, feet=on_floor(1e7, LAW, FEET, hs.Plane((0, 0, -1), (0, 0, 1)), "top")
    )
    top = sliding().bodies[0]
    forces = {name: e for name, e in forces.items() if e.body == "top"}
    found = replace(sliding(), bodies=(top,), forces=forces)
    still = replace(forces["shake"], force={"surge": Harmonic(3.2e5, 2.9)})
    run = hs.simulate(replace(found, forces={**forces, "shake": still}))
    d = gained(run)
    assert float(d.contact_time.sel(contact_mode="open").max()) == 0.0
    moved = d.fender_node.values[:, :2]
    assert np.abs(moved).max() > 1e-3
    np.testing.assert_allclose(d.slip_moved.values[:, :2], moved, atol=1e-7)
    ahead, all_ = d.slip_moved_ahead.values, d.slip_moved.values
    assert (ahead >= 0.0).all()
    assert (ahead >= all_).all()


def test_rigid_friction_is_in_stick() -> None:
    """Half of what would move it: the reaction is the force itself, and slip is at mu_k N."""
    press = table([0.0, 1.0, 1.0001, 2.0], [moving(surge=x * WEIGHT) for x in (0.1, 0.1, 0.5, 0.5)])
    body = block(MASS, ("surge", "heave"), position=moving(heave=-WEIGHT / 1e7))
    forces = {
        "floor": on_floor(1e7, hs.Coulomb(MU_S, MU_K)),
        "weight": steady(heave=-WEIGHT),
        "push": hs.AppliedForce("block", (0.0, 0.0, 0.0), press),
    }
    run = hs.simulate(scene(body, forces, 2.0, 0.1, step=0.01).with_output(impulses=True))
    at_one = run.sel(time=1.0)
    stick = at_one.contact_friction.sel(contact_mode="stick", axis="x")
    np.testing.assert_allclose(stick, -0.1 * WEIGHT, rtol=1e-9)
    d = gained(run)
    np.testing.assert_allclose(d.contact_time.sel(contact_mode="slip"), 1.0, atol=1e-4)
    missing = (d.impulse.sum("force") - d.momentum).sel(dof="surge")
    np.testing.assert_allclose(missing, 0.0, atol=1e-9 * WEIGHT)


def test_a_slope_is_less_than_coefficient_times_load() -> None:
    """What friction in slip is less than mu_k N is left to see: b |v| is not yet mu N."""
    body = block(MASS, ("surge",))
    feet = on_floor(1e7, hs.FrictionSlope(MU_K, 1e6))
    forces = {"floor": replace(feet, plane=replace(FLOOR, point=(0, 0, WEIGHT / 1e7)))}
    forces["push"] = hs.AppliedForce("block", (0, 0, 0), {"surge": Harmonic(1e5, 2.0)})
    run = hs.simulate(scene(body, forces, 5.0, 0.1, step=0.01).with_output(impulses=True))
    d = gained(run)
    slip = d.contact_friction.sel(contact_mode="slip", axis="x")
    assert abs(float(slip.sum())) < 0.9 * MU_K * WEIGHT * 5.0
    np.testing.assert_allclose(
        d.impulse.sum("force").sel(dof="surge"), d.momentum.sel(dof="surge"), atol=1e-6
    )


def test_what_is_not_asked_for_changes_nothing(run: xr.Dataset) -> None:
    bare = hs.simulate(sliding().with_output(impulses=False, accelerations=False))
    new = {str(name) for name in {*run.variables} - {*bare.variables}}
    assert {"impulse", "work", "momentum", "acceleration", "contact_time"} < new
    assert run.sizes["state"] > bare.sizes["state"]
    for name in bare.data_vars:
        if not str(name).startswith("state_"):
            np.testing.assert_array_equal(run[name], bare[name], err_msg=str(name))


def test_accelerations_are_force_over_mass(run: xr.Dataset) -> None:
    at = {"body": "top", "dof": ["surge", "sway", "heave"]}
    total = sum(run[f"force_{name}"].sel(at) for name in run.force.values)
    own = run.acceleration.sel(at)
    np.testing.assert_allclose(own, total / MASS, atol=1e-12 * 9.81)
    assert "acceleration.top.surge" in channel_names(run)
    assert channel_series(run, "acceleration.top.pitch")[1] == "rad/s^2"


def test_a_run_that_goes_on_counts_on(run: xr.Dataset) -> None:
    first = hs.simulate(replace(sliding(), duration=6.0))
    second = hs.simulate(replace(sliding(), duration=6.0, initial=Start(first)))
    for name in ("impulse", "work", "contact_friction", "slip_load"):
        size = float(np.abs(run[name]).max())
        np.testing.assert_allclose(second[name][-1], run[name][-1], atol=1e-9 * size, err_msg=name)


def test_linear_scenes_are_stepped_for_it() -> None:
    """And say so."""
    body = block(MASS, ("surge",))
    forces = {"push": hs.AppliedForce("block", (0, 0, 0), {"surge": Harmonic(1e5, 2.0)})}
    found = scene(body, forces, 5.0, 0.1).with_output(impulses=True)
    linear = replace(found, solver=replace(found.solver, linear=LinearScenes.EXACT))
    said = str(hs.simulate(linear).attrs["solver_linear"])
    assert "output.impulses needs integrals over time steps" in said
    assert "stepped" in said
    exact = hs.simulate(linear.with_output(impulses=False))
    assert "exactly" in str(exact.attrs["solver_linear"])
