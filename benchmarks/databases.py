"""What is refused and what is doubted in which database, and why?

Of the databases that are shipped and of other programs' files, those that the tests read; each as a
whole, and in what three scenes use of it: a decay in heave in calm water, heave in waves of first
order, and all degrees of freedom in waves, with mean drift where there is any.
"""

from __future__ import annotations

from pathlib import Path

from benchmarks.report import ROOT, Answer, Row
from hydrosim.database import CheckSubject, Finding, HydroDatabase, Use, check
from hydrosim.database.load import read
from hydrosim.errors import InputError
from hydrosim.scene.given import Given
from tests.validation_data import unpacked

CALM = frozenset({CheckSubject.ORDER, CheckSubject.RADIATION, CheckSubject.STIFFNESS})
OTHERS = (
    "h851_independent.nc",
    "hemisphere/hemisphere.1",
    "sphere/sphere.h5",
    "sphere/wamit/sphere.1",
    "volturnus/volturnus.1",
)
NAMED = ("hydro_db", "wamit", "sphere")  # folders that tell files of one name apart
GIVEN = {"hemisphere.1": Given(water_density=1000.0)}


def answer() -> Answer:
    """A row for each database and check that does not pass."""
    files = [*sorted((ROOT / "hydro_db").glob("*.nc")), *map(unpacked, OTHERS)]
    rows = [row for path in files for row in _rows(path)]
    remarks = [
        "Waves are those of a sea that has 99 % of its energy below 2 rad/s; a finding names the"
        " frequency, the pair and the size, see `hydrosim db check FILE`.",
    ]
    return Answer({"Findings by database and use": rows}, remarks)


def _rows(path: Path) -> list[Row]:
    """A row for each check that does not pass, with its figure in each use; "-" where it passes or
    is not made."""
    name = f"{path.parent.name}/{path.name}" if path.parent.name in NAMED else path.name
    try:
        db = read(path, GIVEN.get(path.name, Given()))
    except InputError as error:
        print(f"{name} is not read: {str(error).removeprefix(f'{path}: ')}")
        return []
    found = {use_name: check(db, use) for use_name, use in _uses(db)}
    failed = [f.name for f in found["everything"] if not f.has_passed]
    return [
        {"file": name, "check": check_name}
        | {use_name: _cell(check_name, findings) for use_name, findings in found.items()}
        for check_name in failed or ["(nothing)"]
    ]


def _cell(name: str, findings: list[Finding]) -> str:
    for finding in findings:
        if finding.name == name and not finding.has_passed:
            verdict = "refused, " if finding.is_refused else ""
            return f"{verdict}{finding.figure:.2g} {finding.place.split(' (')[0]}".strip()
    return "-"


def _uses(db: HydroDatabase) -> list[tuple[str, Use]]:
    heave = tuple(range(2, 6 * db.bodies, 6))
    drift = {CheckSubject.DRIFT} if db.mean_drift is not None else set()
    return [
        ("everything", Use()),
        ("calm, heave", Use(CALM, heave)),
        ("waves, heave", Use(CALM | {CheckSubject.LOADS}, heave, 2.0)),
        ("waves, all that moves", Use(CALM | {CheckSubject.LOADS} | drift, highest=2.0)),
    ]
