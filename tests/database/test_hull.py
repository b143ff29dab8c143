"""Closed hulls from mesh files and recipes: what is read, what is refused."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hydrosim.database.build.barge import box, hydrostatics
from hydrosim.database.build.recipe import barge_with_deck, hull_of_recipe
from hydrosim.database.hull import close_hull, immersed_triangles, integrals, read_hull
from hydrosim.errors import InputError
from hydrosim.files.quantities import MeshKeys

meshio = pytest.importorskip("meshio")
DATABASES = Path(__file__).parents[2] / "hydro_db"
SHAPE = box(100.0, 30.0, 8.0)
FACES = barge_with_deck(SHAPE, 12.0)


def write(path: Path, corners: np.ndarray) -> Path:
    points = corners.reshape(-1, 3)
    cells = [("triangle", np.arange(len(points)).reshape(-1, 3))]
    meshio.write_points_cells(path, points, cells)
    return path


@pytest.mark.parametrize("form", [".stl", ".obj", ".ply"])
def test_a_mesh_file_has_the_hydrostatics_of_its_hull(tmp_path: Path, form: str) -> None:
    """In millimetres above the keel; binary files have single precision."""
    path = write(tmp_path / f"hull{form}", (FACES + np.array([0.0, 0.0, 8.0])) * 1000.0)
    found, exact = (
        integrals(immersed_triangles(read_hull(path, MeshKeys(scale=1e-3, waterline=8.0)).corners)),
        hydrostatics(SHAPE),
    )
    assert_allclose(found.stiffness(-2.0, 1.0, 1.0), exact.stiffness(-2.0, 1.0, 1.0), atol=1.0)
    assert_allclose([found.volume, found.area], [exact.volume, exact.area], rtol=1e-6)


def test_axes_and_offset_place_a_mesh(tmp_path: Path) -> None:
    """From a file with y to starboard, z down, and its origin at the stern and keel."""
    stern = np.array([50.0, 0.0, 8.0])
    path = write(tmp_path / "hull.ply", (FACES + stern) * [1.0, -1.0, -1.0])
    keys = MeshKeys(axes=("x", "-y", "-z"), offset=(-50.0, 0.0, 0.0), waterline=8.0)
    found = integrals(immersed_triangles(read_hull(path, keys).corners))
    exact = integrals(immersed_triangles(FACES))
    assert_allclose(found.centre_of_buoyancy, exact.centre_of_buoyancy, atol=1e-9)
    assert_allclose(found.stiffness(0.0, 1.0, 1.0), exact.stiffness(0.0, 1.0, 1.0), atol=1e-6)
    path = write(tmp_path / "turned.ply", FACES[..., [2, 0, 1]])
    turned = read_hull(path, MeshKeys(axes=("y", "z", "x"))).corners
    assert_allclose(np.sort(turned, axis=0), np.sort(FACES, axis=0), atol=1e-12)


@pytest.mark.parametrize("axes", [("x", "y", "-z"), ("x", "x", "z")])
def test_axes_that_mirror_or_flatten_a_hull_are_refused(axes: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match=r"such as \[x, -y, -z\] for z down"):
        MeshKeys(axes=axes)


def test_normals_that_point_inwards_are_turned() -> None:
    assert integrals(immersed_triangles(close_hull(FACES[:, ::-1], "hull").corners)).volume > 0.0


def test_open_meshes_are_refused(tmp_path: Path) -> None:
    upper = FACES[..., 2].min(axis=1) > 3.9
    with pytest.raises(InputError, match=r"hull.stl: found an open mesh.*Close the mesh"):
        read_hull(write(tmp_path / "hull.stl", FACES[~upper]))
    turned = FACES.copy()
    turned[0] = turned[0, ::-1]
    with pytest.raises(InputError, match="all normals outward"):
        close_hull(turned, "hull")


def test_a_hull_out_of_the_water_is_refused() -> None:
    with pytest.raises(InputError, match=r"from 2 to 14 m above .* lifted by initial\.position"):
        close_hull(FACES + np.array([0.0, 0.0, 10.0]), "hull")


def test_a_file_that_is_no_mesh_is_refused(tmp_path: Path) -> None:
    (tmp_path / "hull.stl").write_text("nothing")
    with pytest.raises(InputError, match=r"cannot be read as a mesh|has no panels"):
        read_hull(tmp_path / "hull.stl")
    with pytest.raises(InputError, match="no such file"):
        read_hull(tmp_path / "none.stl")


VTK = "# vtk DataFile Version 3.0\n\nASCII\nDATASET {}\nPOINTS 3 float\n"


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("hull.vtk", VTK.format("POLYDATA"), "not POLYDATA"),
        ("hull.vtk", "nothing", "Illegal VTK header"),
        ("hull.vtk", VTK.format("UNSTRUCTURED_GRID") + "0 0 0", "reshape"),
        ("hull.ply", "", "Expected ply"),
        ("hull.msh", "", "concatenate"),
        ("hull.obj", "v 1 2 3\nf 1 2 3\n", "out of bounds"),
        ("hull.xyz", "nothing", "Could not deduce"),
    ],
)
def test_libraries_that_read_meshes_neither_print_nor_end_the_program(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], name: str, content: str, said: str
) -> None:
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(InputError, match=rf"{name}: cannot be read as a mesh \(.*{said}"):
        read_hull(path)
    assert capfd.readouterr() == ("", "")


def test_a_recipe_needs_a_depth_and_a_body() -> None:
    with pytest.raises(InputError, match="expected a barge or a box with a depth"):
        hull_of_recipe(DATABASES / "h851.yaml")
    with pytest.raises(InputError, match="has 1 bodies; expected body 2"):
        hull_of_recipe(DATABASES / "h851.yaml", 2, 15.0)
    with pytest.raises(InputError, match="its hull is a sphere"):
        hull_of_recipe(DATABASES / "sphere.yaml", depth=15.0)


def test_a_placed_hull_of_a_recipe_is_where_its_database_has_it() -> None:
    """The frame stays where it is on the hull, whatever the draught."""
    recipes = ("h851.yaml", "h851_10m2.yaml")
    one, other = (hull_of_recipe(DATABASES / name, depth=15.0) for name in recipes)
    assert_allclose(one.corners[..., :2], other.corners[..., :2], atol=1e-6)
    assert_allclose(one.corners[..., 2].min(), -12.4)
    assert_allclose(other.corners[..., 2].min(), -10.2)
