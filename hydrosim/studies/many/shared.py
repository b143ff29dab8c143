"""What the runs of a set have in common is made once: databases are read once, and a scene that
differs from the one before it in its waves alone takes over its compiled model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.compile import without_symmetric_motions
from hydrosim.compiling.databases import Source, open_database
from hydrosim.compiling.families import all_groups
from hydrosim.compiling.restart import memory_before, opened_start
from hydrosim.compiling.symmetry import wave_asymmetries
from hydrosim.compiling.validate_scene import check_scene
from hydrosim.compiling.without_waves import compile_calm
from hydrosim.database.database import HydroDatabase
from hydrosim.documents.yaml_nodes import source_context
from hydrosim.scene import Body, Coefficients, Family, Scene, Start
from hydrosim.studies.many.alike import scenes_equal
from hydrosim.studies.many.work import RunTask
from hydrosim.studies.run.step_limits import add_step_warnings
from hydrosim.waves.components import WaveComponents, sea

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.compiling.hydrodynamic_groups import HydrodynamicGroup


class SceneCache:
    """Compiles what each scene has in common with the one before it only once; reads databases, and
    the run to start from, only once."""

    def __init__(self) -> None:
        self._databases: dict[Source, HydroDatabase] = {}
        self._start: tuple[Start, Start] | None = None
        self._calm: Scene | None = None
        self._wet: tuple[HydrodynamicGroup, ...] = ()
        self._made: tuple[list[str], Compiled | Exception] | None = None
        self._known: dict[bytes, list[str]] = {}

    def compile_task(self, scene: Scene, estimates: bool = False) -> RunTask | Exception:
        """A scene in calm water and its sea, or why there is none. Its run ``estimates`` its error,
        or does not."""
        calm = replace(scene, title="", source={})
        calm = replace(calm, environment=scene.environment.without_waves())
        if self._calm is None or not scenes_equal(calm, self._calm):
            self._calm = calm
            self._wet = ()
            self._made = None
            self._known.clear()
        try:
            with source_context(scene.places):
                check_scene(scene)
                scene = self.open_sources(scene)
                drawn = sea(scene.environment)
                compiled = self._compile_without_waves(scene, drawn)
        except Exception as error:
            return error
        # what is read from files is read: netCDF knows no threads
        compiled_scene = compiled.scene
        scene = replace(
            scene,
            bodies=compiled_scene.bodies,
            initial=compiled_scene.initial,
            solver=compiled_scene.solver,
        )
        return RunTask(scene, drawn, compiled, estimates)

    def _compile_without_waves(self, scene: Scene, drawn: Sequence[WaveComponents]) -> Compiled:
        """A scene in calm water, in the plane of symmetry that its sea leaves. What is wrong with
        it is found once for all of its seeds."""
        self._wet = self._wet or tuple(all_groups(scene, drawn, memory_before(scene)))
        asymmetries = self._find_asymmetries(scene, drawn)
        if self._made is None or self._made[0] != asymmetries:
            self._made = asymmetries, self._try_compiling(scene, drawn)
        compiled = self._made[1]
        if isinstance(compiled, Exception):
            raise compiled
        return compiled

    def _try_compiling(self, scene: Scene, drawn: Sequence[WaveComponents]) -> Compiled | Exception:
        """A scene in calm water, or why there is none."""
        try:
            return add_step_warnings(
                without_symmetric_motions(compile_calm(scene, self._wet), drawn)
            )
        except Exception as error:
            return error

    def _find_asymmetries(self, scene: Scene, drawn: Sequence[WaveComponents]) -> list[str]:
        """`wave_asymmetries`, which scenes with waves to the same headings have in common."""
        headings = np.unique([heading for waves in drawn for heading in waves.heading]).tobytes()
        if headings not in self._known:
            self._known[headings] = list(wave_asymmetries(scene, self._wet, drawn))
        return self._known[headings]

    def open_sources(self, scene: Scene) -> Scene:
        """A scene with its databases, and the run to start from, in memory."""
        bodies = tuple(map(self._open_body, scene.bodies))
        scene = replace(scene, bodies=bodies)
        if scene.initial is None:
            return scene
        if self._start is None or not scenes_equal(self._start[0], scene.initial):
            self._start = scene.initial, opened_start(scene.initial)
        return replace(scene, initial=self._start[1])

    def _open_body(self, body: Body) -> Body:
        source = body.hydrodynamics
        if source is None or isinstance(source, HydroDatabase | Coefficients):
            return body
        if isinstance(source, Family):
            members = [
                replace(member, source=self._open_database(member.source))
                for member in source.members
            ]
            return replace(body, hydrodynamics=Family(tuple(members)))
        return replace(body, hydrodynamics=self._open_database(source))

    def _open_database(self, source: Source) -> HydroDatabase:
        if source not in self._databases:
            self._databases[source] = open_database(source)
        return self._databases[source]
