"""What of the seas of many runs is outside the frequencies of a database, said once for all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from hydrosim.compiling.databases import database_groups
from hydrosim.compiling.questions.ranges import OUTSIDE_REFUSED, said_of_outside
from hydrosim.database.database import all_headings
from hydrosim.errors import InputError
from hydrosim.scene import Question, Scene
from hydrosim.studies.many.shared import SceneCache
from hydrosim.waves import shares_outside
from hydrosim.waves.components import sea

MIN_REPORTED_SHARE = 1e-3  # share of the energy of the loads that is worth a word


def describe_outside_ranges(scenes: Sequence[Scene]) -> list[str]:
    """Of each sea, whatever its seed, what is outside, in words, and in how many of the ``scenes``.
    Raises InputError where in all of them it is too much, and not accepted."""
    run_counts: Counter[str] = Counter()
    texts_by_sea: dict[object, list[tuple[str, float]]] = {}
    refused, shared = 0, SceneCache()
    for scene in scenes:
        key = _sea_and_hulls(scene)
        if key not in texts_by_sea:
            texts_by_sea[key] = _outside_ranges(scene, shared)
        accepted = Question.RANGE in scene.accept
        run_counts.update(
            _range_message(text, share, accepted) for text, share in texts_by_sea[key]
        )
        refused += any(share > OUTSIDE_REFUSED and not accepted for _, share in texts_by_sea[key])
    total = len(scenes)
    lines = [f"environment.waves: in {n} of {total} runs {text}" for text, n in run_counts.items()]
    if refused == total > 0:
        raise InputError("\n".join(lines))
    return lines


def _range_message(text: str, share: float, accepted: bool) -> str:
    if share <= OUTSIDE_REFUSED or accepted:
        return f"{text}: no first-order loads there"
    return (
        f"found {text}; usual is up to {OUTSIDE_REFUSED:.0%} of what loads it. These runs are"
        " refused. Use a database with a wider range, or other waves. If this is intended, accept:"
        " [range]."
    )


def _sea_and_hulls(scene: Scene) -> object:
    trains = tuple(replace(train, seed=0) for train in scene.environment.waves)
    return trains, tuple((body.hydrodynamics, body.wave_forces) for body in scene.bodies)


def _outside_ranges(scene: Scene, shared: SceneCache) -> list[tuple[str, float]]:
    """Texts and shares of what is left out, of each body that waves load; nothing where a run will
    say what is wrong with its databases or its sea."""
    try:
        seas = sea(scene.environment)
        used = database_groups(shared.open_sources(scene)) if seas else []
    except InputError:
        return []
    texts = []
    for group in used:
        range_loss = shares_outside(all_headings(group.database), seas)
        for body in group.bodies:
            if body.wave_forces.first_order and range_loss.share > MIN_REPORTED_SHARE:
                texts.append((said_of_outside(range_loss, body, group.database), range_loss.share))
    return texts
