"""How long memories are: as long as is asked for, if frequencies resolve that.

The barges of `tests/data/draughts` have frequencies 0.1 rad/s apart, which resolve 31.4 s.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import hydrosim as hs
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.compile.compile import compile_for_linear
from hydrosim.compile.compiled import Compiled
from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup
from hydrosim.database import HydroDatabase, load
from hydrosim.database.kernels import kernels
from hydrosim.scene import (
    AtDraught,
    AutomaticRadiation,
    ConvolutionRadiation,
    Family,
    Method,
    Radiation,
)

TESTS = Path(__file__).parents[1]
DATA = TESTS / "data" / "draughts"
CASE = f"""
title: one barge
duration: 5 s
environment: {{water_depth: infinite}}
bodies:
  barge:
    hydrodynamics: {DATA}/4m4.nc
    hydrostatics: {{recipe: {DATA}/barge.yaml, depth: 8 m}}
    weight: carried
    mass: 5412 tonne
    centre_of_gravity: [0 m, 0 m, -0.4 m]
    radii_of_gyration: [7 m, 16 m, 16 m]
    dofs: [heave]
"""
RECIPE = f"""
extends: {DATA}/barge.yaml
hull: {{draught: 4.4 m}}
"""

pytestmark = pytest.mark.filterwarnings("ignore")  # of coarse databases


def thinned(path: Path) -> HydroDatabase:
    """A database of every second frequency, 0.2 rad/s apart: they resolve 15.7 s."""
    db = load(path)
    names = ("frequency", "added_mass", "radiation_damping", "excitation")
    known: dict[str, Any] = {name: getattr(db, name)[1::2] for name in names}
    rest = ("froude_krylov", "mean_drift", "mean_drift_held", "drift_imbalance")
    return replace(db, **known, **dict.fromkeys(rest))


@pytest.fixture
def one(tmp_path: Path) -> hs.Scene:
    (tmp_path / "barge.yaml").write_text(RECIPE)
    (tmp_path / "case.yaml").write_text(CASE.replace(f"{DATA}/barge.yaml", "barge.yaml"))
    return hs.load_case(tmp_path / "case.yaml").scene()


def with_body(scene: hs.Scene, **changes: Any) -> hs.Scene:
    """The scene with other values of its body."""
    return replace(scene, bodies=(replace(scene.bodies[0], **changes),))


def family(scene: hs.Scene, **changes: Any) -> hs.Scene:
    """The barge with a family whose upper draught has half the frequencies."""
    members = AtDraught(4.4, DATA / "4m4.nc"), AtDraught(3.6, thinned(DATA / "3m6.nc"))
    return with_body(scene, hydrodynamics=Family(members), **changes)


def ends(compiled: Compiled) -> list[float]:
    """Of the memories of all databases, members of families included [s]."""
    groups: list[HydrodynamicGroup] = [one for wet in compiled.wet for one in wet.members or (wet,)]
    return [float(group.memory.time[-1]) for group in groups]


@pytest.mark.parametrize("radiation", ["automatic", "state_space", "convolution", "none"])
def test_without_a_length_memories_end_where_frequencies_resolve_no_more(one, radiation):
    compiled = hs.compile_scene(with_body(one, radiation=radiation))
    assert ends(compiled) == pytest.approx([31.4])
    assert not [text for text in compiled.notes.warnings if "length" in text]
    if radiation == "convolution":
        assert len(compiled.model.convolution.K) == 315
    if radiation != "none":
        (errors,) = compiled.memory_errors
        assert errors.length == pytest.approx(31.4)
        assert "frequencies 0.1 rad/s apart resolve 31.4 s" in str(errors)


def test_each_member_of_a_family_remembers_what_its_frequencies_resolve(one: hs.Scene) -> None:
    compiled = hs.compile_scene(family(one))
    assert ends(compiled) == pytest.approx([15.7, 31.4])
    assert ends(compile_for_linear(family(one))) == pytest.approx([15.7, 31.4])
    assert not [text for text in compiled.notes.warnings if "length" in text]


@pytest.mark.parametrize("radiation", [AutomaticRadiation, ConvolutionRadiation])
def test_a_length_that_is_not_resolved_is_cut_and_told(one: hs.Scene, radiation: Any) -> None:
    chosen: Radiation = radiation(length=40.0)
    scene = with_body(one, radiation=chosen)
    compiled = hs.compile_scene(scene)
    assert ends(compiled) == pytest.approx([31.4])
    (said,) = [text for text in compiled.notes.warnings if "length" in text]
    assert said.startswith("bodies.barge.radiation.length: found 40 s")
    assert "0.1 rad/s apart and resolve 31.4 s" in said
    assert said in linear_analysis(scene, LinearRequest()).attrs["remarks"]


def test_the_members_that_do_not_resolve_a_length_are_told(one: hs.Scene) -> None:
    compiled = hs.compile_scene(family(one, radiation=AutomaticRadiation(length=20.0)))
    assert ends(compiled) == pytest.approx([15.7, 20.0])
    (said,) = [text for text in compiled.notes.warnings if "radiation.length" in text]
    assert "resolve 15.7 s" in said


def test_a_length_that_is_resolved_is_taken(one: hs.Scene) -> None:
    compiled = hs.compile_scene(with_body(one, radiation=ConvolutionRadiation(length=30.0)))
    assert ends(compiled) == [30.0]
    assert not [text for text in compiled.notes.warnings if "length" in text]


def test_convolutions_of_different_lengths_run_together(one: hs.Scene) -> None:
    """After the end of the shorter memory its kernel is zero."""
    near = replace(one.bodies[0], radiation=ConvolutionRadiation(), position=(0, 0, 0.1, 0, 0, 0))
    far: hs.Body = replace(near, name="far", hydrodynamics=thinned(DATA / "4m4.nc"))
    bodies = (near, replace(far, location=(500.0, 0.0)))
    pair = replace(one, bodies=bodies, solver=hs.Solver(Method.RK4, 0.1))  # steps of equal length
    compiled = hs.compile_scene(pair)
    assert ends(compiled) == pytest.approx([31.4, 15.7])
    kernel = compiled.model.convolution
    assert len(kernel.K) == 315
    late = kernel.K[158:, kernel.row == 8]
    assert_array_equal(late, np.zeros_like(late))
    both = hs.simulate(pair)
    for body in pair.bodies:
        alone = hs.simulate(replace(pair, bodies=(body,)))
        moved = both.position.sel(body=body.name) - alone.position.sel(body=body.name)
        assert abs(moved).max() < 1e-9


def test_a_table_of_kernels_tells_where_the_echo_begins() -> None:
    db = load(DATA / "4m.nc")
    assert "resolve 31.4 s: later values are an echo" in kernels(db, 40.0, 0.1)[2]
    assert "echo" not in kernels(db, 30.0, 0.1)[2]


@pytest.mark.slow
def test_the_fits_of_the_barge_at_three_draughts_hold_their_tolerance() -> None:
    case = TESTS.parent / "cases" / "topside_removal" / "tanks.yaml"
    compiled = hs.compile_scene(hs.load_case(case).scene())
    assert ends(compiled) == pytest.approx([78.5, 78.5, 100.0])
    for member in compiled.wet[0].members:
        assert all(fit.report.holds for fit in member.fits)
        assert all(fit.order < 130 for fit in member.fits)
