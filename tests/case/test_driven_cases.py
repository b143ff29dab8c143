"""Drives and rods in case files: what they become, and each mistake with file, key and line."""

from pathlib import Path

import numpy as np
import pytest
from text_tables import rows

import hydrosim as hs
from hydrosim.case import load_case
from hydrosim.compile.compile import compile_scene
from hydrosim.elements import Drive, Harmonic, SmoothTable
from hydrosim.errors import InputError
from hydrosim.report.sentences.run import run_document

CASE = """\
title: Crane with a load
duration: 20 s
bodies:
  base: {mass: 100 tonne, radii_of_gyration: {roll: 3 m, pitch: 3 m, yaw: 3 m}, dofs: [surge, yaw]}
  boom:
    mass: 10 tonne
    inertia: {roll: 10 tonne*m^2, pitch: 80 tonne*m^2, yaw: 80 tonne*m^2}
    centre_of_gravity: [5 m, 0 m, 2 m]
  load:
    mass: 1 tonne
    inertia: {roll: 1 tonne*m^2, pitch: 1 tonne*m^2, yaw: 1 tonne*m^2}
    centre_of_gravity: [10 m, 0 m, -6 m]
    weight: carried
joints:
  slew: {type: hinge, body: boom, to: base, axis: [0, 0, 1], point: [-5 m, 0 m, 0 m]}
  sling: {type: rod, body: load, to: boom, point: [0, 0, 1 m], to_point: [5 m, 0, 0]}
forces:
  shake:
    type: drive
    body: base
    dof: surge
    offset: {amplitude: 0.2 m, period: 5 s}
  turn:
    type: drive
    joint: slew
    angle: {time: [0 s, 10 s, 20 s], angle: [0 deg, 30 deg, 30 deg]}
  hold: {type: linear_mooring, body: base, stiffness: {yaw: 1e9 N*m/rad}}
solver: {step: 0.02 s}
output: {step: 0.1 s}
"""


def written(folder: Path, right: str, wrong: str) -> Path:
    assert CASE.count(right) == 1
    path = folder / "case.yaml"
    path.write_text(CASE.replace(right, wrong))
    (folder / "path.csv").write_text(
        "time [s],x\n" + "".join(f"{k},{0.01 * k}\n" for k in range(22))
    )
    return path


def test_drives_and_rods_of_a_case_run(tmp_path: Path) -> None:
    scene = load_case(written(tmp_path, "title", "title")).scene()
    shake, turn = scene.forces["shake"], scene.forces["turn"]
    assert isinstance(shake, Drive)
    assert isinstance(turn, Drive)
    assert shake.position == Harmonic(0.2, 5.0)
    assert (turn.body, turn.motion, turn.joint) == ("boom", "angle", "slew")
    assert isinstance(turn.position, SmoothTable)
    assert turn.position.value.tolist() == [0.0, *np.radians([30.0, 30.0])]
    run = hs.simulate(scene)
    assert [*run.drive.values] == ["shake surge", "turn angle"]
    assert float(run.joint_position[-1, 0]) == pytest.approx(np.radians(30.0), abs=1e-14)
    assert run.attrs["energy_residual_relative"] < 1e-6
    text = str(run_document(run))
    assert "Prescribed motion" in text
    assert "turn angle" in text
    said = str(hs.check(scene))
    assert "shake moves surge of base by a sine of 5 s: from -0.2" in said
    assert "turn moves angle of slew by a table of 3 values" in said


@pytest.mark.parametrize(("factor", "size"), [("", 1.0), ("2", 2.0), ("1 cm", 0.01)])
def test_a_recorded_path_may_have_a_factor(factor: str, size: float, tmp_path: Path) -> None:
    more = f", factor: {factor}" if factor else ""
    wanted = f"offset: {{file: path.csv, column: x{more}}}"
    path = written(tmp_path, "offset: {amplitude: 0.2 m, period: 5 s}", wanted)
    shake = load_case(path).scene().forces["shake"]
    assert isinstance(shake, Drive)
    assert shake.position.value[-1] == pytest.approx(0.21 * size, rel=1e-12)


MISTAKES = r"""
  dof: surge | dof: lift | 21 | forces.shake.dof: found lift
  dof: surge | dof: sway | 21 | forces.shake.dof | bodies.base.dofs
  offset: {amplitude: 0.2 m | angle: {amplitude: 2 deg | 22 | \
    found angle of surge of base; expected offset
  TABLE | offset: {amplitude: 1 m, period: 9 s} | 26 | forces.turn.offset | angle
  body: base\n | body: bse\n | 20 | forces.shake.body | base
  joint: slew | joint: slw | 25 | forces.turn.joint | slew
  joint: slew | joint: slew\n    motion: lift | 26 | forces.turn.motion | angle
  slew: {type: hinge | slew: {type: cylindrical | 23 | \
    forces.turn.motion: found none | offset, angle
  joint: slew | joint: sling | 25 | forces.turn.joint
  body: base\n | body: boom\n | 20 | forces.shake.body | slew
  20 s], angle | 15 s], angle | 26 | forces.turn.angle.time | 20 s
  [0 s, 10 s, 20 s] | [0 s, 10 s, 5 s] | 26 | forces.turn.angle.time
  [0 s, 10 s, 20 s] | [0 s] | 26 | forces.turn.angle.time | two or more
  [0 deg, 30 deg, 30 deg] | [0 deg] | 26 | an angle for each time
  hold: | again: {type: drive, body: base, dof: surge, SINE}\n  hold: | 27 | \
    forces.again | shake drives surge of base already
  dofs: [surge, yaw] | dofs: [surge, yaw], initial: {position: {surge: 1 m}} | 18 | \
    forces.shake | initial position of 1 m
  SINE | offset: 1 m | 22 | forces.shake.offset | \
    found "1 m"; expected a sine {amplitude: 1 m, period: 8 s}, a table {time: [0 s, 9 s], | \
    offset: [0 m, 1 m]}, or a record {file: path.csv, column: x}
  SINE | offset: {file: path.csv, column: x, factor: 1 kN} | 22 | forces.shake.offset | \
    found a column without a unit and a factor in kN | expected m of both together
  dof: surge | dof: surge\n    active: {from: 2 s} | 22 | forces.shake.active
  END | to_point: [5 m, 0, -7 m] | 16 | joints.sling | both ends
  END | END, length: -1 m | 16 | joints.sling.length
  END | END, length: 9 m | 16 | joints.sling | close
  [0 deg, 30 deg, 30 deg] | [5 deg, 30 deg, 30 deg] | 16 | joints.sling: does not close | \
    Drives move the start (turn)
  , END} | , END}\n  again: {type: rod, body: load, to: boom, point: [0, 0, 1 m], END} | 17 | \
    joints.again | not determined
  , END | | 16 | joints.sling | to_point
"""
"""What is written in place of what; the line, and words of the message."""
for word, text in {
    "TABLE": "angle: {time: [0 s, 10 s, 20 s], angle: [0 deg, 30 deg, 30 deg]}",
    "SINE": "offset: {amplitude: 0.2 m, period: 5 s}",
    "END": "to_point: [5 m, 0, 0]",
}.items():
    MISTAKES = MISTAKES.replace(word, text)


@pytest.mark.parametrize("mistake", rows(MISTAKES), ids=lambda row: row[1])
def test_a_mistake_is_told_with_its_place(mistake: tuple[str, ...], tmp_path: Path) -> None:
    right, wrong, line, *words = mistake
    path = written(tmp_path, right, wrong)
    with pytest.raises(InputError) as error:
        compile_scene(load_case(path).scene())
    text = str(error.value)
    assert len(text.splitlines()) == 1
    assert f"case.yaml:{line}: " in text
    assert text.count("case.yaml") <= 2
    for word in words:
        assert word in text
