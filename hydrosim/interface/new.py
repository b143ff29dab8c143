"""Files to begin with: a case from main particulars, an example, a schema."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import replace
from enum import StrEnum
from functools import partial
from math import ceil, inf, pi, sqrt
from pathlib import Path
from typing import Any

from hydrosim.case.load import Particulars
from hydrosim.database.load import read
from hydrosim.errors import InputError, unwritable
from hydrosim.files.arguments import Amount, quantity
from hydrosim.files.outputs import make_folder

_read_positive = partial(quantity, above=0.0)

# JSON schemas, with which editors complete and check files.


class FileKind(StrEnum):
    """Kinds of files that hydrosim reads."""

    CASE = "case"
    STUDY = "study"
    RECIPE = "recipe"


def schema_of(kind: FileKind) -> dict[str, Any]:
    """JSON schema (draft 2020-12) of files of a ``kind``."""
    from hydrosim.files.json_schema import either_schema, json_schema

    match kind:
        case FileKind.CASE:
            from hydrosim.case.schema import CaseFile

            return json_schema(CaseFile, "Case of hydrosim")
        case FileKind.STUDY:
            from hydrosim.study.study_file import StudyFile

            return json_schema(StudyFile, "Study of hydrosim")
        case FileKind.RECIPE:
            from hydrosim.database.build.recipe import OneBody, SeveralBodies

            single, several = (json_schema(model, "") for model in (OneBody, SeveralBodies))
            return either_schema("Recipe of a database of hydrosim", "bodies", several, single)


# Examples: cases that come with the program.

FILE_NAME_PATTERN = re.compile(r"[\w./]*\.(?:nc|yaml|txt|stl|obj)\b")


def example_names() -> list[str]:
    """Names of the cases that come with the program."""
    folders = (_examples_folder() / "cases").iterdir()
    return sorted(path.name for path in folders if list(path.glob("*.yaml")))


def write_example(name: str, folder: str | Path = ".") -> list[Path]:
    """Write an example with its databases into a ``folder``; return its case files.

    Case files go to cases/NAME, and their databases to hydro_db. Existing files are kept.
    """
    home, folder = _examples_folder(), Path(folder)
    if name not in (names := example_names()):
        raise InputError(f"example: found {name!r}; expected one of {', '.join(names)}")
    for file in _example_files(home, home / "cases" / name):
        copy = folder / file.relative_to(home.resolve())
        if not os.path.lexists(copy):  # a broken link also counts as existing
            make_folder(copy.parent)
            copy.write_bytes(file.read_bytes())
    return sorted((folder / "cases" / name).glob("*.yaml"))


def _examples_folder() -> Path:
    """Folder of the examples: in the package, or beside it in a clone of the repository."""
    package = Path(__file__).parents[1]
    for folder in (package / "examples", package.parent):
        if (folder / "cases").is_dir() and (folder / "hydro_db").is_dir():
            return folder
    raise InputError(
        "example: this installation has no examples; copy the folder cases from the repository."
    )


def _example_files(home: Path, folder: Path) -> list[Path]:
    """Case files, studies and the README of a folder, and all files that the former name."""
    waiting = [*folder.glob("*.yaml"), *folder.glob("studies/*.yaml"), folder / "README.md"]
    paths = set[Path]()
    while waiting:
        path = waiting.pop().resolve()
        if path in paths or not path.is_file():
            continue
        paths.add(path)
        if path.suffix == ".yaml":
            waiting += [
                path.parent / name for name in FILE_NAME_PATTERN.findall(path.read_text("utf-8"))
            ]
    return sorted(path for path in paths if path.is_relative_to(home.resolve()))


# A case from main particulars.

FREQUENCY_STEP = 0.03  # rad/s: a memory of 105 s
# Frequency over sqrt(2 g / B): a box of 60 x 20 x 3 m needs more than 3.2 in surge
SHORT_WAVE_FACTOR = 4.0
MAX_PANELS = 3000  # at most, about, on the whole hull
ROTATIONS = "roll", "pitch", "yaw"

SAME_HULL = 0.1
"""Difference of displacements that one hull may have."""
CASE_TEMPLATE = """\
# Written by hydrosim new from: {given}.
# ESTIMATE marks what was assumed. Replace it by what is known of your vessel.
# Check it with "hydrosim check {name}", run it with "hydrosim run {name} --plot".
title: {title}
duration: 1 hour

environment:
  water_depth: {depth}
  water_density: {density:g} kg/m^3
  waves:
    spectrum: jonswap
    significant_height: {height:g} m
    peak_period: {period:g} s
    peak_enhancement: 3.3
    heading: 180 deg        # where waves go to: 180 deg are head seas
    seed: 1
    ramp: 100 s             # the sea grows from zero; leave this time out of statistics

bodies:
  barge:
{hydrodynamics}
    mass: {mass:.6g} tonne{mass_note}
    # The frame has its origin on the still waterline, x forward, y to port, z up.
    centre_of_gravity: [{x:.6g} m, 0 m, {z:.6g} m]  # {kg_note}
    radii_of_gyration: [{radii}]  # ESTIMATE: 0.35 B, 0.25 L, {yaw:.2g} L, usual of barges
    points: {{bow: [{bow:.6g} m, 0 m, {up:.6g} m]}}  # recorded; measured from the centre of gravity
{start}
forces:
  # ESTIMATE: soft moorings that give these natural periods. Lines are forces of type spring.
  moorings:
    type: linear_mooring
    body: barge
    natural_period: {{surge: 100 s, sway: 100 s, yaw: 80 s}}
    damping_ratio: {{surge: 5 %, sway: 5 %, yaw: 5 %}}
{bilges}
solver: {{method: rk4, step: 0.1 s}}
output: {{step: 0.5 s}}
"""
COEFFICIENTS_TEMPLATE = """\
    # NO WAVE LOADS YET. Until there is a database, these are constant coefficients of a box of
    # {box:.4g} x {beam:g} x {draught:g} m, and the sea has no effect. For the database:
    # hydrosim db build {recipe}
    # Then write "hydrodynamics: {database}" in place of the coefficients, and remove `wave_forces`
    # and `initial`.
    hydrodynamics:
      # rho g V / T; rho g V GM with GM {gm:.3g} m; rho g V GML with GML {gml:.4g} m
      stiffness:{stiffness}
      # ESTIMATE: strips by Newman (1977) and DNV-RP-C205; surge is 8 % of the mass
      added_mass:{added_mass}
      # ESTIMATE: 14 % of critical in heave, 3 % in roll, 15 % in pitch
      damping:{damping}
    # Natural periods by these: heave {heave:.3g} s, roll {roll:.3g} s, pitch {pitch:.3g} s.
    wave_forces: {{first_order: false}}  # until there is a database"""
INITIAL_TEMPLATE = """\
    # Offsets to decay from, so that there is something to see without wave loads.
    initial: {position: {heave: 0.5 m, roll: 2 deg, pitch: 0.5 deg}}
"""
BILGES_TEMPLATE = """\
  # ESTIMATE: viscous damping of roll, which potential flow lacks. Take it from a decay test.
  bilges: {type: linear_damping, body: barge, damping_ratio: {roll: 3 %}}
"""
RECIPE_TEMPLATE = """\
# Written by hydrosim new for {name}. "hydrosim db build {recipe}" computes {database}
# with Capytaine, of the extra bem. The hull is a box with the displacement of the barge: a hull of
# type barge or mesh is nearer to yours.
title: {title}
hull:
  type: box
  length: {box:.6g} m
  beam: {beam:g} m
  draught: {draught:g} m
  panels: {panel:.3g} m  # twice as large takes a tenth of the time, and is enough for a first look
water: {{density: {density:g} kg/m^3, depth: {depth}}}
centre_of_gravity: [0 m, 0 m, {z:.6g} m]  # {kg_note}
radii_of_gyration: [{radii}]  # ESTIMATE: 0.35 B, 0.25 L, {yaw:.2g} L
# Up to three times the peak frequency of the sea, and to waves that are short beside the beam: the
# hull makes hardly any of these. The step resolves 105 s of memory.
frequencies: {{start: {start:.6g} rad/s, stop: {stop:.6g} rad/s, step: {step:g} rad/s}}
headings: {{start: 0 deg, stop: 180 deg, step: 15 deg}}
"""


def write_new_case(
    case_file: str | Path | None = None,
    *,
    length: Amount | None = None,
    beam: Amount | None = None,
    draught: Amount | None = None,
    block_coefficient: Amount | None = None,
    displacement: Amount | None = None,
    kg: Amount | None = None,
    water_depth: Amount = "infinite",
    significant_height: Amount = "1.5 m",
    peak_period: Amount = "8 s",
    database: str | Path | None = None,
    example: str | None = None,
) -> list[Path]:
    """Write a commented case of a barge from its main particulars; return the files.

    Numbers are in SI or texts with a unit, as "590 ft". The case passes `hydrosim check`; its
    comments say what was assumed. Without a ``database`` it has constant coefficients, and waves do
    not move it. A recipe beside it, the second file, computes the database:
    ``build_database(recipe)``. Files that exist are not replaced.

    With ``example``, the name of one, its cases are written with their databases into the folder
    ``case_file``, by default this one. Raises InputError for another name, with those that exist.

    >>> hs.new("own/case.yaml", length=90, beam=27, draught=4)[0]
    PosixPath('own/case.yaml')
    """
    if example is not None:
        return write_example(example, case_file or ".")
    sides = {"length": length, "beam": beam, "draught": draught}
    missing = [name for name, side in sides.items() if side is None]
    if case_file is None or length is None or beam is None or draught is None:
        raise InputError(
            f"{', '.join(missing) or 'case_file'}: found none; expected a file name, `length`,"
            " `beam` and `draught`, or `example`."
        )
    case_file = Path(case_file)
    recipe = case_file.with_name(f"{case_file.stem}_hull.yaml")
    _require_new(case_file, recipe)
    barge = _read_particulars(length, beam, draught, block_coefficient, displacement, kg)
    sea = {
        "height": _read_positive(
            "significant_height", significant_height, "wave height", "m", "1.5 m"
        ),
        "period": _read_positive("peak_period", peak_period, "time", "s", "8 s"),
    }
    depth = _read_depth(water_depth, barge)
    texts = sea | _template_texts(barge, recipe, depth, kg) | {"name": case_file.name}
    if database is None:
        resolution = _recipe_resolution(barge, sea["period"], depth)
        _write_case(recipe, RECIPE_TEMPLATE.format(**texts, **resolution))
        coefficients = COEFFICIENTS_TEMPLATE.format(**texts, **_coefficient_texts(barge))
        parts = {"hydrodynamics": coefficients, "start": INITIAL_TEMPLATE, "bilges": ""}
        _write_case(case_file, CASE_TEMPLATE.format(**texts, **parts))
        return [case_file, recipe]
    database = Path(database)
    texts |= _keys_of_database(database, depth, barge)
    path = Path(os.path.relpath(database, case_file.parent)).as_posix()
    parts = {"hydrodynamics": f"    hydrodynamics: {path}", "start": "", "bilges": BILGES_TEMPLATE}
    _write_case(case_file, CASE_TEMPLATE.format(**texts, **parts))
    return [case_file]


def _require_new(case_file: Path, recipe: Path) -> None:
    """Refuses names that are no case's, or that are taken."""
    if case_file.suffix != ".yaml":
        raise InputError(f"{case_file}: expected a name that ends in .yaml.")
    for path in (case_file, recipe):
        if os.path.lexists(path):
            raise InputError(f"{path} exists and is not replaced. Choose another name, or move it.")


def _read_particulars(
    length: Amount,
    beam: Amount,
    draught: Amount,
    block: Amount | None,
    displacement: Amount | None,
    kg: Amount | None,
) -> Particulars:
    """The main particulars of options; InputError where they are those of no barge afloat."""
    lengths = {"length": length, "beam": beam, "draught": draught}
    long, wide, deep = (
        _read_positive(name, text, "length", "m", "180 m") for name, text in lengths.items()
    )
    if not long >= wide >= deep:
        found_text = f"`length` {long:g} m, `beam` {wide:g} m, `draught` {deep:g} m"
        raise InputError(
            f"found {found_text}; expected a length above the beam, and a beam above the draught."
            " Mend them."
        )
    height = _read_positive("kg", kg, "length", "m", "9 m") if kg else deep
    box = Particulars(long, wide, deep, 1.0, height)
    barge = replace(box, block=_block_coefficient(box, block, displacement))
    if barge.metacentric_height <= 0.0:
        most = barge.kg + barge.metacentric_height
        raise InputError(
            f"kg: found the centre of gravity {barge.kg:g} m above the keel, where the barge"
            f" capsizes (GM {barge.metacentric_height:.3g} m); expected less than {most:.4g} m."
            " Give `kg`, or mend beam and draught."
        )
    return barge


def _block_coefficient(
    box: Particulars, block: Amount | None, displacement: Amount | None
) -> float:
    """The block coefficient that is given, or follows from the displacement."""
    if block and displacement:
        raise InputError(
            "block_coefficient, displacement: found both; expected one of them. Leave one out."
        )
    coefficient = _read_positive("block_coefficient", block or 1.0, "ratio", "", "0.9")
    if displacement:
        coefficient = (
            _read_positive("displacement", displacement, "mass", "kg", "79000 tonne") / box.mass
        )
    if not 0.5 <= coefficient <= 1.0:
        raise InputError(
            f"found a block coefficient of {coefficient:.3g}, the displacement over the"
            f" {box.mass / 1e3:.6g} tonne of a box; expected 0.5 to 1. Mend `block_coefficient`,"
            " `displacement` or the sides."
        )
    return coefficient


def _read_depth(text: Amount, barge: Particulars) -> float:
    """Depth of the water [m], more than the draught."""
    depth = _read_positive("water_depth", text, "depth", "m", "100 m", infinite=True)
    if depth <= barge.draught:
        raise InputError(
            f"water_depth: found {depth:g} m; expected more than the draught of"
            f" {barge.draught:g} m."
        )
    return depth


def _template_texts(
    barge: Particulars, recipe: Path, depth: float, kg: Amount | None
) -> dict[str, Any]:
    """What stands in the texts of case and recipe."""
    sides = f"length {barge.length:g} m, beam {barge.beam:g} m, draught {barge.draught:g} m"
    return {
        "title": f"Barge of {barge.length:g} x {barge.beam:g} x {barge.draught:g} m",
        "given": f"{sides}, block coefficient {barge.block:.4g}",
        "recipe": recipe.name,
        "database": recipe.with_suffix(".nc").name,
        "depth": _metres_text(depth),
        "density": barge.density,
        "box": barge.box_length,
        "beam": barge.beam,
        "draught": barge.draught,
        "mass": barge.mass / 1e3,
        "mass_note": f"  # {barge.density:g} kg/m^3 x Cb {barge.block:.4g} x L B T",
        "x": 0.0,
        "z": barge.kg - barge.draught,
        "kg_note": f"KG {barge.kg:g} m" + ("" if kg else ", an ESTIMATE: on the waterline"),
        "radii": ", ".join(f"{radius:.4g} m" for radius in barge.radii),
        "yaw": barge.radii[2] / barge.length,
        "bow": barge.length / 2,
        "up": 2 * barge.draught - barge.kg,
    }


def _metres_text(depth: float) -> str:
    return "infinite" if depth == inf else f"{depth:g} m"


def _coefficient_texts(barge: Particulars) -> dict[str, Any]:
    """What stands for a database in the text of a case."""
    return {
        "gm": barge.metacentric_height,
        "gml": barge.longitudinal_metacentric_height,
        "stiffness": _lines_by_direction(barge.stiffness(), "kN/m", "kN*m/rad"),
        "added_mass": _lines_by_direction(barge.added_mass(), "tonne", "tonne*m^2"),
        "damping": _lines_by_direction(barge.damping(), "kN*s/m", "kN*m*s/rad"),
        **barge.periods(),
    }


def _lines_by_direction(values: Mapping[str, float], along: str, about: str) -> str:
    """Values in units of 1000 SI, by direction, one a line."""
    units = {dof: about if dof in ROTATIONS else along for dof in values}
    lines = (f"        {dof}: {_rounded_text(x / 1e3)} {units[dof]}" for dof, x in values.items())
    return "\n" + "\n".join(lines)


def _rounded_text(value: float) -> str:
    """Four digits that count, without a power of ten."""
    return f"{float(f'{value:.4g}'):.15g}"


def _recipe_resolution(barge: Particulars, period: float, depth: float) -> dict[str, float]:
    """Panels and frequencies that the sea and the hull's own waves ask for, from the lowest that
    can be computed in water of this ``depth`` [m]."""
    from hydrosim.database.build.drift import Water

    lowest = Water(barge.density, barge.gravity, depth).lowest_frequency
    start = FREQUENCY_STEP * max(ceil(lowest / FREQUENCY_STEP), 1)
    of_sea = 3 * 2 * pi / period
    of_hull = SHORT_WAVE_FACTOR * sqrt(2 * barge.gravity / barge.beam)
    stop = FREQUENCY_STEP * ceil(max(of_sea, of_hull) / FREQUENCY_STEP)
    wave = 2 * pi * barge.gravity / stop**2
    wet = barge.box_length * barge.beam + 2 * barge.draught * (barge.box_length + barge.beam)
    panel = max(min(wave / 4, barge.draught / 2), sqrt(wet / MAX_PANELS))
    return {
        "step": FREQUENCY_STEP,
        "start": start,
        "stop": stop,
        "panel": panel,
    }


def _keys_of_database(path: Path, depth: float, barge: Particulars) -> dict[str, Any]:
    """What a case takes from its database: water, mass, place along the hull."""
    db = read(path)
    if depth not in (inf, db.water_depth):
        raise InputError(
            f"water_depth: found {depth:g} m, but {path} is for {_metres_text(db.water_depth)};"
            " expected the same. Leave `water_depth` out, or take another database."
        )
    texts: dict[str, Any] = {"depth": _metres_text(db.water_depth), "density": db.water_density}
    if db.volume is not None:
        _require_same_hull(path, db.water_density * float(db.volume[0]), barge)
        texts["mass"] = db.water_density * float(db.volume[0]) / 1e3
        texts["mass_note"] = "  # displaced by the hull of the database"
    if db.centre_of_buoyancy is not None:
        texts["x"] = float(db.centre_of_buoyancy[0, 0])
    return texts


def _require_same_hull(path: Path, displaced: float, barge: Particulars) -> None:
    """Refuses a database of a hull that displaces [kg] something else than the particulars do."""
    if abs(displaced / barge.mass - 1.0) > SAME_HULL:
        raise InputError(
            f"database: {path} displaces {displaced / 1e3:.6g} tonne, but the main particulars"
            f" {barge.mass / 1e3:.6g} tonne; expected the same hull. Give the particulars of the"
            " database's hull, with `displacement`, or take another database."
        )


def _write_case(path: Path, text: str) -> None:
    """Writes a file that is not there."""
    make_folder(path.parent)
    try:
        with open(path, "x", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise unwritable(path, error) from None
