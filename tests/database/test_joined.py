"""Recipes of bodies above or within each other, and submerged hulls."""

from pathlib import Path

import numpy as np
import pytest
from markers import few

pytest.importorskip("capytaine", reason="capytaine is not installed (pip install .[bem])")

from hydrosim.database.build import mesh
from hydrosim.database.build.afloat import floating, hulls_afloat
from hydrosim.database.build.build import build
from hydrosim.database.build.drift import Water
from hydrosim.database.build.recipe import load_recipe
from hydrosim.database.netcdf import read
from hydrosim.errors import InputError
from hydrosim.files.quantities import MeshKeys

pytestmark = pytest.mark.bem
HYDRO_DB = Path(__file__).parents[2] / "hydro_db"


OF_CASES = ("flap", "point_absorber", "hinged_barges")


@pytest.mark.parametrize("name", OF_CASES)
def test_databases_of_the_cases_have_the_grids_of_their_recipes(name):
    recipe = load_recipe(HYDRO_DB / f"{name}.yaml")
    shipped = read(HYDRO_DB / f"{name}.nc")
    np.testing.assert_allclose(recipe.frequencies, shipped.frequency, rtol=1e-14)
    np.testing.assert_allclose(recipe.headings, shipped.heading, rtol=1e-14)


@pytest.mark.parametrize("name", few(OF_CASES, 2))
def test_databases_of_the_cases_are_made_of_their_recipes(name):
    shipped = read(HYDRO_DB / f"{name}.nc")
    db = build(load_recipe(HYDRO_DB / f"{name}.yaml", ["frequencies=[1]"]))
    row = int(np.argmin(np.abs(shipped.frequency - 1.0)))
    for field in ("added_mass", "radiation_damping", "excitation"):
        one, other = getattr(db, field)[0], getattr(shipped, field)[row]
        assert np.abs(one - other).max() < 1e-9 * np.abs(other).max()
    for field in ("added_mass_infinite", "hydrostatic_stiffness", "inertia_matrix"):
        one, other = getattr(db, field), getattr(shipped, field)
        assert np.abs(one - other).max() < 1e-9 * np.abs(other).max()


def test_a_float_above_a_submerged_spar():
    """Closed forms of polygons of 32 and 24 sides; the submerged spar has no waterplane at all."""
    recipe = load_recipe(HYDRO_DB / "point_absorber.yaml")
    floats = hulls_afloat(recipe)
    assert floats.hull.symmetric
    disc, column = (0.5 * n * np.sin(2.0 * np.pi / n) for n in (32, 24))
    volume = [36.0 * 2.0 * disc + 0.36 * 2.5 * disc, 4.0 * 24.0 * column + 25.0 * column]
    body = floating(recipe, floats, Water())
    np.testing.assert_allclose(body.volume, volume, rtol=1e-5)
    heave = np.diag(body.stiffness)[[2, 8]]
    np.testing.assert_allclose(heave, [1025.0 * 9.81 * 36.0 * disc, 0.0], rtol=1e-5)


def test_windings_tell_inside_from_outside():
    """Of the float: inside, in the air above (its image in the water), beside, below and away."""
    panels = mesh.read_panels(HYDRO_DB / "float.obj", MeshKeys())
    points = np.array(
        [[1, 2, -1], [0, 0, -4], [1, 2, 1], [0, 7, -1], [0, 1, -4], [0, 0, -20], [90, 0, -1]], float
    )
    np.testing.assert_allclose(mesh.windings(panels, points), [1, 1, 1, 0, 0, 0, 0], atol=1e-9)


def test_a_spar_that_reaches_into_its_float_is_refused():
    higher = ("bodies.spar.hull.waterline=-2",)
    with pytest.raises(InputError, match=r"bodies\.spar\.position: found panels inside float"):
        hulls_afloat(load_recipe(HYDRO_DB / "point_absorber.yaml", higher))


def test_a_float_may_be_within_a_ring(tmp_path):
    """Boxes around them overlap, the hulls do not."""
    (tmp_path / "ring.obj").write_text(_ring())
    (tmp_path / "recipe.yaml").write_text(
        "title: A ring round a box\nfrequencies: [1.0]\nheadings: [0]\nbodies:\n"
        "  ring: {hull: {type: mesh, file: ring.obj}, centre_of_gravity: [0, 0, 0],"
        " radii_of_gyration: [3, 3, 4]}\n"
        "  box: {hull: {type: box, length: 2, beam: 2, draught: 4}, centre_of_gravity: [0, 0, 0],"
        " radii_of_gyration: [1, 1, 1]}\n"
    )
    assert len(hulls_afloat(load_recipe(tmp_path / "recipe.yaml")).integrals) == 2
    with pytest.raises(InputError, match="found panels inside ring"):
        hulls_afloat(load_recipe(tmp_path / "recipe.yaml", ("bodies.box.hull.length=5",)))


def _ring() -> str:
    """A square ring, 8 m outside, 4 m inside, from 1 m above the water to 1 m below."""
    corners, faces = [], []
    for half in (4.0, 2.0):
        for z in (-1.0, 1.0):
            corners += [(half * x, half * y, z) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    for k in range(4):
        n = (k + 1) % 4
        faces += [
            (k, n, 4 + n, 4 + k),  # outside
            (8 + n, 8 + k, 12 + k, 12 + n),  # inside
            (n, k, 8 + k, 8 + n),  # bottom
            (4 + k, 4 + n, 12 + n, 12 + k),  # top
        ]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    return "\n".join([*lines, *(f"f {' '.join(str(i + 1) for i in face)}" for face in faces), ""])
