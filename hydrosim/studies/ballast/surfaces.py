"""Loss of stability of bodies by free surfaces: at rest, and at a heel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.hydrostatics.liquids import cut_tanks
from hydrosim.forces.weight import add_weight
from hydrosim.rigid.kinematics import place_bodies
from hydrosim.rigid.tree import NO_TREE
from hydrosim.stepping.dynamics import new_work, update_contents
from hydrosim.tanks.mesh import section
from hydrosim.tanks.shapes import triangles

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

XX, YY = 0, 2  # of second moments xx, xy, yy


class FreeSurfaces:
    """Free surfaces of a compiled scene with ``volume`` (nt,) [m^3] in the changing tanks and its
    bodies at a ``position`` (nb, 6)."""

    def __init__(self, compiled: Compiled, volume: np.ndarray, position: np.ndarray) -> None:
        self.compiled = compiled
        self.model = compiled.model
        self.work = new_work(compiled.model)
        self.position = position
        self.y = compiled.first_state().y.copy()
        first = self.model.tanks.state
        self.y[first : first + volume.size] = volume

    def slopes(self, b: int) -> np.ndarray:
        """Moments in heel and trim (2,) per angle and g of body ``b`` at its position [kg m]:
        density times the second moments of the surfaces."""
        from scipy.spatial.transform import Rotation  # slow to load, and few scenes have tanks

        self._place(b, *self.position[b, 3:5])
        found = self.work.contents.surface[b, [YY, XX]].copy()
        body = self.compiled.scene.bodies[b]
        turn = Rotation.from_euler("YX", self.position[b, [4, 3]])
        for k, cut in enumerate(cut_tanks(self.compiled.scene)):
            if cut.body == b:
                corners = triangles(cut.shape) - np.asarray(body.centre_of_gravity)
                turned = turn.apply(corners.reshape(-1, 3)).reshape(corners.shape)
                area, x, y, xx, _, yy = section(turned, float(self.work.contents.height[k]))
                if area > 0.0:
                    spread = np.array([yy - y * y / area, xx - x * x / area])
                    found += cut.tank.density * cut.shape.permeability * spread
        return found

    def lever(self, b: int, heel: float) -> float:
        """Moment in heel divided by g of body ``b`` at this heel and its trim [kg m]."""
        self._place(b, heel, float(self.position[b, 4]))
        contents = self.work.contents
        with_surfaces = self._moment(b)
        contents.shift[:] = 0.0
        contents.surface[:] = 0.0
        return (with_surfaces - self._moment(b)) / self.model.weights.gravity

    def _place(self, b: int, heel: float, trim: float) -> None:
        """Place body ``b`` there, without yaw, and compute its free surfaces."""
        q = self.model.bodies.locked.copy()
        q[6 * b + 3] = heel
        q[6 * b + 4] = trim
        each = self.model.bodies._replace(active=np.arange(q.size), tree=NO_TREE)
        place_bodies(q, np.zeros(q.size), each, self.work.motion)
        update_contents(self.y, self.model, self.work)

    def _moment(self, b: int) -> float:
        """Moment of weights [N m] about the level axis along the heading of body ``b``."""
        model = self.model
        motion = self.work.motion
        wrench = np.zeros((model.rows, 6 * model.bodies.each.size))
        add_weight(motion, model.bodies, model.weights, self.work.contents, wrench)
        ahead = motion.rotation[b, :2, 0]
        moment = wrench[model.weights.row, 6 * b + 3 : 6 * b + 5]
        return float(moment @ ahead / np.linalg.norm(ahead))
