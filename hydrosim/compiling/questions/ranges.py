"""Questions about waves outside the frequencies of a database."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from hydrosim.compiling.questions.query import Query, SceneContext
from hydrosim.waves import shares_outside
from hydrosim.waves.frequency_truncation import Outside

if TYPE_CHECKING:
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Body

# fraction of the energy of the loads, or of the waves if the loads are unknown
OUTSIDE_REFUSED = 0.01


def ranges(about: SceneContext) -> Iterator[Query]:
    """Ask about seas with too much energy outside the frequencies of a database."""
    for _, body, db in about.floating_bodies():
        if about.sea and body.wave_forces.first_order:
            found = shares_outside(db, about.sea)
            if found.share > OUTSIDE_REFUSED:
                usual = f"usual is up to {OUTSIDE_REFUSED:.0%} of the energy of the loads"
                advice = (
                    "Waves there have no first-order loads. Use a database with a wider range,"
                    " or other waves."
                )
                found_in_words = said_of_outside(found, body, db)
                yield Query("environment.waves", found_in_words, usual, advice, refused=True)


def said_of_outside(found: Outside, body: Body, db: HydroDatabase) -> str:
    """Text on the part of a sea outside the frequencies of the database of a body."""
    low, high = db.frequency[[0, -1]]
    text = (
        f"{found.below + found.above:.1%} of the waves' energy outside the frequencies of the"
        f" database of {body.name}, {low:.3g} to {high:.3g} rad/s"
    )
    if found.loads is None or found.above == 0.0:
        return text
    return (
        f"{text}, with an estimated fraction {found.below + found.loads:.2g} of the energy of"
        " its loads"
    )
