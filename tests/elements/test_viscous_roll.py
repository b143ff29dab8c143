"""Viscous roll damping: decays, energy, what p1 means for a body with a database, Ikeda."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
import xarray as xr
from scenes import block, hull, in_waves, moving, scene, scene_of
from scipy.integrate import solve_ivp

import hydrosim as hs
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.compile.roll_mode import roll_mode
from hydrosim.elements.decay_records import decay_of
from hydrosim.elements.roll_decay import fit_decays
from hydrosim.elements.viscous_roll import WATER_VISCOSITY, eddy_damping, friction_damping
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Kinematics, LinearScenes, Scene
from hydrosim.scene.damping import SharpBarge, ViscousRoll

MASS, INERTIA = 2e3, 6e3
STIFFNESS = np.diag([0.0, 0.0, 0.0, INERTIA, 0.0, 0.0])  # a natural frequency of 1 rad/s


def rolling(damping: ViscousRoll, start: float = 0.3, **solver: object) -> Scene:
    """A dry body that rolls on a spring, in 40 s."""
    small = solver.get("kinematics") == Kinematics.LINEAR
    heading = 0.0 if small else 0.7  # small angles have no heading
    body = block(MASS, dofs=["roll"], position=moving(roll=start), heading=heading)
    body = replace(body, inertia=INERTIA * np.eye(3))
    forces = {"spring": hs.LinearMooring("block", STIFFNESS), "bilges": damping}
    return scene(body, forces, 40.0, 0.5, **{"step": 0.01, **solver})


def rates(run: xr.Dataset) -> np.ndarray:
    """Roll rate (nt,) about the axis of a body that heads to 0.7 rad."""
    v = run.velocity.values[:, 0]
    return v[:, 3] * np.cos(0.7) + v[:, 4] * np.sin(0.7)


RECORDS = np.linspace(0.0, 40.0, 81)


def reference(
    p: tuple[float, float, float], start: float = 0.3, time: np.ndarray = RECORDS
) -> np.ndarray:
    """The roll of `rolling` at its records or other times, by DOP853."""

    def slope(t: float, y: np.ndarray) -> list[float]:
        v = y[1]
        return [v, -(p[0] + p[1] * abs(v) + p[2] * v * v) * v - y[0]]

    ends = (time[0], time[-1])
    done = solve_ivp(slope, ends, [start, 0.0], "DOP853", time, rtol=1e-12, atol=1e-14)
    return np.asarray(done.y[0])


@pytest.mark.parametrize("kinematics", Kinematics)
@pytest.mark.parametrize(("p", "bound"), [((0.05, 0.0, 0.6), 1e-9), ((0.03, 0.4, 0.2), 1e-8)])
def test_decay_as_by_an_independent_solver(kinematics, p, bound, validated):
    """Smooth damping to 1e-9; |p| p jumps in its second derivative at each extreme."""
    run = hs.simulate(rolling(ViscousRoll("block", *p), kinematics=kinematics))
    error = np.abs(run.position.values[:, 0, 3] - reference(p)).max()
    kind = "quadratic and cubic" if p[1] else "cubic"
    claim = f"decay under linear, {kind} roll damping [rad]"
    validated(Kind.INDEPENDENT, claim, "DOP853 of scipy", error, bound, Feature.ROLL)


def test_order_at_the_jumps_of_quadratic_damping() -> None:
    """Three of four orders are left where the roll turns; the error still falls as h^3."""
    damping = ViscousRoll("block", p2=0.4)
    exact = reference((0.0, 0.4, 0.0))
    runs = [hs.simulate(rolling(damping, step=h)) for h in (0.1, 0.05, 0.025)]
    errors = [np.abs(run.position.values[:, 0, 3] - exact).max() for run in runs]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders.min() > 2.5


def test_envelope_of_weak_quadratic_damping_in_closed_form() -> None:
    """a' = -(4 / (3 pi)) p2 w a^2: a = a0 / (1 + (4 / (3 pi)) p2 w a0 t), to the order of p2."""
    p2, start = 0.05, 0.3
    run = hs.simulate(rolling(ViscousRoll("block", p2=p2), start))
    x, v = run.position.values[:, 0, 3], rates(run)
    time = run.time.values
    expected = start / (1.0 + 4.0 / (3.0 * pi) * p2 * start * time)
    assert np.hypot(x, v) == pytest.approx(expected, rel=0.01)
    assert expected[-1] < 0.83 * start


def test_what_it_takes_is_booked_as_dissipation() -> None:
    run = hs.simulate(rolling(ViscousRoll("block", 0.03, 0.4, 0.2)))
    x, v = run.position.values[:, 0, 3], rates(run)
    energy = 0.5 * INERTIA * (x**2 + v**2)
    lost = run["energy_dissipated_bilges"].values
    assert lost == pytest.approx(energy[0] - energy, abs=1e-7 * energy[0])
    assert (np.diff(lost) > 0.0).all()


def test_only_linear_damping_is_propagated() -> None:
    small = {"kinematics": Kinematics.LINEAR, "linear": LinearScenes.EXACT}
    linear = rolling(ViscousRoll("block", p1=0.1), **small)
    run = hs.simulate(linear)
    assert run.attrs["solver_linear"].startswith("propagated exactly")
    w = np.sqrt(1.0 - 0.05**2)
    t = run.time.values
    expected = 0.3 * np.exp(-0.05 * t) * (np.cos(w * t) + 0.05 / w * np.sin(w * t))
    assert run.position.values[:, 0, 3] == pytest.approx(expected, abs=1e-10)
    more = hs.simulate(rolling(ViscousRoll("block", p1=0.1, p2=0.1), **small))
    assert "bilges" in more.attrs["solver_linear"]


ALL = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def afloat(damping: ViscousRoll | None, dofs: tuple[str, ...], **changes: object) -> Scene:
    """The barge in calm water, without moorings."""
    calm = in_waves(scene_of("free_floating"))
    forces = {} if damping is None else {"bilges": damping}
    body = replace(calm.bodies[0], dofs=dofs, **changes)
    return replace(calm, bodies=(body,), forces=forces)


def roll_ratio(calm: Scene) -> float:
    modes = hs.natural_modes(hs.linearise(*hs.compile_scene(calm)))
    return next(m.damping_ratio for m in modes if m.dof == "roll")


@pytest.mark.parametrize("dofs", [("roll",), ALL])
@pytest.mark.parametrize("heading", [0.0, 1.0])
def test_the_total_is_that_of_the_test_with_the_waves_of_a_database(dofs, heading):
    """Its ratio is p1 / (2 w), coupled to sway or not: mass and damping change at second order."""
    body = replace(afloat(None, dofs).bodies[0], heading=heading)
    mode = roll_mode(body, np.zeros((6, 6)), hull())
    p1 = 0.16 * mode.frequency
    found = roll_ratio(afloat(ViscousRoll("barge", p1=p1), dofs, heading=heading))
    assert found == pytest.approx(0.08, rel=0.02)
    waves = mode.damping / (2.0 * mode.mass * mode.frequency)
    assert waves > 0.01
    damping = ViscousRoll("barge", p1=p1, includes_waves=False)
    both = roll_ratio(afloat(damping, dofs, heading=heading))
    assert both == pytest.approx(0.08 + waves, rel=0.04)


def test_a_simulated_decay_has_the_damping_that_was_measured() -> None:
    """p1 and p2 of a test, simulated with the memory of a database, and fitted again."""
    calm = afloat(None, ("roll",))
    w = roll_mode(calm.bodies[0], np.zeros((6, 6)), hull()).frequency
    damping = ViscousRoll("barge", p1=0.14 * w, p2=0.3, period=2.0 * pi / w)
    decaying = afloat(damping, ("roll",), position=moving(roll=0.15))
    run = hs.simulate(replace(decaying, duration=150.0).with_output(step=0.1))
    assert "warnings" not in run.attrs
    time = run.time.values
    later = time > 5.0  # the memory has begun
    found = fit_decays([decay_of(time[later], run.position.values[later, 0, 3])])
    amplitude = 0.05
    measured = (damping.p1 + 8.0 / (3.0 * pi) * damping.p2 * w * amplitude) / (2.0 * w)
    assert found.terms.damping_ratio(amplitude).value == pytest.approx(measured, rel=0.03)


def test_less_than_the_waves_and_another_period_are_asked() -> None:
    short = afloat(ViscousRoll("barge", p1=1e-4, p2=0.2, period=9.0), ("roll",))
    notes = hs.compile_scene(short).notes.warnings
    assert any("forces.bilges.p1" in text and "by radiated waves" in text for text in notes)
    words = ("forces.bilges.period", "same loading condition")
    assert any(all(word in text for word in words) for text in notes)
    (found,) = hs.compile_scene(short).model.elements.viscous_rolls
    assert found["linear"] == 0.0


def test_check_says_both_figures() -> None:
    document = str(hs.check(afloat(ViscousRoll("barge", p1=0.05, p2=0.2), ("roll",))))
    assert "bilges: B1" in document
    assert "by waves" in document


def test_negative_damping_is_refused() -> None:
    with pytest.raises(hs.InputError, match=r"ViscousRoll.p2: found -0.1; .* 0 or more"):
        ViscousRoll("block", p2=-0.1)


def test_linear_analysis_in_a_sea_takes_the_mean_power() -> None:
    """The std of roll is that with linear damping B1 + sqrt(8/pi) s B2 + 3 s^2 B3 at its own s."""
    calm = scene_of("free_floating")
    B = {"linear": 1e9, "quadratic": 4e11, "cubic": 4e13}
    roll = [ViscousRoll("barge", **B), ViscousRoll("barge", linear=1e9)]
    wanted = LinearRequest(frequencies=(0.4, 0.5, 0.6), headings=(pi / 2,))
    beam = tuple(replace(train, heading=pi / 2) for train in calm.environment.waves)
    sea = in_waves(calm, *beam)
    found = linear_analysis(replace(sea, forces={"bilges": roll[0]}), wanted)
    s = float(found.attrs["remarks"].split("sea, of ")[1].split()[0])
    s = np.radians(s)
    equivalent = B["linear"] + np.sqrt(8.0 / pi) * s * B["quadratic"] + 3.0 * s**2 * B["cubic"]
    assert equivalent > 1.5 * B["linear"]
    same = {"bilges": ViscousRoll("barge", linear=equivalent)}
    other = linear_analysis(replace(sea, forces=same), wanted)
    std = [float(x.response_std.sel(dof="roll")[0]) for x in (found, other)]
    assert std[0] == pytest.approx(std[1], rel=2e-3)
    assert found.rao_amplitude.values == pytest.approx(other.rao_amplitude.values, rel=1e-2)


def test_ikeda_scales_as_its_equation_says() -> None:
    """The equivalent damping of the quadratic part is B_E of the reference; friction is Kato's."""
    L, B, d, OG, rho, R0, w = 90.0, 27.0, 4.0, -3.0, 1025.0, 0.15, 0.8
    barge = SharpBarge(L, B, d)
    H0 = B / (2 * d)
    expected = (2 / pi) * rho * L * d**4 * (H0**2 + 1 - OG / d) * (H0**2 + (1 - OG / d) ** 2)
    found = 8.0 / (3.0 * pi) * eddy_damping(barge, rho, OG) * w * R0
    assert found == pytest.approx(expected * R0 * w, rel=1e-12)
    S = L * (1.7 * d + B)
    r = ((0.887 + 0.145) * (1.7 * d + B) - 2.0 * OG) / pi
    reynolds = 3.22 * r**2 * R0**2 * w / (2.0 * pi * WATER_VISCOSITY)
    friction = 4.0 / (3.0 * pi) * rho * S * r**3 * R0 * w * 1.328 / np.sqrt(reynolds)
    assert friction_damping(barge, rho, OG, w) == pytest.approx(friction, rel=1e-3)


@pytest.mark.parametrize(
    ("form", "said"),
    [
        (SharpBarge(90.0, 27.0, 1.0), "ikeda.beam: found 27 m at a draught of 1 m"),
        (SharpBarge(90.0, 27.0, 20.0), "ikeda.beam"),
        (SharpBarge(20.0, 27.0, 4.0), "ikeda.length"),
    ],
)
def test_ikeda_refuses_what_is_no_barge(form: SharpBarge, said: str) -> None:
    with pytest.raises(hs.InputError, match=said):
        hs.compile_scene(rolling(ViscousRoll("block", ikeda=form)))


LENGTH, BEAM, DRAUGHT = 0.9, 0.3, 0.05
BODY_INERTIA, ADDED, WAVES = 0.236, 0.1129, 0.1636
RESTORING = 9.81e3 * LENGTH * BEAM * DRAUGHT * 0.125


def test_ikeda_against_a_published_barge() -> None:
    """Free decay from 15 deg of a sharp-cornered box across a flume, hinged at its centre of
    gravity in the waterline (Jung, Chang and Jo 2006, Ocean Eng. 33): measured were a natural
    period of 0.93 s and a damping ratio of 0.106.

    Added inertia and wave damping at that period are those of potential flow, by Capytaine 3.0 in
    0.9 m of water, of a section: that of 9 m less that of 6 m, so without ends. Over which swings
    the ratio was taken is not known to us; the formula's falls with the roll, from 0.126 over two
    to 0.105 over four, which end at 4 deg.
    """
    barge = SharpBarge(LENGTH, BEAM, DRAUGHT, viscosity=1.0e-6)
    inertia = BODY_INERTIA + ADDED
    w = np.sqrt(RESTORING / inertia)
    B1 = WAVES + friction_damping(barge, 1e3, 0.0, w)
    B2 = eddy_damping(barge, 1e3, 0.0)
    p = (B1 / inertia / w, B2 / inertia, 0.0)
    roll = reference(p, np.radians(15.0), np.linspace(0.0, 15.0, 2000))
    swings = np.abs(roll[[0, *(np.flatnonzero(np.diff(np.sign(np.diff(roll)))) + 1)]])
    decrements = np.array([np.log(swings[0] / swings[n]) / n for n in (2, 4)])
    ratios = decrements / np.hypot(pi, decrements)
    assert 2.0 * pi / w == pytest.approx(0.93, rel=0.03)
    assert ratios == pytest.approx([0.126, 0.105], abs=1e-3)
    assert np.abs(ratios - 0.106).max() < 0.2 * 0.106
    assert WAVES / (2.0 * inertia * w) < 0.04  # waves alone
