"""The command line as a user meets it: its streams, files and exit codes."""

import json
import os
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
from commands import command
from commands import within as bubblemesh
from paths import ROOT

from bubblemesh import __version__
from bubblemesh.kernels.library import engine
from bubblemesh.process import watchdog

CONFIGS = ROOT / "configs"
QUICKSTART = CONFIGS / "quickstart.yaml"
COARSE = ["--set", "parameters.h=0.2", "--set", "schedule.iterations=30", "--set", "schedule.rounds=2"]
SQUARE = """\
domain: {outer: {rectangle: [0, 0, 1, 1], label: wall}}
spacing: 0.25
schedule: {iterations: 20, rounds: 2}
"""
SET_OF_FILES = ["plate.labels.json", "plate.msh", "plate.report.json", "plate.vtu"]


def separately(*arguments, folder, stdin=None):
    """Run the command in ``folder`` as a process of its own and return that, its streams as bytes."""
    environment = {**os.environ, "COLUMNS": "200"}
    return subprocess.run(
        [sys.executable, "-m", "bubblemesh", *map(str, arguments)],
        cwd=folder,
        input=stdin,
        capture_output=True,
        env=environment,
        timeout=120,
    )


def failed(process, exit_code):
    """The message of a process that has to have failed with the code, without traceback, or output but as JSON."""
    message = process.stderr.decode()
    assert process.returncode == exit_code, message
    assert process.stdout == b"" or json.loads(process.stdout)["error"] in message
    assert "Traceback" not in message
    return message


def names(folder):
    return sorted(path.name for path in Path(folder).iterdir())


@pytest.fixture
def square(tmp_path):
    path = tmp_path / "square.yaml"
    path.write_text(SQUARE)
    return path


def test_run_writes_the_whole_set_of_files_and_tells_each_round_in_plain_lines(tmp_path):
    process = separately("run", QUICKSTART, "-o", "out", *COARSE, folder=tmp_path)
    assert process.returncode == 0, process.stderr
    assert process.stdout == b""
    assert names(tmp_path / "out") == SET_OF_FILES
    report = json.loads((tmp_path / "out/plate.report.json").read_text())
    assert sorted(report["files"]) == SET_OF_FILES
    lines = process.stderr.decode().splitlines()
    assert lines[0].split()[:4] == ["round", "nodes", "deleted", "inserted"]
    for row, line in zip(report["rounds"], lines[1:], strict=False):
        assert line.split()[:4] == [str(row[key]) for key in ("round", "nodes_after", "deleted", "inserted")]
    assert "\x1b" not in process.stderr.decode()
    assert any(line.startswith("quality q") for line in lines)


def test_the_files_go_to_the_folder_that_the_case_names_beside_it(tmp_path):
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases/square.yaml").write_text(SQUARE + "output: {directory: meshes, formats: [vtk]}\n")
    process = bubblemesh("run", "cases/square.yaml", "-q", folder=tmp_path)
    assert process.returncode == 0, process.stderr
    assert process.stderr == b""
    assert names(tmp_path / "cases/meshes") == ["square.labels.json", "square.report.json", "square.vtk"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "name", "start"),
    [
        (["-o", "a.inp"], "a.inp", b"*HEADING"),
        (["-o", "a.mesh"], "a.mesh", b"MeshVersionFormatted 2"),
        (["-o", "a.nodes.csv"], "a.nodes.csv", b"x,y,boundary,label,nx,ny\n"),
        (["-o", "a.msh", "--format", "msh-ascii"], "a.msh", b"$MeshFormat\n2.2 0 8"),
        (["-o", "a.msh", "--for", "openfoam"], "a.msh", b"$MeshFormat\n2.2 0 8"),
        (["-o", "A.MSH", "--for", "openfoam"], "A.MSH", b"$MeshFormat\n2.2 0 8"),
        (["--for", "su2"], "square.su2", b"NDIME= 2"),
        (["--set", "output.for=calculix"], "square.inp", b"*HEADING"),
        (["--set", "output.for=calculix", "-o", "a.su2"], "a.su2", b"NDIME= 2"),
        (["--set", "output.formats=[inp-strain]", "-o", "a.inp"], "a.inp", b"*HEADING"),
        (["--set", "output.order=2", "-o", "a.vtu"], "a.vtu", b"<?xml"),
    ],
)
def test_the_format_is_that_of_the_options_the_case_or_the_ending(options, name, start, square, tmp_path):
    process = bubblemesh("run", square, "-q", *options, folder=tmp_path)
    assert (process.returncode, process.stderr) == (0, b"")
    assert (tmp_path / name).read_bytes().startswith(start)
    stem = name.split(".")[0]
    files = json.loads((tmp_path / f"{stem}.report.json").read_text())["files"]
    assert sorted([*files, "square.yaml"]) == names(tmp_path)
    if "output.formats=[inp-strain]" in options:
        assert b"CPE3" in (tmp_path / name).read_bytes()


def test_the_report_tells_the_solver_and_the_order(square, tmp_path):
    process = bubblemesh("run", square, "-q", "--json", "--set", "output={for: calculix, order: 2}", folder=tmp_path)
    report = json.loads(process.stdout)
    resolved = {"formats": ["inp"], "for": "calculix", "order": 2, "report": False}
    assert report["parameters"]["output"] == resolved
    assert b"CPS6" in (tmp_path / "square.inp").read_bytes()


@pytest.mark.parametrize(
    ("options", "formats"),
    [(["--format", "vtk", "--format", "pos"], ["vtk", "pos"]), (["--for", "su2"], ["su2"]), ([], ["msh", "vtu"])],
)
def test_the_report_tells_the_formats_that_options_ask_for(options, formats, square, tmp_path):
    bubblemesh("run", square, "-q", "-o", "out/", *options, folder=tmp_path)
    report = json.loads((tmp_path / "out" / "square.report.json").read_text())
    dry = json.loads(bubblemesh("run", square, "-q", "--json", "--dry-run", *options, folder=tmp_path).stdout)
    for told in (report, dry):
        assert told["parameters"]["output"]["formats"] == formats
        assert "for" not in told["parameters"]["output"]


@pytest.mark.long
@pytest.mark.parametrize("ending", ["msh", "vtu", "vtk", "xdmf"])
def test_the_mesh_alone_goes_to_the_standard_output(ending, square, tmp_path):
    process = bubblemesh("run", square, "-o", "-", "--format", ending, folder=tmp_path)
    assert process.returncode == 0, process.stderr
    assert names(tmp_path) == ["square.yaml"]
    piped = tmp_path / f"piped.{ending}"
    piped.write_bytes(process.stdout)
    bubblemesh("run", square, "-o", f"filed.{ending}", "-q", folder=tmp_path)
    kind = "gmsh" if ending == "msh" else None
    a, b = (meshio.read(tmp_path / f"{name}.{ending}", file_format=kind) for name in ("piped", "filed"))
    assert np.array_equal(a.points, b.points)
    assert np.array_equal(a.get_cells_type("triangle"), b.get_cells_type("triangle"))


@pytest.mark.long
def test_the_quickstart_is_piped_as_vtu(tmp_path):
    process = separately("run", QUICKSTART, "-o", "-", "--format", "vtu", *COARSE, folder=tmp_path)
    (tmp_path / "plate.vtu").write_bytes(process.stdout)
    assert len(meshio.read(tmp_path / "plate.vtu").get_cells_type("triangle")) > 20


@pytest.mark.long
def test_the_case_comes_from_the_standard_input(tmp_path):
    process = separately("run", "-", "-o", "a.msh", folder=tmp_path, stdin=SQUARE.encode())
    assert process.returncode == 0, process.stderr
    assert names(tmp_path) == ["a.msh", "a.report.json"]


@pytest.mark.long
def test_json_puts_the_report_and_nothing_else_on_the_standard_output(square, tmp_path):
    process = separately("run", square, "--json", "--seed", "3", "-o", "out", folder=tmp_path)
    report = json.loads(process.stdout)
    assert report == json.loads((tmp_path / "out/square.report.json").read_text())
    assert report["seed"] == report["parameters"]["packing"]["seed"] == 3


@pytest.mark.long
def test_the_same_case_and_seed_give_the_same_bytes_and_another_seed_does_not(square, tmp_path):
    for folder, seed in (("a", 1), ("b", 1), ("c", 2)):
        separately("run", square, "-q", "-o", folder, "--seed", seed, folder=tmp_path)
    a, b, c = ({name: (tmp_path / x / name).read_bytes() for name in names(tmp_path / x)} for x in "abc")
    del a["square.report.json"], b["square.report.json"]
    assert a == b
    assert a["square.msh"] != c["square.msh"]


@pytest.mark.parametrize("output", ["out", "out/square.vtu"])
def test_history_has_a_row_for_each_round_and_each_step(output, square, tmp_path):
    process = bubblemesh("run", square, "--history", "--json", "-q", "-o", output, folder=tmp_path)
    report = json.loads(process.stdout)
    assert {"square.rounds.csv", "square.history.csv"} <= set(report["files"]) == set(names(tmp_path / "out"))
    head, *rows = (line.split(",") for line in (tmp_path / "out/square.rounds.csv").read_text().splitlines())
    assert [dict(zip(head, map(float, row), strict=True)) for row in rows] == report["rounds"]
    head, *rows = (line.split(",") for line in (tmp_path / "out/square.history.csv").read_text().splitlines())
    assert head == ["step", "round", "mean_speed"]
    assert [int(step) for step, _, _ in rows] == list(range(1, len(rows) + 1))
    for row in report["rounds"]:
        speeds = [float(speed) for _, number, speed in rows if int(number) == row["round"]]
        assert len(speeds) == row["iterations"]
        assert speeds[-1] == row["mean_speed"]


@pytest.mark.parametrize("command", [["check"], ["run", "--dry-run"]])
def test_check_and_dry_run_estimate_and_write_nothing(command, tmp_path):
    process = bubblemesh(*command, QUICKSTART, folder=tmp_path)
    assert process.returncode == 0
    assert "about 490" in process.stdout.decode()
    assert process.stderr == b""
    assert names(tmp_path) == []
    process = bubblemesh(*command, QUICKSTART, "--json", folder=tmp_path)
    assert "about 490" in process.stderr.decode()
    estimate = json.loads(process.stdout)
    assert estimate["ideal_nodes"] == pytest.approx(490, rel=0.01)
    assert estimate["labels"] == ["bottom", "right", "top", "left", "hole"]


def test_quality_gives_the_figures_of_the_report_for_a_written_mesh(square, tmp_path):
    formats = ("--format", "msh", "--format", "vtu", "--format", "xdmf")
    report = json.loads(bubblemesh("run", square, "--json", "-q", "-o", ".", *formats, folder=tmp_path).stdout)
    for name in ("square.msh", "square.vtu", "square.xdmf"):
        figures = json.loads(bubblemesh("quality", name, "--spacing", "0.25", "--json", folder=tmp_path).stdout)
        del figures["quality"]["obtuse_fraction"]  # which a run does not tell
        for key in ("nodes", "triangles", "quality", "spacing", "area"):
            assert figures[key] == report[key], (name, key)
    process = bubblemesh("quality", "square.vtu", folder=tmp_path)
    assert b"least" in process.stdout
    assert process.stderr == b""
    message = failed(bubblemesh("quality", "square.vtu", "--spacing", "distance('wall')", folder=tmp_path), 2)
    assert "--spacing: distance(...) is measured from the boundary of a domain, and there is none here" in message


@pytest.mark.long
def test_init_writes_a_case_that_runs_and_keeps_what_is_there(tmp_path):
    assert separately("init", folder=tmp_path).returncode == 0
    assert separately("check", "case.yaml", folder=tmp_path).returncode == 0
    text = (tmp_path / "case.yaml").read_text()
    assert "case.yaml" in failed(separately("init", folder=tmp_path), 5)
    assert (tmp_path / "case.yaml").read_text() == text
    assert separately("init", "-", folder=tmp_path).stdout.decode() == text


def test_schema_is_json_that_knows_the_keys(tmp_path):
    schema = json.loads(bubblemesh("schema", folder=tmp_path).stdout)
    assert {"domain", "spacing", "method", "packing"} <= set(schema["properties"])
    assert "fnpbs" in schema["properties"]["method"]["enum"]
    packing = schema["properties"]["packing"]
    w2, motion = packing["properties"]["w2"], packing["properties"]["motion"]
    assert "rhombi" in w2.pop("description")
    assert w2 == {"exclusiveMinimum": 0, "maximum": 2, "type": "number"}
    assert "`euler`: Predictor-corrector" in motion.pop("description")
    assert motion == {"enum": ["euler", "runge-kutta", "semi-implicit"]}
    assert packing["additionalProperties"] is False


def test_help_and_version(tmp_path):
    assert b"run" in separately("--help", folder=tmp_path).stdout
    told = separately("--version", folder=tmp_path).stdout.decode()
    assert told == f"{__version__} (kernels: {engine()})\n"


@pytest.mark.parametrize(
    ("arguments", "exit_code", "part"),
    [
        (["mesh", "square.yaml"], 2, "'mesh'. Did you mean 'run'?"),
        (["square.yaml"], 2, "Did you mean 'bubblemesh run square.yaml'?"),
        (["run"], 2, "CASE"),
        (["run", "missing.yaml"], 5, "missing.yaml"),
        (["run", ""], 5, "error: the case file cannot be read: its name is empty"),
        (["check", ""], 5, "error: the case file cannot be read: its name is empty"),
        (["batch", ""], 5, "error: the name of a case file or folder is empty"),
        (["run", "square.yaml", "-o", "mesh.stl"], 2, ".stl"),
        (["run", "square.yaml", "-o", "mesh.msh", "--format", "vtu"], 2, "--format"),
        (["run", "square.yaml", "--format", "stl"], 2, "stl"),
        (["run", "square.yaml", "--for", "ansys"], 2, "--for: unknown solver 'ansys'; known: fenicsx"),
        (["run", "square.yaml", "--for", "su2", "--format", "su2"], 2, "--for exclude each other"),
        (["run", "square.yaml", "--for", "su2", "-o", "mesh.inp"], 2, "asks for inp, --format or --for asks for su2"),
        (["run", "square.yaml", "-o", "mesh.su2", "--set", "output.order=2"], 2, "su2 has no form for"),
        (["run", "square.yaml", "--set", "output.for=openfoam", "--set", "output.order=2"], 2, "openfoam has no form"),
        (["run", "square.yaml", "-o", "-", "--json"], 2, "--json"),
        (["run", "square.yaml", "-o", "-", "--format", "pvtu"], 2, "has a file for each part, and -o - is one file"),
        (["run", "square.yaml", "-o", "-", "--history"], 2, "--history"),
        (["run", "square.yaml", "--set", "spacing"], 2, "--set"),
        (["run", "square.yaml", "--set", "packing.w2=-1"], 2, "packing.w2"),
        (["quality", "square.yaml"], 5, "square.yaml"),
        (["quality", "missing.vtu"], 5, "missing.vtu"),
    ],
)
def test_a_bad_option_ends_with_its_exit_code_and_a_message_that_names_it(arguments, exit_code, part, square, tmp_path):
    assert part in failed(bubblemesh(*arguments, folder=tmp_path), exit_code)
    assert names(tmp_path) == ["square.yaml"]
    assert square.read_text() == SQUARE


def test_the_case_file_is_never_overwritten(tmp_path):
    (tmp_path / "a.vtk").write_text(SQUARE)
    assert "a.vtk" in failed(bubblemesh("run", "a.vtk", "-o", "a.vtk", folder=tmp_path), 5)
    assert (tmp_path / "a.vtk").read_text() == SQUARE


@pytest.mark.parametrize(("key", "value"), [("quality_mean", 1), ("valence_max", 5)])
def test_a_missed_requirement_is_told_after_the_mesh_is_written(key, value, square, tmp_path):
    process = bubblemesh("run", square, "-q", "--set", f"require.{key}={value}", "-o", "out", folder=tmp_path)
    assert key in failed(process, 4)
    assert "square.msh" in names(tmp_path / "out")


def test_a_time_limit_ends_with_6_after_the_mesh_is_written(square, tmp_path, monkeypatch):
    for grace in ("GRACE", "SHORT_GRACE"):  # that all is over in time is not what is tested here
        monkeypatch.setattr(watchdog, grace, 60.0)
    ended = bubblemesh("run", square, "-o", "out", "--time-limit", "1e-6", folder=tmp_path)
    assert ended.returncode == 6
    assert b"the time limit of 1e-06 s" in ended.stderr
    report = json.loads((tmp_path / "out/square.report.json").read_text())
    assert not report["finished"]
    assert "square.msh" in report["files"]
    plenty = bubblemesh("run", square, "-o", "out", "--time-limit", "1000", folder=tmp_path)
    assert plenty.returncode == 0
    assert json.loads((tmp_path / "out/square.report.json").read_text())["finished"]


def test_warnings_are_shown_and_reported(square, tmp_path):
    process = bubblemesh("run", square, "-q", "--set", "spacing=9", "--json", folder=tmp_path)
    report = json.loads(process.stdout)
    assert report["warnings"]
    for warning in report["warnings"]:
        assert f"warning: {warning}" in process.stderr.decode()


@pytest.mark.long
def test_a_reader_that_goes_away_ends_the_command_without_a_traceback(square, tmp_path):
    command = f"{sys.executable} -m bubblemesh run {square} -q -o - --format vtu --set spacing=0.01"
    command += " --set schedule.iterations=1 --set schedule.rounds=1"
    process = subprocess.run(
        ["bash", "-c", f"{command} | true; exit ${{PIPESTATUS[0]}}"], capture_output=True, cwd=tmp_path, timeout=120
    )
    assert process.returncode == 5
    assert b"Traceback" not in process.stderr


@pytest.mark.long
@pytest.mark.parametrize(
    "arguments", [["run", "square.yaml", "--json", "-q"], ["schema"], ["init", "-"], ["--version"]]
)
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
def test_a_full_disk_behind_the_standard_output_is_a_file_error(arguments, square, tmp_path):
    with Path("/dev/full").open("wb") as full:
        process = subprocess.run(
            [sys.executable, "-m", "bubblemesh", *arguments],
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            timeout=60,
        )
    assert process.returncode == 5
    assert b"No space left" in process.stderr
    assert b"Traceback" not in process.stderr


def test_no_companion_of_the_mesh_overwrites_the_case_file(tmp_path):
    (tmp_path / "p.report.json").write_text(SQUARE)
    assert "p.report.json" in failed(bubblemesh("run", "p.report.json", "--set", "name=p", folder=tmp_path), 5)
    assert (tmp_path / "p.report.json").read_text() == SQUARE


def test_errors_of_the_case_name_its_file(square, tmp_path):
    square.write_text(SQUARE.replace("[0, 0, 1, 1]", "[0, 0, 1, 0]"))
    assert "square.yaml:1: domain: the outer ring" in failed(bubblemesh("run", "square.yaml", folder=tmp_path), 3)
    square.write_text(SQUARE.replace("0.25", "x - 0.5"))
    assert "square.yaml:2: spacing: is " in failed(bubblemesh("check", "square.yaml", folder=tmp_path), 2)


LATE = """name: late
domain:
  outer: {rectangle: [0, 0, 2, 1]}
  regions:
    - {name: core, ring: {rectangle: [1, 0, 2, 1]}}
spacing:
  value: 0.2
  near:
    - {point: [0, 0], size: 0.1}
    - size: 0.1
      label: outer
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("label: outer", "label: rim", "late.yaml:11: spacing.near.1.label: unknown label 'rim'"),
        ("0.2\n", "distance('rim')\n", "late.yaml:7: spacing.value: column 1: unknown label 'rim'"),
        ("0.2\n", "x - 1\n", "late.yaml:7: spacing.value: is -1 at (0, 0)"),
        ("[1, 0, 2, 1]}", "[1, 0, 2, 1]}, spacing: x - 2", "late.yaml:5: domain.regions.0.spacing: is -"),
        ("  near", "  regions: {\n    rim: 1}\n  near", "late.yaml:9: spacing.regions.rim: unknown region 'rim'"),
        ("value: 0.2", "field:\n    - file: no.vtu", "late.yaml:7: spacing.field: "),
        ("value: 0.2", "value: 0.2\n  minimum: 0.1\n  nodes: 9999", "late.yaml:9: spacing.nodes: 9999 nodes are more"),
    ],
)
def test_what_only_the_geometry_shows_to_be_wrong_has_its_line_too(old, new, message, tmp_path):
    (tmp_path / "late.yaml").write_text(LATE.replace(old, new))
    code, _, told = command("check", tmp_path / "late.yaml")
    assert code in (2, 5)
    assert f"{tmp_path}/{message}" in told


@pytest.mark.usefixtures("workers_in_threads")
def test_the_option_that_is_wrong_is_named_and_so_is_the_base(tmp_path):
    (tmp_path / "late.yaml").write_text(LATE)
    told = command("check", tmp_path / "late.yaml", "--set", "spacing.labels.rim=1")[2]
    assert told.startswith("error: --set spacing.labels.rim: spacing.labels.rim: unknown label 'rim'")
    (tmp_path / "base.yaml").write_text(LATE.replace("label: outer", "label: rim"))
    (tmp_path / "late.yaml").write_text("base: base.yaml\nname: late\n")
    assert f"{tmp_path}/base.yaml:11: spacing.near.1.label: " in command("check", tmp_path / "late.yaml")[2]
    command("batch", tmp_path / "late.yaml", "-o", tmp_path / "out")
    assert "base.yaml:11: spacing.near.1.label: " in (tmp_path / "out" / "summary.jsonl").read_text()


@pytest.mark.parametrize(
    ("points", "cells", "part"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, 5]], [("triangle", [[0, 1, 2]])], "surface in space"),
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [("triangle", [[0, 1, 2]])], "node 2"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [("triangle", [[0, 1, 7]])], "damaged"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [("line", [[0, 1]])], "no triangles"),
    ],
)
def test_quality_refuses_what_it_cannot_measure(points, cells, part, tmp_path):
    meshio.Mesh(np.array(points, float), cells).write(tmp_path / "mesh.vtk", file_format="vtk42")
    assert part in failed(bubblemesh("quality", "mesh.vtk", folder=tmp_path), 5)


def test_quality_tells_what_it_leaves_out_and_counts_used_nodes_only(tmp_path):
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [9, 9, 0]], float)
    cells = [("triangle", [[0, 1, 2]]), ("tetra", [[0, 1, 3, 2]])]
    meshio.Mesh(points, cells).write(tmp_path / "mesh.vtk", file_format="vtk42")
    process = bubblemesh("quality", "mesh.vtk", "--json", folder=tmp_path)
    assert "tetra" in process.stderr.decode()
    assert json.loads(process.stdout)["nodes"] == 3


@pytest.mark.parametrize(
    ("method", "setting"),
    [("accelerated", "c0=50"), ("accelerated", "c_in=1"), ("accelerated", "c_odd=100"), ("multilevel", "c=1e6")],
)
def test_a_large_viscosity_does_no_harm(method, setting, square, tmp_path):
    arguments = ["--set", f"method={method}", "--set", f"schedule.{setting}"]
    assert bubblemesh("run", square, "-q", *arguments, folder=tmp_path).returncode == 0


@pytest.mark.long
@pytest.mark.parametrize("settings", [["packing.dt=1"], ["packing.k0=100"], ["packing.force=plain", "packing.dt=0.5"]])
@pytest.mark.parametrize("method", ["accelerated", "multilevel"])
def test_a_force_that_the_time_step_does_not_resolve_ends_in_a_mesh_all_the_same(method, settings, square, tmp_path):
    settings = [f"method={method}", *settings, "spacing=0.1"]
    arguments = [word for setting in settings for word in ("--set", setting)]
    assert bubblemesh("run", square, "-q", *arguments, folder=tmp_path).returncode == 0


def test_an_absurd_time_step_is_named(square, tmp_path):
    assert "packing.dt" in failed(bubblemesh("run", square, "--set", "packing.dt=5", folder=tmp_path), 2)


@pytest.mark.parametrize(("order", "text"), [(1, "nodes"), (2, "at corners")])
def test_the_nodes_that_are_counted_are_those_at_corners(order, text, square, tmp_path):
    said = bubblemesh("run", square, "--set", f"output.order={order}", folder=tmp_path).stderr.decode()
    assert text in said
    assert ("at corners" in said) == (order == 2)
