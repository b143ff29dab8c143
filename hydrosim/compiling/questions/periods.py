"""Natural periods of hulls for each degree of freedom by itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.database.database import require_array
from hydrosim.dofs import DOFS

if TYPE_CHECKING:
    from hydrosim.compiling.questions.query import SceneContext
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Body


def natural_periods(about: SceneContext, i: int, body: Body, db: HydroDatabase) -> dict[str, float]:
    """Natural periods [s] of body ``i`` for each degree of freedom by itself, by name."""
    return {name: period for name, _, period in natural_inertias(about, i, body, db)}


def natural_inertias(
    about: SceneContext, i: int, body: Body, db: HydroDatabase
) -> Iterator[tuple[str, float, float]]:
    """Name, inertia with added mass [kg, kg m^2] and natural period [s] of each degree of freedom
    of body ``i`` that stiffness restores."""
    model = about.model
    each = model.elements.linear_moorings
    moored = [e["stiffness"] for e in each if e["body"] == i]
    stiffness = np.diag(sum(moored, require_array(db, "hydrostatic_stiffness")))
    added = np.diag(model.added_mass)[6 * i : 6 * i + 6]
    inertia = np.array([body.mass] * 3 + list(np.diag(body.inertia))) + added
    for dof, name in enumerate(DOFS):
        if name in body.dofs and stiffness[dof] > 0.0:
            period = float(2.0 * np.pi * np.sqrt(inertia[dof] / stiffness[dof]))
            yield name, float(inertia[dof]), period
