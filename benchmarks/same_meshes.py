"""Whether a change keeps every mesh the same, byte for byte: ``python -m benchmarks.same_meshes``.

``--record FILE`` meshes all cases of ``configs/`` up to 28,000 nodes and 100 generated ones, and notes the hash of each
file and the figures of each report; ``--against FILE`` does the same and compares. ``--package DIR`` meshes with the
package of another checkout, such as one from before the change.
"""

import argparse
import json
import math
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
CONFIGS = ROOT / "configs"
TOO_LARGE = {"example-3-87000", "example-3-280000", "example-3-900000"}
GENERATED = 100
CHANGING = {"seconds", "peak_memory_mb", "version", "engine"}  # what no two reports have in common

Case = dict[str, Any]


def circle(radius: float, x: float = 0.0, y: float = 0.0) -> Case:
    """A round ring."""
    return {"circle": {"center": [x, y], "radius": radius}}


def star(random_: random.Random) -> Case:
    """A polygon with 5 to 16 corners at random distances from its middle."""
    count = random_.randint(5, 16)
    radii = [random_.uniform(0.7, 1.3) for _ in range(count)]
    angles = [2 * math.pi * k / count for k in range(count)]
    return {"polygon": [[r * math.cos(a), r * math.sin(a)] for r, a in zip(radii, angles, strict=True)]}


def comb(random_: random.Random) -> Case:
    """A bar with teeth."""
    teeth = random_.randint(2, 4)
    corners = [[-1.0, -1.0], [1.0, -1.0]]
    for k in range(teeth):
        right = 1 - 2 * k / teeth
        corners += [[right, 0.8], [right - 1 / teeth, 0.8], [right - 1 / teeth, -0.3]]
        corners += [[right - 2 / teeth, -0.3]] if k < teeth - 1 else []
    return {"polygon": [*corners, [-1.0, -0.3]]}


def smooth_path(random_: random.Random) -> Case:
    """A half disc whose straight side is a spline."""
    bulge = random_.uniform(-0.4, 0.4)
    spline = {"spline": {"through": [[-0.3, bulge], [0.3, -bulge], [1, 0]]}, "label": "wavy"}
    return {"path": [[-1, 0], spline, {"arc": {"to": [-1, 0], "center": [0, 0], "turn": "left"}, "label": "round"}]}


OUTLINES = {
    "star": star,
    "comb": comb,
    "path": smooth_path,
    "disc": lambda random_: circle(random_.uniform(0.8, 1.2)),
    "ellipse": lambda random_: {"ellipse": {"center": [0, 0], "radii": [1.2, 0.5], "angle": random_.uniform(0, 90)}},
    "box": lambda random_: {"rectangle": [-1, -1, 1, random_.uniform(0.6, 1.2)], "labels": ["s", "e", "n", "w"]},
}
SPACINGS: list[Any] = [
    0.09,
    "0.06 + 0.05*hypot(x, y)",
    "where(x > 0.1, 0.05, 0.11)",
    {"value": 0.15, "near": [{"point": [0.1, 0.1], "size": 0.03, "growth": 0.2}], "growth": 0.25},
    {"value": 0.2, "per_circle": 36, "across": 2, "growth": 0.3},
    {"value": "0.1 + 0.05*x", "nodes": 500},
]


def generated() -> Iterator[tuple[str, Case]]:
    """Names and data of the generated cases, the same at every call."""
    outlines, methods = list(OUTLINES), ["multilevel"] * 6 + ["accelerated", "fnpbs", "bpm"]
    for number in range(GENERATED):
        random_ = random.Random(number)
        outline = outlines[number % len(outlines)]
        domain: Case = {"outer": OUTLINES[outline](random_)}
        box = outline == "box"
        if box or (outline in ("star", "disc") and number % 4 == 1):
            domain["holes"] = [circle(random_.uniform(0.1, 0.25), -0.2, 0.1)]
        if box and number % 3 == 0:
            domain["regions"] = [{"name": "core", **circle(0.2, 0.5, 0.1), "spacing": 0.05}]
        elif box and number % 3 == 1:
            domain["lines"] = [{"points": [[0.3, -0.5], [0.7, -0.1]], "label": "crack"}]
            domain["points"] = [{"at": [-0.7, -0.7], "label": "gauge"}]
        elif box:
            domain["periodic"] = [["w", "e"]]
        connected_only = "periodic" in domain
        method = "multilevel" if connected_only else methods[number % len(methods)]
        case = {
            "name": f"generated-{number:03}-{outline}",
            "domain": domain,
            "spacing": random_.choice(SPACINGS),
            "method": method,
            "packing": {"seed": number},
            "output": {"formats": ["msh", "vtu", "xdmf", "inp", "mesh"], "order": 1 + number % 7 // 6},
        }
        yield f"generated-{number:03}", case


def groups(folder: Path) -> Iterator[tuple[str, list[Path]]]:
    """Cases that may be one batch: those of each folder of ``configs/``, and the generated ones."""
    yield "quickstart", [CONFIGS / "quickstart.yaml"]
    for name in ("paper", "gallery", "peers"):
        for inside in [CONFIGS / name, *sorted(path for path in (CONFIGS / name).iterdir() if path.is_dir())]:
            found = [path for path in sorted(inside.glob("*.yaml")) if path.stem not in TOO_LARGE]
            yield inside.relative_to(CONFIGS).as_posix(), found
    made = []
    for name, case in generated():
        made.append(folder / f"{name}.yaml")
        made[-1].write_text(json.dumps(case), encoding="utf-8")
    yield "generated", made


def steady(value: Any) -> Any:
    """A report without what changes from run to run."""
    if isinstance(value, dict):
        return {key: steady(entry) for key, entry in value.items() if key not in CHANGING}
    return [steady(entry) for entry in value] if isinstance(value, list) else value


def meshed(package: Path, only: list[str] | None) -> dict[str, Any]:
    """Exit code, hashes of files and report of each case, by group and name; of all groups, or of some."""
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for group, cases in groups(Path(folder)):
            if only and group not in only:
                continue
            out = Path(folder, "out", group)
            command = [sys.executable, "-m", "bubblemesh", "batch", *map(str, cases), "-o", str(out), "-q"]
            environment = os.environ | {"PYTHONPATH": str(package)}
            ended = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True)
            if not (out / "summary.jsonl").exists():
                raise SystemExit(ended.stderr)
            for row in map(json.loads, (out / "summary.jsonl").read_text().splitlines()):
                files = {name: digest for name, digest in row["files"].items() if not name.endswith("report.json")}
                report = out / f"{row['case']}.report.json"
                found[f"{group}/{row['case']}"] = {
                    "exit_code": row["exit_code"],
                    "error": row["error"] and row["error"].replace(folder, ""),
                    "files": dict(sorted(files.items())),
                    "report": steady(json.loads(report.read_text())) if report.exists() else None,
                }
            print(f"{group}: {len(cases)} cases", file=sys.stderr)
    return found


def differences(before: dict[str, Any], now: dict[str, Any]) -> Iterator[str]:
    """What differs, a line for each case."""
    for name in sorted(before.keys() | now.keys()):
        a, b = before.get(name), now.get(name)
        if a is None or b is None:
            yield f"{name}: only {'before' if b is None else 'now'}"
        elif a != b:
            files = sorted(key for key in a["files"].keys() | b["files"] if a["files"].get(key) != b["files"].get(key))
            keys = sorted(k for k in (a["report"] or {}) | (b["report"] or {}) if _entry(a, k) != _entry(b, k))
            ends = "" if a["error"] == b["error"] else f"; {a['error']!r}, now {b['error']!r}"
            yield f"{name}: files {files}; report {keys}{ends}"


def _entry(case: dict[str, Any], key: str) -> Any:
    return (case["report"] or {}).get(key)


def main() -> None:
    """Record or compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    action = parser.add_mutually_exclusive_group(required=True)
    action.add_argument("--record", type=Path, metavar="FILE")
    action.add_argument("--against", type=Path, metavar="FILE")
    parser.add_argument("--package", type=Path, default=ROOT, metavar="DIR")
    parser.add_argument("--only", action="append", metavar="GROUP", help="such as quickstart, gallery, generated")
    options = parser.parse_args()
    now = meshed(options.package.resolve(), options.only)
    digest = sha256(json.dumps({name: case["files"] for name, case in now.items()}, sort_keys=True).encode())
    print(f"{len(now)} cases, {sum(len(case['files']) for case in now.values())} files: {digest.hexdigest()}")
    if options.record:
        options.record.write_text(json.dumps(now, indent=1), encoding="utf-8")
        return
    before = json.loads(options.against.read_text(encoding="utf-8"))
    if options.only:
        before = {name: case for name, case in before.items() if name.rpartition("/")[0] in options.only}
    different = list(differences(before, now))
    print(*different or ["all files and reports are the same"], sep="\n")
    raise SystemExit(1 if different else 0)


if __name__ == "__main__":
    main()
