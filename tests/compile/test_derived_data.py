"""Derived data of a compiled scene are derived once for each of its models, and in one place."""

import ast
from collections import Counter
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest
from scenes import SEA, in_contact, in_waves

import hydrosim
import hydrosim as hs
from hydrosim.compile import compiled
from hydrosim.compile.compiled import DerivedData, derive_data

PACKAGE = Path(hydrosim.__file__).parent
MAKERS = (
    *("force_names", "state_layout", "nonlinearities"),
    *("each_alone", "initial_headings", "met_by_waves"),
)
MODELS = 3  # in calm water, in its plane of symmetry, in its sea
BEFORE = {  # what is asked of a scene before there is a model, and by whom
    "each_alone": {"compile/compiled.py", "compile/model.py", "compile/symmetry.py"},
    "initial_headings": {"compile/compiled.py", "compile/model.py"},
    "state_layout": {"compile/compiled.py"},
    "nonlinearities": {"compile/compiled.py"},
    "met_by_waves": {"compile/compiled.py", "compile/model.py", "analysis/response.py"},
}


def test_each_fact_is_found_once_for_each_model(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiled and run with all checks: once each in calm water, in the plane, in the sea."""
    asked: Counter[str] = Counter()

    def counted(name: str) -> Any:
        made = getattr(compiled, name)

        def found(*arguments: Any) -> Any:
            asked[name] += 1
            return made(*arguments)

        return found

    for name in MAKERS:
        monkeypatch.setattr(compiled, name, counted(name))
    run = hs.simulate(in_waves(in_contact(20.0), hs.WaveTrain(SEA, seed=1)))
    assert run.attrs["status"] == "complete"
    assert {*asked.values()} == {MODELS}, asked


@pytest.mark.slow
@pytest.mark.parametrize("name", BEFORE)
def test_derived_data_are_asked_for_in_one_place(name: str) -> None:
    asking = set()
    for path in PACKAGE.rglob("*.py"):
        tree = ast.parse(path.read_text())
        calls = [x.func for x in ast.walk(tree) if isinstance(x, ast.Call)]
        asked = any(isinstance(f, ast.Name) and f.id == name for f in calls)
        if asked and name not in [x.name for x in tree.body if isinstance(x, ast.FunctionDef)]:
            asking.add(path.relative_to(PACKAGE).as_posix())
    assert asking == BEFORE[name]


def test_a_replaced_model_has_derived_data_of_its_own() -> None:
    compiled = hs.compile_scene(in_contact(20.0))
    other = compiled.model._replace(rows=compiled.model.rows)
    replaced = replace(compiled, derived=derive_data(compiled.scene, compiled.wet, other))
    assert replaced.model is other
    assert replaced.derived.layout.names() == compiled.derived.layout.names()


def test_derived_data_are_few_and_have_no_methods() -> None:
    assert len(fields(DerivedData)) <= 12
    own = [name for name, value in vars(DerivedData).items() if callable(value)]
    assert [name for name in own if not name.startswith("__")] == []
