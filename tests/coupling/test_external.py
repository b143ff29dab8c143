"""Functions of Python as forces: orders, energy, errors, restarts."""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import printed
from scenes import CASES, Acting, block, joint_of, moving, observed_orders, on_floor, scene, steady

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.elements.external import BodyState
from hydrosim.files.document_nodes import Table
from hydrosim.report.sentences.run import summary
from hydrosim.results.dataset import write_run
from hydrosim.run.provenance import case_of
from hydrosim.scene import Kinematics, Method, Scene, Start

MASS, STIFFNESS = 1e3, 1e4
OMEGA = np.sqrt(STIFFNESS / MASS)  # rad/s
END = 2.0  # s
States = Mapping[str, BodyState]


def spring(t: float, state: States) -> np.ndarray:
    """A spring in surge."""
    force = np.zeros(6)
    force[0] = -STIFFNESS * state["block"].position[0]
    return force


def swinging(duration: float = END, step: float = 0.05, **solver: Any) -> Scene:
    body = block(MASS, ("surge",), velocity=moving(surge=1.0))
    return scene(body, {}, duration, step, **solver)


def with_function(function: Callable[..., Any], coupling: str = "stage", **of: Any) -> Scene:
    return replace(swinging(**of), forces={"it": hs.UserForce("block", function, coupling)})


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5, Method.ESDIRK4])
def test_a_spring_per_stage_is_the_spring_inside(method, figure):
    """On a block that bounces on a floor meanwhile: through events of other elements."""
    bouncing = block(MASS, ("surge", "heave"), position=moving(heave=0.3, surge=0.1))
    inside = {
        "it": hs.LinearMooring("block", np.diag([STIFFNESS, *[0.0] * 5])),
        "floor": on_floor(1e6, hs.Frictionless()),
        "weight": steady(heave=-9.81 * MASS),
    }
    one = scene(bouncing, inside, END, 0.02, method=method)
    other = replace(one, forces={**inside, "it": hs.UserForce("block", spring)})
    expected, found = hs.simulate(one), hs.simulate(other)
    assert found.solver_events == expected.solver_events > 1
    apart = float(np.abs(found.position - expected.position).max())
    assert apart < 1e-12
    assert found.external_forces.endswith("stage (the order of the method)")
    figure(f"{method} [m]", apart)


@pytest.mark.parametrize(("coupling", "order"), [("stage", 4), ("held", 1), ("extrapolated", 2)])
def test_orders_are_as_stated(coupling, order, figure):
    """Against x = sin(w t) / w; output at the last time alone is enough."""
    steps = [0.02, 0.01, 0.005]
    found = []
    for step in steps:
        run = hs.simulate(with_function(spring, coupling, step=step))
        exact = np.sin(OMEGA * run.time.values) / OMEGA
        found.append(np.abs(run.position.values[:, 0, 0] - exact).max())
    orders = observed_orders(steps, np.array(found))
    figure(f"order, {coupling}", float(orders[-1]))
    assert np.abs(orders - order).max() < 0.15


@pytest.mark.parametrize(("coupling", "order"), [("held", 1), ("extrapolated", 2)])
def test_the_energy_of_a_delay_is_booked(coupling: str, order: int) -> None:
    """The function has a potential, U = k x^2 / 2, so work beyond -U is that of the delay. The
    ledger closes with the work of the force that acted; the estimate has an error of the next
    order."""
    ratios, sizes = [], []
    for step in (0.02, 0.01):
        run = hs.simulate(with_function(spring, coupling, step=step))
        made = run.energy_work_it + 0.5 * STIFFNESS * run.position[:, 0, 0] ** 2
        booked = run.external_delay_energy[:, 0]
        sizes.append(float(np.abs(made).max()))
        ratios.append(float(np.abs(booked - made).max()) / sizes[-1])
        assert np.abs(run.energy_residual).max() < 1e-9 * run.energy_kinetic.max()
    assert ratios[1] < 0.6 * ratios[0] < 0.05
    assert np.log2(sizes[0] / sizes[1]) == pytest.approx(order, abs=0.35)


def test_a_delay_that_makes_much_energy_is_told() -> None:
    """With couplings that are better than the one in use."""
    coarse = hs.simulate(with_function(spring, "held", step=0.05))
    assert "the delay of it" in coarse.attrs["warnings"]
    assert "coupling extrapolated instead of held, or coupling stage" in coarse.attrs["warnings"]
    extrapolated = hs.simulate(with_function(spring, "extrapolated", step=0.1))
    assert "the delay of it" in extrapolated.attrs["warnings"]
    assert "smaller solver.step, or coupling stage" in extrapolated.attrs["warnings"]
    fine = hs.simulate(with_function(spring, "extrapolated", step=0.005))
    assert "delay" not in fine.attrs.get("warnings", "")


def test_an_extrapolated_force_keeps_its_order_over_short_pieces(figure):
    """Steps are cut in ten: by their caller, who steps to these times."""
    steps = [0.02, 0.01]
    found = []
    for step in steps:
        sim = hs.Simulation(with_function(spring, "extrapolated", step=step))
        for n in range(1, 10 * round(END / step)):
            sim.step(0.1 * step * n)
        run = sim.run()
        assert run.external_calls.values[-1, 0] == 10 * round(END / step) + 1
        exact = np.sin(OMEGA * run.time.values) / OMEGA
        found.append(np.abs(run.position.values[:, 0, 0] - exact).max())
    order = float(observed_orders(steps, np.array(found))[0])
    figure("order", order)
    assert order == pytest.approx(2.0, abs=0.2)


@dataclass
class Controller:
    """Pushes against the speed with an integral: the object remembers. It keeps its calls."""

    total: float = 0.0
    last: float = 0.0

    def __post_init__(self) -> None:
        self.times: list[float] = []

    def __call__(self, t: float, state: States) -> np.ndarray:
        self.times.append(t)
        speed = state["block"].velocity[0]
        self.total += (t - self.last) * speed
        self.last = t
        return np.array([-2e3 * speed - 5e3 * self.total, 0.0, 0.0, 0.0, 0.0, 0.0])

    def get_state(self) -> dict[str, float]:
        return {"total": self.total, "last": self.last}

    def set_state(self, state: dict[str, float]) -> None:
        self.total, self.last = state["total"], state["last"]


def forgetting() -> Callable[..., np.ndarray]:
    """The same without a way to keep what it remembers."""
    controller = Controller()
    return lambda t, state: controller(t, state)


def knocking(method: Method = Method.RK4, duration: float = END) -> Scene:
    """A block that hits a wall: steps are cut, and an adaptive method rejects some."""
    wall = hs.Spring("block", (0.0, 0.0, 0.0), (5.0, 0.0, 0.0), 4.8, curve=hs.TensionCurve(*CURVE))
    body = block(MASS, ("surge",), velocity=moving(surge=-1.0))
    return scene(body, {"wall": wall}, duration, 0.05, method=method)


CURVE = (np.array([0.0, 1.0]), np.array([0.0, 2e6]))


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_a_controller_is_called_once_per_accepted_step_in_order(method: Method) -> None:
    controller = Controller()
    run = hs.simulate(knocking(method), forces={"it": hs.UserForce("block", controller, "held")})
    assert run.solver_events > 0
    assert np.all(np.diff(controller.times) > 0.0)
    assert controller.times[0] == 0.0
    assert controller.times[-1] == END
    assert run.external_calls.values[-1, 0] == len(controller.times) <= run.solver_steps + 1
    assert len(controller.times) >= run.solver_steps - run.solver_events


def test_a_controller_at_stages_is_told() -> None:
    """It is called in no order of time there. A function without memory has no such warning."""
    run = hs.simulate(with_function(Controller(), "stage"))
    assert "It remembers: choose coupling held or extrapolated." in run.attrs["warnings"]
    assert "warnings" not in hs.simulate(with_function(spring, "stage")).attrs


def test_a_run_with_a_controller_goes_on_to_the_bit(tmp_path: Path) -> None:
    """From a file, and from a checkpoint of a simulation."""

    def forces() -> dict[str, hs.UserForce]:
        return {"it": hs.UserForce("block", Controller(), "extrapolated")}

    whole = hs.simulate(knocking(), forces=forces())
    before = hs.simulate(knocking(duration=1.0), forces=forces())
    write_run(before, tmp_path / "before.nc")
    going_on = replace(knocking(duration=1.0), initial=Start(tmp_path / "before.nc"))
    after = hs.simulate(going_on, forces=forces())
    rest = whole.sel(time=slice(1.0 - 1e-9, None))
    for name in ("position", "velocity", "force_it", "energy_work_it", "external_delay_energy"):
        np.testing.assert_array_equal(after[name].values, rest[name].values, err_msg=name)
    sim = hs.Simulation(knocking(), forces=forces())
    sim.step(0.73)
    path = sim.save(tmp_path / "checkpoint")
    again = hs.Simulation(knocking(), forces=forces(), checkpoint=path)
    assert differences(again.run(), sim.run()) == []
    silent = hs.simulate(going_on)
    assert "the function it gave a force in that run" in silent.attrs["warnings"]


def test_a_function_that_may_remember_is_not_taken_up(tmp_path: Path) -> None:
    unknown = {"it": hs.UserForce("block", forgetting(), "held")}
    before = hs.simulate(knocking(duration=1.0), forces=unknown)
    going_on = replace(knocking(duration=1.0), initial=Start(before))
    with pytest.raises(hs.InputError, match="get_state and set_state"):
        hs.simulate(going_on, forces={"it": hs.UserForce("block", forgetting(), "held")})
    sim = hs.Simulation(knocking(), forces={"it": hs.UserForce("block", forgetting(), "held")})
    with pytest.raises(hs.InputError, match="get_state and set_state"):
        sim.save(tmp_path / "checkpoint")
    of_arguments = {"it": hs.UserForce("block", spring, "held", repeatable=True)}
    hs.simulate(going_on, forces=of_arguments)


COUPLINGS = ("stage", "held", "extrapolated")


@pytest.mark.parametrize("coupling", COUPLINGS)
def test_an_exception_ends_the_run_and_keeps_what_is_there(coupling: str) -> None:
    def fails(t: float, state: States) -> np.ndarray:
        if t > 1.0:
            raise ZeroDivisionError("the valve is closed")
        return np.zeros(6)

    with pytest.raises(hs.SimulationError, match=r"function of it fails .*valve") as told:
        hs.simulate(with_function(fails, coupling))
    assert isinstance(told.value.__cause__, ZeroDivisionError)
    assert told.value.__cause__.__traceback__ is not None
    run = told.value.dataset
    assert run.time.values[-1] == 1.0
    assert np.isfinite(run.position).all()
    assert run.attrs["status"] == "failed"


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize(
    ("returned", "told"),
    [
        (np.zeros(3), r"shape \(3,\); expected \(6,\)"),
        (np.full(6, np.nan), "expected finite numbers"),
        (None, "expected 6 numbers"),
        ("left", "expected 6 numbers"),
    ],
)
def test_what_is_no_wrench_is_refused(coupling: str, returned: Any, told: str) -> None:
    with pytest.raises((hs.InputError, hs.SimulationError), match=told):
        hs.simulate(with_function(lambda t, state: returned, coupling))


def test_an_interrupt_in_a_function_ends_the_run() -> None:
    def stopped(t: float, state: States) -> np.ndarray:
        if t > 1.0:
            raise KeyboardInterrupt
        return np.zeros(6)

    for coupling in COUPLINGS:
        run = hs.simulate(with_function(stopped, coupling))
        assert run.attrs["status"] == "interrupted"
        assert run.time.values[-1] == 1.0


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"coupling": "often"}, "expected stage, held, extrapolated"),
        ({"function": 3}, "expected a function"),
        ({"also": ("block",)}, "found a body twice"),
        ({"also": ("other",)}, "is no body of the scene"),
        ({"body": "other"}, "is no body of the scene"),
        ({"point": (1.0, 2.0)}, "expected 3 coordinates"),
        ({"point": (1.0, float("nan"), 0.0)}, "found .*nan.*; expected 3 coordinates"),
        ({"point": (1.0, None, 0.0)}, "expected 3 coordinates"),
        ({"point": "bow"}, "found bow; expected 3 coordinates"),
        ({"body": None}, "forces.*body: found None; expected the name of a body"),
        ({"also": (None,)}, "also: found None; expected names of bodies"),
    ],
)
def test_forces_that_cannot_be_are_refused(changes: dict[str, Any], told: str) -> None:
    given = {"body": "block", "function": spring, **changes}
    with pytest.raises(hs.InputError, match=told):
        hs.simulate(swinging(), forces={"it": hs.UserForce(**given)})


def test_names_are_new_ones() -> None:
    external = hs.UserForce("block", spring)
    with pytest.raises(hs.InputError, match="has one of that name"):
        hs.simulate(with_function(spring), forces={"it": external})
    with pytest.raises(hs.InputError, match="letters, digits"):
        hs.simulate(swinging(), forces={"my/force": external})
    held = {"it": replace(external, coupling="held")}
    with pytest.raises(hs.InputError, match="at_rest"):
        hs.simulate(replace(swinging(), at_rest=True), forces=held)


@pytest.mark.parametrize("kinematics", Kinematics)
def test_a_line_between_two_bodies_is_the_line_inside(kinematics: Kinematics) -> None:
    """Turning bodies pulled at points: places, velocities, wrenches and axes are the element's."""
    here, there = (0.4, -0.3, 0.8), (0.5, 0.2, -1.0)
    curve = np.array([0.0, 9.0]), np.array([0.0, 900.0])
    line = hs.Spring(
        "block", here, there, 1.0, curve=hs.TensionCurve(*curve), damping=50.0, anchor_body="other"
    )
    spinning = block(MASS, velocity=moving(surge=0.2, roll=0.1, yaw=-0.2))
    other = {"position": moving(heave=4.0, yaw=0.2), "velocity": moving(pitch=0.1)}
    bodies = [spinning, block(2e3, name="other", **other)]

    def pull(t: float, state: States) -> np.ndarray:
        one, other = state["block"], state["other"]
        along = other.place(there) - one.place(here)
        length = np.linalg.norm(along)
        rate = (other.velocity_of(there) - one.velocity_of(here)) @ along / length
        force = (100.0 * (length - 1.0) + 50.0 * rate) * along / length
        return np.array([one.wrench(force, here), other.wrench(-force, there)])

    def push(t: float, state: States) -> np.ndarray:
        return np.array([100.0, 50.0, -30.0, 5.0, 6.0, 7.0])

    inside = {"line": line, "push": steady_at(here)}
    one = scene(bodies, inside, END, 0.02, kinematics=kinematics)
    pulled = hs.UserForce("block", pull, also=("other",))
    given = {"line": pulled, "push": hs.UserForce("block", push, point=here)}
    expected, found = hs.simulate(one), hs.simulate(replace(one, forces=given))
    assert np.abs(expected.position[:, 0, 3:]).max() > 0.05
    np.testing.assert_allclose(found.position, expected.position, rtol=0.0, atol=1e-11)


def steady_at(point: tuple[float, float, float]) -> Any:
    force = steady(surge=100.0, sway=50.0, heave=-30.0, roll=5.0, pitch=6.0, yaw=7.0)
    return replace(force, point=point)


def test_a_body_on_a_ball_joint() -> None:
    """Its coordinates are those of the joint: the function is given angles as in the dataset, and
    a resistance that is alike in all directions is that of the element."""
    rates = tuple(Acting(velocity=rate) for rate in (0.5, -0.8, 0.4))
    hung = joint_of("ball", "block", None, *rates, point=(0.0, 0.0, 2.0))
    resistance = np.diag([30.0] * 3 + [200.0] * 3)
    inside = {"it": hs.LinearDamping("block", resistance)}
    whole = replace(scene(block(MASS), inside, END, 0.02), joints={"ball": hung})
    seen = []

    def resist(t: float, state: States) -> np.ndarray:
        return -resistance @ state["block"].velocity

    def watch(t: float, state: States) -> np.ndarray:
        seen.append((t, state["block"].position))
        return np.zeros(6)

    forces = {"it": hs.UserForce("block", resist), "watch": hs.UserForce("block", watch, "held")}
    expected, found = hs.simulate(whole), hs.simulate(replace(whole, forces=forces))
    assert np.abs(expected.position[:, 0, 3:]).max() > 0.5
    np.testing.assert_allclose(found.position, expected.position, rtol=0.0, atol=1e-12)
    at = dict(seen)
    for time, position in zip(found.time.values, found.position.values[:, 0], strict=True):
        np.testing.assert_array_equal(at[time], position)


def test_a_second_process_compiles_nothing(tmp_path: Path) -> None:
    """The machine code on disk holds no address of a function."""
    program = """
import sys
sys.path[:0] = {path!r}
from test_external import spring, with_function
import hydrosim as hs
from hydrosim.jit.waiting import at_first_compile
compiled = []
with at_first_compile(lambda: compiled.append(1)):
    for coupling in ("stage", "held"):
        hs.simulate(with_function(spring, coupling))
print("compiled" if compiled else "loaded")
"""
    hs.simulate(with_function(spring, "stage"))
    hs.simulate(with_function(spring, "held"))
    assert printed(program.format(path=sys.path)).strip() == "loaded"


def test_records_say_which_function_acted() -> None:
    """The case that repeats a run, its summary, and many runs, which have no functions."""
    case = hs.load_case(CASES / "base.yaml", {"duration": 5.0})
    held = hs.UserForce("barge", lambda t, state: np.zeros(6), "held")
    run = hs.simulate(case, forces={"nothing": held})
    assert "# not in this file" in case_of(run)
    assert "<lambda> on barge, held (order 1)" in case_of(run)
    heads = [node.head[0] for node in summary(run) if isinstance(node, Table)]
    assert "external force" in heads
    with pytest.raises(hs.InputError, match="functions of Python in run 0, it"):
        hs.simulate_many([with_function(spring)])


@pytest.mark.parametrize("wrong", [spring, "spring", None, 3.0])
def test_what_is_no_element_is_refused(wrong: Any) -> None:
    with pytest.raises(hs.InputError) as caught:
        hs.simulate(swinging(), forces={"it": wrong})
    assert f"forces.it: found {type(wrong).__name__}; expected a force element" in str(caught.value)
    assert ("hydrosim.UserForce(BODY, FUNCTION)" in str(caught.value)) == callable(wrong)


@pytest.mark.parametrize(
    ("function", "told"),
    [
        (lambda t, state: state["barge"].velocity, "no body 'barge'; expected one of block"),
        (lambda t, state: state["block"].surge, "no 'surge'; it has position and velocity"),
    ],
)
def test_a_function_is_told_what_there_is(function: Callable[..., Any], told: str) -> None:
    with pytest.raises(hs.InputError, match=told):
        hs.simulate(with_function(function))


def test_an_error_names_functions_at_stages() -> None:
    """A latch that remembers when it closed gives another force at trial steps."""
    state_of_latch = {"until": 0.0, "speed": 0.0}

    def latch(t: float, state: States) -> np.ndarray:
        speed = state["block"].velocity[0]
        if speed * state_of_latch["speed"] < 0.0:
            state_of_latch["until"] = t + 0.2
        state_of_latch["speed"] = speed
        return spring(t, state) - (t < state_of_latch["until"]) * 1e4 * np.eye(6)[0] * speed

    run = hs.simulate(with_function(latch))
    assert "The function of it is called at every stage" in run.attrs["warnings"]
    assert "coupling='held'" in run.attrs["warnings"]
