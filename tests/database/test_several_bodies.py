"""Recipes of several bodies, and of one that is placed and turned."""

from pathlib import Path

import numpy as np
import pytest

from hydrosim.database import HydroDatabase
from hydrosim.errors import InputError

pytest.importorskip("capytaine", reason="capytaine is not installed (pip install .[bem])")

from hydrosim.database.build import bem, mesh, second_order
from hydrosim.database.build.afloat import hulls_afloat
from hydrosim.database.build.build import build
from hydrosim.database.build.drift import Water, mean_drift
from hydrosim.database.build.recipe import load_recipe
from hydrosim.database.netcdf import read

pytestmark = pytest.mark.bem
HYDRO_DB = Path(__file__).parents[2] / "hydro_db"

BODY = """\
    hull: {{type: box, length: 40 m, beam: 10 m, draught: 3 m, panels: {panels} m}}
    position: [{x} m, {y} m]
    heading: {heading} deg
    centre_of_gravity: [0, 0, 0.5 m]
    radii_of_gyration: [3.5 m, 10.4 m, 10.5 m]
"""
RECIPE = """\
title: Some boxes
frequencies: [0.9]
headings: [0 deg, 60 deg, 90 deg, 120 deg, 150 deg, 180 deg, 270 deg]
bodies:
{bodies}"""


def boxes(folder: Path, *places: tuple[float, float, float], panels: float = 4.0) -> Path:
    """A recipe of boxes at (x, y, heading)."""
    texts = [BODY.format(x=x, y=y, heading=turn, panels=panels) for x, y, turn in places]
    named = (f"  number_{i}:\n{text}" for i, text in enumerate(texts))
    path = folder / "boxes.yaml"
    path.write_text(RECIPE.format(bodies="".join(named)))
    return path


def built(*given: object, settings: tuple[str, ...] = (), **more: float) -> HydroDatabase:
    return build(load_recipe(boxes(*given, **more), settings))


def close(one: np.ndarray, other: np.ndarray, error: float = 1e-5) -> None:
    """Forces and moments by turns of three: relative to the largest of their kind."""
    size = np.abs(other).reshape(-1, other.shape[-1]).max(axis=0)
    size = np.repeat(size.reshape(-1, 3).max(axis=1), 3)
    assert (np.abs(one - other) <= error * size).all()


@pytest.mark.parametrize(
    ("place", "gap"), [((0.0, 12.0, 0.0), 2.0), ((43.0, 1.3, 0.0), 3.0), ((26.5, 0.0, 90.0), 1.5)]
)
def test_the_gap_between_two_hulls_is_measured(tmp_path, place, gap):
    """Beside, ahead and across; panels of 4 m at most, near the edges half as long."""
    floats = hulls_afloat(load_recipe(boxes(tmp_path, (0.0, 0.0, 0.0), place)))
    owner = np.array(floats.hull.owner)
    found, widest = mesh.narrowest_gap(*(floats.panels[owner == number] for number in (0, 1)))
    assert found == pytest.approx(gap, rel=0.05)
    assert all(1.0 < size <= 4.0 for size in widest)


def test_panels_wider_than_a_gap_are_told_at_build(tmp_path, recwarn):
    places = (0.0, 0.0, 0.0), (0.0, 13.0, 0.0)
    with pytest.warns(UserWarning, match="panels of 3.54 m on number_0 and 3.54 m on number_1 at"):
        built(tmp_path, *places)
    recwarn.clear()
    built(tmp_path, *places, panels=2.5)
    assert [str(warning.message) for warning in recwarn] == []


def test_placed_and_turned(tmp_path):
    """Axes and phases of a body are turned and moved with it."""
    here = built(tmp_path, (0.0, 0.0, 0.0))
    there = built(tmp_path, (30.0, -7.0, 90.0))
    turn = np.kron(np.eye(2), [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for name in ("added_mass", "radiation_damping", "hydrostatic_stiffness", "inertia_matrix"):
        close(getattr(there, name), turn @ getattr(here, name) @ turn.T)
    np.testing.assert_allclose(there.centre_of_gravity, [[30.0, -7.0, 0.5]], atol=1e-12)
    np.testing.assert_allclose(there.centre_of_buoyancy, [[30.0, -7.0, -1.5]], atol=1e-12)
    k = 0.9**2 / 9.81
    for before, after in ((0, 90), (60, 150), (90, 180), (180, 270)):
        i, j = (int(np.argmin(np.abs(np.degrees(here.heading) - b))) for b in (before, after))
        b = np.radians(after)
        phase = np.exp(-1j * k * (30.0 * np.cos(b) - 7.0 * np.sin(b)))
        for name in ("excitation", "froude_krylov"):
            close(getattr(there, name)[:, j], phase * getattr(here, name)[:, i] @ turn.T)


@pytest.mark.parametrize(
    ("places", "alike"),
    [(((0.0, 7.0, 0.0), (0.0, -7.0, 0.0)), False), (((25.0, 0.0, 0.0), (-25.0, 0.0, 0.0)), True)],
)
def test_halves_are_the_whole(tmp_path, places, alike):
    """Side by side one is the other's mirror image, in line each is its own."""
    half, whole = built(tmp_path, *places), built(tmp_path, *places, settings=("symmetry=none",))
    assert hulls_afloat(load_recipe(boxes(tmp_path, *places))).hull.symmetric
    assert half.port_starboard_symmetric is alike
    assert not whole.port_starboard_symmetric
    for name in ("added_mass", "radiation_damping", "excitation", "froude_krylov"):
        close(getattr(half, name), getattr(whole, name))


def test_bodies_are_in_the_order_of_the_recipe(tmp_path):
    """Reciprocity and the mirror image: what one barge feels of the other's motion."""
    db = built(tmp_path, (0.0, 7.0, 0.0), (0.0, -7.0, 0.0))
    sign = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    A = db.added_mass[0]
    close(A[:6, :6], np.outer(sign, sign) * A[6:, 6:])
    close(A[:6, 6:], np.outer(sign, sign) * A[6:, :6])
    assert np.abs(A[:6, 6:]).max() > 0.1 * np.abs(A[:6, :6]).max()
    np.testing.assert_allclose(db.centre_of_gravity[:, 1], [7.0, -7.0])
    head = db.excitation[0, 0]
    close(head[None, :6], (sign * head[6:])[None])


def test_the_two_barges_are_made_of_their_recipe():
    """In the gap's resonance, with half of the loads by Haskind's relation."""
    recipe = load_recipe(HYDRO_DB / "two_barges.yaml")
    shipped = read(HYDRO_DB / "two_barges.nc")
    np.testing.assert_allclose(recipe.frequencies, shipped.frequency, rtol=1e-14)
    np.testing.assert_allclose(recipe.headings, shipped.heading, rtol=1e-14)
    db = build(load_recipe(HYDRO_DB / "two_barges.yaml", ["frequencies=[1.3]"]))
    row = int(np.argmin(np.abs(shipped.frequency - 1.3)))
    for name in ("added_mass", "radiation_damping", "excitation"):
        close(getattr(db, name)[0], getattr(shipped, name)[row], 1e-9)
    for name in ("added_mass_infinite", "hydrostatic_stiffness", "inertia_matrix"):
        close(getattr(db, name), getattr(shipped, name), 1e-9)
    np.testing.assert_allclose(db.centre_of_buoyancy, shipped.centre_of_buoyancy)


def test_drift_of_each_adds_up_to_that_of_all(tmp_path):
    """By pressures on these few panels the surge and sway of both are within 15 per cent of the far
    field's, and are brought to it; barges that are each other's image attract or repel each other
    alike."""
    beside = load_recipe(boxes(tmp_path, (0.0, 7.0, 0.0), (0.0, -7.0, 0.0), panels=2.5))
    water, headings = Water(), np.radians([0.0, 30.0, 90.0])
    floats = hulls_afloat(beside)
    solution = bem.solve(floats.hull, water, 1.2, headings)
    near = second_order._near_field_drifts(floats.hull, None, water, 1.2, headings)
    far = mean_drift(solution.kochin_diffraction, 1.2, headings, water).force
    both = near.reshape(3, 2, 6).sum(axis=1)
    largest = np.abs(far[:, :2]).max()
    assert np.abs(both - far)[:, :2].max() < 0.15 * largest
    found = second_order.brought_to(near, far).reshape(3, 2, 6)
    np.testing.assert_allclose(found.sum(axis=1)[:, :2], far[:, :2], atol=1e-9 * largest)
    np.testing.assert_allclose(
        found[0, 0], found[0, 1] * [1, -1, 1, -1, 1, -1], atol=0.01 * largest
    )
    assert abs(found[0, 0, 1]) > 0.05 * largest


def test_drift_in_a_recipe(tmp_path):
    """Free and held, of two in line; of waves from astern the one astern takes more."""
    places = (25.0, 0.0, 0.0), (-25.0, 0.0, 0.0)
    settings = ("drift=[free, held]", "headings=[0 deg, 90 deg]", "frequencies=[1.2]")
    db = built(tmp_path, *places, settings=settings)
    held = db.mean_drift_held
    assert db.mean_drift.shape == held.shape == (1, 2, 12)
    assert held[0, 0, 6] > held[0, 0, 0] > 0.0
    np.testing.assert_allclose(held[0, 1, 1], held[0, 1, 7], rtol=1e-3)


@pytest.mark.parametrize(
    ("places", "setting", "said"),
    [
        (((0, 4, 0), (0, -4, 0)), "lid=auto", "number_1.position: found panels inside number_0"),
        (((0, 4, 0), (0, 4, 0)), "lid=auto", "found panels inside number_0"),
        (((0, 7, 0), (0, -7, 0)), "bodies.number_1.hull.length=0", "it must be above 0"),
        (((0, 7, 0),), "far_field={share: 0.5, rising: [0.3, 0.6]}", "all round the circle"),
    ],
)
def test_messages(tmp_path, places, setting, said):
    with pytest.raises(InputError, match=said):
        hulls_afloat(load_recipe(boxes(tmp_path, *places), [setting]))


@pytest.mark.parametrize(
    "hull", ["box, length: 100 m, beam: 20 m, draught: 5 m", "sphere, radius: 5 m"]
)
def test_panels_by_default(tmp_path, hull):
    """Some 1,800 on the whole hull, whatever its size."""
    path = tmp_path / "hull.yaml"
    path.write_text(
        f"title: A hull\nhull: {{type: {hull}}}\ncentre_of_gravity: [0, 0, 0]\n"
        "radii_of_gyration: [1, 1, 1]\nfrequencies: [1.0]\nheadings: [0]\n"
    )
    assert 1200 < len(hulls_afloat(load_recipe(path)).panels) < 2400
