"""Mutants of all that is read besides cases: studies, criteria, hindcasts, scatter diagrams,
recipes of databases, maps of recordings, decays of roll, results, files of other programs.

Each is read in this process, as far as a command reads it before it computes; a hindcast and a
scatter diagram are also held against limits. It ends with a message or without, within 20 s of
CPU. The papers are read once before they are changed, so that no compilation counts.

A name that is changed in a file of another program may change what is read of it only with a
message, or with a word on what is left out; else it is silent.
"""

import re
import signal
import warnings
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from random import Random
from shutil import copy
from traceback import format_exc
from types import FrameType
from typing import NamedTuple

import numpy as np
import xarray as xr
import yaml

from hydrosim.compare.align import read_mapping
from hydrosim.database.build.recipe import load_recipe
from hydrosim.errors import HydrosimError
from hydrosim.files.document import Document, printable
from hydrosim.files.layers import read_case
from hydrosim.files.messages import validate_document
from hydrosim.report.sentences.limits import weather_nodes
from hydrosim.study.operability import load_limits
from hydrosim.study.study_file import StudyFile
from hydrosim.study.sweep import load_study
from hydrosim.study.weather import assess_weather, read_weather
from tests.generators import mutant_files
from tests.generators.mutant_trials import Outcome, said
from tests.generators.mutants import CASES, CHANGES, NUMBER, RENAMES, change, places, written

BASE = CASES / "reverse_float_over" / "base.yaml"
RECIPES = CASES.parent / "hydro_db"
HINDCAST = "time [h],hs [m],tp [s],direction [deg]\n" + "".join(
    f"{3 * k},{1 + 0.2 * (k % 5)},{7 + k % 4},{(40 * k) % 360}\n" for k in range(24)
)
SCATTER = "hs [m],6,8,10,12\n0.5,10,20,10,2\n1.5,5,10,8,3\n2.5,0,3,4,2\n"
LIMITS = f"""
case: {BASE}
seeds: 1-40
duration: 60 s
output: {{step: 0.5 s, start: 10 s}}
criteria:
  crawl: {{channel: position.barge.surge, statistic: end_absolute, limit: 1 m}}
  heave: {{channel: position.barge.heave, statistic: largest, limit: 2 m, phase: compressed}}
operability:
  heights: {{from: 0.4 m, to: 1.6 m, apart: 0.4 m}}
  peak_periods: [6 s, 8 s]
  headings: [0 deg, 45 deg]
  swells: [{{significant_height: 1 m, peak_period: 14 s, heading: 90 deg}}]
  probability: 90 %
  scatter: scatter.csv
  hindcast: hindcast.csv
  bearing: 240 deg
  operation:
    planned: 24 hour
    contingency: 12 hour
    alpha:
      source: table
      planned: [12 hour, 48 hour]
      heights: [1 m, 3 m]
      factors: [[0.7, 0.8], [0.6, 0.7]]
"""
STUDY = f"""
case: {BASE}
seeds: [1, 4]
duration: 60 s
output: {{step: 0.5 s, start: 10 s, variables: [position], impulses: true}}
figures:
  crawl: {{channel: position.barge.surge, statistic: end}}
until: {{figure: crawl, wide: 0.1 m, most: 50}}
parameters:
  forces.interface.friction.slip_damping: [0, 1e6]
  K_vert:
    keys: {{forces.interface.normal.stiffness: [20000 tonne_force/m, 40000 tonne_force/m]}}
    called: [soft, hard]
"""
RANGES = f"""
case: {BASE}
duration: 60 s
figures:
  crawl: {{channel: position.barge.surge, statistic: end}}
design: sobol_indices
samples: 8
parameters:
  sea: {{keys: {{environment.waves.seed: {{from: 1, to: 1000000}}}}}}
  C3:
    keys:
      forces.interface.friction.slip_damping: {{from: 10000, to: 1e10, scale: logarithmic}}
"""
MAP = """
time: {column: 1, unit: s, offset: 0 s, shift: false}
channels:
  position.barge.heave: Heave (m)
  position.barge.pitch: {column: 6, unit: deg, sign: -1}
  position.barge.surge: {column: Xbow, unit: m, offset: 2 m, point: [80, 0, 7.5]}
"""
STUDY_RUN = f"""
case: {BASE}
seeds: [1, 4]
duration: 20 s
parameters:
  forces.interface.friction.slip_damping: [0, 1e6]
"""
REFUSED = ("map",)
"""Papers of formats that are not read."""
FIELDS = (
    *("", "nan", "inf", "-1", "0", "1e300", "-1e300", "1e-300", "1e15", "abc", "1,5", "3;4", '"'),
    *("\0", "\x1b[2J", "漢字", "\ud800", "2020-01-31T12:00", "99999-01-01", "\n", "\t", "x" * 5000),
    *("time [h]", "hs [ft]", "tp [parsec]", "0" * 400, "[", "%s", "#", "-", "1_000", "٣"),
)
"""What may stand in a table in place of a number or a name."""

LONGEST = 20  # s of CPU
FOUND = xr.Dataset(
    {"limit": (("stage", "swell", "heading", "peak_period"), np.full((1, 1, 2, 2), 1.2))},
    {"stage": ["all"], "swell": ["none"], "heading": [0.0, 0.785], "peak_period": [7.0, 9.0]},
)
"""Limits, as a search finds them."""

Read = Callable[[Path], object]


class Paper(NamedTuple):
    """A kind of file: how it is read, and one that is right. A result has no text."""

    read: Read
    text: str
    suffix: str = ".yaml"


class Damage(NamedTuple):
    """What was changed, the text that results, and whether a name was."""

    what: str
    text: str
    of_name: bool = False


def _limits(path: Path) -> None:
    study = load_limits(path)
    read_weather(path.parent, study.wanted)


def _weather(path: Path) -> None:
    """Held against limits of the study that is right."""
    wanted = validate_document(read_case(path.with_name("right.yaml"))[1], StudyFile).operability
    assert wanted is not None
    other = "scatter" if path.stem == "hindcast" else "hindcast"
    weather = read_weather(path.parent, wanted.model_copy(update={other: None}))
    str(Document("weather", list(weather_nodes(assess_weather(FOUND, weather)))))


@cache
def papers() -> dict[str, Paper]:
    """One of each kind, by name; that of a table is its file's."""
    paths = sorted(RECIPES.glob("*.yaml"))
    recipes = {f"recipe_{path.stem}": Paper(load_recipe, path.read_text()) for path in paths}
    return {
        "limits": Paper(_limits, LIMITS),
        "study": Paper(load_study, STUDY),
        "ranges": Paper(load_study, RANGES),
        "map": Paper(read_mapping, MAP),
        "hindcast": Paper(_weather, HINDCAST, ".csv"),
        "scatter": Paper(_weather, SCATTER, ".csv"),
        "decay": Paper(mutant_files.read_decay_test, mutant_files.DECAY, ".csv"),
        "run": Paper(partial(mutant_files.show_result, command="show --statistics"), "", ".nc"),
        "runs": Paper(partial(mutant_files.show_result, command="show --statistics"), "", ".nc"),
        **{
            name: Paper(mutant_files.read_mooring, *text_and_suffix)
            for name, text_and_suffix in mutant_files.mooring_texts().items()
        },
        "orcaflex": Paper(mutant_files.read_vessel, mutant_files.vessel_text(), ".yml"),
        **recipes,
    }


def prepare(folder: Path) -> None:
    """Put what papers read into a folder."""
    (folder / "right.yaml").write_text(LIMITS)
    _write_tables(folder)
    mutant_files.copy_results(folder, STUDY_RUN)
    for file in (*RECIPES.glob("*.yaml"), *RECIPES.glob("*.obj")):
        copy(file, folder)
    _compile(folder)


@cache
def _compile(folder: Path) -> None:
    """Read each paper as it is: kernels that are compiled on the way are no hang of a mutant."""
    for paper, kind in papers().items():
        path = folder / f"{paper}{kind.suffix}"
        write_right(path, kind)
        if kind.text and paper not in REFUSED:
            kind.read(path)


def write_right(path: Path, kind: Paper) -> None:
    """Write a paper as it is; a result is copied from the one that `prepare` made."""
    if kind.suffix == ".nc":
        copy(path.with_name(f"right_{path.name}"), path)
    else:
        path.write_text(kind.text)


@cache
def _right(paper: str, path: Path) -> object:
    """What is read of the paper as it is, in the file at ``path``."""
    kind = papers()[paper]
    write_right(path, kind)
    return kind.read(path)


def _write_tables(folder: Path) -> None:
    for table, text in (("hindcast", HINDCAST), ("scatter", SCATTER)):
        (folder / f"{table}.csv").write_text(text)


def trial(paper: str, number: int, folder: Path) -> tuple[str, Outcome]:
    """The mutant of a ``paper`` with this number: which change it is, and what comes of it."""
    kind = papers()[paper]
    random = Random(f"{paper} {number}")
    _write_tables(folder)
    path = folder / f"{paper}{kind.suffix}"
    read = kind.read
    if kind.suffix == ".nc":
        write_right(path, kind)
        damage = Damage(mutant_files.tamper(path, random, FIELDS), "")
        command = random.choice(mutant_files.COMMANDS)
        damage = damage._replace(what=f"{command} of {damage.what}")
        read = partial(mutant_files.show_result, command=command)
    else:
        ways = {".csv": _table, ".txt": _words}
        damage = ways.get(kind.suffix, _document)(kind.text, random)
        path.write_bytes(damage.text.encode("utf-8", "surrogatepass"))
    outcome = _judged(read, path)
    if outcome.status == "complete" and damage.of_name and _is_silent(paper, path):
        outcome = Outcome("silent", "what is read is another thing, and nothing was told")
    return damage.what, outcome


def _judged(read: Read, path: Path) -> Outcome:
    """Read a file within `LONGEST`."""
    signal.signal(signal.SIGPROF, _too_long)
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read(path)
    except HydrosimError as error:
        return said("refused", printable(str(error)))
    except TimeoutError:
        return Outcome("hang", format_exc(limit=-6))
    except Exception:
        return Outcome("crash", format_exc(limit=-6))
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    return Outcome("complete")


def _is_silent(paper: str, path: Path) -> bool:
    """Whether a foreign file with a changed name is read as something else without a word."""
    found = papers()[paper].read(path)
    if not isinstance(found, mutant_files.Reading):
        return False
    right = _right(paper, path.with_name(f"right_{path.name}"))
    assert isinstance(right, mutant_files.Reading)
    return found.content != right.content and {*found.told} <= {*right.told}


def _too_long(number: int, frame: FrameType | None) -> None:
    raise TimeoutError


def _document(text: str, random: Random) -> Damage:
    """A document of YAML with one key changed."""
    document = yaml.safe_load(text)
    keys = random.choice([*places(document)])
    ways = [*CHANGES, *RENAMES] if isinstance(keys[-1], str) else [*CHANGES]
    how = random.choice(ways)
    change(document, keys, how)
    return Damage(f"{keys} {how}", written(document), how in RENAMES)


def _words(text: str, random: Random) -> Damage:
    """A text with one word changed or lost, or one line lost or doubled."""
    if not random.randrange(6):
        return _table(text, random)
    words = re.split(r"(\s+)", text)
    at = random.randrange(0, len(words), 2)
    before = words[at]
    words[at] = random.choice((*FIELDS, "", f"{before}s", before[:-1], before.swapcase()))
    is_name = not NUMBER.match(before) and before.strip("-") != ""
    return Damage(f"word {at // 2} {before!r}: {words[at][:20]!r}", "".join(words), is_name)


def _table(text: str, random: Random) -> Damage:
    """A table with one field changed, or one line lost, doubled or moved."""
    lines = text.splitlines()
    at = random.randrange(len(lines))
    match random.randrange(6):
        case 0:
            del lines[at]
            return Damage(f"line {at} lost", "\n".join(lines))
        case 1:
            lines.insert(random.randrange(len(lines)), lines[at])
            return Damage(f"line {at} again", "\n".join(lines))
    fields = lines[at].split(",")
    place = random.randrange(len(fields))
    fields[place] = random.choice(FIELDS)
    lines[at] = ",".join(fields)
    return Damage(f"line {at} field {place}: {fields[place][:20]!r}", "\n".join(lines))
