"""Checksums of what runs compute, and rows of speed: the judge of a change that may change nothing.

    python -m benchmarks.checksums                       the checksums of this checkout
    python -m benchmarks.checksums --against FOLDER      those of another one, and what differs
    python -m benchmarks.checksums --against FOLDER --numbers     the same, texts left out
    python -m benchmarks.checksums --speed [--against FOLDER]   steps per second, processes in turn

Every variable, coordinate and attribute counts, but for times of the clock and paths, to the bit,
with one thread of BLAS. Numbers count with their type, shape, dimensions and unit. Texts (names,
long names, attributes, printed output) count apart. It uses public names alone, so that it
can be run on other versions.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import json
import os
import subprocess
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import redirect_stdout
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
import xarray as xr

import hydrosim as hs

HERE = Path(os.environ.get("HYDROSIM_HOME", Path(__file__).parents[1]))
CLOCK = {
    "wall_time",
    "case_file",
    "case",
    "case_resolved",
    "history",
    "date_created",
    "format",
}  # attributes of the clock and of places
SOLVER = "solver.method"
TEXT = " (text)"
BARGE = """
    hydrodynamics: {root}/hydro_db/two_barges.nc
    mass: 1.23e6
    radiation: {{model: state_space, length: 160 s, tolerance: 0.01}}
"""
TWO_BARGES = """
title: two barges
duration: 200 s
environment:
  water_depth: infinite
  waves:
    {{spectrum: jonswap, significant_height: 1 m, peak_period: 9 s, heading: 60 deg, ramp: 50 s}}
bodies:
  starboard:{barge}
    database_body: 2
    centre_of_gravity: [0, -7 m, 0]
    radii_of_gyration: [4.0, 11.0, 11.0]
  port:{barge}
    database_body: 1
    centre_of_gravity: [0, 7 m, 0]
    radii_of_gyration: [3.5, 10.4, 10.4]
forces:
  starboard_lines:
    {{type: linear_mooring, body: starboard, stiffness: {{surge: 1.5e5, sway: 1.5e5, yaw: 1.5e7}}}}
  port_lines:
    {{type: linear_mooring, body: port, stiffness: {{surge: 1.5e5, sway: 1.5e5, yaw: 1.5e7}}}}
  bilges: {{type: linear_damping, body: port, damping: {{roll: 5e6}}}}
  drag: {{type: quadratic_damping, body: starboard, damping: {{roll: 5e7}}}}
  tie: {{type: spring, body: port, point: [5, -4, 1], anchor_body: starboard, anchor: [5, 4, 1],
        length: 6 m, stiffness: 1e5, damping: 1e4}}
  side:
    type: fender
    body: port
    points: [[10, -5, 0], [-10, -5, 0]]
    plane: {{body: starboard, point: [0, 8.9, 0], normal: [0, 1, 0]}}
    normal: {{stiffness: 4e6, damping: 1e4}}
    friction: {{law: friction_slope, coefficient: 0.3, slope: 1e5}}
solver: {{method: rk4, step: 0.05 s}}
"""
STUDY = """
case: {root}/cases/reverse_float_over/base.yaml
parameters:
  forces.interface.friction.static: [0.2, 0.4]
seeds: 1-2
duration: 700 s
output: {{step: 1 s, variables: [position, fender_mode]}}
"""
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "base case": ("reverse_float_over/base", {}),
    "base case, all degrees of freedom": ("reverse_float_over/base", {"solver.symmetry": "ignore"}),
    "base case, oblique, rk2": (
        "reverse_float_over/base",
        {"environment.waves.heading": "30 deg", SOLVER: "rk2", "duration": 700},
    ),
    "convolution": (
        "reverse_float_over/base",
        {"bodies.barge.radiation": "convolution", "duration": 700},
    ),
    "convolution, all degrees of freedom": (
        "reverse_float_over/base",
        {"bodies.barge.radiation": "convolution", "duration": 600, "solver.symmetry": "ignore"},
    ),
    "dopri5": ("reverse_float_over/base", {SOLVER: "dopri5", "duration": 650}),
    "esdirk4": ("reverse_float_over/base", {SOLVER: "esdirk4", "duration": 650}),
    "waves that follow": (
        "reverse_float_over/free_floating",
        {
            "bodies.barge.wave_forces": {"headings": "instantaneous", "position": "instantaneous"},
            "duration": 20,
        },
    ),
    "free floating": ("reverse_float_over/free_floating", {}),
    "no friction": ("reverse_float_over/no_friction", {}),
    "sphere, decay": ("sphere/decay", {}),
    "sphere, decay, stepped": ("sphere/decay", {"solver.linear": "step"}),
    "sphere, regular wave": ("sphere/regular", {}),
    "sphere, irregular sea": ("sphere/irregular", {}),
    "coulomb": ("friction_block/exact", {}),
    "coulomb, held": ("friction_block/held", {}),
    "friction slope": ("friction_block/slope_1e6", {}),
    "oscillation": ("numerical_oscillation/base", {}),
    "one dimension": ("one_dimensional/base", {"duration": 800}),
}
SPEED: dict[str, tuple[str, dict[str, Any]]] = {
    "sphere, 42 states": ("sphere/irregular", {"solver.linear": "step", "duration": 3000}),
    "free barge": (
        "reverse_float_over/base",
        {
            **dict.fromkeys(("forces.interface", "forces.deballast")),
            "solver.linear": "step",
            "solver.symmetry": "ignore",
        },
    ),
    "base case, 4 fenders": ("reverse_float_over/base", {"solver.symmetry": "ignore"}),
    "base case in its plane": ("reverse_float_over/base", {}),
    "convolution": CASES["convolution"],
    "coulomb": ("friction_block/exact", {"duration": 5000}),
}


def run_of(name: str, settings: dict[str, Any]) -> xr.Dataset:
    """A run of a shipped case."""
    return hs.simulate(hs.load_case(HERE / "cases" / f"{name}.yaml", settings))


def runs(folder: Path) -> Iterator[tuple[str, xr.Dataset]]:
    """All runs by name; ``folder`` is for files that they need."""
    for name, (case, settings) in CASES.items():
        yield name, run_of(case, settings)
    pair = folder / "two.yaml"
    pair.write_text(TWO_BARGES.format(barge=BARGE.format(root=HERE)))
    yield "two barges", hs.simulate(hs.load_case(pair))
    begun = run_of("reverse_float_over/base", {"duration": 600, "output.states": True})
    begun.to_netcdf(folder / "begun.nc")
    later: dict[str, Any] = {
        "initial": {"run": str(folder / "begun.nc"), "time": 550},
        "duration": 150,
    }
    yield "restart", run_of("reverse_float_over/base", later)
    later["bodies.barge.radiation"] = "convolution"
    begun = run_of("reverse_float_over/base", {**CASES["convolution"][1], "duration": 560})
    begun.to_netcdf(folder / "remembers.nc")
    later["initial"] = {"run": str(folder / "remembers.nc")}
    yield "restart of a convolution", run_of("reverse_float_over/base", later)


def commands(folder: Path) -> Iterator[tuple[str, list[str], Path | None]]:
    """Commands by name, with what they write."""
    base, study = f"{HERE}/cases/reverse_float_over/base.yaml", folder / "study.yaml"
    free, sphere = base.replace("base", "free_floating"), f"{HERE}/cases/sphere/irregular.yaml"
    study.write_text(STUDY.format(root=HERE))
    result = folder / "sweep.nc"
    yield "sweep", ["sweep", str(study), "-o", str(result)], result
    for case in (free, sphere):
        result = folder / f"linear_{Path(case).stem}.nc"
        yield f"linear {Path(case).stem}", ["linear", case, "-o", str(result)], result
    for case in (base, free, sphere):
        yield f"check {Path(case).stem}", ["check", case], None
    yield "check convolution", ["check", base, "--set", "bodies.barge.radiation=convolution"], None


def digest(values: np.ndarray) -> str:
    """Of the type, the shape and the bytes."""
    if values.dtype.kind in "OU":
        values = np.array([placeless(text) for text in values.ravel()], dtype="U")
    head = f"{values.dtype.str}{values.shape}".encode()
    return hashlib.sha256(head + np.ascontiguousarray(values).tobytes()).hexdigest()[:16]


def placeless(text: object) -> str:
    """Without the folder of the checkout."""
    return str(text).replace(str(HERE), "")


def checksums(run: xr.Dataset, folder: Path) -> dict[str, str]:
    """By variable: of numbers with dimensions and units, of texts by themselves."""
    found = {}
    for name, variable in run.variables.items():
        if name in CLOCK:
            continue
        values, about = variable.values, dict(variable.attrs)
        if values.dtype.kind in "OU":
            found[f"{name}{TEXT}"] = digest(values)
        else:
            kept = f"{variable.dims} {about.pop('units', None)} {digest(values)}"
            found[str(name)] = digest(np.array([kept]))
        found[f"{name}, described{TEXT}"] = _attributes(about, folder)
    found[f"attributes{TEXT}"] = _attributes(run.attrs, folder)
    return found


def _attributes(attributes: Mapping[Any, Any], folder: Path) -> str:
    """One checksum of all, but for those of the clock."""
    said = {
        str(k): placeless(np.asarray(v).tolist()).replace(str(folder), "")
        for k, v in attributes.items()
        if k not in CLOCK
    }
    return digest(np.array([f"{k}={v}" for k, v in sorted(said.items())]))


def said(arguments: list[str], folder: Path) -> str:
    """What a command prints."""
    from hydrosim.__main__ import main

    sys.argv[1:], printed = arguments, io.StringIO()
    try:
        with redirect_stdout(printed):
            main()
    except SystemExit as end:
        if end.code:
            raise
    return placeless(printed.getvalue()).replace(str(folder), "")


def all_checksums() -> dict[str, str]:
    """``run: variable`` of everything."""
    found: dict[str, str] = {}
    with TemporaryDirectory() as name:
        folder = Path(name)
        for run, dataset in runs(folder):
            found |= {f"{run}: {k}": v for k, v in checksums(dataset, folder).items()}
        for command, arguments, result in commands(folder):
            text = said(arguments, folder)
            if result is None:
                found[f"{command}: printed{TEXT}"] = digest(np.array([text]))
            else:
                dataset = xr.load_dataset(result, engine="netcdf4")
                found |= {f"{command}: {k}": v for k, v in checksums(dataset, folder).items()}
    return found


def speed() -> dict[str, float]:
    """Steps per second of CPU time, of the time loop alone, once each after a run that compiles."""
    return {name: _pace(*SPEED[name]) for name in SPEED}


def _pace(name: str, settings: dict[str, Any]) -> float:
    marks: list[tuple[float, int]] = []
    case = hs.load_case(HERE / "cases" / f"{name}.yaml", settings)
    hs.simulate(case)
    hs.simulate(case, lambda _, steps: marks.append((process_time(), steps)))
    (begin, few), (end, all_) = marks[0], marks[-1]
    return (all_ - few) / (end - begin)


def _elsewhere(folder: Path, *arguments: str) -> Any:
    """What this program finds in another checkout."""
    place = {"PYTHONPATH": str(folder), "HYDROSIM_HOME": str(folder)}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", __file__, "--json", *arguments],
        env={**os.environ, **place},
        cwd=folder,
        stdout=subprocess.PIPE,
        check=True,
    )
    return json.loads(done.stdout)


def _compare(other: Path, numbers_alone: bool) -> int:
    here, there = _elsewhere(HERE), _elsewhere(other)
    differ = [name for name in sorted({*here, *there}) if here.get(name) != there.get(name)]
    texts = [name for name in differ if name.endswith(TEXT)]
    numbers = [name for name in differ if not name.endswith(TEXT)]
    shown = numbers if numbers_alone else [*numbers, *texts]
    print("\n".join(f"differs: {name}" for name in shown))
    print(f"{len(here)} checksums: of numbers {len(numbers)} differ, of texts {len(texts)}")
    return 1 if shown else 0


def _race(other: Path, rounds: int) -> int:
    pairs = [(_elsewhere(HERE, "--speed"), _elsewhere(other, "--speed")) for _ in range(rounds)]
    for name in SPEED:
        ratios = [ours[name] / theirs[name] for ours, theirs in pairs]
        ours, theirs = (median(pair[i][name] for pair in pairs) for i in (0, 1))
        spread = f"{min(ratios):.3f} to {max(ratios):.3f}"
        print(f"{name:24s} {ours:9,.0f} / {theirs:9,.0f} steps/s: {median(ratios):.3f} ({spread})")
    return 0


def main() -> int:
    """Answer what the command line asks."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    asked.add_argument("--against", type=Path, metavar="FOLDER", help="another checkout")
    asked.add_argument("--speed", action="store_true", help="steps per second, not checksums")
    asked.add_argument("--rounds", type=int, default=5, help="of both checkouts in turn")
    asked.add_argument("--json", action="store_true", help="print JSON")
    asked.add_argument("--numbers", action="store_true", help="with --against: texts do not count")
    given = asked.parse_args()
    if given.against is not None:
        other = given.against.resolve()
        return _race(other, given.rounds) if given.speed else _compare(other, given.numbers)
    warnings.simplefilter("ignore")
    found: dict[str, Any] = speed() if given.speed else all_checksums()
    if given.json:
        print(json.dumps(found))
    else:
        print("\n".join(f"{value}  {name}" for name, value in found.items()))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
