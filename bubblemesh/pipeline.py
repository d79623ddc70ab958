"""From a case to a mesh: the whole story on one screen."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from bubblemesh import compromises
from bubblemesh.arrays import Floats, Integers
from bubblemesh.case import Case
from bubblemesh.conformity import require_conforming
from bubblemesh.geometry.domain import Domain
from bubblemesh.mesh import Mesh
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.connection import connected
from bubblemesh.packing.methods import Method
from bubblemesh.packing.options import configured
from bubblemesh.packing.rounds import Round, rounds
from bubblemesh.quality import radius_ratios
from bubblemesh.record import Measured, measured, run_record
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.refinement import coarse_curves, short_pieces
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Survey, surveyed

__all__ = ["Problem", "Result", "RoundRow", "mesh_case", "prepared"]
