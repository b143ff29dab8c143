"""`run_study`: the runs of a study into one file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from hydrosim.documents.yaml_nodes import locating_in
from hydrosim.errors import InputError
from hydrosim.results.validation import DESIGN
from hydrosim.studies.many.many import simulate_many
from hydrosim.studies.many.run_layout import one_scene_of_each_kind
from hydrosim.studies.sweep.trial import check_figures, check_units

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr

    from hydrosim.outputs import Output
    from hydrosim.studies.many.many import Progress
    from hydrosim.studies.many.pools import Pool
    from hydrosim.studies.sweep.study import ParameterStudy


def run_study(
    study: ParameterStudy,
    output: Path | Output,
    workers: int | None = None,
    progress: Progress | None = None,
    resume: bool = False,
    pool: Pool | None = None,
) -> xr.Dataset:
    """Run a study into the file ``output``, see `simulate_many`. Raises InputError first where its
    runs have no such figures."""
    file = study.inputs[0]
    kinds = one_scene_of_each_kind(study.scenes) if study.figures else []
    with locating_in(file), _named_as(f"{file}: output:"):
        check_units(file, study.bounds, check_figures(file, kinds, study.figures))
        return simulate_many(
            study.scenes,
            output,
            variables=study.kept.variables,
            channels=study.kept.channels,
            labels=study.labels,
            figures=study.figures,
            attributes={DESIGN: study.design},
            start=study.kept.start,
            workers=workers,
            progress=progress,
            resume=resume,
            pool=pool,
            first=study.first,
        )


@contextmanager
def _named_as(place: str) -> Iterator[None]:
    """Names a ``place`` in the study file where a message names the function that is called."""
    try:
        yield
    except InputError as error:
        raise InputError(str(error).replace("simulate_many:", place)) from None
