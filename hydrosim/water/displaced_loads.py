"""First-order wave loads on displaced bodies, and the choice of the position where waves act.

    F = R(psi) Re sum_i X_i(b_i - psi) a_i exp(i (w_i t - k_i . (r + d) + e_i))

r: position of the centre of gravity at rest in the earth's x, y; d: its displacement from there;
psi: yaw, counted from the heading at rest; R: rotation from heading axes to the earth's; X:
transfer functions of the elevation at the centre of gravity. d = 0 if its position does not count,
psi = 0 if its heading does not. Heave, roll and pitch have no influence.

At the momentary position (`following_loads`) every wave is summed at every stage, which costs much
more than the tables of `loads`. Wave-frequency motions count like slow ones, which is a
second-order load of its own. For the slowly drifting position see `slow_path_loads`.

X is interpolated in frequency as in `transfer`. In heading, 6-point Lagrange polynomials pass
through six nodes per heading of the database. Their error is below 1e-4 of the highest harmonic.

Choice of a body's position in the waves where the scene leaves it to the program.

The waves follow the slow motion of a body if nothing restores it to its position at rest and
something may move it away. Otherwise they meet the body at rest, which costs less. The choice
depends on the scene alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import ceil, cos, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.jit.kernels import clear, kernel
from hydrosim.scene import Body, Kinematics, Place, Scene, SecondOrder, WaveForces
from hydrosim.scene.scene import is_anchored, joined_with
from hydrosim.water import quadratic_loads, transfer
from hydrosim.water.loads import MISSED, STENCIL_POINTS, rise, row_step
from hydrosim.water.narrow_bands import TRAINS, Bands, Set, bands_model, body_bands

if TYPE_CHECKING:
    from hydrosim.water.body import WaveBody
    from hydrosim.water.components import WaveComponents

BLOCK = 2.0
"""Duration of one slow path [s]; the nearest multiple of the grid of steps is used."""
HORIZONTAL_DOFS = (0, 1)
YAW = (5,)


def chosen_places(scene: Scene, body: Body) -> WaveForces:
    """The wave forces of a body with automatic ``position`` and ``headings`` resolved. Raises
    InputError if the two do not go together."""
    asked = body.wave_forces
    chosen = replace(
        asked,
        position=_choose_place(asked.position, scene, body, HORIZONTAL_DOFS),
        headings=_choose_place(asked.headings, scene, body, YAW),
    )
    if {chosen.position, chosen.headings} == {Place.SLOW, Place.INSTANTANEOUS}:
        if Place.AUTOMATIC not in (asked.position, asked.headings):
            raise InputError(
                f"bodies.{body.name}.wave_forces: found position: {asked.position} and headings:"
                f" {asked.headings}; expected slow or instantaneous for both, or mean for one."
            )
        return replace(chosen, position=Place.INSTANTANEOUS, headings=Place.INSTANTANEOUS)
    return chosen


def reference_positions(
    scene: Scene, body: Body, database: transfer.TransferFunctions | None
) -> WaveForces:
    """`chosen_places` for a body with this database. Automatic means at rest if the database does
    not have headings all round the circle."""
    chosen = chosen_places(scene, body)
    asked = body.wave_forces
    wanted = {asked.headings, asked.position} & {Place.SLOW, Place.INSTANTANEOUS}
    if wanted or database is None or transfer.has_headings_around(database):
        return chosen
    return replace(chosen, headings=Place.MEAN, position=Place.MEAN)


def met_by_waves(
    scene: Scene, databases: Mapping[str, transfer.TransferFunctions]
) -> dict[str, WaveForces]:
    """Position at which waves act on each body of a scene, by name, with their ``databases``."""
    return {
        body.name: reference_positions(scene, body, databases.get(body.name))
        for body in scene.bodies
    }


def slow_bodies(scene: Scene, met: Mapping[str, WaveForces]) -> list[str]:
    """Names of the bodies whose slow motion the waves follow. ``met`` has the `reference_positions`
    of all."""
    return [body.name for body in scene.bodies if _is_followed_slowly(scene, body, met[body.name])]


def _is_followed_slowly(scene: Scene, body: Body, met: WaveForces) -> bool:
    loaded = body.hydrodynamics is not None and met.has_loads and bool(scene.environment.waves)
    return loaded and Place.SLOW in (met.position, met.headings)


def _choose_place(asked: Place, scene: Scene, body: Body, dofs: tuple[int, ...]) -> Place:
    if asked != Place.AUTOMATIC:
        return asked
    exact = scene.solver.kinematics == Kinematics.EXACT
    leaves = (
        exact
        and _may_move(scene, body, dofs)
        and (_has_steady_force(scene, body) or _is_displaced(body, dofs))
    )
    return Place.SLOW if leaves else Place.MEAN


def _may_move(scene: Scene, body: Body, dofs: tuple[int, ...]) -> bool:
    """True if the body may leave its position at rest in one of the ``dofs``."""
    joined = joined_with(scene, body.name)
    if is_anchored(scene, body.name):
        return False
    held = {dof for e in scene.forces.values() if e.body in joined for dof in e.restored_dofs()}
    return any(dof in body.dofs and dof not in held for dof in (DOFS[i] for i in dofs))


def _has_steady_force(scene: Scene, body: Body) -> bool:
    """True if a steady force pushes the body, or has pushed it."""
    joined = joined_with(scene, body.name)
    others = [other for other in scene.bodies if other.name in joined]
    loads = any(other.wave_forces.second_order != SecondOrder.NONE for other in others)
    driven = any(e.supplies for e in scene.forces.values() if e.body in joined)
    moving = any(other.velocity[i] for other in others for i in (*HORIZONTAL_DOFS, *YAW))
    return loads or driven or moving or scene.environment.current.top_speed != 0.0


def _is_displaced(body: Body, dofs: tuple[int, ...]) -> bool:
    return any(body.position[i] for i in dofs)


def grid_step(scene: Scene) -> float:
    """Spacing of the grid of times at which steps end [s]: the output step if the method is
    adaptive, else the step."""
    return scene.output_step if scene.solver.method.adapts else scene.solver.step


def steps_per_block(scene: Scene) -> int:
    """Number of steps of that grid per slow path."""
    return max(round(BLOCK / grid_step(scene)), 1)


NODES_PER_HEADING = 6  # nodes of heading per heading of the database
SLOW_FREQUENCY_FRACTION = 0.25  # of the mean frequency of the sea: motions below it are slow
STATES_PER_FOLLOWED_BODY = (
    16  # states of a body whose slow motion the waves follow, see `hydrosim.water.slow_path_loads`
)
STEADY_YAW_ERROR_FRACTION = (
    1e-4  # of the error between rows: that of a yaw which is taken as steady
)
NEGLIGIBLE_WAVE_RATIO = 1e-9  # of the largest wave: smaller ones are left out


class FollowingLoads(NamedTuple):
    """Waves on the bodies that they follow, body by body. The entries offset[k] to offset[k + 1] of
    each array (nw,) belong to the k-th body, by sea and rising frequency. Values and slopes of X,
    (nf, nodes[k], 2, 6), are in ``load`` from first[k] on, stored once for equal bodies.

    The loads of the ``slow`` bodies are made in ``rows`` at a time, ``row_step`` [s] apart, for a
    ``block`` [s]. The states of these bodies begin at ``state``, and their filters have the cut-off
    ``cut`` [rad/s], see `hydrosim.water.slow_path_loads`.
    """

    body: np.ndarray  # (nb,) index among the scene's bodies
    loaded: np.ndarray  # (nb,) index where its loads belong, in sixes
    rest: np.ndarray  # (nb,) heading at rest [rad]
    centre: np.ndarray  # (nb, 2) centre of gravity in the frame of the waves of X [m]
    placed: np.ndarray  # (nb,) true if the position counts
    turns: np.ndarray  # (nb,) true if yaw counts
    nodes: np.ndarray  # (nb,) nodes of heading round the circle
    steady: np.ndarray  # (nb,) [rad] change of yaw that no harmonic of the loads shows
    offset: np.ndarray  # (nb + 1,)
    first: np.ndarray  # (nb,)
    active: np.ndarray  # (nb, 6) true for DOFs that are not locked
    omega: np.ndarray  # (nw,)
    wavenumber: np.ndarray  # (nw,)
    heading: np.ndarray  # (nw,)
    ramp: np.ndarray  # (nw,)
    elevation: np.ndarray  # (nw,) complex, at the centre of gravity at rest
    cell: np.ndarray  # (nw,) int64, of the table's frequencies
    part: np.ndarray  # (nw,) of the cell
    width: np.ndarray  # (nw,) of the cell [rad/s]
    load: np.ndarray  # complex
    second: quadratic_loads.Forms  # loads of second order
    bands: Bands  # bands of the waves of slow bodies, where these are summed in bands
    gathered: (
        transfer.FrequencyNodes
    )  # nodes of the waves of those that drift, where bands need them
    slow: np.ndarray  # (nb,) bool
    state: np.ndarray  # (nb,) int64
    cut: np.ndarray  # (nb,)
    block: float
    row_step: float
    rows: int


class _Part(NamedTuple):
    """The waves of all seas that load one body, (nw,) each, and the table of its loads."""

    omega: np.ndarray
    wavenumber: np.ndarray
    heading: np.ndarray
    ramp: np.ndarray
    elevation: np.ndarray
    cell: np.ndarray
    part: np.ndarray
    width: np.ndarray
    table: np.ndarray
    cut: float
    forms: quadratic_loads.BodyForms
    waves: quadratic_loads.Waves
    frequency: np.ndarray  # (nf,) of the table

    def bands(
        self, body: WaveBody, seas: Sequence[WaveComponents], span: transfer.NodeSpan, missed: float
    ) -> list[Set]:
        """Bands of these waves on the body."""
        nodes = self.table.shape[1]
        return body_bands(body, seas, self.waves, self.forms, self.frequency, nodes, span, missed)


def is_followed_by_waves(body: WaveBody) -> bool:
    """True if the waves follow the body."""
    asked = body.wave_forces
    moving = {Place.SLOW, Place.INSTANTANEOUS} & {asked.position, asked.headings}
    return body.database is not None and asked.has_loads and bool(moving)


def is_slow(body: WaveBody) -> bool:
    """True if the waves follow the slow motion of the body."""
    return is_followed_by_waves(body) and Place.SLOW in (
        body.wave_forces.position,
        body.wave_forces.headings,
    )


def following_model(
    seas: Sequence[WaveComponents],
    bodies: Sequence[WaveBody],
    block: float = 2.0,
    missed: float = MISSED,
) -> FollowingLoads:
    """The waves of all ``seas`` on the bodies that they follow. A slow path is renewed after each
    ``block`` [s]. Its loads are interpolated with an error of ``missed`` of the sea's standard
    deviation."""
    chosen = [body for body in bodies if is_followed_by_waves(body)] if seas else []
    parts = [
        _part_of_body(seas, body, body.database) for body in chosen if body.database is not None
    ]
    slow = np.array([is_slow(body) for body in chosen], dtype=bool)
    owners = sorted({body.index for body in chosen if is_slow(body)})
    cuts = {body.index: part.cut for body, part in zip(chosen[::-1], parts[::-1], strict=True)}
    first, load = quadratic_loads.join_once([part.table for part in parts], complex)
    step = row_step([line for part in parts for line in _lines_of_part(part)], block, missed)
    spans = [transfer.span_of(part.omega, part.wavenumber, block, step) for part in parts]
    bands = [
        part.bands(body, seas, span, missed)
        for part, body, span in zip(parts, chosen, spans, strict=True)
    ]
    nodes = [[band.nodes for band in sets if band.nodes is not None] for sets in bands]

    def join_fields(name: str, kind: type = float) -> np.ndarray:
        return np.concatenate([np.zeros(0, kind), *(getattr(part, name) for part in parts)])

    return FollowingLoads(
        body=np.array([body.index for body in chosen], dtype=np.int64),
        loaded=np.array([body.offset // 6 for body in chosen], dtype=np.int64),
        rest=np.array([body.heading for body in chosen]),
        centre=np.array([body.centre[:2] for body in chosen]).reshape(-1, 2),
        placed=np.array([body.wave_forces.position != Place.MEAN for body in chosen], dtype=bool),
        turns=np.array([body.wave_forces.headings != Place.MEAN for body in chosen], dtype=bool),
        nodes=np.array([part.table.shape[1] for part in parts], dtype=np.int64),
        steady=np.array(
            [
                STEADY_YAW_ERROR_FRACTION * missed * 2 * NODES_PER_HEADING / part.table.shape[1]
                for part in parts
            ]
        ),
        offset=np.cumsum([0, *(part.omega.size for part in parts)]),
        first=first,
        active=np.array([body.active for body in chosen], dtype=bool).reshape(-1, 6),
        **{
            name: join_fields(name)
            for name in ("omega", "wavenumber", "heading", "ramp", "part", "width")
        },
        elevation=join_fields("elevation", complex),
        cell=join_fields("cell", np.int64),
        load=load,
        second=quadratic_loads.forms_model([part.forms for part in parts]),
        bands=bands_model(bands),
        gathered=transfer.nodes_model(nodes, spans),
        slow=slow,
        state=STATES_PER_FOLLOWED_BODY
        * np.searchsorted(owners, [body.index for body in chosen]).astype(np.int64),
        cut=np.array([cuts[body.index] for body in chosen]),
        block=block,
        row_step=step,
        rows=ceil(block / step) + STENCIL_POINTS if slow.any() else 0,
    )


def _part_of_body(
    seas: Sequence[WaveComponents], body: WaveBody, database: transfer.TransferFunctions
) -> _Part:
    """The waves of the seas that load a body, train by train in the order of frequency, which saves
    work where many waves have one heading. First-order loads have only waves in the frequency range
    of its database."""
    w, table = transfer.transfer_table(database, NODES_PER_HEADING)
    elevation = np.concatenate([waves.amplitudes_at(*body.place()) for waves in seas])
    columns = [
        np.concatenate([getattr(waves, name) for waves in seas])
        for name in ("omega", "wavenumber", "heading")
    ]
    columns.append(np.concatenate([np.full(waves.omega.size, waves.ramp) for waves in seas]))
    sea = np.repeat(np.arange(len(seas)), [waves.omega.size for waves in seas])
    size = np.abs(elevation)
    first = (columns[0] <= w[-1] * (1.0 + 1e-9)) & body.wave_forces.first_order
    loaded = (size > NEGLIGIBLE_WAVE_RATIO * size.max(initial=0.0)) & (
        first | quadratic_loads.has_moving_second_order(body)
    )
    order = np.lexsort((columns[0], _heading_numbers(columns[2]), sea))
    order = order[loaded[order]]
    omega, wavenumber, heading, ramp = (values[order] for values in columns)
    waves_in_order = quadratic_loads.Waves(
        sea[order], omega, wavenumber, heading - body.heading, ramp
    )
    forms = quadratic_loads.body_forms(body, waves_in_order, elevation[order])
    elevation = np.where(first, elevation, 0.0)
    energy = np.where(first, size, 0.0)[order] ** 2 if first.any() else size[order] ** 2
    mean = np.sum(energy * omega) / max(np.sum(energy), np.finfo(float).tiny)
    return _Part(
        *(omega, wavenumber, heading, ramp, elevation[order]),
        *quadratic_loads.cells_of(w, omega),
        table,
        SLOW_FREQUENCY_FRACTION * float(mean),
        forms,
        waves_in_order,
        w,
    )


def _heading_numbers(heading: np.ndarray) -> np.ndarray:
    """Numbers (nw,) of the headings of waves, if these are few; else one number for all."""
    headings, number = np.unique(heading, return_inverse=True)
    return number if headings.size <= TRAINS else np.zeros(heading.size, dtype=np.int64)


def _lines_of_part(part: _Part) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Frequencies and amplitudes that rows have to resolve."""
    first = np.abs(part.elevation)
    yield part.omega, first if first.any() else np.abs(part.forms.wave)
    if any(form.pairing == quadratic_loads.SUM for form in part.forms.forms):
        yield 2.0 * part.omega, np.abs(part.forms.wave) ** 2


class Sums(NamedTuple):
    """Scratch: loads in heading axes of every wave, alternately real and imaginary, (12, nw); loads
    of one cell of the table at one heading, (2, 2, 6), complex; cos and sin of phases, (2, nw);
    sums of both orders, (2, 6)."""

    waves: np.ndarray
    cell: np.ndarray
    phase: np.ndarray
    total: np.ndarray
    filtered: quadratic_loads.Filtered


def new_sums(p: FollowingLoads) -> Sums:
    """Scratch for these loads."""
    most = int(np.diff(p.offset).max(initial=0))
    return Sums(
        np.zeros((12, most)),
        np.zeros((2, 2, 6), complex),
        np.zeros((2, most)),
        np.zeros((2, 6)),
        quadratic_loads.new_filtered(p.second, p.offset),
    )


@kernel
def following_loads(t, coordinates, p, sums, first, second):
    """Add the loads of both orders at time t to ``first`` and ``second`` (6 nb,), for displacements
    ``coordinates`` (6 nb,). Slow bodies are left out."""
    for k in range(p.body.size):
        if not p.slow[k]:
            at = 6 * p.loaded[k]
            _add_followed_loads(k, t, coordinates, p, sums)
            for j in range(6):
                if p.active[k, j]:
                    first[at + j] += sums.total[0, j]
                    second[at + j] += sums.total[1, j]


@kernel
def _add_followed_loads(k, t, coordinates, p, sums):
    """The loads of both orders on the k-th body into ``sums.total``, in earth axes."""
    at, start = 6 * p.body[k], p.offset[k]
    yaw = coordinates[at + 5] if p.turns[k] else 0.0
    dx = coordinates[at] if p.placed[k] else 0.0
    dy = coordinates[at + 1] if p.placed[k] else 0.0
    loads_at_heading(k, yaw, p, sums.cell, sums.waves)
    first = sums.total[0]
    second = sums.total[1]
    clear(first)
    clear(second)
    for i in range(start, p.offset[k + 1]):
        along = dx * cos(p.heading[i]) + dy * sin(p.heading[i])
        angle, ramp = p.omega[i] * t - p.wavenumber[i] * along, rise(t, p.ramp[i])
        sums.phase[0, i - start] = cos(angle)
        sums.phase[1, i - start] = sin(angle)
        c, s = ramp * cos(angle), ramp * sin(angle)
        for j in range(6):
            load = sums.waves
            first[j] += c * load[2 * j, i - start] - s * load[2 * j + 1, i - start]
    turn_to_earth(p.rest[k] + yaw, first)
    if quadratic_loads.has_forms(k, p.second):
        quadratic_loads.fill_load_factors(k, yaw, 0, p, sums.filtered)
        quadratic_loads.add_forms(k, t, 0, 1.0, sums.phase, p.second, sums.filtered, second)
        turn_to_earth(p.rest[k] + yaw, second)


@kernel
def turn_to_earth(heading, load):
    """Turn loads (6,) from axes of a ``heading`` to those of the earth, in place."""
    c, s = cos(heading), sin(heading)
    for j in range(0, 6, 3):
        load[j], load[j + 1] = load[j] * c - load[j + 1] * s, load[j] * s + load[j + 1] * c


@kernel
def loads_at_heading(k, yaw, p, cell, out):
    """Fill ``out`` (12, nw) with X a exp(i e) of every wave on the k-th body at this yaw, in
    heading axes, alternately real and imaginary. ``cell`` is scratch."""
    start, last, heading = p.offset[k], -1, 0.0
    x, y = p.centre[k, 0], p.centre[k, 1]
    for i in range(p.offset[k + 1] - start):
        n = start + i
        if p.cell[n] != last or p.heading[n] != heading:
            last, heading = p.cell[n], p.heading[n]
            to = heading - p.rest[k] - yaw
            quadratic_loads.cell_at(last, to, p.nodes[k], p.first[k], STENCIL_POINTS, p.load, cell)
        to, u, h = heading - p.rest[k] - yaw, p.part[n], p.width[n]
        v = 1.0 - u
        shift = p.wavenumber[n] * (x * cos(to) + y * sin(to)) if x != 0.0 or y != 0.0 else 0.0
        a = p.elevation[n] * (cos(shift) + 1j * sin(shift))
        v0, v1 = v * v * (1.0 + 2.0 * u) * a, u * u * (1.0 + 2.0 * v) * a
        s0, s1 = h * u * v * v * a, -h * u * u * v * a
        for j in range(6):
            load = v0 * cell[0, 0, j] + v1 * cell[1, 0, j] + s0 * cell[0, 1, j] + s1 * cell[1, 1, j]
            out[2 * j, i], out[2 * j + 1, i] = load.real, load.imag
