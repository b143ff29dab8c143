"""Waves of few headings on a body that yaws or drifts slowly: sums over the frequencies of its
database, which are fewer than the waves.

    F1(t, psi) = Re sum_f X_f(b - psi) E_f(t) + X'_f(b - psi) S_f(t)
    F2(t, psi) =    sum_f D_f(b - psi) Re(z* E_f(t)) + D'_f(b - psi) Re(z* S_f(t)),    z = sum_f E_f
    E_f(t) = sum_i H_f(w_i) a_i exp(i w_i t),    S_f(t) = sum_i G_f(w_i) a_i exp(i w_i t)

Between two frequencies of a database its loads are cubic polynomials of the values X_f, D_f and the
slopes X'_f, D'_f there. H_f and G_f are the Hermite polynomials, non-zero only in the two cells
beside f. So these sums equal the sums over waves of `slow` at every yaw, and no E_f or S_f depends
on the yaw. F2 is Newman's approximation; for the mean load, sum_i H_f |a_i|^2 replaces z* E_f.

A band is one E_f or S_f. It is narrow. So its envelope E_f(t) exp(-i w_b t), about a frequency w_b
in its middle, is stored at few times of the repeat period. It is interpolated by 6-point Lagrange
polynomials, whose error is below 3e-9 for each wave. The envelopes are made by FFT. Where a body
drifts they change with its place, and `FrequencyNodes` makes them along each block of its path.

The loads of a table at its nodes of heading are kept for each band in the order in which sums read
them: a body that hardly yaws needs the same few nodes at all times.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, cos, floor, pi, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from hydrosim.jit.kernels import assign, clear, kernel, root, summing
from hydrosim.scene import Place, SecondOrder
from hydrosim.water import quadratic_loads, transfer
from hydrosim.water.loads import STENCIL_POINTS, lagrange, rise

if TYPE_CHECKING:
    from hydrosim.water.body import WaveBody
    from hydrosim.water.components import WaveComponents

PHASE = 0.09
"""Largest turn of a wave's phase [rad] about the middle of its band between two stored times."""
WORTH = 2  # fewest waves per band
TRAINS = 8  # most headings of a long-crested sea
WIDE = 3.0
"""Largest ratio of the widest cell of frequencies to the mean one; it sets the resolution of
envelopes."""
NO_LOAD = -1
SPARE = 2  # nodes of heading that are kept beside those of one yaw; even, as others
NO_HEADING_NODE = np.iinfo(np.int64).min
VALUE, SLOPE, LOW, LOW_DRIFT = range(4)
"""Factor of a band: the value or the slope of X and D at a frequency of the database. Below all of
these, the first value of X alone, or of D alone, which fades to zero there."""
ENTRIES_PER_LOAD = 12  # of a frequency and a heading in a table of loads: six values, six slopes


class Bands(NamedTuple):
    """The bands of all bodies, body by body, in sets; the waves of a set belong to one sea.

    ``sets`` (nb + 1,) and ``span`` (ns + 1,) give the first set of each body and the first band of
    each set. The envelopes of a set, (times, 2, bands), real and imaginary, start at ``table`` in
    ``values``, ``step`` apart; none where the body drifts. The factor of a band at heading 0 starts
    at ``load`` in the body's table of X and at ``drift`` in the table of D; `NO_LOAD` if there is
    no such load."""

    sets: np.ndarray
    span: np.ndarray
    ramp: np.ndarray  # (ns,) [s]
    pairing: np.ndarray  # (ns,) of the second-order load, or NO_LOAD
    step: np.ndarray  # (ns,) [s]
    times: np.ndarray  # (ns,)
    table: np.ndarray  # (ns,)
    values: np.ndarray
    omega: np.ndarray  # (n,) in the middle
    kx: np.ndarray  # (n,) wavenumber in the middle, along the earth's x
    ky: np.ndarray  # (n,)
    heading: np.ndarray  # (n,)
    load: np.ndarray  # (n,)
    drift: np.ndarray  # (n,)
    share: np.ndarray  # (n,) 1 if it is a part of the elevation, else 0
    energy: np.ndarray  # (n,) sum of H |a|^2


class Set(NamedTuple):
    """The bands of one set, as in `Bands`; ``values`` (times, 2, n). Its ``nodes`` if the body
    drifts."""

    ramp: float
    pairing: int
    step: float
    values: np.ndarray
    omega: np.ndarray
    kx: np.ndarray
    ky: np.ndarray
    heading: np.ndarray
    load: np.ndarray
    drift: np.ndarray
    share: np.ndarray
    energy: np.ndarray
    nodes: transfer.NodeSet | None


def body_bands(
    body: WaveBody,
    seas: Sequence[WaveComponents],
    waves: quadratic_loads.Waves,
    forms: quadratic_loads.BodyForms,
    w: np.ndarray,
    nodes: int,
    span: transfer.NodeSpan,
    missed: float,
) -> list[Set]:
    """The bands of ``waves`` on a body, whose table of X has frequencies ``w`` (nf,) and ``nodes``
    headings. None if bands cannot represent the waves, or are not far fewer than the waves.

    Where the body drifts, its amplitudes at nodes are used over a ``span``, with an error of
    ``missed``.
    """
    placed = body.wave_forces.position == Place.SLOW
    on_grid = placed or all(sea.spacing > 0.0 for sea in seas)
    if not (on_grid and _has_bands(body) and _are_regular(waves, w)):
        return []
    numbers = np.unique(waves.sea)
    cells_by_sea = [_Cells(w, waves, np.flatnonzero(waves.sea == number)) for number in numbers]
    count = 0
    if placed:
        count = transfer.count_nodes(
            max(np.max(cells.high - cells.low) for cells in cells_by_sea), span, missed
        )
        if count > transfer.MAX_NODES:
            return []
    sets = [
        _fill_set(body, seas[number].spacing, cells, forms, nodes, count)
        for number, cells in zip(numbers, cells_by_sea, strict=True)
    ]
    few = WORTH * sum(band_set.omega.size for band_set in sets) <= waves.omega.size
    return sets if few else []


def _has_bands(body: WaveBody) -> bool:
    """True if bands can represent all loads on a body."""
    wanted = body.wave_forces
    slow = Place.INSTANTANEOUS not in (wanted.position, wanted.headings)
    without_bands = (SecondOrder.NONE, SecondOrder.NEWMAN, SecondOrder.MEAN_DRIFT)
    second = wanted.second_order in without_bands and not wanted.sum_frequency
    return (
        slow
        and not np.any(body.centre[:2])
        and (second or not quadratic_loads.has_moving_second_order(body))
    )


def _are_regular(waves: quadratic_loads.Waves, w: np.ndarray) -> bool:
    """True if the waves have few headings and lie in cells of ``w`` of similar width."""
    cells = np.unique(quadratic_loads.cells_of(w, waves.omega)[0])
    width = np.diff(w)[cells]
    even = bool(np.all(width <= WIDE * width.mean()))
    return even and np.unique(waves.heading).size <= TRAINS


class _Cells:
    """The waves with indices ``at`` (n,), all of one sea, in cells of the frequencies ``w`` (nf,).

    A slot (n,) is a cell of ``w``, or one of the slots, two cells wide, that continue below 0 and
    from nf on. ``train`` (n,) is the index of a wave's heading among the ``trains``. The cells with
    waves have the first of these waves, and the one after the last, and lie between ``low`` and
    ``high`` [rad/s].
    """

    def __init__(self, w: np.ndarray, waves: quadratic_loads.Waves, at: np.ndarray) -> None:
        self.w = w
        self.at = at
        self.omega = waves.omega[at]
        self.wavenumber = waves.wavenumber[at]
        self.ramp = float(waves.ramp[at[0]])
        self.trains, self.train = np.unique(waves.heading[at], return_inverse=True)
        cell, _, width = quadratic_loads.cells_of(w, self.omega)
        wide = 2.0 * width.max(initial=0.0)
        below = np.floor((self.omega - w[0]) / wide).astype(np.int64)
        above = w.size + np.floor((self.omega - w[-1]) / wide).astype(np.int64)
        high = self.omega > w[-1] * (1.0 + 1e-9)
        self.slot = np.where(self.omega < w[0], below, np.where(high, above, cell))
        edges = np.flatnonzero(np.diff(self.train) | np.diff(self.slot)) + 1
        self.begin = np.concatenate([[0], edges]).astype(np.int64)
        self.end = np.concatenate([edges, [at.size]]).astype(np.int64)
        self.low = self.omega[self.begin]
        self.high = np.maximum(self.omega[self.end - 1], self.low + transfer.NARROWEST * wide)

    def shares(
        self, omega: np.ndarray, slot: np.ndarray, train: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Bands (n, 3) of waves of ``omega`` (m,): train, slot and kind. Shares of the waves in
        them: indices of the wave and of the band, and weight."""
        w = self.w
        cell = np.clip(slot, 0, w.size - 2)
        h = np.diff(w)[cell]
        u = (omega - w[cell]) / h
        v = 1.0 - u
        low = slot < 0
        high = slot >= w.size
        inside = ~(low | high)
        shares = (
            (inside, slot, VALUE, v * v * (1.0 + 2.0 * u)),
            (inside, slot, SLOPE, h * u * v * v),
            (inside, slot + 1, VALUE, u * u * (1.0 + 2.0 * v)),
            (inside, slot + 1, SLOPE, -h * u * u * v),
            (low, slot, LOW, np.ones(omega.size)),
            (low, slot, LOW_DRIFT, omega / (w[0] or 1.0)),
            (high, slot, VALUE, np.ones(omega.size)),
        )
        wave = np.concatenate([np.flatnonzero(chosen) for chosen, _, _, _ in shares])
        slots = np.concatenate([at[chosen] for chosen, at, _, _ in shares])
        kinds = np.concatenate([np.full(chosen.sum(), kind) for chosen, _, kind, _ in shares])
        weight = np.concatenate([factor[chosen] for chosen, _, _, factor in shares])
        bands, band = np.unique(
            np.stack([train[wave], slots, kinds], axis=1), axis=0, return_inverse=True
        )
        return bands, wave, band.ravel(), weight

    def wavenumbers_at(self, omega: np.ndarray) -> np.ndarray:
        """Wavenumbers at frequencies among those of the waves."""
        w, index = np.unique(self.omega, return_index=True)
        return transfer.interpolate_spline(w, self.wavenumber[index], omega)

    def nodes(self, count: int, heading: float) -> transfer.NodeSet:
        """``count`` nodes per cell on a body with this ``heading``."""
        x = np.cos(np.pi * (np.arange(count) + 0.5) / count)
        middle = (self.low + self.high)[:, None] / 2.0
        of_cell = middle + (self.high - self.low)[:, None] / 2.0 * x
        omega = of_cell.ravel()
        train = np.repeat(self.train[self.begin], count)
        slot = np.repeat(self.slot[self.begin], count)
        _, node, band, factor = self.shares(omega, slot, train)
        order = np.argsort(node, kind="stable")
        cell = np.repeat(np.arange(self.begin.size), self.end - self.begin)
        k = self.wavenumbers_at(omega)
        to = heading + self.trains[train]
        return transfer.NodeSet(
            begin=self.at[0] + self.begin,
            end=self.at[0] + self.end,
            weight=transfer.lagrange_weights(of_cell[cell], self.omega),
            omega=omega,
            kx=k * np.cos(to),
            ky=k * np.sin(to),
            node=node[order],
            band=band[order],
            factor=factor[order],
        )


def _fill_set(
    body: WaveBody,
    spacing: float,
    cells: _Cells,
    forms: quadratic_loads.BodyForms,
    nodes: int,
    count: int,
) -> Set:
    """The bands of the waves of one sea; ``count`` nodes per cell where the body drifts, else
    0."""
    w = cells.w
    bands, wave, band, weight = cells.shares(cells.omega, cells.slot, cells.train)
    train, slot, what = bands.T
    inside = np.clip(slot, 0, w.size - 1)
    entry = 6 * (what == SLOPE)
    loads = (what != LOW_DRIFT) & (slot < w.size) & body.wave_forces.first_order
    drifts = (what != LOW) & bool(forms.forms)
    elevation = forms.wave[cells.at[wave]]
    drift_nodes = forms.drift.table.shape[1]
    omega, step, values = _band_envelopes(
        cells.omega[wave], band, weight * elevation, spacing, count
    )
    k = cells.wavenumbers_at(omega)
    heading = body.heading + cells.trains[train]
    return Set(
        ramp=cells.ramp,
        pairing=forms.forms[0].pairing if forms.forms else NO_LOAD,
        step=step,
        values=values,
        omega=omega,
        kx=k * np.cos(heading),
        ky=k * np.sin(heading),
        heading=heading,
        load=np.where(loads, ENTRIES_PER_LOAD * nodes * inside + entry, NO_LOAD),
        drift=np.where(drifts, ENTRIES_PER_LOAD * drift_nodes * inside + entry, NO_LOAD),
        share=np.isin(what, (VALUE, LOW)).astype(float),
        energy=np.bincount(band, weight * np.abs(elevation) ** 2),
        nodes=cells.nodes(count, body.heading) if count else None,
    )


def _band_envelopes(
    omega: np.ndarray, band: np.ndarray, amplitude: np.ndarray, spacing: float, nodes: int
) -> tuple[np.ndarray, float, np.ndarray]:
    """Frequencies in the middle of bands, and the step and the values (times, 2, bands) of their
    envelopes over the repeat period; there are none where there are ``nodes``."""
    count = band.max(initial=-1) + 1
    lowest = np.full(count, np.inf)
    highest = np.zeros(count)
    np.minimum.at(lowest, band, omega)
    np.maximum.at(highest, band, omega)
    if nodes:
        return (lowest + highest) / 2.0, 1.0, np.zeros((0, 2, count))
    index = np.rint(omega / spacing).astype(np.int64)
    middle = np.rint((lowest + highest) / (2.0 * spacing)).astype(np.int64)
    off = index - middle[band]
    reach = np.abs(off).max(initial=0)
    times = scipy.fft.next_fast_len(ceil(2.0 * np.pi * reach / PHASE) + 1)
    spectrum = np.zeros((times, count), dtype=complex)
    np.add.at(spectrum, (off % times, band), amplitude)
    values = scipy.fft.ifft(spectrum, axis=0, norm="forward", overwrite_x=True)
    step = 2.0 * np.pi / (spacing * times)
    return spacing * middle, step, np.stack([values.real, values.imag], axis=1)


def bands_model(bodies: Sequence[Sequence[Set]]) -> Bands:
    """The bands of all bodies as arrays."""
    sets = [band_set for body_sets in bodies for band_set in body_sets]

    def of_sets(name: str, kind: type = float) -> np.ndarray:
        return np.array([getattr(band_set, name) for band_set in sets], dtype=kind)

    def join_fields(name: str, kind: type = float) -> np.ndarray:
        return np.concatenate(
            [np.zeros(0, kind), *(getattr(band_set, name).ravel() for band_set in sets)]
        )

    return Bands(
        sets=np.cumsum([0, *map(len, bodies)]),
        span=np.cumsum([0, *(band_set.omega.size for band_set in sets)]),
        ramp=of_sets("ramp"),
        pairing=of_sets("pairing", np.int64),
        step=of_sets("step"),
        times=np.array([len(band_set.values) for band_set in sets], dtype=np.int64),
        table=np.cumsum([0, *(band_set.values.size for band_set in sets)])[: len(sets)],
        values=join_fields("values"),
        omega=join_fields("omega"),
        kx=join_fields("kx"),
        ky=join_fields("ky"),
        heading=join_fields("heading"),
        load=join_fields("load", np.int64),
        drift=join_fields("drift", np.int64),
        share=join_fields("share"),
        energy=join_fields("energy"),
    )


class BandSums(NamedTuple):
    """Scratch for all bands: ``load`` (24, n), alternately real and imaginary, and ``drift`` (12,
    n) at the ``yaw`` (2, nb) of each body; ``phase`` (4, n), cos and sin of the phase in the middle
    and of its change per row; ``value`` (2, n) of E_f; ``paired`` (n,), Re(z* E_f). Envelopes along
    the path of a body that drifts, from ``nodes``. Each ``weight`` of loads at nodes of heading;
    these are kept for all bodies."""

    yaw: np.ndarray
    load: np.ndarray
    drift: np.ndarray
    phase: np.ndarray
    value: np.ndarray
    paired: np.ndarray
    envelope: np.ndarray
    nodes: transfer.NodeSums
    weight: np.ndarray
    loads: Columns
    drifts: Columns


class Columns(NamedTuple):
    """Entries of a table of loads at a few nodes of heading, (columns, entries, n) for all bands,
    in a ring. The node ``known`` (columns, n) of a column is said at the first band of a
    heading."""

    values: np.ndarray
    known: np.ndarray


def new_band_sums(bodies: int, bands: Bands, gathered: transfer.FrequencyNodes) -> BandSums:
    """Scratch for the bands of the loads on this number of ``bodies``, and for the nodes that are
    ``gathered``."""
    drifts = gathered.per_cell > 0
    drifting = int(np.diff(bands.span[bands.sets])[drifts].max(initial=0)) if drifts.any() else 0
    return BandSums(
        np.full((2, bodies), np.nan),
        np.zeros((24, bands.omega.size)),
        np.zeros((12, bands.omega.size)),
        np.zeros((4, bands.omega.size)),
        np.zeros((2, bands.omega.size)),
        np.zeros(bands.omega.size),
        np.zeros(2 * STENCIL_POINTS * drifting),
        transfer.new_node_sums(gathered),
        np.zeros(quadratic_loads.DRIFT_STENCIL_POINTS),
        _new_columns(STENCIL_POINTS, 12, bands.load),
        _new_columns(quadratic_loads.DRIFT_STENCIL_POINTS, 6, bands.drift),
    )


def _new_columns(points: int, entries: int, table: np.ndarray) -> Columns:
    """Columns for bands with this place (n,) in a table; none if no band has any."""
    shape = (points + SPARE, entries, table.size if np.any(table != NO_LOAD) else 0)
    return Columns(np.zeros(shape), np.full((shape[0], shape[2]), NO_HEADING_NODE))


@kernel
def has_bands(k, bands):
    """True if the waves on the k-th body are summed in bands."""
    return bands.sets[k + 1] > bands.sets[k]


@root
def weigh_bands(k, yaw, end, p, work):
    """Compute the factors of the bands of the k-th body at this yaw, for the ``end`` of
    ``work``."""
    if work.yaw[end, k] == yaw:
        return
    work.yaw[end, k] = yaw
    bands = p.bands
    first = bands.span[bands.sets[k]]
    stop = bands.span[bands.sets[k + 1]]
    while first < stop:
        last = first + 1
        while last < stop and bands.heading[last] == bands.heading[first]:
            last += 1
        to = bands.heading[first] - p.rest[k] - yaw
        if work.loads.known.size > 0:
            x = to * p.nodes[k] / (2.0 * pi)
            node = floor(x) - STENCIL_POINTS // 2 + 1
            for m in range(STENCIL_POINTS):
                column = (node + m) % work.loads.known.shape[0]
                if work.loads.known[column, first] != node + m:
                    work.loads.known[column, first] = node + m
                    at = p.first[k] + ENTRIES_PER_LOAD * ((node + m) % p.nodes[k])
                    copy_loads(first, last, at, bands.load, p.load, work.loads.values[column])
                work.weight[m] = lagrange(x - node, m, STENCIL_POINTS)
            for j in range(12):
                row = work.load[12 * end + j, first:last]
                _weigh_columns(node, work.weight[:STENCIL_POINTS], j, first, work.loads.values, row)
        if work.drifts.known.size > 0:
            x = to * p.second.nodes[k] / (2.0 * pi)
            node = floor(x) - quadratic_loads.DRIFT_STENCIL_POINTS // 2 + 1
            for m in range(quadratic_loads.DRIFT_STENCIL_POINTS):
                column = (node + m) % work.drifts.known.shape[0]
                if work.drifts.known[column, first] != node + m:
                    work.drifts.known[column, first] = node + m
                    at = p.second.table[k] + ENTRIES_PER_LOAD * ((node + m) % p.second.nodes[k])
                    table = p.second.drift
                    copy_drifts(first, last, at, bands.drift, table, work.drifts.values[column])
                work.weight[m] = lagrange(x - node, m, quadratic_loads.DRIFT_STENCIL_POINTS)
            for j in range(6):
                row = work.drift[6 * end + j, first:last]
                _weigh_columns(node, work.weight, j, first, work.drifts.values, row)
        first = last


@kernel
def copy_loads(first, last, at, entry, table, out):
    """Copy the entries of bands from the node ``at`` of a complex ``table`` into a column (12,
    n)."""
    for n in range(first, last):
        for j in range(6):
            value = table[at + entry[n] + j] if entry[n] != NO_LOAD else 0.0j
            out[2 * j, n] = value.real
            out[2 * j + 1, n] = value.imag


@kernel
def copy_drifts(first, last, at, entry, table, out):
    """Copy the entries of bands from the node ``at`` of a real ``table`` into a column (6, n)."""
    for n in range(first, last):
        for j in range(6):
            out[j, n] = table[at + entry[n] + j] if entry[n] != NO_LOAD else 0.0


@kernel
def _weigh_columns(node, weight, j, first, columns, out):
    """Entry j of bands from the one numbered ``first`` on, into ``out`` (n,): the weighted sum over
    columns of nodes of heading from ``node`` on."""
    ring = columns.shape[0]
    clear(out)
    for m in range(0, weight.size, 2):
        column = columns[(node + m) % ring, j, first : first + out.size]
        other = columns[(node + m + 1) % ring, j, first : first + out.size]
        _add_two(weight[m], column, weight[m + 1], other, out)


@summing
def _add_two(first, near, second, far, out):
    for i in range(out.size):
        out[i] += first * near[i] + second * far[i]


@root
def interpolate_path(k, t, middle, apart, path, p, work):
    """Envelopes of a body that drifts, at `STENCIL_POINTS` times ``apart``, from t on. The block is
    about the time ``middle``; ``path`` has the displacement at t and the velocity."""
    bands = p.bands
    since = middle - t
    transfer.gather_waves(
        k, middle, path[0] + since * path[2], path[1] + since * path[3], p, work.nodes
    )
    clear(work.envelope)
    transfer.fill_envelopes(k, t, apart, path, p, work.nodes, work.envelope)
    find_phases(k, t, apart, path, bands, work)
    start = bands.span[bands.sets[k]]
    for s in range(STENCIL_POINTS):
        for i in range(bands.sets[k], bands.sets[k + 1]):
            low = bands.span[i]
            high = bands.span[i + 1]
            at = 2 * STENCIL_POINTS * (low - start) + 2 * (high - low) * s
            re = work.envelope[at : at + high - low]
            im = work.envelope[at + high - low : at + 2 * (high - low)]
            turn_back(work.phase[0, low:high], work.phase[1, low:high], re, im)
        turn_phases(k, bands, work)


@kernel
def turn_phases(k, bands, work):
    """Turn the phases of `find_phases` by one interval."""
    low = bands.span[bands.sets[k]]
    high = bands.span[bands.sets[k + 1]]
    phase = work.phase
    rotate_phase(phase[2, low:high], phase[3, low:high], phase[0, low:high], phase[1, low:high])


@kernel
def find_phases(k, t, interval, path, bands, work):
    """Phases of the middles of bands at the time t, and their change in an ``interval``."""
    for n in range(bands.span[bands.sets[k]], bands.span[bands.sets[k + 1]]):
        angle = bands.omega[n] * t - bands.kx[n] * path[0] - bands.ky[n] * path[1]
        met = bands.omega[n] - bands.kx[n] * path[2] - bands.ky[n] * path[3]
        work.phase[0, n] = cos(angle)
        work.phase[1, n] = sin(angle)
        work.phase[2, n] = cos(met * interval)
        work.phase[3, n] = sin(met * interval)


@root
def add_bands(k, t, part, sample, p, work, first, second):
    """Add the loads of both orders at the time t on the k-th body to ``first`` and ``second`` (6,),
    in heading axes; ``part`` is the fraction of the way between the loads at the two yaws. The time
    is ``sample`` samples behind the first one of `interpolate_path`."""
    bands = p.bands
    drifts = transfer.has_nodes(k, p.gathered)
    start = bands.span[bands.sets[k]]
    for s in range(bands.sets[k], bands.sets[k + 1]):
        low = bands.span[s]
        high = bands.span[s + 1]
        grown = rise(t, bands.ramp[s])
        if drifts:
            at = 2 * STENCIL_POINTS * (low - start)
            _find_values(sample, 0, STENCIL_POINTS, at, low, high, work.envelope, work)
        else:
            x = t / bands.step[s]
            before = floor(x) - STENCIL_POINTS // 2 + 1
            at = bands.table[s]
            _find_values(x - before, before, bands.times[s], at, low, high, bands.values, work)
        add_waves(grown, part, low, high, work.load, work.value, first)
        if bands.pairing[s] == quadratic_loads.DIFFERENCE:
            pair_values(bands.share[low:high], low, high, work)
        elif bands.pairing[s] == quadratic_loads.MEAN:
            assign(work.paired[low:high], bands.energy[low:high])
        if bands.pairing[s] != NO_LOAD:
            _add_drift(grown * grown, part, low, high, work.drift, work.paired, second)


@kernel
def _find_values(x, before, times, table, low, high, values, work):
    """E_f of the bands of a set, x samples behind the one numbered ``before``, out of ``times``
    that repeat, from ``table`` on in ``values``."""
    size = high - low
    re = work.value[0, low:high]
    im = work.value[1, low:high]
    clear(re)
    clear(im)
    for m in range(0, STENCIL_POINTS, 2):
        a = table + 2 * size * ((before + m) % times)
        b = table + 2 * size * ((before + m + 1) % times)
        weights = lagrange(x, m, STENCIL_POINTS)
        other = lagrange(x, m + 1, STENCIL_POINTS)
        _add_two(weights, values[a : a + size], other, values[b : b + size], re)
        a += size
        b += size
        _add_two(weights, values[a : a + size], other, values[b : b + size], im)
    rotate_phase(work.phase[0, low:high], work.phase[1, low:high], re, im)


@summing
def pair_values(share, low, high, work):
    """Re(z* E_f) of bands; z is the sum over the bands that are parts of the elevation."""
    re = work.value[0, low:high]
    im = work.value[1, low:high]
    paired = work.paired[low:high]
    z_re = 0.0
    z_im = 0.0
    for i in range(share.size):
        z_re += share[i] * re[i]
        z_im += share[i] * im[i]
    for i in range(share.size):
        paired[i] = z_re * re[i] + z_im * im[i]


@summing
def _add_drift(grown, part, low, high, drift, paired, row):
    """Add the second-order loads of bands to a row."""
    y = paired[low:high]
    for j in range(6):
        d0 = drift[j, low:high]
        d1 = drift[6 + j, low:high]
        first_sum = 0.0
        other = 0.0
        for i in range(y.size):
            first_sum += d0[i] * y[i]
        if part != 0.0:
            for i in range(y.size):
                other += d1[i] * y[i]
        row[j] += grown * ((1.0 - part) * first_sum + part * other)


@summing
def add_waves(ramp, part, first, last, ends, waves, row):
    """Add the loads of the waves, or bands, with indices ``first`` <= i < ``last`` to a row."""
    c, s = waves[0, first:last], waves[1, first:last]
    for j in range(6):
        re0, im0 = ends[2 * j, first:last], ends[2 * j + 1, first:last]
        re1, im1 = ends[12 + 2 * j, first:last], ends[13 + 2 * j, first:last]
        first_wave, second_wave = 0.0, 0.0
        for i in range(c.size):
            first_wave += c[i] * re0[i] - s[i] * im0[i]
        if part != 0.0:
            for i in range(c.size):
                second_wave += c[i] * re1[i] - s[i] * im1[i]
        row[j] += ramp * ((1.0 - part) * first_wave + part * second_wave)


@summing
def rotate_phase(c, s, re, im):
    """Multiply re + i im by c + i s, in place."""
    for i in range(c.size):
        real = re[i] * c[i] - im[i] * s[i]
        im[i] = re[i] * s[i] + im[i] * c[i]
        re[i] = real


@summing
def turn_back(c, s, re, im):
    """Multiply re + i im by c - i s, in place."""
    for i in range(c.size):
        real = re[i] * c[i] + im[i] * s[i]
        im[i] = im[i] * c[i] - re[i] * s[i]
        re[i] = real
