"""One mesh packed in parts: ``python -m benchmarks.large`` meshes in one piece, and in parts by 1 and 2 workers.

One worker and two take turns, ``--turns`` times: of each the run of median time counts, and of the speed-up the median
of the turns. In each turn two runs of a part's size, which know nothing of each other, go at once and one after the
other: two workers cannot gain more than these here. Meshes of at most ``--whole`` nodes are packed by 4 workers too, by
2 of which one is killed on the way, and by 2 of a Dask cluster; of larger ones there are three turns at the most. Files
of parts have to be the same bytes, whoever packs them. It prints a table of wall and processor time, memory and
quality, beside the cuts and away from them; ``-o docs/large.md`` writes it between the marks of that page.
"""

import argparse
import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from hashlib import file_digest, sha256
from importlib.util import find_spec
from math import inf
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, sleep
from typing import Any

import h5py
import numpy as np
import shapely

from benchmarks.dask_workers import dask_workers
from benchmarks.peers.machine import machine
from bubblemesh.case import load_case
from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.parts.cuts import find_cuts
from bubblemesh.parts.pipeline import enough_parts
from bubblemesh.problem.prepare import prepare

PEERS = Path(__file__).parents[1] / "configs" / "peers" / "example-3.yaml"
# Nodes of Example 3 and of the coast at the scale 1; the number goes with the square of the scale.
NODES_AT_ONE, COAST_AT_ONE = 668.0, 5100.0
TICK = 0.1  # seconds between two looks at the memory
MOST_TURNS = 3  # of what is too large to be run in all ways
LEAST_PARTS = 4  # so that there is one for each of 4 workers
SETTLED = 5.0  # seconds that workers of a cluster take to start
BESIDE, AWAY = 2.0, 10.0  # spacings from a cut, and from a wall
BEGIN, END = "<!-- benchmarks.large -->", "<!-- end -->"


@dataclass(frozen=True)
class Run:
    """One run of the command."""

    name: str
    seconds: float
    cpu: float
    main_mb: float  # peak memory of the process that was started
    worker_mb: float  # the largest of its workers' peaks; 0 without any
    all_mb: float  # the most that all had at once
    digest: str  # of all files but the report
    folder: Path


def case_of(nodes: float) -> str:
    """Example 3 of the paper with about so many nodes."""
    return (
        f"base: {PEERS}\nname: large\nparameters: {{scale: {float(np.sqrt(NODES_AT_ONE / nodes)):.6g}}}\n"
        "limits: {max_nodes: 20000000}\noutput: {formats: [xdmf]}\n"
    )


def coast_of(nodes: float, folder: Path) -> str:
    """A coast of many vertices with islands, fine along the shore, with about so many nodes."""
    random = np.random.default_rng(7)

    def shore(center: tuple[float, float], radius: float, corners: int) -> shapely.Polygon:
        turn = np.linspace(0, 2 * np.pi, corners, endpoint=False)
        waves = sum(random.normal(0, 0.3 / k**1.6) * np.cos(k * turn + random.uniform(0, 6.3)) for k in range(2, 60))
        r = radius * (1 + 0.3 * np.tanh(waves))
        return shapely.Polygon(np.column_stack([center[0] + r * np.cos(turn), center[1] + r * np.sin(turn)]))

    sea, islands = shore((0, 0), 100, 1000), list[shapely.Polygon]()
    while len(islands) < 25:
        island = shore(tuple(random.uniform(-75, 75, 2)), random.uniform(2, 6), 60)
        if sea.buffer(-3).contains(island) and all(island.distance(other) > 3 for other in islands):
            islands.append(island)
    (folder / "coast.geojson").write_text(shapely.to_geojson(sea.difference(shapely.union_all(islands))))
    scale = float(np.sqrt(COAST_AT_ONE / nodes))
    return (
        "name: large\ndomain: {file: coast.geojson}\nlimits: {max_nodes: 20000000}\n"
        f'spacing: "min({5 * scale}, {0.8 * scale} + 0.1*distance())"\noutput: {{formats: [xdmf]}}\n'
    )


def written(name: str, nodes: float, place: Path) -> Path:
    """The case file of Example 3 or of the coast with about so many nodes, in a folder of its own."""
    folder = place / f"{name}-{nodes:g}".replace(" ", "-")
    folder.mkdir()
    path = folder / "large.yaml"
    path.write_text(coast_of(nodes, folder) if name == "coast" else case_of(nodes))
    return path


def ran(name: str, path: Path, *options: str, kill_after: float = inf, others: Sequence[int] = ()) -> Run:
    """Run a case in a process of its own, one of whose workers is killed after so many seconds.

    ``others`` are processes that work for it and are there already.
    """
    folder = path.parent / name.replace(" ", "-")
    before, begun = processor_seconds(others), perf_counter()
    process, peaks, together = started(path, folder, *options), dict[int, float](), 0.0
    while not has_ended(process):
        workers = [*children_of(process.pid), *others]
        held = {pid: memory_of(pid) for pid in (process.pid, *workers)}
        peaks |= {pid: max(peaks.get(pid, 0.0), megabytes) for pid, megabytes in held.items()}
        together = max(together, sum(held.values()))
        if perf_counter() - begun > kill_after:
            os.kill(workers[0], signal.SIGKILL)
            kill_after = inf
    assert process.returncode == 0
    assert kill_after == inf, "the run ended before a worker was killed"
    seconds, cpu = perf_counter() - begun, processor_seconds(others) - before
    main = peaks.pop(process.pid)
    return Run(name, seconds, cpu, main, max(peaks.values(), default=0.0), together, digest_of(folder), folder)


def started(path: Path, folder: Path, *options: str) -> subprocess.Popen[bytes]:
    """Start the command for a case."""
    return subprocess.Popen([sys.executable, "-m", "bubblemesh", "run", str(path), "-q", "-o", str(folder), *options])


def gain_of_two(path: Path) -> float:
    """How many times as fast two runs of a case are at once as one after the other."""
    seconds = list[float]()
    for count in (1, 2):
        begun = perf_counter()
        processes = [started(path, path.parent / f"at-once-{number}") for number in range(count)]
        assert all(process.wait() == 0 for process in processes)
        seconds.append(perf_counter() - begun)
    return 2 * seconds[0] / seconds[1]


def has_ended(process: subprocess.Popen[bytes]) -> bool:
    """Whether a process ends within a tick, without a wait beyond its end."""
    try:
        process.wait(TICK)
    except subprocess.TimeoutExpired:
        return False
    return True


def processor_seconds(others: Iterable[int]) -> float:
    """Processor time of all processes that were started here and have ended, and of others that live."""
    ended, tick = resource.getrusage(resource.RUSAGE_CHILDREN), os.sysconf("SC_CLK_TCK")
    columns = (Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split() for pid in others)
    return ended.ru_utime + ended.ru_stime + sum((int(column[11]) + int(column[12])) / tick for column in columns)


def digest_of(folder: Path) -> str:
    """Digest of all files of a run but its report, which tells times."""
    digest = sha256()
    for path in sorted(folder.iterdir()):
        if not path.name.endswith(".report.json"):
            with path.open("rb") as file:
                digest.update(path.name.encode() + file_digest(file, "sha256").digest())
    return digest.hexdigest()


def children_of(pid: int) -> list[int]:
    """Processes that a process has started and that live; none where there is no /proc."""
    try:
        return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def memory_of(pid: int) -> float:
    """Megabytes of memory that a process has now; 0 for one that is gone."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * resource.getpagesize() / 1e6
    except OSError:
        return 0.0


def report_in(folder: Path) -> dict[str, Any]:
    """The report of a run."""
    report: dict[str, Any] = json.loads((folder / "large.report.json").read_text())
    return report


def beside_cuts(path: Path, run: Run) -> dict[str, tuple[float, float]]:
    """Mean quality and first percentile of the triangles beside the cuts, and of those away from them."""
    problem = prepare(load_case(path))
    parts = report_in(run.folder)["parts"]["number"]
    cuts = find_cuts(problem.domain, problem.packing_spacing, problem.expected_nodes, parts)
    lines = shapely.union_all(shapely.linestrings([line.vertices for line in cuts.lines]))
    shapely.prepare(lines)
    with h5py.File(run.folder / "large.h5") as file:
        points, triangles = file["data0"][:], file["data1"][:]
    centers = points[triangles].mean(axis=1)
    away = shapely.distance(lines, shapely.points(centers)) / problem.packing_spacing.extended(centers)
    wall = problem.domain.distance_at_least(centers) / problem.packing_spacing.extended(centers)
    q = radius_ratios(points, triangles)
    groups = {"beside": (away < BESIDE) & (wall > AWAY), "away": (away > AWAY) & (wall > AWAY)}
    return {name: (float(q[mine].mean()), float(np.quantile(q[mine], 0.01))) for name, mine in groups.items()}


def in_parts(path: Path, part: Path, parts: int, turns: int, small: bool) -> Iterator[tuple[Run, str]]:
    """Runs in parts by 1 and 2 workers, in turns, with their speed-ups; if ``small``, also in all other ways.

    The case ``part`` has the size of one part, for what two workers can gain here at the most.
    """
    options = "--parts", str(parts), "--jobs"
    pairs, most = list[tuple[Run, Run]](), list[float]()
    for _ in range(turns):
        pairs.append((ran("1 worker", path, *options, "1"), ran("2 workers", path, *options, "2")))
        most.append(gain_of_two(part))
    assert len({run.digest for pair in pairs for run in pair}) == 1, "the files depend on the turn"
    one, two = (sorted(runs, key=lambda run: run.seconds)[turns // 2] for runs in zip(*pairs, strict=True))
    gains = [alone.seconds / shared.seconds for alone, shared in pairs]
    yield from ((one, "1.00"), (two, f"{middle(gains)}, at most {middle(most)}"))
    if not small:
        return
    for name, jobs, kill_after in (("4 workers", "4", inf), ("2 workers, one killed", "2", two.seconds / 2)):
        run = ran(name, path, *options, jobs, kill_after=kill_after)
        yield run, speed_up(one, run)
    if find_spec("distributed") is None:
        print("Dask is not installed: its workers are left out", file=sys.stderr)
        return
    with dask_workers(2, path.parent) as workers:
        sleep(SETTLED)
        run = ran("2 of Dask", path, *options[:2], "--cluster", workers.address, others=workers.pids)
    yield run, speed_up(one, run)


def middle(gains: Sequence[float]) -> str:
    """Median of some figures, with the least and the largest."""
    return f"{median(gains):.2f} ({min(gains):.2f} to {max(gains):.2f})"


def speed_up(one: Run, run: Run) -> str:
    """How many times as fast a run was as that of one worker."""
    return f"{one.seconds / run.seconds:.2f}"


def table(name: str, path: Path, part: Path, parts: int, turns: int, small: bool) -> list[str]:
    """Rows of a case in parts; if it is ``small``, also in one piece. The case ``part`` has the size of one part."""
    one = ran("one piece", path) if small else None
    runs = list(in_parts(path, part, parts, turns if small else min(turns, MOST_TURNS), small))
    alone = runs[0][0]
    assert len({run.digest for run, _ in runs}) == 1, "the files depend on the workers"
    q = beside_cuts(path, alone)
    rows = []
    for run, gain in runs if one is None else ((one, speed_up(alone, one)), *runs):
        report = report_in(run.folder)
        quality, nodes = report["quality"], report["nodes"]
        cells = [
            *(name, run.name, f"{nodes:,}", str(report.get("parts", {}).get("number", 1))),
            *(f"{run.seconds:.1f}", gain),
            f"{1e6 * run.cpu / nodes:.1f}",
            *("" if one is None else f"{run.cpu / one.cpu:.2f}", *memory(run)),
            f"{quality['mean']:.4f} / {quality['p01']:.3f}",
            "" if run is one else f"{q['beside'][0]:.4f} / {q['beside'][1]:.3f}",
            "" if run is one else f"{q['away'][0]:.4f} / {q['away'][1]:.3f}",
        ]
        rows.append(f"| {' | '.join(cells)} |")
    return rows


def memory(run: Run) -> tuple[str, str, str]:
    """Peak memory of the first process, of its largest worker, and of all at once."""
    return f"{run.main_mb:.0f}", f"{run.worker_mb:.0f}" if run.worker_mb else "", f"{run.all_mb:.0f}"


HEAD = (
    "| case | how | nodes | parts | wall s | speed-up | µs per node | / one piece | main MB | worker MB | all MB "
    "| mean q, 1 % | beside | away |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)


def main() -> None:
    """Measure, print, and write the table."""
    parser = argparse.ArgumentParser("python -m benchmarks.large", description=__doc__)
    parser.add_argument("--nodes", nargs="+", type=float, default=[1e5, 1e6], help="about [%(default)s]")
    parser.add_argument("--coast", nargs="*", type=float, default=[1e5], help="the same of the coast [%(default)s]")
    parser.add_argument("--whole", type=float, default=2e6, help="most nodes of what is run in all ways [%(default)s]")
    parser.add_argument("--turns", type=int, default=3, help="of one worker and two [%(default)s]")
    parser.add_argument("-o", "--output", type=Path, help="page with the table")
    options = parser.parse_args()
    rows = list[str]()
    with TemporaryDirectory() as place:
        for name, nodes in [*(("Example 3", n) for n in options.nodes), *(("coast", n) for n in options.coast)]:
            parts = max(enough_parts(nodes), LEAST_PARTS)
            path, part = (written(name, size, Path(place)) for size in (nodes, nodes / parts))
            fresh = table(name, path, part, parts, options.turns, nodes <= options.whole)
            print("\n".join(fresh), flush=True)
            rows += fresh
    text = f"{HEAD}\n" + "\n".join(rows) + f"\n\nMeasured on {machine()}.\n"
    print(text)
    if options.output:
        page = options.output.read_text(encoding="utf-8")
        before, rest = page.split(BEGIN)
        options.output.write_text(f"{before}{BEGIN}\n{text}{END}{rest.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()
