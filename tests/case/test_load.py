"""Case files: YAML as people expect it, errors that name their place, settings, extending."""

import json
import math
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scenes import ROOT
from text_tables import rows

from hydrosim.case import Case, load_case
from hydrosim.case.build import resolved_case_text
from hydrosim.errors import InputError

Load = Callable[..., Case]
Refusal = Callable[..., str]

BLOCK = """\
title: Block on a spring
duration: 60 s
bodies:
  block:
    mass: 1e6          # PyYAML takes this for a text
    dofs: [surge]
forces:
  spring:
    type: linear_mooring
    body: block
    stiffness: {surge: 10 kN/m}
solver: {method: rk4, step: 0.1 s}
"""


def without(line: str) -> str:
    """The block's case without the line that begins with ``line``."""
    kept = [text for text in BLOCK.splitlines() if not text.strip().startswith(line)]
    return "\n".join(kept)


def test_a_case_is_its_path_text_and_values(load: Load, tmp_path: Path) -> None:
    case = load(BLOCK)
    assert case.path == tmp_path / "case.yaml"
    assert case.text == BLOCK
    assert case.data.bodies["block"].mass == 1e6
    whole = resolved_case_text(case.data, tmp_path)
    assert case.scene().source == {
        "case_file": str(case.path),
        "case": BLOCK,
        "case_resolved": whole,
    }
    assert resolved_case_text(load(whole).data, tmp_path) == whole


@pytest.mark.parametrize(
    ("written", "mass"),
    [("1e6", 1e6), ("+1.e+6", 1e6), ("010", 10), ("'1e6'", 1e6), ("1e3 tonne", 1e6), (".5", 0.5)],
)
def test_numbers_mean_what_they_look_like(load: Load, written: str, mass: float) -> None:
    assert load(BLOCK.replace("1e6", written)).data.bodies["block"].mass == mass


@pytest.mark.parametrize("written", ["1:30", "0x10", "1_000", "1,5", "2017-01-01", ".inf", ".nan"])
def test_no_hidden_numbers(refusal: Refusal, written: str) -> None:
    assert "case.yaml:5: bodies.block.mass: found" in refusal(BLOCK.replace("1e6", written))


@pytest.mark.parametrize("word", ["off", "no", "on", "yes", "True", "0"])
def test_switches_are_true_or_false(refusal: Refusal, load: Load, word: str) -> None:
    message = refusal(BLOCK, [f"solver.events={word}"])
    assert message.endswith("expected true or false")
    assert load(BLOCK, ["solver.events=false"]).scene().solver.events is False


@pytest.mark.parametrize("name", ["on", "y", "null_body", "NO"])
def test_names_stay_names(load: Load, name: str) -> None:
    assert list(load(BLOCK.replace("block", name)).data.bodies) == [name]


def test_bytes_of_windows_and_its_editors(load: Load) -> None:
    assert load(b"\xef\xbb\xbf" + BLOCK.replace("\n", "\r\n").encode()).data.duration == 60.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "case.yaml:1: found no keys"),
        ("# nothing\n", "case.yaml:1: found no keys"),
        ("- a\n- b\n", "case.yaml:1: found no keys"),
        ("VesselTypes:\n  - Name: Ship\n", "case.yaml: found data of OrcaFlex; expected a case"),
        ("title: [a\nb: c", 'case.yaml:1: not valid YAML: found a bracket "["'),
        ("title: a\n\tb: c", "case.yaml:2: not valid YAML"),
        ("title: a: b", "case.yaml:1: not valid YAML"),
        ("title: a\n---\ntitle: b", "case.yaml:2: not valid YAML"),
        ("title: a\x07", "case.yaml: not valid YAML"),
        ('title: "\\UFFFFFFFF"', "case.yaml: not valid YAML"),
        ("title: *unknown", "case.yaml:1: not valid YAML"),
        ("a: &a [*a]", "case.yaml:1: found an alias within"),
        ("[" * 1500, "case.yaml: not valid YAML"),
        ("title: a\n? [b]\n: c", "case.yaml:2: found a list or mapping as key"),
        ("title: a\n\ntitle: b", 'case.yaml:3: found the key "title" twice, first in line 1'),
        ("a: {b: 1, c: [{d: 1, d: 2}]}", 'case.yaml:1: found the key "d" twice'),
        (b"title: a\nx: \xff\xfe\x00", "case.yaml:2: found bytes that are no text"),
        (bytes(range(256)), "case.yaml:"),
    ],
)
def test_what_is_not_a_case_file(refusal: Refusal, text: str | bytes, message: str) -> None:
    assert refusal(text).startswith(message)


def test_missing_file_and_directory(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.yaml: found no such file; expected a YAML"):
        load_case(tmp_path / "nowhere.yaml")
    with pytest.raises(InputError, match="found a directory; expected a case file"):
        load_case(tmp_path)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_damaged_case_is_read_or_refused(load: Load, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(BLOCK)))
    end = data.draw(st.integers(start, min(start + 12, len(BLOCK))))
    junk = data.draw(st.text(alphabet="{}[]:,-&*!#'\"\n\t 1aé~null", max_size=8))
    with suppress(InputError):  # no other error may escape
        load(BLOCK[:start] + junk + BLOCK[end:])


def test_all_problems_at_once_with_their_lines(refusal: Refusal) -> None:
    text = BLOCK.replace("60 s", "60 m").replace("1e6", "-3").replace("step:", "stp:")
    lines = refusal(text.replace("body: block", "body: blok")).splitlines()
    assert [line.split(": found")[0] for line in lines] == [
        "case.yaml:2: duration",
        "case.yaml:5: bodies.block.mass",
        "case.yaml:12: solver.stp",
    ]
    assert lines[2].endswith(
        'step, tolerance, kinematics, events, unstable, linear, symmetry; did you mean "step"?'
    )


def test_place_of_a_list_entry(refusal: Refusal) -> None:
    text = without("stiffness") + "\n    stiffness:\n" + "    - [0, 0, 0, 0, 0, 0]\n" * 6
    text = text.replace("solver: {method: rk4, step: 0.1 s}\n", "").replace(
        "- [0, 0, 0, 0, 0, 0]\n    - [0", "- [0, 0, 0, 0, 0, 0]\n    - [1 kg", 1
    )
    message = refusal(text)
    assert message.startswith("case.yaml:13: forces.spring.stiffness.1.0: found")


@pytest.mark.parametrize("key", ["title", "duration", "mass", "type", "body"])
def test_missing_keys(refusal: Refusal, key: str) -> None:
    assert f'found no key "{key}"' in refusal(without(f"{key}:"))


def test_a_mooring_needs_a_stiffness_of_one_kind(refusal: Refusal) -> None:
    assert "found no stiffness; expected stiffness, natural_period" in refusal(without("stiffness"))
    both = BLOCK.replace("stiffness:", "natural_period: {surge: 100 s}\n    stiffness:")
    assert "found both stiffness and natural_period in surge" in refusal(both)


@pytest.mark.parametrize("key", ["forces", "solver", "solver.step", "bodies.block.initial"])
def test_a_key_without_value_is_an_error(load: Load, refusal: Refusal, key: str) -> None:
    empty = {
        "forces": BLOCK.split("forces:")[0] + "forces:\n",
        "solver": without("solver") + "\nsolver:\n",
        "solver.step": without("solver") + "\nsolver:\n  step:\n",
        "bodies.block.initial": BLOCK.replace("dofs:", "initial: ~\n    dofs:"),
    }
    assert f": {key}: found nothing; expected" in refusal(empty[key])


class TestMergeKeys:
    TWO = """\
title: two
duration: 60
bodies:
  one: &one {mass: 1, radii_of_gyration: [1, 1, 1], location: [0, 0]}
  other: {<<: *one, location: [9, 0], mass: 2}
"""

    def test_own_keys_are_laid_over_those_of_the_anchor(self, load: Load) -> None:
        one, other = load(self.TWO).data.bodies.values()
        assert (one.mass, one.location) == (1.0, (0.0, 0.0))
        assert (other.mass, other.location) == (2.0, (9.0, 0.0))
        assert one.radii_of_gyration == other.radii_of_gyration == (1.0,) * 3

    def test_of_several_the_first_is_first(self, load: Load) -> None:
        third = "  third: {<<: [*other, *one], location: [20, 0]}\n"
        text = self.TWO.replace("other: {", "other: &other {") + third
        assert load(text).data.bodies["third"].mass == 2.0

    def test_null_removes(self, load: Load) -> None:
        inertia = "radii_of_gyration: null, inertia: {roll: 1, pitch: 1, yaw: 1}"
        third = load(f"{self.TWO}  third: {{<<: *one, {inertia}}}\n").data.bodies["third"]
        assert third.radii_of_gyration is None

    def test_settings_change_one_of_them(self, load: Load) -> None:
        bodies = load(self.TWO, ["bodies.other.radii_of_gyration.0=7"]).data.bodies
        assert [body.radii_of_gyration[0] for body in bodies.values()] == [1.0, 7.0]

    def test_a_mistake_in_an_anchor_is_told_once(self, refusal: Refusal) -> None:
        message = refusal(self.TWO.replace("&one {mass: 1", "&one {masss: 3, mass: 1"))
        assert "bodies.one.masss and 1 like it: found an unknown key" in message
        assert "bodies.other.masss" not in message

    def test_a_merge_key_in_quotes_is_a_key(self, refusal: Refusal) -> None:
        assert "other.<<: found an unknown key" in refusal(self.TWO.replace("<<:", "'<<':"))

    @pytest.mark.parametrize(
        ("given", "found"),
        [
            ("3", 'case.yaml:5: found no mapping after "<<"; expected one by its anchor'),
            ("[*one, x]", 'case.yaml:5: found no mapping after "<<"'),
            ("*none", "case.yaml:5: not valid YAML: found undefined alias"),
        ],
    )
    def test_what_is_no_mapping_is_refused(self, refusal: Refusal, given: str, found: str) -> None:
        assert found in refusal(self.TWO.replace("<<: *one", f"<<: {given}"))


class TestSettings:
    def test_values_are_as_in_the_file(self, load: Load) -> None:
        case = load(BLOCK, ["solver.step=0.05 s", "bodies.block.mass=2e6", "title=a=b: [c"[:9]])
        assert case.data.solver.step == 0.05
        assert case.data.bodies["block"].mass == 2e6
        assert case.data.title == "a=b"

    def test_lists_mappings_and_entries_of_lists(self, load: Load) -> None:
        push = "forces.push={type: applied_force, body: block, force: {surge: 1 kN}}"
        dofs = ["bodies.block.dofs=[surge, heave]", "bodies.block.dofs.1=sway"]
        case = load(BLOCK, [*dofs, push, "output.step=1 s"])
        assert case.data.bodies["block"].dofs == ("surge", "sway")
        assert case.scene().output_step == 1.0
        assert list(case.data.forces) == ["spring", "push"]

    def test_null_removes(self, load: Load) -> None:
        assert load(BLOCK, ["forces.spring=null"]).data.forces == {}

    def test_python_values(self, load: Load) -> None:
        values = {
            "solver.step": np.float64(0.05),
            "bodies.block.dofs": ("surge", "yaw"),
            "bodies.block.inertia": np.eye(3),
            "title": "5",
            "forces.spring": None,
        }
        data = load(BLOCK, values).data
        assert (data.solver.step, data.title, data.forces) == (0.05, "5", {})
        assert data.bodies["block"].inertia == ((1, 0, 0), (0, 1, 0), (0, 0, 1))

    def test_the_text_is_the_whole_case(self, load: Load) -> None:
        case = load(BLOCK, ["solver.step=0.05 s", "forces.spring.damping_ratio={surge: 20 %}"])
        assert "--set solver.step=0.05 s" in case.text
        assert load(case.text).data == case.data

    def test_an_anchor_is_not_changed_elsewhere(self, load: Load) -> None:
        text = BLOCK.replace("{surge: 10", "&k {surge: 10").replace(
            "solver", "  dashpot: {type: linear_mooring, body: block, stiffness: *k}\nsolver"
        )
        forces = load(text, ["forces.dashpot.stiffness.surge=7 N/m"]).scene().forces
        assert [forces[n].stiffness[0, 0] for n in ("spring", "dashpot")] == [1e4, 7.0]

    @pytest.mark.parametrize(
        ("setting", "message"),
        rows("""
        solver.stp=1 | solver.stp: found an unknown key; expected one of: method, step
        stiffness=3 | did you mean "forces.spring.stiffness"?
        solvr.step=1 | one of: title, duration, environment, bodies, forces, joints, solver
        bodies.blok.dofs=[surge] | found no "blok" there; expected one of: block; did you
        forces.sprin.body=block | found no "sprin" there; expected one of: spring; did you
        forces.sprin=null | found no "sprin" there; expected one of: spring
        bodies.block.dofs.3=yaw | found no "3" there; expected one of: 0
        duration.s=3 | found the value "60 s" there
        solver.step=0 | solver.step: found 0; expected a time in s
        solver.step=[ | not valid YAML
        solver.step= | expected KEY=VALUE
        solver.step | expected KEY=VALUE
        =3 | expected KEY=VALUE
        title=5 | title: found 5; expected text
        """),
    )
    def test_wrong_settings_are_named(self, refusal: Refusal, setting: str, message: str) -> None:
        refused = refusal(BLOCK, [setting])
        assert refused.startswith(f"--set {setting}: ")
        assert message in refused


class TestExtends:
    @pytest.fixture
    def base(self, tmp_path: Path) -> Path:
        path = tmp_path / "base.yaml"
        path.write_text(BLOCK)
        return path

    def test_lays_over_and_removes(self, base: Path, load: Load) -> None:
        case = load(
            "extends: base.yaml\nbodies: {block: {mass: 5}}\n"
            "forces: {spring: {damping: {surge: 1}}}"
        )
        assert case.data.title == "Block on a spring"
        assert case.data.bodies["block"].mass == 5.0
        assert case.data.bodies["block"].dofs == ("surge",)
        spring = case.scene().forces["spring"]
        assert (spring.stiffness[0, 0], spring.damping[0, 0]) == (1e4, 1.0)
        assert load("extends: base.yaml\nforces: {spring: null}").data.forces == {}

    def test_a_mapping_that_says_its_kind_replaces(self, base: Path, refusal: Refusal) -> None:
        text = "extends: base.yaml\nforces: {spring: {type: linear_mooring, body: block}}"
        assert refusal(text).startswith("case.yaml:2: forces.spring: found no stiffness")

    def test_the_text_is_the_whole_case(self, base: Path, load: Load) -> None:
        case = load("extends: base.yaml\ntitle: Heavier\nbodies: {block: {mass: 2e6}}\n")
        assert case.text.startswith("# case.yaml over base.yaml\n")
        assert "extends" not in case.text
        base.unlink()
        assert load(case.text).data == case.data

    def test_lines_are_those_of_the_file_that_is_wrong(self, base: Path, refusal: Refusal) -> None:
        base.write_text(BLOCK.replace("1e6", "-1"))
        lines = refusal("extends: base.yaml\nduration: 0\n").splitlines()
        assert lines[0].startswith("case.yaml:2: duration: found 0")
        assert lines[1].startswith("base.yaml:5: bodies.block.mass: found -1")

    def test_paths_begin_at_the_file_that_they_are_in(self, tmp_path: Path, load: Load) -> None:
        """Of the file below, of the one that extends it from another folder, and of a setting."""
        for folder in ("below", "below/further", "runs"):
            (tmp_path / folder).mkdir()
        for file in ("below/record.txt", "runs/record.txt"):
            (tmp_path / file).write_text("0 0\n1 0\n2 0\n3 0\n200 0\n")
        record = "{file: ../record.txt, column: 2}"
        push = f"  push: {{type: applied_force, body: block, force: {{surge: {record}}}}}\n"
        (tmp_path / "below" / "further" / "base.yaml").write_text(
            BLOCK.replace("forces:\n", "forces:\n" + push)
        )
        (tmp_path / "below" / "middle.yaml").write_text("extends: further/base.yaml")
        middle = "extends: below/middle.yaml\n"

        def read(text: str, *settings: str) -> Path:
            force = load(text, settings).data.forces["push"].force.surge
            return (tmp_path / force.file).resolve()

        assert read(middle) == tmp_path / "below" / "record.txt"
        own = middle + "forces: {push: {force: {surge: {file: runs/record.txt}}}}"
        assert read(own) == tmp_path / "runs" / "record.txt"
        setting = "forces.push.force.surge.file=runs/record.txt"
        assert read(middle, setting) == tmp_path / "runs" / "record.txt"
        absolute = f"forces.push.force.surge.file={tmp_path}/runs/record.txt"
        assert read(middle, absolute) == tmp_path / "runs" / "record.txt"

    def test_a_missing_file_is_told_where_it_was_looked_for(
        self, tmp_path: Path, refusal: Refusal
    ) -> None:
        (tmp_path / "below").mkdir()
        hull = "hydrodynamics: hulls/none.nc\n    centre_of_gravity: [0, 0, 0]\n    mass: 1e6"
        text = BLOCK.replace("mass: 1e6", hull) + "environment: {water_depth: infinite}\n"
        (tmp_path / "below" / "base.yaml").write_text(text)
        message = refusal("extends: below/base.yaml")
        assert message.startswith("below/base.yaml:5: bodies.block.hydrodynamics: found no such")
        assert "below/hulls/none.nc" in message

    def test_a_chain(self, base: Path, tmp_path: Path, load: Load) -> None:
        (tmp_path / "middle.yaml").write_text("extends: base.yaml\ntitle: Middle\nduration: 5")
        data = load("extends: middle.yaml\ntitle: Top").data
        assert (data.title, data.duration, data.solver.step) == ("Top", 5.0, 0.1)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("extends: nothing.yaml", "case.yaml:1: extends: found no file nothing.yaml"),
            ("extends: .", "case.yaml:1: extends: found no file"),
            ("extends:", "case.yaml:1: extends: found no file"),
            ("title: a\nextends: case.yaml", "case.yaml:2: extends: case.yaml leads back here"),
            ("extends: base.yaml\nforces: {sprin: null}", 'case.yaml:2: found no "sprin" there'),
            ("extends: base.yaml\nsolver: {stp: 1}", "case.yaml:2: solver.stp: found an unknown"),
        ],
    )
    def test_refused(self, base: Path, refusal: Refusal, text: str, message: str) -> None:
        assert refusal(text).startswith(message)


def test_infinite_is_a_word(load: Load) -> None:
    text = BLOCK + "environment: {water_depth: infinite}"
    assert load(text).scene().environment.water_depth == math.inf


def test_the_files_that_a_case_reads() -> None:
    """Whatever a case names and is there: no key has to be known for that."""
    case = load_case(ROOT / "cases" / "one_dimensional" / "base.yaml")
    names = {path.name for path in case.inputs()}
    assert {"base.yaml", "no_friction.yaml"} <= names
    wet = load_case(ROOT / "cases" / "reverse_float_over" / "base.yaml")
    assert {path.name for path in wet.inputs()} == {"base.yaml", "h851.nc"}


WET = """
    hydrodynamics: {}
    mass: 1000 tonne
    centre_of_gravity: [0, 0, 0]
    dofs: [heave]
"""
HYDRODYNAMICS = r"""
  {file: none.nc, accept: 3} | hydrodynamics.accept
  {file: none.nc, frequencies: [3 rad/s, 1 rad/s]} | the lower one first
  {file: none.nc, without: [heave]} | hydrodynamics.without.0
  {file: none.nc, simetrise: true} | symmetrise
  {file: none.nc, accept: [positive dampng]} | case.yaml:6: \
    bodies.block.hydrodynamics.accept.0: found "positive dampng"; expected "positive damping"
  [{file: none.nc, draught: 4 m}, {file: none.nc, draught: 5 m, accept: [x]}] | case.yaml:6: \
    bodies.block.hydrodynamics.1.accept.0: found "x"; expected one of
  {file: none.nc} | hydrodynamics.file: found no such file
  {stiffness: {heave: -1 N/m}} | hydrodynamics.stiffness
  {damping: {heave: 1 kN/m}} | hydrodynamics.damping.heave
  {added_mass: [[1, 2], [2, 1]]} | hydrodynamics.added_mass
  {} | found none of them
"""


@pytest.mark.parametrize(("text", "said"), rows(HYDRODYNAMICS))
def test_hydrodynamics_that_cannot_be_are_named(text, said, refusal):
    body = WET.format(text)
    head = "title: t\nduration: 1 s\nenvironment: {}\nbodies:\n  block:"
    assert said in " ".join(refusal(head + body).split())


@pytest.mark.parametrize(
    ("solver", "said"),
    [
        ("{method: automatic, tolerance: {relative: 1e-6}}", "chooses itself"),
        ("{method: dopri5, tolerance: 1e-6}", "expected method: automatic, or"),
        ("{method: automatic, tolerance: -1}", "1e-10 or more"),
        ("{method: automatic, tolerance: 1e-11}", "1e-10 or more"),
        ("{method: automatic, tolerance: 20 %}", "0.1 or less"),
    ],
)
def test_tolerances_of_the_wrong_kind(solver: str, said: str, refusal: Refusal) -> None:
    assert said in refusal(BLOCK.replace("{method: rk4, step: 0.1 s}", solver))


def test_settings_hold_what_a_case_gives() -> None:
    """Also of recorded series, one below a normal force, one below a degree of freedom."""
    text = load_case(ROOT / "cases/one_dimensional/base.yaml").settings()
    keys = [key for key in json.loads(text) if key.startswith("forces.waves.force")]
    assert keys == [f"forces.waves.force.surge.{key}" for key in ("file", "case", "column")]
