"""The linear analysis of scenes that are pressed, that drift, and in regular waves."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from markers import few
from scenes import (
    SEA,
    block,
    hull,
    in_waves,
    motion,
    moving,
    on_floor,
    scene,
    scene_of,
    steady,
    with_body,
)

import hydrosim as hs
from hydrosim.analysis.response import at_rest, responder
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.compile.compile import Radiation, compile_for_linear
from hydrosim.elements import AppliedForce, Coulomb, StickSlip, constant
from hydrosim.errors import InputError
from hydrosim.linear.equilibrium import Contacts
from hydrosim.linear.modes import ModeKind
from hydrosim.report.charts.analysis import draw_response
from hydrosim.scene import Kinematics, Place, Question, SecondOrder, StateSpaceRadiation

Figure = Callable[[str, float], None]
PRESSED = 4100.0  # s
LIFT = 316.1e6  # N, then


@lru_cache
def pressed() -> hs.Scene:
    """The base case at the end of its lift, in calm water and in equilibrium; with few states of
    radiation, for the more there are, the longer their own modes ring beside a decay."""
    few = StateSpaceRadiation(1e-3, 80.0, 0.1)
    case = with_body(in_waves(scene_of("base")), radiation=few)
    lift = AppliedForce("barge", (0.0, 0.0, 0.0), {"heave": constant(LIFT)})
    still = replace(case, forces={**case.forces, "deballast": lift}, solver=hs.Solver(step=0.05))
    return with_body(still, position=tuple(at_rest(still).position[0]))


@pytest.mark.parametrize("dof", few(["heave", "surge", "sway", "roll"], 2))
def test_stuck_periods_are_those_of_decays(dof: str, figure: Figure) -> None:
    """A push that friction holds against: the run rings on the springs K2 of the nodes. What is
    compared is the exponent of the decay, by a matrix pencil, once the modes of the memory are
    gone (of roll, from 20 s on, 5e-5 are left); rk4's own error at 0.05 s is 1e-6."""
    about = responder(pressed(), contacts=Contacts.STUCK)
    mode = next(m for m in about.natural_modes() if m.dof == dof)
    push = np.zeros(6)
    push[mode.coordinate] = 1e-3 if dof != "roll" else 1e-5
    run = hs.simulate(replace(with_body(pressed(), velocity=tuple(push)), duration=140.0))
    assert (run.fender_mode == 1).all()
    late = run.sel(time=slice(40.0, None))
    found = eigenvalue(late.time.values, motion(late)[:, mode.coordinate], mode.eigenvalue)
    figure(f"stuck {dof}: error of the period", mode.eigenvalue.imag / abs(found.imag) - 1)
    assert abs(found.imag) == pytest.approx(mode.eigenvalue.imag, rel=1e-4)
    assert found.real == pytest.approx(mode.eigenvalue.real, rel=1e-3)


def eigenvalue(time: np.ndarray, x: np.ndarray, near: complex) -> complex:
    """The exponent of a sum of decaying exponentials that is nearest to one, by a matrix pencil
    (Hua and Sarkar 1990)."""
    window = x.size // 2
    hankel = np.lib.stride_tricks.sliding_window_view(x, window)
    _, s, v = np.linalg.svd(hankel, full_matrices=False)
    v = v[s > 1e-9 * s[0]].T  # modes of the memory beside that of the hull are small
    values = np.linalg.eigvals(np.linalg.pinv(v[:-1]) @ v[1:])
    exponents = np.log(values.astype(complex)) / (time[1] - time[0])
    return complex(exponents[np.argmin(np.abs(exponents - near))])


def test_a_block_on_its_nodes() -> None:
    """By hand: w^2 = (k + 2 K2) / m stuck, k / m sliding and open, without normal springs open."""
    from hydrosim.elements import LinearMooring

    law = StickSlip(0.5, 0.4, 300.0, 1.0)
    forces = {
        "mooring": LinearMooring("block", np.diag([200.0, 0, 50.0, 0, 0, 0])),
        "weight": steady(heave=-100.0),
        "floor": on_floor(1e3, law, points=[(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)]),
    }
    standing = scene(block(2.0, ["surge", "heave"]), forces, 1.0, 0.1)
    for contacts, squares in (
        (Contacts.STUCK, (400.0, 1025.0)),
        (Contacts.SLIDING, (100.0, 1025.0)),
        (Contacts.OPEN, (100.0, 25.0)),
    ):
        found = linear_analysis(standing, LinearRequest(contacts=contacts))
        np.testing.assert_allclose(
            (2 * np.pi / found.natural_period) ** 2, squares, rtol=1e-6, err_msg=contacts
        )
        assert "floor 1 and floor 2" in found.remarks
    rigid = {**forces, "floor": on_floor(1e3, Coulomb(0.5, 0.4))}
    held = linear_analysis(replace(standing, forces=rigid), LinearRequest())
    assert list(held["mode"].values) == ["block heave"]
    np.testing.assert_allclose((2 * np.pi / held.natural_period) ** 2, 525.0, rtol=1e-6)
    along = replace(standing, bodies=(block(2.0, ["surge"], position=moving(heave=-0.1)),))
    with pytest.raises(InputError, match=r"rigid friction .* holds floor 1 at rest, so that"):
        linear_analysis(replace(along, forces=rigid), LinearRequest())
    assert linear_analysis(
        replace(standing, forces=rigid), LinearRequest(contacts=Contacts.OPEN)
    ).remarks


def test_base_case_open_and_stuck() -> None:
    """In surge the barge is its mass and added mass on the mooring, but for what couples it with
    heave and pitch; the founding study has 129.8 s and 0.2 of critical."""
    (barge,), stiffness = scene_of("base").bodies, 40 * 9810.0
    added = np.interp(2 * np.pi / 129.8, hull().frequency, hull().added_mass[:, 0, 0])
    alone = 2 * np.pi * np.sqrt((barge.mass + added) / stiffness)
    found = {
        contacts: linear_analysis(scene_of("base"), LinearRequest(time=PRESSED, contacts=contacts))
        for contacts in Contacts
    }
    for contacts in (Contacts.OPEN, Contacts.SLIDING):
        surge = found[contacts].sel(mode="barge surge")
        assert float(surge.natural_period) == pytest.approx(alone, abs=0.02)
        assert float(surge.natural_period) == pytest.approx(129.8, abs=0.05)
        assert float(surge.damping_ratio) == pytest.approx(0.2, abs=1e-4)
    assert float(found[Contacts.STUCK].sel(mode="barge surge").natural_period) < 4.0
    assert str(found[Contacts.SLIDING].sel(mode="barge yaw").mode_kind.values) == ModeKind.FREE


def test_what_waves_do_to_stuck_contacts_is_said() -> None:
    """Small waves leave the contacts as they are; in waves ten times as high they slip."""
    for height, slips in ((0.01, False), (10.0, True)):
        train = hs.WaveTrain(replace(SEA, significant_height=height))
        found = linear_analysis(in_waves(pressed(), train), LinearRequest())
        assert ("interface 1 would slip" in found.remarks) == slips


def drifting() -> hs.Scene:
    """The barge on nothing, in a sea of 45 deg with mean drift."""
    train = hs.WaveTrain(SEA, heading=np.radians(45.0))
    free = replace(in_waves(scene_of("free_floating"), train), forces={})
    return with_body(free, wave_forces=hs.WaveForces(True, SecondOrder.NEWMAN))


def test_a_free_barge_has_modes_and_responses() -> None:
    """No equilibrium is needed where nothing holds: heave, roll and pitch stay at rest, and the
    loads on the others are the mean of the second-order loads."""
    found = linear_analysis(drifting(), LinearRequest(frequencies=[0.6]))
    kinds = {str(m): str(k) for m, k in zip(found.mode.values, found.mode_kind.values, strict=True)}
    free = {f"barge {dof}" for dof in ("surge", "sway", "yaw")}
    assert {mode for mode, kind in kinds.items() if kind == ModeKind.FREE} == free
    assert "surge of barge" in found.remarks
    assert "heave of barge" not in found.remarks
    mean = with_body(drifting(), wave_forces=hs.WaveForces(False, SecondOrder.MEAN_DRIFT))
    run = hs.simulate(replace(mean, duration=0.5))
    load = run.force_wave_second_order.isel(time=0, body=0)
    for dof in ("surge", "sway", "yaw"):
        assert float(found.drift_load.sel(dof=dof)[0]) == pytest.approx(
            float(load.sel(dof=dof)), rel=1e-6
        )
    still = linear_analysis(
        in_waves(drifting()), LinearRequest(headings=[np.pi / 4], frequencies=[0.6])
    )
    np.testing.assert_allclose(found.rao_amplitude, still.rao_amplitude, rtol=1e-9)
    with pytest.raises(InputError, match="act in directions without stiffness"):
        at_rest(drifting(), mean_drift=True)


def test_regular_waves_have_an_amplitude_and_a_phase() -> None:
    """The RAO times the amplitude, and its phase, for a wave of any phase; no random figures."""
    wave = hs.WaveTrain(hs.RegularWave(0.5, 9.0, phase=1.0), heading=np.radians(45.0))
    case = with_body(scene_of("free_floating"), wave_forces=hs.WaveForces(True, SecondOrder.NONE))
    found = linear_analysis(in_waves(case, wave), LinearRequest(frequencies=[2 * np.pi / 9.0]))
    np.testing.assert_allclose(
        found.regular_amplitude[0], 0.5 * found.rao_amplitude[0, 0], rtol=1e-9
    )
    turned = found.regular_phase[0] - found.rao_phase[0, 0]
    np.testing.assert_allclose(np.exp(1j * turned), 1.0, atol=1e-9)
    assert "response_maximum" not in found
    both = linear_analysis(
        in_waves(case, wave, hs.WaveTrain(SEA)), LinearRequest(frequencies=[0.7])
    )
    alone = linear_analysis(in_waves(case, hs.WaveTrain(SEA)), LinearRequest(frequencies=[0.7]))
    np.testing.assert_allclose(both.response_std, alone.response_std, rtol=1e-9)
    assert both.sizes["wave"] == 1


def test_the_databases_radiation_needs_no_fit(figure: Figure) -> None:
    """With a tolerance that no fit reaches; periods and damping are those of the model."""
    case = in_waves(scene_of("free_floating"))
    impossible = with_body(case, radiation=StateSpaceRadiation(tolerance=1e-19))
    compiled = compile_for_linear(impossible, Radiation.DATABASE)
    assert not compiled.wet[0].fits
    own = {m.dof: m for m in responder(compiled, radiation=Radiation.DATABASE).natural_modes()}
    model = {m.dof: m for m in responder(case).natural_modes()}
    for dof in ("surge", "heave", "roll", "pitch"):
        error = own[dof].natural_period / model[dof].natural_period - 1
        figure(f"{dof}: natural period, database against model", error)
        assert abs(error) < 2e-3
    assert own["roll"].damping_ratio == pytest.approx(model["roll"].damping_ratio, rel=0.1)


def test_waves_that_follow_a_body_meet_it_at_rest() -> None:
    """Loads at the place at the time are those at rest, for small motions."""
    case = with_body(scene_of("free_floating"), hydrodynamics=hull())
    follow = hs.WaveForces(True, SecondOrder.NONE, headings=Place.INSTANTANEOUS)
    omega = np.array([0.5])
    found = [
        responder(with_body(case, wave_forces=loads)).raos(0.3, omega)
        for loads in (hs.WaveForces(True, SecondOrder.NONE), follow)
    ]
    np.testing.assert_array_equal(*found)
    assert np.abs(found[0]).max() > 0.0
    assert scene_of("free_floating").solver.kinematics == Kinematics.EXACT


@pytest.mark.parametrize("radiation", Radiation)
@pytest.mark.parametrize("by", ["heading", "yaw"])
def test_responses_turn_with_the_barge(radiation: Radiation, by: str) -> None:
    """A free barge turned by 40 deg, by its heading or its yaw, in waves turned as far: surge and
    sway along turned axes, all angles as they were, about the body's own axes."""
    turn, omega = np.radians(40.0), np.array([0.4, 0.7])
    free = with_body(
        replace(in_waves(scene_of("free_floating")), forces={}),
        wave_forces=hs.WaveForces(True, SecondOrder.NONE),
        centre_of_gravity=(0.0, 0.0, -4.9),
    )
    place = {"heading": turn} if by == "heading" else {"position": (0, 0, 0, 0, 0, turn)}
    still, turned = free, with_body(free, **place)
    expected = responder(still, radiation=radiation).raos(0.5, omega)
    found = responder(turned, radiation=radiation).raos(0.5 + turn, omega)
    c, s = np.cos(turn), np.sin(turn)
    expected[:, :2] = expected[:, :2] @ np.array([[c, s], [-s, c]])
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())


def test_coefficients_alone_have_modes_and_are_said_to_feel_no_waves(tmp_path) -> None:
    """m + a, c: the period in closed form; the picture has nothing to draw."""
    a, c = (value * np.diag(np.eye(6)[2]) for value in (5e5, 8e5))
    given = hs.Coefficients(a, 0.0 * a, c)
    body = hs.Body("buoy", 1e6, np.eye(3), hydrodynamics=given, dofs=("heave",))
    found = linear_analysis(hs.Scene("buoy", 1.0, (body,)), LinearRequest())
    expected = 2.0 * np.pi * np.sqrt(1.5e6 / 8e5)
    assert float(found.natural_period[0]) == pytest.approx(expected, rel=1e-9)
    assert (
        "has no wave loads: in these RAOs only the other bodies drive buoy"
        in found.attrs["remarks"]
    )
    draw_response(found, tmp_path / "rao.png")


def test_what_check_asks_is_told() -> None:
    """A wave of 40 s is unusual."""
    scene = scene_of("free_floating")
    water = replace(
        scene.environment,
        waves=(replace(scene.environment.waves[0], spectrum=hs.RegularWave(0.1, 40.0)),),
    )
    odd = replace(scene, environment=water)
    remarks = linear_analysis(odd, LinearRequest()).remarks
    assert "a period of 40 s" in remarks
    accepted = linear_analysis(replace(odd, accept=(Question.WAVES,)), LinearRequest()).remarks
    assert "a period of 40 s" not in accepted
