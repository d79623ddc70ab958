"""Meshes of glyphs and random domains: each is sound, or the domain was refused for a reason that holds.

Rows go to a file as they come; a run that is begun again goes on after the last one.
"""

import json
import random
from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely

from benchmarks.robustness.capped import Call
from benchmarks.robustness.corpus import Keys, glyphs, random_domains
from benchmarks.robustness.soundness import faults
from benchmarks.robustness.trials import Row, completed, counted_outcomes, row_options

METHODS = ("multilevel", "accelerated")
SPACINGS = ("coarse", "fine", "graded")
# Most packings are short ones: what is tried is whether meshes are sound, and all stages have a part in that.
SHORT: dict[str, Keys] = {
    "multilevel": {"packing": {"effort": "fast"}},
    "accelerated": {"schedule": {"rounds": 2, "iterations": 30}},
}
WHOLE = 10  # every so many-th packing is one of the method's own length


def tasks(glyph_count: int, domain_count: int) -> Iterator[Keys]:
    """A case for each domain, spacing and method, in an order in which any first part is a fair sample."""
    domains = [*glyphs(glyph_count), *random_domains(domain_count)]
    order = [(name, domain, s, m) for name, domain in domains for s in SPACINGS for m in METHODS]
    random.Random(0).shuffle(order)
    for number, (name, domain, spacing, method) in enumerate(order):
        yield {
            "name": f"{name}.{spacing}.{method}",
            "domain": domain,
            "spacing": _spacing(domain, spacing),
            "method": method,
            **(SHORT[method] if number % WHOLE else {}),
        }


def _spacing(domain: Keys, kind: str) -> Any:
    x0, y0, x1, y1 = _bounds(domain["outer"])
    size = max(x1 - x0, y1 - y0)
    if kind != "graded":
        return size / {"coarse": 5, "fine": 14}[kind]
    return {"value": size / 5, "near": [{"point": [x0, y0], "size": size / 60, "growth": 0.3}], "growth": 0.3}


def _bounds(ring: Keys) -> tuple[float, float, float, float]:
    if "rectangle" in ring:
        x0, y0, x1, y1 = ring["rectangle"]
        return x0, y0, x1, y1
    if "polygon" in ring:
        x, y = np.transpose(ring["polygon"])
        return float(x.min()), float(y.min()), float(x.max()), float(y.max())
    inner = ring.get("circle") or ring["ellipse"]
    radius = max(inner.get("radii", [inner.get("radius")]))
    return -radius, -radius, radius, radius


def _polygon(domain: Keys) -> shapely.Polygon | None:
    """The domain, if all of its sides are straight."""
    rings = [domain["outer"], *domain.get("holes", [])]
    if not all(ring.keys() <= {"polygon", "rectangle"} for ring in rings):
        return None
    outlines = [ring.get("polygon") or shapely.box(*ring["rectangle"]).exterior.coords for ring in rings]
    return shapely.Polygon(outlines[0], outlines[1:])


def mesh_one(case: Keys) -> Row:
    """Row of a case: sound, or what is wrong, or why it was refused."""
    from bubblemesh.case import load_case
    from bubblemesh.errors import BubblemeshError
    from bubblemesh.run.pipeline import mesh_case

    polygon = _polygon(case["domain"])
    valid = polygon is None or polygon.is_valid
    try:
        result = mesh_case(load_case("case.yaml", text=json.dumps(case)))
    except BubblemeshError as error:
        kind = "refused, and invalid" if error.exit_code == 3 and not valid else "refused"
        return {"outcome": kind, "why": f"{error.exit_code}: {error}"}
    mesh, quality = result.mesh, result.report["quality"]
    found = faults(mesh.points, mesh.triangles, mesh.facets, None if polygon is None or not valid else polygon.area)
    return {
        "outcome": "unsound" if found else "sound",
        "why": "; ".join(found),
        "nodes": len(mesh.points),
        "least": quality["min"],
        "mean": quality["mean"],
        "warnings": len(result.report["warnings"]),
    }


def row_of(call: Call) -> Row:
    """Row of a call, whatever became of it."""
    row = {"name": call.task["name"], "seconds": round(call.seconds, 3)}
    if call.crash is None:
        return row | call.value
    lines = call.crash.strip().splitlines()
    outcome = "no end" if lines[-1].startswith("no end") else "crash"
    return row | {"outcome": outcome, "why": lines[-1], "traceback": call.crash}


def main(arguments: list[str]) -> None:
    """Mesh what is not meshed yet, and count the outcomes."""
    parser = row_options("meshes", 120, 3000, __doc__)
    parser.add_argument("--glyphs", type=int, default=3000)
    parser.add_argument("--domains", type=int, default=2000)
    parser.add_argument("--most", type=int, help="how many of all cases to mesh")
    options = parser.parse_args(arguments)
    chosen = list(tasks(options.glyphs, options.domains))[: options.most]
    print(*counted_outcomes(completed(mesh_one, row_of, chosen, options)), sep="\n")
