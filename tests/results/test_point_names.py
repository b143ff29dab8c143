"""Points and bodies may be called as they please: nobody takes their names apart."""

import numpy as np
from scenes import block, moving, scene

import hydrosim as hs
from hydrosim.results.channels import channel_series
from hydrosim.scene import Clearance


def test_names_with_of_and_to_in_them() -> None:
    """Two blocks that fly and turn: relative positions, velocities and clearances of their points
    are those of the same scene with plain names."""
    runs = {}
    for body, other, point in (("one", "two", "tip"), ("leg of jacket", "a to b", "top_to_toe")):
        bodies = [
            block(
                2.0,
                name=body,
                points={point: (1.0, 2.0, 3.0)},
                velocity=moving(surge=0.3, roll=0.2, yaw=-0.1),
            ),
            block(3.0, name=other, points={point: (0.5, 0.0, -1.0)}, location=(4.0, 1.0)),
        ]
        ends = f"{point} of {body}", f"{point} of {other}"
        flight = scene(bodies, {}, 2.0, 0.1)
        run = hs.simulate(flight.with_output(clearances={"gap": Clearance(of=ends[0], to=ends[1])}))
        names = [f"{kind}.{' to '.join(ends)}.{axis}" for kind in KINDS for axis in "xyz"]
        names.append(f"point_velocity.{ends[0]}.y")
        runs[body] = [channel_series(run, name)[0] for name in names] + [run.clearance.values[:, 0]]
    plain, odd = runs.values()
    assert np.ptp(plain[0]) > 0.1
    assert all(np.array_equal(a, b) for a, b in zip(plain, odd, strict=True))


KINDS = ("relative_position", "relative_velocity")
