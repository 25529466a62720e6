"""Commands of design: a damper for a target, materials."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..errors import UsageError
from .common import ConfigArgument, one_line_errors, picture_file, stoppable, writable

app = typer.Typer()


@app.command()
def design(
    config: ConfigArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the results.")] = Path("results"),
    workers: Annotated[int | None, typer.Option(min=1, help="Workers (default: all cores).")] = None,
) -> None:
    """Find a damper for a structure and a target, with the probability that it does the job.

    Every case is kept in OUTPUT/CONFIG-design/ as soon as it is done; the same command goes on from there.
    """
    with one_line_errors():
        from ..analysis.results import write
        from ..config.reading import IN_SI, resolved_yaml
        from ..design.dataset import to_dataset
        from ..design.run import design as search
        from ..files import whole_file
        from ..report.design import lines, picture
        from ..report.figures import save
        from ..sweep.load import load

        checked = load(config)
        store = output / f"{config.stem}-design"
        writable(store)

        def say(line: str) -> None:
            print(line, flush=True)

        with stoppable(store):
            answer = search(checked, store, workers=workers, say=say)
        said = "\n".join(lines(answer))
        target = output / f"{config.stem}-design.yaml"
        with whole_file(target) as part:
            comment = f"# {said.replace(chr(10), chr(10) + '# ')}\n"
            part.write_text(IN_SI + comment + resolved_yaml(answer.configuration()))
        save(picture(answer), target.with_suffix(".png"))
        write(to_dataset(answer), target.with_suffix(".nc"))
    print(said)
    print(f"{target}, {target.stem}.png and {target.stem}.nc: `warpdamp report` makes a page of the last")


@app.command()
def compare(
    file: Annotated[Path, typer.Argument(help="Results of a run with a structure.", metavar="RESULTS.nc")],
    measured: Annotated[
        Path, typer.Argument(help="Table: gamma, damping_ratio, frequency ...", metavar="MEASURED.csv")
    ],
    calibrate: Annotated[
        bool, typer.Option("--calibrate", help="Find what the swept scalars, as restitution, are by the measurement.")
    ] = False,
    at: Annotated[list[str] | None, typer.Option(help="Value of a swept scalar, as friction=0.5.")] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Picture (default: beside MEASURED).")] = None,
) -> None:
    """Compare measured damping and frequency with results: overlay, residuals over joint errors, calibration."""
    with one_line_errors():
        from ..accessor import open_results
        from ..modal.apparent_mass import require_modes
        from ..modal.calibrate import calibrate as calibrated
        from ..modal.frf import chosen
        from ..modal.measured import compare as compared
        from ..modal.measured import read_measured
        from ..report.compare import calibration_lines, comparison_lines, overlay, posterior_overlay
        from ..report.figures import save

        target = picture_file(output or measured.with_suffix(".png"))
        dataset = open_results(file)
        require_modes(dataset)
        points = read_measured(measured, dataset["mode"].values)
        dataset = chosen(dataset, at or [])
        if calibrate:
            found = calibrated(dataset, points)
            said, figure = calibration_lines(found, points), posterior_overlay(found, points)
        else:
            residuals = compared(dataset, points)
            said, figure = comparison_lines(residuals), overlay(dataset, residuals)
        save(figure, target)
    for line in said:
        print(line)
    print(target)


@app.command()
def materials(
    name: Annotated[str | None, typer.Argument(help="Material (default: all).", metavar="[NAME]")] = None,
) -> None:
    """Show the library of materials: values, ranges and sources."""
    from rich.console import Console

    with one_line_errors():
        from ..config.messages import suggestion
        from ..report.materials import material_lines, materials_table, sources_lines
        from ..scene.materials import LIBRARY

        if name is not None and name not in LIBRARY:
            raise UsageError(f"there is no material '{name}'{suggestion(name, LIBRARY)}")
    console = Console()
    if name is None:
        console.print(materials_table())
    for line in sources_lines() if name is None else material_lines(name):
        console.print(line, highlight=False, markup=False, soft_wrap=True)
