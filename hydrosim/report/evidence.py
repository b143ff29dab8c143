"""Lines of evidence: what was held against what, and the features of scenes that they are about."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrosim import elements
from hydrosim import scene as scenes
from hydrosim.files.document_layout import digits_of
from hydrosim.files.document_nodes import List, Nodes, Row, Sentence, Table
from hydrosim.scene.damping import QuadraticDamping, ViscousRoll
from hydrosim.scene.links import Link, Spring
from hydrosim.scene.loads import AppliedForce

if TYPE_CHECKING:
    import xarray as xr

# Features of scenes that evidence is about.


class Feature(StrEnum):
    """A part of a scene, or of the program, that lines of evidence are about."""

    STEPS = "steps of a fixed size"
    ADAPTIVE = "steps that adapt"
    IMPLICIT = "implicit steps"
    ROTATIONS = "rotations of any size"
    RESTART = "start from another run"
    EXACT = "exact propagation"
    PLANE = "solution in the plane of symmetry"
    STIFFNESS = "hydrostatic stiffness of a database"
    HULL = "buoyancy of a closed hull"
    RADIATION = "memory of radiated waves (Cummins)"
    DRAUGHTS = "databases over the draught"
    COUPLED = "bodies coupled through the water"
    WAVES = "first-order wave loads"
    SEA = "random seas"
    SPREADING = "directional seas"
    MEAN_DRIFT = "mean drift"
    NEWMAN = "slow drift after Newman"
    QTF = "slow drift from QTFs"
    SUM = "loads at sums of frequencies"
    FOLLOWING = "wave loads that follow heading and position"
    FENDERS = "fenders"
    LANDINGS = "landings"
    GUIDES = "walls of landings"
    STICK_SLIP = "stick-slip friction"
    COULOMB = "rigid friction"
    SLOPE = "friction slope"
    SPRINGS = "springs and lines"
    CATENARIES = "catenaries"
    STRUTS = "struts, torsion springs and power take-offs"
    WINCHES = "winches and compensators"
    BUSHINGS = "bushings"
    MOORINGS = "linear moorings"
    APPLIED = "applied forces"
    DAMPING = "linear damping"
    DRAG = "quadratic damping"
    ROLL = "viscous roll damping"
    CURRENT = "current"
    WIND = "wind"
    WEIGHT = "weight as a force"
    TANKS = "tanks"
    PUMPS = "pumps"
    TRIGGERS = "elements that act for a time"
    JOINTS = "joints"
    DRIVES = "prescribed motion"
    EXTREMES = "extremes of random seas"
    LINEAR = "linear analysis"
    LIMITS = "limits of operation"
    RECIPES = "databases computed from recipes"
    HULLS = "databases that come with the program"


def features_of(
    scene: scenes.Scene, attributes: Mapping[str, object] | None = None
) -> set[Feature]:
    """Features that a scene uses. ``attributes`` of its run tell how it was solved."""
    used = {feature for feature, is_used in OF_SCENES.items() if is_used(scene)}
    told = attributes or {}
    return used | {feature for feature, is_used in OF_RUNS.items() if is_used(told)}


def _methods(*methods: scenes.Method) -> Callable[[scenes.Scene], bool]:
    return lambda scene: scene.solver.method in methods


def _elements(*classes: type[scenes.ForceElement]) -> Callable[[scenes.Scene], bool]:
    return lambda scene: any(isinstance(element, classes) for element in scene.forces.values())


def _has_friction_law(law: type) -> Callable[[scenes.Scene], bool]:
    return lambda scene: any(isinstance(contact.friction, law) for contact in _all_contacts(scene))


def _all_contacts(scene: scenes.Scene) -> Iterator[elements.Contact]:
    return (element for element in scene.forces.values() if isinstance(element, elements.Contact))


def _any_body_is(is_so: Callable[[scenes.Body], bool]) -> Callable[[scenes.Scene], bool]:
    return lambda scene: any(is_so(body) for body in scene.bodies)


def _second_order(*orders: scenes.SecondOrder) -> Callable[[scenes.Scene], bool]:
    return _is_so_in_waves(lambda body: body.wave_forces.second_order in orders)


def _is_so_in_waves(is_so: Callable[[scenes.Body], bool]) -> Callable[[scenes.Scene], bool]:
    return lambda scene: any(_is_wet(b) and is_so(b) for b in scene.bodies if _wave_trains(scene))


def _is_wet(body: scenes.Body) -> bool:
    """True if the body has a database."""
    return body.hydrodynamics is not None and not isinstance(
        body.hydrodynamics, scenes.Coefficients
    )


def _has_memory(body: scenes.Body) -> bool:
    constant = isinstance(body.radiation, scenes.ConstantRadiation)
    return _is_wet(body) and not constant and not isinstance(body.radiation, scenes.NoRadiation)


def _has_following_loads(body: scenes.Body) -> bool:
    places = (body.wave_forces.headings, body.wave_forces.position)
    return any(place in (scenes.Place.SLOW, scenes.Place.INSTANTANEOUS) for place in places)


def _wave_trains(scene: scenes.Scene) -> tuple[scenes.WaveTrain, ...]:
    return scene.environment.waves


def _is_random(scene: scenes.Scene) -> bool:
    given = scenes.RegularWave | scenes.GivenComponents
    gusty = scene.environment.gusts is not None
    return gusty or any(not isinstance(w.spectrum, given) for w in _wave_trains(scene))


OF_SCENES: Mapping[Feature, Callable[[scenes.Scene], bool]] = {
    Feature.STEPS: _methods(scenes.Method.RK2, scenes.Method.HEUN, scenes.Method.RK4),
    Feature.ADAPTIVE: _methods(scenes.Method.DOPRI5, scenes.Method.AUTOMATIC),
    Feature.IMPLICIT: _methods(scenes.Method.ESDIRK4),
    Feature.ROTATIONS: lambda scene: scene.solver.kinematics == scenes.Kinematics.EXACT,
    Feature.RESTART: lambda scene: scene.initial is not None,
    Feature.STIFFNESS: _any_body_is(lambda body: _is_wet(body) and body.hydrostatics is None),
    Feature.HULL: _any_body_is(lambda body: body.hydrostatics is not None),
    Feature.RADIATION: _any_body_is(_has_memory),
    Feature.DRAUGHTS: _any_body_is(lambda body: isinstance(body.hydrodynamics, scenes.Family)),
    Feature.COUPLED: _any_body_is(lambda body: body.database_body > 1),
    Feature.WAVES: _is_so_in_waves(lambda body: body.wave_forces.first_order),
    Feature.SEA: _is_random,
    Feature.SPREADING: lambda scene: any(
        train.spreading is not None for train in _wave_trains(scene)
    ),
    Feature.MEAN_DRIFT: _second_order(scenes.SecondOrder.MEAN_DRIFT),
    Feature.NEWMAN: _second_order(scenes.SecondOrder.NEWMAN, scenes.SecondOrder.NEWMAN_SQUARE_ROOT),
    Feature.QTF: _second_order(scenes.SecondOrder.QTF),
    Feature.SUM: _is_so_in_waves(lambda body: body.wave_forces.sum_frequency),
    Feature.FOLLOWING: _is_so_in_waves(_has_following_loads),
    Feature.FENDERS: _elements(elements.Fender),
    Feature.LANDINGS: _elements(elements.Landing),
    Feature.GUIDES: lambda scene: any(
        isinstance(element, elements.Landing) and element.wall is not None
        for element in scene.forces.values()
    ),
    Feature.STICK_SLIP: _has_friction_law(elements.StickSlip),
    Feature.COULOMB: _has_friction_law(elements.Coulomb),
    Feature.SLOPE: _has_friction_law(elements.FrictionSlope),
    Feature.SPRINGS: _elements(Spring),
    Feature.CATENARIES: _elements(elements.Catenary),
    Feature.STRUTS: lambda scene: any(
        isinstance(e, Link) and not isinstance(e, Spring | elements.Compensator)
        for e in scene.forces.values()
    ),
    Feature.WINCHES: _elements(elements.Winch, elements.Compensator),
    Feature.BUSHINGS: _elements(elements.Bushing),
    Feature.MOORINGS: _elements(elements.LinearMooring),
    Feature.APPLIED: _elements(AppliedForce),
    Feature.DAMPING: _elements(elements.LinearDamping),
    Feature.DRAG: _elements(QuadraticDamping),
    Feature.ROLL: _elements(ViscousRoll),
    Feature.CURRENT: lambda scene: (
        scene.environment.current.top_speed != 0.0 or _elements(elements.CurrentLoad)(scene)
    ),
    Feature.WIND: _elements(elements.WindLoad),
    Feature.WEIGHT: _any_body_is(lambda body: body.weight == scenes.Weight.CARRIED),
    Feature.TANKS: _any_body_is(lambda body: bool(body.tanks)),
    Feature.PUMPS: _any_body_is(lambda body: bool(body.pumps)),
    Feature.TRIGGERS: lambda scene: any(element.active for element in scene.forces.values()),
    Feature.JOINTS: lambda scene: bool(scene.joints),
    Feature.DRIVES: _elements(elements.Drive),
    Feature.EXTREMES: _is_random,
}
"""Features of scenes, and whether a scene uses them."""

OF_RUNS: Mapping[Feature, Callable[[Mapping[str, object]], bool]] = {
    Feature.EXACT: lambda told: str(told.get("solver_linear", "")).startswith("propagated exactly"),
    Feature.PLANE: lambda told: str(told.get("solver_symmetry", "")).startswith("in the plane"),
}
"""Features of solutions, and whether the attributes of a run tell them."""


# Lines of evidence, which ``python -m benchmarks --keep evidence`` writes from tests.

FILE = Path(__file__).with_name("evidence.json")


class Kind(StrEnum):
    """What a line holds hydrosim against, in the order of what it is worth."""

    EXPERIMENT = "experiment"
    PROGRAM = "other program"
    CLOSED_FORM = "closed form"
    INDEPENDENT = "independent code"
    SELF = "hydrosim otherwise"


@dataclass(frozen=True)
class EvidenceLine:
    """A ``claim`` held ``against`` a reference of a ``kind``.

    ``figure`` is the largest error that the ``test`` measured at the ``commit``, ``limit`` the
    bound that it asserts. Both are relative unless the claim names a unit. ``others`` is what
    another program has there. The line is about scenes that use all its ``features``.
    """

    claim: str
    against: str
    kind: Kind
    figure: float
    limit: float
    features: tuple[Feature, ...]
    test: str
    commit: str
    others: str = ""

    @classmethod
    def read(cls, data: Mapping[str, Any]) -> EvidenceLine:
        """A line as it is stored."""
        features = tuple(Feature[name] for name in data["features"])
        return cls(**{**data, "kind": Kind(data["kind"]), "features": features})

    def as_dict(self) -> dict[str, Any]:
        """The line as it is stored, of plain texts and numbers: names of features, figures of three
        digits."""
        return {
            **asdict(self),
            "kind": self.kind.value,
            "figure": float(f"{self.figure:.3g}"),
            "limit": float(self.limit),
            "features": [feature.name for feature in self.features],
        }


def known_lines() -> tuple[EvidenceLine, ...]:
    """All lines, by kind."""
    return tuple(EvidenceLine.read(data) for data in json.loads(FILE.read_text("utf-8")))


def lines_about(used: Collection[Feature]) -> list[EvidenceLine]:
    """Lines whose features are all ``used``."""
    return [line for line in known_lines() if set(line.features) <= set(used)]


# Evidence about what the scene of a run uses, in its report.

EVIDENCE_COLUMNS = ("claim", "against", "kind", "error", "limit")
EVIDENCE_NOTE = (
    "These comparisons are about parts of this scene. They were made when the program was tested,"
    " with scenes of their own. An error is the largest that a test found, a limit the bound that"
    " it asserts. Both are relative unless the claim names a unit."
)
UNKNOWN_CASE_NOTE = (
    "The result does not hold its case, or it cannot be read again, so the evidence for what it"
    " uses cannot be named."
)


def evidence_nodes(run: xr.Dataset, scene: scenes.Scene | None) -> Nodes:
    """Lines of evidence about the features of the ``scene`` of a run, and features without one."""
    if scene is None:
        yield Sentence(UNKNOWN_CASE_NOTE)
        return
    used = features_of(scene, {str(name): value for name, value in run.attrs.items()})
    lines = lines_about(used)
    if lines:
        yield Sentence(EVIDENCE_NOTE)
        yield Table(EVIDENCE_COLUMNS, [_row(line) for line in lines])
    if bare := without_line(used, lines):
        yield Sentence("No line of evidence is about these parts of the scene by themselves:")
        yield List(bare)


def without_line(used: Collection[Feature], lines: Sequence[EvidenceLine]) -> list[str]:
    """Features that are ``used`` and that none of the ``lines`` is about."""
    covered = {feature for line in lines for feature in line.features}
    return [feature.value for feature in Feature if feature in used and feature not in covered]


def _row(line: EvidenceLine) -> Row:
    figures = [digits_of(line.figure, 2), digits_of(line.limit, 3)]
    return [line.claim, line.against, line.kind.value, *figures]
