"""Random cases by whose references the errors of runs are judged: contacts, joints, lines, mixtures
and what is held."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import hydrosim as hs
from tests.generators.articulated_cases import articulated_case
from tests.generators.bouncing_cases import bouncing_case
from tests.generators.held_cases import held_case
from tests.generators.long_cases import lengthened, undamped
from tests.generators.mixed_cases import MESH, mesh_of, mixed_case
from tests.generators.moored_cases import moored_case
from tests.generators.random_cases import Case, random_case, text_of
from tests.generators.swinging_cases import swinging_case


def contact_case(number: int) -> Case:
    """Every other case bounces or lands, a third of the rest is longer."""
    if number % 2:
        return bouncing_case(number)
    case = random_case(number)
    return lengthened(case, number) if number % 3 == 0 else case


def joint_case(number: int) -> Case:
    """Every other case swings without damping, and a half of the rest is longer and undamped."""
    if number % 2:
        return swinging_case(number)
    case = articulated_case(number)
    return undamped(lengthened(case, number)) if number % 4 == 0 else case


def line_case(number: int) -> Case:
    """Every other case is longer, and every fourth undamped."""
    case = moored_case(number)
    case = lengthened(case, number) if number % 2 else case
    return undamped(case) if number % 4 == 1 else case


def mixture_case(number: int) -> Case:
    """Every third case is longer."""
    case = mixed_case(number)
    return lengthened(case, number) if number % 3 == 0 else case


KINDS: Mapping[str, Callable[[int], Case]] = {
    "contacts": contact_case,
    "joints": joint_case,
    "lines": line_case,
    "mixtures": mixture_case,
    "held": held_case,
}
"""Makers of the case of a number, by kind."""
SPACINGS = {"held": 0.005}
"""Time between records of a reference [s], at most, where peaks of loads are short."""


@contextmanager
def drawn_scene(kind: str, number: int) -> Iterator[hs.Scene]:
    """The scene of a case, by way of its file. Its mesh is there while the context lasts."""
    mesh = mesh_of(number) if kind == "mixtures" else None
    with written_scene(KINDS[kind](number), mesh) as scene:
        yield scene


@contextmanager
def written_scene(case: Case, mesh: str | None = None) -> Iterator[hs.Scene]:
    """The scene of a case, by way of its file, with the ``mesh`` of its hull beside."""
    with TemporaryDirectory() as folder:
        if mesh is not None:
            Path(folder, MESH).write_text(mesh)
        path = Path(folder, "case.yaml")
        path.write_text(text_of(case))
        yield hs.load_case(path).scene()
