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
from hydrosim.database.readers.text import Text, read_text
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

# Common parts of VERES's result files: lines of text, then rows of numbers by speed.

HALF_TURN_SIGNS = np.array([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0])  # half a turn about z
NO_SPEED = 1e-6  # m/s

_TEXT = 6  # lines of it
_MIN_DIMENSION, _MAX_DIMENSION = 1e-3, 1e5  # of dimensions of a ship and properties of water


class NumberLines:
    """Rows of numbers, one after the other."""

    def __init__(self, path: Path) -> None:
        self.text: Text = read_text(path)
        self.at = _TEXT

    def row(self, what: str, *counts: int) -> list[float]:
        """The next line, with one of these counts of numbers."""
        words = self.text.line(self.at, what).split()
        self.at += 1
        if len(words) not in counts:
            raise self.wrong(f"{len(words)} numbers", f"{' or '.join(map(str, counts))}: {what}")
        return self.text.numbers(self.at - 1, words)

    def counts(self, what: str, count: int) -> list[int]:
        """The next line, of whole numbers."""
        return [self.text.count(self.at - 1, f"{value:g}") for value in self.row(what, count)]

    def matrix(self, what: str) -> Real:
        """Six rows of six, in our axes."""
        return np.array([self.row(what, 6) for _ in range(6)]) * np.outer(
            HALF_TURN_SIGNS, HALF_TURN_SIGNS
        )

    def wrong(self, text: str, expected: str, *advice: str) -> InputError:
        """Error to raise about the last line read."""
        return self.text.wrong(self.at - 1, text, expected, *advice)


@dataclass(frozen=True)
class Ship:
    """Data in the head of a file, in SI units."""

    density: float
    gravity: float
    length: float
    breadth: float
    draught: float


def ship_of(lines: NumberLines) -> Ship:
    """Values of the next two lines."""
    density, gravity = lines.row("density and gravity", 2)
    ship = Ship(density, gravity, *lines.row("length, breadth and draught", 3))
    sizes = density, gravity, ship.length, ship.breadth
    if not _MIN_DIMENSION <= min(sizes) <= max(sizes) <= _MAX_DIMENSION:
        raise lines.wrong("numbers of no ship", "density, gravity, length and breadth in SI units")
    return ship


def counts_of(lines: NumberLines) -> tuple[int, int, int]:
    """Numbers of speeds, headings and frequencies."""
    *counts, dofs = lines.counts("numbers of speeds, headings, frequencies and DOFs", 4)
    if dofs != 6 or 0 in counts:
        raise lines.wrong(
            f"{counts} speeds, headings and frequencies and {dofs} DOFs",
            "one at least of each and 6 DOFs",
            "Leave out the air cushion.",
        )
    return counts[0], counts[1], counts[2]


def skip_to_zero_speed(lines: NumberLines, speeds: int, size: int) -> tuple[float, float]:
    """Skip to the speed of zero, with ``size`` lines for each speed. Returns the position of its
    motion coordinate system, aft of amidships and above the keel."""
    values = []
    for _ in range(speeds):
        speed, sinkage, trim, *place = lines.row("speed, sinkage, trim, and X and Z of motions", 5)
        if sinkage or trim:
            raise lines.wrong(
                f"a sinkage of {sinkage:g} m and a trim of {trim:g} degrees",
                "none",
                "Give VERES the draught at which the ship floats, and no trim.",
            )
        if abs(speed) < NO_SPEED:
            return place[0], place[1]
        values.append(f"{speed:g}")
        lines.at += size
    raise lines.wrong(
        f"speeds of {', '.join(values)} m/s",
        "one of zero",
        "Let VERES compute a speed of zero, too.",
    )


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
    path = _require_file(path)
    coefficients = _read_coefficients(NumberLines(path))
    _warn_of_omissions(path, coefficients)
    loads = _sibling_file(path, ".re8")
    none = np.empty(0), np.empty((coefficients.frequency.size, 0, 6), dtype=complex)
    heading, excitation = _read_loads(NumberLines(loads), coefficients) if loads else none
    drift = _sibling_file(path, ".re2") if loads else None
    mean = {"mean_drift": _read_drift(NumberLines(drift), coefficients, heading)} if drift else {}
    method = {"mean_drift_method": "surge, sway, yaw by VERES; heave, roll, pitch zero"}
    ship, (ahead, above) = coefficients.ship, coefficients.centre
    depth = {} if given.water_depth else {"assumed": "water depth inf"}
    return assemble(
        path,
        coefficients.frequency,
        heading,
        given.port_starboard_symmetric is not False,
        used=given.frequencies,
        added_mass=coefficients.added_mass,
        radiation_damping=coefficients.damping,
        excitation=excitation,
        **mean,
        hydrostatic_stiffness=coefficients.stiffness,
        inertia_matrix=coefficients.inertia,
        volume=volumes(path, given.volume, coefficients.inertia[2:3, 2] / ship.density),
        centre_of_buoyancy=points(path, "centre of buoyancy", given.centre_of_buoyancy, None, 1),
        centre_of_gravity=np.array([[ahead, 0.0, above]]),
        reference_point=np.array([[0.0, 0.0, coefficients.origin]]),
        water_depth=given.water_depth or np.inf,
        water_density=ship.density,
        gravity=ship.gravity,
        attributes={"solver": "VERES", **depth, **(method if mean else {})},
    )


def _require_file(path: Path) -> Path:
    """The .re7 of the set that ``path`` belongs to."""
    existing_path = (
        path if path.suffix.lower() not in _SET - {".re7"} else _sibling_file(path, ".re7")
    )
    if existing_path is None:
        raise InputError(
            f"{path.with_suffix('.re7')}: no such file, expected it beside {path.name}: it has the"
            " coefficients. Let VERES write the hydrodynamic coefficients (IOUTRE7 = 1)."
        )
    return existing_path


def _sibling_file(path: Path, suffix: str) -> Path | None:
    names = (path.with_suffix(suffix), path.with_suffix(suffix.upper()))
    return next((name for name in names if name.is_file()), None)


def _read_coefficients(lines: NumberLines) -> _Coefficients:
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
    place = skip_to_zero_speed(lines, speeds, headings * (1 + _BLOCK * count))
    lines.row("a heading", 1)
    blocks = [_read_block(lines) for _ in range(count)]
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


def _read_block(lines: NumberLines) -> tuple[float, Real, list[float]]:
    """Frequency, six matrices (6, 6, 6) and roll damping."""
    omega = lines.row("a frequency", 1)[0]
    kinds = ("added mass", "damping", "stiffness")
    matrices = [lines.matrix(f"{more}{kind}") for kind in kinds for more in ("", "additional ")]
    return omega, np.array(matrices), lines.row("viscous roll damping", 3)


def _read_loads(lines: NumberLines, coefficients: _Coefficients) -> tuple[Real, Complex]:
    """Headings (nh,) and loads (nw, nh, 6) of .re8; columns with parts of the loads are skipped."""
    ship_of(lines)
    lines.row("the centre of gravity, LCG and VCG", 2)
    speeds, headings, count = counts_of(lines)
    skip_to_zero_speed(lines, speeds, headings * (1 + 7 * count))
    degrees, loads = [], []
    for _ in range(headings):
        degrees += lines.row("a heading", 1)
        for w in range(count):
            _require_frequencies(
                lines,
                lines.row("a frequency", 1)[0],
                coefficients.frequency,
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
    return _wave_heading(degrees), array


def _read_drift(lines: NumberLines, coefficients: _Coefficients, heading: Real) -> Real:
    """Drift (nw, nh, 6) of .re2, at the frequencies and headings of the loads."""
    ship = ship_of(lines)
    speeds, headings, count = lines.counts("numbers of speeds, headings and frequencies", 3)
    drifts: dict[float, list[list[float]]] = {}
    for _ in range(speeds * headings):
        speed, degrees = lines.row("speed and heading", 2)
        rows = []
        for w in range(count):
            omega, *three = lines.row("frequency and three drift coefficients", 4)
            _require_frequencies(lines, omega, coefficients.frequency, w, _ROUNDING)
            rows.append(three)
        if abs(speed) < NO_SPEED:
            drifts[float(_wave_heading([degrees])[0])] = rows
    if set(drifts) != set(heading.tolist()):
        raise lines.wrong(
            f"{len(drifts)} headings at a speed of zero",
            f"the {heading.size} of {lines.text.path.with_suffix('.re8').name}",
            _OTHER_RUN,
        )
    scale = ship.density * ship.gravity * ship.breadth**2
    drift = np.zeros((count, heading.size, 6))
    drift[..., [0, 1, 5]] = np.array([drifts[b] for b in heading.tolist()]).swapaxes(0, 1)
    return drift * HALF_TURN_SIGNS * scale / np.array([ship.length] * 3 + [1.0] * 3)


def _require_frequencies(
    lines: NumberLines, omega: float, frequencies: Real, index: int, tolerance: float
) -> None:
    """Raises `InputError` if a frequency differs from that of .re7."""
    if index >= frequencies.size or abs(omega - frequencies[index]) > tolerance:
        raise lines.wrong(
            f"{omega:g} rad/s",
            f"the frequencies of {lines.text.path.with_suffix('.re7').name}",
            _OTHER_RUN,
        )


def _wave_heading(degrees: list[float]) -> Real:
    """Headings that waves go to in our axes, [rad]."""
    return np.radians(np.mod(np.array(degrees) + 180.0, 360.0))


def _warn_of_omissions(path: Path, coefficients: _Coefficients) -> None:
    """Warn of data that are left out and are not zero."""
    kinds = ("added mass", "damping", "stiffness")
    parts = [
        f"additional {kind} of up to {size:.3g} (SI units)"
        for kind, size in zip(kinds, coefficients.other, strict=True)
        if size > 0
    ]
    linear, quadratic = np.abs(coefficients.viscous).max(axis=0)
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
