"""Green function of a pulsating source in water of finite depth h.

It is the Green function of deep water at the same frequency, the image of the source in the sea
bed, and a smooth rest (John 1950, Comm. Pure Appl. Math. 3; Wehausen & Laitone 1960, eq. 13.18).
With nu = w^2/g = k tanh kh, q = (m + nu) / (m - nu), E = exp(-2 m h), v = z + zeta, u = z - zeta,
and R the horizontal distance,

    G      = 1/r + 1/r' + PV integral of F(m) J0(m R) dm + i pi Res F(k) J0(k R)
    F      = q / (1 - q E) (e^(m v) + E^2 e^(-m v) + E e^(m u) + E e^(-m u))
    G_deep = 1/r + PV integral of q e^(m v) J0(m R) dm + 2 pi i nu e^(nu v) J0(nu R)

for exp(-i w t). The rest is what the integrals differ by: a function of R and v, and one of R and
u. It is as smooth as the waves, and as images at a distance of twice the depth. Two tables hold
it; Capytaine computes the other two terms.
"""

from __future__ import annotations

from math import ceil, exp, inf, isinf, pi, tanh
from typing import Any, NamedTuple

import capytaine as cpt
import numpy as np
from numpy.typing import NDArray
from scipy.special import j0, j1

from hydrosim.water.bed_reflection import BY_BOTH, BY_R, BY_W, VALUE, add_reflection

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

NODES = 16  # of Gauss and Legendre in a piece of the integrals
PIECE_R = 6.0  # half a piece times the largest horizontal distance, at most
PIECE_H = 1.0  # half a piece times the depth, at most
FADED = 40.0  # exponent of the largest image at which integrals end
STEP_K = 0.4  # steps of tables over 1/k
STEP_H = 0.1  # steps of tables over the distance to the nearest image
SCALE = -1.0 / (4.0 * pi)  # of Capytaine's potentials


class FiniteDepth(cpt.Delhommeau):
    """Green function of water of finite depth, from Capytaine's of deep water."""

    def evaluate(self, mesh1: Any, mesh2: Any, **given: Any) -> tuple[Complex, Complex]:
        """Matrices S and K of the panels of ``mesh2`` at those of ``mesh1``. Capytaine calls it."""
        depth = given.pop("water_depth")
        k = given.pop("wavenumber")
        nu = inf if isinf(k) else k * tanh(k * depth)
        S, K = super().evaluate(mesh1, mesh2, water_depth=inf, wavenumber=nu, **given)
        adjoint = given.get("adjoint_double_layer", True)
        image = super().evaluate_rankine_only(
            mesh1,
            _bed_image(mesh2, depth),
            adjoint_double_layer=adjoint,
            diagonal_term_in_double_layer=False,
        )
        S += image[0]
        K += image[1]
        deepest = -min(mesh1.vertices[:, 2].min(), mesh2.vertices[:, 2].min())
        tables = bed_tables(k, nu, depth, _farthest(mesh1, mesh2), deepest)
        add_reflection(
            mesh1.faces_centers,
            mesh2.faces_centers,
            mesh2.faces_areas,
            mesh1.faces_normals if adjoint else mesh2.faces_normals,
            adjoint,
            *tables,
            S,
            K,
        )
        return S, K


class BedImage(NamedTuple):
    """Mirror image of a mesh in the sea bed, as Capytaine's Rankine integrals read it."""

    nb_faces: int
    vertices: Real
    faces: NDArray[np.int64]
    faces_centers: Real
    faces_normals: Real
    faces_areas: Real
    faces_radiuses: Real
    quadrature_points: tuple[Real, Real]


def _bed_image(mesh: Any, depth: float) -> BedImage:
    """The image of ``mesh``. Its faces go round the other way, so that normals are images too."""
    turned = np.array([1.0, 1.0, -1.0])
    below = np.array([0.0, 0.0, -2.0 * depth])
    return BedImage(
        mesh.nb_faces,
        mesh.vertices * turned + below,
        mesh.faces[:, ::-1],
        mesh.faces_centers * turned + below,
        mesh.faces_normals * turned,
        mesh.faces_areas,
        mesh.faces_radiuses,
        mesh.quadrature_points,
    )


def _farthest(mesh1: Any, mesh2: Any) -> float:
    """Upper bound of the horizontal distance [m] between two meshes."""
    corners = [mesh.vertices[:, :2] for mesh in (mesh1, mesh2)]
    low = np.min([c.min(axis=0) for c in corners], axis=0)
    high = np.max([c.max(axis=0) for c in corners], axis=0)
    return float(np.hypot(*(high - low)))


class BedTables(NamedTuple):
    """Values and derivatives (nr, nw, 4), times steps, of the rest ``of_sum`` over R and -v, and
    ``of_difference`` over R and |u|; their steps [m]. The scale is Capytaine's."""

    of_sum: Complex
    of_difference: Complex
    step_r: float
    step_w: float


def bed_tables(k: float, nu: float, h: float, farthest: float, deepest: float) -> BedTables:
    """Tables for horizontal distances up to ``farthest`` [m] and points down to ``deepest`` [m], of
    waves of wavenumber ``k`` [1/m], infinite included, in water of depth ``h`` [m]."""
    step = STEP_H * (2.0 * h - deepest)
    if not isinf(k):
        step = min(step, STEP_K / k)
    R = step * np.arange(ceil(farthest / step) + 2, dtype=float)
    quadrature = _green_quadrature(k, nu, h, farthest, deepest)
    phase = np.outer(R, quadrature.m)
    level = np.stack([j0(phase), -step * quadrature.m * j1(phase)])
    down = step * np.arange(ceil(2.0 * deepest / step) + 2, dtype=float)
    apart = step * np.arange(ceil(deepest / step) + 2, dtype=float)
    by_sum = [(quadrature.direct, 0.0, -1.0), (quadrature.images, 4.0 * h, 1.0)]
    by_difference = [(quadrature.images, 2.0 * h, 1.0), (quadrature.images, 2.0 * h, -1.0)]
    of_sum = _table(level, quadrature.m, by_sum, down, step)
    of_difference = _table(level, quadrature.m, by_difference, apart, step)
    return BedTables(of_sum, of_difference, step, step)


def _table(
    level: Real, m: Real, terms: list[tuple[Complex, float, float]], w: Real, step: float
) -> Complex:
    """Table over R and ``w`` [m] of sums over ``m`` of J0(m R) times ``terms`` (weights, l, sign),
    which mean weights * exp(-m (l - sign w)); ``level`` (2, nr, n) are J0 and its slope."""
    height = np.zeros((2, m.size, w.size), complex)
    for weights, length, sign in terms:
        fading = weights[:, None] * np.exp(-np.outer(m, length - sign * w))
        height[0] += fading
        height[1] += sign * step * m[:, None] * fading
    table = np.empty((level.shape[1], w.size, 4), complex)
    for along, up, entry in ((0, 0, VALUE), (1, 0, BY_R), (0, 1, BY_W), (1, 1, BY_BOTH)):
        product = level[along] @ height[up].real + 1j * (level[along] @ height[up].imag)
        table[:, :, entry] = SCALE * product
    return table


class GreenQuadrature(NamedTuple):
    """Weights (n,) of J0(m R) exp(m v) (``direct``), and of the images of it in the bed, at ``m``
    (n,) [1/m]. Their sums are the integrals; the last two are the residues."""

    m: Real
    direct: Complex
    images: Complex


def _green_quadrature(
    k: float, nu: float, h: float, farthest: float, deepest: float
) -> GreenQuadrature:
    """Quadrature of the rest. Gauss' nodes lie symmetrically about poles, so that their sums are
    principal values."""
    end = FADED / (2.0 * h - deepest)
    half = min(PIECE_R / max(farthest, 1e-9), PIECE_H / h)
    if k > end:  # the bed is out of reach of these waves
        return _images_alone(*_pieces(0.0, end, half), nu, h)
    ours, weight = _pieces(0.0, 2.0 * k, half)
    wet = weight * _factor(ours, nu, h)
    residue = 1j * pi * (k + nu) / _denominator_slope(k, nu, h)
    first, first_weight = _pieces(0.0, 2.0 * nu, half)
    second, second_weight = _pieces(2.0 * nu, 2.0 * k, half)
    deep = np.concatenate([first, second])
    dry = -np.concatenate([first_weight, second_weight]) * (deep + nu) / (deep - nu)
    tail = _images_alone(*_rising_pieces(2.0 * k, end, half), nu, h)
    zero = np.zeros(deep.size)
    return GreenQuadrature(
        np.concatenate([ours, deep, tail.m, [k, nu]]),
        np.concatenate([wet, dry, tail.direct, [residue, -2j * pi * nu]]),
        np.concatenate([wet, zero, tail.images, [residue, 0.0]]),
    )


def _images_alone(m: Real, weight: Real, nu: float, h: float) -> GreenQuadrature:
    """What is left where the integral of deep water is subtracted node by node."""
    q = -np.ones(m.size) if isinf(nu) else (m + nu) / (m - nu)
    E = np.exp(-2.0 * m * h)
    images = weight * q / (1.0 - q * E)
    return GreenQuadrature(m, (images * q * E).astype(complex), images.astype(complex))


def _factor(m: Real, nu: float, h: float) -> Real:
    """q / (1 - q E), also where m is near nu."""
    return (m + nu) / (m - nu - (m + nu) * np.exp(-2.0 * m * h))


def _denominator_slope(k: float, nu: float, h: float) -> float:
    """Derivative of m - nu - (m + nu) E at its zero ``k``."""
    E = exp(-2.0 * k * h)
    return 1.0 - E + 2.0 * h * (k + nu) * E


def _pieces(begin: float, end: float, half: float) -> tuple[Real, Real]:
    """Nodes and weights of an odd number of pieces, each at most twice ``half`` long."""
    count = 2 * ceil((end - begin) / (4.0 * half)) + 1
    x, weight = np.polynomial.legendre.leggauss(NODES)
    size = (end - begin) / count
    middle = begin + size * (np.arange(count) + 0.5)
    return (middle[:, None] + 0.5 * size * x).ravel(), np.tile(0.5 * size * weight, count)


def _rising_pieces(begin: float, end: float, half: float) -> tuple[Real, Real]:
    """Nodes and weights where the integrand changes over a distance of the size of ``m``."""
    parts = [_pieces(begin, begin, half)]
    while begin < end:
        stop = min(2.0 * begin, end)
        parts.append(_pieces(begin, stop, half))
        begin = stop
    m, weight = zip(*parts, strict=True)
    return np.concatenate(m), np.concatenate(weight)
