"""Families of databases over the draught: against the database of a draught between two, blends
that swing as fast as they like, the ledger, restart, and what is refused.

The barge is a box, 60 x 20 x 8 m, at 3.6 and 4.4 m; a third database of it is for 4 m.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from scenes import moving

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.compile.clock import compile_clock
from hydrosim.compile.compile import compile_scene
from hydrosim.compile.compiled import Compiled
from hydrosim.database import load
from hydrosim.database.build.barge import box
from hydrosim.database.build.recipe import barge_with_deck
from hydrosim.errors import InputError
from hydrosim.integrate.draught_interpolation import DRAUGHT_CUTOFF, DRAUGHT_STATES
from hydrosim.integrate.dynamics import Work, new_work, stored_energies
from hydrosim.integrate.loop import advance
from hydrosim.integrate.methods import RK4
from hydrosim.integrate.record import new_record
from hydrosim.integrate.state import START_SLOPE, Run, new_run
from hydrosim.linear.equilibrium import equilibrium
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import (
    AtDraught,
    ConvolutionRadiation,
    Family,
    Hull,
    Place,
    Question,
    SecondOrder,
    StateSpaceRadiation,
    Symmetry,
    Weight,
)

DATA = Path(__file__).parents[1] / "data" / "draughts"
FILES = {3.6: DATA / "3m6.nc", 4.0: DATA / "4m.nc", 4.4: DATA / "4m4.nc"}
KG, MASS = 4.0, 1025.0 * 60.0 * 20.0 * 4.0
FAMILY = Family((AtDraught(4.4, FILES[4.4]), AtDraught(3.6, FILES[3.6])))
ALONE = FILES[4.0]

pytestmark = pytest.mark.filterwarnings("ignore")  # of coarse databases


def barge(source: Any, draught: float, heave: float = 0.0, **changes: Any) -> hs.Body:
    """The barge with the mass of 4 m, ``heave`` above a ``draught``, in the frame of that."""
    hull = Hull(barge_with_deck(box(60.0, 20.0, draught), 8.0))
    parts = {"hydrodynamics": source, "hydrostatics": hull, "weight": Weight.CARRIED}
    parts |= {"position": moving(heave=heave), "radiation": StateSpaceRadiation(3e-3)}
    inertia, centre = MASS * np.diag([7.0, 16.0, 16.0]) ** 2, (0.0, 0.0, KG - draught)
    body = hs.Body("barge", MASS, inertia, centre_of_gravity=centre, **parts)
    return replace(body, **changes)


def scene(body: hs.Body, duration: float = 40.0, step: float = 0.1, **changes: Any) -> hs.Scene:
    solver = hs.Solver(step=step)
    whole = hs.Scene("draughts", duration, (body,), solver=solver, output={"step": 0.5})
    return replace(whole, **changes)


@pytest.mark.parametrize(("dof", "start"), [("heave", 0.02), ("roll", 0.02)])
@pytest.mark.slow
def test_a_decay_between_two_draughts_is_that_of_the_database_there(dof, start, validated):
    """Within 1 % of its start: what linear interpolation leaves of databases 20 % apart."""
    offset, first = moving(**{dof: start}), np.array(moving(heave=0.4))
    own = hs.simulate(scene(barge(ALONE, 4.0, position=offset)))
    both = hs.simulate(scene(barge(FAMILY, 4.4, position=tuple(first + offset))))
    apart = (both - own)[["position"]].position.sel(dof=dof) - (0.4 if dof == "heave" else 0.0)
    error = float(abs(apart).max()) / start
    claim, against = "decay between two draughts, of its start", "database of this draught"
    validated(Kind.SELF, claim, against, error, 0.01, Feature.DRAUGHTS)


def blends(count: int) -> list[Callable[[float], float]]:
    """Slow heaves from draught to draught: two random sines, a fifth of them at resonance."""
    draw, found = np.random.default_rng(7), []
    for k in range(count):
        w, phase = draw.uniform(0.1, 3.0, 2), draw.uniform(0.0, 2.0 * np.pi, 2)
        w[0] = {0: 2.0 * 0.97, 1: 2.0 * 0.9}.get(k % 10, w[0])
        a = draw.uniform(0.05, 0.4, 2) * [1.0, 0.2]
        found.append(lambda t, w=w, a=a, phase=phase: 0.4 + float(a @ np.sin(w * t + phase)))
    return found


@pytest.mark.slow
def test_no_blend_gains_energy(figure) -> None:
    """The first filter is put where the second follows a given heave, which no wave could make it;
    the energy is that of the body, of A_inf at the draught and of the hull's potential. A memory
    only takes from it, but for the error of the steps."""
    start = moving(heave=0.4, roll=0.06, pitch=0.02, sway=0.1)
    speeds = moving(heave=0.3, roll=-0.05, sway=0.4)
    compiled = compile_scene(scene(barge(FAMILY, 4.4, position=start, velocity=speeds)))
    rest = compile_scene(scene(barge(FAMILY, 4.4, 0.4))).state.y
    model, h, gains = compiled.model, 0.1, []
    at, stored = model.draught, np.zeros(model.rows)
    for heave in blends(100):
        run = started(compiled)
        y, work = run.state.y, run.work

        def energy(y: np.ndarray, run: Run = run, work: Work = work) -> float:
            kinetic = stored_energies(0.0, y, run.state.modes, model, work, stored)
            return kinetic + float(stored.sum())

        y[at : at + DRAUGHT_STATES] = heave(0.0)
        still = energy(np.where(np.arange(y.size) < model.radiation, rest, y))
        before = first = energy(y) - still
        advance(0, run)
        for n in range(200):
            y[at] = y[at + 1] + (heave((n + 1) * h) - y[at + 1]) / h / DRAUGHT_CUTOFF
            run.scratch.step_cache[START_SLOPE] = 0
            advance(1, run)  # one step
            if n % 5 == 4:
                now = energy(y) - still
                gains.append((now - before) / first)
                before = max(now, before)
    figure("largest gain, of the energy at the start", max(gains))
    assert max(gains) < 1e-3
    assert now < 0.5 * first


def started(compiled: Compiled) -> Run:
    """A run that has not begun."""
    clock = compile_clock(compiled)
    state = compiled.first_state()
    return new_run(clock, compiled.model, RK4, state, new_record(compiled.model, clock))


def rising(**changes: Any) -> hs.Scene:
    """Let go at a draught of 4.35 m: it swings about 4 m, and its slow draught follows."""
    start = moving(heave=0.05, roll=0.05, pitch=0.01, yaw=0.3)
    return scene(barge(FAMILY, 4.4, position=start), **changes)


def test_the_ledger_closes_at_the_order_of_the_method(figure) -> None:
    runs = [hs.simulate(rising(duration=10.0, step=h)) for h in (0.05, 0.025, 0.0125)]
    left = [float(np.abs(run.energy_residual.values).max()) for run in runs]
    orders = np.log2(np.array(left[:-1]) / left[1:])
    figure("order of the ledger", orders[-1])
    assert orders.min() > 3.7


def test_a_draught_beyond_the_family_is_warned_of() -> None:
    """The coefficients stay those of the last database; the slow draught is recorded."""
    run = hs.simulate(scene(barge(FAMILY, 4.4, 1.0, mass=0.8 * MASS), 5.0))
    assert run.slow_draught.sel(body="barge")[0] == pytest.approx(3.4)
    assert "its databases cover 3.6 to 4.4 m" in run.attrs["warnings"]


def test_a_run_goes_on_in_the_midst_of_a_blend_to_the_bit() -> None:
    whole = hs.simulate(rising())
    first = hs.simulate(rising(duration=20.0))
    second = hs.simulate(rising(duration=20.0, initial=hs.Start(first)))
    late = whole.sel(time=slice(20.0, None))
    for name in ("position", "velocity", "force_radiation"):
        assert np.array_equal(late[name].values, second[name].values), name


SEA = hs.Environment(waves=(hs.WaveTrain(hs.RegularWave(0.5, 6.0), heading=np.radians(40.0)),))


def held(source: Any, draught: float, heave: float) -> xr.Dataset:
    """The loads on a barge that is held at a heave over its place at rest, and heavy in surge."""
    mean = {"headings": Place.MEAN, "position": Place.MEAN}
    forces = hs.WaveForces(second_order=SecondOrder.MEAN_DRIFT, **mean)
    body = barge(source, draught, heave, mass=1e15, dofs=("surge",), wave_forces=forces)
    return hs.simulate(scene(body, 10.0, environment=SEA, accept=tuple(Question)))


def test_wave_loads_are_those_of_the_draught() -> None:
    """At a draught of a database its own; half-way between two their mean."""
    low, high = held(FILES[4.4], 4.4, 0.0), held(FILES[3.6], 3.6, 0.0)
    for heave, part in ((0.0, 0.0), (0.8, 1.0), (0.4, 0.5)):
        found = held(FAMILY, 4.4, heave)
        for name in ("force_wave_first_order", "force_wave_second_order"):
            expected = (1.0 - part) * low[name] + part * high[name]
            scale = float(abs(expected).max())
            assert_allclose(found[name], expected, rtol=0, atol=1e-12 * scale)


def test_waves_follow_the_slow_place_of_a_family() -> None:
    """At the draught of one of its databases as that alone, locked there."""
    forces = hs.WaveForces(headings=Place.SLOW, position=Place.SLOW)
    dofs = ("surge", "sway", "yaw")
    keys = {"dofs": dofs, "wave_forces": forces, "position": moving(surge=3.0, yaw=0.3)}
    one, both = (barge(source, 4.4, **keys) for source in (FILES[4.4], FAMILY))
    alone, found = (hs.simulate(scene(body, environment=SEA)) for body in (one, both))
    assert_allclose(found.position, alone.position, rtol=0, atol=1e-9)


def test_a_family_that_is_turned_is_turned_as_one_database() -> None:
    """At the draught of one, with a heading at rest, a yaw and a place of its own."""
    mean = {"headings": Place.MEAN, "position": Place.MEAN}
    forces = hs.WaveForces(second_order=SecondOrder.NEWMAN, **mean)
    place = {"heading": 0.6, "location": (30.0, -20.0), "position": moving(yaw=0.2, roll=0.05)}
    keys = {"dofs": ("surge", "sway", "roll", "yaw"), "wave_forces": forces, **place}
    one, both = (barge(source, 4.4, **keys) for source in (FILES[4.4], FAMILY))
    alone, found = (hs.simulate(scene(body, environment=SEA)) for body in (one, both))
    assert_allclose(found.position, alone.position, rtol=0, atol=1e-12)


def test_a_family_in_its_plane_is_what_it_is_in_all_degrees_of_freedom() -> None:
    ahead = hs.Environment(waves=(hs.WaveTrain(hs.RegularWave(0.5, 6.0)),))
    mean = hs.WaveForces(headings=Place.MEAN, position=Place.MEAN)
    body = barge(FAMILY, 4.4, 0.2, wave_forces=mean)
    plane = hs.simulate(scene(body, environment=ahead))
    solver = hs.Solver(step=0.1, symmetry=Symmetry.IGNORE)
    whole = hs.simulate(scene(body, environment=ahead, solver=solver))
    assert "sway of barge" in plane.attrs["zero_by_symmetry"]
    assert_allclose(plane.position, whole.position, rtol=0, atol=1e-10)


def test_no_family_no_cost() -> None:
    """No states, no scratch, and nothing to sum."""
    model = compile_scene(scene(barge(ALONE, 4.0))).model
    blend = new_work(model).blend
    assert model.draught == model.energy
    assert blend.added_mass.size == blend.root.size == model.family.owner.size == 0


REFUSED = {
    "expected a closed hull": {"hydrostatics": None},
    "expected two or more different draughts": {
        "hydrodynamics": Family((AtDraught(4.4, FILES[4.4]),))
    },
    r"for a draught of 3.8 m: found a displaced volume of 4320 m\^3; expected .* 4560 m\^3": {
        "hydrodynamics": Family((AtDraught(4.4, FILES[4.4]), AtDraught(3.8, FILES[3.6])))
    },
    "the lowest point of the hull is -9.6 m and the highest -1.6 m above the water; expected": {
        "hydrodynamics": Family((AtDraught(4.4, FILES[4.4]), AtDraught(9.6, FILES[3.6])))
    },
    "radiation: found convolution, .* expected state_space": {"radiation": ConvolutionRadiation()},
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_is_no_family_is_refused(message: str) -> None:
    with pytest.raises(InputError, match=message):
        compile_scene(scene(replace(barge(FAMILY, 4.4), **REFUSED[message])))


def test_a_current_and_another_origin_are_refused() -> None:
    with pytest.raises(InputError, match="and a current; expected still water"):
        compile_scene(scene(barge(FAMILY, 4.4), environment=hs.Environment(current=hs.Stream(1.0))))
    db = load(FILES[3.6])
    centre = db.centre_of_buoyancy + np.array([2.0, 0.0, 0.0])
    high = AtDraught(3.6, replace(db, centre_of_buoyancy=centre))
    moved = Family((AtDraught(4.4, FILES[4.4]), high))
    with pytest.raises(InputError, match="the same origin on the hull"):
        compile_scene(scene(barge(moved, 4.4)))


CASE = """
title: two draughts
duration: 5 s
environment: {{water_depth: infinite}}
bodies:
  barge:
    hydrodynamics: [{{draught: 4.4 m, file: {0}/4m4.nc}}, {{draught: 3.6 m, file: {0}/3m6.nc}}]
    hydrostatics: {{recipe: {0}/barge.yaml, depth: 8 m}}
    weight: carried
    mass: 4920 tonne
    centre_of_gravity: [0 m, 0 m, -0.4 m]
    radii_of_gyration: [7 m, 16 m, 16 m]
    radiation: {{model: state_space, tolerance: 3e-3}}
"""


def test_a_case_file_has_a_family_as_a_list(tmp_path: Path) -> None:
    """And so has the case that its run writes."""
    (tmp_path / "case.yaml").write_text(CASE.format(DATA))
    (tmp_path / "hull.yaml").write_text("extends: case.yaml\n")
    with pytest.raises(InputError, match=r"bodies.barge.hydrodynamics: .*3m6.nc.*displaced volume"):
        hs.simulate(hs.load_case(tmp_path / "hull.yaml"))
    recipe = DATA / "barge.yaml"
    deeper = f"extends: {recipe}\nhull: {{draught: 4.4 m}}\n"
    (tmp_path / "barge.yaml").write_text(deeper)
    text = CASE.format(DATA).replace(f"{DATA}/barge.yaml", "barge.yaml")
    (tmp_path / "case.yaml").write_text(text)
    run = hs.simulate(hs.load_case(tmp_path / "case.yaml"))
    assert "at 3.6 m: " in run.attrs["database_checksum_barge"]
    (tmp_path / "again.yaml").write_text(run.attrs["case_resolved"])
    again = hs.simulate(hs.load_case(tmp_path / "again.yaml"))
    apart = differences(run, again, {"units_read"})  # what is written is in SI
    assert not [x for x in apart if "case" not in x]


def test_a_place_at_rest_has_the_draught_of_it() -> None:
    """By 80 % of the weight of 4.4 m the barge rises to 3.52 m, beyond the last database."""
    compiled = compile_scene(scene(barge(FAMILY, 4.4, mass=0.8 * MASS * 1.1)))
    rest = equilibrium(compiled.model, compiled.state, 0.0, MASS * 9.81)
    filters = rest.state.y[compiled.model.draught : compiled.model.energy]
    assert_allclose(rest.position[0, 2], 0.2 * 4.4, rtol=1e-9)
    assert_allclose(filters, 0.2 * 4.4, rtol=1e-9)
