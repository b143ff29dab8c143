"""Locks and ratchets in case files, and bad input about joints."""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from textwrap import dedent, indent

import numpy as np
import pytest
from markers import few
from scenes import block, scene

import hydrosim as hs
from hydrosim.case import load_case
from hydrosim.compile.compile import compile_scene
from hydrosim.errors import InputError
from hydrosim.report.sentences.run import run_document
from hydrosim.results.channels import channel_series
from hydrosim.scene import When
from tests.generators.articulated_cases import TYPES, articulated_case
from tests.generators.random_cases import text_of
from tests.generators.random_links import LINKED_FROM
from tests.generators.scene_trials import offences, scene_of, tried

SHIPPED = Path(hs.__file__).parents[1] / "cases"
CASE = """
    title: two masses
    duration: 2 s
    bodies:
      a: {mass: 2 kg, inertia: {roll: 1, pitch: 1, yaw: 1}, dofs: [surge],
          points: {eye: [0 m, 0 m, 0 m]}, initial: {velocity: {surge: 1 m/s}}}
      b: {mass: 3 kg, inertia: {roll: 1, pitch: 1, yaw: 1}, dofs: [surge],
          location: [1 m, 0 m], points: {eye: [0 m, 0 m, 0 m]}}
    solver: {step: 0.05 s}
    output: {step: 0.1 s, clearances: {eyes: {of: eye of a, to: eye of b}}}
"""


def case(tmp_path: Path, joints: str) -> Path:
    path = tmp_path / "case.yaml"
    path.write_text(dedent(CASE) + "joints:\n" + indent(dedent(joints).strip(), "  ") + "\n")
    return path


def test_a_pin_with_a_channel_and_a_window(tmp_path: Path) -> None:
    pin = """
        pin:
          type: fixed
          body: a
          to: b
          active: {from: {channel: clearance.eyes, below: 0.5 m}, until: 1.5 s}
          window: {gap: 0.8 m, speed: 2 m/s}
    """
    path = case(tmp_path, pin)
    joint = load_case(path).scene().joints["pin"]
    assert joint.window == hs.JointWindow(0.8, 2.0)
    assert joint.active.start == When(channel="clearance.eyes", below=0.5)
    run = hs.simulate(path)
    # the masses are 1 m apart at rest, which is a gap of zero at the joint's point
    assert run.lock_mode.values[:, 0].tolist() == [0] * 6 + [3] * 10 + [0] * 5
    assert run.velocity.values[-1, :, 0] == pytest.approx(0.4, abs=1e-12)


def test_a_pin_waits_for_a_relative_speed(tmp_path: Path) -> None:
    """That of the points falls below 0.9 m/s where a force has slowed the mass, at 0.2 s."""
    pin = """
        pin:
          type: fixed
          body: a
          to: b
          active: {from: {channel: relative_speed.eye of a to eye of b, below: 0.9 m/s}}
    """
    path = case(tmp_path, pin)
    brake = "forces: {brake: {type: applied_force, body: a, force: {surge: -1 N}}}\n"
    path.write_text(path.read_text() + brake)
    run = hs.simulate(path)
    assert run.lock_mode.values[:, 0].tolist() == [0] * 3 + [3] * 18
    assert run.lock_loss.values[-1, 0] == pytest.approx(0.5 * 1.2 * 0.9**2, rel=1e-9)
    speed, unit = channel_series(run, "relative_speed.eye of a to eye of b")
    assert unit == "m/s"
    assert speed[:3] == pytest.approx([1.0, 0.95, 0.9], abs=1e-12)


def test_a_ratchet_of_a_case_file(tmp_path: Path) -> None:
    text = "pawl: {type: ratchet, body: a, axis: [-1, 0, 0], slide: {pitch: 0.1 m}}"
    joint = load_case(case(tmp_path, text)).scene().joints["pawl"]
    assert joint.type == "ratchet"
    assert joint.pawl == hs.SlidingPawl(0.1)
    run = hs.simulate(case(tmp_path, text))
    assert np.abs(run.position.values[:, 0, 0]).max() < 1e-9  # the wrong way: held at once


BAD = {
    "pawl: {type: ratchet, body: a, axis: [1, 0, 0]}": "either slide",
    "pawl: {type: ratchet, body: a, axis: [1, 0, 0], turn: {pitch: 190 deg}}": "below 180 deg",
    "pawl: {type: ratchet, body: a, axis: [1e-200, 0, 0], slide: {}}": "an axis of no length",
    "pin: {type: fixed, body: a, to: b, window: {}}": "gap, speed, or both",
    "pin: {type: fixed, body: a, to: b, window: {gap: 0 m}}": "a value above 0",
    "pin: {type: fixed, body: a, to: b, breaks_at: 0 N}": "a force above 0",
    "pin: {type: fixed, body: a, to: c}": "expected a body of this case",
    "pin: {type: fixed, body: a, to: a}": "on both sides",
    "pin: {type: slider, body: a, to: b, axis: [1, 0, 0], damping: 1 kg/s, window: {gap: 1 m}}": (
        "window, and a spring, damping"
    ),
    "pin: {type: fixed, body: a, active: {from: {channel: clearance.eye, below: 1 m}}}": (
        "clearance. and eyes"
    ),
}


@pytest.mark.parametrize("joint", BAD)
def test_bad_joints_are_refused_by_message(tmp_path: Path, joint: str) -> None:
    with pytest.raises(InputError) as raised:
        hs.simulate(case(tmp_path, joint))
    assert BAD[joint] in str(raised.value)


def test_a_summary_tells_when_joints_hold(tmp_path: Path) -> None:
    """The faster mass passes the other; one pin takes it, one is never near enough."""
    pins = """
        pin: {type: fixed, body: a, to: b, active: {from: 0.5 s, until: 1.5 s}}
        late: {type: fixed, body: b, active: {from: 1 s}, window: {gap: 1 mm}}
    """
    run = hs.simulate(case(tmp_path, pins))
    summary = str(run_document(run))
    told = next(line for line in summary.splitlines() if line.startswith("pin ") and "48" in line)
    assert told.split()[:4] == ["pin", "0.6", "1.5", "48"]  # 10 of 21 records
    assert "late has not closed: it was never within its window." in summary
    assert "pin has not closed" not in summary


def test_a_start_at_rest_has_no_rate(tmp_path: Path) -> None:
    path = case(tmp_path, "pin: {type: hinge, body: a, axis: [0, 0, 1], initial: {rate: 1 rad/s}}")
    text = path.read_text().replace("dofs: [surge],\n      points", "points", 1)
    text = text.replace(", initial: {velocity: {surge: 1 m/s}}", "").replace("dofs: [surge],", "")
    path.write_text(text + "initial: at_rest\n")
    with pytest.raises(InputError, match="at_rest, and a velocity of pin; expected one of them"):
        load_case(path)


def test_a_load_that_two_joints_share_is_warned_of(tmp_path: Path) -> None:
    """Two fixed joints between the same bodies; not a joint beside locked directions."""
    second = "c: {type: fixed, body: b, to: a, point: [1 m, 0 m, 0 m]}"
    path = case(tmp_path, "one: {type: fixed, body: b, to: a}\n" + second)
    text = path.read_text().replace("dofs: [surge],", "")
    path.write_text(text.replace("initial: {velocity: {surge: 1 m/s}}", "initial: {}"))
    warnings = compile_scene(load_case(path).scene()).notes.warnings
    assert any("joints.c: other joints or locked directions hold 6 of its 6" in w for w in warnings)
    locked = case(tmp_path, "c: {type: fixed, body: b, to: a, active: {until: 1 s}}")
    text = locked.read_text().replace("initial: {velocity: {surge: 1 m/s}}", "initial: {}")
    locked.write_text(text)
    notes = compile_scene(load_case(locked).scene()).notes
    assert any("joints.c" in text for text in notes.skipped)
    assert not any("joints.c" in text for text in notes.warnings)


def test_unknown_bodies_of_a_scene_are_named() -> None:
    base = scene([block(2.0, name="a")], {}, 1.0, 0.1)
    for joint, text in (
        (hs.Fixed("a", "c"), "joints.pin.to: found c"),
        (hs.Fixed("c"), "joints.pin.body: found c"),
        (hs.Fixed("a", "a"), "joints.pin.to: found a on both sides"),
    ):
        with pytest.raises(InputError, match=text):
            hs.simulate(replace(base, joints={"pin": joint}))


def test_check_names_the_root_of_bodies_in_water() -> None:
    """Heading and restoring are defined along the tree; a body on the earth has no such choice."""
    told = str(hs.check(SHIPPED / "hinged_barges" / "regular.yaml"))
    assert "is the root of the floating tree with" in told
    assert "root of the floating tree" not in str(hs.check(SHIPPED / "flap" / "decay.yaml"))


# Random articulated scenes, a few of those that `tests.generators.scene_trials` runs.

FIRST = 1_000_000


def test_a_random_articulated_case_is_one_that_a_case_file_may_hold(tmp_path: Path) -> None:
    """All types of joints are drawn, and trees of all sizes."""
    path = tmp_path / "case.yaml"
    types, sizes = Counter[str](), Counter[int]()
    for number in range(FIRST, FIRST + 40):
        text = text_of(articulated_case(number))
        assert text == text_of(articulated_case(number))
        path.write_text(text)
        scene = load_case(path).scene()
        types.update(joint.type for joint in scene.joints.values())
        sizes[len(scene.bodies)] += 1
    assert types.keys() == TYPES.keys()
    assert sizes.keys() == {2, 3, 4, 5, 6}


def test_a_case_is_turned_as_a_whole() -> None:
    scene, turned = scene_of(articulated_case, FIRST), scene_of(articulated_case, FIRST, 0.7)
    for body, other in zip(scene.bodies, turned.bodies, strict=True):
        assert other.heading == pytest.approx(body.heading + 0.7)
        assert other.mass == body.mass
    here, there = ({n: j.point for n, j in s.joints.items()} for s in (scene, turned))
    assert here == there


@pytest.mark.parametrize(
    "number", [*few(range(FIRST, FIRST + 40), 12), *few(range(LINKED_FROM, LINKED_FROM + 40), 6)]
)
def test_a_random_articulated_scene(number: int) -> None:
    """It runs or says why not; its ledger closes; turned, it turns; it goes on to the bit."""
    trial = tried(articulated_case, number)
    assert trial.status in ("complete", "failed", "refused"), trial.said
    assert trial.said or trial.status == "complete"
    assert list(offences(trial)) == []
