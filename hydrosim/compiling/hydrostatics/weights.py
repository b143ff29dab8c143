"""Bodies that carry their own weight, and the elements that can carry them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hydrosim.compiling.hydrostatics.tank_checks import check_lightship
from hydrosim.database.database import HydroDatabase, require_array
from hydrosim.database.hull import integrals
from hydrosim.errors import InputError
from hydrosim.forces.layout import HYDROSTATIC, WEIGHT
from hydrosim.forces.weight import Weights
from hydrosim.scene import Body, Scene, Weight


def weights_of(scene: Scene, alone: Mapping[str, HydroDatabase], rows: Sequence[str]) -> Weights:
    """Constants of the weights. ``alone`` are the databases of wet bodies, ``rows`` the names of
    the rows of forces. Raises InputError if nothing can carry a body."""
    carried = [i for i, body in enumerate(scene.bodies) if body.weight == Weight.CARRIED]
    _check_supports(scene, alone)
    for body in scene.bodies:
        if body.hydrostatics is not None:
            whole = scene.environment.water_density * integrals(body.hydrostatics.corners).volume
            check_lightship(body, whole, sinks=True)
        elif body.name in alone:
            check_lightship(body, _buoyancy(body, alone) / scene.environment.gravity)
    return Weights(
        np.array(carried, dtype=np.int64),
        np.array([_buoyancy(scene.bodies[i], alone) for i in carried], dtype=float),
        rows.index(WEIGHT) if carried else HYDROSTATIC,
        scene.environment.gravity,
    )


def _buoyancy(body: Body, alone: Mapping[str, HydroDatabase]) -> float:
    """Buoyancy rho g V of a body at rest [N]; 0 for a dry body, and for one whose hull gives it."""
    if body.name not in alone or body.hydrostatics is not None:
        return 0.0
    db = alone[body.name]
    return float(db.water_density * db.gravity * require_array(db, "volume")[0])


def _check_supports(scene: Scene, alone: Mapping[str, HydroDatabase]) -> None:
    supported = _supported_bodies(scene, alone)
    for body in scene.bodies:
        if body.weight == Weight.CARRIED and body.name not in supported:
            weight = body.mass * scene.environment.gravity
            raise InputError(
                f"bodies.{body.name}.weight: found carried, but nothing in the case can carry its"
                f" {weight:.4g} N. Add hydrodynamics with stiffness in heave, or an applied force,"
                " or connect it by a joint, contact, spring or mooring to the earth or to a body"
                " that is carried. Otherwise lock heave; or set weight: balanced, a constant force"
                " equal to the weight."
            )


def _supported_bodies(scene: Scene, alone: Mapping[str, HydroDatabase]) -> set[str]:
    """Names of the bodies that float, that are held, or that hang on or rest on such bodies."""
    found = {body.name for body in scene.bodies if _stands(body, alone)}
    links = list(_links(scene))
    for _ in scene.bodies:  # chains of bodies are at most this long
        found |= {a for a, b in links if b is None or b in found}
    return found


def _stands(body: Body, alone: Mapping[str, HydroDatabase]) -> bool:
    if "heave" not in body.dofs or body.hydrostatics is not None:
        return True
    if body.name not in alone:
        return False
    return bool(require_array(alone[body.name], "hydrostatic_stiffness")[2, 2] > 0.0)


def _links(scene: Scene) -> Iterator[tuple[str, str | None]]:
    """Pairs of bodies: the second may carry the first; None is the earth."""
    for joint in scene.joints.values():
        yield joint.body, joint.to
        if joint.to is not None:
            yield joint.to, joint.body
    for element in scene.forces.values():
        if element.supports_weight():
            others = [name for _, name in element.connected_bodies()] or [None]
            for other in others:
                yield element.body, other
                if other is not None:
                    yield other, element.body
