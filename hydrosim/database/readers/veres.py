"""ShipX Vessel Responses (VERES): name.re7 with coefficients, .re8 with loads, .re2 with drift.

All files begin with six lines of text; numbers follow in SI units and degrees. Coefficients and
loads are read for zero speed, one hull and deep water. Added mass and damping are those of the
first heading, because without speed all headings have the same. VERES stores some data separately:
matrices of tanks, fins and foils or of the user, and viscous roll damping. These are left out with
a warning. Strip theory has no added mass in surge.

VERES has x aft, y to starboard and z up, so its numbers are rotated by half a turn about z. Its
motion coordinate system is the origin of coefficients, loads and phases. Here it is the reference
point and, at the waterline, the frame's origin. Heading 0 is head seas, and 90 is waves that go to
starboard. The time factor is exp(+i w t). Drift is per amplitude squared over rho g B^2 / Lpp, in
yaw over rho g B^2.

Layout: MSS's readers (Fossen, MIT licence), those of NTNU students after the user's manual, and the
results of MSS's supply vessel (VERES 4.02.3). Its loads and matrices reproduce its own motions
(.re1). In long waves its loads are those of static water under the waves' pressure, which
determines axes, headings, time factor and origin. The scale of the drift comes from MSS. In short
waves at 60 degrees it gives rho g Lpp / 2 times the squared sine, the load on a wall.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.database.readers.assembly import assemble, points, volumes
from hydrosim.database.readers.veres_text import (
    HALF_TURN_SIGNS,
    NO_SPEED,
    NumberLines,
    Ship,
    at_rest,
    counts_of,
    ship_of,
)
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

NAME = "ShipX (VERES) .re7"

_SET = {".re1", ".re2", ".re7", ".re8"}
_BLOCK = 38  # lines of one frequency: the frequency, six matrices and the viscous roll damping
_ROUNDING = 1e-3  # rad/s: frequencies of .re2 have four decimals
_FREQUENCY_TOLERANCE_RAD_S = 1e-6  # rad/s: .re7 and .re8 print them alike
_OTHER_RUN = "The files belong to different runs; run VERES again."


@dataclass(frozen=True)
class _Coefficients:
    """Data of .re7 (nw, 6, 6). ``other`` are additional matrices of VERES; ``viscous`` (nw, 2) is
    roll damping, linear and quadratic."""

    ship: Ship
    centre: Real  # (2,): of gravity, forward of the origin and above the waterline
    origin: float  # of the motion coordinate system above the waterline
    inertia: Real
    frequency: Real
    added_mass: Real
    damping: Real
    stiffness: Real
    other: Real  # (3,): largest
    viscous: Real


def sniff(path: Path, head: bytes) -> bool:
    """Whether the name, or the first line, is that of VERES."""
    return path.suffix.lower() in _SET or b"- VERES Version" in head.split(b"\n")[0]


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database in a .re7 file and those beside it. Raises `InputError` for data that are missing or
    do not fit."""
    path = _existing(path)
    found = _coefficients(NumberLines(path))
    _warn(path, found)
    loads = _sibling_file(path, ".re8")
    none = np.empty(0), np.empty((found.frequency.size, 0, 6), dtype=complex)
    heading, excitation = _loads(NumberLines(loads), found) if loads else none
    drift = _sibling_file(path, ".re2") if loads else None
    mean = {"mean_drift": _drift(NumberLines(drift), found, heading)} if drift else {}
    method = {"mean_drift_method": "surge, sway, yaw by VERES; heave, roll, pitch zero"}
    ship, (ahead, above) = found.ship, found.centre
    depth = {} if given.water_depth else {"assumed": "water depth inf"}
    return assemble(
        path,
        found.frequency,
        heading,
        given.port_starboard_symmetric is not False,
        used=given.frequencies,
        added_mass=found.added_mass,
        radiation_damping=found.damping,
        excitation=excitation,
        **mean,
        hydrostatic_stiffness=found.stiffness,
        inertia_matrix=found.inertia,
        volume=volumes(path, given.volume, found.inertia[2:3, 2] / ship.density),
        centre_of_buoyancy=points(path, "centre of buoyancy", given.centre_of_buoyancy, None, 1),
        centre_of_gravity=np.array([[ahead, 0.0, above]]),
        reference_point=np.array([[0.0, 0.0, found.origin]]),
        water_depth=given.water_depth or np.inf,
        water_density=ship.density,
        gravity=ship.gravity,
        attributes={"solver": "VERES", **depth, **(method if mean else {})},
    )


def _existing(path: Path) -> Path:
    """The .re7 of the set that ``path`` belongs to."""
    found = path if path.suffix.lower() not in _SET - {".re7"} else _sibling_file(path, ".re7")
    if found is None:
        raise InputError(
            f"{path.with_suffix('.re7')}: no such file, expected it beside {path.name}: it has the"
            " coefficients. Let VERES write the hydrodynamic coefficients (IOUTRE7 = 1)."
        )
    return found


def _sibling_file(path: Path, suffix: str) -> Path | None:
    names = (path.with_suffix(suffix), path.with_suffix(suffix.upper()))
    return next((name for name in names if name.is_file()), None)


def _coefficients(lines: NumberLines) -> _Coefficients:
    ship, (aft, keel) = ship_of(lines), lines.row("the centre of gravity, LCG and VCG", 2)
    version = lines.row("the version, -1 and 2", 2, 4)
    if version != [-1.0, 2.0]:
        raise lines.wrong(
            " ".join(f"{x:g}" for x in version),
            "-1 2, which is version 2",
            "Write the file with a newer ShipX.",
        )
    speeds, headings, count = counts_of(lines)
    inertia = lines.matrix("the mass matrix")
    place = at_rest(lines, speeds, headings * (1 + _BLOCK * count))
    lines.row("a heading", 1)
    blocks = [_block(lines) for _ in range(count)]
    frequency, matrices, roll = (np.array(column) for column in zip(*blocks, strict=True))
    added, other_added, damping, other_damping, stiffness, other = matrices.swapaxes(0, 1)
    return _Coefficients(
        ship,
        np.array([place[0] - aft, keel - ship.draught]),
        place[1] - ship.draught,
        inertia,
        frequency,
        added,
        damping,
        stiffness[0],
        np.array([np.abs(value).max() for value in (other_added, other_damping, other)]),
        roll[:, :2],
    )


def _block(lines: NumberLines) -> tuple[float, Real, list[float]]:
    """Frequency, six matrices (6, 6, 6) and roll damping."""
    omega = lines.row("a frequency", 1)[0]
    kinds = ("added mass", "damping", "stiffness")
    matrices = [lines.matrix(f"{more}{kind}") for kind in kinds for more in ("", "additional ")]
    return omega, np.array(matrices), lines.row("viscous roll damping", 3)


def _loads(lines: NumberLines, known: _Coefficients) -> tuple[Real, Complex]:
    """Headings (nh,) and loads (nw, nh, 6) of .re8; columns with parts of the loads are skipped."""
    ship_of(lines)
    lines.row("the centre of gravity, LCG and VCG", 2)
    speeds, headings, count = counts_of(lines)
    at_rest(lines, speeds, headings * (1 + 7 * count))
    degrees, loads = [], []
    for _ in range(headings):
        degrees += lines.row("a heading", 1)
        for w in range(count):
            _require_frequencies(
                lines,
                lines.row("a frequency", 1)[0],
                known.frequency,
                w,
                _FREQUENCY_TOLERANCE_RAD_S,
            )
            rows = [lines.row("DOF, real and imaginary part", 3, 9) for _ in range(6)]
            loads.append([complex(row[1], row[2]) for row in rows])
            if [row[0] for row in rows] != [1, 2, 3, 4, 5, 6]:
                raise lines.wrong(f"DOFs {[row[0] for row in rows]}", "1 to 6 in this order")
    if len(set(degrees)) < headings:
        raise lines.wrong("a heading twice", "each of them once")
    array = np.array(loads).reshape(headings, count, 6).swapaxes(0, 1) * HALF_TURN_SIGNS
    return _heading(degrees), array


def _drift(lines: NumberLines, known: _Coefficients, heading: Real) -> Real:
    """Drift (nw, nh, 6) of .re2, at the frequencies and headings of the loads."""
    ship = ship_of(lines)
    speeds, headings, count = lines.counts("numbers of speeds, headings and frequencies", 3)
    found: dict[float, list[list[float]]] = {}
    for _ in range(speeds * headings):
        speed, degrees = lines.row("speed and heading", 2)
        rows = []
        for w in range(count):
            omega, *three = lines.row("frequency and three drift coefficients", 4)
            _require_frequencies(lines, omega, known.frequency, w, _ROUNDING)
            rows.append(three)
        if abs(speed) < NO_SPEED:
            found[float(_heading([degrees])[0])] = rows
    if set(found) != set(heading.tolist()):
        raise lines.wrong(
            f"{len(found)} headings at a speed of zero",
            f"the {heading.size} of {lines.text.path.with_suffix('.re8').name}",
            _OTHER_RUN,
        )
    scale = ship.density * ship.gravity * ship.breadth**2
    drift = np.zeros((count, heading.size, 6))
    drift[..., [0, 1, 5]] = np.array([found[b] for b in heading.tolist()]).swapaxes(0, 1)
    return drift * HALF_TURN_SIGNS * scale / np.array([ship.length] * 3 + [1.0] * 3)


def _require_frequencies(
    lines: NumberLines, omega: float, known: Real, index: int, tolerance: float
) -> None:
    """Raises `InputError` if a frequency differs from that of .re7."""
    if index >= known.size or abs(omega - known[index]) > tolerance:
        raise lines.wrong(
            f"{omega:g} rad/s",
            f"the frequencies of {lines.text.path.with_suffix('.re7').name}",
            _OTHER_RUN,
        )


def _heading(degrees: list[float]) -> Real:
    """Headings that waves go to in our axes, [rad]."""
    return np.radians(np.mod(np.array(degrees) + 180.0, 360.0))


def _warn(path: Path, found: _Coefficients) -> None:
    """Warn of data that are left out and are not zero."""
    kinds = ("added mass", "damping", "stiffness")
    parts = [
        f"additional {kind} of up to {size:.3g} (SI units)"
        for kind, size in zip(kinds, found.other, strict=True)
        if size > 0
    ]
    linear, quadratic = np.abs(found.viscous).max(axis=0)
    if linear or quadratic:
        parts.append(
            f"viscous roll damping of up to {linear:.3g} N m s/rad and {quadratic:.3g} N m s²/rad²"
        )
    if parts:
        warnings.warn(
            f"{path}: {', '.join(parts)} are left out, because they come from tanks, fins, foils"
            " or bilge keels and radiate no waves. Add the parts that belong to the body to the"
            " case.",
            stacklevel=2,
        )
