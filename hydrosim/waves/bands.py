"""Waves of few headings on a body that yaws slowly and does not drift: sums over the frequencies of
its database, which are fewer than the waves.

    F1(t, psi) = Re sum_f X_f(b - psi) E_f(t) + X'_f(b - psi) S_f(t)
    F2(t, psi) =    sum_f D_f(b - psi) Re(z* E_f(t)) + D'_f(b - psi) Re(z* S_f(t)),    z = sum_f E_f
    E_f(t) = sum_i H_f(w_i) a_i exp(i w_i t),    S_f(t) = sum_i G_f(w_i) a_i exp(i w_i t)

Between two frequencies of a database its loads are cubic polynomials of the values X_f, D_f and the
slopes X'_f, D'_f there. H_f and G_f are the Hermite polynomials, non-zero only in the two cells
beside f. So these sums equal the sums over waves of `slow` at every yaw, and no E_f or S_f depends
on the yaw. F2 is Newman's approximation; for the mean load, sum_i H_f |a_i|^2 replaces z* E_f.

A band is one E_f or S_f. It is narrow. So its envelope E_f(t) exp(-i w_b t), about a frequency w_b
in its middle, is stored at few times of the repeat period. It is interpolated by 6-point Lagrange
polynomials, whose error is below 3e-9 for each wave. The envelopes are made by FFT.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, cos, floor, pi, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from hydrosim.jit.kernels import assign, clear, kernel, root, summing
from hydrosim.scene import Place, SecondOrder
from hydrosim.waves.forms import DIFFERENCE, MEAN, cells_of, moves_second_order
from hydrosim.waves.forms import POINTS as DRIFT_POINTS
from hydrosim.waves.loads import POINTS, lagrange, rise

if TYPE_CHECKING:
    from hydrosim.waves.body import WaveBody
    from hydrosim.waves.components import Components
    from hydrosim.waves.forms import BodyForms, Waves

PHASE = 0.09
"""Largest turn of a wave's phase [rad] about the middle of its band between two stored times."""
WORTH = 2  # fewest waves per band
TRAINS = 8  # most headings of a long-crested sea
WIDE = 3.0
"""Largest ratio of the widest cell of frequencies to the mean one; it sets the resolution of
envelopes."""
NONE = -1
VALUE, SLOPE, LOW, LOW_DRIFT = range(4)
"""Factor of a band: the value or the slope of X and D at a frequency of the database. Below all of
these, the first value of X alone, or of D alone, which fades to zero there."""
KINDS = 4
ENTRIES = 12  # of a frequency and a heading in a table of loads: six values, six slopes


class Bands(NamedTuple):
    """The bands of all bodies, body by body, in sets; the waves of a set belong to one sea.

    ``sets`` (nb + 1,) and ``span`` (ns + 1,) give the first set of each body and the first band of
    each set. The envelopes of a set, (times, 2, bands), real and imaginary, start at ``table`` in
    ``values``, ``step`` apart. The factor of a band at heading 0 starts at ``load`` in the body's
    table of X and at ``drift`` in the table of D; `NONE` if there is no such load.
    """

    sets: np.ndarray
    span: np.ndarray
    ramp: np.ndarray  # (ns,) [s]
    pairing: np.ndarray  # (ns,) of the second-order load, or NONE
    step: np.ndarray  # (ns,) [s]
    times: np.ndarray  # (ns,)
    table: np.ndarray  # (ns,)
    values: np.ndarray
    omega: np.ndarray  # (n,) in the middle
    heading: np.ndarray  # (n,)
    load: np.ndarray  # (n,)
    drift: np.ndarray  # (n,)
    share: np.ndarray  # (n,) 1 if it is a part of the elevation, else 0
    energy: np.ndarray  # (n,) sum of H |a|^2


class Set(NamedTuple):
    """The bands of one set, as in `Bands`; ``values`` (times, 2, n)."""

    ramp: float
    pairing: int
    step: float
    values: np.ndarray
    omega: np.ndarray
    heading: np.ndarray
    load: np.ndarray
    drift: np.ndarray
    share: np.ndarray
    energy: np.ndarray


def body_bands(
    body: WaveBody,
    seas: Sequence[Components],
    waves: Waves,
    forms: BodyForms,
    w: np.ndarray,
    nodes: int,
) -> list[Set]:
    """The bands of ``waves`` on a body, whose table of X has frequencies ``w`` (nf,) and ``nodes``
    headings. None if bands cannot represent the waves, or are not far fewer than the waves."""
    on_grid = all(one.spacing > 0.0 for one in seas)
    if not (on_grid and _has_bands(body) and _are_regular(waves, w)):
        return []
    found = []
    for number in np.unique(waves.sea):
        at = np.flatnonzero(waves.sea == number)
        found.append(_set(body, seas[number].spacing, waves, at, forms, w, nodes))
    few = WORTH * sum(one.omega.size for one in found) <= waves.omega.size
    return found if few else []


def _has_bands(body: WaveBody) -> bool:
    """True if bands can represent all loads on a body."""
    wanted = body.wave_forces
    stays = wanted.position == Place.MEAN and not np.any(body.centre[:2])
    turns = wanted.headings == Place.SLOW
    known = (SecondOrder.NONE, SecondOrder.NEWMAN, SecondOrder.MEAN_DRIFT)
    second = wanted.second_order in known and not wanted.sum_frequency
    return turns and stays and (second or not moves_second_order(body))


def _are_regular(waves: Waves, w: np.ndarray) -> bool:
    """True if the waves have few headings and lie in cells of ``w`` of similar width."""
    cells = np.unique(cells_of(w, waves.omega)[0])
    width = np.diff(w)[cells]
    even = bool(np.all(width <= WIDE * width.mean()))
    return even and np.unique(waves.heading).size <= TRAINS


def _set(
    body: WaveBody,
    spacing: float,
    waves: Waves,
    at: np.ndarray,
    forms: BodyForms,
    w: np.ndarray,
    nodes: int,
) -> Set:
    """The bands of the waves with indices ``at`` (n,), all of one sea."""
    omega = waves.omega[at]
    trains, train = np.unique(waves.heading[at], return_inverse=True)
    wave, key, weight = _shares(w, omega)
    lowest = key.min(initial=0)
    count = key.max(initial=0) - lowest + 1
    found, band = np.unique(train[wave] * count + key - lowest, return_inverse=True)
    slot, what = np.divmod(found % count + lowest, KINDS)
    inside = np.clip(slot, 0, w.size - 1)
    entry = 6 * (what == SLOPE)
    loads = (what != LOW_DRIFT) & (slot < w.size) & body.wave_forces.first_order
    drifts = (what != LOW) & bool(forms.forms)
    elevation = forms.wave[at[wave]]
    index = np.rint(omega / spacing).astype(np.int64)[wave]
    middle, times, values = _envelopes(index, band, weight * elevation)
    drift_nodes = forms.drift.table.shape[1]
    return Set(
        ramp=float(waves.ramp[at[0]]),
        pairing=forms.forms[0].pairing if forms.forms else NONE,
        step=2.0 * np.pi / (spacing * times),
        values=values,
        omega=spacing * middle,
        heading=body.heading + trains[found // count],
        load=np.where(loads, ENTRIES * nodes * inside + entry, NONE),
        drift=np.where(drifts, ENTRIES * drift_nodes * inside + entry, NONE),
        share=np.isin(what, (VALUE, LOW)).astype(float),
        energy=np.bincount(band, weight * np.abs(elevation) ** 2),
    )


def _shares(w: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shares (m,) of waves of ``omega`` (n,) in bands: index of the wave, key of the band, weight.

    A key is `KINDS` times a slot, plus the kind. A slot is the index of a frequency of ``w`` (nf,),
    or one of the slots, two cells wide, that continue below 0 and from nf on.
    """
    cell, u, h = cells_of(w, omega)
    v = 1.0 - u
    every = np.arange(omega.size)
    wide = 2.0 * h.max(initial=0.0)
    low = omega < w[0]
    high = omega > w[-1] * (1.0 + 1e-9)
    inside = ~(low | high)
    below = np.floor((omega - w[0]) / wide).astype(np.int64)
    above = w.size + np.floor((omega - w[-1]) / wide).astype(np.int64)
    shares = (
        (inside, cell, VALUE, v * v * (1.0 + 2.0 * u)),
        (inside, cell, SLOPE, h * u * v * v),
        (inside, cell + 1, VALUE, u * u * (1.0 + 2.0 * v)),
        (inside, cell + 1, SLOPE, -h * u * u * v),
        (low, below, LOW, np.ones(omega.size)),
        (low, below, LOW_DRIFT, omega / (w[0] or 1.0)),
        (high, above, VALUE, np.ones(omega.size)),
    )
    return (
        np.concatenate([every[chosen] for chosen, _, _, _ in shares]),
        np.concatenate([KINDS * slot[chosen] + kind for chosen, slot, kind, _ in shares]),
        np.concatenate([weight[chosen] for chosen, _, _, weight in shares]),
    )


def _envelopes(
    index: np.ndarray, band: np.ndarray, amplitude: np.ndarray
) -> tuple[np.ndarray, int, np.ndarray]:
    """Centre of every band as a multiple of the spacing, the number of times in the repeat period,
    and the envelopes (times, 2, bands), for waves of the multiples ``index`` (m,)."""
    count = band.max(initial=-1) + 1
    lowest = np.full(count, np.iinfo(np.int64).max)
    highest = np.zeros(count, dtype=np.int64)
    np.minimum.at(lowest, band, index)
    np.maximum.at(highest, band, index)
    middle = (lowest + highest) // 2
    off = index - middle[band]
    reach = np.abs(off).max(initial=0)
    times = scipy.fft.next_fast_len(ceil(2.0 * np.pi * reach / PHASE) + 1)
    spectrum = np.zeros((times, count), dtype=complex)
    np.add.at(spectrum, (off % times, band), amplitude)
    values = scipy.fft.ifft(spectrum, axis=0, norm="forward", overwrite_x=True)
    return middle, times, np.stack([values.real, values.imag], axis=1)


def bands_model(bodies: Sequence[Sequence[Set]]) -> Bands:
    """The bands of all bodies as arrays."""
    sets = [one for each in bodies for one in each]

    def of_sets(name: str, kind: type = float) -> np.ndarray:
        return np.array([getattr(one, name) for one in sets], dtype=kind)

    def joined(name: str, kind: type = float) -> np.ndarray:
        return np.concatenate([np.zeros(0, kind), *(getattr(one, name).ravel() for one in sets)])

    return Bands(
        sets=np.cumsum([0, *map(len, bodies)]),
        span=np.cumsum([0, *(one.omega.size for one in sets)]),
        ramp=of_sets("ramp"),
        pairing=of_sets("pairing", np.int64),
        step=of_sets("step"),
        times=np.array([len(one.values) for one in sets], dtype=np.int64),
        table=np.cumsum([0, *(one.values.size for one in sets)])[: len(sets)],
        values=joined("values"),
        omega=joined("omega"),
        heading=joined("heading"),
        load=joined("load", np.int64),
        drift=joined("drift", np.int64),
        share=joined("share"),
        energy=joined("energy"),
    )


class BandSums(NamedTuple):
    """Scratch for every band of a body: ``load`` (24, n), alternately real and imaginary, and
    ``drift`` (12, n) at two yaws; ``phase`` (4, n), cos and sin of the phase in its middle and of
    its change per row; ``value`` (2, n) of E_f; ``paired`` (n,), Re(z* E_f). Weight and table index
    of each ``node`` of heading, for X and D."""

    load: np.ndarray
    drift: np.ndarray
    phase: np.ndarray
    value: np.ndarray
    paired: np.ndarray
    weight: np.ndarray
    node: np.ndarray
    load_entry: np.ndarray
    drift_entry: np.ndarray


def new_band_sums(p: Bands) -> BandSums:
    """Scratch for these bands."""
    most = int(np.diff(p.span[p.sets]).max(initial=0))
    return BandSums(
        np.zeros((24, most)),
        np.zeros((12, most)),
        np.zeros((4, most)),
        np.zeros((2, most)),
        np.zeros(most),
        np.zeros((2, DRIFT_POINTS)),
        np.zeros((2, DRIFT_POINTS), dtype=np.int64),
        np.zeros(6, complex),
        np.zeros(6),
    )


@kernel
def has_bands(k, bands):
    """True if the waves on the k-th body are summed in bands."""
    return bands.sets[k + 1] > bands.sets[k]


@root
def weigh_bands(k, yaw, end, p, work):
    """Compute the factors of the bands of the k-th body at this yaw, for the ``end`` of
    ``work``."""
    bands = p.bands
    start = bands.span[bands.sets[k]]
    of_load = work.weight[0, :POINTS]
    of_drift = work.weight[1]
    for n in range(start, bands.span[bands.sets[k + 1]]):
        if n == start or bands.heading[n] != bands.heading[n - 1]:
            to = bands.heading[n] - p.rest[k] - yaw
            _weigh_nodes(to, p.nodes[k], work.node[0], of_load)
            _weigh_nodes(to, p.second.nodes[k], work.node[1], of_drift)
        clear(work.load_entry)
        clear(work.drift_entry)
        if bands.load[n] != NONE:
            at = p.first[k] + bands.load[n]
            _interpolate(at, p.load, work.node[0], of_load, work.load_entry)
        if bands.drift[n] != NONE:
            at = p.second.table[k] + bands.drift[n]
            _interpolate(at, p.second.drift, work.node[1], of_drift, work.drift_entry)
        for j in range(6):
            work.load[12 * end + 2 * j, n - start] = work.load_entry[j].real
            work.load[12 * end + 2 * j + 1, n - start] = work.load_entry[j].imag
            work.drift[6 * end + j, n - start] = work.drift_entry[j]


@kernel
def _weigh_nodes(to, nodes, node, weight):
    """Table indices and weights of the evenly spaced ``nodes`` of heading that interpolate waves
    ``to`` a heading."""
    x = to * nodes / (2.0 * pi)
    first = floor(x) - weight.size // 2 + 1
    for m in range(weight.size):
        node[m] = ENTRIES * ((first + m) % nodes)
        weight[m] = lagrange(x - first, m, weight.size)


@summing
def _interpolate(at, table, node, weight, out):
    """Add the interpolated values from the table entry ``at`` on, from this number of heading
    nodes."""
    for m in range(weight.size):
        share = weight[m]
        values = table[at + node[m] : at + node[m] + 6]
        for j in range(6):
            out[j] += share * values[j]


@kernel
def find_phases(k, t, interval, bands, work):
    """Phases of the middles of bands at the time t, and their change in an ``interval``."""
    start = bands.span[bands.sets[k]]
    for n in range(start, bands.span[bands.sets[k + 1]]):
        angle = bands.omega[n] * t
        turn = bands.omega[n] * interval
        work.phase[0, n - start] = cos(angle)
        work.phase[1, n - start] = sin(angle)
        work.phase[2, n - start] = cos(turn)
        work.phase[3, n - start] = sin(turn)


@root
def add_bands(k, t, part, bands, work, first, second):
    """Add the loads of both orders at the time t on the k-th body to ``first`` and ``second`` (6,),
    in heading axes; ``part`` is the fraction of the way between the loads at the two yaws."""
    start = bands.span[bands.sets[k]]
    for s in range(bands.sets[k], bands.sets[k + 1]):
        low = bands.span[s] - start
        high = bands.span[s + 1] - start
        grown = rise(t, bands.ramp[s])
        _find_values(s, t, low, high, bands, work)
        add_waves(grown, part, low, high, work.load, work.value, first)
        if bands.pairing[s] == DIFFERENCE:
            pair_values(bands.share[start + low : start + high], low, high, work)
        elif bands.pairing[s] == MEAN:
            assign(work.paired[low:high], bands.energy[start + low : start + high])
        if bands.pairing[s] != NONE:
            _add_drift(grown * grown, part, low, high, work.drift, work.paired, second)


@kernel
def _find_values(s, t, low, high, bands, work):
    """E_f at the time t of the bands of set ``s``, the bands ``low`` to ``high`` of their body."""
    x = t / bands.step[s]
    before = floor(x) - POINTS // 2 + 1
    size = high - low
    re = work.value[0, low:high]
    im = work.value[1, low:high]
    clear(re)
    clear(im)
    for m in range(POINTS):
        at = bands.table[s] + 2 * size * ((before + m) % bands.times[s])
        weight = lagrange(x - before, m, POINTS)
        _add_times(weight, bands.values[at : at + size], re)
        _add_times(weight, bands.values[at + size : at + 2 * size], im)
    turn(work.phase[0, low:high], work.phase[1, low:high], re, im)


@summing
def _add_times(weight, values, out):
    for i in range(out.size):
        out[i] += weight * values[i]


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
        one = 0.0
        other = 0.0
        for i in range(y.size):
            one += d0[i] * y[i]
            other += d1[i] * y[i]
        row[j] += grown * ((1.0 - part) * one + part * other)


@summing
def add_waves(ramp, part, first, last, ends, waves, row):
    """Add the loads of the waves, or bands, with indices ``first`` <= i < ``last`` to a row."""
    c, s = waves[0, first:last], waves[1, first:last]
    for j in range(6):
        re0, im0 = ends[2 * j, first:last], ends[2 * j + 1, first:last]
        re1, im1 = ends[12 + 2 * j, first:last], ends[13 + 2 * j, first:last]
        one, other = 0.0, 0.0
        for i in range(c.size):
            one += c[i] * re0[i] - s[i] * im0[i]
            other += c[i] * re1[i] - s[i] * im1[i]
        row[j] += ramp * ((1.0 - part) * one + part * other)


@summing
def turn(c, s, re, im):
    """Multiply re + i im by c + i s, in place."""
    for i in range(c.size):
        real = re[i] * c[i] - im[i] * s[i]
        im[i] = re[i] * s[i] + im[i] * c[i]
        re[i] = real
