"""Winches for set-up and output; their kernels are in `hydrosim.elements.line.winch`."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any, ClassVar

import numpy as np

from hydrosim.elements.kind import (
    LINEARISATION_DEPTH,
    Columns,
    KindWithModeSets,
    ModeRows,
    ModeSet,
    StateBlocks,
    UnitRecord,
    Variable,
    capacity_of,
    elements_of,
    rest_at_first,
    with_mode_of_unit,
)
from hydrosim.elements.line import drum
from hydrosim.elements.line.drum import (
    DRUM_MODES,
    LENGTH_CONTROL,
    PRESCRIBED,
    SLIPPING_IN,
    STUCK,
    TENSION_CONTROL,
    Compensation,
)
from hydrosim.elements.line.winch import (
    DRIVE_WORK,
    DRUM_FRICTION,
    DRUM_SPEED,
    LARGEST_TENSION,
    LENGTH_OFF,
    PAY_OUT,
    SNAP_SPEED,
    WINCH_STATE_NAMES,
    WINCH_STATES,
    WIRE_CUT,
    WIRE_LENGTH,
    WIRE_SLACK,
    WIRE_TAUT,
    WIRE_TENSION,
    Winch,
    WinchConstants,
    compile_elements,
)
from hydrosim.elements.pair import line_between
from hydrosim.modes import MODE, SEGMENT
from hydrosim.scene import Scene

DELAY = tuple(f"delay {k + 1}" for k in range(drum.DELAY_STATES))


class WinchKind(KindWithModeSets):
    unit = "winch"
    variables: ClassVar = {
        "winch_tension": Variable("tension of the wire", "N", "from the point to the anchor"),
        "winch_length": Variable("length of wire off the drum, without load", "m"),
        "winch_speed": Variable("speed of pay-out of the drum", "m/s"),
        "winch_work": Variable("energy that the drive of the drum has taken", "J"),
        "winch_friction_loss": Variable("energy lost by friction in the drum", "J"),
        "winch_snap_speed": Variable("speed at which the wire last became taut", "m/s"),
        "winch_largest_tension": Variable("largest tension of all steps so far", "N"),
        "winch_mode": Variable("mode of the drum", "1", flags=" ".join(DRUM_MODES)),
        "winch_segment": Variable("wire slack, taut, or cut by its damping", "1"),
    }

    def modes(self, p: WinchConstants) -> ModeRows:
        count = p.each.size
        return ModeRows(count, first=np.zeros(count, dtype=int), last=np.full(count, WIRE_CUT))

    def states(self, p: WinchConstants, scene: Scene) -> Iterator[StateBlocks]:
        every = {name: e for name, e in scene.forces.items() if isinstance(e, Winch)}
        controls = {name: e.control for name, e in every.items()}
        yield StateBlocks("winch", [*every], WINCH_STATE_NAMES)
        late = [n for n, c in controls.items() if isinstance(c, Compensation) and c.delay]
        yield StateBlocks("winch delay", late, DELAY)

    def coupled_states(self, p: WinchConstants) -> np.ndarray:
        ruled = np.flatnonzero(p.each["drum"]["control"] != LENGTH_CONTROL)
        heavy = np.flatnonzero(p.each["drum"]["acceleration"] > 0.0)
        late = WINCH_STATES * p.each.size + np.arange(drum.DELAY_STATES * p.delays)
        states = [WINCH_STATES * ruled + WIRE_LENGTH, WINCH_STATES * heavy + DRUM_SPEED, late]
        return (p.state + np.concatenate(states)).astype(np.int64)

    def is_mirrored(self, p: WinchConstants, y: np.ndarray, modes: np.ndarray) -> bool:
        """Winches that are alike but for their ends have the same lengths and modes."""
        fields = [n for n in p.each.dtype.names or () if n not in ("row", "point", "anchor")]
        alike: dict[bytes, list[int]] = {}
        for i, winch in enumerate(p.each):
            alike.setdefault(b"".join(winch[n].tobytes() for n in fields), []).append(i)
        lengths = y[p.state : p.state + WINCH_STATES * p.each.size].reshape(-1, WINCH_STATES)[
            :, : DRUM_SPEED + 1
        ]
        return all(
            np.array_equal(lengths[i], lengths[same[0]])
            and np.array_equal(modes[i], modes[same[0]])
            for same in alike.values()
            for i in same
        )

    def clear_unused_states(self, p: WinchConstants, y: np.ndarray) -> None:
        """All states have a meaning."""

    def renew(
        self,
        p: WinchConstants,
        y: np.ndarray,
        anew: np.ndarray,
        possible: np.ndarray,
        known_states: np.ndarray,
    ) -> None:
        """Winches that the run before did not have begin with the length of their start."""
        winch_states = slice(
            p.state, p.state + WINCH_STATES * p.each.size + drum.DELAY_STATES * p.delays
        )
        y[winch_states] = np.where(known_states[winch_states], y[winch_states], anew[winch_states])

    def mode_sets(self, p: WinchConstants) -> Sequence[ModeSet]:
        if not p.each.size:
            return []
        sets = [ModeSet("winches slack", _modes_of_wires(p, WIRE_SLACK))]
        sets.append(ModeSet("winches taut", _modes_of_wires(p, WIRE_TAUT)))
        slips = (p.each["drum"]["control"] == TENSION_CONTROL) & (p.each["damping"] > 0.0)
        if slips.any():
            slipping = _modes_of_wires(p, WIRE_TAUT)
            slipping[slips, MODE] = SLIPPING_IN
            sets.append(ModeSet("drums slipping", slipping))
        return sets

    def one_unit_active(
        self, p: WinchConstants, names: Sequence[str], which: Sequence[int]
    ) -> Iterator[ModeSet]:
        for i in which if p.each.size > 1 else ():
            winch = with_mode_of_unit(
                _modes_of_wires(p, WIRE_SLACK), _modes_of_wires(p, WIRE_TAUT), i
            )
            yield ModeSet(f"{names[i]} alone taut", winch)

    def equivalence_keys(self, p: WinchConstants) -> Sequence[Hashable]:
        """No two winches are alike: each pulls in a direction of its own."""
        return range(p.each.size)

    def rates(self, p: WinchConstants, bodies: Any, motion: Any) -> np.ndarray:
        """Along the wires."""
        rates_by_winch = [_line_of_winch(winch, bodies, motion).rate for winch in p.each]
        return np.reshape(rates_by_winch, (-1, 1))

    def moved_onto_segment(
        self, p: WinchConstants, modes: np.ndarray, bodies: Any, motion: Any
    ) -> WinchConstants:
        """Constants with wires that are just taut, as stiff as at their shortest."""
        constants = p.each.copy()
        for winch, (mode, segment, _) in zip(constants, modes, strict=True):
            if segment == WIRE_TAUT and mode != SLIPPING_IN:
                distance = _line_of_winch(winch, bodies, motion).length
                winch["pinned"] = distance / (
                    1.0 + LINEARISATION_DEPTH / max(distance, LINEARISATION_DEPTH)
                )
                winch["stiffness"] *= winch["pinned"] / max(
                    _shortest(winch, p), LINEARISATION_DEPTH
                )
        return p._replace(each=constants)

    def idle_states(self, p: WinchConstants, modes: np.ndarray) -> np.ndarray:
        """Lengths of drums that do not slip, and their speeds."""
        still = np.flatnonzero(modes[:, MODE] != SLIPPING_IN)
        first = p.state + WINCH_STATES * still
        return np.concatenate([first + WIRE_LENGTH, first + DRUM_SPEED])

    def coordinates(self, scene: Scene) -> dict[str, object]:
        return super().coordinates(scene) | capacity_of(self.unit, elements_of(scene, Winch))

    def record(self, p: WinchConstants, bodies: Any, unit_record: UnitRecord) -> Columns:
        dims = ("time", "winch")
        n = p.each.size
        states = unit_record.y[p.state : p.state + WINCH_STATES * n].reshape(-1, n, WINCH_STATES)
        return {
            "winch_tension": (dims, unit_record.observed[:, :, WIRE_TENSION]),
            "winch_length": (dims, unit_record.observed[:, :, LENGTH_OFF]),
            "winch_speed": (dims, unit_record.observed[:, :, PAY_OUT]),
            "winch_work": (dims, states[:, :, DRIVE_WORK]),
            "winch_friction_loss": (dims, states[:, :, DRUM_FRICTION]),
            "winch_snap_speed": (dims, states[:, :, SNAP_SPEED]),
            "winch_largest_tension": (dims, states[:, :, LARGEST_TENSION]),
            "winch_mode": (dims, unit_record.modes[:, :, MODE].astype(np.int8)),
        }


def _modes_of_wires(p: WinchConstants, wire: int) -> np.ndarray:
    """Modes with all drums at rest, or driven by their target, and all wires alike."""
    tense = p.each["drum"]["control"] == TENSION_CONTROL
    modes = rest_at_first(np.full(p.each.size, wire), STUCK)
    modes[:, MODE] = np.where(tense, STUCK, PRESCRIBED)
    modes[:, SEGMENT] = wire
    return modes


def _line_of_winch(winch: Any, bodies: Any, motion: Any) -> Any:
    """The line between the ends of a winch."""
    ends = (winch["body"], tuple(winch["point"]), winch["anchor_body"], tuple(winch["anchor"]))
    return line_between(*ends, bodies, motion)


def _shortest(winch: np.void, p: WinchConstants) -> float:
    """The shortest length off the drum [m] that a winch may have."""
    if winch["drum"]["control"] == LENGTH_CONTROL:
        signal = winch["signal"]
        pieces = p.pieces[signal["first"] : signal["last"] + 1]
        return float(pieces["a"].min() - abs(signal["amplitude"]))
    if winch["drum"]["shortest"] > 0.0:
        return float(winch["drum"]["shortest"])
    return float(winch["start"])


WINCH_KIND = WinchKind("winches", (Winch,), compile_elements)
