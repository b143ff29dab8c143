"""The score card: the share of seeds that agree with each observation of the thesis.

A criterion is a function of the figures of one seed. Its docstring quotes the thesis. A number that
the thesis reports of one run counts as met within a quarter of it, or within half of it where the
thesis puts +- before it and means "about". The bounds are ours. Crawl is counted towards -x: a run
that goes towards +x crawls less than one that stays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from benchmarks.report import Row
from cases.reverse_float_over.thesis.aggregates import share_of
from cases.reverse_float_over.thesis.runner import Figures, Record

Of = Callable[[str], Figures]
"""Figures of a variant, of one seed."""
Test = Callable[[Of], bool]

BASE = "base case"
TENTH_OF_FENDERS = 3.15  # kN: a tenth of the mean fender force of 31.5 kN
STEEL_SHAKES = 5.0  # times the heave velocity of the fine step
MOSTLY = 0.8  # share of stick from which a barge counts as stuck, as in hydrosim.results.phases
CHATTERS = 0.25  # share of steps in which the acceleration changes sign
STAYS = 1e-3  # m: a block that moves less has stayed


def swings_about_zero_without_friction(of: Of) -> bool:
    """'In the x direction the barge oscillates around 0.' (3.2.4)"""
    run = of("no friction, lifted 1.5 m")
    return abs(run["lifted_mean"]) < 0.05 and run["lifted_least"] < 0.0 < run["lifted_most"]


def finds_place_within_100_s(of: Of) -> bool:
    """'After roughly +-100 s a new equilibrium is found' (3.2.4)"""
    return 50.0 <= of("friction, lifted 1.5 m")["found_after"] <= 150.0


def place_is_half_a_metre_off(of: Of) -> bool:
    """'+-0.50 m of the original equilibrium position' (3.2.4)"""
    return 0.25 <= abs(of("friction, lifted 1.5 m")["lifted_mean"]) <= 0.75


def smaller_step_ends_oscillation(of: Of) -> bool:
    """'The oscillations ... were removed by reducing the time step of dt = 0.1 to dt = 0.01 s.'
    (3.2.3)"""
    name = "heave_velocity_on_steel"
    return of("rk2 at 0.1 s")[name] > STEEL_SHAKES * of("rk2 at 0.01 s")[name]


def crawls_against_waves_when_pressed(of: Of) -> bool:
    """'There is also negative crawling behaviour observed.' (3.3)"""
    return _pressed_crawl(of) < 0.0


def crawls_07_m_when_pressed(of: Of) -> bool:
    """'The barge moves +-0.70 m in the direction the waves are coming from.' (3.3)"""
    return -1.05 <= _pressed_crawl(of) <= -0.35


def mean_wave_force_is_nothing(of: Of) -> bool:
    """'The mean wave force is almost 0 with a value of 0.840 kN.' (3.3.1, six seeds)"""
    return abs(of(BASE)["waves"]) < TENTH_OF_FENDERS


def mean_fender_force_is_negative(of: Of) -> bool:
    """'The mean force given in the fender on the other hand is -31.545 kN.' (3.3.1, six seeds)"""
    return of(BASE)["fenders"] < 0.0


def soft_slopes_creep(of: Of) -> bool:
    """'When b = 10^4, 10^6 the mass starts moving as soon as the force is exerted' (4.2)"""
    return all(of(f"slope {b}")["creep"] > STAYS for b in ("1e4", "1e6"))


def slope_1e8_is_not_stuck(of: Of) -> bool:
    """'At b = 10^8 ... the mass is not yet in stick condition' (4.2)"""
    return of("slope 1e8")["creep"] > STAYS


def slope_1e10_stays(of: Of) -> bool:
    """'At b = 10^10 the mass stays at the initial location' (4.2)"""
    return of("slope 1e10")["creep"] < STAYS


def slope_1e10_oscillates_in_explicit_steps_only(of: Of) -> bool:
    """'At b = 10^10 oscillations can be observed in the aNySIM run ... in the matlab run there are
    no oscillations' (4.2)"""
    chatters = of("slope 1e10, explicit")["reversals"] > CHATTERS
    return chatters and of("exact")["reversals"] == 0.0


def moored_surge_is_positive(of: Of) -> bool:
    """'a positive mean displacement due to the second order mean drift forces' (6.3.4)"""
    return of(BASE)["moored_mean"] > 0.0


def initial_contact_crawls_back(of: Of) -> bool:
    """'In the initial contact phase crawling motion in the negative x direction is visible.'
    (6.3.4)"""
    return _initial_contact(of(BASE)) < 0.0


def friction_acts_more_ahead(of: Of) -> bool:
    """'The motion in positive x direction encounters more friction forces than the motion in
    negative x direction' (6.3.4)"""
    base = of(BASE)
    return abs(base["fenders_moving_ahead"]) > abs(base["fenders_moving_back"])


def compressed_crawls_ahead(of: Of) -> bool:
    """'During the compressed phase a small positive crawling behaviour ... is visible.' (6.3.4)"""
    return _compressed(of(BASE)) > 0.0


def compressed_crawls_030_m(of: Of) -> bool:
    """'In the 500 seconds of the compressed phase the barge has a crawling distance of
    dx = 0.30 m.' (6.3.3)"""
    return 0.225 <= _compressed(of(BASE)) <= 0.375


def ends_at_120_m(of: Of) -> bool:
    """'the barge has found its final position at x = -1.20 m' (6.3.3)"""
    return -1.5 <= _end(of(BASE)) <= -0.9


def sticks_from_1500_s(of: Of) -> bool:
    """'When t > 1500 s the top of the interface is in stick condition' (6.4.2)"""
    return of(BASE)["stick_1500_2000"] >= MOSTLY


def initial_contact_matters_most(of: Of) -> bool:
    """'Of all 3 stages the initial contact phase has the biggest influence' (6.3.4)"""
    base = of(BASE)
    others = abs(base["surge_600"]), abs(_compressed(base))
    return abs(_initial_contact(base)) > max(others)


def little_damping_lessens_crawl(of: Of) -> bool:
    """'The crawling distance decreases when damping is applied. This can be seen when comparing
    the C3 = 0 and C3 = 10^6 runs.' (6.4.1)"""
    return abs(_end(of("C3 1e+06"))) < abs(_end(of("C3 0e+00")))


def damping_1e8_moves_ahead(of: Of) -> bool:
    """C3 = 10^8: 'for high values ... the barge moves in positive x direction' (6.4.1)"""
    return _initial_contact(of("C3 1e+08")) > 0.0


def damping_1e10_moves_ahead(of: Of) -> bool:
    """C3 = 10^10: 'for high values ... the barge moves in positive x direction' (6.4.1)"""
    return _initial_contact(of("C3 1e+10")) > 0.0


def softest_crawls_least_in_initial_contact(of: Of) -> bool:
    """In initial contact: 'The barge with the lowest value for K2 = 5.6 * 10^6 shows little
    crawling' (6.4.2)"""
    soft, middle, stiff = (-_initial_contact(of(variant)) for variant in STIFFNESS)
    return soft < min(middle, stiff)


def middle_stiffness_crawls_most_in_initial_contact(of: Of) -> bool:
    """In initial contact: 'The largest crawling distance is found with K2 = 5.6 * 10^7' (6.4.2)"""
    soft, middle, stiff = (-_initial_contact(of(variant)) for variant in STIFFNESS)
    return middle > max(soft, stiff)


def softest_crawls_least(of: Of) -> bool:
    """At 2000 s: 'The barge with the lowest value for K2 = 5.6 * 10^6 shows little crawling'
    (6.4.2)"""
    # the thesis says so of initial contact
    soft, middle, stiff = (-_end(of(variant)) for variant in STIFFNESS)
    return soft < min(middle, stiff)


def middle_stiffness_crawls_most(of: Of) -> bool:
    """At 2000 s: 'The largest crawling distance is found with K2 = 5.6 * 10^7' (6.4.2)"""
    # the thesis says so of initial contact
    soft, middle, stiff = (-_end(of(variant)) for variant in STIFFNESS)
    return middle > max(soft, stiff)


def middle_stiffness_reaches_020_m_s(of: Of) -> bool:
    """'When the topside of the barge is in stick condition ..., the barge reaches velocities of
    v = +-0.20 m/s.' (6.4.2)"""
    # here the thesis' sign stands for both directions, so that the bound is a quarter
    return 0.15 <= of("K2 5.6e+07")["velocity_stuck"] <= 0.25


def middle_stiffness_is_fastest_while_stuck(of: Of) -> bool:
    """'For the highest stiffness small horizontal motions can be observed.' (6.4.2)"""
    return of("K2 5.6e+07")["velocity_stuck"] > of("K2 5.6e+08")["velocity_stuck"]


def less_friction_sticks_later(of: Of) -> bool:
    """'the lower the values for mu are, the longer it will take before the barge is in stick
    condition' (6.4.3)"""
    # it is in that condition after the last slip of a point
    high, middle, low = (of(f"mu {pair}")["last_slip"] for pair in ("0.7/0.4", "0.4/0.2", LOW))
    return high < middle < low


def faster_deballasting_shortens_phases(of: Of) -> bool:
    """'When the deballast speed is increased, the initial contact phase and compressed phase will
    be shorter.' (6.4.4)"""
    slow, base, fast = (_phases(of(rate)) for rate in RATES)
    return slow > base > fast


def faster_deballasting_crawls_less(of: Of) -> bool:
    """'Increasing the deballast velocity reduces the crawling distance of the barge.'
    (abstract)"""
    # the sentence of 6.4.4 on less crawl has friction as its subject
    slow, base, fast = (-of(rate)["surge_end"] for rate in RATES)
    return slow > base > fast


def stiffer_fenders_heave_less(of: Of) -> bool:
    """'An increase in the vertical fender stiffness of the fender reduces the heave motion'
    (6.4.5)"""
    soft, base, stiff = (of(_vertical(k))["heave_velocity"] for k in VERTICAL)
    return soft > base > stiff


def vertical_20000_crawls_most(of: Of) -> bool:
    """At 2000 s: 'When Kvert = 20.000 (mT/0.5m) this distance is the most' (6.4.5)"""
    # the thesis may mean the distance within its window of 50 s
    soft, base, stiff = (-_end(of(_vertical(k))) for k in VERTICAL)
    return base > max(soft, stiff)


LOW = "0.2/0.04"
STIFFNESS = ("K2 5.6e+06", "K2 5.6e+07", "K2 5.6e+08")
RATES = ("10000 t/h, to 3500 s", "20000 t/h", "50000 t/h")
VERTICAL = (10_000, 20_000, 40_000)  # t per 0.5 m

OF_BASE: Mapping[Test, int] = {
    initial_contact_crawls_back: 7,
    compressed_crawls_ahead: 8,
    compressed_crawls_030_m: 8,
    ends_at_120_m: 8,
    sticks_from_1500_s: 8,
    initial_contact_matters_most: 9,
}
OF_CONTACT: Mapping[Test, int] = {
    little_damping_lessens_crawl: 10,
    damping_1e8_moves_ahead: 10,
    damping_1e10_moves_ahead: 10,
    softest_crawls_least_in_initial_contact: 11,
    middle_stiffness_crawls_most_in_initial_contact: 11,
    softest_crawls_least: 11,
    middle_stiffness_crawls_most: 11,
    middle_stiffness_reaches_020_m_s: 11,
    middle_stiffness_is_fastest_while_stuck: 11,
}
OF_PRESSED: Mapping[Test, int] = {
    crawls_against_waves_when_pressed: 3,
    crawls_07_m_when_pressed: 3,
    mean_wave_force_is_nothing: 4,
    mean_fender_force_is_negative: 4,
}


@dataclass(frozen=True)
class Model:
    """A ``name``, the ``table`` that has its runs, the row of each test that it is put to, and the
    variant of the table for each variant that tests name."""

    name: str
    table: str
    tests: Mapping[Test, int]
    variant_of: Callable[[str], str] = str


def _six_degrees(variant: str) -> str:
    as_base = {"C3 1e+06", "K2 5.6e+08", "20000 t/h", _vertical(20_000)}
    return BASE if variant in as_base else variant


def _fixed(variant: str) -> Callable[[str], str]:
    """The same variant for the only one that tests name."""
    return lambda _: variant


def _one_dimension(prefix: str) -> Callable[[str], str]:
    """Variants of the table of one dimension, whose base has the prefix alone."""
    as_base = {BASE, "C3 1e+06", "K2 5.6e+08", _vertical(20_000)}
    return lambda variant: prefix if variant in as_base else f"{prefix}, {variant}"


def _vertical(stiffness: int) -> str:
    return f"K_vert {stiffness} t per 0.5 m"


MODELS = (
    Model(
        "section 3.2",
        "steel",
        {
            swings_about_zero_without_friction: 1,
            finds_place_within_100_s: 1,
            place_is_half_a_metre_off: 1,
            smaller_step_ends_oscillation: 2,
        },
    ),
    *(
        Model(f"section 3.3, {variant}", "pressed", OF_PRESSED, _fixed(variant))
        for variant in (
            "exact, lift 1",
            "exact, lift 1.1",
            "exact, lift 2",
            "rk2 at 0.1 s without events, lift 1",
            "rk2 at 0.1 s without events, lift 1.1",
            "rk2 at 0.1 s without events, lift 2",
            "contact node, lift 2",
        )
    ),
    Model(
        "block",
        "block",
        {
            soft_slopes_creep: 5,
            slope_1e8_is_not_stuck: 5,
            slope_1e10_stays: 5,
            slope_1e10_oscillates_in_explicit_steps_only: 5,
        },
    ),
    Model(
        "six degrees of freedom",
        "sensitivities",
        {
            moored_surge_is_positive: 6,
            friction_acts_more_ahead: 7,
            **OF_BASE,
            **OF_CONTACT,
            less_friction_sticks_later: 12,
            faster_deballasting_shortens_phases: 13,
            faster_deballasting_crawls_less: 13,
            stiffer_fenders_heave_less: 14,
            vertical_20000_crawls_most: 14,
        },
        _six_degrees,
    ),
    *(
        Model(
            f"one dimension, {at}, {friction}",
            "one_dimension",
            {**OF_BASE, **OF_CONTACT, **more},
            _one_dimension(f"{at}, {friction}"),
        )
        for at in ("forward", "mean", "aft")
        for friction, more in (
            ("0.2/0.1 of N", {vertical_20000_crawls_most: 14}),
            ("0.7/0.4 of N", {}),
        )
    ),
)


def score(records: Iterable[Record]) -> list[Row]:
    """A row for each test and model whose table is among the records, by the rows of the card."""
    seeds = figures_by_seed(records)
    rows = [row for model in MODELS if model.table in seeds for row in _rows(model, seeds)]
    return sorted(rows, key=lambda row: row["row"])


def _rows(model: Model, seeds: Mapping[str, Mapping[int, Mapping[str, Figures]]]) -> Iterator[Row]:
    for test, number in model.tests.items():
        outcomes = [
            test(lambda variant, of=found: of[model.variant_of(variant)])  # type: ignore[misc]
            for found in seeds[model.table].values()
        ]
        statement = test.__name__.replace("_", " ")
        share = share_of(outcomes)._asdict()
        quote = " ".join((test.__doc__ or "").split())
        row = {"row": number, "statement": statement, "model": model.name, **share}
        yield {**row, "quote": quote}


def figures_by_seed(
    records: Iterable[Record],
) -> Mapping[str, Mapping[int, Mapping[str, Figures]]]:
    """Figures by table, seed and variant. A seed in which a run has none does not count."""
    records = list(records)
    failed = {(record.table, record.seed) for record in records if not record.figures}
    found: dict[str, dict[int, dict[str, Figures]]] = {}
    for record in records:
        if (record.table, record.seed) in failed:
            continue
        of_seed = found.setdefault(record.table, {}).setdefault(record.seed, {})
        of_seed[record.variant] = record.figures
    return found


def _pressed_crawl(of: Of) -> float:
    """From 2000 to 7000 s [m]."""
    run = of(BASE)
    return run["surge_7000"] - run["surge_2000"]


def _initial_contact(run: Figures) -> float:
    """Crawl from 600 to 1000 s [m]."""
    return run["surge_1000"] - run["surge_600"]


def _compressed(run: Figures) -> float:
    """Crawl from 1000 to 1500 s [m]."""
    return run["surge_1500"] - run["surge_1000"]


def _end(run: Figures) -> float:
    """Surge at 2000 s [m]."""
    return run["surge_2000"]


def _phases(run: Figures) -> float:
    """Length of initial contact and of the compressed phase [s]."""
    return run["initial_contact_lasts"] + run["compressed_lasts"]
