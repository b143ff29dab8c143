"""Documents on the content of a database and on its checks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from hydrosim.database.checks import Finding
from hydrosim.database.database import HydroDatabase, Real
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import List, Node, Outcome, Row, Sentence, Table, Verdict
from hydrosim.water.radiation import retardation

_OPTIONAL = (
    "hydrostatic_stiffness",
    "inertia_matrix",
    "volume",
    "centre_of_buoyancy",
    "centre_of_gravity",
    "added_mass_zero",
    "added_mass_infinite",
    "froude_krylov",
    "mean_drift",
    "mean_drift_held",
    "qtf_difference",
    "qtf_sum",
)


def contents(db: HydroDatabase, form: str) -> Document:
    """Document with a table of what the database holds: water, frequencies, headings, bodies
    and optional arrays. ``form`` is the name of the format of its file."""
    rows = (
        ("format", form),
        *_water_entries(db),
        *_range_entries(db),
        *_body_entries(db),
        *_other_entries(db),
    )
    return Document(db.attributes.get("title", db.source), [Table(("", ""), list(rows))])


def verdicts(db: HydroDatabase, findings: Sequence[Finding]) -> Document:
    """A row for each check, and remedies for checks that did not pass."""
    nodes: list[Node] = [_verdict_of(finding) for finding in findings if not finding.has_passed]
    if not nodes:
        nodes.append(Verdict(Outcome.GOOD, "All checks are passed."))
    head = ("check", "found", "at most", "refused above", "")
    nodes.append(Table(head, [_finding_cells(finding) for finding in findings]))
    left = [finding for finding in findings if finding.left_out]
    if left:
        reasons = [
            f"{finding.name}: {finding.advice.removeprefix('left out: ')}" for finding in left
        ]
        nodes.append(List(reasons, "Left out:"))
    if not any(finding.is_refused for finding in findings):
        nodes.append(Sentence("{}", [memory(db)]))
    return Document(db.attributes.get("title", db.source), nodes)


def _verdict_of(finding: Finding) -> Verdict:
    outcome = Outcome.BAD if finding.is_refused else Outcome.WARNING
    return Verdict(outcome, "{}: {}", [finding.name, finding.advice])


def _finding_cells(finding: Finding) -> Row:
    figure = "" if finding.left_out else f"{finding.figure:.2g}"
    refusal = "" if np.isinf(finding.refusal) else f"{finding.refusal:g}"
    return [finding.name, figure, f"{finding.limit:g}", refusal, _verdict_text(finding)]


def memory(db: HydroDatabase) -> str:
    """Resolved length of radiation memory, of all bodies together."""
    functions = retardation(db.frequency, db.added_mass, db.radiation_damping)
    return f"retardation functions to {functions.time[-1]:g} s: {functions.report}"


def _verdict_text(finding: Finding) -> str:
    if finding.left_out:
        return "left out"
    if finding.is_refused:
        return "refused"
    return "passed" if finding.has_passed else "look closer"


def _water_entries(db: HydroDatabase) -> Iterator[tuple[str, str]]:
    depth = "deep water" if np.isinf(db.water_depth) else f"{db.water_depth:g} m"
    yield "water", f"{depth}, {db.water_density:g} kg/m³, gravity {db.gravity:g} m/s²"


def _range_entries(db: HydroDatabase) -> Iterator[tuple[str, str]]:
    yield (
        "frequencies",
        f"{_range_text(db.frequency, 'rad/s')}; periods {_periods_text(db.frequency)}",
    )
    loads = _range_text(np.degrees(db.heading), "deg") if db.heading.size else "none, no wave loads"
    yield "headings", loads
    if db.qtf_frequency is not None and db.qtf_heading is not None:
        pairs = f"{len(db.qtf_heading)} pairs of headings"
        yield "QTF", f"{_range_text(db.qtf_frequency, 'rad/s')}; {pairs}"
    symmetry = "symmetric about y = 0" if db.port_starboard_symmetric else "none"
    yield "symmetry", symmetry


def _body_entries(db: HydroDatabase) -> Iterator[tuple[str, str]]:
    yield "bodies", str(db.bodies)
    quantities = {"volume": "m³", "centre_of_buoyancy": "m", "centre_of_gravity": "m"}
    for body in range(db.bodies):
        prefix = f"body {body + 1}, " if db.bodies > 1 else ""
        for name, unit in {**quantities, "reference_point": "m"}.items():
            value = getattr(db, name)
            if value is not None:
                figures = ", ".join(f"{x:.6g}" for x in np.atleast_1d(value[body]))
                yield prefix + name.replace("_", " "), f"{figures} {unit}"
        yield from ((prefix + key, value) for key, value in _metacentre_entries(db, body))


def _metacentre_entries(db: HydroDatabase, body: int) -> Iterator[tuple[str, str]]:
    if db.hydrostatic_stiffness is None or db.volume is None:
        return
    weight = db.water_density * db.gravity * db.volume[body]
    roll, pitch = np.diag(db.hydrostatic_stiffness)[6 * body + 3 :][:2] / weight
    yield "metacentric heights", f"transverse {roll:.4g}, longitudinal {pitch:.4g} m"


def _other_entries(db: HydroDatabase) -> Iterator[tuple[str, str]]:
    lacking = [name.replace("_", " ") for name in _OPTIONAL if getattr(db, name) is None]
    yield "lacks", ", ".join(lacking) or "nothing"
    attributes = ("solver", "recipe", "assumed", "changed", "accepted")
    yield from ((k, db.attributes[k]) for k in attributes if k in db.attributes)
    yield "checksum", db.checksum[:16]


def _range_text(values: Real, unit: str) -> str:
    return f"{values.size}, from {values[0]:.4g} to {values[-1]:.4g} {unit}"


def _periods_text(frequency: Real) -> str:
    return f"{2 * np.pi / frequency[-1]:.3g} to {2 * np.pi / frequency[0]:.3g} s"
