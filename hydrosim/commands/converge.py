"""`hydrosim converge`: error against run time of integration methods."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.compiling import announce_compiling
from hydrosim.commands.options import CaseFile, Overwrite, Settings, numbers, one_of, output_for
from hydrosim.commands.progress import progress
from hydrosim.commands.running import run_earlier_stages, simulate_with_progress
from hydrosim.commands.terminal import print_lines, progress_console, show_document
from hydrosim.errors import InputError

err = progress_console()


def converge(
    case_file: CaseFile,
    methods: Annotated[str, typer.Option(help="Methods, separated by commas.")] = "rk2,rk4,dopri5",
    steps: Annotated[str, typer.Option(help="Steps (s), separated by commas.")] = "0.1,0.05,0.025",
    tolerances: Annotated[
        str,
        typer.Option(help="Tolerances of methods that choose their own step, separated by commas."),
    ] = "1e-5,1e-6,1e-7",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="STUDY.nc", help="netCDF file to write."),
    ] = None,
    overwrite: Overwrite = False,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Compare error and run time of methods and steps; print a table, draw it, write netCDF."""
    from hydrosim.case.load import load_case
    from hydrosim.plot.work_precision import draw_work_precision
    from hydrosim.presentation.units import choice_in, units_of
    from hydrosim.results.netcdf import write_run
    from hydrosim.scene import Method
    from hydrosim.studies.run.converge import converge as study_of
    from hydrosim.studies.run.converge import to_dataset
    from hydrosim.wording.convergence import study_document

    chosen = [one_of(Method, name, "--methods") for name in methods.split(",")]
    if Method.AUTOMATIC in chosen:
        raise InputError(
            "--methods: found automatic, which only selects one of the other methods; expected"
            " rk2, heun, rk4, dopri5 or esdirk4."
        )
    all_steps = numbers(steps, "--steps")
    all_tolerances = numbers(tolerances, "--tolerances")
    case = load_case(case_file, settings)
    name = f"{case_file.stem}_converge"
    asked = {"methods": chosen, "steps": all_steps, "tolerances": all_tolerances}
    made = output_for(
        output,
        name,
        "convergence",
        case_file,
        inputs=case.inputs(),
        overwrite=overwrite,
        settings=case.settings(asked),
    )
    page = made.output_at(made.path.with_suffix(".png"), "picture").checked_output()
    with made.hold_lock():
        run_earlier_stages(case, simulate_with_progress)
        scene = case.scene()
        with announce_compiling(err), progress("comparing") as report:

            def tell(trial: str) -> None:
                report(remark=trial)

            study = study_of(scene, chosen, all_steps, all_tolerances, tell)
        dataset = to_dataset(study, scene.title).assign_attrs(choice_in(scene.source))
        write_run(dataset, made)
    draw_work_precision(dataset, page)
    show_document(study_document(study, scene.title, units_of(scene.source)))
    print_lines(f"result    {made.path}, {page.path}")
