"""What a case may hold, element by element, and what it becomes in the scene."""

import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from text_tables import rows, sections

from hydrosim import elements, scene, simulate
from hydrosim.case import Case
from hydrosim.case.checks import RESERVED
from hydrosim.dofs import DOFS
from hydrosim.elements.kind import BODY_ROWS, WEIGHT
from hydrosim.errors import InputError

Load = Callable[..., Case]
Refusal = Callable[..., str]

DRY = """\
title: Dry body
duration: 60 s
bodies:
  block: {mass: 2 tonne, radii_of_gyration: [1 m, 2 m, 3 m]}
"""


def body(keys: str) -> str:
    """A case of one body."""
    return f"title: t\nduration: 60\nbodies:\n  block: {{{keys}}}\n"


def element(keys: str) -> str:
    """The dry body's case with one force element."""
    return DRY + f"forces:\n  element: {{{keys}}}\n"


JONSWAP = "spectrum: jonswap, significant_height: 1, peak_period: 8"
APPLIED = "type: applied_force, body: block"
MOORING = "type: linear_mooring, body: block"
FENDER = (
    "type: fender, body: block, points: [[0, 0, 1]], plane: {point: [0, 0, 2], normal: [0, 0, -1]}"
)


def fender(normal: str = "stiffness: 1 kN/m", friction: str = "law: none", more: str = "") -> str:
    return element(f"{FENDER}, normal: {{{normal}}}, friction: {{{friction}}}{more}")


def waves(text: str) -> str:
    return DRY + f"environment: {{waves: {text}}}\n"


ELEMENT = "case.yaml:6: forces.element"


class TestBody:
    def test_a_dry_body(self, load: Load) -> None:
        (block,) = load(DRY).scene().bodies
        assert (block.name, block.mass, block.hydrodynamics) == ("block", 2000.0, None)
        assert_allclose(block.inertia, np.diag([2000.0, 8000.0, 18000.0]), rtol=1e-15)
        assert block.dofs == DOFS
        assert block.radiation == scene.AutomaticRadiation()
        assert load(DRY).scene().environment == scene.Environment()

    def test_directions_by_name(self, load: Load) -> None:
        """The same as lists: what is not named is zero, but of radii and inertia all are asked."""
        listed = body(
            "mass: 2, radii_of_gyration: [1, 2, 3],"
            " initial: {position: [0, 0, 1, 0, 5 deg, 0], velocity: [3, 0, 0, 0, 0, 1 deg/s]}"
        )
        named = body(
            "mass: 2, radii_of_gyration: {yaw: 3, roll: 1, pitch: 2},"
            " initial: {position: {heave: 1, pitch: 5 deg}, velocity: {yaw: 1 deg/s, surge: 3}}"
        )
        assert load(named).data == load(listed).data
        (block,) = load(body("mass: 2, inertia: {roll: 4, pitch: 5, yaw: 6}")).scene().bodies
        assert_array_equal(block.inertia, np.diag([4.0, 5.0, 6.0]))

    def test_all_keys(self, load: Load, tmp_path: Path) -> None:
        (tmp_path / "db.nc").touch()
        text = body(
            "mass: 1, hydrodynamics: db.nc, centre_of_gravity: [1 km, 0, -4.9 m],"
            "location: [10 m, -20 m], inertia: [[2, 0, 1 g*m^2], [0, 3, 0], [0.001, 0, 4]],"
            "initial: {position: [1 cm, 0, 0, 180 deg, 0, 0],"
            "          velocity: [0, 0, 1 knot, 0, 0, 6 rpm]},"
            "radiation: convolution, wave_forces: {first_order: false, second_order: mean_drift}"
        )
        (block,) = load(text + "environment: {}").scene().bodies
        assert block.hydrodynamics == tmp_path / "db.nc"
        assert block.centre_of_gravity == (1000.0, 0.0, -4.9)
        assert block.location == (10.0, -20.0)
        assert_allclose(block.inertia, [[2, 0, 1e-3], [0, 3, 0], [1e-3, 0, 4]], rtol=1e-15)
        assert_allclose(block.position, [0.01, 0, 0, math.pi, 0, 0])
        assert_allclose(block.velocity, [0, 0, 1852 / 3600, 0, 0, math.pi / 5])
        assert block.radiation == scene.ConvolutionRadiation()
        assert block.wave_forces == scene.WaveForces(False, scene.SecondOrder.MEAN_DRIFT)

    @pytest.mark.parametrize(
        ("text", "radiation"),
        [
            ("state_space", scene.StateSpaceRadiation()),
            ("automatic", scene.AutomaticRadiation()),
            (
                "{model: automatic, tolerance: 1e-4, step: 0.1 s}",
                scene.AutomaticRadiation(1e-4, None, 0.1),
            ),
            ("none", scene.NoRadiation()),
            ("{model: none, period: 10 s}", scene.NoRadiation()),
            ("{model: constant, period: 10 s}", scene.ConstantRadiation(10.0)),
            ("{model: convolution, step: 200 ms}", scene.ConvolutionRadiation(None, 0.2)),
            (
                "{model: state_space, tolerance: 0.1 %, length: 2 min}",
                scene.StateSpaceRadiation(1e-3, 120.0),
            ),
        ],
    )
    def test_radiation(self, load: Load, tmp_path: Path, text: str, radiation: object) -> None:
        (tmp_path / "db.nc").touch()
        wet = "hydrodynamics: db.nc, centre_of_gravity: [0, 0, 0]"
        text = body(f"mass: 1, dofs: [surge], {wet}, radiation: {text}") + "environment: {}"
        (block,) = load(text).scene().bodies
        assert block.radiation == radiation

    @pytest.mark.parametrize(
        "keys", ["radiation: convolution", "wave_forces: {second_order: newman}"]
    )
    def test_a_dry_body_makes_and_feels_no_waves(self, refusal: Refusal, keys: str) -> None:
        told = refusal(body(f"mass: 1, dofs: [surge], {keys}"))
        assert f"found {keys.partition(':')[0]} of a dry body" in told

    def test_mass_matrix_is_mass_and_inertia(self, load: Load) -> None:
        rows = "[2000,0,0,0,0,0],[0,2000,0,0,0,0],[0,0,2 tonne,0,0,0]"
        turns = "[0,0,0,5,1,0],[0,0,0,1,6,0],[0,0,0,0,0,7 kg*m^2]"
        (block,) = load(body(f"mass: 2 tonne, mass_matrix: [{rows},{turns}]")).scene().bodies
        assert_array_equal(block.inertia, [[5, 1, 0], [1, 6, 0], [0, 0, 7]])

    def test_without_free_rotations_the_inertia_is_not_needed(self, load: Load) -> None:
        (block,) = load(body("mass: 5, dofs: [heave, surge]")).scene().bodies
        assert block.dofs == ("surge", "heave")
        assert np.linalg.eigvalsh(block.inertia).min() > 0.0

    def test_something_must_be_free(self, refusal: Refusal) -> None:
        assert "bodies: found no degree of freedom in" in refusal(body("mass: 1, dofs: []"))

    @pytest.mark.parametrize(
        ("entry", "found"),
        [
            ("1001 1 0 0 0", "a mass_matrix that is not of this mass"),
            ("1000 1 0 500 500", "a mass_matrix that is not of this mass"),
            ("1000 1 0 500 0", "500 in row 1, column 5 and 0 opposite it"),
            ("1000 1 2 0 0", "a matrix that is not positive definite"),
        ],
    )
    def test_mass_matrix_must_be_about_the_centre_of_gravity(
        self, refusal: Refusal, entry: str, found: str
    ) -> None:
        m, i, ij, couple, couple_back = entry.split()
        rows = (
            f"[{m},0,0,0,{couple},0],[0,1000,0,0,0,0],[0,0,1000,0,0,0],"
            f"[0,0,0,{i},{ij},0],[{couple_back},0,0,{ij},1e4,0],[0,0,0,0,0,1]"
        )
        if ij != "0":
            rows = rows.replace("1e4", "1")
        assert f"found {found}" in refusal(body(f"mass: 1000, mass_matrix: [{rows}]"))

    @pytest.mark.parametrize(
        ("keys", "message"),
        rows(r"""
        initial: {position: {heav: 1}} | position.heav: found an unknown key.*mean "heave"
        second_order: newman | found an unknown key.*mean "wave_forces.second_order"
        initial: {velocity: {yaw: 1 m}} | velocity.yaw: found \"1 m\"; expected an ang
        initial: {position: 1 m} | position: found "1 m"; expected a list
        inertia: {roll: 1, pitch: 1} | inertia: found no key "yaw"
        inertia: {roll: 1, pitch: -1, yaw: 1} | not positive definite
        """),
    )
    def test_names_refused(self, refusal: Refusal, keys: str, message: str) -> None:
        assert re.search(message, refusal(body(f"mass: 1, {keys}")))

    @pytest.mark.parametrize("name", ["my block", "2", "a/b", "blöck", "a.b"])
    def test_names_are_words(self, refusal: Refusal, name: str) -> None:
        assert "expected letters, digits and _" in refusal(DRY.replace("block", name))

    def test_a_wet_body_needs_its_place_and_water(self, refusal: Refusal, tmp_path: Path) -> None:
        (tmp_path / "db.nc").touch()
        keys = "mass: 1, dofs: [surge], hydrodynamics: db.nc"
        assert "found no centre_of_gravity" in refusal(body(keys) + "environment: {}")
        assert "found no environment" in refusal(body(f"{keys}, centre_of_gravity: [0, 0, 0]"))

    @pytest.mark.parametrize(("path", "found"), [("db.nc", "no such file"), (".", "a directory")])
    def test_database_must_be_a_file(self, refusal: Refusal, path: str, found: str) -> None:
        keys = f"mass: 1, dofs: [surge], centre_of_gravity: [0, 0, 0], hydrodynamics: {path}"
        message = refusal(body(keys) + "environment: {}")
        assert message.startswith(f"case.yaml:4: bodies.block.hydrodynamics: found {found} at ")
        assert "relative paths begin at the folder of the file" in message

    def test_at_least_one_body(self, refusal: Refusal) -> None:
        assert "yaml:3: bodies: found nothing in it" in refusal("title: t\nduration: 1\nbodies: {}")


class TestWaves:
    def test_jonswap(self, load: Load) -> None:
        text = waves(
            "{spectrum: jonswap, significant_height: 150 cm, peak_period: 8 s, heading: 45 deg,"
            " peak_enhancement: 2, seed: 7, ramp: 200 s, repeat_period: 3 hour}"
        )
        (train,) = load(text).scene().environment.waves
        assert train.spectrum == scene.Jonswap(1.5, 8.0, 2.0)
        assert (train.seed, train.ramp, train.repeat_period) == (7, 200.0, 10800.0)
        assert train.heading == pytest.approx(math.pi / 4)

    def test_pierson_moskowitz_is_jonswap_without_enhancement(self, load: Load) -> None:
        text = waves("{spectrum: pierson_moskowitz, significant_height: 1, peak_period: 8}")
        assert load(text).scene().environment.waves[0].spectrum == scene.Jonswap(1.0, 8.0, 1.0)

    def test_several_trains_and_none(self, load: Load) -> None:
        text = waves(
            "[{spectrum: regular, amplitude: 1, period: 9, phase: 90 deg}, {spectrum: none}]"
        )
        (train,) = load(text).scene().environment.waves
        assert train.spectrum == scene.RegularWave(1.0, 9.0, math.pi / 2)
        assert load(waves("[]")).scene().environment.waves == ()

    def test_one_word_turns_them_off(self, load: Load) -> None:
        text = waves("{spectrum: jonswap, significant_height: 1.5, peak_period: 8}")
        assert load(text, ["environment.waves.spectrum=none"]).scene().environment.waves == ()


class TestMooring:
    def test_per_dof(self, load: Load) -> None:
        text = element(
            f"{MOORING}, stiffness: {{surge: 40 tonne_force/m, yaw: 1 MN*m/deg}},"
            "damping_ratio: {surge: 20 %}"
        )
        mooring = load(text).scene().forces["element"]
        assert isinstance(mooring, elements.LinearMooring)
        assert_allclose(
            mooring.stiffness, np.diag([392400, 0, 0, 0, 0, 180e6 / math.pi]), rtol=1e-15
        )
        assert mooring.damping is None
        assert_array_equal(mooring.damping_ratio, [0.2, 0, 0, 0, 0, 0])

    def test_matrices(self, load: Load) -> None:
        zero, rows = "[0,0,0,0,0,0]", "[2 kN/m, 0, 0, 0, {}, 0]"
        text = element(
            f"{MOORING}, stiffness: [{rows.format('1 kN/rad')},{zero},{zero},{zero},"
            f"[1 kN,0,0,0,3 kN*m/rad,0],{zero}], damping: {{heave: 5}}"
        )
        mooring = load(text).scene().forces["element"]
        expected = np.zeros((6, 6))
        expected[np.ix_([0, 4], [0, 4])] = [[2000, 1000], [1000, 3000]]
        assert_array_equal(mooring.stiffness, expected)
        assert_array_equal(mooring.damping, np.diag([0, 0, 5, 0, 0, 0]))
        assert mooring.damping_ratio is None

    def test_a_matrix_that_gives_energy_away(self, refusal: Refusal) -> None:
        rows = "[1,0,0,0,2,0],[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0],[2,0,0,0,1,0],[0,0,0,0,0,0]"
        assert "negative eigenvalue" in refusal(element(f"{MOORING}, stiffness: [{rows}]"))


class TestAppliedForce:
    def test_table(self, load: Load) -> None:
        text = element(
            "type: applied_force, body: block, frame: body, point: [1 m, 0, 0],"
            "time: [0, 1 hour], force: {heave: [0, 1 kN], pitch: [1 kN*m, 0]}"
        )
        force = load(text).scene().forces["element"]
        assert isinstance(force, elements.AppliedForce)
        assert (force.frame, force.point) == ("body", (1.0, 0.0, 0.0))
        assert list(force.force) == ["heave", "pitch"]
        for signal, values in zip(force.force.values(), ([0, 1000], [1000, 0]), strict=True):
            assert isinstance(signal, elements.Table)
            assert_array_equal([signal.time, signal.value], [[0, 3600], values])

    def test_constant(self, load: Load) -> None:
        text = element(f"{APPLIED}, force: {{surge: 1 kN, yaw: 2 N*m}}")
        force = load(text).scene().forces["element"]
        assert force.frame == "earth"
        assert {dof: signal.value.item() for dof, signal in force.force.items()} == {
            "surge": 1000.0,
            "yaw": 2.0,
        }


class TestForcesOverTime:
    """Of an applied force; a prescribed normal force is the same."""

    SINE = "amplitude: 3 kN, period: 8 s, mean: -1 kN, phase: 90 deg"

    def test_forms(self, load: Load) -> None:
        text = element(
            "type: applied_force, body: block, force: {surge: {time: [0, 1 min],"
            f"force: [1 kN, 2 kN]}}, sway: 5, heave: {{{self.SINE}}},"
            "yaw: {amplitude: 2 kN*m, period: 1}}"
        )
        force = load(text).scene().forces["element"].force
        assert_array_equal([force["surge"].time, force["surge"].value], [[0, 60], [1e3, 2e3]])
        assert_array_equal([force["sway"].time, force["sway"].value], [[0.0], [5.0]])
        assert force["heave"] == elements.Harmonic(3e3, 8.0, mean=-1e3, phase=math.pi / 2)
        assert force["yaw"] == elements.Harmonic(2e3, 1.0)

    def test_prescribed(self, load: Load) -> None:
        two = "[[0, 0, 1], [0, 1, 1]]"
        sine = fender(f"prescribed: {{{self.SINE}}}, total: true").replace("[[0, 0, 1]]", two)
        normal = load(sine).scene().forces["element"].normal
        assert normal.force == elements.Harmonic(1.5e3, 8.0, mean=-500.0, phase=math.pi / 2)
        table = "prescribed: {time: [0, 1], force: [0, 4 kN]}, total: true"
        force = load(fender(table)).scene().forces["element"].normal.force
        assert_array_equal([force.time, force.value], [[0, 1], [0, 4e3]])
        constant = load(fender("prescribed: 4 kN")).scene().forces["element"].normal.force
        assert_array_equal([constant.time, constant.value], [[0.0], [4e3]])

    def test_a_time_that_nothing_uses(self, refusal: Refusal) -> None:
        force = "time: [0, 1], force: {surge: {amplitude: 1, period: 1}}"
        message = refusal(element(f"type: applied_force, body: block, {force}"))
        assert "forces.element: found time and no list over it" in message

    def test_one_file_is_the_run_of_one_case(self, refusal: Refusal, tmp_path: Path) -> None:
        (tmp_path / "other.yaml").touch()
        runs = [f"{{file: run.nc, column: 2, case: {name}.yaml}}" for name in ("case", "other")]
        force = f"force: {{surge: {runs[0]}, sway: {runs[1]}}}"
        message = refusal(element(f"type: applied_force, body: block, {force}"))
        assert "force.sway.case: found run.nc as the run of other.yaml and of case.yaml" in message


class TestFender:
    def test_a_stiffness_is_a_line(self, load: Load) -> None:
        fend = load(fender("stiffness: 5 kN/m, damping: 2")).scene().forces["element"]
        assert isinstance(fend, elements.Fender)
        assert fend.plane == elements.Plane((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), None)
        assert_array_equal(fend.points, [[0, 0, 1]])
        assert_array_equal(
            np.vstack([fend.normal.compression, fend.normal.force]), [[0, 1], [0, 5e3]]
        )
        assert fend.normal.damping == 2.0
        assert fend.friction == elements.Frictionless()

    @pytest.mark.parametrize("total", [False, True])
    def test_totals_are_shared_by_the_points(self, load: Load, total: bool) -> None:
        word = str(total).lower()
        text = fender(
            f"compression: [0, 1, 2], force: [0, 8 kN, 80 kN], damping: 16, total: {word}",
            "law: stick_slip, static: 0.4, kinetic: 0.2, stiffness: 32, damping: 64,"
            f"slip_damping: 128, total: {word}",
        ).replace("[[0, 0, 1]]", "[[0, 0, 1], [0, 1, 1], [0, 2, 1], [0, 3, 1]]")
        fend = load(text).scene().forces["element"]
        share = 4.0 if total else 1.0
        assert_array_equal(fend.normal.compression, [0, 1, 2])
        assert_array_equal(fend.normal.force * share, [0, 8e3, 80e3])
        assert fend.normal.damping * share == 16.0
        assert fend.friction == elements.StickSlip(0.4, 0.2, 32 / share, 64 / share, 128 / share)

    def test_friction_slope(self, load: Load) -> None:
        friction = "law: friction_slope, coefficient: 0.2, slope: 1e9 N*s/m, total: true"
        fend = load(fender(friction=friction)).scene().forces["element"]
        assert fend.friction == elements.FrictionSlope(0.2, 1e9)

    def test_one_word_turns_friction_off(self, load: Load) -> None:
        text = fender(friction="law: friction_slope, coefficient: 0.2, slope: 1e9")
        case = load(text, ["forces.element.friction.law=none"])
        assert case.scene().forces["element"].friction == elements.Frictionless()

    @pytest.mark.parametrize(
        ("old", "new", "message"),
        rows("""
        [[0, 0, 1]] | [] | .points: found nothing in it
        [[0, 0, 1]] | [0, 0, 1] | .points: found a list of values; expected a list of lists
        [0, 0, -1] | [0, 0, 0] | .plane: found the normal [0, 0, 0]
        -1] | -1], body: block | .plane.body: found "block" on both sides
        -1] | -1], body: blok | .plane.body: found "blok"; expected a body of this case
        body: block | body: blok | .body: found "blok"; expected a body of this case: block
        -1] | -1], corners: [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]] | \
          .plane: found corners whose sides cross each other; expected each beside
        -1] | -1], corners: [[0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 1, 0]] | \
          .plane: found a corner twice; expected each once
        type: fender | type: fender, group: "" | .group: found the name ""; expected letters
        type: fender | type: fender, when: {channel: sped.block, below: 1 m/s} | \
          .when: found the channel sped.block; expected one that begins with position
        type: fender | type: fendr | .type: found "fendr"; expected one of: linear_mooring
        """),
    )
    def test_geometry_refused(self, refusal: Refusal, old: str, new: str, message: str) -> None:
        assert refusal(fender().replace(old, new)).startswith(f"{ELEMENT}{message}")

    def test_between_two_bodies(self, load: Load) -> None:
        text = fender().replace("-1]", "-1], body: topside")
        text = text.replace("forces:", "  topside: {mass: 1, dofs: [heave]}\nforces:")
        assert load(text).scene().forces["element"].plane.body == "topside"


SPRING = "type: spring, body: block, point: [1, 0, 0], anchor: [9, 0, 2 m], length: 6 m"


class TestSpring:
    def test_a_stiffness_is_a_line(self, load: Load) -> None:
        spring = load(element(f"{SPRING}, stiffness: 5 kN/m")).scene().forces["element"]
        assert isinstance(spring, elements.Spring)
        assert (spring.body, spring.point, spring.anchor) == ("block", (1, 0, 0), (9, 0, 2))
        assert (spring.length, spring.damping, spring.anchor_body) == (6.0, 0.0, None)
        assert_array_equal([spring.extension, spring.tension], [[0, 1], [0, 5e3]])

    def test_all_keys(self, load: Load) -> None:
        curve = "curve: {extension: [-10 cm, 0.5, 1 m], tension: [0 kN, 2 kN, 9 kN]}"
        text = element(f"{SPRING}, {curve}, damping: 3 kN*s/m, anchor_body: tug")
        text = text.replace("forces:", "  tug: {mass: 1, dofs: [heave]}\nforces:")
        spring = load(text).scene().forces["element"]
        assert (spring.damping, spring.anchor_body) == (3e3, "tug")
        assert_array_equal(spring.extension, [-0.1, 0.5, 1.0])
        assert_array_equal(spring.tension, [0, 2e3, 9e3])

    def test_length_is_needed(self, refusal: Refusal) -> None:
        text = element(f"{SPRING}, stiffness: 1")
        assert 'forces.element: found no key "length"' in refusal(text.replace(", length: 6 m", ""))
        wrong = refusal(text.replace("6 m", "0 m"))
        assert 'forces.element.length: found "0 m"; expected a length' in wrong


STRUT = "type: strut, body: block, point: [1, 0, 0], anchor: [9, 0, 2 m]"
TORSION = "type: torsion_spring, body: block"


class TestStrut:
    def test_a_stiffness_is_a_line_of_both_signs(self, load: Load) -> None:
        strut = load(element(f"{STRUT}, stiffness: -5 kN/m")).scene().forces["element"]
        assert isinstance(strut, elements.Strut)
        assert (strut.length, strut.damping, strut.absorbs) == (None, 0.0, False)
        assert_array_equal([strut.offset, strut.force], [[0, 1], [0, -5e3]])

    def test_all_keys(self, load: Load) -> None:
        curve = "curve: {extension: [-10 cm, 0.5], force: [-4 kN, 9 kN]}, capacity: 9 kN"
        text = element(
            f"{STRUT}, {curve}, damping: 3 kN*s/m, quadratic_damping: 2 kN*s^2/m^2,"
            " length: 7 m, anchor_body: tug"
        )
        text = text.replace("forces:", "  tug: {mass: 1, dofs: [heave]}\nforces:")
        strut = load(text).scene().forces["element"]
        found = (
            strut.damping,
            strut.quadratic_damping,
            strut.length,
            strut.capacity,
            strut.anchor_body,
        )
        assert found == (3e3, 2e3, 7.0, 9e3, "tug")
        assert_array_equal([strut.offset, strut.force], [[-0.1, 0.5], [-4e3, 9e3]])

    def test_a_power_take_off_needs_no_stiffness(self, load: Load) -> None:
        text = element(f"{STRUT}, stiffness: 0, damping: 2 kN*s/m").replace(
            "strut", "power_take_off"
        )
        pto = load(text).scene().forces["element"]
        assert isinstance(pto, elements.Strut)
        assert (pto.absorbs, pto.damping, pto.offset.size, pto.can_carry_weight()) == (
            True,
            2e3,
            0,
            False,
        )


class TestTorsionSpring:
    def test_all_keys(self, load: Load) -> None:
        curve = "curve: {angle: [-20 deg, 0, 1], moment: [-4 kN*m, 0, 9]}, neutral: 90 deg"
        more = "damping: 3 kN*m*s/rad, quadratic_damping: 2 N*m*s^2/rad^2, to: tug"
        text = element(f"{TORSION}, axis: [0, 2, 0], {curve}, {more}")
        text = text.replace("forces:", "  tug: {mass: 1, dofs: [heave]}\nforces:")
        spring = load(text).scene().forces["element"]
        assert isinstance(spring, elements.TorsionSpring)
        assert (spring.axis, spring.damping, spring.quadratic_damping, spring.to) == (
            (0, 2, 0),
            3e3,
            2,
            "tug",
        )
        assert spring.neutral == pytest.approx(np.pi / 2)
        assert_array_equal(spring.offset, [-np.radians(20.0), 0, 1])
        assert_array_equal(spring.force, [-4e3, 0, 9])

    def test_a_rotary_power_take_off(self, load: Load) -> None:
        text = element("type: rotary_power_take_off, body: block, axis: [0, 1, 0], damping: 2")
        assert load(text).scene().forces["element"].absorbs


ALONG = "point: [1, 0, 0], anchor: [9, 0, 2 m]"
ABOUT = "axis: [0, 1, 0]"
JOINTS = """\
joints:
  ball: {type: ball, body: arm, point: [0, 0, 1]}
  hinge: {type: hinge, body: hand, to: arm, point: [0, 0, 1], axis: [0, 1, 0]}
  guide: {type: cylindrical, body: tip, to: hand, point: [0, 0, 1], axis: [0, 0, 1]}
forces:"""
LIMBS = "".join(
    f"  {name}: {{mass: 1, centre_of_gravity: [0, 0, {z}], radii_of_gyration: [1, 1, 1]}}\n"
    for name, z in (("arm", -2), ("hand", -4), ("tip", -6))
)


class TestCoordinates:
    """Elements along a distance, a twist or a motion of a joint."""

    def test_the_recorded_case_gives_the_same_values(self, load: Load) -> None:
        curve = "curve: {place: [-20 deg, 0, 1], load: [-4 kN*m, 0, 9]}, neutral: 90 deg"
        whole = load(element(f"type: spring_damper, body: block, {ABOUT}, {curve}")).scene()
        spring = whole.forces["element"]
        again = load(whole.source["case_resolved"]).scene().forces["element"]
        assert again == spring
        assert_array_equal(spring.offset, [-np.radians(20.0), 0, 1])

    @pytest.mark.parametrize(
        ("keys", "key", "found"),
        rows("""
        stop, ALONG, lowest: 10 deg, stiffness: 1 | .lowest | "10 deg"
        stop, ABOUT, lowest: -1, stiffness: 1 kN/m | .stiffness | "1 kN/m"
        spring_damper, ABOUT, curve: {place: [0, 1], load: [0, 1 kN]} | .curve.load | \
          "1 kN"; expected a value in N*m, as it acts about an axis
        stop, joint: ball, lowest: 1, stiffness: 1 | .joint | ball, a ball joint; exp
        spring_damper, joint: guide, stiffness: 1 | .motion | none; expected one of: off
        spring_damper, joint: hinge, motion: offset, stiffness: 1 | .motion | \
          offset; expected one of: angle
        stop, joint: hinge, body: arm, lowest: 1, stiffness: 1 | .body | \
          arm; expected hand, which is the body of hinge, or none
        stop, joint: hinge, lowest: 1 m, stiffness: 1 | .lowest | "1 m"; expected a value
        """),
    )
    def test_what_no_coordinate_has(self, load: Load, keys: str, key: str, found: str) -> None:
        keys = keys.replace("ALONG", ALONG).replace("ABOUT", ABOUT)
        on_body = "" if "joint" in keys else "body: block, "
        text = element(f"{on_body}type: {keys}").replace("forces:", LIMBS + JOINTS)
        with pytest.raises(InputError) as caught:
            simulate(load(text).scene())
        assert f"forces.element{key}: found {found}" in str(caught.value)

    def test_a_spring_in_a_joint_carries_no_weight_itself(self, load: Load) -> None:
        """The joint carries the body, if what it joins it to is carried."""
        text = element("type: spring_damper, joint: hinge, stiffness: 1")
        spring = load(text.replace("forces:", LIMBS + JOINTS)).scene().forces["element"]
        assert spring.body == "hand"
        assert not spring.can_carry_weight()

    def test_an_unknown_joint(self, refusal: Refusal) -> None:
        text = element("type: stop, joint: hing, lowest: 1, stiffness: 1")
        message = refusal(text.replace("forces:", LIMBS + JOINTS))
        assert 'forces.element.joint: found "hing"; expected a joint of this case: ball' in message
        assert 'did you mean "hinge"?' in message


class TestBushing:
    def test_all_keys(self, load: Load) -> None:
        text = element(
            "type: bushing, body: block, to: tug, point: [1 m, 0, 0],"
            " stiffness: {surge: 5 kN/m, yaw: 2 kN*m/rad}, damping: {heave: 3}"
        ).replace("forces:", "  tug: {mass: 1, dofs: [heave]}\nforces:")
        bushing = load(text).scene().forces["element"]
        assert isinstance(bushing, elements.Bushing)
        assert (bushing.point, bushing.to) == ((1.0, 0.0, 0.0), "tug")
        assert_array_equal(bushing.stiffness, np.diag([5e3, 0, 0, 0, 0, 2e3]))
        assert_array_equal(bushing.damping, np.diag([0, 0, 3.0, 0, 0, 0]))


class TestSolver:
    def test_defaults(self, load: Load) -> None:
        made = load(DRY).scene()
        assert made.solver == scene.Solver(method=scene.Method.AUTOMATIC, accuracy=1e-4)
        assert made.output_step == 0.5

    def test_a_step_alone_is_that_of_rk4(self, load: Load) -> None:
        made = load(DRY + "solver: {step: 0.2}").scene()
        assert made.solver == scene.Solver(method=scene.Method.RK4, step=0.2)

    def test_all_keys(self, load: Load) -> None:
        text = DRY + "solver: {method: heun, step: 50 ms, kinematics: linear, events: false}"
        solver = load(text).scene().solver
        assert solver == scene.Solver(
            method=scene.Method.HEUN, step=0.05, kinematics=scene.Kinematics.LINEAR, events=False
        )

    @pytest.mark.parametrize(("step", "output"), [(0.3, 0.6), (2.0, 2.0), (0.07, 0.49)])
    def test_output_follows_the_step(self, load: Load, step: float, output: float) -> None:
        made = load(DRY + f"solver: {{step: {step}}}").scene()
        assert made.output_step == pytest.approx(output, rel=1e-12)

    @pytest.mark.parametrize(("step", "output"), [("0.1", "0.3"), ("0.01", "1e3"), ("1/3", "1")])
    def test_multiples_in_spite_of_rounding(self, load: Load, step: str, output: str) -> None:
        step = f"{1 / 3!r}" if "/" in step else step
        made = load(DRY + f"solver: {{step: {step}}}\noutput: {{step: {output}}}").scene()
        assert made.output_step == float(output)


def test_names_of_the_outputs_own_forces_are_taken(refusal: Refusal) -> None:
    assert RESERVED == (*BODY_ROWS, WEIGHT)
    text = element(f"{MOORING}, stiffness: {{surge: 1}}")
    assert "the output has a force of that name" in refusal(text.replace("element", "radiation"))


FRAMES = [  # of a section below: where the message is, and the case with KEYS in it
    ("body", "case.yaml:4: bodies.block", body("KEYS")),
    ("body in surge", "case.yaml:4: bodies.block", body("mass: 1, dofs: [surge], KEYS")),
    ("duration", "case.yaml:2: duration", DRY.replace("60 s", "KEYS")),
    ("waves", "case.yaml:5: environment.waves", waves("KEYS")),
    ("jonswap", "case.yaml:5: environment.waves.", waves(f"{{{JONSWAP}, KEYS}}")),
    ("water", "case.yaml:5: environment.", DRY + "environment: {KEYS}"),
    ("mooring", ELEMENT, element(f"{MOORING}, KEYS")),
    ("applied force", ELEMENT, element(f"{APPLIED}, KEYS")),
    ("force over time", f"{ELEMENT}.force.surge", element(f"{APPLIED}, force: {{surge: KEYS}}")),
    ("force over time", f"{ELEMENT}.normal.prescribed", fender("prescribed: KEYS")),
    ("normal", f"{ELEMENT}.normal", fender("KEYS")),
    ("friction", f"{ELEMENT}.friction", fender(friction="KEYS")),
    ("spring", ELEMENT, element(f"{SPRING}, KEYS")),
    ("strut", ELEMENT, element(f"{STRUT}, KEYS")),
    ("torsion spring", ELEMENT, element(f"{TORSION}, KEYS")),
    ("coordinates", ELEMENT, element("body: block, type: KEYS")),
    ("bushing", ELEMENT, element("type: bushing, body: block, KEYS")),
    ("solver", "case.yaml:5: ", DRY + "KEYS"),
    ("output", "case.yaml:5: output.step", DRY + "output: {step: KEYS}\nsolver: {step: 0.1}"),
]
REFUSED = """
body
  mass: -1, dofs: [surge] | .mass | -1
  mass: 0 kg, dofs: [surge] | .mass | "0 kg"
  mass: 3 kN, dofs: [surge] | .mass | "3 kN"
  mass: .nan, dofs: [surge] | .mass | ".nan"
  mass: true, dofs: [surge] | .mass | true
  mass: 1 | | none
  mass: 1, dofs: surge | .dofs | "surge"
  mass: 1, dofs: [surge, surge] | .dofs | [surge, surge]
  mass: 1, dofs: [surge, jaw] | .dofs | [surge, jaw]
  mass: 1, dofs: [1] | .dofs.0 | 1
  mass: 1, radii_of_gyration: [1, 2] | .radii_of_gyration | a list of 2
  mass: 1, radii_of_gyration: [1, 2, 3, 4] | .radii_of_gyration | a list of 4
  mass: 1, radii_of_gyration: [1, 0, 3] | .radii_of_gyration.1 | 0
  mass: 1, radii_of_gyration: [1, 1, 1], inertia: [[1,0,0],[0,1,0],[0,0,1]] | | \
    radii_of_gyration and inertia
  mass: 1, inertia: [[1,2,0],[2,1,0],[0,0,1]] | .inertia | a matrix that is not
  mass: 1, inertia: [[0,0,0],[0,1,0],[0,0,1]] | .inertia | a matrix that is not
  mass: 1, inertia: [[1,.5,0],[0,1,0],[0,0,1]] | .inertia | 0.5 in row 1
body in surge
  database_body: 2 | | database_body and no
  colour: red | .colour | an unknown key
  radiation: fft | .radiation | "fft"
  radiation: {model: fft} | .radiation.model | "fft"
  radiation: constant | .radiation | no key "period"
  radiation: {model: convolution, length: 1 s, step: 2 s} | .radiation | length 1 s
  wave_forces: {second_order: full} | .wave_forces.second_order | "full"
  initial: {velocity: [1, 0, 1, 0, 0, 0]} | | an initial velocity in heave
  initial: {position: [1, 0, 0, 1 m, 0, 0]} | .initial.position.3 | "1 m"
  location: [1 m] | .location | a list of 1
duration
  0 | |
  -1 s | |
  nan | |
  infinite | |
waves
  {spectrum: jonswop, peak_period: 8} | .spectrum | "jonswop"
  {peak_period: 8} | | no key "spectrum"
  {spectrum: jonswap, peak_period: 8} | | no key "significant_height"
  {spectrum: regular, amplitude: 1, period: 0} | .period | 0
  {spectrum: regular, amplitude: -1, period: 1} | .amplitude | -1
  {spectrum: regular, amplitude: 1, period: 1, height: 2} | .height | an unknown
  {spectrum: regular, amplitude: 1, period: 1, heading: 3 m} | .heading | "3 m"
  [{spectrum: none}, {spectrum: regular, period: 1}] | .1 | no key "amplitude"
  off | | "off"
jonswap
  seed: -1 | seed | -1
  seed: 1.5 | seed | 1.5
  seed: true | seed | true
  peak_enhancement: 0.9 | peak_enhancement | 0.9
  ramp: -1 s | ramp | "-1 s"
  repeat_period: 59 s | repeat_period | 59 s; expected the duration or more, 60 s
water
  water_depth: 0 m | water_depth |
  water_density: -1 | water_density |
  gravity: 9.81 m/s | gravity |
  water_deph: 3 | water_deph |
mooring
  stiffness: {surge: 3 kN} | .stiffness.surge | "3 kN"
  stiffness: {surge: 40 t/m} | .stiffness.surge | "40 t/m"
  stiffness: {roll: 3 N/m} | .stiffness.roll | "3 N/m"
  stiffness: {surge: -1} | .stiffness | -1 for surge
  stiffness: {surg: 1} | .stiffness.surg | an unknown key
  stiffness: 3 | .stiffness | 3; expected a mapping
  stiffness: [[1, 2]] | .stiffness.0 | a list of 2
  stiffness: {surge: 1}, damping: {surge: -1} | .damping | -1 for surge
  stiffness: {surge: 1}, damping: {surge: 1}, damping_ratio: {surge: 1} | | \
    damping and damping_ratio
  stiffness: {surge: 1}, damping_ratio: {heave: .1} | | a damping_ratio in hea
  stiffness: {surge: 1}, damping_ratio: {surge: -1} | .damping_ratio.surge | -1
applied force
  time: [0, 2, 1], force: {surge: [1, 2, 3]} | .time | 1 after 2
  time: [0, 1, 1], force: {surge: [1, 2, 3]} | .time | 1 after 1
  time: [0, nan s], force: {surge: [1, 2]} | .time.1 | "nan s"
  time: [], force: {surge: []} | .time | nothing in it
  time: [0, 1], force: {surge: [1, 2, 3]} | | 3 values in force.surge and 2 in time
  time: [0, 1], force: {surge: 1} | | 1 values in force.surge and 2 in time
  force: {surge: [1, 2]} | | 2 values in force.surge and 1 in time
  time: [0], force: {surge: [1 kN*m]} | .force.surge.0 | "1 kN*m"
  force: {roll: 1 kN} | .force.roll | "1 kN"
  frame: ship, force: {surge: 1} | .frame | "ship"
  point: [0, 0], force: {surge: 1} | .point | a list of 2
force over time
  {time: [0, 1], force: [1]} | | 2 times and 1 forces; expected a force for each
  {time: [1, 0], force: [1, 2]} | .time | 0 after 1
  {force: [1, 2]} | | no key "time"
  {time: [0, 1], force: [1, 2 m]} | .force.1 | "2 m"; expected a force
  {amplitude: 1, period: 0 s} | .period | "0 s"
  {amplitude: 1 m, period: 1} | .amplitude | "1 m"; expected a force
  {amplitude: 1, period: 1, fase: 1} | .fase | an unknown key; expected one of: amp
  {mean: 1} | | no key "amplitude"
  {} | | no key "amplitude"
  {file: nowhere.csv, column: 2} | .file | no such file at nowhere.csv
  {file: ., column: 2} | .file | a directory at
  {file: case.yaml} | | no key "column"
  {column: 2} | | no key "file"
  {file: case.yaml, column: []} | .column | nothing in it
  {file: case.yaml, column: 1.5} | .column | 1.5; expected text
  {file: case.yaml, column: 2, factor: big} | .factor | "big"
  {file: case.yaml, column: 2, factor: 2 ton} | .factor | "2 ton"
  {file: case.yaml, column: 2, factor: 2 blah} | .factor | "2 blah"; expected a fac
  {file: run.nc, column: 2, case: none.yaml} | .case | no such file at none.yaml
  {file: a/run.nc, column: 2, case: case.yaml} | .file | no folder a; expected it
normal
  compression: [0, 1, 1], force: [0, 1, 2] | .compression | 1 after 1
  compression: [0, 1, 2], force: [0, 2, 1] | .force | 1 after 2
  compression: [0.1, 1], force: [0, 1] | .compression | [0.1, 1]
  compression: [0, 1], force: [1, 2] | .force | [1, 2]
  compression: [0], force: [0] | .compression | [0]
  compression: [0, 1, 2], force: [0, 1] | | 3 values in compression and 2 in force
  compression: [0, 1], force: [0, 0] | | no force at any compression
  compression: [0, 1] | | compression; expected stiffness, or
  stiffness: 1, force: [0, 1] | | stiffness and force
  damping: 1 | | no curve
  stiffness: 0 | .stiffness | 0
  stiffness: 5 kN | .stiffness | "5 kN"
  stiffness: 5, damping: -1 | .damping | -1
  stiffness: 5, total: yes | .total | "yes"
friction
  law: stick_slip, static: .1, kinetic: .2, stiffness: 1, damping: 1 | | static 0.1, k
  law: stick_slip, static: .2, kinetic: -.1, stiffness: 1, damping: 1 | .kinetic | -0.1
  law: stick_slip, static: .2, kinetic: .1, stiffness: 0, damping: 1 | .stiffness | 0
  law: stick_slip, static: .2, kinetic: .1 | | no key "stiffness"
  law: friction_slope, coefficient: .2, slope: 0 | .slope | 0
  law: friction_slope, coefficient: .2, slope: 1, static: 1 | .static | an unknown key
  law: glue, coefficient: .2 | .law | "glue"; expected one of: stick_slip,
  coefficient: .2 | | no key "law"
spring
  | | no curve; expected either stiffness or curve
  stiffness: 1, curve: {extension: [0, 1], tension: [0, 1]} | | stiffness and cur
  stiffness: 0 | .stiffness | 0
  stiffness: 5 kN | .stiffness | "5 kN"
  stiffness: 1, damping: -1 | .damping | -1
  stiffness: 1, lenght: 1 | .lenght | an unknown key
  curve: {extension: [0, 2, 1], tension: [0, 1, 2]} | .curve.extension | 1 after 2
  curve: {extension: [0, 1, 2], tension: [0, 2, 1]} | .curve.tension | 1 after 2
  curve: {extension: [0, 1], tension: [1, 2]} | .curve.tension | [1, 2]; expected a
  curve: {extension: [0, 1], tension: [0, 0]} | .curve | no tension at any extension
  curve: {extension: [0, 1], tension: [0, 1, 2]} | .curve | 2 values in extension
  curve: {extension: [0, 1]} | .curve | no key "tension"
  curve: {extension: [-7, 1], tension: [0, 1]} | | length 6 m and a first extension
  stiffness: 1, anchor_body: blok | .anchor_body | "blok"; expected a body of this
  stiffness: 1, anchor_body: block | .anchor_body | "block" on both sides
strut
  | | nothing that acts; expected stiffness, curve, damping or
  stiffness: 0 | | nothing that acts
  stiffness: 1, curve: {extension: [0, 1], force: [0, 1]} | | stiffness and curve
  stiffness: 5 kN | .stiffness | "5 kN"
  stiffness: 1, damping: -1 | .damping | -1
  damping: 1 kN*m*s/rad | .damping | "1 kN*m*s/rad"
  stiffness: 1, length: 0 | .length | 0
  stiffness: 1, neutral: 1 | .neutral | an unknown key
  curve: {extension: [0, 2, 1], force: [0, 1, 2]} | .curve.extension | 1 after 2
  curve: {extension: [0, 1], force: [0, 1, 2]} | .curve | 2 values in extension
  curve: {extension: [0], force: [0]} | .curve | 1 points; expected two or more
  curve: {extension: [0, 1]} | .curve | no key "force"
  stiffness: 1, anchor_body: blok | .anchor_body | "blok"; expected a body of this
  stiffness: 1, anchor_body: block | .anchor_body | "block" on both sides
torsion spring
  stiffness: 1 | | no key "axis"
  axis: [0, 0, 0], stiffness: 1 | | an axis of no length
  axis: [0, 1], stiffness: 1 | .axis | a list of 2
  axis: [0, 1, 0] | | nothing that acts
  axis: [0, 1, 0], stiffness: 1 kN/m | .stiffness | "1 kN/m"
  axis: [0, 1, 0], damping: 1, point: [0, 0, 0] | .point | an unknown key
  axis: [0, 1, 0], curve: {angle: [0, 1], moment: [0]} | .curve | 2 values in angle and 1 in moment
  axis: [0, 1, 0], damping: 1, to: block | .to | "block" on both sides
coordinates
  gas_spring, ALONG, push: 1, gas_length: 5, stroke: -5 deg | .stroke | "-5 deg"; expected a stroke
  stop, lowest: 1, stiffness: 1 | | no coordinate; expected one: point and anchor
  stop, ALONG, ABOUT, lowest: 1, stiffness: 1 | | point and axis
  stop, ALONG, motion: angle, lowest: 1, stiffness: 1 | | motion without joint
  stop, ALONG, stiffness: 1 | | no stop
  stop, ALONG, highest: 0 m, stiffness: 1 | | highest 0; expected a distance
  stop, ALONG, lowest: 2, highest: 2, stiffness: 1 | | lowest 2 and highest 2
  gas_spring, ALONG, push: 1, stroke: 4, gas_length: 5, neutral: 1, stiffness: 1 | | \
    neutral 1 and a stroke of 4; expected ends that never meet
  dry_friction, ALONG, static: 1, kinetic: 2, stiffness: 1 | | static 1, kin
  spring_damper, ABOUT | | nothing that acts
  spring_damper, ALONG, neutral: -1, damping: 1 | | neutral -1; expected a dist
bushing
  point: [0, 0, 0] | | nothing that acts; expected stiffness, damping, or both
  stiffness: {surge: -1} | .stiffness | -1 for surge; expected 0 or more
  stiffness: {roll: 3 N/m} | .stiffness.roll | "3 N/m"
  stiffness: 3 | .stiffness | 3; expected a mapping
  stiffness: {surge: 1}, to: blok | .to | "blok"; expected a body of this case
  stiffness: {surge: 1}, anchor: [0, 0, 0] | .anchor | an unknown key
solver
  solver: {step: 0} | solver.step | 0; expected a time in s
  solver: {step: -0.1 s} | solver.step | "-0.1 s"
  solver: {step: 61 s} | solver.step | 61 s; expected no more than the duration
  solver: {method: rk5} | solver.method | "rk5"; expected one of: rk2, heun, rk4
  solver: {kinematics: small} | solver.kinematics | "small"
  output: {file: a.nc} | output.file | an unknown key; expected one of: step
output
  0.25 | | 0.25 s; expected a multiple of solver.step
  0.05 | | 0.05 s; expected a multiple of solver.step
"""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (frame.replace("KEYS", keys), f"{place}{key}: found {found}")
        for name, place, frame in FRAMES
        for keys, key, found in sections(REFUSED)[name]
    ],
)
def test_refused(refusal: Refusal, text: str, message: str) -> None:
    assert refusal(text.replace("ALONG", ALONG).replace("ABOUT", ABOUT)).startswith(message)
