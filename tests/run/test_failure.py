"""Messages of runs that cannot continue."""

import pytest

from hydrosim.integrate.state import CHATTERING, NOT_FINITE, STEP_TOO_SMALL
from hydrosim.run.failure import MAX_WARNINGS, choose_remedy, earlier_warnings
from hydrosim.scene import Method

STEPPED = [method for method in Method if method != Method.AUTOMATIC]


@pytest.mark.parametrize("status", [CHATTERING, STEP_TOO_SMALL, NOT_FINITE])
@pytest.mark.parametrize("method", STEPPED)
def test_no_remedy_proposes_the_method_in_use(status: int, method: Method) -> None:
    """Nor does it propose a smaller first step to a method that chooses its steps."""
    remedy = choose_remedy(status, method)
    assert f"solver.method: {method}" not in remedy
    assert ("solver.step" in remedy) == (not method.adapts and status != STEP_TOO_SMALL)
    assert ("solver.tolerance" in remedy) == (method.adapts or status == STEP_TOO_SMALL)


def test_a_message_tells_the_first_earlier_warnings_and_counts_the_others() -> None:
    lines = [*earlier_warnings([f"warning {k}" for k in range(9)])]
    assert lines[0] == "Earlier warnings: warning 0"
    assert lines[MAX_WARNINGS:] == ["Earlier warnings: 5 more, which hydrosim check prints."]
    assert [*earlier_warnings(["a"])] == ["Earlier warnings: a"]
