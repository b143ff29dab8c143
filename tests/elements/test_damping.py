"""Damping and loads of streams: decays, terminal velocities and static loads in closed form."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
import xarray as xr
from scenes import block, hull, in_waves, moving, scene, scene_of, steady, surge
from scipy.optimize import brentq

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.report.evidence import Feature, Kind

MASS = 2e3


def diagonal(**values: float) -> np.ndarray:
    return np.diag([values.get(dof, 0.0) for dof in DOFS])


def extremes(run: xr.Dataset, dof: int) -> np.ndarray:
    """Sizes of a coordinate where its rate changes sign, by the cubic between the records."""
    t, x, v = run.time.values, run.position.values[:, 0, dof], run.velocity.values[:, 0, dof]
    h, found = t[1] - t[0], []
    for i in np.flatnonzero(v[1:-1] * v[2:] < 0.0) + 1:
        s = v[i] / (v[i] - v[i + 1])
        shape = ((1 + 2 * s) * (1 - s) ** 2, s * s * (3 - 2 * s))
        slope = (s * (1 - s) ** 2, s * s * (s - 1))
        ends = shape[0] * x[i] + shape[1] * x[i + 1]
        found.append(abs(ends + h * (slope[0] * v[i] + slope[1] * v[i + 1])))
    return np.array(found)


@pytest.mark.parametrize(("dof", "start", "drag"), [("surge", 1.5, 900.0), ("roll", 0.3, 2.4e4)])
def test_quadratic_damping_decays_as_its_first_integral(dof, start, drag, validated):
    """Extremes of m x'' + D |x'| x' + k x = 0: (1 + b x1) exp(-b x1) = (1 - b x2) exp(b x2),
    b = 2 D / m. Steps of a two hundredth of the period, where RK4's error is below 1e-6; the
    second derivative of the force jumps at each extreme."""
    i = DOFS.index(dof)
    inertia = MASS * (1.0 if i < 3 else 3.0)
    stiffness = diagonal(**{dof: inertia})
    damper = hs.QuadraticDamping("block", diagonal(**{dof: drag}))
    forces = {"spring": hs.LinearMooring("block", stiffness), "drag": damper}
    body = block(MASS, dofs=[dof], position=moving(**{dof: start}))
    run = hs.simulate(scene(body, forces, 40.0, pi / 100))
    b, sizes = 2 * drag / inertia, [start]
    for _ in range(10):
        left = (1 + b * sizes[-1]) * np.exp(-b * sizes[-1])
        sizes.append(brentq(lambda x: (1 - b * x) * np.exp(b * x) - left, 0.0, sizes[-1]))  # noqa: B023
    found = extremes(run, i)[:10]
    error = np.abs(found - sizes[1:]).max() / start
    claim = "decay under quadratic damping, ten extremes over the first"
    validated(Kind.CLOSED_FORM, claim, "first integral", error, 2e-6, Feature.DRAG)
    assert found[-1] < 0.4 * start
    lost = run["energy_dissipated_drag"].values
    assert (np.diff(lost) >= 0.0).all()
    assert float(run.attrs["energy_residual_relative"]) < 1e-6


def test_a_body_adrift_takes_up_the_current(validated) -> None:
    """m v' = D (U - v)^2: U - v = U / (1 + D U t / m), along an axis of a body that is turned."""
    U, drag, angle = 1.2, 300.0, 0.5
    body = block(MASS, dofs=["surge", "sway"], position=moving(yaw=angle))
    damper = hs.QuadraticDamping("block", diagonal(surge=drag))
    drifting = scene(body, {"drag": damper}, 60.0, 0.5, step=0.05)
    run = hs.simulate(replace(drifting, environment=hs.Environment(current=hs.Stream(U, angle))))
    speed = U - U / (1 + drag * U * run.time.values / MASS)
    towards = np.array([np.cos(angle), np.sin(angle)])
    error = np.abs(run.velocity.values[:, 0, :2] - speed[:, None] * towards).max()
    claim, against = "body adrift that takes up a current [m/s]", "U/(1 + DUt/m)"
    features = (Feature.DRAG, Feature.CURRENT)
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-7, *features)
    gained = 0.5 * MASS * speed**2
    assert run["energy_dissipated_drag"].values == pytest.approx(-gained, rel=1e-6)


def test_linear_damping_relative_to_the_current_or_to_the_earth() -> None:
    """m v' = C (U - v) against m v' = -C v."""
    damping = diagonal(surge=500.0)
    for relative, end in ((True, 0.8), (False, 0.0)):
        forces = {"drag": hs.LinearDamping("block", damping, relative_to_current=relative)}
        body = block(MASS, dofs=["surge"], velocity=moving(surge=2.0))
        drifting = scene(body, forces, 20.0, 0.5, step=0.05)
        run = hs.simulate(replace(drifting, environment=hs.Environment(current=hs.Stream(0.8))))
        expected = end + (2.0 - end) * np.exp(-0.25 * run.time.values)
        assert run.velocity.values[:, 0, 0] == pytest.approx(expected, abs=1e-8)


def test_terminal_velocity_under_a_steady_force() -> None:
    """m v' = F - D v^2: v = sqrt(F/D) tanh(sqrt(F D) t / m)."""
    force, drag = 5e3, 800.0
    damper = hs.QuadraticDamping("block", diagonal(surge=drag))
    forces = {"push": steady(surge=force), "drag": damper}
    run = hs.simulate(scene(block(MASS, dofs=["surge"]), forces, 20.0, 0.5, step=0.02))
    expected = np.sqrt(force / drag) * np.tanh(np.sqrt(force * drag) * run.time.values / MASS)
    assert run.velocity.values[:, 0, 0] == pytest.approx(expected, abs=1e-8)
    assert surge(run)[-1] > 40.0


SURGE = np.eye(6)[0]
SWAY = np.eye(6)[1]
RATIO = np.array([0.1, 0.0, 0.02, 0.05, 0.0, 0.3])
STIFFNESS = np.array([9e3, 4e3, 16e3, 5e3, 8e3, 3e3])


def test_ratio_of_critical_on_the_moorings_of_a_dry_body(validated) -> None:
    """Two moorings count together; the damping ratios of the modes are those asked for."""
    body = block(MASS, inertia=MASS * np.diag([3.0, 4.0, 6.0]))
    forces = {
        "bow": hs.LinearMooring("block", 0.25 * np.diag(STIFFNESS)),
        "stern": hs.LinearMooring("block", 0.75 * np.diag(STIFFNESS)),
        "viscous": hs.LinearDamping("block", damping_ratio=RATIO),
    }
    modes = hs.natural_modes(hs.linearise(*hs.compile_scene(scene(body, forces, 1.0, 0.1))))
    found = {mode.dof: mode.damping_ratio for mode in modes}
    error = np.abs([found[dof] for dof in DOFS] - np.array(RATIO)).max()
    claim, features = "damping ratio of six modes on moorings", (Feature.DAMPING, Feature.MOORINGS)
    validated(Kind.CLOSED_FORM, claim, "ratio that was asked for", error, 1e-7, *features)


def test_ratio_of_critical_is_along_the_axes_of_a_body_that_has_turned() -> None:
    """A body to 90 deg surges along the earth's y: 2 r sqrt(k m) with the stiffness there."""
    body = block(MASS, heading=pi / 2)
    viscous = hs.LinearDamping("block", damping_ratio=0.1 * SURGE)
    forces = {"lines": hs.LinearMooring("block", np.diag(STIFFNESS)), "viscous": viscous}
    compiled = hs.compile_scene(scene(body, forces, 1.0, 0.1))
    damping = compiled.model.elements.linear_dampings[0]["damping"]
    assert damping[0, 0] == pytest.approx(0.2 * np.sqrt(STIFFNESS[1] * MASS))


def test_ratio_of_critical_on_a_mooring_of_a_natural_period(validated) -> None:
    body = block(MASS, dofs=["surge"])
    period = 20.0 * (np.arange(6) == 0)
    forces = {
        "lines": hs.LinearMooring("block", np.zeros((6, 6)), natural_period=period),
        "viscous": hs.LinearDamping("block", damping_ratio=0.2 * (np.arange(6) == 0)),
    }
    (mode,) = hs.natural_modes(hs.linearise(*hs.compile_scene(scene(body, forces, 1.0, 0.1))))
    error = abs(mode.natural_period / 20.0 - 1.0)
    claim, against = "natural period on a mooring that is given by it", "period that was asked for"
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-6, Feature.MOORINGS)
    assert mode.damping_ratio == pytest.approx(0.2, abs=1e-6)


def test_ratio_of_critical_of_a_floating_barge(figure) -> None:
    """C = 2 r sqrt(k (I + a(w))) at w^2 = k / (I + a(w)); roll, coupled to sway, about as much."""
    calm = in_waves(scene_of("free_floating"))
    ratio = hs.LinearDamping("barge", damping_ratio=RATIO * (np.arange(6) == 3))
    damped = replace(calm, forces={**calm.forces, "roll": ratio})
    model = hs.compile_scene(damped).model
    (element,) = model.elements[4]
    db, (barge,) = hull(), calm.bodies
    k, inertia = db.hydrostatic_stiffness[3, 3], barge.inertia[0, 0]

    def unbalance(w: float) -> float:
        return w * w * (inertia + np.interp(w, db.frequency, db.added_mass[:, 3, 3])) - k

    w = brentq(unbalance, 0.2, 1.5)
    assert element["damping"][3, 3] == pytest.approx(2 * 0.05 * k / w, rel=1e-6)
    assert np.count_nonzero(element["damping"]) == 1
    both = [hs.natural_modes(hs.linearise(*hs.compile_scene(s))) for s in (calm, damped)]
    before, after = (next(m.damping_ratio for m in modes if m.dof == "roll") for modes in both)
    figure("damping ratio of roll with 0.05 more, less that without", after - before)
    assert after - before == pytest.approx(0.05, rel=0.2)


def test_no_ratio_along_an_axis_of_the_body_that_nothing_holds() -> None:
    """A body that lies across has its surge along the earth's y, where the mooring is slack."""
    mooring = hs.LinearMooring("block", np.diag([9e3, 0, 0, 0, 0, 0]), damping_ratio=0.1 * SURGE)
    across = scene(block(MASS, heading=np.pi / 2.0), {"lines": mooring}, 1.0, 0.1)
    with pytest.raises(hs.InputError, match=r"forces.lines.damping_ratio.surge.*body's surge"):
        hs.compile_scene(across)
    along = replace(mooring, damping_ratio=0.1 * SWAY)
    model = hs.compile_scene(replace(across, forces={"lines": along})).model
    (element,) = model.elements.linear_moorings
    C = element["damping"]
    assert C[0, 0] == pytest.approx(0.2 * np.sqrt(9e3 * MASS))
    assert np.abs(C).sum() == pytest.approx(C[0, 0])


def test_no_ratio_without_stiffness() -> None:
    free = scene(block(MASS), {"drag": hs.LinearDamping("block", damping_ratio=RATIO)}, 1.0, 0.1)
    with pytest.raises(
        hs.InputError, match=r"forces.drag.damping_ratio.surge: found a ratio where"
    ):
        hs.compile_scene(free)


def in_stream(
    load: hs.CurrentLoad | hs.WindLoad, speed: float, heading: float, **changes
) -> xr.Dataset:
    """The first instant of a body in a stream."""
    stream = hs.Stream(speed, heading)
    still: hs.Scene = scene(block(MASS, **changes), {"load": load}, 0.01, 0.01)
    return hs.simulate(replace(still, environment=hs.Environment(current=stream, wind=stream)))


HEADINGS = np.radians(np.arange(0.0, 360.0, 10.0))
C = 400.0  # N s^2/m^2


def round_drag(kind: type[hs.CurrentLoad] | type[hs.WindLoad], point=(0.0, 0.0, 0.0)):
    """F = c |w| w, whatever the heading; the splines miss the cosine by 10 deg^4 / 384."""
    return kind("block", point, HEADINGS, C * np.cos(HEADINGS), C * np.sin(HEADINGS), 0 * HEADINGS)


SPLINE = np.radians(10.0) ** 4 / 384


@pytest.mark.parametrize("kind", [hs.CurrentLoad, hs.WindLoad])
@pytest.mark.parametrize("yaw", [0.0, 0.7, -3.0])
def test_static_load_at_a_point(kind, yaw, validated) -> None:
    """Along the stream, and its moment; the point turns with the body."""
    point, speed, heading = np.array([3.0, -1.0, 8.0]), 14.0, 2.2
    run = in_stream(round_drag(kind, tuple(point)), speed, heading, position=moving(yaw=yaw))
    found = run["force_load"].values[0, 0]
    force = C * speed**2 * np.array([np.cos(heading), np.sin(heading), 0.0])
    c, s = np.cos(yaw), np.sin(yaw)
    arm = np.array([c * point[0] - s * point[1], s * point[0] + c * point[1], point[2]])
    size = C * speed**2
    feature = {hs.CurrentLoad: Feature.CURRENT, hs.WindLoad: Feature.WIND}[kind]
    error = np.abs(found[:3] - force).max() / size
    claim = f"load of a steady {feature}, of its size"
    validated(Kind.CLOSED_FORM, claim, "cU²", error, 2.7e-6, feature)
    assert found[:3] == pytest.approx(force, abs=1.1 * SPLINE * size)
    assert found[3:] == pytest.approx(np.cross(arm, force), abs=10 * SPLINE * size)


def test_coefficients_are_exact_at_their_headings_and_smooth_round_the_circle() -> None:
    rng = np.random.default_rng(2)
    x, y, n = rng.normal(size=(3, 36))
    load = hs.WindLoad("block", (0.0, 0.0, 0.0), HEADINGS, x, y, n)
    for k in (0, 1, 17, 18, 35):
        wrench = in_stream(load, 2.0, HEADINGS[k])["force_load"].values[0, 0]
        c, s = np.cos(0.0), np.sin(0.0)
        assert wrench == pytest.approx([4 * x[k] * c, 4 * y[k] + s, 0, 0, 0, 4 * n[k]], abs=1e-9)
    # from either side of the turn's end
    runs = [in_stream(load, 1.0, a) for a in (2 * pi - 1e-9, 1e-9)]
    before, after = (run["force_load"].values[0, 0] for run in runs)
    assert before == pytest.approx(after, abs=1e-7)


def test_a_body_adrift_in_a_current_load() -> None:
    """U - v = U / (1 + c U t / m), in the direction of the current."""
    U, angle = 1.2, 2.2
    adrift = scene(block(MASS), {"load": round_drag(hs.CurrentLoad)}, 60.0, 0.5, step=0.05)
    run = hs.simulate(replace(adrift, environment=hs.Environment(current=hs.Stream(U, angle))))
    speed = U - U / (1 + C * U * run.time.values / MASS)
    towards = np.array([np.cos(angle), np.sin(angle)])
    assert run.velocity.values[:, 0, :2] == pytest.approx(speed[:, None] * towards, abs=5 * SPLINE)
    assert run["energy_work_load"].values == pytest.approx(0.5 * MASS * speed**2, abs=1e-2)
    assert float(run.attrs["energy_residual_relative"]) < 1e-6
