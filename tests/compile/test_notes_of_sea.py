"""What is said of a scene before it runs."""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import block, hull, moving, scene, scene_of, steady

import hydrosim as hs
from hydrosim import check, simulate
from hydrosim.compile.compile import compile_scene
from hydrosim.compile.questions.waters import OUTSIDE_REFUSED, ask_about_ranges
from hydrosim.compile.scene_notes import OUTSIDE_WARNED, range_warnings
from hydrosim.errors import InputError
from hydrosim.report.document import run_document as report_document
from hydrosim.report.sentences.run import run_document
from hydrosim.scene import ForceElement, Question, Scene, SpectrumTable, Weight, WhiteNoise
from hydrosim.water.components import sea

NOISE = hs.WaveTrain(WhiteNoise(1.0, 0.5, 1.5))  # a band of 1 rad/s: shares of it are frequencies


@dataclass(frozen=True, eq=False)
class Loads:
    """What is read of a database."""

    frequency: np.ndarray
    excitation: np.ndarray


def said(share: float, power: float = 0.0, **forces: bool) -> tuple[list[str], list[str]]:
    """Warnings and refusals, if a share of energy is above a database; loads go as w^power."""
    body = replace(block(1.0), wave_forces=hs.WaveForces(**forces))
    frequency = np.linspace(0.1, 1.5 - share, 50)
    loads = np.tile(frequency[:, None, None] ** power + 0j, (1, 8, 6))
    database = Loads(frequency, loads)
    seas = sea(hs.Environment(waves=(NOISE,)))
    about = SimpleNamespace(floating_bodies=lambda: [(0, body, database)], sea=seas)
    asked = [doubt.found for doubt in ask_about_ranges(about)]
    return list(range_warnings(seas, body, database)), asked


def test_energy_outside_a_database() -> None:
    """Of the waves, where loads do not fall as those on a wall do."""
    # the last 0.1 % is cut off, and a component is 0.06 % of the energy
    assert said(0.5 * OUTSIDE_WARNED, 8.0) == ([], [])
    (warning,), refused = said(0.8 * OUTSIDE_REFUSED, 8.0)
    assert not refused
    assert "of the waves' energy outside the frequencies of the database of block" in warning
    warned, (found,) = said(1.2 * OUTSIDE_REFUSED + 1e-3, 8.0)
    assert not warned
    assert "1.2% of the waves' energy outside" in found
    assert said(0.9, 8.0, first_order=False) == ([], [])


def test_loads_outside_a_database() -> None:
    """With loads as w^-2, those above 1.2 rad/s are int w^-4 dw from there over that of all."""
    share = (1.2**-3 - 1.5**-3) / (0.5**-3 - 1.5**-3)
    _, (found,) = said(0.3, -2.0)
    assert "29.9% of the waves' energy" in found
    assert f"an estimated fraction {share:.2g} of the energy of its loads" in found
    (warning,), refused = said(0.1, -2.0)
    assert not refused
    assert warning.endswith("these waves have no first-order loads.")


def test_each_sea_is_in_one_line_of_check_run_and_report() -> None:
    """Of a triangle from 0.5 to 2.5 about 1.5 of the lowest frequency an eighth is below it."""
    base = scene_of("base")
    low = float(hull().frequency[0])
    triangle = SpectrumTable(low * np.array([0.5, 1.5, 2.5]), np.array([0.0, 1e-2, 0.0]) / low)
    swell = hs.WaveTrain(triangle, np.pi / 2.0, spreading=4.0, repeat_period=36000.0)
    waves = (swell, hs.WaveTrain(hs.RegularWave(0.5, 9.0), 0.25))
    environment = replace(base.environment, waves=waves)
    scene = replace(base, environment=environment, duration=2.0, accept=tuple(Question))
    table, regular = compile_scene(scene).notes.seas
    peak = f"table, Hs 0.4 m, Tp {2.0 * np.pi / (1.5 * low):.3g} s, goes to 90 deg, spreading"
    assert table.startswith(f"{peak} {np.degrees(np.sqrt(0.4)):.2g} deg; 12.50% of its energy")
    assert table.endswith(f"outside the frequencies of {scene.bodies[0].name}")
    assert regular.startswith("regular wave, amplitude 0.5 m, period 9 s, goes to 14.3 deg, long")
    run = simulate(scene)
    for document in (check(scene), run_document(run), report_document(run)):
        text = str(document)
        assert table in " ".join(text.split())
        assert regular in " ".join(text.split())


def test_a_sea_that_loads_no_body_is_told(tmp_path: Path) -> None:
    """As in a new case without a database."""
    case, _ = hs.new(tmp_path / "own.yaml", length=60, beam=20, draught=3)
    (sea,) = compile_scene(hs.load_case(case).scene()).notes.seas
    assert sea.endswith("long-crested; it loads no body")
    assert all("loads no body" not in sea for sea in compile_scene(scene_of("base")).notes.seas)


# Starts at rest: what carries a weight, and what is said where nothing does.

WEIGHT = 9.81 * 2e7
CORNERS = np.array([[x, y, -5.0] for x in (-20.0, 18.0) for y in (-15.0, 15.0)])
X = np.array([0.0, 0.1, 0.2])
LOOP = hs.NormalLoop(X, np.array([0.0, 2e7, 8e7]), X, np.array([0.0, 1e7, 8e7]), 2e9)
LAW = hs.StickSlip(0.3, 0.2, 1e8, 1e6)


def topside(height: float = 0.0, **forces: ForceElement) -> Scene:
    """A topside on four legs, whose centre of gravity is not in their middle."""
    inertia, place = 2e7 * np.diag([80.0, 120.0, 150.0]), moving(heave=height)
    body = block(2e7, name="topside", inertia=inertia, weight=Weight.CARRIED, position=place)
    legs = hs.Landing("topside", CORNERS, hs.Seats(CORNERS), LOOP, LAW)
    resting = scene(body, {"legs": legs, **forces}, 20.0, 0.5, step=0.05)
    return replace(resting, at_rest=True)


def test_the_legs_of_a_topside_carry_its_weight_and_nothing_moves():
    run = hs.simulate(topside())
    N = run.fender_normal_force.values
    assert N.sum(axis=1) == pytest.approx(WEIGHT, rel=1e-10)
    lever = run.fender_node.values[0] - run.position.values[0, 0, :3]
    moment = N[0] @ lever[:, :2]
    assert np.abs(moment).max() < 1e-9 * WEIGHT
    assert N[0, 0] == pytest.approx(WEIGHT * 18 / 38 / 2, rel=1e-3)  # levers of the two sides
    assert np.ptp(run.position.values, axis=0).max() < 1e-11
    assert run.attrs["solver_events"] == 0
    assert np.abs(run.fender_friction.values).max() < 1e-6 * WEIGHT
    assert np.abs(run.fender_dissipated.values).max() < 1e-15


def test_legs_lines_and_pads_share_a_load_as_their_stiffness_says():
    """A level body: k (x0 - x) of each, by hand."""
    ends = ("topside", (0.0, 0.0, 5.0), (0.0, 0.0, 15.0))
    hanger = hs.Spring(*ends, 9.0, curve=hs.TensionCurve(X[:2], np.array([0.0, 2000000.0])))
    pads = hs.Fender(
        *("topside", CORNERS[[0, 3]], hs.Plane((0.0, 0.0, -4.9), (0.0, 0.0, 1.0))),
        *(hs.NormalCurve(X[:2], np.array([0.0, 1e7])), hs.Frictionless()),
    )
    only = topside(hanger=hanger, pads=pads)
    body = replace(only.bodies[0], dofs=("heave",))
    run = hs.simulate(replace(only, bodies=(body,)))
    x = run.position.values[0, 0, 2]
    legs = 4 * np.interp(-x, X, LOOP.force)
    pads_force, line = 2 * 1e8 * (0.1 - x), 2e7 * (1.0 - x)
    assert legs + pads_force + line == pytest.approx(WEIGHT, rel=1e-10)
    assert np.ptp(run.position.values[:, 0, 2]) < 1e-11


def test_what_nothing_carries_is_said():
    said = r"nothing carries -1\.962e\+08 N in heave of topside \(the"
    with pytest.raises(InputError, match=said):
        hs.compile_scene(topside(2.0))
    with pytest.raises(InputError, match=r"legs \d, is 2 m away"):
        hs.compile_scene(topside(2.0))


def test_legs_that_cannot_hold_it_level_are_said():
    """Its centre of gravity is outside what carries it: it topples."""
    legs = hs.Landing("topside", CORNERS[:2], hs.Seats(CORNERS[:2]), LOOP, LAW)
    with pytest.raises(InputError, match="initial: found at_rest"):
        hs.compile_scene(topside(legs=legs))


def test_a_mooring_that_is_pulled_begins_where_it_holds():
    """No weight needed: a steady force and a spring."""
    body = block(1e3, ("surge",))
    forces = {"spring": hs.LinearMooring("block", 50.0 * np.eye(6)), "pull": steady(surge=20.0)}
    run = hs.simulate(replace(scene(body, forces, 5.0, 0.1), at_rest=True))
    assert run.position.values[:, 0, 0] == pytest.approx(0.4, abs=1e-12)


def test_a_case_begins_at_rest_and_says_so_again(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(
        "title: pull\nduration: 5 s\ninitial: at_rest\nbodies: {block: {mass: 2 kg, dofs: [surge]}}"
        "\nforces:\n  spring: {type: linear_mooring, body: block, stiffness: {surge: 50 N/m}}\n"
        "  pull: {type: applied_force, body: block, force: {surge: [20 N]}}\n"
    )
    found = hs.load_case(path)
    path.write_text(str(found.scene().source["case_resolved"]))
    assert hs.load_case(path).scene().at_rest
    assert hs.simulate(found).position.values[-1, 0, 0] == pytest.approx(0.4, abs=1e-12)
    path.write_text(path.read_text().replace("velocity: [0.0,", "velocity: [1.0,", 1))
    with pytest.raises(InputError, match="at_rest, and a velocity of block"):
        hs.load_case(path)
