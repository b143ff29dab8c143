"""Nemoh 2 and 3: a project folder, by its Nemoh.cal or any of Results/*.tec.

Verified with real files of versions 2.3 and 3.0.2, and with the program's source. Nemoh.cal has
three or four numbers in the line of frequencies. RadiationCoefficients.tec has a zone for each
motion, ExcitationForce.tec one for each heading. Hydrostatics.dat and KH.dat are about the centre
of gravity, with gravity, and numbered from zero if there are several bodies. Loads in long waves
show exp(-i w t), so phases are negated, and headings that waves go to. Phases refer to the wave
measurement point of Nemoh.cal.

The layout of the quadratic transfer functions is that of the manual; no real file was available.
Files are Results/QTF/OUT_QTFM_N.dat and OUT_QTFP_N.dat, with _0 and so on for several bodies. They
hold the triangle w_1 >= w_2 over rho g, with phases in degrees. Inertia_hull.dat is that of the
shell and is not read.
"""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hydrosim.database.changes import velocity_transfer
from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.database.readers import assembly
from hydrosim.database.readers.text import Text, parse_number, read_text
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

NAME = "Nemoh project (Nemoh.cal)"

_CENTRES = re.compile(r"[XYZ]F\s*=\s*(\S+)\s*-\s*[XYZ]G\s*=\s*(\S+)")
_DISPLACEMENT = re.compile(r"Displacement\s*=\s*(\S+)")
_RIGID = np.tile(np.eye(3), (2, 1))  # directions of the six DOFs
_SIX = "surge, sway, heave, roll, pitch and yaw, in this order"
_TABLES = {
    f"{name}.tec"
    for name in ("radiationcoefficients", "excitationforce", "diffractionforce", "fkforce")
}
_ROUNDING = 1e-5  # of frequencies, which are printed in single precision
_BODY_HEAD = 3  # lines of a body before its DOFs: a ruler, the mesh, its size


class _Project(NamedTuple):
    """Data of Nemoh.cal."""

    density: float
    gravity: float
    depth: float
    wave_point: Real  # (2,)
    rotation_points: Real  # (nb, 3)
    heading: tuple[float, float, int]  # first, last [rad], number
    text: Text

    def headings(self) -> Real:
        """Evenly spaced headings [rad]. Call it after the tables have confirmed their number."""
        return np.linspace(*self.heading)


def sniff(path: Path, head: bytes) -> bool:
    """Whether Nemoh uses this name; other programs also have .tec files."""
    if path.name.lower() == "nemoh.cal":
        return True
    beside = _find_any_case(path.parent.parent, "Nemoh.cal")
    return path.suffix.lower() == ".tec" and (beside is not None or path.name.lower() in _TABLES)


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database of the project that ``path`` belongs to. Raises `InputError` for data that are
    missing or do not fit."""
    folder = path.parent if path.name.lower() == "nemoh.cal" else path.parent.parent
    project = _read_project(read_text(_require_file(folder, "Nemoh.cal")))
    bodies = len(project.rotation_points)
    results = _require_file(folder, "Results")
    tec = _require_file(results, "RadiationCoefficients.tec")
    omega, matrices = _read_zones(tec, 6 * bodies, 6 * bodies)
    loads = _first_order(results, project, omega)  # confirms the number of headings
    hydrostatics = _read_hydrostatics(folder, bodies, project.rotation_points)
    return assembly.assemble(
        project.text.path,
        omega,
        project.headings(),
        given.port_starboard_symmetric,
        used=given.frequencies,
        added_mass=matrices[..., 0].transpose(1, 2, 0),
        radiation_damping=matrices[..., 1].transpose(1, 2, 0),
        **loads,
        **_second_order(results, project),
        hydrostatic_stiffness=hydrostatics.stiffness,
        volume=assembly.volumes(path, given.volume, hydrostatics.volume),
        centre_of_buoyancy=assembly.points(
            path, "centre of buoyancy", given.centre_of_buoyancy, hydrostatics.buoyancy, bodies
        ),
        centre_of_gravity=assembly.points(
            path, "centre of gravity", given.centre_of_gravity, hydrostatics.gravity, bodies
        ),
        reference_point=project.rotation_points,
        water_depth=project.depth,
        water_density=project.density,
        gravity=project.gravity,
        attributes={"solver": "Nemoh"},
    )


def _find_any_case(folder: Path, name: str) -> Path | None:
    """A file or folder, in upper or lower case, which depends on the version."""
    if not folder.is_dir():
        return None
    return next((entry for entry in folder.iterdir() if entry.name.lower() == name.lower()), None)


def _require_file(folder: Path, name: str) -> Path:
    path = _find_any_case(folder, name)
    if path is None:
        raise InputError(
            f"{folder / name}: no such file or folder; expected one of a Nemoh project, with"
            " Nemoh.cal and Results in one folder. Run Nemoh to its end."
        )
    return path


def _read_project(text: Text) -> _Project:
    density, gravity, depth = (_read_values(text, line, 1, "a number")[0] for line in (1, 2, 3))
    wave_point = np.array(_read_values(text, 4, 2, "the wave measurement point"))
    bodies = text.count(6, _split_words(text, 6, "the number of bodies")[0])
    line = 7
    rotation_points: list[Real] = []
    while len(rotation_points) < bodies:
        line, point = _read_body(text, line)
        rotation_points.append(point)
    if not rotation_points:
        raise text.wrong(6, "no bodies", "at least one")
    words = _split_words(text, line + 2, "the number of headings, the first and the last")
    count = text.count(line + 2, words[0])
    if count == 0:
        raise text.wrong(line + 2, "no headings", "at least one")
    first, last = np.radians(text.numbers(line + 2, words[1:3], 2))
    return _Project(
        density,
        gravity,
        depth if depth > 0 else np.inf,
        wave_point,
        np.array(rotation_points),
        (first, last, count),
        text,
    )


def _split_words(text: Text, line: int, expected: str) -> list[str]:
    """Words before the comment, at least one."""
    words = text.line(line, expected).split("!")[0].split()
    if not words:
        raise text.wrong(line, "nothing", expected)
    return words


def _read_values(text: Text, line: int, count: int, expected: str) -> list[float]:
    return text.numbers(line, _split_words(text, line, expected)[:count], count)


def _read_body(text: Text, line: int) -> tuple[int, Real]:
    """The line after a body's description, and the point of rotation."""
    line += _BODY_HEAD
    motions = _read_motion(text, line, "degrees of freedom")
    forces = _read_motion(text, line + 7, "generalised forces")
    if (motions != forces).any():
        raise text.wrong(line + 7, "forces unlike the motions", "moments about the same point")
    line += 14
    extra = text.count(line, _split_words(text, line, "the number of additional lines")[0])
    return line + 1 + extra, motions


def _read_motion(text: Text, line: int, what: str) -> Real:
    """Point of rotation of six rigid DOFs or forces."""
    if text.count(line, _split_words(text, line, f"the number of {what}")[0]) != 6:
        raise text.wrong(line, "another number", f"6 {what}: {_SIX}", "Compute all six.")
    rows = np.array([_read_values(text, line + 1 + dof, 7, what) for dof in range(6)])
    kinds, directions, centres = rows[:, 0], rows[:, 1:4], rows[3:, 4:]
    if (kinds != [1, 1, 1, 2, 2, 2]).any() or (directions != _RIGID).any():
        raise text.wrong(line + 1, f"other {what}", _SIX)
    if (centres != centres[0]).any():
        raise text.wrong(line + 4, "rotations about several points", "one for each body")
    return np.asarray(centres[0])


def _read_zones(path: Path, zones: int, pairs: int) -> tuple[Real, Real]:
    """Frequencies (nw,) and tables (zones, nw, pairs, 2): rows of numbers between titles."""
    text = read_text(path)
    rows, starts = [], [0]
    for line, content in enumerate(text.lines):
        words = content.split()
        if words and parse_number(words[0]) is not None:
            rows.append(text.numbers(line, words, 1 + 2 * pairs))
        elif words and len(rows) > starts[-1]:
            starts.append(len(rows))
    if len(rows) > starts[-1]:
        starts.append(len(rows))
    sizes = {b - a for a, b in pairwise(starts)}
    if len(starts) != zones + 1 or len(sizes) != 1:
        raise InputError(
            f"{path}: found {len(starts) - 1} zones of {sorted(sizes)} rows, expected {zones} of"
            " the same number. The file is incomplete or belongs to another project; run Nemoh"
            " again."
        )
    table = np.array(rows).reshape(zones, -1, 1 + 2 * pairs)
    if (table[..., 0] != table[0, :, 0]).any():
        raise InputError(
            f"{path}: found zones with different frequencies, expected the same in all."
        )
    omega = assembly.frequencies(path, table[0, :, 0], _read_abscissa(text.lines[0]))
    return omega, table[..., 1:].reshape(zones, -1, pairs, 2)


def _read_abscissa(head: str) -> assembly.Abscissa:
    """Kind of the first column, from the head of a table."""
    if "rad" in head:
        return assembly.Abscissa.RADIANS_PER_SECOND
    if "Hz" in head:
        return assembly.Abscissa.HERTZ
    return (
        assembly.Abscissa.PERIOD
        if "(s)" in head or "[s]" in head
        else assembly.Abscissa.RADIANS_PER_SECOND
    )


def _first_order(results: Path, project: _Project, omega: Real) -> dict[str, Complex]:
    """Excitation and, if it was written, its Froude-Krylov part."""
    paths = {"excitation": _require_file(results, "ExcitationForce.tec")}
    if froude_krylov := _find_any_case(results, "FKForce.tec"):
        paths["froude_krylov"] = froude_krylov
    return {field: _read_loads(path, project, omega) for field, path in paths.items()}


def _read_loads(path: Path, project: _Project, omega: Real) -> Complex:
    """Loads (nw, nh, n); a phase for exp(-i w t) is a lag for exp(+i w t)."""
    headings, table = _read_zones(path, project.heading[2], 6 * len(project.rotation_points))
    if headings.shape != omega.shape or not np.allclose(headings, omega, rtol=_ROUNDING):
        raise InputError(
            f"{path}: has other frequencies than RadiationCoefficients.tec, expected the same."
            " The files belong to different runs; run Nemoh again."
        )
    loads = assembly.polar(table[..., 0], table[..., 1]).transpose(1, 0, 2)
    return assembly.at_origin(
        loads, omega, project.headings(), project.wave_point, project.depth, project.gravity
    )


def _second_order(results: Path, project: _Project) -> dict[str, Any]:
    """Quadratic transfer functions, if they were computed."""
    folder = _find_any_case(results, "QTF")
    if folder is None:
        return {}
    bodies = len(project.rotation_points)
    difference, total = (_read_pairs(folder, project, kind) for kind in ("M", "P"))
    return assembly.quadratic(folder, 6 * bodies, difference, total)


def _read_pairs(folder: Path, project: _Project, kind: str) -> assembly.Pairs | None:
    """Rows of all bodies of one kind."""
    bodies = len(project.rotation_points)
    whole = _find_any_case(folder, f"OUT_QTF{kind}_N.dat")
    paths = (
        [whole]
        if whole
        else [_find_any_case(folder, f"OUT_QTF{kind}_N_{k}.dat") for k in range(bodies)]
    )
    rows = [_read_rows(path, 6 * body) for body, path in enumerate(paths) if path]
    if not rows:
        return None
    omega, heading, dof, size, phase = (
        np.concatenate(column) for column in zip(*rows, strict=True)
    )
    if not np.isin(dof, np.arange(6 * bodies)).all():
        raise InputError(
            f"{folder}: found degrees of freedom beyond those of {bodies} bodies, expected 1 to 6"
            " for each. The files are damaged or belong to another project; run Nemoh again."
        )
    scale = project.density * project.gravity
    pairs = assembly.Pairs(omega, heading, dof.astype(np.intp), assembly.polar(scale * size, phase))
    return pairs.at_origin(project.wave_point, project.depth, project.gravity, kind == "M")


def _read_rows(path: Path, first_dof: int) -> tuple[Real, ...]:
    """Frequencies and headings (m, 2), DOFs, sizes and phases (m,) of one file."""
    text = read_text(path)
    words = [(line, content.split()) for line, content in enumerate(text.lines) if line > 0]
    rows = np.array([text.numbers(line, word, 9) for line, word in words if word])
    if rows.size == 0:
        raise text.wrong(0, "no rows", "a head and rows of nine numbers")
    return (
        assembly.frequencies(path, rows[:, :2], _read_abscissa(text.lines[0])),
        np.radians(rows[:, 2:4]),
        rows[:, 4] - 1 + first_dof,
        rows[:, 5],
        np.radians(rows[:, 6]),
    )


class _Hydrostatics(NamedTuple):
    """None if there is no file."""

    stiffness: Real | None = None
    volume: Real | None = None
    buoyancy: Real | None = None
    gravity: Real | None = None


def _read_hydrostatics(folder: Path, bodies: int, rotation_points: Real) -> _Hydrostatics:
    """Hydrostatics from Mesh/Hydrostatics.dat and Mesh/KH.dat; the stiffness is moved from the
    centres of gravity to the points of rotation."""
    mesh = _find_any_case(folder, "Mesh")
    files = (
        []
        if mesh is None
        else [_numbered_mesh(mesh, "Hydrostatics", k, bodies) for k in range(bodies)]
    )
    if not all(files) or not files:
        return _Hydrostatics()
    volume, buoyancy, gravity = zip(
        *[_hydrostatics_of(path) for path in files if path], strict=True
    )
    hydrostatics = _Hydrostatics(None, np.array(volume), np.array(buoyancy), np.array(gravity))
    matrices = [mesh and _numbered_mesh(mesh, "KH", k, bodies) for k in range(bodies)]
    if not all(matrices):
        return hydrostatics
    stiffness = assembly.block_diagonal([_read_matrix(path) for path in matrices if path])
    move = velocity_transfer(np.array(gravity) - rotation_points)
    return hydrostatics._replace(stiffness=move.T @ stiffness @ move)


def _numbered_mesh(mesh: Path, name: str, body: int, bodies: int) -> Path | None:
    """File of one body; that of a single body may have no number."""
    plain = _find_any_case(mesh, f"{name}.dat") if bodies == 1 else None
    return plain or _find_any_case(mesh, f"{name}_{body}.dat")


def _hydrostatics_of(path: Path) -> tuple[float, list[float], list[float]]:
    """Volume, centre of buoyancy and of gravity."""
    text = read_text(path)
    centres = [
        text.numbers(line, match.groups())
        for line, content in enumerate(text.lines)
        if (match := _CENTRES.search(content))
    ]
    volume = [
        text.number(line, match[1])
        for line, content in enumerate(text.lines)
        if (match := _DISPLACEMENT.search(content))
    ]
    if len(centres) != 3 or len(volume) != 1:
        raise text.wrong(
            0, f"{len(centres)} centres and {len(volume)} volumes", "lines for XF, YF, ZF and one"
        )
    return volume[0], [row[0] for row in centres], [row[1] for row in centres]


def _read_matrix(path: Path) -> Real:
    text = read_text(path)
    rows = [(line, content.split()) for line, content in enumerate(text.lines) if content.strip()]
    if len(rows) < 6:
        raise text.wrong(len(text.lines) - 1, f"{len(rows)} rows", "6")
    return np.array([text.numbers(line, words, 6) for line, words in rows[:6]])
