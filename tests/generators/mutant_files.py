"""Files of other programs, decays of roll and results, right ones, and how each is read.

What is read of a file of another program is kept as a `Reading`, so that a mutant of a name there
may be compared with the file that is right. A result is opened by a command, as its user would.
"""

import warnings
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import fields
from functools import cache
from hashlib import sha256
from io import StringIO
from pathlib import Path
from random import Random
from shutil import copy
from tempfile import TemporaryDirectory
from typing import NamedTuple

import netCDF4
import numpy as np
import yaml

from hydrosim.__main__ import app
from hydrosim.analysis.line import lines_of_system, offsets_to, response
from hydrosim.case.lines import chains
from hydrosim.database import load
from hydrosim.database.load import read as read_database
from hydrosim.elements.roll_decay import fit_files
from hydrosim.files.text import Source
from hydrosim.report.sentences.analysis import calibration_document, keys_of
from tests.case import mooring_files
from tests.generators.mutants import CASES
from tests.orcaflex_files import contents

H851 = CASES.parent / "hydro_db" / "h851.nc"
RUN = CASES / "reverse_float_over" / "base.yaml"
DECAY = "time [s],roll [deg]\n" + "".join(
    f"{0.2 * k:.1f},{8.0 * np.exp(-0.01 * k) * np.cos(0.2 * k):.4f}\n" for k in range(200)
)
NUMBERS = (np.nan, np.inf, -1.0, 0.0, 1e15, 1e99, 1e308, 1e-300)
"""What stands in a damaged variable of a result."""
SUFFIXES = {
    **dict.fromkeys(("report", "report --replay"), ".html"),
    **dict.fromkeys(("show --statistics", "compare"), ".nc"),
    "export": ".csv",
    "show --plot": "",
}
COMMANDS = (*SUFFIXES,)


class Reading(NamedTuple):
    """The ``content`` of a file of another program, and what was ``told`` to be left out."""

    content: str
    told: tuple[str, ...] = ()


def read_mooring(path: Path) -> Reading:
    """Lines as `hydrosim analyse` shows them, and as keys of a case."""
    assert chains.is_mooring_file(path) or path.suffix != ".txt"
    source = Source(path)
    system = chains.read_mooring_system(source)
    lines = lines_of_system(system)
    for way in (False, True):
        response(lines[0], offsets_to(lines[0].usual_offset()), way)
    chains.case_keys(path)
    kept = chains.mooring_lines(
        system, chains.water_of_system(system, chains.DEFAULT_WATER), source
    )
    told = tuple(entry.message for entry in system.left_out)
    water = chains.water_of_system(system, chains.DEFAULT_WATER)
    return Reading(repr((kept, system.depth, system.friction, water)), told)


def read_vessel(path: Path) -> Reading:
    """A database of another program, as `hydrosim db` reads it."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        database = read_database(path)
    names = (field.name for field in fields(database) if field.name != "source")
    values = (getattr(database, name) for name in names)
    digest = sha256()
    for value in values:
        digest.update(value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode())
    return Reading(digest.hexdigest(), tuple(str(each.message) for each in told))


def read_decay_test(path: Path) -> None:
    """A fit, its page and its keys, as `hydrosim decay` writes them."""
    fit = fit_files([path])
    str(calibration_document(fit))
    keys_of(fit, "barge")


def mooring_texts() -> dict[str, tuple[str, str]]:
    """Text and suffix of mooring files by what they are."""
    return {
        "moordyn_2": (mooring_files.version_2(), ".txt"),
        "moordyn_2_body": (
            mooring_files.version_2("Body1  5  0  -10", "coupled 0 0 0 0 0 90 0 0 0 0 0 0"),
            ".txt",
        ),
        "moordyn_1": (mooring_files.DOCUMENTED_1, ".txt"),
        "moordyn_1_counts": (
            mooring_files.COUNTED_1.replace("{ends}", "NodeAnch NodeFair"),
            ".txt",
        ),
        "map": (mooring_files.MAP, ".txt"),
        "moorpy": (mooring_files.MOORPY_YAML, ".yaml"),
        "raft": (mooring_files.RAFT_YAML, ".yaml"),
    }


@cache
def vessel_text() -> str:
    """A vessel type of OrcaFlex with the hull of the shipped barge."""
    settings = {"Dumper": yaml.CSafeDumper, "sort_keys": False, "width": 10**6}
    return str(yaml.dump(contents(load(H851)), **settings))


def copy_results(folder: Path, study: str) -> None:
    """A short run, and the runs of a ``study``, as they are; made once."""
    for path in Path(_results(study).name).glob("*.nc"):
        copy(path, folder)


@cache
def _results(study: str) -> TemporaryDirectory[str]:
    made = TemporaryDirectory()
    _write_results(Path(made.name), study)
    return made


def _write_results(folder: Path, study: str) -> None:
    ask(["run", str(RUN), "--set", "duration=30 s", "-o", str(folder / "right_run.nc")])
    path = folder / "right_runs.yaml"
    path.write_text(study)
    ask(["study", str(path), "-o", str(folder / "right_runs.nc"), "--workers", "1"])


def ask(words: list[str]) -> None:
    """Ask a command in this process, without a terminal."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        app(words, standalone_mode=False)


def tamper(path: Path, random: Random, texts: tuple[str, ...]) -> str:
    """Change an attribute, numbers, a name or bytes of the result at ``path``; says which."""
    what = random.choice(("attribute", "attribute lost", "numbers", "number", "name", "bytes"))
    if what == "bytes":
        content = bytearray(path.read_bytes())
        at = random.randrange(len(content))
        content[at : at + random.choice((1, 100, len(content)))] = b""
        path.write_bytes(content)
        return f"bytes from {at} on"
    with netCDF4.Dataset(path, "a") as file:
        groups = [file, *file.groups.values()]
        holders = [file, *(variable for group in groups for variable in group.variables.values())]
        if what in ("attribute", "attribute lost"):
            holder = random.choice([each for each in holders if {*each.ncattrs()} - {"_FillValue"}])
            name = random.choice([name for name in holder.ncattrs() if name != "_FillValue"])
            value = random.choice((*texts, "[]", "{}", "[1]", '{"a": 1}', "null", "m, rad"))
            value = value.encode("utf-8", "replace").decode().replace("\0", "")
            if what == "attribute lost":
                holder.delncattr(name)
            else:
                holder.setncattr(name, value)
            return f"{what} {getattr(holder, 'name', '')} {name} {value[:20]!r}"
        return f"{what} {_change_variable(random.choice(groups), what, random)}"


def _change_variable(file: netCDF4.Dataset, what: str, random: Random) -> str:
    name = random.choice(list(file.variables))
    if what == "name":
        file.renameVariable(name, f"{name}_x")
        return name
    variable = file[name]
    if variable.dtype is str or variable.dtype.kind not in "fiu":
        variable[...] = np.full(variable.shape, random.choice(("", "x", "é\x1b[2J")), object)
        return f"{name} texts"
    value = random.choice(NUMBERS)
    if variable.dtype.kind != "f":
        value = random.choice((-1, 0, 10**9))
    values = np.array(variable[...])
    value = np.array(value).astype(values.dtype)
    if what == "number" and values.size:
        values.flat[random.randrange(values.size)] = value
    else:
        values[...] = value
    variable[...] = values
    return f"{name} {value}"


def show_result(path: Path, command: str) -> None:
    """Show a result by one of `COMMANDS`."""
    name, *view = command.split()
    is_table = command == "show --statistics" and path.stem == "runs"
    suffix = ".csv" if is_table else SUFFIXES[command]
    out = path.with_name(f"out_{name}{suffix}")
    others = [str(path.with_name(f"right_{path.name}"))] if command == "compare" else []
    ask([name, str(path), *others, *view, "-o", str(out), "--overwrite"])
