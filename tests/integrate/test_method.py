"""What methods answer about themselves."""

import numpy as np
import pytest

from hydrosim import scene
from hydrosim.integrate.methods import METHODS, IntegrationMethod, method_named
from hydrosim.linear.stability import ray_limits


def test_every_name_in_a_scene_has_a_method() -> None:
    names = [str(name) for name in scene.Method if name != scene.Method.AUTOMATIC]
    assert [*METHODS] == names


@pytest.mark.parametrize("name", METHODS)
def test_scene_and_tableau_agree_on_who_chooses_steps(name: str) -> None:
    assert method_named(name).adapts == scene.Method(name).adapts


@pytest.mark.parametrize("method", METHODS.values(), ids=str)
def test_only_methods_that_choose_their_steps_or_are_stable_everywhere_have_no_limit(method):
    left = np.linspace(0.5 * np.pi, np.pi, 20)
    stable = bool(np.isinf(ray_limits(method, left)).all())
    assert method.any_step == (method.adapts or stable)


@pytest.mark.parametrize("method", METHODS.values(), ids=str)
def test_the_stability_function_is_the_exponential_to_the_order(method: IntegrationMethod) -> None:
    """R(z) - exp(z) = C z^(p + 1) + ..."""
    z = np.array([0.2, 0.1]) * np.exp(2.0j)
    far, near = np.abs(method.stability(z) - np.exp(z))
    assert np.log2(far / near) == pytest.approx(method.order + 1, abs=0.15)


@pytest.mark.parametrize("method", METHODS.values(), ids=str)
def test_dopri5_alone_ends_a_step_at_its_last_stage(method: IntegrationMethod) -> None:
    """Of the explicit ones: the slope there begins the next step."""
    assert method.tableau.closes == (method.name == "dopri5")
