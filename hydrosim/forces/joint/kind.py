"""Joints as kinds of units: locks, which have modes and states, and the forces of all joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from hydrosim.forces.joint import locks
from hydrosim.forces.joint.locks import (
    ALL_ROW_BITS,
    CLOSED,
    LOCK_IMPULSE,
    LOCK_LOSS,
    LOCK_MODES,
    LOCK_STATES,
    LockConstants,
)
from hydrosim.forces.joint.rows import REFERENCE_SIZE
from hydrosim.forces.kind import (
    Columns,
    ElementKind,
    KindConstants,
    ModeRows,
    StateBlocks,
    UnitKind,
    UnitRecord,
    Variable,
)
from hydrosim.forces.layout import constraint_names
from hydrosim.modes import MODE, SEGMENT
from hydrosim.scene import Scene

LOCK_STATE_NAMES = (
    *(f"reference {k + 1}" for k in range(REFERENCE_SIZE)),
    "energy lost",
    *(f"impulse of {force}" for force in ("force x", "force y", "force z")),
    *(f"impulse of {moment}" for moment in ("moment x", "moment y", "moment z")),
)


class LockKind(ElementKind):
    unit = "lock"
    variables: ClassVar[Mapping[str, Variable]] = {
        "lock_mode": Variable(
            "mode of a joint that is a constraint", "1", flags=" ".join(LOCK_MODES)
        ),
        "lock_segment": Variable("bits of the rows of a joint that are not redundant", "1"),
        "lock_rows": Variable(
            "number of relative motions that a joint holds; those that others hold do not count",
            "1",
        ),
        "lock_impulse": Variable(
            "impulses of a joint on its body since the start, when joints closed; moment about the"
            " joint",
            "N s or N m s",
            "earth",
        ),
        "lock_loss": Variable("energy lost since the start, when the joint closed", "J"),
    }

    def unit_names(self, scene: Scene) -> list[str]:
        return list(constraint_names(scene))

    def modes(self, p: LockConstants) -> ModeRows:
        count = p.each.size
        return ModeRows(count, first=np.zeros(count, dtype=int), last=np.full(count, ALL_ROW_BITS))

    def states(self, p: LockConstants, scene: Scene) -> Iterator[StateBlocks]:
        yield StateBlocks("lock", self.unit_names(scene), LOCK_STATE_NAMES)

    def record(self, p: LockConstants, bodies: Any, kept: UnitRecord) -> Columns:
        count = p.each.size
        own = kept.y[p.state : p.state + LOCK_STATES * count].reshape(-1, count, LOCK_STATES)
        return {
            "lock_mode": (("time", "lock"), kept.modes[:, :, MODE].astype(np.int8)),
            "lock_impulse": (("time", "lock", "dof"), own[:, :, LOCK_IMPULSE:LOCK_STATES]),
            "lock_loss": (("time", "lock"), own[:, :, LOCK_LOSS]),
            "lock_rows": (("time", "lock"), _held_rows(kept.modes)),
        }

    def is_mirrored(self, p: LockConstants, y: np.ndarray, modes: np.ndarray) -> bool:
        """True if all joints are in the same mode; others may be mirrored too."""
        own = modes[p.mode : p.mode + p.each.size, MODE]
        return bool((own == own[:1]).all())

    def clear_unused_states(self, p: LockConstants, y: np.ndarray) -> None:
        """No state of a joint lacks meaning after a restart."""

    def renew(
        self,
        p: LockConstants,
        y: np.ndarray,
        anew: np.ndarray,
        possible: np.ndarray,
        known: np.ndarray,
    ) -> None:
        """References of loops, and of joints that the earlier run did not have, are those of
        now."""
        for i, lock in enumerate(p.each):
            own = slice(p.state + LOCK_STATES * i, p.state + LOCK_STATES * i + REFERENCE_SIZE)
            if lock["lasts"] or not known[own].all():
                y[own] = anew[own]


def _held_rows(modes: np.ndarray) -> np.ndarray:
    """Number (nt, n) of the rows that each joint holds."""
    bits = np.unpackbits(modes[:, :, SEGMENT].astype(np.uint8)[..., None], axis=2).sum(axis=2)
    return np.where(modes[:, :, MODE] == CLOSED, bits, 0).astype(np.int8)


class JointLoadKind(UnitKind):
    unit = "joint"
    variables: ClassVar[Mapping[str, Variable]] = {
        "joint_force": Variable(
            "force and moment of a joint at its point on its body", "N or N m", "earth"
        ),
    }

    def constants_in(self, parts: KindConstants) -> LockConstants:
        found: LockConstants = parts.elements.locks
        return found

    def unit_names(self, scene: Scene) -> list[str]:
        return list(scene.joints)

    def record(self, p: LockConstants, bodies: Any, kept: UnitRecord) -> Columns:
        return {"joint_force": (("time", "joint", "dof"), kept.observed)}


LOCK_KIND = LockKind("locks", (), locks.compile_elements)
JOINT_LOAD_KIND = JointLoadKind()
