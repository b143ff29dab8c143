"""Commands as they are typed now: their order, their earlier names, and the same from Python."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import Command, built_commands

import hydrosim as hs
from hydrosim.cli.earlier import NEW_WORDS, current_arguments
from hydrosim.cli.terminal import with_options
from hydrosim.compare.dataset import differences, read_result

ORDER = "new check analyse run study show report compare export decay db"
UNCHANGED = "new check run report export compare"
OF_DATABASES = "info check convert kernel build"
MAX_LINES_OF_HELP = 34
MAX_PARAMETERS = 131
BLOCK = """\
title: A block on a spring
duration: 20 s
environment: {waves: {spectrum: jonswap, significant_height: 1 m, peak_period: 8 s, heading: 0 deg}}
bodies:
  block:
    mass: 1000 tonne
    radii_of_gyration: [3 m, 3 m, 3 m]
    dofs: [surge]
    initial: {position: {surge: 1 m}}
forces:
  spring:
    type: linear_mooring
    body: block
    natural_period: {surge: 9 s}
    damping_ratio: {surge: 5 %}
solver: {method: rk4, step: 0.1 s}
output: {step: 0.5 s, impulses: true}
"""
STUDY = """\
case: block.yaml
parameters:
  bodies.block.mass: [900 tonne, 1000 tonne]
figures:
  way: {channel: position.block.surge, statistic: end}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with a case in waves and a study of it."""
    (tmp_path / "block.yaml").write_text(BLOCK)
    (tmp_path / "study.yaml").write_text(STUDY)
    return tmp_path


def test_commands_stand_in_the_order_of_use(hydrosim: Command, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert " ".join(built_commands().commands) == ORDER
    assert " ".join(built_commands().commands["db"].commands) == OF_DATABASES
    result = hydrosim("--help")
    assert result.code == 0
    places = [result.out.index(f"│ {name} ") for name in ORDER.split()]
    assert places == sorted(places)


def test_help_fits_a_screen(
    hydrosim: Command, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line for each command."""
    commands = built_commands().commands.values()
    assert all(len(command.get_short_help_str(limit=100)) <= 67 for command in commands)


def test_parameters_are_few() -> None:
    commands = built_commands().commands
    leaves = [*commands.values(), *commands["db"].commands.values()]
    names = [
        param.name
        for command in leaves
        if not hasattr(command, "commands")
        for param in command.params
        if param.name != "help"
    ]
    assert len(names) <= MAX_PARAMETERS


@pytest.mark.parametrize(
    "name", [*NEW_WORDS, *UNCHANGED.split(), "db", *(f"db {of}" for of in OF_DATABASES.split())]
)
def test_every_earlier_command_has_help(hydrosim: Command, name: str) -> None:
    result = hydrosim(*name.split(), "--help")
    assert (result.code, "Usage: hydrosim" in result.out) == (0, True)
    note = NEW_WORDS.get(name, "").partition(" ")[0]
    assert result.err == (f"note this is now: hydrosim {note} --help" if note else "")


@pytest.mark.parametrize(
    ("earlier", "current"),
    [
        ("linear a.yaml --time 3", "analyse a.yaml --time 3"),
        ("line a.yaml --line bow", "analyse a.yaml --line bow"),
        ("line a.yaml -o x.png", "analyse a.yaml -o x.png --line all"),
        ("line a.dat --case", "export a.dat --case"),
        ("ballast a.yaml --lift 3", "analyse a.yaml --lift 3 --ballast"),
        ("converge a.yaml --steps 0.1", "analyse a.yaml --steps 0.1 --converge"),
        ("plot a.nc --from 3", "show a.nc --from 3 --plot"),
        ("replay a.nc", "report a.nc --replay"),
        ("statistics a.nc", "show a.nc --statistics"),
        ("explain a.nc", "show a.nc --why surge"),
        ("explain a.nc --until 3 --body b", "show a.nc --to 3 --why b.surge"),
        ("explain --direction=sway a.nc", "show a.nc --why sway"),
        ("case a.nc --run 3", "export a.nc --run 3 --case"),
        ("sweep a.yaml --plot", "study a.yaml --plot"),
        ("operability a.yaml", "study a.yaml"),
        ("calibrate a.csv b.csv", "decay a.csv b.csv"),
        ("schema", "new --schema case"),
        ("schema study", "new --schema study"),
        ("example", "new --example list"),
        ("example flap -o there", "new there --example flap"),
        ("db build a.yaml --jobs 2 --picture", "db build a.yaml --workers 2 --plot"),
        ("run a.yaml --plot", "run a.yaml --plot"),
        ("--version", "--version"),
    ],
)
def test_earlier_commands_are_typed_otherwise_now(earlier: str, current: str) -> None:
    assert current_arguments(earlier.split()) == current.split()


def test_messages_name_options_as_they_are_typed() -> None:
    options = {"start": "--from", "end": "--to", "kg": "--kg"}
    told = with_options(
        "start, end: found 3; expected times. Leave `start` or `other` out.", options
    )
    assert told == "--from, --to: found 3; expected times. Leave --from or `other` out."
    assert with_options("run.nc: found start: 3", options) == "run.nc: found start: 3"
    assert with_options("start, place: found", options) == "start, place: found"


def test_earlier_and_present_commands_do_the_same(hydrosim: Command, folder: Path) -> None:
    """What they print, and the files that they write."""
    assert hydrosim("run", "block.yaml").code == 0
    for earlier, current in (
        (("case", "block.nc"), ("export", "block.nc", "--case")),
        (("schema", "study"), ("new", "--schema", "study")),
        (("example",), ("new", "--example", "list")),
        (("statistics", "block.nc"), ("show", "block.nc", "--statistics")),
        (("explain", "block.nc"), ("show", "block.nc", "--why", "surge")),
        (("plot", "block.nc"), ("show", "block.nc", "--plot")),
        (("linear", "block.yaml"), ("analyse", "block.yaml")),
        (("sweep", "study.yaml"), ("study", "study.yaml")),
    ):
        first, second = hydrosim(*earlier), hydrosim(*current)
        assert (first.code, first.out) == (second.code, second.out) == (0, first.out)
        assert f"note this is now: hydrosim {' '.join(current)}" in first.err
        assert "note" not in second.err


def test_show_prints_what_was_printed(hydrosim: Command, folder: Path) -> None:
    """Of a run, many runs, an analysis and a comparison."""
    for command, file in (
        (("run", "block.yaml"), "block.nc"),
        (("study", "study.yaml"), "study.nc"),
        (("analyse", "block.yaml"), "block_linear.nc"),
        (("compare", "block.nc", "block.nc"), "block_compare.nc"),
    ):
        printed = hydrosim(*command)
        assert printed.code == 0, printed.err
        shown = hydrosim("show", file)
        assert shown.code == 0
        assert shown.out in printed.out
        assert len(shown.out) > 200


def test_a_picture_of_channels_has_the_name_that_is_asked_for(
    hydrosim: Command, folder: Path
) -> None:
    assert hydrosim("run", "block.yaml").code == 0
    view = "show", "block.nc", "--plot", "--channels", "position.*"
    for name in ("heave.svg", "heave.svg", "sub/heave.pdf"):
        assert f"picture {name}" in hydrosim(*view, "-o", name).out
        assert (folder / name).is_file()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("analyse block.yaml --lift 3", "--lift: not possible with a linear analysis"),
        ("analyse block.yaml --ballast --converge", "--ballast, --converge: found several"),
        ("show block.nc --why surge --plot", "--why, --plot: found several"),
        ("show block.nc --from 3", "--from: not possible with a summary"),
        ("show block.nc --plot -o a.png", "--output: found a.png; expected a folder for several"),
        ("report block.nc -o a.pdf", "expected .html, which a browser prints to PDF"),
        ("show block.nc --plot --duration 3", "--duration: not possible with --plot"),
        ("export block.nc", "--output: found none; expected a file that ends in .nc"),
        ("export block.nc --run 3 -o a.csv", "--run: found no --case; expected both"),
        ("export block.nc --case -o a.yaml", "--output: not possible with --case"),
        ("new own.yaml --length 3", "--beam, --draught: found none; expected CASE.yaml, --length"),
        ("analyse block.nc", "block.nc: "),
        ("show block.nc --why pitch", "--why: found pitch; expected one of surge, sway, heave"),
        ("new --schema recipe --kg 3", "--kg: not possible with --schema"),
        ("new --hs 2", "No such option: --hs (Possible options: --significant-height)"),
        ("show block.nc --start 9", "No such option: --start (Possible options: --from)"),
        ("run block.yaml --seed 2", "(Possible options: --set environment.waves.seed=)"),
        ("stats block.nc", "No such command 'stats'. Type: hydrosim show RUN.nc --statistics"),
        ("new --schema cases", "--schema: found 'cases'; expected one of case, study, recipe"),
    ],
)
def test_what_does_not_go_together_is_told(
    hydrosim: Command, folder: Path, arguments: str, words: str
) -> None:
    result = hydrosim(*arguments.split())
    assert result.code == 2
    assert words in result.err


def same(first: Path, second: Path) -> bool:
    """Whether two results are identical, and say the same of their origin."""
    one, other = read_result(first), read_result(second)
    assert one.attrs["history"] == other.attrs["history"]
    assert one.attrs.get("settings") == other.attrs.get("settings")
    return differences(one, other) == []


def test_python_writes_the_files_of_the_commands(hydrosim: Command, folder: Path) -> None:
    """Of a run, a study with its table, analyses and statistics."""
    assert hydrosim("run", "block.yaml", "-o", "a.nc").code == 0
    run = hs.simulate("block.yaml", output="b.nc")
    assert same(folder / "a.nc", folder / "b.nc")
    assert run.position.equals(hs.open_run("a.nc").position)

    assert hydrosim("study", "study.yaml").code == 0
    Path("a_study.nc").write_bytes(Path("study.nc").read_bytes())
    table = Path("study.csv").read_text()
    result = hs.study("study.yaml", output=True)
    assert same(folder / "a_study.nc", folder / "study.nc")
    assert Path("study.csv").read_text() == table
    assert np.array_equal(hs.study("study.yaml").dataset.way, result.dataset.way)

    options = ("--time", "2 s", "--periods", "6,8")
    assert hydrosim("analyse", "block.yaml", "-o", "a_linear.nc", *options).code == 0
    hs.analyse("block.yaml", time=2.0, periods=[6, 8], output="b_linear.nc")
    assert same(folder / "a_linear.nc", folder / "b_linear.nc")
    assert Path("b_linear.png").is_file()

    assert hydrosim("show", "a.nc", "--statistics", "--from", "2 s", "-o", "as.nc").code == 0
    hs.open_run("a.nc").hydrosim.extremes(start=2.0, output="bs.nc")
    assert same(folder / "as.nc", folder / "bs.nc")


def compare_exactly() -> object:
    return hs.compare("block.nc", "block.nc", exact=True)


def test_python_prints_the_text_of_the_commands(hydrosim: Command, folder: Path) -> None:
    for command, result in (
        ("run block.yaml", lambda: hs.simulate("block.yaml").hydrosim.summary()),
        ("analyse block.yaml", lambda: hs.analyse("block.yaml")),
        ("show block.nc --why surge", lambda: hs.open_run("block.nc").hydrosim.explain()),
        ("compare block.nc block.nc", lambda: hs.compare("block.nc", "block.nc")),
        (
            "compare block.nc block.nc --exact",
            lambda: hs.compare("block.nc", "block.nc", exact=True),
        ),
    ):
        told = hydrosim(*command.split())
        assert told.code == 0
        text = " ".join(str(result()).split())
        assert len(text) > 50
        assert text[:200] in told.out


def test_schema_is_that_of_python(hydrosim: Command) -> None:
    from hydrosim.interface.new import FileKind, schema_of

    assert json.loads(hydrosim("new", "--schema", "case").out) == schema_of(FileKind.CASE)


def test_a_new_case_runs(hydrosim: Command) -> None:
    """Its coefficients are among the settings of the result."""
    sides = ("--length", 180, "--beam", 55, "--draught", 8)
    assert hydrosim("new", "own.yaml", *sides).code == 0
    result = hydrosim("run", "own.yaml", "--set", "duration=5 s")
    assert result.code == 0, result.err
    settings = json.loads(hs.open_run("own.nc").attrs["settings"])
    assert settings["bodies.barge.hydrodynamics.added_mass.heave"] > 1e8
