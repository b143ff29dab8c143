"""What does an error cost, and does each run know its own? Errors asked, said and true, over CPU.

Scenes are those of `precision_scenes`. Each is run by automatic at four tolerances, and by rk4 at
its own step or a smaller one that is stable. References are runs by dopri5 at 1e-10 and 1e-11; a
true error is shown where it is ten times what the references are apart. CPU times are those of the
second of two runs, all told but compiling the scene: the estimate of errors is in it.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, isnan, nan
from statistics import median

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.error_scenes import GOOD, WITHIN, is_warned
from benchmarks.evidence import with_block
from benchmarks.report import ROOT, Answer, Row, page_table
from benchmarks.timing import timed
from hydrosim.errors import HydrosimError
from hydrosim.scene import Kinematics, Method, Scene
from hydrosim.simulation import compiled_to_run, run_compiled
from tests.generators.precision_scenes import named_scene, scene_names, shipped_cases
from tests.generators.references import (
    COARSE,
    FINE,
    at_stable_step,
    compile_reference,
    least_ranges,
    motion_errors,
    run_reference,
)

ASKED = (1e-3, 1e-4, 1e-5, 1e-6)  # of the range of a motion
RK4 = "rk4"
SEEDS = (1, 2, 3)
SMALLEST = 1e-9  # of the range of a motion, for the picture
TENTH = 0.1
TOLERANCE_LABEL = "tolerance of automatic, of the range of a motion"
PAGE = ROOT / "docs" / "reference" / "work_precision.md"
PICTURE = ROOT / "benchmarks" / "work_precision.png"
BEGIN = "<!-- scenes: python -m benchmarks --keep work_precision -->"
END = "<!-- end of scenes -->"
BEGIN_SEEDS = "<!-- seeds: python -m benchmarks --keep work_precision -->"
END_SEEDS = "<!-- end of seeds -->"
COLOURS = {RK4: "#D55E00", "1e-03": "#CC79A7", "1e-04": "#0072B2", "1e-05": "#56B4E9"}
COLOURS |= {"1e-06": "#009E73"}

References = tuple[np.ndarray, np.ndarray]
"""Positions (nt, nb, 6) of the coarser and of the finer reference."""


@dataclass(frozen=True)
class Trial:
    """A run: the errors ``asked`` (NaN of rk4), ``said`` and ``true``, of the range of a motion;
    how far references are ``apart`` for it; its CPU time [s]. It is ``told`` if it warns, or says
    that it is beyond what was asked."""

    scene: str
    way: str
    asked: float
    said: float = nan
    true: float = nan
    apart: float = inf
    seconds: float = nan
    told: bool = True

    @property
    def limit(self) -> float:
        """The largest error of which the run need not tell."""
        return WITHIN if isnan(self.asked) else self.asked

    @property
    def counts(self) -> bool:
        """Whether the references can judge whether the limit is kept."""
        return self.apart <= TENTH * max(self.limit, self.true)

    @property
    def keeps(self) -> bool:
        """Whether the error is within the limit."""
        return self.true <= self.limit


def answer() -> Answer:
    """Errors and CPU times of all scenes."""
    trials = [trial for name in scene_names() for trial in trials_of(name)]
    seeded = [trial for name in shipped_cases() for trial in trials_of_seeds(name)]
    rows = [*scene_rows(trials), *scene_rows(seeded)]
    summary = [*summary_rows(trials), *summary_rows(seeded)]
    page = with_block(PAGE.read_text("utf-8"), page_block(trials), BEGIN, END)
    page = with_block(page, page_block(seeded), BEGIN_SEEDS, END_SEEDS)
    silent = [(t.scene, t.way) for t in (*trials, *seeded) if is_silent(t)]
    return Answer(
        {"All scenes": rows, "By way": summary},
        [f"not kept and not told: {silent}"],
        picture=draw(trials),
        kept={PAGE: page},
        kept_picture=PICTURE,
    )


def trials_of(name: str, asked: Sequence[float] = ASKED) -> Iterator[Trial]:
    """A scene by rk4, and by automatic with each tolerance that is ``asked``."""
    with named_scene(name) as scene, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        references = _references(scene)
        yield _trial(name, at_stable_step(scene), nan, references)
        for accuracy in asked:
            solver = replace(scene.solver, method=Method.AUTOMATIC, accuracy=accuracy)
            yield _trial(name, replace(scene, solver=solver), accuracy, references)


def trials_of_seeds(name: str) -> Iterator[Trial]:
    """A shipped case by its own solver, with several seeds if it has any."""
    with named_scene(name) as scene, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for seed in SEEDS if scene.environment.seeds else SEEDS[:1]:
            sea = replace(scene, environment=scene.environment.with_seed(seed))
            asked = nan if sea.solver.accuracy is None else sea.solver.accuracy
            trial = _trial(name, sea, asked, _references(sea))
            yield replace(trial, way=f"seed {seed}")


def _references(scene: Scene) -> References | None:
    """Those of a scene; None if one of them fails."""
    compiled, finer = compile_reference(scene)
    try:
        runs = [run_reference(compiled, tolerance) for tolerance in (COARSE, FINE)]
    except HydrosimError:
        return None
    coarse, fine = (run.position.values[::finer] for run in runs)
    return coarse, fine


def _trial(name: str, scene: Scene, asked: float, references: References | None) -> Trial:
    trial = Trial(name, RK4 if isnan(asked) else f"{asked:.0e}", asked)
    try:
        compiled = compiled_to_run(scene)
        run_compiled(compiled)
        run, seconds = timed(lambda: run_compiled(compiled))
    except HydrosimError:
        return trial
    exact = scene.solver.kinematics is Kinematics.EXACT
    least = least_ranges(compiled.scene.solver, run.attrs.get("solver_accuracy"))
    said = float(run.attrs.get("error_relative", nan))
    record = {"warnings": str(run.attrs.get("warnings") or "").splitlines()}
    told = is_warned(record) or said > asked
    trial = replace(trial, said=said, seconds=seconds, told=told)
    if references is None:
        return trial
    coarse, fine = references
    return replace(
        trial,
        true=float(motion_errors(run.position.values, fine, exact, least).max()),
        apart=float(motion_errors(coarse, fine, exact, least).max()),
    )


def is_silent(t: Trial) -> bool:
    """Whether a run is beyond its limit and does not tell."""
    return t.counts and not t.keeps and not t.told


def by_scene(trials: Sequence[Trial]) -> dict[str, dict[str, Trial]]:
    """Trials by scene and way."""
    return {
        scene: {t.way: t for t in trials if t.scene == scene}
        for scene in dict.fromkeys(t.scene for t in trials)
    }


def ways(trials: Sequence[Trial]) -> list[str]:
    """Ways of all trials, in their order."""
    return list(dict.fromkeys(t.way for t in trials))


def scene_rows(trials: Sequence[Trial]) -> Iterator[Row]:
    """A row for each run."""
    for t in trials:
        yield {
            "scene": t.scene,
            "asked": t.way,
            "said": _text(t.said),
            "true": true_text(t),
            "told": "yes" if t.told else "",
            "CPU [s]": "failed" if isnan(t.seconds) else f"{t.seconds:.2g}",
        }


def summary_rows(trials: Sequence[Trial]) -> Iterator[Row]:
    """By way: how many keep what was asked, how well they know their errors, and CPU times over
    those of rk4."""
    scenes = by_scene(trials)
    for way in ways(trials):
        own = [t for t in trials if t.way == way and t.counts]
        ratios = [t.said / max(t.true, 1e-300) for t in own if max(t.said, t.true) > 1e-7]
        cost = [x[way].seconds / x[RK4].seconds for x in scenes.values() if RK4 in x and way in x]
        cost = [x for x in cost if not isnan(x)]
        good = sum(GOOD[0] <= x <= GOOD[1] for x in ratios)
        yield {
            "asked": way,
            "scenes": len(own),
            "kept": sum(t.keeps for t in own),
            "beyond, told": sum(t.told and not t.keeps for t in own),
            "beyond, not told": sum(map(is_silent, own)),
            f"said within {GOOD[0]:g} to {GOOD[1]:g} of the true": f"{good} of {len(ratios)}",
            "CPU over that of rk4, median": median(cost) if cost else nan,
        }


def true_text(t: Trial) -> str:
    """The true error, as far as the references know it."""
    if isnan(t.true) or t.apart > 0.3:
        return "-"
    return _text(t.true) if t.apart <= TENTH * t.true else f"< {max(t.true, t.apart):.0e}"


def _text(value: float) -> str:
    return "-" if isnan(value) else f"{value:.1e}"


def page_block(trials: Sequence[Trial]) -> str:
    """The table of the page: a row for each scene, three figures for each way."""
    used = ways(trials)
    head = ["scene", *(f"{way}: said / true / CPU [s]" for way in used)]
    scenes = by_scene(trials).items()
    return page_table(head, ([name, *(_cell(own.get(w)) for w in used)] for name, own in scenes))


def _cell(t: Trial | None) -> str:
    if t is None:
        return "-"
    if isnan(t.seconds):
        return "failed"
    told = " (told)" if t.told else ""
    return f"{_text(t.said)} / {true_text(t)}{told} / {t.seconds:.2g}"


def draw(trials: Sequence[Trial]) -> Figure:
    """Error true over asked, error said over true, and CPU time over that of rk4."""
    figure = Figure((14.0, 4.6), dpi=100, layout="constrained")
    kept, known, cost = figure.subplots(1, 3)
    judged = [t for t in trials if t.counts]
    _draw_kept(kept, [t for t in judged if not isnan(t.asked)])
    _draw_known(known, judged)
    _draw_cost(cost, trials)
    return figure


def _shown(errors: Sequence[float]) -> np.ndarray:
    """Errors, at least `SMALLEST`, and at most the range of the motion."""
    return np.clip(errors, SMALLEST, 1.0)


def _draw_kept(axis: Axes, trials: Sequence[Trial]) -> None:
    for told, style, label in ((False, "o", "not told"), (True, "x", "told by the run")):
        own = [t for t in trials if (t.told and not t.keeps) == told]
        spread = 10 ** np.random.default_rng(1).uniform(-0.15, 0.15, len(own))
        asked = np.array([t.asked for t in own]) * spread
        axis.loglog(asked, _shown([t.true for t in own]), style, markersize=4, label=label)
    axis.plot(ASKED, ASKED, color="0.5", linewidth=0.8)
    title = "Is the tolerance kept? Below the line it is"
    _label(axis, title, TOLERANCE_LABEL, "true error, of the range")


def _draw_known(axis: Axes, trials: Sequence[Trial]) -> None:
    ends = np.array([SMALLEST, 1.0])
    for way in ways(trials):
        own = [t for t in trials if t.way == way and not isnan(t.said)]
        true, said = (_shown([getattr(t, key) for t in own]) for key in ("true", "said"))
        label = way if way == RK4 else f"automatic, {way}"
        axis.loglog(true, said, "o", color=COLOURS[way], markersize=4, label=label)
    axis.fill_between(ends, GOOD[0] * ends, GOOD[1] * ends, color="0.9", zorder=0)
    axis.plot(ends, ends, color="0.5", linewidth=0.8)
    title = "Does a run know its error? On the line it is exact"
    _label(axis, title, "true error, of the range", "error that the run says")


def _draw_cost(axis: Axes, trials: Sequence[Trial]) -> None:
    costs = [
        [own[way].seconds / own[RK4].seconds for way in own if way != RK4]
        for own in by_scene(trials).values()
    ]
    costs = [line for line in costs if len(line) == len(ASKED) and not np.isnan(line).any()]
    for line in costs:
        axis.loglog(ASKED, line, color="0.8", linewidth=0.8)
    if costs:
        axis.loglog(ASKED, np.median(costs, axis=0), "o-", color="#0072B2", label="median")
    axis.invert_xaxis()
    title = "What does it cost? CPU time over that of rk4"
    _label(axis, title, TOLERANCE_LABEL, "CPU time over that of rk4 at its step")


def _label(axis: Axes, title: str, x: str, y: str) -> None:
    axis.set_title(title)
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    axis.legend(frameon=False, loc="upper left", fontsize="small")
    axis.grid(alpha=0.3)
    axis.spines[["top", "right"]].set_visible(False)
