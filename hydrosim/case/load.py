"""`load_case`: from a case file to a validated case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from yaml.nodes import Node

from hydrosim.case.checks import check, recorded_series
from hydrosim.case.schema import CaseFile
from hydrosim.files.display_units import Units, chosen_units
from hydrosim.files.document import Document
from hydrosim.files.layers import apply_setting, read_case, settings_of, yaml_text
from hydrosim.files.messages import validate_document
from hydrosim.files.outputs import files_named, settings_text
from hydrosim.files.units import units_written
from hydrosim.files.yaml_nodes import SETTING, Places, places_of, source_context
from hydrosim.scene import Scene


@dataclass(frozen=True)
class Case:
    """A validated case: the file's ``path``, its whole ``text`` in YAML (with what it extends and
    the settings laid over it), its ``data`` in SI and radians, the ``units`` that it is read in by
    SI unit. ``places`` are file and line of its keys."""

    path: Path
    text: str
    data: CaseFile
    units: Mapping[str, str] = field(default_factory=dict)
    places: Places = field(default_factory=dict, repr=False, compare=False)

    def scene(self) -> Scene:
        """The scene to simulate; databases are files in it, not yet read."""
        from hydrosim.case.build import build_scene  # the force elements load numba

        with source_context(self.places):
            scene = build_scene(self.data, self.path, self.text, self.units)
        return replace(scene, places=self.places)

    def __repr__(self) -> str:
        data = self.data
        held = f"bodies: {', '.join(data.bodies)}; forces: {', '.join(data.forces)}"
        return f"<case {self.path}: {data.title}, {data.duration:g} s; {held}>"

    def _repr_html_(self) -> str:
        return self.document()._repr_html_()

    def document(self) -> Document:
        """Its title, and its surroundings, bodies and elements."""
        from hydrosim.case.build import resolved_case_text
        from hydrosim.case.tables import case_tables, plain

        data = self.data
        lasts = f"{data.duration:g} s by {data.solver.method}, from {self.path}"
        tables = case_tables(plain(resolved_case_text(data, self.path.parent)))
        return Document(data.title, list(tables), lasts, Units(self.units))

    def inputs(self) -> tuple[Path, ...]:
        """The case file and all files that it names: databases, series, the run to start from."""
        return (self.path, *files_named(self.data, self.path.parent))

    def settings(self, asked: Mapping[str, Any] = MappingProxyType({})) -> str:
        """What a result is made with: all that the case sets, in SI and radians, but its title, and
        what else is ``asked`` for."""
        data = self.data.model_dump(
            mode="json", exclude_unset=True, warnings=False, exclude={"title"}
        )
        return settings_text(data, asked)

    def stages(self) -> tuple[Stage, ...]:
        """The runs of other cases that this one needs: recorded series with a case of their own."""
        folder = self.path.parent
        series = (form for _, form in recorded_series(self.data) if form.case is not None)
        needed = {folder / form.file: folder / str(form.case) for form in series}
        return tuple(Stage(file, load_case(path)) for file, path in needed.items())


@dataclass(frozen=True)
class Stage:
    """A run that another case needs: its ``file``, and the ``case`` that it is a run of."""

    file: Path
    case: Case


def load_case(path: Path | str, settings: Mapping[str, Any] | Sequence[str] = ()) -> Case:
    """The case in the YAML file ``path``, validated, with ``settings`` laid over it.

    Settings are texts ``KEY=VALUE`` or a mapping; a key is dotted ("solver.step",
    "environment.waves.seed", "forces.interface.points.0"), a value is as in the file, None removes.
    Raises InputError with a line for each problem: file and line, key, what was found, what was
    expected, what to do.
    """
    return laid_over(Path(path), read_case(Path(path)), settings)


def laid_over(
    path: Path, read: tuple[str, Node], settings: Mapping[str, Any] | Sequence[str]
) -> Case:
    """`load_case` of what was ``read`` of the file, text and nodes."""
    text, document = read
    texts = settings_of(settings) if isinstance(settings, Mapping) else settings
    for setting in texts:
        document = apply_setting(document, setting)
    if texts:
        remarks = "".join(f"# {SETTING}{' '.join(setting.split())}\n" for setting in texts)
        text = f"# {path.name}\n{remarks}{yaml_text(document)}"
    with units_written() as written:
        data = validate_document(document, CaseFile, lambda data: check(data, path.parent))
    return Case(path, text, data, chosen_units(written), places_of(document))
