import numpy as np
import pytest
from known_box import Box, box_at


@pytest.fixture(scope="session")
def box() -> Box:
    """The box at 0.02 to 2.2 rad/s by 0.02, all headings by 15 deg."""
    return box_at(np.arange(1, 111) * 0.02, np.arange(0.0, 360.0, 15.0))
