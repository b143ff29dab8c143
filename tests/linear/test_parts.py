"""Components of a scene give what the whole gives, and are solved once each."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scenes import block, scene, scene_of

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.linear import linearise as module
from hydrosim.linear.linearise import Linear, find_components, linearise
from hydrosim.linear.modes import find_admittances
from hydrosim.run.step_limits import add_step_warnings

NAMES = ("left", "right", "other")
PARTS = 2  # of a barge: what moves in its plane, and what moves aside


def barges(count: int = 3, **forces: hs.Spring) -> hs.Scene:
    """Two equal barges, and one of another inertia, far apart."""
    base = scene_of("free_floating")
    (barge,) = base.bodies
    bodies = [replace(barge, name=name, location=(1000.0 * k, 0.0)) for k, name in enumerate(NAMES)]
    bodies[2] = replace(bodies[2], inertia=1.1 * barge.inertia)
    moorings = {
        f"{kind} of {name}": replace(element, body=name)
        for name in NAMES[:count]
        for kind, element in base.forces.items()
    }
    return replace(base, bodies=tuple(bodies[:count]), forces={**moorings, **forces})


def line(stiffness: float) -> hs.Spring:
    """A line between the equal bodies."""
    curve = np.array([0.0, 1.0]), np.array([0.0, stiffness])
    return hs.Spring(
        "left",
        (0.8, 0.0, 0.5),
        (-0.8, 0.0, 0.5),
        0.5,
        curve=hs.TensionCurve(*curve),
        anchor_body="right",
    )


def linear_of(scene: hs.Scene) -> Linear:
    return linearise(*hs.compile_scene(scene))


def parts_of(linear: Linear) -> tuple[Linear, ...]:
    return linear.split(linear.coupled_states)


def distance(some: np.ndarray, others: np.ndarray) -> float:
    """The largest relative distance of one of ``some`` from the nearest of the ``others``."""
    return float((np.abs(some[:, None] - others).min(axis=1) / np.abs(some)).max())


def test_components_of_a_graph() -> None:
    edges = np.zeros((6, 6))
    edges[0, 3] = edges[4, 3] = 1e-300
    edges[5, 1] = np.nan
    found = [part.tolist() for part in find_components(edges)]
    assert found == [[0, 3, 4], [1, 5], [2]]
    assert find_components(np.zeros((0, 0))) == []


@pytest.mark.parametrize("count", [1, 3])
def test_memory_of_parts_is_differentiated_at_once(count, monkeypatch):
    """To the bit as one column after the other, with fewer evaluations."""
    compiled = hs.compile_scene(barges(count, line=line(1e6)) if count > 1 else barges(1))
    shifts: list[np.ndarray] = []
    fill = module.fill_jacobian

    def watch(*args):
        shifts.append(args[7].number)
        return fill(*args)

    monkeypatch.setattr(module, "fill_jacobian", watch)
    at_once = linearise(*compiled).jacobian
    together = sum(np.unique(number).size for number in shifts)
    shifts.clear()
    monkeypatch.setattr(module, "_find_parts", lambda _, __, states, ___: np.zeros_like(states))
    assert np.array_equal(at_once, linearise(*compiled).jacobian)
    assert together < sum(np.unique(number).size for number in shifts)


def test_eigenvalues_of_components_are_those_of_the_whole(figure) -> None:
    linear = linear_of(barges())
    parts = parts_of(linear)
    assert len(parts) == 3 * PARTS
    each = np.concatenate([part.eigenvalues() for part in parts])
    whole = linear.eigenvalues()
    moving = np.abs(whole) > 1e-6  # what is free has none but rounding
    assert each.size == whole.size
    off = max(distance(whole[moving], each), distance(each[np.abs(each) > 1e-6], whole))
    figure("eigenvalues, relative", off)
    assert off < 1e-9


def test_a_weak_line_makes_one_component() -> None:
    apart = len(parts_of(linear_of(barges())))
    assert len(parts_of(linear_of(barges(line=line(1e-6))))) < apart


def test_equal_components_are_solved_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """As many eigenvalue problems as components that differ."""
    asked: Counter[int] = Counter()
    eigvals = module.linalg.eigvals

    def counted(matrix: np.ndarray) -> np.ndarray:
        asked[len(matrix)] += 1
        return eigvals(matrix)

    for count, different in ((1, 1), (2, 1), (3, 2)):
        compiled = hs.compile_scene(barges(count))
        with monkeypatch.context() as patched:
            patched.setattr(module.linalg, "eigvals", counted)
            add_step_warnings(compiled)
        assert asked.total() == different * PARTS
        asked.clear()


def test_memory_of_each_body_changes_motions_as_it_does_alone() -> None:
    one, three = (hs.compile_scene(barges(count)).memory_errors for count in (1, 3))
    assert [errors.names for errors in three] == list(NAMES)
    for errors in three[:2]:
        assert errors.fit is not None
        assert one[0].fit is not None
        assert errors.fit[0].size == pytest.approx(one[0].fit[0].size, rel=1e-9)
        assert errors.cut[0].size == pytest.approx(one[0].cut[0].size, rel=1e-9)
    assert three[2].cut[0].size != pytest.approx(one[0].cut[0].size, rel=1e-6)


def by_hand(s: complex, memory: np.ndarray, change: np.ndarray, linear: Linear) -> float:
    """The norm of Z^-1 dZ of all coordinates at once, scaled by the roots of their inertias, with
    ``memory`` and ``change`` (6 nb, 6 nb)."""
    n, M, J = linear.active.size, linear.inertia, linear.jacobian[linear.active.size :]
    own = np.ix_(linear.active, linear.active)
    Z = s * M - M @ J[:, n:] - M @ J[:, :n] / s + memory[own]
    root = np.sqrt(np.diag(M))
    return float(np.linalg.norm(root[:, None] * np.linalg.solve(Z, change[own]) / root, 2))


def selected(dofs: np.ndarray, linear: Linear) -> np.ndarray:
    """Velocities (k, n) of these DOFs of bodies per rate of each free coordinate."""
    return np.asarray(dofs[:, None] == linear.active, dtype=float)


@pytest.mark.parametrize("forces", [{}, {"line": line(30.0)}], ids=["apart", "on a line"])
def test_changes_of_components_are_those_of_the_whole(forces: dict[str, hs.Spring]) -> None:
    """Databases of one body and of two, in an order of their own, partly locked."""
    free = (DOFS, ("sway", "roll", "yaw"), ("surge",))
    bodies = [block(2.0, own, name) for own, name in zip(free, NAMES, strict=True)]
    moored = {f"k {name}": hs.LinearMooring(name, np.diag(np.arange(5.0, 11.0))) for name in NAMES}
    linear = linear_of(scene(bodies, {**moored, **forces}, 20.0, 0.1))
    w = np.linspace(0.3, 3.0, 7)
    s = 0.01 + 1j * w
    dofs = [np.arange(6, 12), np.r_[12:18, 0:6]]
    rng = np.random.default_rng(1)
    memories = [rng.normal(size=(w.size, own.size, own.size)) + 1j for own in dofs]
    memory = np.zeros((w.size, 18, 18), dtype=complex)
    for own, K in zip(dofs, memories, strict=True):
        memory[:, own[:, None], own] = K
    found = find_admittances(s, [selected(own, linear) for own in dofs], memories, linear)
    for own, admittance in zip(dofs, found, strict=True):
        dZ = rng.normal(size=(w.size, own.size, own.size))
        change = np.zeros(memory.shape)
        change[:, own[:, None], own] = dZ
        norms = [by_hand(*each, linear) for each in zip(s, memory, change, strict=True)]
        largest = admittance.largest_change(w, dZ)
        assert largest.size == pytest.approx(max(norms), rel=1e-9)
        assert largest.w == w[np.argmax(norms)]
