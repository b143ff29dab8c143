"""Damping of catenaries by their drag, from the motions in the waves of a scene, before a run.

The drag of a line depends on the motions, and these on the drag. So the damping c of all lines
(`hydrosim.elements.line.kind`) is a fixed point: the scene is linearised at its start, the motions
in its first-order waves give the velocities of all fairleads across their lines, and these give c.
A run that starts from another run keeps its values.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import linalg

from hydrosim.compile.restart import start_time
from hydrosim.dofs import about_z
from hydrosim.elements.kind import elements_of
from hydrosim.elements.line import kind
from hydrosim.elements.line.points import LineShape, line_shapes
from hydrosim.integrate.dynamics import Model, new_work
from hydrosim.linear.linearise import linearise
from hydrosim.multibody.kinematics import place_bodies, positions_at, slopes_at
from hydrosim.scene.catenary import Catenary
from hydrosim.water.build import first_order
from hydrosim.water.components import WaveComponents

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import xarray as xr

    from hydrosim.integrate.state import State
    from hydrosim.scene import Scene
    from hydrosim.water.body import WaveBody

LINE_DAMPING = "line_damping"
DRIFT = "line_drift"
"""Variables of a run with c and m of its lines."""
ROUNDS = 200  # of the fixed point
DAMPING_RTOL = 1e-12  # relative change of the damping in the last round
BINS = 300  # of frequencies, in which loads of a sea are gathered


class Fairlead(NamedTuple):
    """A line at the start: velocities (3, n) of its fairlead across the line per rate of each
    coordinate, the current (3,) across the line, and places (k,) along it: the share ``phi`` of the
    fairlead's motion, and 1/2 rho C D ds [N s^2/m^2]."""

    across: np.ndarray
    current: np.ndarray
    phi: np.ndarray
    drag: np.ndarray


class DraggedLines(NamedTuple):
    """A ``model`` with the drag of its lines, and ``texts`` about it."""

    model: Model
    texts: tuple[str, ...]


def with_line_drag(
    scene: Scene,
    model: Model,
    state: State,
    seas: Sequence[WaveComponents],
    bodies: Sequence[WaveBody],
) -> DraggedLines:
    """Model with the linearised drag of its lines in the ``seas``, whose first-order loads act on
    the ``bodies`` at rest."""
    p = kind.CATENARY_KIND.constants_in(model)
    if not p.lines["width"].any():
        return DraggedLines(model, tuple(_friction_notes(scene)))
    names = kind.CATENARY_KIND.unit_names(scene)
    before = _drag_before(scene)
    n = model.bodies.active.size
    motion = new_work(model).motion
    place_bodies(state.y[:n], np.zeros(n), model.bodies, motion)
    now = line_shapes(model, scene, start_time(scene), state.y, state.modes, model.bodies, motion)
    there = {line.name: _fairlead_motion(line, scene, model, state) for line in now}
    gone = Fairlead(np.zeros((3, n)), np.zeros(3), np.zeros(0), np.zeros(0))
    fairleads = [there.get(name, gone) for name in names]
    linearised = _fixed_point(model, state, seas, bodies, fairleads)
    texts = []
    lines = p.lines.copy()
    for name, line, (drag, sigma) in zip(names, lines, linearised, strict=True):
        c = drag.damping
        m = drag.drift
        is_kept = name in before
        if is_kept:
            c, m = before[name]
        line["damping"] = c
        line["drift"] = m
        if line["width"]:
            texts.append(f"{name}: {_drag_text(c, sigma, is_kept)}")
    elements = model.elements._replace(**{kind.CATENARY_KIND.field: p._replace(lines=lines)})
    return DraggedLines(model._replace(elements=elements), (*texts, *_friction_notes(scene)))


def _friction_notes(scene: Scene) -> Iterator[str]:
    """What friction of the seabed means for the energy of lines."""
    for name, line in elements_of(scene, Catenary):
        if getattr(line, "friction", None):
            yield (
                f"{name}: with friction of the seabed it has no potential, and its stiffness is not"
                " symmetric. All its work is booked as its loss, of either sign"
            )


def _drag_text(damping: float, sigma: float, is_kept: bool) -> str:
    if is_kept:
        return f"drag of {damping:.4g} N s/m across the line at the fairlead, as in the earlier run"
    if damping == 0.0:
        return "drag without damping (c = 0), because neither waves nor a current move it"
    return (
        f"drag of {damping:.4g} N s/m across the line at the fairlead, linearised for a standard"
        f" deviation of {sigma:.3g} m/s of its velocity there"
    )


def _drag_before(scene: Scene) -> dict[str, tuple[float, float]]:
    """c and m of the lines of the run that a scene of `open_start` starts from."""
    if scene.initial is None:
        return {}
    run: xr.Dataset = scene.initial.run
    if LINE_DAMPING not in run:
        return {}
    line_rows = zip(run.line.values, run[LINE_DAMPING].values, run[DRIFT].values, strict=True)
    return {str(name): (float(c), float(m)) for name, c, m in line_rows}


def _fairlead_motion(now: LineShape, scene: Scene, model: Model, state: State) -> Fairlead:
    """A line at the start."""
    line = now.constants
    ends = now.ends
    pull = now.pull
    places = kind.drag_points(now.line_pieces["length"], pull.touch)
    widths = kind.CATENARY_KIND.constants_in(model).widths[line["first"] : line["last"]]
    half = 0.5 * scene.environment.water_density * widths[places.segment]
    along = np.array([pull.H * ends.e[0], pull.H * ends.e[1], -pull.V])
    along /= max(float(np.linalg.norm(along)), 1e-300)
    P = np.eye(3) - np.outer(along, along)
    u = P @ [*line["stream"], 0.0]
    b = 6 * int(line["body"])
    S = slopes_at(model.bodies, state.y[: model.bodies.active.size])[b : b + 6]
    arm = np.asarray(ends.arm)
    J = S[:3] + np.cross(S[3:].T, arm).T
    return Fairlead(P @ J, u, places.phi, half * places.length)


def _fixed_point(
    model: Model,
    state: State,
    seas: Sequence[WaveComponents],
    bodies: Sequence[WaveBody],
    fairleads: Sequence[Fairlead],
) -> list[tuple[kind.LinearisedDrag, float]]:
    """Linearised drag of each line, and the standard deviation of its velocity [m/s]."""
    n = model.bodies.active.size
    still = np.zeros((n, n))
    waves = [sea for sea in seas if sea.omega.size]
    if not waves:
        return [_linearise_drag(at, still, False) for at in fairleads]
    regular = sum(sea.omega.size for sea in waves) == 1
    omega, loads = _wave_loads(model, state, waves, bodies)
    D = _dynamic_stiffness(model, state, omega)
    linearised: list[tuple[kind.LinearisedDrag, float]] = []
    c = np.zeros(len(fairleads))
    for _ in range(ROUNDS):
        B = sum(ci * at.across.T @ at.across for ci, at in zip(c, fairleads, strict=True))
        H = np.linalg.inv(D + 1j * omega[:, None, None] * B)
        spread = H @ loads @ H.conj().transpose(0, 2, 1)
        S = np.real((omega[:, None, None] ** 2 * spread).sum(axis=0))
        linearised = [_linearise_drag(at, S, regular) for at in fairleads]
        new = np.array([drag.damping for drag, _ in linearised])
        if np.abs(new - c).max() <= DAMPING_RTOL * np.abs(new).max():
            break
        c = new
    return linearised


def _linearise_drag(
    at: Fairlead, S: np.ndarray, regular: bool
) -> tuple[kind.LinearisedDrag, float]:
    """Drag for velocities of the coordinates with a covariance ``S`` (n, n)."""
    covariance = at.across @ S @ at.across.T
    sigma = float(np.sqrt(max(np.trace(covariance), 0.0)))
    if regular:
        linearised = [kind.linearise_regular(x * np.sqrt(2.0) * sigma, at.current) for x in at.phi]
    else:
        linearised = [kind.linearise_random(x * x * covariance, at.current) for x in at.phi]
    damping = sum(k * x**2 * f.damping for k, x, f in zip(at.drag, at.phi, linearised, strict=True))
    drift = sum(k * x * f.drift for k, x, f in zip(at.drag, at.phi, linearised, strict=True))
    return kind.LinearisedDrag(float(damping), float(drift)), sigma


def _wave_loads(
    model: Model, state: State, seas: Sequence[WaveComponents], bodies: Sequence[WaveBody]
) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (nb,) of bins, and covariances (nb, n, n) of the generalised loads in them."""
    n = model.bodies.active.size
    S = slopes_at(model.bodies, state.y[:n])
    place = positions_at(model.bodies, state.y[:n])
    at = [body.moved_by(where) for body, where in zip(bodies, place, strict=True)]
    omega = np.concatenate([sea.omega for sea in seas])
    load = np.concatenate([first_order(sea, at).amplitude[:, : len(S)] @ S for sea in seas])
    order = np.argsort(omega, kind="stable")
    parts = np.array_split(order, min(BINS, omega.size))
    centres = np.array([omega[part].mean() for part in parts])
    spread = [0.5 * load[part].T @ load[part].conj() for part in parts]
    return centres, np.array(spread)


def _dynamic_stiffness(model: Model, state: State, omega: np.ndarray) -> np.ndarray:
    """D(w), (nw, n, n), at the start, without drag of lines; a memory by convolution included."""
    n = model.bodies.active.size
    y = state.y.copy()
    y[n : 2 * n] = 0.0
    linear = linearise(model, state._replace(y=y))
    D = linear.dynamic_stiffness(omega)
    kernel = model.convolution
    if not kernel.row.size:
        return D
    size = 6 * model.bodies.each.size
    in_bodies = (kernel.row < size) & (kernel.column < size)
    lags = kernel.step * np.arange(len(kernel.K))
    weights = np.full(lags.size, kernel.step)
    weights[[0, -1]] *= 0.5
    waves = np.exp(-1j * np.outer(omega, lags)) * weights
    memory = np.zeros((omega.size, size, size), dtype=complex)
    memory[:, kernel.row[in_bodies], kernel.column[in_bodies]] = waves @ kernel.K[:, in_bodies]
    yaw = positions_at(model.bodies, y[:n])[:, 5] + model.bodies.each["heading"]
    turned = linalg.block_diag(*(about_z(float(a)) for a in yaw for _ in range(2)))
    along = turned.T @ slopes_at(model.bodies, y[:n])
    return np.asarray(D + 1j * omega[:, None, None] * (along.T @ memory @ along))
