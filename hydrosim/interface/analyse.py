"""Analyses of a case without a run: `analyse` by frequencies, of a mooring line, of ballast, of
methods and steps; `fit_decay` of recorded decay tests."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from inspect import signature
from math import degrees, pi, radians
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydrosim.case import Case, as_case
from hydrosim.case.lines.chains import is_mooring_file, read_mooring_system
from hydrosim.errors import InputError
from hydrosim.files import arguments
from hydrosim.files.display_units import DEFAULT, Units, unit_choice_attribute, units_of
from hydrosim.files.outputs import Output
from hydrosim.interface.printed import Findings, PrintedResult, run_analysis
from hydrosim.scene import Scene
from hydrosim.simulation import prepare_scene

if TYPE_CHECKING:
    from hydrosim.analysis.line import StillLine

MAX_ANGLE_RAD = 1.48  # rad (85 deg)
ALL_LINES = "all"
EXPECTED_FILE = "a case file (YAML), or an input file of MoorDyn or MoorPy"
Values = arguments.Amount | Sequence[float]
Report = Callable[[str], None]
"""Receives what is being computed."""


class Task(NamedTuple):
    """What any analysis is told: the ``case``, scene or file, and where results go."""

    case: Any
    output: arguments.Target
    overwrite: bool
    progress: Report

    @property
    def scene(self) -> Scene:
        """The scene of the case."""
        return self.case if isinstance(self.case, Scene) else as_case(self.case).scene()


def analyse(
    case: Case | Scene | str | Path,
    *,
    line: str | bool = False,
    ballast: bool = False,
    converge: bool = False,
    output: arguments.Target = None,
    overwrite: bool = False,
    progress: Report = lambda _: None,
    **options: Any,
) -> PrintedResult:
    """Analyse a case, or a file of one, without a run.

    By default the analysis is linear: equilibrium without friction, natural modes, RAOs and the
    response in the sea. Its options are ``time``, ``headings`` [deg], ``periods`` [s], ``database``
    and ``contacts``. With ``line``, the name of a mooring line or "all", it is that of the line
    over the ``offset`` of its fairlead; a file of MoorDyn or MoorPy needs no ``line``. With
    ``ballast``, it is the loading condition at a ``time``, with the pump plan for a ``lift`` or a
    ``rise`` of a ``body`` ``within`` a time, and the loss of GM at a ``heel``. With ``converge``,
    errors and run times of ``methods`` are compared over ``steps`` and ``tolerances``.

    Numbers are in SI or texts with a unit, unless another unit stands above. With ``output``, files
    are written as by `hydrosim analyse`. Raises InputError for options of another analysis.

    >>> modes = hs.analyse("cases/sphere/decay.yaml").dataset
    >>> round(float(modes.natural_period[0]), 1)
    4.4
    """
    named = [("line", line), ("ballast", ballast), ("converge", converge)]
    kinds = [name for name, choice in named if choice]
    if len(kinds) > 1:
        raise InputError(f"{', '.join(kinds)}: found several; expected one of them.")
    of_lines = isinstance(case, str | Path) and is_file_of_lines(Path(case))
    kind = kinds[0] if kinds else "line" if of_lines else "linear"
    if of_lines and kind != "line":
        raise InputError(f"{kind}: found {case}, which is no case; expected a case.")
    if kind == "line":
        options["name"] = line if isinstance(line, str) and line != ALL_LINES else None
    elif not isinstance(case, Scene):
        case = as_case(case)
    analysis = ANALYSES[kind]
    known = [*signature(analysis).parameters][1:]
    if foreign := [name for name in options if name not in known]:
        raise InputError(
            f"{', '.join(foreign)}: not possible with {NAMES_OF_ANALYSES[kind]}. Leave it out."
        )
    return analysis(Task(case, output, overwrite, progress), **options)


def is_file_of_lines(file: Path) -> bool:
    """Whether a file is one of MoorDyn or MoorPy: neither a case nor a result."""
    return file.suffix != ".nc" and is_mooring_file(file)


def _analyse_linearly(
    task: Task,
    time: arguments.Amount = 0.0,
    headings: Values = (),
    periods: Values = (),
    database: bool = False,
    contacts: str = "stuck",
) -> PrintedResult:
    from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
    from hydrosim.compile.compile import Radiation
    from hydrosim.linear.equilibrium import Contacts
    from hydrosim.report.charts.analysis import draw_response
    from hydrosim.report.sentences.analysis import linear_document

    begin = arguments.seconds("time", time)
    state = arguments.one_of(Contacts, contacts, "contacts")
    all_headings = arguments.numbers(headings, "headings", positive=False) if headings else []
    all_periods = arguments.numbers(periods, "periods") if periods else []
    asked = {
        "time": begin,
        "headings": all_headings,
        "periods": all_periods,
        "database": database,
        "contacts": state,
    }
    result = _output(task, "linear", asked)
    page = arguments.picture_beside(result)
    request = LinearRequest(
        begin,
        [radians(heading) for heading in all_headings],
        sorted(2 * pi / period for period in all_periods),
        Radiation.DATABASE if database else Radiation.MODEL,
        contacts=state,
    )
    task.progress("linear analysis")
    scene = task.scene

    def compute() -> Findings:
        dataset = linear_analysis(scene, request)
        document = linear_document(dataset, raos=bool(all_periods))
        return Findings(document, dataset, partial(draw_response, dataset))

    return run_analysis(compute, result, page)


def _analyse_line(
    task: Task,
    name: str | None = None,
    offset: arguments.Amount | None = None,
) -> PrintedResult:
    """Tension, pull, stiffness and grounded length of a mooring line over offsets of its fairlead,
    with the lines of the file at rest."""
    from hydrosim.analysis.line import offsets_to, response
    from hydrosim.report.charts.analysis import draw_line
    from hydrosim.report.sentences.analysis import line_document

    case = task.case
    file = case.path if isinstance(case, Case) else Path(getattr(case, "title", case))
    if not isinstance(case, Scene):
        arguments.require_file(file, EXPECTED_FILE)
    largest = (
        None if offset is None else arguments.quantity("offset", offset, "length", "m", "20 m")
    )
    if largest is not None and not largest > 0.0:
        raise InputError(f"offset: found {largest:g} m; expected a length above 0.")
    page = arguments.output_for(
        task.output, f"{file.stem}_line", "line", file, overwrite=task.overwrite, suffix=".png"
    )
    task.progress("lines")

    def compute() -> Findings:
        title, lines, units, left_out = _lines_of(task)
        chosen = _choose_line(file, lines, name)
        offsets = offsets_to(largest or chosen.usual_offset())
        responses = (response(chosen, offsets, False), response(chosen, offsets, True))
        heading = f"{title}: line {chosen.name}"
        shown = [chosen] if name else lines
        return Findings(
            line_document(heading, shown, responses, units, left_out),
            draw=lambda out: draw_line(heading, chosen, responses, out, units),
        )

    return run_analysis(compute, page=page)


def _lines_of(task: Task) -> tuple[str, list[StillLine], Units, list[str]]:
    """Title, lines and units of a case, with its bodies as they are at the start, or of a file of
    another program; and what of that file is left out."""
    from hydrosim.analysis.line import lines_of_case, lines_of_system
    from hydrosim.compile.compile import compile_in_calm
    from hydrosim.files.text import Source

    case = task.case
    if isinstance(case, str | Path) and is_file_of_lines(Path(case)):
        system = read_mooring_system(Source(Path(case)))
        left_out = [entry.message for entry in system.left_out]
        return Path(case).name, lines_of_system(system), DEFAULT, left_out
    scene = task.scene
    return scene.title, lines_of_case(compile_in_calm(scene)), units_of(scene.source), []


def _choose_line(file: Path, lines: list[StillLine], name: str | None) -> StillLine:
    """The line that is asked for, or the first."""
    lines_by_name = {line.name: line for line in lines}
    if not lines_by_name:
        raise InputError(f"{file}: found no catenary; expected one under forces.")
    if name is not None and name not in lines_by_name:
        raise InputError(f"line: found {name}; expected one of {', '.join(lines_by_name)}.")
    return lines_by_name[name] if name is not None else lines[0]


def _analyse_ballast(
    task: Task,
    time: arguments.Amount = 0.0,
    lift: arguments.Amount | None = None,
    rise: arguments.Amount | None = None,
    within: arguments.Amount = 3600.0,
    heel: arguments.Amount | None = None,
    body: str | None = None,
) -> PrintedResult:
    """The loading condition of bodies with tanks, and a plan of their pumps."""
    from hydrosim.analysis.ballast import conditions, find_pump_plan
    from hydrosim.compile.compile import compile_in_calm
    from hydrosim.report.charts.analysis import draw_loading
    from hydrosim.report.sentences.analysis import ballast_document
    from hydrosim.tanks.contents import triggered_pumps

    page = _output(task, "ballast", suffix=".png")
    at = arguments.quantity("time", time, "time", "s", "1 hour")
    angle = None if heel is None else arguments.quantity("heel", heel, "angle", "rad", "5 deg")
    if angle is not None and not 0.0 < abs(angle) < MAX_ANGLE_RAD:
        raise InputError(
            f"heel: found {degrees(angle):.4g} deg; expected an angle above 0 and below 85 deg."
            ' A number without a unit is in rad: write "5 deg".'
        )
    scene = task.scene
    bodies = [body.name for body in scene.bodies if body.tanks]
    if not bodies:
        raise InputError(
            f"{scene.title}: no body has tanks; expected at least one. Add them under"
            " bodies.NAME.tanks."
        )
    if body is not None and body not in bodies:
        raise InputError(f"body: found {body}; expected one of {', '.join(bodies)}.")
    force = ("force", "N", "20000 tonne_force")
    weight = None if lift is None else arguments.quantity("lift", lift, *force)
    height = 0.0 if rise is None else arguments.quantity("rise", rise, "length", "m", "0.5 m")
    span = arguments.quantity("within", within, "time", "s", "1 hour")
    task.progress("loading condition")

    def compute() -> Findings:
        compiled = compile_in_calm(scene)
        conditions_found = conditions(compiled, at, angle)
        is_moved = lift is not None or rise is not None
        plan = (
            find_pump_plan(compiled, body or bodies[0], span, weight, height) if is_moved else None
        )
        waiting = [pump.key for pump in triggered_pumps(scene)] if at > 0.0 else []
        return Findings(
            ballast_document(scene, conditions_found, at, angle, plan, waiting),
            draw=lambda out: draw_loading(conditions_found, at, out, units_of(scene.source)),
        )

    return run_analysis(compute, page=page)


def _analyse_convergence(
    task: Task,
    methods: arguments.Names = "rk2,rk4,dopri5",
    steps: Values = "0.1,0.05,0.025",
    tolerances: Values = "1e-5,1e-6,1e-7",
) -> PrintedResult:
    """Error against run time of methods and steps."""
    from hydrosim.report.charts.analysis import draw_work_precision
    from hydrosim.report.sentences.run import study_document
    from hydrosim.scene import Method
    from hydrosim.study.converge import converge, to_dataset

    names = methods.split(",") if isinstance(methods, str) else methods
    chosen = [arguments.one_of(Method, name, "methods") for name in names]
    if Method.AUTOMATIC in chosen:
        raise InputError(
            "methods: found automatic, which only selects one of the other methods; expected"
            " rk2, heun, rk4, dopri5 or esdirk4."
        )
    all_steps = arguments.numbers(steps, "steps")
    all_tolerances = arguments.numbers(tolerances, "tolerances")
    asked = {"methods": chosen, "steps": all_steps, "tolerances": all_tolerances}
    result = _output(task, "converge", asked, what="convergence")
    page = arguments.picture_beside(result)

    def compute() -> Findings:
        scene = prepare_scene(task.case)
        study = converge(scene, chosen, all_steps, all_tolerances, task.progress)
        units = unit_choice_attribute(scene.source)
        dataset = to_dataset(study, scene.title).assign_attrs(units)
        document = study_document(study, scene.title, units_of(scene.source))
        return Findings(document, dataset, partial(draw_work_precision, dataset))

    return run_analysis(compute, result, page)


ANALYSES: dict[str, Callable[..., PrintedResult]] = {
    "linear": _analyse_linearly,
    "line": _analyse_line,
    "ballast": _analyse_ballast,
    "converge": _analyse_convergence,
}
NAMES_OF_ANALYSES = {
    "linear": "a linear analysis",
    "line": "the analysis of a line",
    "ballast": "the analysis of ballast",
    "converge": "a comparison of methods and steps",
}


def _output(
    task: Task,
    name: str,
    asked: dict[str, Any] | None = None,
    what: str = "",
    suffix: str = ".nc",
) -> Output | None:
    case = task.case
    if isinstance(case, Scene):
        if task.output in (None, False):
            return None
        raise InputError("output: found a scene; expected a case, whose file names results.")
    return arguments.output_for(
        task.output,
        f"{case.path.stem}_{name}",
        what or name,
        case.path,
        inputs=case.inputs(),
        overwrite=task.overwrite,
        suffix=suffix,
        settings="" if asked is None else case.settings(asked),
    )


def fit_decay(
    records: str | Path | Sequence[str | Path],
    *,
    column: str = "roll",
    unit: str = "",
    start: arguments.Amount | None = None,
    end: arguments.Amount | None = None,
    body: str = "barge",
    output: arguments.Target = None,
    overwrite: bool = False,
) -> PrintedResult:
    """Roll damping p1, p2, p3 and natural period of recorded decay tests, with 90 % intervals; and
    the keys of a case that give it to a ``body``.

    ``column`` is that of the roll angle, in ``unit`` (deg or rad) if the files do not say it. The
    fit begins at ``start`` and stops at ``end`` [s]. Keys are written to ``output``, and a picture
    beside it; True draws the picture alone.

    >>> t = np.arange(0.0, 200.0, 0.2)
    >>> roll = 8.0 * np.exp(-0.01 * t) * np.cos(0.6 * t)
    >>> head = {"header": "time [s],roll [deg]", "comments": ""}
    >>> np.savetxt("decay.csv", np.c_[t, roll], "%g", ",", **head)
    >>> "p1: 0.02 s^-1" in str(hs.decay("decay.csv"))
    True
    """
    from hydrosim.elements.roll_decay import fit_files
    from hydrosim.report.charts.analysis import draw_decay
    from hydrosim.report.sentences.analysis import calibration_document, keys_of

    paths = [Path(x) for x in ([records] if isinstance(records, str | Path) else records)]
    if not paths:
        raise InputError("records: found none; expected recordings of decaying roll.")
    for path in paths:
        arguments.require_file(path, "a recording of decaying roll")
    if unit not in ("", "deg", "rad"):
        raise InputError(f"unit: found {unit!r}; expected deg or rad.")
    first = Output(paths[0], "keys", paths[0], tuple(paths), overwrite, "output")
    keys = page = None
    if not isinstance(output, bool) and output is not None:
        keys = first.output_at(Path(output)).checked_output()
        if keys.path.suffix not in (".yaml", ".yml"):
            raise InputError(f"output: found {output}; expected a name that ends in .yaml.")
    if output:
        drawn = keys.path.with_suffix(".png") if keys else Path(f"{paths[0].stem}_fit.png")
        page = first.output_at(drawn, "picture").checked_output()
    begin = None if start in (None, "") else arguments.seconds("start", start)
    close = None if end in (None, "") else arguments.seconds("end", end)
    fit = fit_files(paths, column, unit or None, begin, close)
    if page:
        draw_decay(fit, page)
    lines = keys_of(fit, body)
    if keys:
        with keys.write_complete() as path:
            path.write_text("\n".join([f"# {keys.mark}", *lines, ""]), encoding="utf-8")
    shown = () if keys else tuple(lines)
    files = tuple(made.path for made in (keys, page) if made)
    return PrintedResult(calibration_document(fit), files=files, lines=shown)
