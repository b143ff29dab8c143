"""What docs/limits.md calls refused is refused, and says what there is instead."""

import itertools
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import yaml

import hydrosim as hs
from hydrosim.errors import InputError

ROOT = Path(__file__).parents[2]
LINE = {"type": "spring", "body": "barge", "point": [0, 0, 0], "anchor": [99, 0, 0], "length": 90}


def case() -> dict[str, Any]:
    """A barge afloat."""
    barge = {"hydrodynamics": str(ROOT / "hydro_db" / "box.nc"), "mass": "10250 tonne"}
    barge |= {"centre_of_gravity": [0, 0, 0], "radii_of_gyration": [7, 26, 26]}
    water = {"water_depth": "infinite"}
    return {"title": "Barge", "duration": 60, "environment": water, "bodies": {"barge": barge}}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("forces.pto", {**LINE, "type": "power_take_off", "damping": 1e5, "force_limit": 1e6}),
        ("forces.brace", {"type": "morison", "body": "barge"}),
        ("environment.wind", {"speed": 20, "heading": 0, "spectrum": "npd"}),
        ("environment.wind", {"speed": {"time": [0, 1], "speed": [0, 9]}, "heading": 0}),
        ("environment.current", {"speed": [1, 0.5], "heading": 0}),
        ("forces.keels", {"type": "viscous_roll", "body": "barge", "bilge_keels": 0.4}),
        ("bodies.barge.speed", 5),
        ("bodies.barge.dofs", ["surge", "bending"]),
    ],
)
def test_what_is_not_there_is_refused(tmp_path: Path, key: str, value: object) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(yaml.safe_dump(_with(case(), key, value)))
    with pytest.raises(InputError, match=r"case\.yaml:\d+: .*expected"):
        hs.load_case(path)


def test_the_barge_alone_is_taken(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(yaml.safe_dump(case()))
    assert hs.load_case(path).scene().bodies


@pytest.mark.parametrize(("heave", "displaced"), [(12.0, 0.0), (-10.0, 64.0)])
def test_a_load_with_a_hull_hangs_in_air_and_under_water(
    tmp_path: Path, heave: float, displaced: float
) -> None:
    """A cube of 4 m on a wire, lifted by `initial`: weight less that of the water, closed form."""
    corners = np.array(list(itertools.product((-2.0, 2.0), repeat=3)))
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    meshio.write(tmp_path / "load.obj", meshio.Mesh(corners, [("quad", np.array(faces))]))
    load = {"mass": 1e5, "weight": "carried", "centre_of_gravity": [0, 0, 0], "dofs": ["heave"]}
    load |= {"radii_of_gyration": [1.6, 1.6, 1.6], "hydrostatics": {"mesh": "load.obj"}}
    load |= {"initial": {"position": {"heave": heave}}}
    wire = {"type": "spring", "body": "load", "point": [0, 0, 2], "anchor": [0, 0, 34]}
    wire |= {"length": 32.0 - heave, "stiffness": 1e8}
    water = {"water_depth": "infinite", "water_density": 1025.0, "gravity": 9.81}
    data = {"title": "Load", "duration": 1, "initial": "at_rest", "environment": water}
    data |= {"solver": {"method": "rk4", "step": 0.01}}
    data |= {"bodies": {"load": load}, "forces": {"wire": wire}}
    path = tmp_path / "case.yaml"
    path.write_text(yaml.safe_dump(data))
    run = hs.simulate(hs.load_case(path))
    expected = 9.81 * (1e5 - 1025.0 * displaced)
    np.testing.assert_allclose(run.spring_tension, expected, rtol=1e-6)
    assert "load: buoyancy of its hull in still water, no waves, drag" in run.attrs["skipped"]


def _with(data: dict[str, Any], key: str, value: object) -> dict[str, Any]:
    """The case with a value at a key."""
    *folders, last = key.split(".")
    inner = data
    for name in folders:
        inner = inner.setdefault(name, {})
    inner[last] = value
    return data
