"""What `import hydrosim as hs` shows of itself."""

from __future__ import annotations

import hydrosim as hs


def test_names_are_listed_and_there() -> None:
    assert set(hs.__all__) < set(dir(hs))
    assert all(getattr(hs, name) is not None for name in dir(hs))
    assert hs.__version__.split(".")[0].isdigit()
