import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from hydrosim.case import Case, load_case
from hydrosim.errors import InputError

CASES = Path(__file__).parents[2] / "cases"


@pytest.fixture(scope="session")
def cases(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The reverse float-over cases, beside a database that is only a name: loading does not read
    it."""
    root = tmp_path_factory.mktemp("project")
    shutil.copytree(CASES / "reverse_float_over", root / "cases" / "reverse_float_over")
    (root / "hydro_db").mkdir()
    (root / "hydro_db" / "h851.nc").touch()
    return root / "cases" / "reverse_float_over"


@pytest.fixture
def load(tmp_path: Path) -> Callable[..., Case]:
    """Loads a case given as text."""

    def load(text: str | bytes, settings: Sequence[str] | Mapping[str, Any] = ()) -> Case:
        path = tmp_path / "case.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_case(path, settings)

    return load


@pytest.fixture
def refusal(load: Callable[..., Case], tmp_path: Path) -> Callable[..., str]:
    """The message with which a case given as text is refused; file names without their folder."""

    def refusal(text: str | bytes, settings: Sequence[str] | Mapping[str, Any] = ()) -> str:
        with pytest.raises(InputError) as caught:
            load(text, settings)
        return str(caught.value).replace(f"{tmp_path}/", "")

    return refusal
