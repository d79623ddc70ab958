"""Preview of a run: what meshing a case would take, as figures and as a picture of the spacing."""

from pathlib import Path
from typing import Any

from bubblemesh.case import Case
from bubblemesh.errors import located
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem
from bubblemesh.run.estimate import estimate
from bubblemesh.run.limits import within_limits


def preview(case: Case, source: str, picture: Path | None = None, *, complete: bool = True) -> dict[str, Any]:
    """Figures of what a case asks for, as `estimate` returns them, found within the limits of the case.

    If a ``picture`` is named, it is drawn as `draw_preview` does. Errors begin with the ``source``, the name of the
    case's file.
    """

    def found() -> dict[str, Any]:
        with located(source, case.origin):
            problem = prepare(case)
        figures = estimate(problem, complete)
        if picture is not None:
            draw_preview(problem, picture)  # last: while files get their names no time limit holds
        return figures

    return within_limits(case, found, f"{source}: ")


def draw_preview(problem: Problem, picture: Path) -> None:
    """Draw the spacing of a problem, or its rings before and after a repair that changed them.

    CaseError if the ending of the file is not that of a picture, FileError if it cannot be written.
    """
    # Imported here since few previews have a picture.
    from bubblemesh.pictures.plots import require_picture
    from bubblemesh.pictures.repairs import draw_repairs
    from bubblemesh.pictures.spacing_plots import draw_spacing
    from bubblemesh.problem.ruling import ruling
    from bubblemesh.run.assembly import previewed

    require_picture(picture)  # before the work
    if changes := problem.domain.changes:
        before = [points for change in changes for points in change.before]
        draw_repairs(problem.domain.polygon, before, [change.at for change in changes], picture)
        return
    mesh, spacing = previewed(problem)
    setters = ruling(problem, mesh.points[mesh.triangles[:, :3]].mean(axis=1))
    draw_spacing(mesh, spacing, problem.packing_extremes.both, picture, problem.task.name, setters)
