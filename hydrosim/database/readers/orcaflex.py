"""OrcaFlex vessel types: text data files (.yml) with load RAOs, added mass, damping and stiffness.

Verified with a file of OrcaFlex 11.0 with a diffraction result. It shows the layout of all
first-order tables, of hydrostatics and of the (empty) table of sum-frequency transfer functions.
Units are te, kN, m (SI), kips, kips, ft (US), or those that the file names (User). The centre of
gravity is CentreOfMass in files of 11.0 to 11.4, and CentreOfGravity in others. Phases lag the
crest at the phase origin (~ for the RAO origin), as the loads in long waves confirm. Period 0 is
infinite frequency. Headings are directions that waves go to. By the program's help, the stiffness
includes the weight, as from diffraction programs. The sign conventions apply to stiffness, added
mass and damping, too, but not to the positions of origins.

Not verified with a file: the other phase conventions, wave drift and sum-frequency rows. A
difference-frequency load is read as the amplitude of cos((w_1 - w_2) t - lag). Data of several
vessel types or draughts, of inclined vessels and of multibody groups are refused, and so are RAOs
per other quantities than wave amplitude. Damping other than by waves, wind and current are left
out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from hydrosim.database.changes import velocity_transfer
from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.database.readers import assembly
from hydrosim.database.readers.text import parse_number, read_text
from hydrosim.errors import InputError
from hydrosim.files.units import value_text
from hydrosim.files.yaml_nodes import MAX_NESTING
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

NAME = "OrcaFlex vessel type"

_GRAVITY = 9.80665  # OrcaFlex's own, m/s^2
_FREQUENCY_RTOL = 1e-6  # relative difference of equal frequencies
_HEAVE_ROLL_PITCH = [2, 3, 4]
_DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
_PAIR = ("RAOPeriodOrFrequency1", "RAOPeriodOrFrequency2", "RAODirection1", "RAODirection2")

# keys of the six sign conventions, and our values
_POSITIVE = {
    "SurgePositive": ("forward", "aft"),
    "SwayPositive": ("port", "starboard"),
    "HeavePositive": ("up", "down"),
    "RollPositiveStarboard": ("down", "up"),
    "PitchPositiveBow": ("down", "up"),
    "YawPositiveBow": ("port", "starboard"),
}
_ABSCISSA_BY_UNIT = {
    "period (s)": assembly.Abscissa.PERIOD,
    "frequency (rad/s)": assembly.Abscissa.RADIANS_PER_SECOND,
    "frequency (Hz)": assembly.Abscissa.HERTZ,
}
_CENTRES = ("CentreOfMass", "CentreOfGravity")
_LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": 0.3048, "in": 0.0254}
_POUND = 0.45359237  # kg
_MASSES = {
    "te": 1e3,
    "kg": 1.0,
    "slug": _POUND * _GRAVITY / 0.3048,
    **dict.fromkeys(("lb", "lbm"), _POUND),
    **dict.fromkeys(("kip", "kips"), 1e3 * _POUND),
}
_FORCES = {
    "kN": 1e3,
    "N": 1.0,
    "MN": 1e6,
    **dict.fromkeys(("te", "tef"), 1e3 * _GRAVITY),
    **dict.fromkeys(("kg", "kgf"), _GRAVITY),
    **dict.fromkeys(("lb", "lbf"), _POUND * _GRAVITY),
    **dict.fromkeys(("kip", "kips", "kipf"), 1e3 * _POUND * _GRAVITY),
}
_NAMED_UNITS = {"SI": ("m", "te", "kN"), "US": ("ft", "kips", "kips")}
# reference of the phases, as a lag behind the crest
_REFERENCE = {
    "crest": 0.0,
    "zero down-crossing": np.pi / 2,
    "trough": np.pi,
    "zero up-crossing": 3 * np.pi / 2,
}
_SYMMETRY = ("None", "xz plane", "yz plane", "xz and yz planes", "circular")


_LOADER = getattr(yaml, "CBaseLoader", yaml.BaseLoader)


class _Node:
    """A mapping of the file with its place, keys and numbers of items; its scalars are texts."""

    def __init__(self, path: Path, place: tuple[str | int, ...], content: Any) -> None:
        self.path = path
        self.place = place
        self.content = content
        if not isinstance(content, dict):
            raise self.wrong("", value_text(content), "a mapping")

    def wrong(self, key: str, text: str, expected: str) -> InputError:
        """Error to raise about a key."""
        place = (*self.place, key) if key else self.place
        name = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
        return InputError(
            f"{self.path}: line {_line_of(self.path, place)}: {name.lstrip('.') or 'the file'}:"
            f" found {text}, expected {expected}. Save the OrcaFlex model as text data again, or"
            " correct the entry."
        )

    def get(self, key: str) -> Any:
        """Value of a key, which must exist."""
        if key not in self.content:
            raise self.wrong(key, "nothing", "an entry")
        return self.content[key]

    def node(self, key: str) -> _Node:
        """The mapping under a key."""
        return _Node(self.path, (*self.place, key), self.get(key))

    def nodes(self, key: str) -> list[_Node]:
        """The mappings in the list under a key."""
        items = self.get(key)
        if not isinstance(items, list):
            raise self.wrong(key, value_text(items), "a list")
        return [_Node(self.path, (*self.place, key, i), item) for i, item in enumerate(items)]

    def choice(self, key: str, choices: Sequence[str]) -> str:
        """Value of a key that is one of several words."""
        value = self.get(key)
        if value not in choices:
            raise self.wrong(key, value_text(value).strip('"'), f"one of {', '.join(choices)}")
        return str(value)

    def number(self, key: str) -> float:
        """One number, which may be infinite."""
        return math.inf if self.get(key) == "Infinity" else float(self.numbers(key, ()))

    def numbers(self, key: str, shape: tuple[int, ...]) -> Real:
        """Finite numbers in nested lists; -1 in ``shape`` allows any number of rows."""
        rows = self.get(key)
        flat = list(_flatten(rows, len(shape)))
        values = [parse_number(word) if isinstance(word, str) else None for word in flat]
        if None in values:
            raise self.wrong(key, value_text(flat[values.index(None)]), "a number")
        try:
            return np.array(values, dtype=float).reshape(shape)
        except ValueError:
            raise self.wrong(key, f"{len(flat)} numbers", f"a table of {shape}") from None

    def table(self, first: str) -> tuple[list[str], Real]:
        """Columns and rows (m, columns) of the table whose first column has this name."""
        key = next((key for key in self.content if key.split(",")[0].strip() == first), None)
        if key is None:
            raise self.wrong(first, "nothing", "a table that begins with this column")
        columns = [name.strip() for name in key.split(",")]
        return columns, self.numbers(key, (-1, len(columns)))


class _Conventions(NamedTuple):
    """Conventions of one vessel type."""

    abscissa: assembly.Abscissa
    sign: Real  # (6,)
    leads: bool
    phase_unit: float  # rad
    reference: float  # rad

    def lag(self, phase: Real, waves: int) -> Real:
        """Lag behind the crest; for a sum of phases of several ``waves``, the sum of their lags."""
        lag = phase * (-self.phase_unit if self.leads else self.phase_unit)
        return np.asarray(lag + waves * self.reference)


class _Units(NamedTuple):
    """Units of length [m], mass [kg] and force [N] of a file."""

    length: float
    mass: float
    force: float

    @property
    def arms(self) -> Real:
        """Units (6,) of a motion: 1 for a length, and the unit of length of an arm per radian."""
        return np.array([1.0, 1.0, 1.0, self.length, self.length, self.length])

    @property
    def stiffness(self) -> Real:
        """Units (6, 6) of stiffness, and of damping over seconds."""
        return self.force / self.length * np.outer(self.arms, self.arms)

    @property
    def inertia(self) -> Real:
        """Units (6, 6) of mass and added mass."""
        return self.mass * np.outer(self.arms, self.arms)

    def loads(self, waves: int) -> Real:
        """Units (6,) of loads over so many wave amplitudes."""
        return self.force / self.length**waves * self.arms


class _Vessel(NamedTuple):
    """One draught of one type; its ``reference`` and ``waterline`` are in m."""

    draught: _Node
    units: _Units
    conventions: _Conventions
    symmetry: str
    reference: Real  # origin of the matrices in vessel axes
    waterline: float  # in vessel axes
    depth: float
    gravity: float


def sniff(path: Path, head: bytes) -> bool:
    """Whether it is a YAML file that names the program or has its first sections."""
    return path.suffix.lower() in (".yml", ".yaml") and any(
        mark in head for mark in (b"Program: OrcaFlex", b"VesselTypes:", b"UnitsSystem:")
    )


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database in an OrcaFlex file with one vessel type and draught. Raises `InputError` for data
    that are missing or do not fit."""
    model = _Node(path, (), _load_content(path))
    vessel = _find_vessel(model, given)
    draught = vessel.draught
    units = vessel.units
    lift = np.array([0.0, 0.0, vessel.waterline])
    omega, added_mass, damping = _read_matrices(vessel)
    waves, heading, excitation = _first_order(vessel)
    rows = _matching_rows(draught, omega, waves)
    centre = units.length * draught.numbers(_centre_key(draught), (3,)) - lift
    buoyancy = units.length * draught.numbers("CentreOfBuoyancy", (3,)) - lift
    volume = units.length**3 * draught.numbers("DisplacedVolume", ())
    reference = vessel.reference - lift
    return assembly.assemble(
        path,
        omega,
        heading,
        _read_symmetry(vessel, given),
        used=given.frequencies,
        added_mass=added_mass,
        radiation_damping=damping,
        excitation=excitation[rows],
        mean_drift=_mean_drift(vessel, waves, heading, rows),
        **_second_order(vessel),
        hydrostatic_stiffness=_read_stiffness(vessel),
        inertia_matrix=_read_inertia(draught, centre - reference, units),
        volume=assembly.volumes(path, given.volume, volume),
        centre_of_gravity=assembly.points(path, "CentreOfMass", given.centre_of_gravity, centre, 1),
        centre_of_buoyancy=assembly.points(
            path, "CentreOfBuoyancy", given.centre_of_buoyancy, buoyancy, 1
        ),
        reference_point=reference[None],
        water_depth=vessel.depth,
        water_density=_read_density(model, given, units),
        gravity=vessel.gravity,
        attributes={"solver": "OrcaFlex vessel type"},
    )


def _load_content(path: Path) -> Any:
    """Document with all scalars as texts, because YAML does not recognise 12e3 as a number."""
    text = "\n".join(read_text(path).lines)
    try:
        _require_shallow(path, yaml.parse(text, Loader=_LOADER))
        return yaml.load(text, Loader=_LOADER)
    except yaml.MarkedYAMLError as error:
        line = 0 if error.problem_mark is None else error.problem_mark.line
        raise InputError(
            f"{path}: line {line + 1}: {error.problem}; expected YAML. The file is damaged; save"
            " the model as text data again."
        ) from error
    except (yaml.YAMLError, RecursionError) as error:
        raise InputError(
            f"{path}: cannot be read as YAML ({str(error)[:200]}). The file is damaged; save the"
            " model as text data again."
        ) from error


def _require_shallow(path: Path, events: Iterable[yaml.Event]) -> None:
    """Refuse lists and mappings nested too deeply for the loader, which would crash."""
    depth = 0
    for event in events:
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if depth > MAX_NESTING and event.start_mark:
            raise InputError(
                f"{path}: line {event.start_mark.line + 1}: found more than {MAX_NESTING} nested"
                " lists and mappings; expected at most that. The file is damaged; save the model"
                " as text data again."
            )


def _line_of(path: Path, place: tuple[str | int, ...]) -> int:
    """The line of an entry, or of the last one above it that is there."""
    node = yaml.compose("\n".join(read_text(path).lines), Loader=_LOADER)
    line = 1
    for part in place:
        if isinstance(node, yaml.MappingNode):
            scalars = (pair for pair in node.value if isinstance(pair[0], yaml.ScalarNode))
            entries = {pair[0].value: pair for pair in scalars}
            if part not in entries:
                break
            key, node = entries[part]
            line = key.start_mark.line + 1
        elif isinstance(node, yaml.SequenceNode) and isinstance(part, int):
            node = node.value[part]
            line = node.start_mark.line + 1
    return line


def _flatten(item: Any, depth: int) -> Iterator[Any]:
    """Scalars in nested lists, not deeper than ``depth``; a scalar may replace a list of one."""
    if isinstance(item, list) and depth > 0:
        for part in item:
            yield from _flatten(part, depth - 1)
    else:
        yield item


def _find_vessel(model: _Node, given: Given) -> _Vessel:
    """The requested draught, or the only one, among those with wave loads."""
    candidates = [
        (kind, draught)
        for kind in model.nodes("VesselTypes")
        for draught in kind.nodes("Draughts")
        if _tables_of(draught)
    ]
    names = [_draught_label(kind, draught) for kind, draught in candidates]
    if given.draught is not None:
        chosen = [k for k, name in enumerate(names) if name == given.draught]
        candidates = [candidates[k] for k in chosen]
    if not names:
        raise model.wrong(
            "VesselTypes",
            "no draught with load RAOs",
            "one: displacement RAOs are motions, which a `drive` prescribes, and no loads",
        )
    if len(candidates) != 1:
        raise model.wrong(
            "VesselTypes",
            f"draughts with load RAOs: {' and '.join(map(repr, names))}",
            "one: choose it by its name, with `draught` in a case or `--given draught=` for"
            " `hydrosim db`",
        )
    kind, draught = candidates[0]
    draught.choice("AMDMethod", ["Frequency dependent"])
    units, gravity = _read_units(model.node("General"))
    reference = units.length * draught.numbers("ReferenceOrigin", (3,))
    height, heel, trim = draught.numbers("ReferenceOriginDatumPosition", (3,))
    if heel or trim:
        raise draught.wrong("ReferenceOriginDatumPosition", "heel or trim", "an upright vessel")
    depth = units.length * model.node("Environment").number("WaterDepth")
    return _Vessel(
        draught,
        units,
        _read_conventions(kind),
        kind.choice("Symmetry", _SYMMETRY),
        reference,
        reference[2] - units.length * height,
        assembly.require_number(model.path, "water depth", given.water_depth, depth),
        gravity if given.gravity is None else given.gravity,
    )


def _read_units(general: _Node) -> tuple[_Units, float]:
    """Units of the file, and gravity [m/s^2]."""
    system = general.choice("UnitsSystem", ["SI", "US", "User"])
    if system in _NAMED_UNITS:
        names = _NAMED_UNITS[system]
        return _Units(_LENGTHS[names[0]], _MASSES[names[1]], _FORCES[names[2]]), _GRAVITY
    length = _LENGTHS[general.choice("LengthUnits", [*_LENGTHS])]
    mass = _MASSES[general.choice("MassUnits", [*_MASSES])]
    force = _FORCES[general.choice("ForceUnits", [*_FORCES])]
    if "TimeUnits" in general.content:
        general.choice("TimeUnits", ["s"])
    gravity = length * general.number("g") if "g" in general.content else _GRAVITY
    return _Units(length, mass, force), gravity


def _centre_key(draught: _Node) -> str:
    """Key of the centre of gravity."""
    given_keys = [key for key in _CENTRES if key in draught.content]
    if len(given_keys) != 1:
        keys_text = " and ".join(given_keys) or "nothing"
        raise draught.wrong(_CENTRES[0], keys_text, f"one of {' and '.join(_CENTRES)}")
    return given_keys[0]


def _draught_label(kind: _Node, draught: _Node) -> str:
    """Name of a draught: type and draught."""
    return ", ".join(
        value_text(node.content.get("Name", "unnamed")).strip('"') for node in (kind, draught)
    )


def _tables_of(draught: _Node) -> list[_Node]:
    """Load RAOs by direction, if the draught has any."""
    return draught.node("LoadRAOs").nodes("RAOs") if "LoadRAOs" in draught.content else []


def _read_conventions(kind: _Node) -> _Conventions:
    kind.choice("RAOWaveUnit", ["amplitude"])
    units = {"degrees": np.pi / 180, "radians": 1.0}
    return _Conventions(
        _ABSCISSA_BY_UNIT[kind.choice("WavesReferredToBy", list(_ABSCISSA_BY_UNIT))],
        np.array([1.0 if kind.choice(k, c) == c[0] else -1.0 for k, c in _POSITIVE.items()]),
        kind.choice("RAOPhaseConvention", ["lags", "leads"]) == "leads",
        units[kind.choice("RAOPhaseUnitsConvention", list(units))],
        _REFERENCE[kind.choice("RAOPhaseRelativeToConvention", list(_REFERENCE))],
    )


def _read_density(model: _Node, given: Given, units: _Units) -> float:
    environment = model.node("Environment")
    density = None
    if "Density" in environment.content:
        density = units.mass / units.length**3 * environment.number("Density")
    return assembly.require_number(model.path, "water density", given.water_density, density)


def _read_matrices(vessel: _Vessel) -> tuple[Real, Real, Real]:
    """Frequencies, among them zero and infinity, added mass and damping (nw, 6, 6)."""
    items = vessel.draught.nodes("FrequencyDependentAddedMassAndDamping")
    if not items:
        raise vessel.draught.wrong("FrequencyDependentAddedMassAndDamping", "nothing", "matrices")
    value = [item.number("AMDPeriodOrFrequency") for item in items]
    added_mass, damping = (
        np.array([item.numbers(_find_key(item, first), (6, 6)) for item in items])
        for first in ("AddedMassMatrixX", "DampingX")
    )
    sign = np.outer(vessel.conventions.sign, vessel.conventions.sign)
    omega = assembly.frequencies(vessel.draught.path, value, vessel.conventions.abscissa)
    units = vessel.units
    return omega, added_mass * sign * units.inertia, damping * sign * units.stiffness


def _find_key(node: _Node, first: str) -> str:
    """Key of a matrix, which names its columns."""
    key = next((key for key in node.content if key.split(",")[0].strip() == first), None)
    if key is None:
        raise node.wrong(first, "nothing", "a matrix")
    return str(key)


def _first_order(vessel: _Vessel) -> tuple[Real, Real, Complex]:
    """Frequencies (nw,), headings (nh,) and loads (nw, nh, 6) about the origin of the matrices."""
    node = vessel.draught.node("LoadRAOs")
    waves, heading, table = _read_by_direction(vessel, node)
    size, phase = _sizes_and_phases(*table)
    scale = vessel.units.loads(1) * vessel.conventions.sign
    loads = assembly.polar(size, vessel.conventions.lag(phase, 1)) * scale
    origin, phase_origin = _read_origins(node, vessel.units)
    loads = _loads_at(vessel, loads, waves, heading, phase_origin - origin)
    heading, loads = _mirror_headings(vessel, heading, loads)
    loads = _loads_at(vessel, loads, waves, heading, origin)
    return waves, heading, loads @ velocity_transfer((origin - vessel.reference)[None])


def _read_symmetry(vessel: _Vessel, given: Given) -> bool | None:
    """Symmetry that the user or the file gives; if neither does, it is determined from the data."""
    is_symmetric = "xz" in vessel.symmetry or vessel.symmetry == "circular"
    return (
        True
        if is_symmetric and given.port_starboard_symmetric is None
        else given.port_starboard_symmetric
    )


def _mirror_headings(vessel: _Vessel, heading: Real, loads: Any) -> tuple[Real, Any]:
    """Loads with the headings that fore-aft symmetry gives."""
    if "yz" not in vessel.symmetry:
        return heading, loads
    return assembly.with_fore_aft_headings(heading, loads)


def _loads_at(vessel: _Vessel, loads: Complex, omega: Real, heading: Real, point: Real) -> Complex:
    return assembly.at_origin(loads, omega, heading, point, vessel.depth, vessel.gravity)


def _read_by_direction(vessel: _Vessel, node: _Node) -> tuple[Real, Real, tuple[list[str], Real]]:
    """Frequencies, headings, and columns with rows (nw, nh, columns)."""
    items = node.nodes("RAOs")
    tables = [item.table("RAOPeriodOrFrequency") for item in items]
    columns, first = tables[0]
    if len(first) == 0:
        raise items[0].wrong("RAOPeriodOrFrequency", "an empty table", "rows")
    _require_motions(items[0], columns[1:])  # the others must have the same
    for item, (names, rows) in zip(items, tables, strict=True):
        if names != columns or rows.shape != first.shape or (rows[:, 0] != first[:, 0]).any():
            raise item.wrong(
                "RAOPeriodOrFrequency", "other columns or waves", "those of the first direction"
            )
    heading = np.array([item.number("RAODirection") for item in items])
    omega = assembly.frequencies(node.path, first[:, 0], vessel.conventions.abscissa)
    stack = np.stack([rows for _, rows in tables], axis=1)
    return omega, np.radians(heading), (columns, stack)


def _require_motions(node: _Node, columns: list[str]) -> None:
    """Refuse columns that are no amplitude or phase of a motion: they would count as zero."""
    column_names = [f"RAO{dof}{what}" for dof in _DOFS for what in ("Amp", "Phase")]
    unknown = [name for name in columns if name not in column_names]
    if unknown:
        raise node.wrong("", f"a column {value_text(unknown[0])}", "RAOSurgeAmp to RAOYawPhase")


def _sizes_and_phases(columns: list[str], rows: Real) -> tuple[Real, Real]:
    """Loads (..., 6) each; zero for a DOF without columns."""
    size, phase = np.zeros((2, *rows.shape[:-1], 6))
    for dof, name in enumerate(_DOFS):
        for out, what in ((size, "Amp"), (phase, "Phase")):
            if f"RAO{name}{what}" in columns:
                out[..., dof] = rows[..., columns.index(f"RAO{name}{what}")]
    return size, phase


def _read_origins(node: _Node, units: _Units) -> tuple[Real, Real]:
    """References of loads and of phases [m], in vessel axes; ~ means the former."""
    origin = units.length * node.numbers("RAOOrigin", (3,))
    words = node.content.get("PhaseOrigin", ["~"] * 3)
    if isinstance(words, list) and len(words) == 3 and set(words) == {"~"}:
        return origin, origin
    return origin, units.length * node.numbers("PhaseOrigin", (3,))


def _matching_rows(draught: _Node, omega: Real, waves: Real) -> list[int]:
    """Row of loads for each matrix; any row for the limits."""
    finite = np.isfinite(omega) & (omega > 0)
    near = np.abs(waves - np.where(finite, omega, 0.0)[:, None])
    rows = near.argmin(axis=1)
    fits = near[np.arange(omega.size), rows] <= _FREQUENCY_RTOL * omega
    if not fits[finite].all() or finite.sum() != waves.size:
        raise draught.wrong(
            "FrequencyDependentAddedMassAndDamping",
            f"{finite.sum()} finite frequencies",
            f"the {waves.size} of the load RAOs",
        )
    return [int(row) for row in rows]


def _mean_drift(vessel: _Vessel, waves: Real, heading: Real, rows: list[int]) -> Real | None:
    """Newman's diagonal (nw, nh, 6); the phase gives the sign only."""
    if "WaveDrift" not in vessel.draught.content:
        return None
    node = vessel.draught.node("WaveDrift")
    if not node.content.get("RAOs"):
        return None
    own_waves, directions, table = _read_by_direction(vessel, node)
    size, phase = _sizes_and_phases(*table)
    scale = vessel.units.loads(2) * vessel.conventions.sign
    drift = size * np.cos(phase * vessel.conventions.phase_unit) * scale
    own_heading, drift = _mirror_headings(vessel, directions, drift)
    if not np.array_equal(own_waves, waves) or not np.array_equal(own_heading, heading):
        raise node.wrong("RAOs", "other waves", "the frequencies and directions of the load RAOs")
    origin, _ = _read_origins(node, vessel.units)
    return np.asarray(drift @ velocity_transfer((origin - vessel.reference)[None]))[rows]


def _second_order(vessel: _Vessel) -> dict[str, Any]:
    """Full transfer functions, if there are rows."""
    difference = _read_pairs(vessel, "WaveDrift", difference=True)
    total = _read_pairs(vessel, "SumFrequencyQTFs", difference=False)
    return assembly.quadratic(vessel.draught.path, 6, difference, total)


def _read_pairs(vessel: _Vessel, key: str, difference: bool) -> assembly.Pairs | None:
    """Rows of one table about the origin of the matrices."""
    node = vessel.draught.node(key) if key in vessel.draught.content else None
    if node is None or not any("," in line for line in node.content):
        return None
    columns, rows = node.table(_PAIR[0])
    if tuple(columns[:4]) != _PAIR:
        raise node.wrong(columns[0], f"the columns {', '.join(columns[:4])}", ", ".join(_PAIR))
    _require_motions(node, columns[4:])
    if len(rows) == 0:
        return None
    size, phase = _sizes_and_phases(columns, rows)
    lag = vessel.conventions.lag(phase, 0 if difference else 2)
    origin, phase_origin = _read_origins(node, vessel.units)
    loads = assembly.polar(size, lag) * vessel.units.loads(2) * vessel.conventions.sign
    loads = loads @ velocity_transfer((origin - vessel.reference)[None])
    pairs = assembly.Pairs(
        np.repeat(
            assembly.frequencies(node.path, rows[:, :2], vessel.conventions.abscissa), 6, axis=0
        ),
        np.repeat(np.radians(rows[:, 2:4]), 6, axis=0),
        np.tile(np.arange(6), len(rows)),
        loads.ravel(),
    )
    return pairs.at_origin(phase_origin, vessel.depth, vessel.gravity, difference)


def _read_stiffness(vessel: _Vessel) -> Real:
    """Stiffness (6, 6) from heave, roll and pitch."""
    key = _find_key(vessel.draught, "HydrostaticStiffnessz")
    sign = vessel.conventions.sign[_HEAVE_ROLL_PITCH]
    stiffness = np.zeros((6, 6))
    part = vessel.draught.numbers(key, (3, 3)) * np.outer(sign, sign)
    stiffness[np.ix_(_HEAVE_ROLL_PITCH, _HEAVE_ROLL_PITCH)] = part
    return np.asarray(stiffness * vessel.units.stiffness)


def _read_inertia(draught: _Node, offset: Real, units: _Units) -> Real:
    """Inertia (6, 6) about a point from which the centre of gravity is at ``offset``."""
    mass = draught.number("Mass")
    mass_matrix = np.diag([mass, mass, mass, 0.0, 0.0, 0.0])
    mass_matrix[3:, 3:] = draught.numbers(_find_key(draught, "MomentOfInertiaTensorX"), (3, 3))
    move = velocity_transfer(offset[None])
    return np.asarray(move.T @ (mass_matrix * units.inertia) @ move)
