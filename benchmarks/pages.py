"""Pages of reports in a real browser.

``python -m benchmarks.pages`` prints how long pages of growing meshes take to open in a headless Chromium;
``python -m benchmarks.pages figures`` makes the pictures of docs/reports.md anew. Both need selenium, chromium and
chromedriver.
"""

import argparse
import base64
import shutil
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np
from selenium import webdriver
from selenium.webdriver.support.ui import WebDriverWait

from benchmarks.light import lighten
from bubblemesh.case import load_case
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import Measures, mesh_figures
from bubblemesh.pages.index import index_page
from bubblemesh.pages.report import report_page
from bubblemesh.pictures.plots import PlotOptions, draw_mesh, small_png
from bubblemesh.run.pipeline import Result, mesh_case
from bubblemesh.spacing.spacing import Spacing

ROOT = Path(__file__).parent.parent
FIGURES = ROOT / "docs" / "figures"
CELLS = (22, 71, 224, 707)  # along the sides of squares, each cell two triangles
REPEATS = 3
WRITTEN = datetime(2025, 1, 1, tzinfo=UTC)
# Notes when the mesh is drawn for the first time, in milliseconds since the page was asked for.
WATCH = """
new MutationObserver(() => {
  if (!window.drawnAt && document.querySelector("canvas[data-drawn]")) window.drawnAt = performance.now();
}).observe(document, { subtree: true, attributes: true, attributeFilter: ["data-drawn"], childList: true });
"""


def square(cells: int) -> Mesh:
    """The unit square in cells of two triangles, whose inner nodes are moved by chance."""
    i, j = np.meshgrid(np.arange(cells + 1), np.arange(cells + 1), indexing="ij")
    points = np.stack([i, j], axis=-1).reshape(-1, 2).astype(float)
    inner = ((points > 0) & (points < cells)).all(axis=1)
    points[inner] += np.random.default_rng(0).uniform(-0.25, 0.25, (inner.sum(), 2))
    number = np.arange(len(points)).reshape(cells + 1, -1)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    ring = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    facets = np.column_stack([ring, np.roll(ring, -1)])
    labels = np.repeat(np.arange(4), cells)
    order = np.lexsort(triangles.T[::-1])
    return Mesh(points / cells, triangles[order], facets, labels, ("bottom", "right", "top", "left"))


def browser(width: int = 1280, height: int = 900, *, dark: bool = False) -> webdriver.Chrome:
    """A headless browser with a window of some size."""
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"):
        options.add_argument(argument)
    # With both paths given, selenium asks nothing of the network.
    options.binary_location = shutil.which("chromium") or ""
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
    driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
    return driver


def first_drawing(path: Path) -> float:
    """Seconds from asking for a page to its first picture of the mesh."""
    driver = browser()
    try:
        driver.get(path.as_uri())
        wait = WebDriverWait(driver, 120, poll_frequency=0.05)
        return float(wait.until(lambda it: it.execute_script("return window.drawnAt"))) / 1000
    finally:
        driver.quit()


def page_of_square(cells: int, run: Result) -> str:
    """The page of a run, if its mesh were that of a square in cells of two triangles."""
    mesh, d = square(cells), 1 / cells
    measures = Measures(mesh.points, mesh.triangles)
    spacing = Spacing(lambda x, y: np.full(len(x), d))
    report = {**run.report, **mesh_figures(measures, spacing.between), "files": []}
    report |= {"nodes": len(mesh.points), "triangles": len(mesh.triangles), "area": 1.0}
    fields = {"quality": measures.radius_ratios, "target_spacing": np.full(2 * cells**2, d)}
    return report_page(mesh, fields, report, run.speeds, WRITTEN)


def measure() -> None:
    """Print size and times of pages of growing meshes."""
    run = mesh_case(load_case(ROOT / "configs/quickstart.yaml", overrides=["parameters.h=0.2"]))
    print("triangles  megabytes  seconds to make  seconds to open")
    with tempfile.TemporaryDirectory() as folder:
        for cells in CELLS:
            begun = process_time()
            page = page_of_square(cells, run)
            making = process_time() - begun
            path = Path(folder, "page.html")
            path.write_text(page, encoding="utf-8")
            opening = median(first_drawing(path) for _ in range(REPEATS))
            print(f"{2 * cells**2:9,}  {len(page) / 1e6:9.2f}  {making:15.1f}  {opening:15.2f}")


def figures() -> None:
    """Make the pictures of docs/reports.md."""
    results = {
        name: mesh_case(load_case(ROOT / f"configs/{name}.yaml")) for name in ("gallery/composite", "quickstart")
    }
    composite, plate = results["gallery/composite"], results["quickstart"]
    draw_mesh(plate.mesh, FIGURES / "plot-paper.png", PlotOptions(style="paper", dpi=150))
    lighten(FIGURES / "plot-paper.png")
    # Fewer pixels, not fewer colours: these tell the materials.
    picture = small_png(composite.mesh, PlotOptions(color="material", dpi=75))
    (FIGURES / "plot-material.png").write_bytes(picture)
    with tempfile.TemporaryDirectory() as folder:
        report, index = Path(folder, "report.html"), Path(folder, "index.html")
        report.write_text(_page(composite), encoding="utf-8")
        index.write_text(index_page([_row(result) for result in results.values()] + [FAILED]), encoding="utf-8")
        _photograph(report, FIGURES / "report.png", 1180, 1330)
        _photograph(report, FIGURES / "report-dark.png", 390, 780, dark=True)
        _photograph(index, FIGURES / "index.png", 1180, 360)


FAILED = {
    "case": "bracket",
    "exit_code": 3,
    "message": "bracket.yaml: domain: the outer ring crosses itself at (0.4, 1)",
}


def _page(result: Result) -> str:
    files = [f"{result.report['case']}{end}" for end in (".msh", ".vtu", ".report.json", ".html")]
    return report_page(result.mesh, result.fields, {**result.report, "files": files}, result.speeds, WRITTEN)


def _row(result: Result) -> dict[str, object]:
    report = result.report
    figures = {f"quality_{key}": report["quality"][key] for key in ("mean", "p01", "min")}
    figures |= {key: report[key] for key in ("case", "nodes", "triangles", "warnings")}
    spread, seconds = report["spacing"]["std"], report["seconds"]["total"]
    return figures | {"exit_code": 0, "spacing_std": spread, "seconds": seconds, "report": f"{report['case']}.html"}


def _photograph(page: Path, path: Path, width: int, height: int, *, dark: bool = False) -> None:
    driver = browser(width, height, dark=dark)
    try:
        driver.get(page.as_uri())
        if 'id="mesh"' in page.read_text(encoding="utf-8"):
            WebDriverWait(driver, 30).until(lambda it: it.execute_script("return window.drawnAt"))
        if width < 500:
            driver.execute_script("document.getElementById('mesh-title').scrollIntoView()")
        shot = driver.execute_cdp_cmd("Page.captureScreenshot", {})["data"]
    finally:
        driver.quit()
    path.write_bytes(base64.b64decode(shot))
    lighten(path)


if __name__ == "__main__":
    parser = argparse.ArgumentParser("python -m benchmarks.pages", description=__doc__)
    parser.add_argument("what", nargs="?", choices=["figures"], help="make the pictures of docs/reports.md anew")
    figures() if parser.parse_args().what else measure()
