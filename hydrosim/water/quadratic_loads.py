"""Second-order loads of waves on a body that they follow: quadratic forms of filtered elevations.

    F-(t) = R(psi) Re sum_rs C_rs(psi) z_r conj(z_s),     F+(t) = R(psi) Re sum_rs C_rs(psi) z_r z_s
    z_r(t) = exp(-i h_r psi) sum_i W_ri(psi) a_i exp(i (w_i t - k_i . d))

as in `second_order`, for a body that has moved by d and turned by psi. Each z_r is one sum over the
waves, so that no pair of them is ever formed. Both d and psi enter every term.

* Newman's approximation and the mean load have the drift D(w_i, b_i - psi) among their weights W,
  and a constant C. Between headings D is read from a finer table, by 10-point Lagrange polynomials
  through sixteen nodes per heading of the database. The error is below 1e-10 of its highest
  harmonic.
* For a quadratic transfer function W are B-splines over the frequency. Either C is a trigonometric
  polynomial of psi, or psi turns the phase of the harmonics h_r (`turned_qtf`). Both are exact if
  the headings of the database are evenly spaced.
"""

from __future__ import annotations

from itertools import accumulate, pairwise
from math import cos, floor, pi, sin, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.jit.kernels import clear, kernel, root, summing
from hydrosim.scene import Place, SecondOrder, WaveForces
from hydrosim.water import second_order
from hydrosim.water.loads import lagrange, rise
from hydrosim.water.transfer import drift_above, drift_table

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from hydrosim.water.body import WaveBody

DIFFERENCE, SUM, MEAN = range(3)
"""Kinds of forms: pairs of waves at their difference or sum frequencies, or each wave with
itself."""
WEIGHTED_AS_GIVEN, ONE, DRIFT, PLUS, MINUS = range(5)
"""Weights of a filter: given, 1, drift of a DOF, roots of its positive or its negative values."""
DRIFT_STENCIL_POINTS = 10
DRIFT_NODES_PER_HEADING = 16  # nodes of heading per heading of the database
DOFS = range(6)


class Forms(NamedTuple):
    """The forms of all bodies that waves follow, body by body.

    ``filters`` and ``forms`` (nb + 1,) give the first ones of each body. A filter reads the waves
    ``begin`` to ``end`` of its body. A form uses the filters ``span`` (nq, 2) of its body. The
    ``harmonics`` of C, (6, r, r) each, from the lowest on, are in ``core`` from ``first`` on. Drift
    is ``factor`` (nw, 2) times the values of ``drift`` at two of its frequencies.
    """

    filters: np.ndarray
    kind: np.ndarray
    dof: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    harmonic: np.ndarray
    ramp: np.ndarray  # [s]
    at: np.ndarray  # first of the given weights
    weight: np.ndarray  # complex
    forms: np.ndarray
    span: np.ndarray
    pairing: np.ndarray
    harmonics: np.ndarray
    first: np.ndarray
    core: np.ndarray  # complex
    wave: np.ndarray  # (nw,) complex elevation at the centre of gravity at rest
    drifts: np.ndarray  # (nb,) true if drift is needed
    nodes: np.ndarray  # (nb,) nodes of heading round the circle
    table: np.ndarray  # (nb,) first entry of the body's drift, the same for equal bodies
    cell: np.ndarray  # (nw, 2)
    part: np.ndarray  # (nw, 2) of the cell
    width: np.ndarray  # (nw, 2) of the cell [rad/s]
    factor: np.ndarray
    drift: np.ndarray


class Filter(NamedTuple):
    """One filter of a body, with its ``weights`` if they are given."""

    kind: int
    begin: int
    end: int
    ramp: float
    dof: int = 0
    harmonic: int = 0
    weights: np.ndarray = np.zeros(0, complex)


class QuadraticForm(NamedTuple):
    """One form of a body: its filters, and ``core`` (harmonics, 6, r, r)."""

    pairing: int
    filters: list[Filter]
    core: np.ndarray


class Drift(NamedTuple):
    """Mean drift of waves: cells of the ``table`` (nf, nodes, 2, 6) and factors, (nw, 2) each."""

    cell: np.ndarray
    part: np.ndarray
    width: np.ndarray
    factor: np.ndarray
    table: np.ndarray


class BodyForms(NamedTuple):
    """Filters, forms and drift of the second-order loads on one body."""

    wave: np.ndarray
    forms: list[QuadraticForm]
    drift: Drift


class Waves(NamedTuple):
    """The waves of all seas that load a body, (nw,) each. ``sea`` numbers the seas; the waves of
    one sea are adjacent. ``heading`` is relative to the body at rest."""

    sea: np.ndarray
    omega: np.ndarray
    wavenumber: np.ndarray
    heading: np.ndarray
    ramp: np.ndarray


def has_moving_second_order(body: WaveBody) -> bool:
    """True if second-order loads move with a body that the waves follow."""
    wanted = body.wave_forces
    second = wanted.second_order != SecondOrder.NONE or wanted.sum_frequency
    return body.database is not None and second and not _is_fixed(wanted, body.database)


def uses_second_order_at_rest(
    wanted: WaveForces, database: second_order.QuadraticFunctions
) -> bool:
    """True if second-order loads on a turning body are those of its heading at rest."""
    second = wanted.second_order != SecondOrder.NONE or wanted.sum_frequency
    return second and (wanted.headings == Place.MEAN or _is_fixed(wanted, database))


def _is_fixed(wanted: WaveForces, database: second_order.QuadraticFunctions) -> bool:
    """True if the loads are known for a few headings only, as QTFs may be."""
    quadratic = wanted.second_order == SecondOrder.QTF or wanted.sum_frequency
    return quadratic and not second_order.has_qtf_around(database)


def body_forms(body: WaveBody, waves: Waves, elevation: np.ndarray) -> BodyForms:
    """The forms of a body in these waves of complex ``elevation`` (nw,) at its position at rest."""
    database = body.database
    if database is None or not has_moving_second_order(body):
        return BodyForms(elevation, [], no_drift(waves.omega.size))
    wanted = body.wave_forces.second_order
    forms: list[QuadraticForm] = []
    for number in np.unique(waves.sea):
        at = np.flatnonzero(waves.sea == number)
        ends = (int(at[0]), int(at[-1]) + 1, float(waves.ramp[at[0]]))
        if wanted == SecondOrder.QTF:
            forms.extend(_quadratic_forms(database, waves, at, "qtf_difference"))
        forms.extend(_drift_forms(wanted, *ends))
        if body.wave_forces.sum_frequency:
            forms.extend(_quadratic_forms(database, waves, at, "qtf_sum"))
    drift = no_drift(waves.omega.size)
    if wanted == SecondOrder.QTF and database.mean_drift is not None:
        drift = _drift_beyond(database, waves.omega)
    elif wanted not in (SecondOrder.NONE, SecondOrder.QTF):
        drift = _drift_of_database(database, waves.omega)
    return BodyForms(elevation, forms, drift)


def _drift_forms(wanted: SecondOrder, begin: int, end: int, ramp: float) -> Iterator[QuadraticForm]:
    """The forms of mean drift, for the waves with indices ``begin`` <= i < ``end``."""
    unit_filter = Filter(ONE, begin, end, ramp)
    nothing = np.zeros((1, 6))
    match wanted:
        case SecondOrder.MEAN_DRIFT:
            yield QuadraticForm(MEAN, [unit_filter], np.zeros((0, 6, 1, 1)))
        case SecondOrder.NEWMAN | SecondOrder.QTF:
            filters_by_dof = [Filter(DRIFT, begin, end, ramp, dof) for dof in DOFS]
            yield QuadraticForm(
                DIFFERENCE, [unit_filter, *filters_by_dof], second_order.newman(nothing).core[None]
            )
        case SecondOrder.NEWMAN_SQUARE_ROOT:
            filters_by_dof = [
                Filter(kind, begin, end, ramp, dof) for kind in (PLUS, MINUS) for dof in DOFS
            ]
            yield QuadraticForm(
                DIFFERENCE, filters_by_dof, second_order.newman_square_root(nothing).core[None]
            )


def _quadratic_forms(
    database: second_order.QuadraticFunctions, waves: Waves, at: np.ndarray, name: str
) -> Iterator[QuadraticForm]:
    """The forms of a quadratic transfer function, for the waves ``at`` (n,) of one sea."""
    pairing = DIFFERENCE if name == "qtf_difference" else SUM
    for qtf in second_order.turned_qtf(database, waves.omega[at], waves.heading[at], name):
        filters = [
            Filter(
                WEIGHTED_AS_GIVEN,
                int(at[0]) + turned.begin,
                int(at[0]) + turned.begin + turned.weights.size,
                float(waves.ramp[at[0]]),
                harmonic=turned.harmonic,
                weights=turned.weights,
            )
            for turned in qtf.filters
        ]
        yield QuadraticForm(pairing, filters, qtf.core)


def no_drift(waves: int) -> Drift:
    """Zero drift for all waves."""
    nothing = np.zeros((waves, 2))
    return Drift(nothing.astype(np.int64), nothing, nothing, nothing, np.zeros((0, 0, 2, 6)))


def _drift_of_database(database: second_order.QuadraticFunctions, omega: np.ndarray) -> Drift:
    """D of every wave at its own frequency; the second factor is zero."""
    w, table = drift_table(database, DRIFT_NODES_PER_HEADING)
    factor = np.stack([drift_above(database, omega), np.zeros(omega.size)], axis=1)
    return Drift(*cells_of(w, np.stack([omega, omega], axis=1)), factor, table)


def _drift_beyond(database: second_order.QuadraticFunctions, omega: np.ndarray) -> Drift:
    """D of every wave minus D at the nearest frequency of the QTF."""
    frequencies = np.asarray(database.qtf_frequency)
    ends = np.clip(omega, frequencies[0], frequencies[-1])
    if np.array_equal(ends, omega):
        return no_drift(omega.size)
    w, table = drift_table(database, DRIFT_NODES_PER_HEADING)
    both = np.stack([omega, ends], axis=1)
    factor = np.stack([drift_above(database, omega), -drift_above(database, ends)], axis=1)
    factor[ends == omega] = 0.0
    return Drift(*cells_of(w, both), factor, table)


def cells_of(w: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells of rising frequencies ``w`` that hold ``omega``, the relative position in each, and
    their widths."""
    inside = np.clip(omega, w[0], w[-1])
    cell = np.clip(np.searchsorted(w, inside, side="right") - 1, 0, w.size - 2)
    width = np.diff(w)[cell]
    return cell.astype(np.int64), (inside - w[cell]) / width, width


def forms_model(bodies: list[BodyForms]) -> Forms:
    """The forms of all bodies as arrays."""
    # forms without the drift that they consist of are zero
    used = [[form for form in body.forms if _may_load_body(form, body.drift)] for body in bodies]
    forms = [form for body_forms in used for form in body_forms]
    filters = [filter_ for form in forms for filter_ in form.filters]
    spans = [span for body_forms in used for span in _spans_of_forms(body_forms)]
    tables = [body.drift.table for body in bodies]
    table, drift = join_once(tables, float)

    def join_fields(name: str, kind: type = float) -> np.ndarray:
        return np.concatenate(
            [np.zeros((0, 2), kind), *(getattr(body.drift, name) for body in bodies)]
        )

    def column(name: str, kind: type = np.int64) -> np.ndarray:
        return np.array([getattr(filter_, name) for filter_ in filters], dtype=kind)

    return Forms(
        filters=np.cumsum(
            [0, *(sum(len(form.filters) for form in body_forms) for body_forms in used)]
        ),
        kind=column("kind"),
        dof=column("dof"),
        begin=column("begin"),
        end=column("end"),
        harmonic=column("harmonic"),
        ramp=column("ramp", float),
        at=np.cumsum([0, *(filter_.weights.size for filter_ in filters)])[: len(filters)],
        weight=np.concatenate([np.zeros(0, complex), *(filter_.weights for filter_ in filters)]),
        forms=np.cumsum([0, *map(len, used)]),
        span=np.array(spans, dtype=np.int64).reshape(-1, 2),
        pairing=np.array([form.pairing for form in forms], dtype=np.int64),
        harmonics=np.array([len(form.core) for form in forms], dtype=np.int64),
        first=np.cumsum([0, *(form.core.size for form in forms)])[: len(forms)],
        core=np.concatenate([np.zeros(0, complex), *(form.core.ravel() for form in forms)]),
        wave=np.concatenate([np.zeros(0, complex), *(body.wave for body in bodies)]),
        drifts=np.array([bool(np.any(body.drift.factor)) for body in bodies], dtype=bool),
        nodes=np.array([table.shape[1] for table in tables], dtype=np.int64),
        table=table,
        cell=join_fields("cell", np.int64),
        part=join_fields("part"),
        width=join_fields("width"),
        factor=join_fields("factor"),
        drift=drift,
    )


def join_once(tables: Sequence[np.ndarray], kind: type) -> tuple[np.ndarray, np.ndarray]:
    """Start (nb,) of each of the ``tables`` in one array of their values, and that array. Tables
    that several equal bodies share are stored once."""
    distinct = {id(table): table.ravel() for table in tables}
    begin = accumulate((values.size for values in distinct.values()), initial=0)
    begins = dict(zip(distinct, begin, strict=False))
    at = np.array([begins[id(table)] for table in tables], dtype=np.int64)
    return at, np.concatenate([np.zeros(0, kind), *distinct.values()])


def _may_load_body(form: QuadraticForm, drift: Drift) -> bool:
    """True if a form may load the body; a form of drift does so only if there is drift."""
    given = all(filter_.kind == WEIGHTED_AS_GIVEN for filter_ in form.filters)
    return given or bool(np.any(drift.factor))


def _spans_of_forms(forms: list[QuadraticForm]) -> list[tuple[int, int]]:
    ends = np.cumsum([0, *(len(form.filters) for form in forms)])
    return [(int(first), int(last)) for first, last in pairwise(ends)]


class Filtered(NamedTuple):
    """Scratch: for every wave its ``amplitude`` (2, nw), real and imaginary, and ``drift`` (6, nw);
    cells of the table of drift. For one or two yaws: ``weighted`` amplitudes of all filters (2, 2,
    m), ``core`` (2, m) and mean loads ``steady`` (2, nq, 6). ``z`` of all filters."""

    amplitude: np.ndarray
    drift: np.ndarray
    cell: np.ndarray
    weighted: np.ndarray
    core: np.ndarray
    steady: np.ndarray
    z: np.ndarray


def new_filtered(p: Forms, offset: np.ndarray) -> Filtered:
    """Scratch for these forms; the waves of the bodies begin at ``offset`` (nb + 1,)."""
    used = np.diff(p.forms) > 0
    waves = int(np.diff(offset)[used].max(initial=0))
    size = np.zeros(used.size, dtype=np.int64)
    core = np.zeros(used.size, dtype=np.int64)
    for k in range(used.size):
        filters = slice(p.filters[k], p.filters[k + 1])
        size[k] = np.sum(p.end[filters] - p.begin[filters])
        core[k] = np.sum(6 * np.diff(p.span[p.forms[k] : p.forms[k + 1]]) ** 2)
    return Filtered(
        np.zeros((2, waves)),
        np.zeros((6, waves)),
        np.zeros((2, 2, 2, 6)),
        np.zeros((2, 2, int(size.max(initial=0)))),
        np.zeros((2, int(core.max(initial=0))), complex),
        np.zeros((2, int(np.diff(p.forms).max(initial=0)), 6)),
        np.zeros(int(np.diff(p.filters).max(initial=0)), complex),
    )


@kernel
def has_forms(k, forms):
    """True if the k-th body has second-order loads at its displaced position."""
    return forms.forms[k + 1] > forms.forms[k]


@root
def fill_load_factors(k, yaw, end, p, work):
    """Compute the factors of the loads on the k-th body at this yaw, for the ``end`` of
    ``work``."""
    forms = p.second
    start = p.offset[k]
    count = p.offset[k + 1] - start
    x = p.centre[k, 0]
    y = p.centre[k, 1]
    for i in range(count):
        n = start + i
        to = p.heading[n] - p.rest[k] - yaw
        shift = p.wavenumber[n] * (x * cos(to) + y * sin(to))
        a = forms.wave[n] * (cos(shift) + 1j * sin(shift))
        work.amplitude[0, i] = a.real
        work.amplitude[1, i] = a.imag
    if forms.drifts[k]:
        _find_drift(k, yaw, p, work)
    at = 0
    for f in range(forms.filters[k], forms.filters[k + 1]):
        _weigh_form(f, yaw, at, work.weighted[end], forms, work)
        at += forms.end[f] - forms.begin[f]
    at = 0
    for q in range(forms.forms[k], forms.forms[k + 1]):
        if forms.pairing[q] == MEAN:
            _find_mean(q, forms.filters[k], work.steady[end, q - forms.forms[k]], forms, work)
        else:
            size = 6 * (forms.span[q, 1] - forms.span[q, 0]) ** 2
            _find_core(q, yaw, forms, work.core[end, at : at + size])
            at += size


@kernel
def _find_drift(k, yaw, p, work):
    """Drift of every wave at this yaw."""
    forms = p.second
    start = p.offset[k]
    last = (-1, -1)
    seen = (0.0, 0.0)
    for i in range(p.offset[k + 1] - start):
        n = start + i
        heading = p.heading[n]
        to = heading - p.rest[k] - yaw
        for j in range(6):
            work.drift[j, i] = 0.0
        for side in range(2):
            if forms.factor[n, side] != 0.0:
                f = forms.cell[n, side]
                if f != last[side] or heading != seen[side]:
                    first = forms.table[k]
                    cell_at(
                        f,
                        to,
                        forms.nodes[k],
                        first,
                        DRIFT_STENCIL_POINTS,
                        forms.drift,
                        work.cell[side],
                    )
                    last = (f, last[1]) if side == 0 else (last[0], f)
                    seen = (heading, seen[1]) if side == 0 else (seen[0], heading)
                _add_drift(n, side, forms, work.cell[side], work.drift[:, i])


@kernel
def _add_drift(n, side, forms, cell, drift):
    """Add the drift of wave ``n`` at one of its two frequencies."""
    u = forms.part[n, side]
    h = forms.width[n, side]
    v = 1.0 - u
    factor = forms.factor[n, side]
    for j in range(6):
        value = v * v * (1.0 + 2.0 * u) * cell[0, 0, j] + u * u * (1.0 + 2.0 * v) * cell[1, 0, j]
        value += h * u * v * (v * cell[0, 1, j] - u * cell[1, 1, j])
        drift[j] += factor * value


@kernel
def cell_at(f, to, nodes, first, points, table, cell):
    """Values and slopes of a ``table`` (nf, nodes, 2, 6) that begins at ``first``, at both ends of
    its cell ``f``, for waves ``to`` this heading."""
    x = to * nodes / (2.0 * pi)
    node = floor(x) - points // 2 + 1
    for end in range(2):
        for what in range(2):
            clear(cell[end, what])
    for m in range(points):
        weight = lagrange(x - node, m, points)
        for end in range(2):
            at = first + 12 * ((f + end) * nodes + (node + m) % nodes)
            for what in range(2):
                for j in range(6):
                    cell[end, what, j] += weight * table[at + 6 * what + j]


@kernel
def _weigh_form(f, yaw, at, out, forms, work):
    """Amplitudes times weights of filter ``f``, from ``at`` on, into ``out`` (2, m)."""
    turn = cos(forms.harmonic[f] * yaw) - 1j * sin(forms.harmonic[f] * yaw)
    kind = forms.kind[f]
    for i in range(forms.begin[f], forms.end[f]):
        weight = turn
        if kind == WEIGHTED_AS_GIVEN:
            weight *= forms.weight[forms.at[f] + i - forms.begin[f]]
        elif kind == DRIFT:
            weight *= work.drift[forms.dof[f], i]
        elif kind == PLUS:
            weight *= sqrt(max(work.drift[forms.dof[f], i], 0.0))
        elif kind == MINUS:
            weight *= sqrt(max(-work.drift[forms.dof[f], i], 0.0))
        a = weight * (work.amplitude[0, i] + 1j * work.amplitude[1, i])
        out[0, at + i - forms.begin[f]] = a.real
        out[1, at + i - forms.begin[f]] = a.imag


@kernel
def _find_mean(q, filters, out, forms, work):
    """Loads of every wave with itself into ``out`` (6,)."""
    f = filters + forms.span[q, 0]
    clear(out)
    for i in range(forms.begin[f], forms.end[f]):
        energy = work.amplitude[0, i] ** 2 + work.amplitude[1, i] ** 2
        for j in range(6):
            out[j] += energy * work.drift[j, i]


@kernel
def _find_core(q, yaw, forms, out):
    """C of form ``q`` at this yaw."""
    for i in range(out.size):
        out[i] = 0.0
    lowest = -(forms.harmonics[q] // 2)
    for m in range(forms.harmonics[q]):
        angle = (lowest + m) * yaw
        at = forms.first[q] + m * out.size
        _add_multiple(cos(angle) - 1j * sin(angle), forms.core[at : at + out.size], out)


@summing
def _add_multiple(factor, values, out):
    for i in range(out.size):
        out[i] += factor * values[i]


@root
def add_forms(k, t, end, share, waves, forms, work, out):
    """Add a ``share`` of the loads on the k-th body to ``out`` (6,), in heading axes, from the
    factors of `fill_load_factors`; ``waves`` (2, nw) are cos and sin of their phases."""
    first = forms.filters[k]
    at = 0
    for f in range(first, forms.filters[k + 1]):
        begin = forms.begin[f]
        last = forms.end[f]
        re = work.weighted[end, 0, at : at + last - begin]
        im = work.weighted[end, 1, at : at + last - begin]
        z = _complex_product_sum(waves[0, begin:last], waves[1, begin:last], re, im)
        work.z[f - first] = rise(t, forms.ramp[f]) * z
        at += last - begin
    at = 0
    for q in range(forms.forms[k], forms.forms[k + 1]):
        low = forms.span[q, 0]
        count = forms.span[q, 1] - low
        if forms.pairing[q] == MEAN:
            grown = rise(t, forms.ramp[first + low])
            for j in range(6):
                out[j] += share * grown * grown * work.steady[end, q - forms.forms[k], j]
        else:
            z = work.z[low : low + count]
            sign = 1.0 if forms.pairing[q] == SUM else -1.0
            for j in range(6):
                out[j] += share * _pair_sum(work.core[end, at : at + count * count], z, sign)
                at += count * count


@summing
def _complex_product_sum(c, s, re, im):
    """sum (c + i s) (re + i im)."""
    real = 0.0
    imag = 0.0
    for i in range(c.size):
        real += c[i] * re[i] - s[i] * im[i]
        imag += c[i] * im[i] + s[i] * re[i]
    return real + 1j * imag


@summing
def _pair_sum(core, z, sign):
    """Re sum C_rs z_r z_s, the second of each pair conjugate where ``sign`` is -1."""
    total = 0.0
    for r in range(z.size):
        pair = 0.0j
        for s in range(z.size):
            pair += core[r * z.size + s] * (z[s].real + 1j * sign * z[s].imag)
        total += (z[r] * pair).real
    return total
