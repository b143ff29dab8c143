"""Bodies that share a database: with all couplings, and as single ones where there are none."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
import xarray as xr
from markers import few
from scenes import SEA, hull, in_waves, scene_of
from scipy.linalg import block_diag

import hydrosim as hs
from hydrosim.database import HydroDatabase, move_reference
from hydrosim.scene import Scene, SecondOrder, WaveForces, WaveTrain

HIGH, LOW = (0.0, 0.0, -3.0), (0.0, 0.0, -4.9)  # centres of gravity


@lru_cache
def uncoupled() -> HydroDatabase:
    """Two of one hull that do not feel each other, one of them ballasted: a database of two."""
    one, two = hull(), move_reference(hull(), HIGH)

    def both(name: str) -> np.ndarray:
        return np.concatenate([getattr(db, name) for db in (one, two)], axis=-1)

    def blocks(name: str) -> np.ndarray:
        pair = [getattr(db, name).reshape(-1, 6, 6) for db in (one, two)]
        whole = np.array([block_diag(a, b) for a, b in zip(*pair, strict=True)])
        return whole.reshape(*getattr(one, name).shape[:-2], 12, 12)

    def each(name: str) -> np.ndarray:
        return np.concatenate([getattr(db, name) for db in (one, two)])

    return replace(
        one,
        source="two barges, far apart",
        **{name: blocks(name) for name in ("added_mass", "radiation_damping")},
        **{name: blocks(name) for name in ("added_mass_zero", "added_mass_infinite")},
        hydrostatic_stiffness=blocks("hydrostatic_stiffness"),
        **{
            name: both(name)
            for name in ("excitation", "froude_krylov", "mean_drift", "qtf_difference")
        },
        **{name: each(name) for name in ("reference_point", "centre_of_gravity", "volume")},
        centre_of_buoyancy=each("centre_of_buoyancy"),
        mean_drift_held=None,
        inertia_matrix=None,
        drift_imbalance=None,
    )


def two_barges(database: HydroDatabase, radiation: str, duration: float) -> Scene:
    """The high one first, which is the second body of the database of two."""
    base = in_waves(scene_of("free_floating"), WaveTrain(SEA, heading=np.radians(30.0), ramp=20.0))
    (barge,) = base.bodies
    loads = WaveForces(second_order=SecondOrder.NEWMAN)
    barge = replace(barge, hydrodynamics=database, radiation=radiation, wave_forces=loads)
    coupled = database.bodies == 2
    high = replace(barge, name="high", centre_of_gravity=HIGH, database_body=2 if coupled else 1)
    low = replace(barge, name="low", centre_of_gravity=LOW)
    forces = {
        f"{kind}_{body.name}": replace(element, body=body.name)
        for body in (high, low)
        for kind, element in base.forces.items()
    }
    return replace(base, bodies=(high, low), forces=forces, duration=duration)


@pytest.mark.parametrize("radiation", few(["none", "convolution", "state_space", "automatic"], 2))
@pytest.mark.usefixtures("fits_made_here")
@pytest.mark.slow
def test_bodies_without_coupling_move_as_with_a_database_each(radiation, figure) -> None:
    """Both changes of reference, all loads, all kinds of radiation; fits differ by rounding."""
    duration = 20.0 if radiation == "convolution" else 200.0
    scenes = [two_barges(database, radiation, duration) for database in (uncoupled(), hull())]
    found, expected = (hs.simulate(scene) for scene in scenes)
    loads = ("force_radiation", "force_wave_first_order", "force_wave_second_order")
    for name in ("position", *loads):
        there = expected[name].values
        off = np.abs(found[name].values - there).max(axis=0)
        size = np.maximum(np.abs(there).max(axis=0), 1e-300)
        figure(f"{radiation}, {name}", float((off / size).max()))
        assert (off <= 1e-12 * size).all()
    assert float(np.abs(expected.position[:, 0] - expected.position[:, 1]).max()) > 1e-4


def refused(scene: Scene) -> str:
    with pytest.raises(hs.InputError) as caught:
        hs.compile_scene(scene)
    return str(caught.value)


def changed(scene: Scene, **changes: object) -> Scene:
    """With the first body changed."""
    first, *others = scene.bodies
    return replace(scene, bodies=(replace(first, **changes), *others))


def test_all_bodies_of_a_database_are_at_one_place_with_one_radiation() -> None:
    scene = two_barges(uncoupled(), "none", 10.0)
    text = "two barges, far apart has 2 bodies, and those of the scene at location"
    here = f"{text} [0, 0], heading 0 deg, are"
    assert f"{here} 1 (low), 1 (high); expected each of 1 to 2 once" in " ".join(
        refused(changed(scene, database_body=1))
        .replace("1 (high), 1 (low)", "1 (low), 1 (high)")
        .split()
    )
    turned, moved = changed(scene, heading=np.pi / 2), changed(scene, location=(5.0, 0.0))
    assert f"{text} [0, 0], heading 90 deg, are 2 (high)" in refused(turned)
    assert f"{text} [5, 0], heading 0 deg, are 2 (high)" in refused(moved)
    alone = replace(scene, bodies=scene.bodies[1:], forces={})
    assert f"{here} 1 (low)" in refused(alone)
    assert "3 (high)" in refused(changed(scene, database_body=3))
    models = refused(changed(scene, radiation="convolution"))
    assert "found convolution and none for bodies of one database" in models


@pytest.mark.slow
def test_two_pairs_may_share_a_database() -> None:
    scene = two_barges(uncoupled(), "none", 10.0)
    there = [replace(b, name=f"far_{b.name}", location=(500.0, 0.0)) for b in scene.bodies]
    model = hs.compile_scene(replace(scene, bodies=(*scene.bodies, *there))).model
    assert np.array_equal(model.added_mass[:12, :12], model.added_mass[12:, 12:])


@pytest.mark.slow
def test_a_held_body_does_not_move_and_leaves_the_state() -> None:
    scene = two_barges(uncoupled(), "state_space", 20.0)
    held = changed(scene, dofs=())
    low = {k: e for k, e in scene.forces.items() if e.body == "low"}
    run = hs.simulate(replace(held, forces=low))
    free = hs.simulate(scene)
    assert not run.position.sel(body="high").any()
    assert np.abs(run.position - free.position).sel(body="low").max() < 1e-9
    assert run.sizes["state"] < free.sizes["state"]
    none = tuple(replace(b, dofs=()) for b in held.bodies)
    assert "found no degree of freedom" in refused(replace(held, bodies=none))


def states(run: xr.Dataset) -> list[str]:
    return [str(name) for name in run.state.values]
