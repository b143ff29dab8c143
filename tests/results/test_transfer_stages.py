"""A weight that goes from legs to pads and back: stages, points and clearances, by hand."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from reading import number, row
from scenes import block, moving, scene, steady, table

import hydrosim as hs
from hydrosim.elements import linear_mooring
from hydrosim.elements.contact.group import GROUP_STATES as GROUP_STATES
from hydrosim.errors import InputError
from hydrosim.report.charts.pictures import PICTURES
from hydrosim.report.sentences.run import run_document
from hydrosim.results.phases import STAGES, TRANSFER_FRACTIONS, stages
from hydrosim.scene import Clearance, Kinematics, LinearScenes, Scene, Solver, Start, Weight
from hydrosim.statistics.explain import WHOLE_RUN, explain_run

MASS, WEIGHT = 1e5, 9.81e5
K = 1e7  # N/m of each: legs together, pads together
CORNERS = np.array([[x, y, -2.0] for x in (-5.0, 5.0) for y in (-4.0, 4.0)])
LINE = hs.NormalCurve(np.array([0.0, 1.0]), np.array([0.0, K / 4]))


def removal(rate: float = 1e3, lift: float = 3.0) -> Scene:
    """A topside on four legs that a table lifts off, which a force presses up: slowly, by ``lift``
    of its weight per thousand seconds."""
    top = block(
        MASS,
        ("heave",),
        "top",
        weight=Weight.CARRIED,
        points={"keel": (0.0, 0.0, -2.0)},
        position=moving(heave=-WEIGHT / K),
    )
    barge = block(2e5, ("heave",), "barge", location=(0.0, 0.0), position=moving(heave=-0.5))
    barge = replace(barge, points={"deck": (0.0, 0.0, -2.0)})
    stiff, damping = np.zeros((6, 6)), np.zeros((6, 6))
    stiff[2, 2], damping[2, 2] = 2e6, 2e6
    push = table([0.0, 1000.0], [np.zeros(6), moving(heave=lift * WEIGHT)])
    forces = {
        "leg": hs.Landing("top", CORNERS, hs.Seats(CORNERS), LINE, hs.Frictionless(), group="legs"),
        "pad": hs.Fender(
            "barge", CORNERS, hs.Plane((0, 0, -2.0), (0, 0, -1), "top"), LINE, hs.Frictionless()
        ),
        "water": linear_mooring.LinearMooring("barge", stiff, damping),
        "sink": hs.AppliedForce("barge", (0.0, 0.0, 0.0), table([0.0], [moving(heave=-1e6)])),
        "lift": hs.AppliedForce("barge", (0.0, 0.0, 0.0), push),
    }
    run = scene((top, barge), forces, 1000.0, 1.0, step=0.05)
    return run.with_output(clearances={"gap": Clearance("keel of top", "deck of barge")})


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return hs.simulate(removal())


def test_quasi_static_times_of_the_stages(run):
    """Slow: barge at -0.5 m + L / k until it touches at -W / K, then W moves by the springs."""
    found = xr.Dataset(stages(run))
    pads = found.stage_time.sel(contact_group="pad")
    legs = found.stage_time.sel(contact_group="legs")
    rate = 3.0 * WEIGHT / 1000.0  # N/s
    touch = (0.5 - WEIGHT / K) * 2e6 / rate
    assert float(pads.sel(stage="first contact")) == pytest.approx(touch, abs=3.0)
    # in contact: top rests on K (legs) and K (pads) on the barge on 2e6 N/m
    series = 1.0 / (1.0 / K + 1.0 / (2e6))  # what the barge's heave meets through the pads alone
    assert series < K
    for part in TRANSFER_FRACTIONS[:-1]:
        # legs lose part W: top rises by part W / K; pads carry part W, so that the barge is
        # part W / K above the top's rise, and the water has given back 2e6 of its rise
        rise = part * WEIGHT / K + part * WEIGHT / K
        at = touch + (part * WEIGHT + 2e6 * rise) / rate
        assert float(pads.sel(stage=f"{part:.0%} transferred")) == pytest.approx(at, abs=5.0)
        assert float(legs.sel(stage=f"{part:.0%} transferred")) == pytest.approx(at, abs=5.0)
    off = touch + (WEIGHT + 2e6 * 2 * WEIGHT / K) / rate
    assert float(legs.sel(stage="open")) == pytest.approx(off, abs=3.0)
    assert [*found.stage.values] == [*STAGES]
    assert float(found.end_clearance.sel(contact_group="legs")) > 0.1


def test_loads_at_every_record_are_weight_and_inertia():
    """Barge and supports carry m (g + a), to rounding, also where they are thrown about; that a is
    the rate of the velocity the next test sees to."""
    run = hs.simulate(replace(removal(lift=200.0), duration=20.0).with_output(accelerations=True))
    load = run.contact_load
    total = load.sel(contact_group="legs") + load.sel(contact_group="pad")
    a = run.acceleration.sel(body="top", dof="heave").values
    assert np.abs(total.values - WEIGHT - MASS * a).max() < 1e-12 * WEIGHT
    assert np.abs(MASS * a).max() > 0.02 * WEIGHT
    force = sum(run[f"force_{name}"].sel(body="top", dof="heave") for name in ("leg", "pad"))
    assert force.values == pytest.approx(total.values, rel=1e-12)


def test_impulses_of_contacts_add_up_to_those_of_their_group():
    """Both are in the run, and it can be explained."""
    run = hs.simulate(removal().with_output(impulses=True))
    each = run.contact_impulse.sum(["fender", "contact_mode"]).values
    group = run.group_impulse.sum("contact_group").values
    assert each - each[0] == pytest.approx(group - group[0], rel=1e-9, abs=1e-9 * np.ptp(group))
    assert WHOLE_RUN in explain_run(run).span


def test_accelerations_are_the_rates_of_velocities():
    """A body that tumbles on springs: what its accelerations integrate to, by Simpson's rule over
    records, at its order."""
    stiffness = np.diag([3e3, 2e3, 4e3, 5e3, 6e3, 7e3])
    spin = moving(surge=1.0, sway=0.3, heave=-0.5, roll=0.7, pitch=-0.4, yaw=1.1)
    line = linear_mooring.LinearMooring("block", stiffness, np.zeros((6, 6)))
    missed = []
    for step in (0.02, 0.01):
        tumbling = scene(block(1e3, velocity=spin), {"line": line}, 4.0, step)
        run = hs.simulate(tumbling.with_output(accelerations=True))
        a, v = run.acceleration.values[:, 0], run.velocity.values[:, 0]
        assert np.ptp(a, axis=0).min() > 0.1
        gained = step / 3.0 * (a[:-2:2] + 4.0 * a[1::2] + a[2::2])
        missed.append(np.abs(np.cumsum(gained, axis=0) - (v[2::2] - v[0])).max())
    assert missed[1] < 1e-6
    assert np.log2(missed[0] / missed[1]) > 3.7
    assert "acceleration" not in hs.simulate(tumbling)


def test_named_points_and_clearances(run):
    top, barge = (run.position.sel(body=b, dof="heave").values for b in ("top", "barge"))
    keel = run.point_position.sel(point="keel of top", axis="z").values
    assert keel == pytest.approx(top - 2.0, abs=1e-12)
    assert run.clearance.sel(gap="gap").values == pytest.approx(np.abs(top - barge), abs=1e-12)


@pytest.mark.parametrize("kinematics", Kinematics)
def test_points_of_a_body_that_turns(kinematics):
    """Against the rotation matrix of z-y'-x'', and a plane that turns with another body."""
    still = LinearScenes.STEP
    angles = moving(surge=1.0, roll=0.2, pitch=-0.1, yaw=0.3)
    ship = block(1.0, (), "ship", position=angles, points={"bow": (3.0, 1.0, -0.5)})
    other = block(1.0, ("surge",), "other", position=moving(pitch=0.2))
    plane = Clearance("bow of ship", None, hs.Plane((1.0, 0.0, 0.5), (0.0, 0.0, 2.0), "other"))
    solver = Solver(step=0.1, kinematics=kinematics, linear=still)
    at = Scene("points", 0.2, (ship, other), solver=solver, output={"step": 0.1})
    run = hs.simulate(at.with_output(clearances={"over": plane}))
    a, b, c = 0.2, -0.1, 0.3
    Rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    Ry = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    Rz = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    little = np.eye(3) + np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    R = Rz @ Ry @ Rx if kinematics is Kinematics.EXACT else little
    bow = [1.0, 0.0, 0.0] + R @ [3.0, 1.0, -0.5]
    assert run.point_position.values[-1, 0] == pytest.approx(bow, abs=1e-12)
    s = np.array([[np.cos(0.2), 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, np.cos(0.2)]])
    s = s if kinematics is Kinematics.EXACT else np.array([[1, 0, 0.2], [0, 1, 0], [-0.2, 0, 1]])
    expected = (bow - s @ [1.0, 0.0, 0.5]) @ (s @ [0.0, 0.0, 1.0])
    assert run.clearance.values[-1, 0] == pytest.approx(expected, abs=1e-12)


def test_a_clearance_of_nothing_is_refused():
    bad = removal().with_output(clearances={"gap": Clearance("mast of top", "deck of barge")})
    with pytest.raises(InputError, match=r"clearances\.gap\.of: found mast of top; expected one"):
        hs.compile_scene(bad)


def test_recontacts_their_number_force_and_speed():
    """A topside that is thrown up off its legs and bounces on them without loss: v and v sqrt(m K)
    each time, besides its weight."""
    top = block(
        MASS,
        ("heave",),
        "top",
        weight=Weight.CARRIED,
        position=moving(heave=-WEIGHT / K),
        velocity=moving(heave=2.0),
    )
    legs = hs.Landing("top", CORNERS, hs.Seats(CORNERS), LINE, hs.Frictionless())
    run = hs.simulate(scene(top, {"legs": legs}, 3.0, 0.05, step=0.002))
    found = xr.Dataset(stages(run)).sel(contact_group="legs")
    y = WEIGHT / K
    v = np.sqrt(4.0 + 9.81 * y - 2 * 9.81 * y)  # m v^2 / 2 + m g y - K y^2 / 2 = m 2^2 / 2
    amplitude = np.sqrt(v**2 * MASS / K + y**2)
    assert float(found.recontact_speed) == pytest.approx(v, rel=1e-6)
    assert float(found.recontact_force) == pytest.approx(K * (amplitude + y) / 4, rel=1e-4)
    cycle = 2 * v / 9.81 + 2 * (np.pi - np.arctan(v * np.sqrt(MASS / K) / y)) / np.sqrt(K / MASS)
    assert float(found.recontacts) == 4 * np.ceil((3.0 - 2 * v / 9.81) / cycle)


def test_records_seldom_or_often_tell_the_same():
    """Times, counts, speeds and forces are of events and steps; shares of the weight of an impulse
    that is known to order 4 between records."""
    brisk = replace(removal(lift=30.0), duration=120.0)
    often, seldom = (hs.simulate(brisk.with_output(step=step)) for step in (0.25, 1.0))
    assert often.recontacts.sel(contact_group="pad") == 0.0
    assert float(often.stage_time.sel(contact_group="legs", stage="separated")) > 0.0
    for name, found in stages(often).items():
        if name not in ("stage_time", "end_clearance"):
            assert np.array_equal(found, seldom[name], equal_nan=True), name
    apart = (often.stage_time - seldom.stage_time).values
    assert np.nanmax(np.abs(apart)) < 1e-2
    exact = [STAGES.index(name) for name in ("first contact", "open", "separated")]
    assert np.nanmax(np.abs(apart[:, exact])) == 0.0


def bouncing(**contact: object) -> Scene:
    """A block that falls on a fender from 0.3 m, and bounces without loss."""
    feet = hs.Fender(
        "block", CORNERS, hs.Plane((0, 0, -2.0), (0, 0, 1)), LINE, hs.Frictionless(), **contact
    )
    body = block(MASS, ("heave",), position=moving(heave=0.3))
    return scene(body, {"feet": feet, "pull": steady(heave=-WEIGHT)}, 2.5, 0.25, step=0.002)


def test_a_plain_fender_tells_its_impacts_where_it_has_a_group():
    """Without a weight that is known: times and speeds of free fall and of a spring."""
    run = hs.simulate(bouncing(group="feet")).sel(contact_group="feet")
    falls, v = np.sqrt(0.6 / 9.81), np.sqrt(0.6 * 9.81)
    root, rest = np.sqrt(MASS / K), WEIGHT / K
    stays = 2 * root * (np.pi - np.arctan(v * root / rest))
    cycles = int((2.5 - falls) / (2 * falls + stays))
    times = {stage: float(run.stage_time.sel(stage=stage)) for stage in STAGES}
    assert times["first contact"] == pytest.approx(falls, abs=1e-9)
    assert times["open"] == pytest.approx(falls + stays, rel=1e-7)
    assert times["separated"] == pytest.approx(
        falls + stays + cycles * (2 * falls + stays), rel=1e-6
    )
    assert np.isnan(times["50% transferred"])
    assert (float(run.closings), float(run.recontacts)) == (4 * (cycles + 1), 4 * cycles)
    assert float(run.closing_speed) == pytest.approx(v, rel=1e-7)
    assert float(run.recontact_speed) == pytest.approx(v, rel=1e-6)
    peak = (rest + np.sqrt(v**2 * root**2 + rest**2)) * K / 4
    assert float(run.largest_contact_force) == pytest.approx(peak, rel=1e-4)
    assert float(run.recontact_force) == pytest.approx(peak, rel=1e-4)


def test_nothing_is_transferred_before_the_first_contact():
    """The mean over a minute looks ahead: it is above all parts before a short fall ends."""
    top = block(MASS, ("heave",), "top", weight=Weight.CARRIED, position=moving(heave=0.3))
    legs = hs.Landing("top", CORNERS, hs.Seats(CORNERS), LINE, hs.Frictionless())
    times = hs.simulate(scene(top, {"legs": legs}, 20.0, 0.5, step=0.002)).stage_time.values[0]
    assert times[0] == pytest.approx(np.sqrt(0.6 / 9.81), abs=1e-9)
    assert np.all(times[1 : 1 + len(TRANSFER_FRACTIONS)] == times[0])


def test_without_a_group_nothing_is_remembered():
    plain, told = hs.compile_scene(bouncing()), hs.compile_scene(bouncing(group="feet"))
    assert told.model.size == plain.model.size + GROUP_STATES
    run, other = hs.simulate(plain), hs.simulate(told)
    assert "stage_time" not in run
    for name in ("position", "velocity", "fender_normal_force", "energy_residual"):
        assert np.array_equal(run[name], other[name])


def test_a_restart_knows_the_stages_before_it():
    whole = hs.simulate(bouncing(group="feet").with_output(states=True))
    again = hs.simulate(replace(bouncing(group="feet"), duration=1.5, initial=Start(whole, 1.0)))
    for name, found in stages(whole).items():
        assert np.array_equal(found, again[name], equal_nan=True), name
    unknown = hs.simulate(bouncing().with_output(states=True))
    new = hs.simulate(replace(bouncing(group="feet"), duration=1.5, initial=Start(unknown, 1.0)))
    first = float(new.stage_time.sel(contact_group="feet", stage="first contact"))
    assert first >= 1.0


def test_the_summary_and_the_picture_tell_the_stages(run):
    nodes = run_document(run).nodes
    assert number(row(nodes, "stage or figure", of=["first contact"])["legs"], "s") == 0.0
    smallest = row(nodes, "clearance", of=["gap"])["smallest"]
    assert number(smallest, "m") == run.clearance.sel(gap="gap").min()
    assert len(PICTURES["_transfer"](run)) == 5
