"""What runs compute and what the program says, to the bit: the judge of a change of neither.

    python -m benchmarks.checksums                    transitions of all runs, and restarts
    python -m benchmarks.checksums --against COMMIT   the same, and what differs from a commit
    python -m benchmarks.checksums --against FOLDER --parts numbers,schemas
    python -m benchmarks.checksums --speed [--against COMMIT]   steps per second, in turn

A record of a checkout has parts, which are compared one by one:

    numbers    every variable of every run, with its type, shape, dimensions and unit; numeric
               attributes, but for times of the clock
    texts      names, descriptions and other attributes; what commands print; reports
    schemas    keys of the JSON schemas of cases, studies and recipes
    messages   what is said of mutants of the shipped cases, with file and line

Transitions are counted between records, so that of several within a step there is one.

Both checkouts are recorded at once, each in one process with one thread of BLAS. This checkout
writes random cases and mutants, and both read them. The recording itself uses public names and
the command line alone, so that it can be run on other versions. Each works in a copy of its cases
and databases, in a folder whose name is equally long, so that lines break alike.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import json
import os
import re
import runpy
import shutil
import signal
import subprocess
import sys
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import reduce
from itertools import chain
from operator import getitem
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

import hydrosim as hs

ENVIRONMENT = {
    "OPENBLAS_NUM_THREADS": "1",
    "COLUMNS": "100",
    "NO_COLOR": "1",
    "TERM": "dumb",
    "PYTHONHASHSEED": "0",
}
HERE = Path(os.environ.get("HYDROSIM_HOME", Path(__file__).parents[1]))
PARTS = ("numbers", "texts", "schemas", "messages")
CLOCK = {"wall_time", "case_file", "case", "history", "date_created"}
"""Attributes of the clock and of places."""
CLOCK_LINES = re.compile(r"computing time|steps in a second|\d s so far|^compiling kernels")
SOLVER = "solver.method"
BASE = "reverse_float_over/base"
STATES = "output.states"
MAX_CHECK_TIME = 20  # s of CPU
MESSAGES = 300
DRAWN_ANEW = "sobol_indices"
"""A study whose intervals are drawn anew whenever they are printed: its numbers count alone."""
SHOWN = 20  # differences of a part that are printed
Settings = dict[str, Any]
Record = dict[str, dict[str, Any]]

CASES: dict[str, tuple[str, Settings]] = {
    "base case, all degrees of freedom": (BASE, {"solver.symmetry": "ignore", "duration": 1000}),
    "base case, oblique, rk2": (
        BASE,
        {"environment.waves.heading": "30 deg", SOLVER: "rk2", "duration": 700},
    ),
    "convolution": (BASE, {"bodies.barge.radiation": "convolution", "duration": 700}),
    "convolution, all degrees of freedom": (
        BASE,
        {"bodies.barge.radiation": "convolution", "duration": 600, "solver.symmetry": "ignore"},
    ),
    "quadratic transfer functions": (
        BASE,
        {"bodies.barge.wave_forces": {"second_order": "qtf"}, "duration": 300},
    ),
    "dopri5": (BASE, {SOLVER: "dopri5", "duration": 650}),
    "esdirk4": (BASE, {SOLVER: "esdirk4", "duration": 650}),
    "waves that follow": (
        "reverse_float_over/free_floating",
        {
            "bodies.barge.wave_forces": {"headings": "instantaneous", "position": "instantaneous"},
            "duration": 20,
        },
    ),
    "free floating": ("reverse_float_over/free_floating", {}),
    "no friction": ("reverse_float_over/no_friction", {}),
    "deballasting by tanks": ("reverse_float_over/tanks", {"duration": 700}),
    "sphere, decay": ("sphere/decay", {}),
    "sphere, decay, stepped": ("sphere/decay", {"solver.linear": "step"}),
    "sphere, regular wave": ("sphere/regular", {}),
    "coulomb, held": ("friction_block/held", {}),
    "friction slope": ("friction_block/slope_1e6", {}),
    "friction slope, stiff": ("friction_block/slope_1e8", {}),
    "chain": ("chain/circle", {}),
    "flap, decay": ("flap/decay", {}),
    "flume, decay": ("flume/decay", {}),
    "flume, fixed": ("flume/fixed", {}),
    "hinged barges, regular wave": ("hinged_barges/regular", {"duration": 300}),
    "lift off": ("lift_over_the_side/lift_off", {}),
    "lift without tuggers": ("lift_over_the_side/no_tuggers", {"duration": 200}),
    "line lost": ("turret_tanker/line_lost", {"duration": 1300}),
    "removal by tanks": ("topside_removal/tanks", {"duration": 900}),
    "lock-in, clamp": ("lock_in/clamp", {"duration": 700}),
    "lock-in, lines": ("lock_in/lines", {"duration": 700}),
    "lock-in, catenaries": ("lock_in/catenaries", {"duration": 700}),
}
"""Shipped cases that are simulated, by name, with settings."""
REPORTED: dict[str, int] = {
    BASE: 2000,
    "flap/irregular": 300,
    "flume/free": 17,
    "friction_block/exact": 1000,
    "hinged_barges/irregular": 300,
    "lift_over_the_side/compensated": 200,
    "lift_over_the_side/over_the_side": 200,
    "lock_in/pins": 700,
    "lock_in/ratchet": 700,
    "mating/mating": 2000,
    "numerical_oscillation/base": 1000,
    "one_dimensional/base": 800,
    "point_absorber/irregular": 300,
    "sphere/irregular": 600,
    "tender_alongside/alongside": 300,
    "topside_removal/removal": 900,
    "turret_tanker/storm": 400,
}
"""Shipped cases that are checked, run and reported by the command line, with durations [s]."""
TRANSITIONS = {
    "fender_mode": "open>stick open>slip stick>slip slip>stick stick>open slip>open",
    "fender_rising": "0>1 1>0 0>2 1>2 2>0 0>3 1>3 2>3 3>0 3>1",
    "fender_segment": "up down",
    "contact_phase": "moored>initial_contact initial_contact>compressed compressed>stuck"
    " initial_contact>stuck",
    "guide_mode": "away>free away>beside free>away free>pressed pressed>free pressed>away"
    " beside>free beside>away inactive>free inactive>away inactive>beside free>inactive"
    " pressed>inactive away>inactive beside>inactive",
    "guide_segment": "up down",
    "spring_mode": "slack>taut taut>slack slack>absent taut>absent absent>slack absent>taut",
    "spring_segment": "up down",
    "link_mode": "acting>absent absent>acting",
    "link_segment": "up down",
    "link_half_turns": "up down",
    "bushing_mode": "acting>absent absent>acting",
    "line_mode": "acting>absent absent>acting acting>lost",
    "line_segment": "up down",
    "winch_mode": " ".join(
        [
            "stuck>slipping_out slipping_out>stuck stuck>fast_out fast_out>stuck",
            "slipping_out>fast_out fast_out>slipping_out slipping_out>empty fast_out>empty",
            "empty>slipping_in empty>fast_in stuck>empty",
            "stuck>slipping_in slipping_in>stuck stuck>fast_in fast_in>stuck",
            "slipping_in>fast_in fast_in>slipping_in slipping_in>full fast_in>full",
            "full>slipping_out full>fast_out stuck>full",
            "stuck>speeding_out speeding_out>fast_out speeding_out>braking_out",
            "fast_out>braking_out braking_out>speeding_out braking_out>stuck speeding_out>empty",
            "braking_out>empty braking_out>speeding_in",
            "stuck>speeding_in speeding_in>fast_in speeding_in>braking_in",
            "fast_in>braking_in braking_in>speeding_in braking_in>stuck speeding_in>full",
            "braking_in>full braking_in>speeding_out",
            "driven>fast_out fast_out>driven driven>fast_in fast_in>driven driven>empty",
            "empty>driven driven>full full>driven",
            "stuck>absent driven>absent absent>stuck absent>driven",
        ]
    ),
    "winch_segment": "0>1 1>0 1>2 2>1 2>0",
    "compensator_mode": "pulling>cut cut>pulling pulling>absent absent>pulling",
    "compensator_segment": "0>1 1>0 1>2 2>1 2>3 3>2",
    "lock_mode": "open>waiting open>running open>closed waiting>closed waiting>open"
    " running>closed closed>running running>open closed>open",
    "lock_segment": "up down",
    "joint_motion_mode": "stuck>up stuck>down up>stuck down>stuck up>down down>up",
    "joint_motion_segment": "away>at_lowest at_lowest>away at_lowest>below below>at_lowest"
    " below>away away>at_highest at_highest>away at_highest>above above>at_highest above>away",
    "pump_mode": "waiting>running running>over waiting>over",
    "pump_segment": "up",
    "trigger_stage": "before>during during>after",
    "trigger_waits": "0>1 1>0",
}
"""Transitions that the laws of units know, by the variable of the mode. Columns without names of
modes are numbers: of a wire slack, taut, cut; of a compensator slack, lower stop, gas, upper stop;
of a contact whether its load rises, 2 behind the edge of its plane, 3 absent; else of pieces."""
NUMBERED_MODES = {"fender_rising", "winch_segment", "compensator_segment", "trigger_waits"}


class Restart(NamedTuple):
    """A run that begins anew while a unit is in a mode: the case, the variable, the mode."""

    case: str
    variable: str
    mode: str
    settings: Settings | None = None


RESTARTS = {
    "in a stick": Restart("cases/lock_in/pins.yaml", "fender_mode", "stick", {"duration": 650}),
    "in a slip": Restart("cases/lock_in/pins.yaml", "fender_mode", "slip", {"duration": 650}),
    "in a lock": Restart("cases/lock_in/pins.yaml", "lock_mode", "closed", {"duration": 650}),
    "in a ratchet": Restart("scenes/locks.yaml", "lock_mode", "running"),
    "in a pay-out": Restart(
        "cases/lift_over_the_side/over_the_side.yaml",
        "winch_mode",
        "slipping_out",
        {"duration": 100},
    ),
    "in a braking drum": Restart("scenes/lines 43.yaml", "winch_mode", "braking_out"),
    "in a slack line": Restart("scenes/elements for a time.yaml", "spring_mode", "slack"),
    "in a stuck joint": Restart("scenes/held 0.yaml", "joint_motion_mode", "stuck"),
    "at a wall": Restart("scenes/guides.yaml", "guide_mode", "pressed"),
    "in a pumped tank": Restart("scenes/pumps.yaml", "pump_mode", "running"),
}
SINCE_START = ("energy_", "contact_phase")
"""Beginnings of names of variables that depend on what was before."""
VALUES_OF_KEYS = (
    *("type", "const", "enum", "default", "unit", "quantity", "minimum", "maximum", "required"),
    *("exclusiveMinimum", "exclusiveMaximum", "minItems", "maxItems"),
)
STEPS_OF_SCHEMAS = {"then": "(part)", "items": ".*", "prefixItems": ".*"}
STEPS_OF_SCHEMAS |= {"additionalProperties": ".*", "patternProperties": ".*"}
SPEED: dict[str, tuple[str, Settings]] = {
    "sphere, 42 states": ("sphere/irregular", {"solver.linear": "step", "duration": 3000}),
    "free barge": (
        BASE,
        {
            **dict.fromkeys(("forces.interface", "forces.deballast")),
            "solver.linear": "step",
            "solver.symmetry": "ignore",
        },
    ),
    "base case, 4 fenders": (BASE, {"solver.symmetry": "ignore"}),
    "base case in its plane": (BASE, {}),
    "convolution": CASES["convolution"],
    "coulomb": ("friction_block/exact", {"duration": 5000}),
}


def record_checkout(inputs: Mapping[str, Any]) -> Record:
    """The record of the checkout in `HERE`: all parts, transitions and restarts."""
    record: Record = {part: {} for part in (*PARTS, "restarts")}
    transitions = Counter[str]()
    with working_copy(inputs) as folder:
        for name, run in chain(simulate_all(record, folder), run_commands(record, folder)):
            add_dataset(record, name, run, folder)
            transitions.update(count_transitions(run))
        for name, restart in RESTARTS.items():
            try:
                record["restarts"][name] = compare_restart(record, name, restart, folder)
            except (hs.HydrosimError, KeyError, ValueError) as error:
                record["restarts"][name] = [str(error)]
        for kind in ("case", "study", "recipe"):
            add_schema(record, kind, json.loads(call("new", "--schema", kind)))
        add_messages(record, inputs, folder)
    return {**record, "transitions": dict(transitions)}


@contextmanager
def working_copy(inputs: Mapping[str, Any]) -> Iterator[Path]:
    """Work in a folder with cases, databases and the files of the ``inputs``."""
    ignore = shutil.ignore_patterns("*.png", "*.md", "thesis", "no_friction.nc")
    with TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        for part in ("cases", "hydro_db"):
            shutil.copytree(HERE / part, folder / part, ignore=ignore)
        for path, text in inputs["files"].items():
            (folder / path).parent.mkdir(exist_ok=True)
            (folder / path).write_text(text)
        os.chdir(folder)
        yield folder
        os.chdir(HERE)


def simulate_all(record: Record, folder: Path) -> Iterator[tuple[str, xr.Dataset]]:
    """Runs by name, in memory. The error of one that fails is added to the ``record``."""

    def simulate(name: str, path: Path | str, settings: Settings, **forces: Any) -> xr.Dataset:
        try:
            return hs.simulate(hs.load_case(path, settings), forces=forces)
        except hs.HydrosimError as error:
            record["texts"][f"{name} (error)"] = str(error).replace(str(folder), "")
            return xr.Dataset()

    for name, (case, settings) in CASES.items():
        yield name, simulate(name, f"cases/{case}.yaml", {**settings, STATES: True})
    for path in sorted(Path("scenes").glob("*.yaml")):
        yield path.stem, simulate(path.stem, path, {})
    short: Settings = {"duration": 40, "solver.step": 0.1}
    for coupling in ("stage", "held", "extrapolated"):
        name = f"function, {coupling}"
        user_force = getattr(hs, "UserForce", None) or hs.External  # its name in versions before
        brake = user_force("port", brake_pair, coupling, also=("starboard",), repeatable=True)
        yield name, simulate(name, "scenes/two barges.yaml", short, brake=brake)
    base = f"cases/{BASE}.yaml"
    memory: Settings = {"bodies.barge.radiation": "convolution"}
    simulate("memory", base, {**memory, "duration": 560}).to_netcdf("memory.nc")
    later = {**memory, "duration": 150, "initial": {"run": str(Path("memory.nc").resolve())}}
    name = "restart of a convolution"
    yield name, simulate(name, base, later)


def brake_pair(t: float, state: Mapping[str, Any]) -> list[list[float]]:
    """Wrenches (2, 6) [N, N m] against the relative velocity of two barges."""
    speed = state["port"].velocity[1] - state["starboard"].velocity[1]
    return [[0.0, sign * 2e4 * speed, 0.0, 0.0, 0.0, 0.0] for sign in (-1.0, 1.0)]


def load_whole(file: Path) -> xr.Dataset:
    """A result with its restart data, which a version may keep in a group of their own."""
    groups = xr.open_groups(file, engine="netcdf4")
    return xr.merge([group.load() for group in groups.values()], compat="override")


def run_commands(record: Record, folder: Path) -> Iterator[tuple[str, xr.Dataset]]:
    """Results of commands by name; what they print and report is added to the ``record``."""

    def add(name: str, *arguments: str) -> None:
        record["texts"][name] = call(*arguments).replace(str(folder), "")

    def read(result: str) -> xr.Dataset:
        file = Path(result)
        run = load_whole(file) if file.exists() else xr.Dataset()
        record["texts"][f"report {result}"] = write_report(result, folder) if run else "no result"
        return run

    for case, duration in REPORTED.items():
        path = f"cases/{case}.yaml"
        result = f"{case.replace('/', '_')}.nc"
        setting = (f"--set=duration={duration} s", f"--set={STATES}=true")
        add(f"run {case}", "run", path, "-o", result, *setting)
        add(f"check {case}", "check", path)
        yield case, read(result)
        add(f"statistics {case}", "show", result, "--statistics")
    for case in ("reverse_float_over/free_floating", "sphere/irregular"):
        result = f"linear_{Path(case).name}.nc"
        add(f"linear {case}", "analyse", f"cases/{case}.yaml", "-o", result)
        yield f"linear {case}", read(result)
    for path in sorted(Path("studies").glob("*.yaml")):
        result = f"{path.stem}_runs.nc"
        add(f"study {path.stem}", "study", str(path), "--workers=1", "-o", result)
        yield f"study {path.stem}", read(result)
    for text in (f"study {DRAWN_ANEW}", f"report {DRAWN_ANEW}_runs.nc"):
        del record["texts"][text]


def typed_before(arguments: Sequence[str]) -> list[str]:
    """The same command as versions of 27 commands know it."""
    name, *others = arguments
    study = "operability" if "operability" in others[0] else "sweep"
    earlier = {"new": "schema", "show": "statistics", "analyse": "linear", "study": study}
    kept = [part for part in others if part not in ("--schema", "--statistics")]
    return [earlier.get(name, name), *kept]


def call(*arguments: str) -> str:
    """What the command line prints, messages included, and its exit code if that is not 0."""
    sys.argv[1:] = arguments if hasattr(hs, "UserForce") else typed_before(arguments)
    printed = io.StringIO()
    code: Any = 0
    with redirect_stdout(printed), redirect_stderr(printed):
        try:
            runpy.run_module("hydrosim", run_name="__main__")
        except SystemExit as end:
            code = end.code or 0
    text = without_clock(printed.getvalue())
    return f"{text}\nexit code {code}" if code else text


def without_clock(text: str) -> str:
    """The lines of a text that do not depend on the clock."""
    return "\n".join(line for line in text.splitlines() if not CLOCK_LINES.search(line))


def write_report(result: str, folder: Path) -> str:
    """The page of a result, without its programs, what these draw, and unrounded numbers."""
    page_file = Path(result).with_suffix(".html")
    answer = call("report", result, "-o", str(page_file))
    if not page_file.exists():
        return answer.replace(str(folder), "")
    page = re.sub(r"<script.*?</script>", "", page_file.read_text(), flags=re.DOTALL)
    page = re.sub(r"'sha256-[^']*'|(?<=<data) value=\"[^\"]*\"", "", page)
    return without_clock(page).replace(str(folder), "")


def add_dataset(record: Record, name: str, run: xr.Dataset, folder: Path) -> None:
    """Add a run: numbers with dimensions and units; names and attributes as texts."""
    add_attributes(record, name, run.attrs, folder)
    for label, variable in run.variables.items():
        if label in CLOCK:
            continue
        item = f"{name}: {label}"
        attributes = dict(variable.attrs)
        values = variable.values
        if values.dtype.kind in "OU":
            words = [str(word).replace(str(folder), "") for word in values.ravel()]
            record["texts"][f"{item} (labels)"] = "\n".join(words)
        else:
            about = f"{variable.dims} {attributes.pop('units', None)}"
            record["numbers"][item] = f"{about} {digest(values)}"
        add_attributes(record, item, attributes, folder)


def add_attributes(record: Record, item: str, values: Mapping[Any, Any], folder: Path) -> None:
    """Add attributes: numbers one by one, texts together."""
    texts = []
    for key, value in sorted(values.items()):
        if key in CLOCK:
            continue
        array = np.asarray(value)
        if array.dtype.kind in "OU":
            texts.append(f"{key} = {str(array.tolist()).replace(str(folder), '')}")
        else:
            record["numbers"][f"{item} ({key})"] = digest(array)
    record["texts"][f"{item} (attributes)"] = "\n".join(texts)


def digest(values: np.ndarray) -> str:
    """Of the type, the shape and the bytes."""
    head = f"{values.dtype.str}{values.shape}".encode()
    return hashlib.sha256(head + np.ascontiguousarray(values).tobytes()).hexdigest()[:16]


def count_transitions(run: xr.Dataset) -> Counter[str]:
    """``variable transition`` between records that follow one another, with counts."""
    counts = Counter[str]()
    for name, variable in run.variables.items():
        if name not in TRANSITIONS or variable.dims[0] not in ("time", "state_time"):
            continue
        modes = variable.values.astype(int)
        words = str(variable.attrs.get("flag_meanings", "")).split()
        before, after = modes[:-1], modes[1:]
        changed = before != after
        for a, b in zip(before[changed].tolist(), after[changed].tolist(), strict=True):
            if words:
                text = f"{words[a]}>{words[b]}"
            elif name in NUMBERED_MODES:
                text = f"{a}>{b}"
            else:
                text = "up" if b > a else "down"
            counts[f"{name} {text}"] += 1
    return counts


def compare_restart(record: Record, name: str, restart: Restart, folder: Path) -> list[str]:
    """Variables of a run from a state on the way that differ from those of the unbroken run."""
    whole = hs.simulate(hs.load_case(restart.case, {**(restart.settings or {}), STATES: True}))
    time = find_time(whole, restart)
    whole.to_netcdf("whole.nc")
    later: Settings = {
        **(restart.settings or {}),
        "initial": {"run": str(Path("whole.nc").resolve()), "time": time},
        "duration": float(whole.time[-1]) - time,
    }
    rest = hs.simulate(hs.load_case(restart.case, later))
    add_dataset(record, f"restart {name}", rest, folder)
    unbroken = whole.sel(time=slice(time, None))
    return [
        str(label)
        for label, variable in rest.data_vars.items()
        if "time" in variable.dims
        and not str(label).startswith(SINCE_START)
        and not np.array_equal(variable.values, unbroken[label].values, equal_nan=True)
    ]


def find_time(run: xr.Dataset, restart: Restart) -> float:
    """The middle of the longest time that a unit spends in the mode, after the start."""
    variable = run[restart.variable]
    mode = variable.attrs["flag_meanings"].split().index(restart.mode)
    longest = (0, 0)
    for states in (variable.values == mode).T:
        edges = np.flatnonzero(np.diff(states.astype(int), prepend=0, append=0))
        for begin, end in edges.reshape(-1, 2).tolist():
            if begin > 0:
                longest = max(longest, (end - begin, (begin + end) // 2))
    if not longest[0]:
        raise ValueError(f"{restart.case}: no unit gets into the mode {restart.mode}")
    return float(run.time[longest[1]])


def add_schema(record: Record, kind: str, schema: Mapping[str, Any]) -> None:
    """Add the keys of a schema by their paths, each with the words and numbers of its values.
    Elements of a list are ``*``; a mapping with a type has this in brackets."""

    def walk(node: Any, path: str, references: tuple[str, ...]) -> None:
        if isinstance(node, list):
            for child in node:
                walk(child, path, references)
        if not isinstance(node, dict):
            return
        reference = node.get("$ref")
        if reference and reference not in references:
            steps = reference.removeprefix("#/").split("/")
            walk(reduce(getitem, steps, schema), path, (*references, reference))
        values.setdefault(path, set()).add(
            json.dumps({name: node[name] for name in VALUES_OF_KEYS if name in node})
        )
        type_of = node.get("properties", {}).get("type", {}).get("const")
        place = f"{path}[{type_of}]" if type_of else path
        for name, child in node.items():
            if name == "properties":
                for key, value in child.items():
                    walk(value, f"{place}.{key}", references)
            elif name not in ("$defs", *VALUES_OF_KEYS):
                walk(child, place + STEPS_OF_SCHEMAS.get(name, ""), references)

    values: dict[str, set[str]] = {}
    walk(schema, kind, ())
    record["schemas"] |= {path: "\n".join(sorted(lines)) for path, lines in values.items()}


def add_messages(record: Record, inputs: Mapping[str, Any], folder: Path) -> None:
    """Add the first `MESSAGES` messages on mutants that are read, and all on those checked."""

    def write(number: int, case: str, text: str) -> Path:
        path = Path("cases", case).with_name(f"mutant_{number}.yaml")
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        return path

    messages = record["messages"]
    for number, (case, name, text) in enumerate(inputs["mutants"]):
        try:
            hs.load_case(write(number, case, text)).scene()
        except Exception as error:
            message = str(error) if isinstance(error, hs.HydrosimError) else f"crash: {error!r}"
            messages[name] = message.replace(str(folder), "")
        if len(messages) == MESSAGES:
            break
    for number, (case, name, text) in enumerate(inputs["checked"]):
        path = write(1000 + number, case, text)
        messages[name] = call_for_a_while("check", str(path)).replace(str(folder), "")


class OutOfTime(BaseException):
    """No error of a command: it is not for the command line to tell."""


def call_for_a_while(*arguments: str) -> str:
    """What a command prints, unless it takes longer than `MAX_CHECK_TIME`."""

    def stop(*_: object) -> None:
        raise OutOfTime

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, MAX_CHECK_TIME)
    try:
        return call(*arguments)
    except OutOfTime:
        return "no answer"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def measure_speed() -> dict[str, float]:
    """Steps per second of CPU time, of the time loop alone, once each after a run that compiles."""
    return {name: measure_pace(*SPEED[name]) for name in SPEED}


def measure_pace(name: str, settings: Settings) -> float:
    marks: list[tuple[float, int]] = []
    case = hs.load_case(HERE / "cases" / f"{name}.yaml", settings)
    hs.simulate(case)
    hs.simulate(case, lambda _, steps: marks.append((process_time(), steps)))
    (begin, few), (end, all_) = marks[0], marks[-1]
    return (all_ - few) / (end - begin)


class Side(NamedTuple):
    """A checkout that is recorded in a process of its own, and the file that it writes."""

    process: subprocess.Popen[bytes]
    output: Path

    def read(self) -> Any:
        """What the process has recorded, once it has ended."""
        if self.process.wait():
            raise SystemExit(f"the record was not made: exit code {self.process.returncode}")
        return json.loads(self.output.read_text())


def start_side(checkout: Path, inputs: Path, output: Path) -> Side:
    """Begin to record a checkout by this program."""
    home = {"PYTHONPATH": str(checkout), "HYDROSIM_HOME": str(checkout)}
    command = [sys.executable, "-W", "ignore", __file__, "--side", str(inputs), str(output)]
    return Side(
        subprocess.Popen(command, env={**os.environ, **ENVIRONMENT, **home}, cwd=checkout), output
    )


def record_side(inputs: Path, output: Path) -> None:
    """What `start_side` runs."""
    if not Path(hs.__file__).is_relative_to(HERE):
        raise SystemExit(f"hydrosim was loaded from {hs.__file__}, not from {HERE}")
    warnings.simplefilter("ignore")
    read = json.loads(inputs.read_text())
    output.write_text(json.dumps(record_checkout(read) if read else measure_speed()))


@contextmanager
def checkout_of(name: str) -> Iterator[Path]:
    """The folder of this name, or a worktree of a commit for as long as it is needed."""
    if Path(name).is_dir():
        yield Path(name).resolve()
        return
    with TemporaryDirectory() as folder:
        worktree = Path(folder, "checkout")
        git = ["git", "-C", str(HERE), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(worktree), name], check=True)
        try:
            yield worktree
        finally:
            subprocess.run([*git, "remove", "--force", str(worktree)], check=True)


def find_differences(ours: Mapping[str, str], theirs: Mapping[str, str]) -> dict[str, str]:
    """Names of what differs, with the first lines that do: theirs, then ours."""
    return {
        name: first_difference(theirs.get(name), ours.get(name))
        for name in sorted({*ours, *theirs})
        if ours.get(name) != theirs.get(name)
    }


def first_difference(before: str | None, after: str | None) -> str:
    """The first lines that differ of two texts."""
    if before is None or after is None:
        return "new" if before is None else "missing"
    lines = [text.splitlines() for text in (before, after)]
    count = max(map(len, lines))
    padded = [[*own, *[""] * (count - len(own))] for own in lines]
    pairs = (pair for pair in zip(*padded, strict=True) if pair[0] != pair[1])
    return "\n    ".join(
        ("", *(f"{sign} {line[:300]}" for sign, line in zip("-+", next(pairs), strict=True)))
    )


def print_differences(ours: Record, theirs: Record, parts: Iterable[str]) -> int:
    """Print what differs, part by part; the number of differences."""
    total = 0
    for part in parts:
        differences = find_differences(ours[part], theirs[part])
        for name, text in [*differences.items()][:SHOWN]:
            line = f"{part}: {name}" if part == "numbers" else f"{part}: {name}: {text}"
            print(line.encode("ascii", "backslashreplace").decode())
        if len(differences) > SHOWN:
            print(f"{part}: {len(differences) - SHOWN} others")
        total += len(differences)
        print(f"{part}: {len(ours[part])} compared, {len(differences)} differ\n")
    return total


def print_transitions(records: list[Record]) -> None:
    """Print how often each transition happened, in each record."""
    known = [f"{name} {text}" for name, all_ in TRANSITIONS.items() for text in all_.split()]
    others = {*(key for record in records for key in record["transitions"])} - {*known}
    print(f"{'transition':52s} {'count':>9s}")
    missing = 0
    for key in (*known, *sorted(others)):
        counts = [record["transitions"].get(key, 0) for record in records]
        missing += key in known and not any(counts)
        shown = (f"{count:9,}" if count else "not reached" for count in dict.fromkeys(counts))
        print(f"{key:52s} {' '.join(shown)}")
    print(f"{len(known)} transitions are known, {missing} of them not reached\n")


def print_restarts(record: Record) -> int:
    """Print which restarts go on to the bit; the number of those that do not."""
    for name, differing in record["restarts"].items():
        print(f"restart {name:20s} {', '.join(differing) or 'to the bit'}")
    return sum(map(bool, record["restarts"].values()))


def judge(other: str | None, parts: list[str]) -> int:
    """Record this checkout, and the ``other`` one if there is one, and print what there is to say:
    1 if anything differs or a restart is not exact."""
    from tests.generators.recorded_inputs import recorded_inputs  # of this checkout alone

    with TemporaryDirectory() as name:
        folder = Path(name)
        inputs = folder / "inputs.json"
        inputs.write_text(json.dumps(recorded_inputs()))
        with checkout_of(other or str(HERE)) as checkout:
            sides = [start_side(HERE, inputs, folder / "ours.json")]
            if other:
                sides.append(start_side(checkout, inputs, folder / "theirs.json"))
            try:
                records: list[Record] = [side.read() for side in sides]
            finally:
                for side in sides:
                    side.process.kill()
    print_transitions(records)
    wrong = print_restarts(records[0])
    if other:
        wrong += print_differences(records[0], records[1], parts)
    return int(wrong > 0)


def race(other: str | None, rounds: int) -> int:
    """Print steps per second of this checkout, and over those of the ``other`` one."""
    times: dict[str, list[tuple[float, ...]]] = {name: [] for name in SPEED}
    with TemporaryDirectory() as folder, checkout_of(other or str(HERE)) as checkout:
        inputs = Path(folder, "inputs.json")
        inputs.write_text("null")
        for _ in range(rounds):
            sides = [HERE, checkout] if other else [HERE]
            paces = [start_side(side, inputs, Path(folder, "pace.json")).read() for side in sides]
            for name in SPEED:
                times[name].append(tuple(pace[name] for pace in paces))
    for name, pairs in times.items():
        ratios = [pair[0] / pair[-1] for pair in pairs]
        ours, theirs = (median(pair[i] for pair in pairs) for i in (0, -1))
        spread = f"{min(ratios):.3f} to {max(ratios):.3f}"
        print(f"{name:24s} {ours:9,.0f} / {theirs:9,.0f} steps/s: {median(ratios):.3f} ({spread})")
    return 0


def main() -> int:
    """Answer what the command line asks."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--against", metavar="COMMIT", help="a commit, or a folder")
    parser.add_argument("--parts", default=",".join(PARTS), help="to compare, by commas")
    parser.add_argument("--speed", action="store_true", help="steps per second, no records")
    parser.add_argument("--rounds", type=int, default=5, help="of both checkouts in turn")
    parser.add_argument("--side", nargs=2, type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.side:
        record_side(*options.side)
        return 0
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # sides and worktrees are cleared away
    if options.speed:
        return race(options.against, options.rounds)
    return judge(options.against, options.parts.split(","))


if __name__ == "__main__":
    raise SystemExit(main())
