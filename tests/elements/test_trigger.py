"""Elements that act for a time only: when they begin and end, and what the ledger says of it."""

from dataclasses import replace
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest
from reading import texts
from scenes import block, central_force, heave, moving, on_floor, scene, steady, surge, with_step

import hydrosim as hs
from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.report.sentences.run import run_document
from hydrosim.scene import Active, Clearance, ForceElement, Kinematics, Method, Scene, Start, When
from hydrosim.scene.plane import Plane

MASS = 2.0
ALONG = ("surge",)


def pushed(duration: float = 4.0, **forces: ForceElement) -> Scene:
    """A mass that a force of 3 N pushes along."""
    body = block(MASS, ALONG)
    return scene(body, {"push": steady(surge=3.0), **forces}, duration, 0.1, step=0.1)


def during(start: float | None = None, until: float | None = None) -> Active:
    return Active(*(None if t is None else When(t) for t in (start, until)))


@pytest.mark.parametrize("method", Method)
def test_a_force_acts_between_its_times_to_the_last_digit(method, validated):
    """Times that are on no grid: x = F / 2m (t - a)^2, and then straight on."""
    a, b = 0.7123, 2.3456
    brief = replace(steady(surge=5.0), active=during(a, b))
    pushed = scene(block(MASS, ALONG), {"brief": brief}, 4.0, 0.1)
    run = hs.simulate(with_step(pushed, 0.1, method=method))
    t = run.time.values
    on, after = np.clip(t - a, 0.0, b - a), np.maximum(t - b, 0.0)
    expected = 0.5 * 5.0 / MASS * on**2 + 5.0 / MASS * (b - a) * after
    error = np.abs(surge(run) - expected).max()
    claim = "force that acts between two times, every method [m]"
    validated(Kind.CLOSED_FORM, claim, "parabola and straight lines", error, 1e-9, Feature.TRIGGERS)
    assert [*run.trigger_stage.values[[0, 15, -1], 0]] == [0, 1, 2]
    work = 0.5 * MASS * (5.0 / MASS * (b - a)) ** 2
    assert run.energy_work_brief.values[-1] == pytest.approx(work)


def test_a_force_begins_when_the_body_is_fast_and_ends_when_it_is_far():
    """v = F t / m reaches 1.2 m/s, and the pull against it brings x back down to its own event."""
    fast = When(channel="velocity.block.surge", above=1.2)
    slow = When(channel="speed.block", below=0.3)
    brake = replace(steady(surge=-6.0), active=Active(fast, slow))
    run = hs.simulate(pushed(brake=brake))
    begun, v = 1.2 * MASS / 3.0, run.velocity.values[:, 0, 0]
    ended = begun + (1.2 - 0.3) * MASS / 3.0
    t = run.time.values
    braked, freed = 1.2 - 3.0 * (t - begun) / MASS, 0.3 + 3.0 * (t - ended) / MASS
    expected = np.where(t < begun, 3.0 * t / MASS, np.where(t < ended, braked, freed))
    assert v == pytest.approx(expected, abs=1e-9)


def test_what_must_last_is_counted_anew_each_time():
    """x = sin t is above 0.5 for 2 pi / 3 at a time, and above -0.5 for 4 pi / 3."""
    body = block(MASS, ALONG, velocity=moving(surge=1.0))
    spring = hs.LinearMooring("block", MASS * np.eye(6))

    def begins(value: float, lasting: float) -> float:
        when = Active(When(channel="position.block.surge", above=value, lasting=lasting))
        drag = replace(hs.LinearDamping("block", np.eye(6)), active=when)
        run = hs.simulate(scene(body, {"spring": spring, "drag": drag}, 20.0, 0.01, step=0.01))
        on = np.flatnonzero(run.trigger_stage.values[:, 0])
        return float(run.time.values[on[0]]) if on.size else np.inf

    assert begins(0.5, 2.0) == pytest.approx(np.pi / 6 + 2.0, abs=0.011)
    assert begins(0.5, 2.2) == np.inf
    assert begins(-0.5, 3.0) == pytest.approx(3.0, abs=0.011)  # it is there as the run begins
    assert begins(-0.5, 4.0) == pytest.approx(11 * np.pi / 6 + 4.0, abs=0.011)


TAUT = np.array([0.0, 1.0]), np.array([0.0, 50.0])


@pytest.mark.parametrize(
    ("name", "element", "k"),
    [
        (
            "line",
            hs.Spring(
                "block", (0.0, 0.0, 0.0), (10.0, 0.0, 0.0), 9.0, curve=hs.TensionCurve(*TAUT)
            ),
            50.0,
        ),
        ("mooring", hs.LinearMooring("block", 50.0 * np.eye(6)), 50.0),
        ("pad", on_floor(80.0, hs.Frictionless()), 80.0),
    ],
)
def test_what_is_stored_as_elements_come_and_go_is_in_the_ledger(name, element, k):
    """A quick release: what is stored is lost then, and nothing else; and the other way round."""
    dofs = ("heave",) if name == "pad" else ALONG
    start = moving(heave=-0.5) if name == "pad" else moving(surge=0.5)
    of = heave if name == "pad" else surge
    body = block(MASS, dofs, position=start)

    def run_of(active: Active) -> object:
        forces = {name: replace(element, active=active)}
        return hs.simulate(scene(body, forces, 1.0, 0.01, step=0.01))

    released, until = run_of(during(until=0.1234)), 0.1234
    assert released.attrs["energy_residual_relative"] < 1e-6
    lost, stored = (released[f"energy_{what}_{name}"].values for what in ("dissipated", "stored"))
    v = np.diff(of(released))[-1] / 0.01
    w = np.sqrt(k / MASS)
    assert abs(v) == pytest.approx(0.5 * w * np.sin(w * until), rel=1e-5)
    assert lost[-1] == pytest.approx(0.5 * k * (0.5 * np.cos(w * until)) ** 2, rel=1e-5)
    assert np.all(stored[13:] == 0.0)
    begun = run_of(during(0.2))
    assert begun.attrs["energy_residual_relative"] < 1e-6
    assert begun[f"energy_dissipated_{name}"].values[21] == pytest.approx(-0.5 * k * 0.25)
    before = of(begun)[:21]
    assert np.ptp(before) == 0.0


def test_a_restart_while_something_lasts_is_the_run_to_the_bit():
    when = Active(When(channel="speed.block", above=1.0, lasting=0.7))
    whole = pushed(brake=replace(steady(surge=-6.0), active=when))
    whole = whole.with_output(states=True)
    run = hs.simulate(whole)
    for time in (0.3, 0.9, 2.0):  # before, while it lasts, after it has begun
        again = hs.simulate(replace(whole, initial=Start(run, time), duration=4.0 - time))
        assert surge(again)[-1] == surge(run)[-1]
        assert again.trigger_stage.values[-1] == run.trigger_stage.values[-1]


def test_a_scene_with_a_trigger_is_not_taken_for_linear():
    body = block(MASS, ALONG, position=moving(surge=1.0))
    spring = replace(hs.LinearMooring("block", np.eye(6)), active=during(until=1.0))
    linear = replace(scene(body, {"spring": spring}, 3.0, 0.1).solver, linear="exact")
    run = hs.simulate(replace(scene(body, {"spring": spring}, 3.0, 0.1), solver=linear))
    assert "spring is not always active" in run.attrs["solver_linear"]
    w = np.sqrt(0.5)
    assert surge(run)[-1] == pytest.approx(np.cos(w) - 2.0 * w * np.sin(w), abs=1e-5)


CASE = """
    title: a quick release
    duration: 10 s
    bodies: {block: {mass: 2 kg, dofs: [surge]}}
    forces:
      mooring: {type: linear_mooring, body: block, stiffness: {surge: 5 N/m}, %s}
      push:
        type: applied_force
        body: block
        force: {surge: [1 N]}
"""


def case(tmp_path: Path, keys: str) -> hs.Case:
    path = tmp_path / "case.yaml"
    path.write_text(dedent(CASE % keys))
    return hs.load_case(path)


@pytest.mark.parametrize(
    "keys",
    [
        "active: {from: 1 s, until: {channel: velocity.block.surge, below: 1 cm/s, lasting: 2 s}}",
        "when: {channel: position.block.surge, above: 1 cm}",
        "active: {until: 3 s}",
        "active: {from: {time: 1 s}, until: {time: 3 s}}",
        "when: {time: 2 s}",
        "when: 2 s",
    ],
)
def test_case_files_ask_for_it_and_write_it_again(tmp_path, keys):
    found = case(tmp_path, keys)
    again = tmp_path / "again.yaml"
    again.write_text(str(found.scene().source["case_resolved"]))
    active = found.scene().forces["mooring"].active
    assert hs.load_case(again).scene().forces["mooring"].active == active
    assert active is not None


@pytest.mark.parametrize("when", ["2 s", "{time: 2 s}"])
def test_a_moment_is_a_time_or_a_mapping_with_one(tmp_path, when):
    found = case(tmp_path, f"when: {when}").scene().forces["mooring"].active
    assert found == Active(When(2.0))


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("when: {channel: position.block.surge, above: 1 N}", "expected a value in m, which"),
        ("when: {channel: speed.block}", "expected either above or below"),
        ("active: {}", "expected from, until, or both"),
        ("active: {from: 3 s, until: 2 s}", "expected an end after the start"),
        ("active: {from: 3 s, until: {time: 2 s}}", "expected an end after the start"),
        ("when: {channel: position.barge.surge, above: 1}", "expected position. and block.surge"),
        (
            "when: {channel: tide, above: 1}",
            "expected one that begins with position, velocity, speed",
        ),
    ],
)
def test_what_cannot_be_waited_for_is_a_message(tmp_path, keys, expected):
    with pytest.raises(InputError, match=expected):
        hs.compile_scene(case(tmp_path, keys).scene())


def test_contacts_can_be_waited_for():
    """A force that begins when a pad carries 5 N, and ends when it has done so for 0.2 s."""
    pressed = When(channel="fender_normal_force.pad", above=5.0)
    when = Active(pressed, When(channel="fender_compression.pad 1", above=0.0, lasting=0.3))
    lift = central_force(**steady(heave=1.0).force)
    pad, lift = on_floor(80.0, hs.Frictionless()), replace(lift, active=when)
    forces = {"pad": pad, "down": steady(heave=-10.0), "lift": lift}
    body = block(MASS, ("heave",), position=moving(heave=0.1))
    run = hs.simulate(scene(body, forces, 1.0, 0.005, step=0.005))
    stage, N = run.trigger_stage.values[:, 0], run.fender_normal_force.values[:, 0]
    first = int(np.flatnonzero(stage)[0])
    assert N[first - 1] < 5.0 <= N[first]
    begun, ended = run.time.values[[first, np.flatnonzero(stage == 2)[0]]]
    assert ended == pytest.approx(begun + 0.3, abs=0.011)  # it is waited for from then on


@pytest.mark.parametrize("kinematics", Kinematics)
def test_a_clearance_from_the_plane_of_a_tilted_body_can_be_waited_for(kinematics) -> None:
    """A point 2 m above a plane that is pitched by 0.3 goes along at 1 m/s: x sin + 2 cos, or
    0.3 x + 2 with small angles, reaches 2.1 m on its way."""
    passing = block(MASS, ALONG, velocity=moving(surge=1.0), points={"keel": (0.0, 0.0, 2.0)})
    deck = block(1.0, (), "deck", position=moving(pitch=0.3))
    over = Clearance("keel of block", None, Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), "deck"))
    push = replace(steady(surge=3.0), active=Active(When(channel="clearance.over", above=2.1)))
    above = scene((passing, deck), {"push": push}, 2.0, 0.1, kinematics=kinematics)
    run = hs.simulate(above.with_output(clearances={"over": over}))
    exact = kinematics is Kinematics.EXACT
    begun = (2.1 - 2.0 * np.cos(0.3)) / np.sin(0.3) if exact else 0.1 / 0.3
    t = run.time.values
    expected = t + 1.5 / MASS * np.maximum(t - begun, 0.0) ** 2
    assert surge(run) == pytest.approx(expected, abs=1e-9)


def test_what_has_not_begun_is_said() -> None:
    """A force from a speed on that the mass has after 4 s, 6 m/s, or has not."""
    for speed, waits in ((100.0, True), (1.0, False)):
        start = When(channel="speed.block", above=speed)
        more = replace(steady(surge=0.1), active=Active(start))
        said = texts(run_document(hs.simulate(pushed(more=more))).nodes)
        told = "warning: more has not begun: its condition was not met."
        assert (told in said) == waits


def stopped(load: str) -> hs.Scene:
    """A mass at 1 m/s that meets a stop 2 m ahead; a force waits for 40 of its load."""
    ends = {"point": (0, 0, 0), "anchor": (10, 0, 0)}
    stop = hs.Stop("block", **ends, lowest=8.0, stiffness=1e4)
    pressed = When(channel="stop_load.stop", below=load)
    late = replace(steady(surge=0.0), active=Active(pressed))
    body = block(MASS, ALONG, velocity=moving(surge=1.0))
    return scene(body, {"stop": stop, "late": late}, 2.2, 0.001, step=0.001)


def test_the_load_of_a_stop_can_be_waited_for() -> None:
    """k v / w sin(w t) reaches it, with w^2 = k / m."""
    run = hs.simulate(stopped("-40 N"))
    omega = np.sqrt(1e4 / MASS)
    exact = 2.0 + np.arcsin(40.0 * omega / 1e4) / omega
    begun = run.trigger_stage.values[:, 0] > 0
    first = int(begun.argmax())
    assert run.time.values[first - 1] < exact <= run.time.values[first]


def test_a_load_is_waited_for_in_the_unit_of_its_coordinate() -> None:
    expected = (
        "stop_load.stop: found a value in N\\*m; expected one in N, as stop acts along a line"
    )
    with pytest.raises(InputError, match=expected):
        hs.compile_scene(stopped("-40 N*m"))
