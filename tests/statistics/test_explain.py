"""`explain_run` against records made by hand: a point that slips to and fro, under a load that is
larger one way, and for longer that way."""

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from reading import ends, number, row, rows

from hydrosim.dofs import DOFS
from hydrosim.elements.contact.kind import MODES
from hydrosim.errors import InputError
from hydrosim.files.document import Document
from hydrosim.report.sentences.explanation import explanation, mean_cell
from hydrosim.results.phases import STAGES, Phase
from hydrosim.statistics.explain import (
    COVARIANCE,
    DIRECTION,
    IN_CONTACT,
    JOINT_REACTIONS,
    OTHER,
    REACTION,
    SLIP_DAMPING,
    STICK,
    WHOLE_RUN,
    explain_run,
)

MU = 0.2
EVERY = 1.0  # s
WAYS = [  # seconds, mode, N, direction of slip, C3 |v2|
    *((10.0, "open", 0.0, 0.0, 0.0), (3.0, "slip", 4e6, 1.0, 3e3), (2.0, "stick", 6e6, 0.0, 0.0)),
    *((1.0, "slip", 1e6, -1.0, 1e3), (4.0, "stick", 2e6, 0.0, 0.0)),
]
QUARTERS = [f"{a} to {b}" for a, b in pairwise(STAGES[:4])]
HELD = -5e5  # N of friction in stick
AXES = ["x", "y", "z"]


def made() -> xr.Dataset:
    """A run of one point with all integrals in closed form, and a force that balances friction."""
    ends = np.cumsum([0.0, *(seconds for seconds, *_ in WAYS)])
    time = np.arange(0.0, ends[-1] + EVERY, EVERY)

    def summed(*rates: float) -> np.ndarray:
        return np.interp(
            time, ends, np.cumsum([0.0, *(s * r for (s, *_), r in zip(WAYS, rates, strict=True))])
        )

    def along_x(values: np.ndarray) -> np.ndarray:
        return np.stack([values, 0.0 * time, 0.0 * time], axis=-1)[:, None]

    modes = [mode for _, mode, *_ in WAYS]
    slip = [-(MU * N + c3) * d for _, _, N, d, c3 in WAYS]
    friction = {
        mode: [
            HELD if m == mode == "stick" else f if m == mode == "slip" else 0.0
            for m, f in zip(modes, slip, strict=True)
        ]
        for mode in MODES
    }
    each = {mode: along_x(summed(*friction[mode])) for mode in MODES}
    total = sum(x[:, 0, 0] for x in each.values())
    N, d = [w[2] for w in WAYS], [w[3] for w in WAYS]
    inside = {mode: [float(m == mode) for m in modes] for mode in MODES}
    impulse, none = np.zeros((time.size, 2, 1, 6)), np.zeros((time.size, 1, 6))
    impulse[:, 0, 0, 0], impulse[:, 1, 0, 0] = total, -total
    by_mode, at = ("time", "fender", "contact_mode"), ("time", "fender", "axis")

    def per_mode(rates: list[float]) -> np.ndarray:
        return np.stack([summed(*np.multiply(rates, inside[m]))[:, None] for m in MODES], axis=2)

    ahead = [max(x, 0.0) for x in d]
    nothing = np.zeros((time.size, 1, 3, 3))
    phase = np.where(time < 10.0, Phase.MOORED, Phase.INITIAL_CONTACT)
    return xr.Dataset(
        {
            "position": (("time", "body", "dof"), none),
            "momentum": (("time", "body", "dof"), none),
            "energy_kinetic": ("time", 0.0 * time),
            "impulse": (("time", "force", "body", "dof"), impulse),
            "work": (("time", "force", "body", "dof"), 0.0 * impulse),
            "contact_phase": (("time", "contact_group"), phase[:, None]),
            "contact_time": (by_mode, per_mode([1.0] * len(WAYS))),
            "contact_impulse": (by_mode, per_mode(N)),
            "contact_friction": ((*by_mode, "axis"), np.stack([each[m] for m in MODES], axis=2)),
            **{
                f"contact_{x}": ((*by_mode, "axis"), nothing)
                for x in ("press", "moved", "friction_work")
            },
            "contact_press_work": (by_mode, nothing[..., 0]),
            "slip_direction": (at, along_x(summed(*d))),
            "slip_load": (at, along_x(summed(*np.multiply(N, d)))),
            "slip_damping": (at, along_x(summed(*np.multiply(d, [w[4] for w in WAYS])))),
            "slip_moved": (at, along_x(summed(*d))),
            "slip_direction_ahead": (at, along_x(summed(*ahead))),
            "slip_load_ahead": (at, along_x(summed(*np.multiply(N, ahead)))),
            "slip_moved_ahead": (at, along_x(summed(*ahead))),
        },
        coords={
            "time": time,
            "body": ["barge"],
            "dof": list(DOFS),
            "axis": AXES,
            "force": ["pad", "push"],
            "contact_mode": list(MODES),
            "fender": ["pad 1"],
            "contact_group": ["pad"],
            "fender_group": ("fender", ["pad"]),
            "fender_kinetic": ("fender", [MU]),
        },
    )


def parts(found: xr.Dataset, span: str) -> dict[str, float]:
    """Sums over a span [N s] in x."""
    at = found.sel(span=span, fender="pad 1", direction="x")
    time = float(at.span_end - at.span_begin)
    return {str(p): time * float(at.friction_part.sel(part=p)) for p in at.part.values}


def test_what_friction_comes_from() -> None:
    """Three seconds of slip ahead under 4 MN, one astern under 1 MN: E[N] = 3.25 MN, E[d] = 0.5,
    E[N d] = 2.75 MN; six seconds of stick."""
    found = explain_run(made())
    for span in (WHOLE_RUN, IN_CONTACT, "initial contact"):
        assert parts(found, span) == pytest.approx(
            {
                STICK: 6.0 * HELD,
                DIRECTION: -MU * 4.0 * 3.25e6 * 0.5,
                COVARIANCE: -MU * 4.0 * (2.75e6 - 3.25e6 * 0.5),
                SLIP_DAMPING: -(3.0 * 3e3 - 1.0 * 1e3),
                OTHER: 0.0,
            },
            rel=1e-12,
            abs=1e-6,
        )
    at = found.sel(span=WHOLE_RUN, fender="pad 1", direction="x")
    assert float(at.load_ahead) == pytest.approx(4e6)
    assert float(at.load_astern) == pytest.approx(1e6)
    assert float(at.slip_ahead) == pytest.approx(3.0)
    assert float(at.slip_astern) == pytest.approx(-1.0)


def test_spans_that_are_not_there_are_no_numbers() -> None:
    found = explain_run(made())
    assert np.isnan(found.mean_force.sel(span="stuck")).all()
    assert parts(found, "moored") == pytest.approx(dict.fromkeys(parts(found, "moored"), 0.0))
    assert float(found.span_end.sel(span="moored")) == 10.0


def test_a_part_of_a_run() -> None:
    """The slip astern alone has no covariance."""
    found = explain_run(made(), 15.0, 16.0)
    assert parts(found, WHOLE_RUN)[DIRECTION] == pytest.approx(MU * 1e6)
    assert parts(found, WHOLE_RUN)[COVARIANCE] == pytest.approx(0.0, abs=1e-6)
    with pytest.raises(InputError, match=r"found 1 output times from 3 to 3\.5 s"):
        explain_run(made(), 3.0, 3.5)


def test_what_is_held_has_a_reaction_of_its_own() -> None:
    """A push of 3 kN in sway, where the body does not move: nothing is left of it; a push of 2 kN
    in surge, where it does, is a fault of the momentum and stays one."""
    run = made()
    pushed = 1e3 * run.time * xr.DataArray([2.0, 3.0], {"dof": ["surge", "sway"]}, "dof")
    run.impulse.loc[{"force": "push", "body": "barge", "dof": ["surge", "sway"]}] += pushed
    run.position.loc[{"dof": "surge"}] += run.time * 1e-3
    whole = explain_run(run).sel(span=WHOLE_RUN, body="barge")
    held = whole.mean_force.sel(force=REACTION)
    assert float(held.sel(dof="sway")) == pytest.approx(-3e3)
    assert float(held.sel(dof="surge")) == 0.0
    assert float(whole.unbalanced.sel(dof="sway")) == pytest.approx(0.0, abs=1e-9)
    assert float(whole.unbalanced.sel(dof="surge")) == pytest.approx(2e3)
    title = "barge in sway"
    assert row(
        explanation(explain_run(run), "barge", "sway"), title, of=[f"mean force, {REACTION}"]
    )
    surge = rows(explanation(explain_run(run), "barge", "surge"), "barge in surge")
    assert not any(REACTION in str(each["barge in surge"]) for each in surge)


def test_reactions_of_joints_are_what_other_forces_lack() -> None:
    """A push of 2 kN in surge that a joint of a tree takes; a lock has an impulse of its own."""
    run = made()
    run.impulse.loc[{"force": "push", "body": "barge", "dof": "surge"}] += 2e3 * run.time
    run.position.loc[{"dof": "surge"}] += run.time * 1e-3
    joined = explain_run(run.assign_coords(joint=["pin", "stop"], lock=["stop"]))
    whole = joined.sel(span=WHOLE_RUN, body="barge", dof="surge")
    assert float(whole.mean_force.sel(force=JOINT_REACTIONS)) == pytest.approx(-2e3)
    assert float(whole.unbalanced) == pytest.approx(0.0, abs=1e-9)
    told = explanation(joined, "barge", "surge")
    assert row(told, "barge in surge", of=[f"mean force, {JOINT_REACTIONS}"])
    locked = explain_run(run.assign_coords(joint=["stop"], lock=["stop"]))
    whole = locked.sel(span=WHOLE_RUN, body="barge", dof="surge")
    assert float(whole.mean_force.sel(force=JOINT_REACTIONS)) == 0.0
    assert float(whole.unbalanced) == pytest.approx(2e3)


def test_stages_of_a_transfer() -> None:
    """From 2 s to 11 s the first quarter, to 14 s the second; what it does not come to has no
    numbers. A group without a weight has phases alone."""
    times = [2.0, 11.0, 14.0, np.nan, np.nan, np.nan, np.nan]
    run = made().assign(stage_time=(("contact_group", "stage"), [times]))
    run = run.assign_coords(stage=list(STAGES), contact_weight=("contact_group", [1e7]))
    found = explain_run(run)
    ends = [
        (float(found.span_begin.sel(span=s)), float(found.span_end.sel(span=s))) for s in QUARTERS
    ]
    assert ends[:2] == [(2.0, 11.0), (11.0, 14.0)]
    assert np.isnan(ends[2]).all()
    assert parts(found, QUARTERS[1])[STICK] == pytest.approx(HELD)  # from 13 s on
    none = explain_run(run.assign_coords(contact_weight=("contact_group", [np.nan])))
    assert not set(QUARTERS) & set(none.span.values)


def test_a_run_without_impulses_is_told_what_it_lacks() -> None:
    with pytest.raises(InputError, match=r"without impulse, momentum; .*output.impulses=true"):
        explain_run(made().drop_vars(["impulse", "momentum"]))


def test_means_over_runs_have_the_interval_of_student() -> None:
    """Of five numbers with standard deviation sqrt(2.5): t(0.95, 4) = 2.1318 (tables)."""
    x = xr.DataArray([1.0, 2.0, 3.0, 4.0, 5.0], dims="run")
    mean, interval = mean_cell(x, "m").parts
    assert number(mean, "m") == 3.0
    half = 2.131847 * np.sqrt(2.5 / 5.0)
    assert ends(interval, "m") == pytest.approx((3.0 - half, 3.0 + half), rel=1e-6)
    assert number(mean_cell(x[:1], "m"), "m") == 1.0
    assert mean_cell(x * np.nan, "m") == ""


def test_the_lines_say_each_figure_once() -> None:
    nodes = list(explanation(explain_run(made()), "barge", "surge"))
    text = str(Document("made", nodes))
    assert "nan" not in text
    assert text.count("mean force, pad [kN]") == 1
    pad = row(nodes, "barge in surge", of=["mean force, pad"])
    assert number(pad[WHOLE_RUN], "N") == pytest.approx(-260.4e3, rel=1e-6)
    # (6 HELD - 4 MU E[N d] - 8e3) / 20 s
    assert "stuck" not in text
