"""Modes of flows: each flow waits, runs or is over.

A flow runs in pieces of constant rate, which end at given times. It begins at once, when a level is
reached, or by a trigger (`hydrosim.elements.trigger`). It ends at a time, at a level, by a trigger,
or when its source is empty or its target full. All of these are events.
"""

from __future__ import annotations

import numpy as np

from hydrosim.jit.kernels import kernel, root, root_giving
from hydrosim.modes import MARGINS, MODE, SEGMENT
from hydrosim.tanks.surface import SHALLOW

SEA_INDEX = -1
MIN_STEP_FRACTION = 1e-3  # of a step
MANY = 32  # steps until a tank is empty or full
PUMP_WAITING, PUMP_RUNNING, PUMP_ENDED = range(3)
NEXT_MARGIN, SOURCE_MARGIN, TARGET_MARGIN, LEVEL_MARGIN = range(4)
FLOW = np.dtype(
    [
        *(("body", int), ("source", int), ("target", int), ("first", int), ("last", int)),
        *(("start_tank", int), ("start_volume", float), ("start_sign", float)),
        *(("stop_tank", int), ("stop_volume", float), ("stop_sign", float)),
        *(("watched", bool), ("triggered", bool), ("inertial", bool), ("image", int)),
    ]
)
"""Constants of a flow. Its rates are ``first`` to ``last``. A level is reached if sign (V - volume)
is positive; there is none if the tank is `SEA_INDEX`. ``watched`` is true if the flow ends when its
source is empty or its target full. ``triggered`` is true if it begins and ends by a trigger.
``image`` is the index of its mirror image, or its own index."""
PUMP_RATE_DTYPE = np.dtype([("end", float), ("rate", float)])
"""Mass per time [kg/s] until ``end`` [s]; into the target, negative back to the source."""


@kernel
def rate_of(i, modes, p):
    """Mass per time of flow ``i``."""
    mode = modes[p.mode + i]
    return p.rates[mode[SEGMENT]].rate if mode[MODE] == PUMP_RUNNING else 0.0


@root_giving(float)
def share_of_step(step, y, modes, p):
    """Fraction of a ``step`` that is allowed while a tank with a level surface runs empty or full.

    Near the end the height of the surface changes as the cube root of the remaining volume, and a
    method resolves it only with order 4/3 of its step. Steps that shrink as the power 2/3 of that
    volume restore fourth order.
    """
    least = 1.0
    for i in range(p.flows.size):
        flow = p.flows[i]
        moved = step * abs(rate_of(i, modes, p))
        if moved > 0.0:
            least = min(
                least,
                _share_by_tank(flow.source, moved, y, p),
                _share_by_tank(flow.target, moved, y, p),
            )
    return max(least, MIN_STEP_FRACTION)


@kernel
def _share_by_tank(k, moved, y, p):
    """The fraction for tank ``k``, with the mass ``moved`` in a step. It is 1 while `MANY` steps
    remain."""
    if k == SEA_INDEX or p.each[k].liquid < 0:
        return 1.0
    tank = p.each[k]
    left = min(y[p.state + k], tank.capacity - y[p.state + k])
    if left <= 0.0:
        return 0.0
    return max(
        (left / (SHALLOW * tank.capacity)) ** (2.0 / 3.0), tank.density * left / (MANY * moved)
    )


@root
def find_margins(t, y, modes, p, out):
    """Margins of all flows into ``out``: time to the end of the piece, remaining content of the
    source, remaining room of the target, and distance to a level."""
    for i in range(p.flows.size):
        flow, mode, m = p.flows[i], modes[p.mode + i], MARGINS * (p.mode + i)
        for j in range(MARGINS):
            out[m + j] = 1.0
        if mode[MODE] == PUMP_WAITING and flow.start_tank != SEA_INDEX:
            missing = y[p.state + flow.start_tank] - flow.start_volume
            out[m + LEVEL_MARGIN] = -flow.start_sign * missing
        elif mode[MODE] == PUMP_RUNNING:
            _running_margins(t, y, mode, flow, p, m, out)


@kernel
def _running_margins(t, y, mode, flow, p, m, out):
    if mode[SEGMENT] < flow.last:
        out[m + NEXT_MARGIN] = p.rates[mode[SEGMENT]].end - t
    if p.rates[mode[SEGMENT]].rate == 0.0:
        return
    if flow.watched and flow.source != SEA_INDEX:
        out[m + SOURCE_MARGIN] = y[p.state + flow.source]
    if flow.watched and flow.target != SEA_INDEX:
        tank = p.each[flow.target]
        out[m + TARGET_MARGIN] = tank.capacity - y[p.state + flow.target]
    if flow.stop_tank != SEA_INDEX:
        over = y[p.state + flow.stop_tank] - flow.stop_volume
        out[m + LEVEL_MARGIN] = -flow.stop_sign * over


@root
def switch_flow(i, which, t, modes, p):
    """Switch flow ``i`` to its next mode, after margin ``which`` has reached zero."""
    mode = modes[p.mode + i]
    if mode[MODE] == PUMP_WAITING:
        mode[MODE] = PUMP_RUNNING
        while mode[SEGMENT] < p.flows[i].last and p.rates[mode[SEGMENT]].end <= t:
            mode[SEGMENT] += 1
    elif which == NEXT_MARGIN:
        mode[SEGMENT] += 1
    else:
        mode[MODE] = PUMP_ENDED


@kernel
def follow_trigger(i, stage, y, modes, p):
    """Set flow ``i`` to the state of its trigger: before, during or after its time, which are
    `PUMP_WAITING`, `PUMP_RUNNING` and `PUMP_ENDED`. It is also over if there is nothing to pump."""
    flow, mode = p.flows[i], modes[p.mode + i]
    dry = flow.source != SEA_INDEX and y[p.state + flow.source] <= 0.0
    full = flow.target != SEA_INDEX and y[p.state + flow.target] >= p.each[flow.target].capacity
    mode[MODE] = PUMP_ENDED if stage == PUMP_RUNNING and (dry or full) else stage


@root
def set_initial_modes(t, modes, p):
    """Modes of all flows for a start. Flows with a level wait; all others run, on the piece that
    ends at or after ``t``. Triggers are applied last."""
    for i in range(p.flows.size):
        flow, mode = p.flows[i], modes[p.mode + i]
        mode[MODE] = PUMP_RUNNING if flow.start_tank == SEA_INDEX else PUMP_WAITING
        mode[SEGMENT] = flow.first
        while mode[SEGMENT] < flow.last and p.rates[mode[SEGMENT]].end < t:
            mode[SEGMENT] += 1
