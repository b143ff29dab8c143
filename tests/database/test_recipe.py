"""Recipes: what they say, and what is said about wrong ones."""

from pathlib import Path

import numpy as np
import pytest

from hydrosim.database.build import barge
from hydrosim.database.build.drift import Drifting
from hydrosim.database.build.recipe import Lid, load_recipe
from hydrosim.errors import InputError

HYDRO_DB = Path(__file__).parents[2] / "hydro_db"

BOX = """\
title: A box
hull: {type: box, length: 100 m, beam: 2000 cm, draught: 5, panels: 5 m}
centre_of_gravity: [0, 0, 1 m]
radii_of_gyration: [7 m, 26 m, 26 m]
frequencies: {start: 0.1 rad/s, stop: 1 rad/s, step: 0.1 rad/s}
headings: [0 deg, 90 deg]
"""
BARGE = """\
title: A barge
hull:
  type: barge
  length: 260 m
  beam: 63 m
  draught: 12.4 m
  bow_beam: 42 m
  bow_length: 100 m
  stern_length: 51.23 m
  wall_depth: 2.4 m
  rake_length: 19 m
  panels: 6 m
centre_of_gravity: [0, 0, -4.9 m]
radii_of_gyration: [22 m, 67 m, 69 m]
frequencies: [0.5, 0.6]
headings: [0, 90 deg]
"""
QTF = "title: A box\nqtf: {{headings: [0 deg, {} deg], frequencies: [{}]}}"


def written(folder: Path, text: str) -> Path:
    path = folder / "recipe.yaml"
    path.write_text(text)
    return path


def test_units_steps_and_defaults(tmp_path):
    recipe = load_recipe(written(tmp_path, BOX))
    assert (recipe.data.hull.length, recipe.data.hull.beam) == (100.0, 20.0)
    assert recipe.data.frequencies == (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
    np.testing.assert_allclose(recipe.headings, [0.0, np.pi / 2], rtol=1e-15)
    assert np.isinf(recipe.data.water.depth)
    assert recipe.data.lid is Lid.AUTO
    assert recipe.data.drift == (Drifting.FREE, Drifting.HELD)


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ("type: box", "type: boat", 2, "expected one of: barge, box, sphere, mesh"),
        ("length: 100 m", "length: 100 kg", 2, 'found "100 kg"; expected a length'),
        ("length: 100 m", "lenght: 100 m", 2, 'did you mean "length"?'),
        ("panels: 5 m", "panels: -5 m", 2, "it must be above 0"),
        ("panels: 5 m", "panels: {along: [1, 2]}", 2, "found a list of 2; expected"),
        ("stop: 1 rad/s", "stop: 0.95 rad/s", 5, "step 0.1, which are 8.5 steps; expected a whole"),
        ("step: 0.1 rad/s", "step: 1e-9 rad/s", 5, "steps from start to stop, at most 999"),
        ("start: 0.1 rad/s", "start: 0 rad/s", 5, "it must be above 0"),
        ("start: 0.1 rad/s", "start: 0.1 Hz", 5, "another kind of quantity"),
        ("[0 deg, 90 deg]", "[90 deg, 0 deg]", 6, "values that rise"),
        ("[0 deg, 90 deg]", "[0 deg, 0.7 deg]", 6, "multiples of half a degree"),
        ("[0 deg, 90 deg]", "[]", 6, "expected one or more"),
        ("radii_of_gyration: [7 m, 26 m, 26 m]\n", "", 1, "radii_of_gyration or inertia"),
        ("title: A box", "title: A box\ndrift: [fixed]", 2, "expected one of: free, held"),
        ("title: A box", "title: A box\nwater: {depth: -3 m}", 2, "it must be above 0"),
        ("title: A box", QTF.format(45, 0.5), 1, "qtf for 45 deg; expected one of `headings`"),
        ("title: A box", QTF.format(90, 1.5), 1, "qtf from 1.5 to 1.5 rad/s; expected `freq"),
        ("title: A box", QTF.format(90, 0.5) + "\ndrift: [held]", 1, "expected drift: [free]"),
        ("title: A box", QTF.format(90, 0.5) + "\nwater: {depth: 9 m}", 1, "qtf in 9 m of water"),
        ("title: A box", QTF.format(90, 0.5) + "\nmethod: direct", 1, "expected method: indirect"),
        ("title: A box", "title: A box\nqtf: {headings: [0]}", 2, "frequencies"),
    ],
)
def test_messages_for_a_box(tmp_path, old, new, line, said):
    path = written(tmp_path, BOX.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_recipe(path)
    assert f"{path}:{line}: " in str(caught.value)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("stern_length: 51.23 m", "heave_stiffness: 300 kN/m", "corners of the hull"),
        ("stern_length: 51.23 m", "rake_length: 19 m\n  stern_length: 19 m", "twice"),
        ("  stern_length: 51.23 m\n", "", "stern_length or heave_stiffness"),
        ("stern_length: 51.23 m", "stern_length: 19 m", "six different positions"),
        ("wall_depth: 2.4 m", "wall_depth: 24 m", "the draught at most"),
        ("bow_length: 100 m", "bow_length: 300 m", "corners of the hull"),
    ],
)
def test_messages_for_a_barge(tmp_path, old, new, said):
    with pytest.raises(InputError, match=said):
        load_recipe(written(tmp_path, BARGE.replace(old, new)))


def test_every_recipe_here_is_right():
    """And the barge's full beam is as long as the heave stiffness asks for."""
    recipes = {path.stem: load_recipe(path) for path in HYDRO_DB.glob("*.yaml")}
    assert {"h851", "h851_50m", "box"} <= recipes.keys()
    deep, shallow = recipes["h851"].data, recipes["h851_50m"].data
    shape = deep.hull.shape(deep.water)
    assert shape.stern_length == pytest.approx(51.230, abs=5e-4)
    stiffness = barge.hydrostatics(shape).stiffness(0.0, 1025.0, 9.81)[2, 2]
    assert stiffness == pytest.approx(132_105e3, rel=1e-12)
    assert shallow.hull.shape(shallow.water) == shape
    assert (deep.water.depth, shallow.water.depth) == (np.inf, 50.0)
