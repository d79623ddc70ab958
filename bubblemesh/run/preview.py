"""The spacing of a problem on a coarse mesh, to look at before any packing."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.packing.net import connect_inside
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.problem.problem import Problem
from bubblemesh.run.assembly import mesh_of
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Extremes

FINEST, COARSEST = 1 / 160, 1 / 60  # of the domain's size: triangles that pictures show
ENOUGH = 1_000_000


class Preview(NamedTuple):
    """A mesh, the spacing (n,) at its nodes, and its extremes in the whole domain."""

    mesh: Mesh
    spacing: Floats
    extremes: Extremes


def previewed(problem: Problem) -> Preview:
    """The spacing that the packing goes by, on triangles that are fine enough for a picture and no finer."""
    domain, wanted = problem.domain, problem.packing_spacing
    finest, coarsest = FINEST * domain.size, COARSEST * domain.size

    def shown(x: Floats, y: Floats) -> Floats:
        return np.clip(wanted.extended(np.column_stack([x, y])), finest, coarsest)

    spacing = Spacing(shown, finest)
    mesh = mesh_of(connect_inside(ErrorDiffusion()(domain, spacing, ENOUGH), domain, spacing), domain)
    return Preview(mesh, wanted(mesh.points), problem.packing_extremes)
