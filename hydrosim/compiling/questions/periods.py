"""Natural periods of hulls for each degree of freedom by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.database.database import require_array
from hydrosim.dofs import DOFS

if TYPE_CHECKING:
    from hydrosim.compiling.questions.doubt import About
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Body


def natural_periods(about: About, i: int, body: Body, db: HydroDatabase) -> dict[str, float]:
    """Natural periods [s] of body ``i`` for each degree of freedom by itself, by name."""
    model = about.model
    each = model.elements.linear_moorings
    moored = [e["stiffness"] for e in each if e["body"] == i]
    stiffness = np.diag(sum(moored, require_array(db, "hydrostatic_stiffness")))
    added = np.diag(model.added_mass)[6 * i : 6 * i + 6]
    inertia = np.array([body.mass] * 3 + list(np.diag(body.inertia))) + added
    return {
        name: float(2.0 * np.pi * np.sqrt(inertia[dof] / stiffness[dof]))
        for dof, name in enumerate(DOFS)
        if name in body.dofs and stiffness[dof] > 0.0
    }
