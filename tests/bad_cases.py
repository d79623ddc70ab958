"""Cases for the tests of bad input."""

import json

from commands import command

from bubblemesh.case import load_case
from bubblemesh.run.pipeline import mesh_case

UNIT = {"rectangle": [0, 0, 1, 1]}


def case(domain, spacing=0.2, **more):
    return json.dumps({"domain": domain, "spacing": spacing, "packing": {"effort": "fast"}} | more)


def circle(x, y, radius):
    return {"circle": {"center": [x, y], "radius": radius}}


def polygon(*points):
    return {"polygon": [list(point) for point in points]}


def meshed(here, text):
    """Report and mesh of a case that is accepted, whose warnings the command line tells."""
    (here / "case.yaml").write_text(text)
    result = mesh_case(load_case(here / "case.yaml"))
    code, out, message = command("check", "case.yaml", "-q")
    assert (code, out) == (0, "")
    told = [line.removeprefix("warning: ") for line in message.splitlines()]
    assert told == result.report["warnings"][: len(told)]  # those of the finished mesh come after
    return result.report, result.mesh


SQUARE = "domain: {{outer: {{rectangle: [0, 0, 1, 1]}}}}\nspacing: {}\n"
