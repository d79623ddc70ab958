"""Pictures of meshes, of this package and of files."""

import base64
import dataclasses
import re
import sys

import matplotlib as mpl
import meshio
import numpy as np
import pytest
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import LogNorm, to_hex
from matplotlib.figure import Figure
from quadrilaterals import mixed
from squares import holed_square
from typer.testing import CliRunner

from bubblemesh.cli import app
from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.read import read_mesh, read_triangles
from bubblemesh.meshfiles.writing import write_file
from bubblemesh.pages.scene import Scene
from bubblemesh.pictures import plots
from bubblemesh.pictures.colouring import QUALITY
from bubblemesh.pictures.plots import MeshData, PlotOptions, draw_mesh, mesh_figure
from bubblemesh.pictures.styles import BARE, INK, PlotOptionError

ENDINGS = ["png", "svg", "pdf"]
MM = 72 / 25.4  # points


@pytest.fixture(scope="module")
def mesh():
    """A mesh with five labels and two regions."""
    plain = holed_square()
    middle = plain.points[plain.triangles].mean(axis=1)[:, 0] > plain.points[:, 0].mean()
    return dataclasses.replace(plain, regions=("west", "east"), triangle_regions=middle.astype(np.int64))


@pytest.fixture(scope="module")
def data(mesh):
    x, y = mesh.points.T
    cells = {"target_spacing": np.linspace(0.2, 0.5, len(mesh.triangles)), "count": np.arange(len(mesh.triangles)) / 7}
    return MeshData(cells, {"height": x - 2 * y, "flow": np.column_stack([x, y, 0 * x])})


def png_size(path):
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    return int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")


def triangles_of(figure):
    (found,) = [artist for artist in figure.axes[0].collections if isinstance(artist, PolyCollection)]
    return found


def test_diagonals_of_quadrilaterals_are_not_drawn():
    mesh = mixed()
    figure = mesh_figure(mesh, PlotOptions(color="quality"))
    drawn = [artist for artist in figure.axes[0].collections if isinstance(artist, PolyCollection)]
    assert len(drawn) == 3
    assert len(drawn[0].get_paths()) == len(mesh.triangles)
    for artist, (nodes, _) in zip(drawn[1:], mesh.cells, strict=True):
        assert len(artist.get_facecolor()) == 0
        corners = [path.vertices[:-1] for path in artist.get_paths()]
        assert np.array_equal(corners, mesh.points[nodes])
    bare = mesh_figure(mesh, PlotOptions(color="quality", edges=False))
    assert len(triangles_of(bare).get_paths()) == len(mesh.triangles)


def lines_of(figure):
    """Colour and number of the lines of each label."""
    found = [artist for artist in figure.axes[0].collections if isinstance(artist, LineCollection)]
    return [(to_hex(lines.get_colors()[0]), len(lines.get_segments())) for lines in found if lines.get_segments()]


def legend_of(figure):
    legend = figure.axes[0].get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def run(*arguments):
    """Exit code and messages of a command."""
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert done.stdout == ""
    return done.exit_code, done.stderr


# Files


@pytest.mark.long
@pytest.mark.parametrize("ending", ENDINGS)
def test_the_same_mesh_gives_the_same_picture(mesh, tmp_path, ending):
    for name in "ab":
        draw_mesh(mesh, tmp_path / "new" / f"{name}.{ending}", PlotOptions(title="a plate", labels=True))
    first, second = sorted((tmp_path / "new").iterdir())
    assert first.read_bytes() == second.read_bytes()


def test_a_png_has_the_shape_of_the_mesh(mesh, tmp_path):
    flat = dataclasses.replace(mesh, points=mesh.points * [1, 0.1])
    draw_mesh(mesh, tmp_path / "square.png", PlotOptions(color="none"))
    draw_mesh(flat, tmp_path / "flat.png", PlotOptions(color="none"))
    width, height = png_size(tmp_path / "square.png")
    assert width > 800
    assert abs(width - height) < 0.15 * width
    width, height = png_size(tmp_path / "flat.png")
    assert width > 3 * height


@pytest.mark.long
@pytest.mark.parametrize("stretch", [(1, 1), (5, 1), (1, 5)])
def test_a_picture_for_paper_is_a_column_wide_and_its_triangles_are_lines(mesh, tmp_path, stretch):
    shaped = dataclasses.replace(mesh, points=mesh.points * stretch)
    draw_mesh(shaped, tmp_path / "a.pdf", PlotOptions(style="paper", title="wide"))
    content = (tmp_path / "a.pdf").read_bytes()
    _, _, width, height = map(float, re.search(rb"/MediaBox \[([^]]*)\]", content)[1].split())
    assert abs(width - 85 * MM) < 0.01
    assert height < 260 * MM
    assert b"STIXGeneral" in content
    assert b"/Subtype /Image" not in content


@pytest.mark.parametrize(("width", "dpi"), [(60, 200), (120, 100)])
def test_width_and_resolution_give_the_number_of_pixels(mesh, tmp_path, width, dpi):
    draw_mesh(mesh, tmp_path / "a.png", PlotOptions(width=width, dpi=dpi))
    assert abs(png_size(tmp_path / "a.png")[0] - width / 25.4 * dpi) <= 1


def test_an_svg_shows_labels_title_and_scale(mesh, tmp_path):
    with mpl.rc_context({"svg.fonttype": "none"}):
        draw_mesh(mesh, tmp_path / "a.svg", PlotOptions(title="a $plate$"))
    text = (tmp_path / "a.svg").read_text()
    for word in (*mesh.labels, "a $plate$", "radius ratio"):
        assert word in text


@pytest.mark.long
@pytest.mark.parametrize("ending", ["svg", "pdf"])
def test_only_the_triangles_of_a_large_mesh_become_a_bitmap(mesh, tmp_path, ending):
    mark = {"svg": b"<image", "pdf": b"/Subtype /Image"}[ending]
    draw_mesh(mesh, tmp_path / f"small.{ending}", PlotOptions(color="none"))
    draw_mesh(holed_square(60), tmp_path / f"large.{ending}", PlotOptions(color="none"))
    assert mark not in (tmp_path / f"small.{ending}").read_bytes()
    assert mark in (tmp_path / f"large.{ending}").read_bytes()


def test_a_picture_of_an_unknown_kind(mesh, tmp_path):
    with pytest.raises(CaseError, match=r"\.png, \.svg, \.pdf"):
        draw_mesh(mesh, tmp_path / "a.jpg")


def test_a_picture_that_cannot_be_written(mesh, tmp_path):
    (tmp_path / "a.png").mkdir()
    with pytest.raises(FileError, match=r"a\.png"):
        draw_mesh(mesh, tmp_path / "a.png")
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_pictures_leave_no_global_state(mesh, tmp_path):
    before = dict(mpl.rcParams)
    draw_mesh(mesh, tmp_path / "a.png", PlotOptions(style="paper"))
    assert dict(mpl.rcParams) == before
    assert "matplotlib.pyplot" not in sys.modules or not sys.modules["matplotlib.pyplot"].get_fignums()


# What is drawn


def test_every_triangle_is_drawn_where_it_is_with_its_quality(mesh):
    drawn = triangles_of(mesh_figure(mesh))
    corners = np.array([path.vertices[:3] for path in drawn.get_paths()])
    assert np.array_equal(corners, mesh.points[mesh.triangles])
    assert np.array_equal(drawn.get_array(), radius_ratios(mesh.points, mesh.triangles))
    assert drawn.get_clim() == (0.8, 1.0)


def test_a_triangle_of_second_order_is_drawn_by_its_corners(mesh):
    curved, _ = mesh.second_order()
    drawn = triangles_of(mesh_figure(curved, PlotOptions(nodes=True)))
    corners = np.array([path.vertices[:3] for path in drawn.get_paths()])
    assert np.array_equal(corners, mesh.points[mesh.triangles])


def test_spacing_is_the_mean_edge_length_over_the_target_spacing(mesh, data):
    drawn = triangles_of(mesh_figure(mesh, PlotOptions(color="spacing"), data))
    for triangle in (0, 37):
        corners = mesh.points[mesh.triangles[triangle]]
        lengths = [np.linalg.norm(corners[k] - corners[k - 1]) for k in range(3)]
        expected = np.mean(lengths) / data.cells["target_spacing"][triangle]
        assert drawn.get_array()[triangle] == pytest.approx(expected, rel=1e-12)
    low, high = drawn.get_clim()
    assert low == pytest.approx(2 - high)


@pytest.mark.parametrize(("name", "title"), [("count", "count"), ("height", "height"), ("flow", "|flow|")])
def test_fields_of_triangles_nodes_and_vectors(mesh, data, name, title):
    figure = mesh_figure(mesh, PlotOptions(color=name), data)
    x, y = mesh.points.T
    at_nodes = {"height": x - 2 * y, "flow": np.hypot(x, y)}
    expected = data.cells[name] if name == "count" else at_nodes[name][mesh.triangles].mean(axis=1)
    assert np.allclose(triangles_of(figure).get_array(), expected, rtol=1e-14)
    assert figure.axes[1].get_xlabel().startswith(title) or figure.axes[1].get_ylabel().startswith(title)
    assert triangles_of(figure).get_clim() == (expected.min(), expected.max())


def test_values_that_are_no_numbers_have_no_colour(mesh, data):
    values = np.array(data.cells["count"])
    values[::2] = np.nan
    drawn = triangles_of(mesh_figure(mesh, PlotOptions(color="count"), MeshData({"count": values})))
    assert drawn.get_array().mask.sum() == np.isnan(values).sum()
    with pytest.raises(CaseError, match="count has no finite value"):
        mesh_figure(mesh, PlotOptions(color="count"), MeshData({"count": values * np.nan}))


def test_regions_have_a_colour_and_a_name_each(mesh):
    figure = mesh_figure(mesh, PlotOptions(color="material", labels=False))
    assert np.array_equal(triangles_of(figure).get_array(), mesh.triangle_regions)
    assert legend_of(figure) == ["west", "east"]
    assert len(figure.axes) == 1  # no colour bar


def test_each_label_has_its_edges_in_a_colour_of_its_own(mesh):
    figure = mesh_figure(mesh)
    lines = lines_of(figure)
    assert len({color for color, _ in lines}) == 5
    assert [count for _, count in lines] == np.bincount(mesh.facet_labels).tolist()
    assert legend_of(figure) == list(mesh.labels)
    assert lines_of(mesh_figure(mesh, PlotOptions(labels=False))) == [(INK, len(mesh.facets))]


def test_the_boundary_of_a_mesh_without_labels_is_drawn_all_the_same(mesh):
    bare = dataclasses.replace(mesh, facets=np.zeros((0, 2), np.int64), facet_labels=[], facet_middles=[], labels=())
    assert lines_of(mesh_figure(bare)) == [(INK, len(mesh.facets))]
    assert legend_of(mesh_figure(bare)) == []


def test_many_labels_are_told_apart_only_where_asked_for(mesh):
    labels = tuple(f"side{i}" for i in range(30))
    many = dataclasses.replace(mesh, labels=labels, facet_labels=np.arange(len(mesh.facets)) % 30)
    assert legend_of(mesh_figure(many)) == []
    legend = legend_of(mesh_figure(many, PlotOptions(color="label")))
    assert legend == [*labels[:23], "and 7 more"]
    assert len(lines_of(mesh_figure(many, PlotOptions(color="label")))) == 30


def test_the_colour_of_the_first_region_is_that_of_no_other(mesh):
    regions = tuple(f"r{i}" for i in range(60))
    many = dataclasses.replace(mesh, regions=regions, triangle_regions=np.arange(len(mesh.triangles)) % 60)
    figure = mesh_figure(many, PlotOptions(color="material"))
    colours = list(map(to_hex, figure.axes[0].collections[0].cmap.colors))
    assert len(colours) == 60
    assert len(set(colours)) == len(set(colours[:24])) == 24
    assert colours.count(colours[0]) == 1


def test_edges_of_many_triangles_are_seen_in_a_view(mesh, monkeypatch):
    def width(**options):
        drawn = mesh_figure(mesh, PlotOptions(color="quality", **options)).axes[0].collections[0]
        return drawn.get_linewidth()[0]

    monkeypatch.setattr(plots, "MANY", 3)
    x0, y0 = mesh.points.min(axis=0).tolist()
    seen = width(view=(x0, y0, x0 + 1, y0 + 1))
    assert seen == width(view=(x0, y0, x0 + 1, y0 + 1), edges=True) != width(edges=False)


def test_a_legend_fits_into_the_width(mesh):
    labels = tuple(f"a rather long name of a side, the {i}th" for i in range(5))
    figure = mesh_figure(dataclasses.replace(mesh, labels=labels), PlotOptions(style="paper", labels=True))
    figure.draw_without_rendering()
    assert figure.axes[0].get_legend().get_window_extent().width < figure.bbox.width
    # The mesh keeps nearly all of the width.
    assert figure.axes[0].get_window_extent().width > 0.95 * figure.bbox.width


@pytest.mark.long
@pytest.mark.parametrize("label", ["_hidden", r"$\wrong{$", "a & <b>", "größe 漢"])
def test_any_label_can_be_drawn(tmp_path, label):
    draw_mesh(holed_square(labels=(label, "b", "c", "d", "e")), tmp_path / "a.svg", PlotOptions(title=label))
    assert (tmp_path / "a.svg").stat().st_size > 1000


def test_nodes_are_drawn_where_asked_for(mesh):
    def dots(**options):
        return [line for line in mesh_figure(mesh, PlotOptions(**options)).axes[0].lines if line.get_marker() == "o"]

    assert dots() == []
    (drawn,) = dots(nodes=True)
    assert {tuple(point) for point in drawn.get_xydata()} == {tuple(point) for point in mesh.points}


def test_edges_that_would_only_darken_the_picture_are_left_out(mesh):
    fine = holed_square(60)

    def edge_colors(**options):
        return {to_hex(color) for color in triangles_of(mesh_figure(fine, PlotOptions(**options))).get_edgecolor()}

    assert edge_colors(color="none") == {INK}
    assert edge_colors(color="none", dpi=12) == {BARE}
    assert edge_colors(color="none", dpi=12, edges=True) == {INK}
    assert edge_colors(color="none", edges=False) == {BARE}
    drawn = triangles_of(mesh_figure(fine, PlotOptions(dpi=12)))
    drawn.update_scalarmappable()
    assert np.array_equal(drawn.get_edgecolor(), drawn.get_facecolor())


def test_a_view_shows_its_part_of_the_mesh_only(mesh):
    x0, y0 = mesh.points.min(axis=0)
    view = (x0 - 0.1, y0 - 0.1, x0 + 0.7, y0 + 0.4)
    figure = mesh_figure(mesh, PlotOptions(view=view))
    corners = mesh.points[mesh.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    reaching = [i for i in range(len(corners)) if (low[i] < view[2:]).all() and (high[i] > view[:2]).all()]
    assert 0 < len(reaching) < len(corners) / 4
    assert np.array_equal([path.vertices[:3] for path in triangles_of(figure).get_paths()], corners[reaching])
    assert figure.axes[0].get_xlim() == (view[0], view[2])
    assert figure.axes[0].get_ylim() == (view[1], view[3])
    assert legend_of(figure) == ["bottom", "left"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"color": "qualty"},
            "unknown quantity 'qualty'; did you mean 'quality'.* known: .*count, height, flow",
        ),
        ({"color": "spacing"}, "no target_spacing"),
        ({"colormap": "virdis"}, "unknown colour map 'virdis'; did you mean 'viridis'"),
        ({"colormap": "nothere"}, r"unknown colour map 'nothere'; known: quality, \w+, .* and \d+ more$"),
        ({"style": "papr"}, "did you mean 'paper'"),
        ({"color": 3}, r"color: must be a text \(found 3\)"),
        ({"colormap": 3}, r"colormap: must be a text \(found 3\)"),
        ({"view": (9, 9, 10, 10)}, r"no triangle is there: the mesh covers \[0.333333, 3.33333\] x \[-3.14159, "),
        ({"view": (1, 0, 0, 1)}, "x0 < x1"),
        ({"view": (0, 0, np.inf, 1)}, "x0 < x1"),
        ({"view": (1, -1, 1, -1 + 1e-300)}, "x0 < x1"),
        ({"view": (1.9, -1.9, 1.9 + 1e-15, -1.9 + 1e-15)}, "sides are too short for numbers as large as 1.9"),
        ({"limits": (1, 1)}, "first less than the second"),
        ({"width": 5}, "width: is 5: it has to be between 10 and 2400"),
        ({"dpi": np.nan}, "dpi: is nan"),
        ({"dpi": 2400, "width": 2000}, "pixels long"),
    ],
)
def test_what_cannot_be_drawn_is_refused(mesh, data, options, message):
    known = MeshData({"count": data.cells["count"]}, data.points)
    with pytest.raises(CaseError, match=message):
        mesh_figure(mesh, PlotOptions(**options), known)


def test_the_error_of_an_option_names_it(mesh):
    with pytest.raises(PlotOptionError) as refused:
        mesh_figure(mesh, PlotOptions(limits=(1, 1)))
    assert (refused.value.option, str(refused.value)[:7]) == ("range", "range: ")


def test_a_mesh_without_labels_regions_or_area(mesh):
    bare = dataclasses.replace(mesh, facets=mesh.facets[:0], facet_labels=[], facet_middles=[], labels=())
    bare = dataclasses.replace(bare, regions=(), triangle_regions=[])
    for color, what in (("label", "no labelled edges"), ("material", "no regions")):
        with pytest.raises(CaseError, match=what):
            mesh_figure(bare, PlotOptions(color=color))
    with pytest.raises(CaseError, match="no area"):
        mesh_figure(dataclasses.replace(mesh, points=mesh.points * [1, 0]))


def test_a_mesh_of_the_programming_interface_is_drawn_with_its_fields(mesh, data, tmp_path):
    figure = mesh.plot(tmp_path / "a.pdf", color="spacing", style="paper", fields=data.cells, edges=False)
    assert (tmp_path / "a.pdf").stat().st_size > 1000
    assert len(triangles_of(figure).get_paths()) == len(mesh.triangles)


# Sizes, coordinates, axes of one's own


def test_many_triangles_are_shown_by_their_size_and_a_part_by_quality(mesh):
    fine = holed_square(80)
    whole = triangles_of(mesh_figure(fine))
    assert len(fine.triangles) >= 10_000
    assert np.ptp(whole.get_array()) < 0.2 * whole.get_array().mean()
    low, high = whole.get_clim()
    assert high / low == pytest.approx(3)
    x0, y0 = fine.points.min(axis=0)
    part = triangles_of(mesh_figure(fine, PlotOptions(view=(x0, y0, x0 + 0.5, y0 + 0.5))))
    assert part.get_clim()[1] == 1
    assert triangles_of(mesh_figure(fine, PlotOptions(color="quality"))).get_clim()[1] == 1


def test_sizes_are_lengths_of_edges_and_a_wide_scale_is_logarithmic():
    side = 0.25
    rows = np.array([(side * (i + j / 2), side * j * np.sqrt(3) / 2) for j in range(2) for i in range(3)])
    triangles = np.array([(0, 1, 3), (1, 4, 3), (1, 2, 4), (2, 5, 4)])
    facets = np.array([(0, 1), (1, 2), (2, 5), (5, 4), (4, 3), (3, 0)])
    even = Mesh(rows, triangles, facets, np.zeros(6, np.int64), ("rim",))
    assert np.allclose(triangles_of(mesh_figure(even, PlotOptions(color="size"))).get_array(), side)
    plain = holed_square(8)
    uneven = dataclasses.replace(plain, points=np.exp(plain.points * 1.5))
    figure = mesh_figure(uneven, PlotOptions(color="size"))
    assert isinstance(triangles_of(figure).norm, LogNorm)
    assert figure.axes[1].get_xlabel().startswith("edge length")


def test_quality_has_one_scale_in_pictures_of_every_style_and_on_pages(mesh):
    maps = [triangles_of(mesh_figure(mesh, PlotOptions(style=style))).cmap for style in ("screen", "paper")]
    scene = Scene.of(mesh, {"target_spacing": np.ones(len(mesh.triangles))}, 3)
    colors = [colormap(np.linspace(0, 1, 256)) for colormap in (*maps, scene.quality.colormap, QUALITY)]
    assert all(np.array_equal(colors[0], other) for other in colors)
    lightness = colors[0][:, :3] @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness) > 0).all()  # readable without colours


def test_coordinates_stand_beside_the_mesh_unless_left_out(mesh):
    shown, bare = (mesh_figure(mesh, PlotOptions(axes=axes)).axes[0] for axes in (None, False))
    assert (shown.axison, bare.axison) == (True, False)
    assert not mesh_figure(mesh, PlotOptions(style="paper")).axes[0].axison
    far = dataclasses.replace(mesh, points=mesh.points + np.array([448_000, 5_400_000]))
    axes = mesh_figure(far).axes[0]
    axes.figure.canvas.draw()
    told = [text.get_text() for text in axes.get_xticklabels() if text.get_text()]
    assert {"448001", "448002", "448003"} <= set(told)


def test_a_mesh_is_drawn_into_axes_of_ones_own(mesh, tmp_path):
    figure = Figure(figsize=(8, 4))
    left, right = figure.subplots(1, 2)
    assert mesh.plot(ax=left, title="left") is figure
    mesh.plot(ax=right, color="none")
    assert (left.get_title(), right.get_title()) == ("left", "")
    assert len(figure.axes) == 3  # with one colour bar
    with pytest.raises(CaseError, match="path: ax is drawn into"):
        mesh.plot(tmp_path / "a.png", ax=left)


def test_a_notebook_shows_a_small_picture_above_the_words(mesh):
    named = dataclasses.replace(mesh, labels=("<b>", *mesh.labels[1:]))
    text = named._repr_html_()
    picture = base64.b64decode(re.search(r'src="data:image/png;base64,([^"]*)"', text)[1])
    assert picture.startswith(b"\x89PNG")
    assert len(picture) < 60_000
    assert "&lt;b&gt;" in text
    flat = dataclasses.replace(mesh, points=mesh.points * [1, 0])
    assert "<img" not in flat._repr_html_()


@pytest.mark.parametrize(
    ("zoom", "message"),
    [
        ("0,0,1", "give four numbers"),
        ("a,b,c,d", "found 'a,b,c,d'"),
        ("1,0,0,1", "x0 < x1"),
        ("nan,0,1,1", "x0 < x1"),
        ("0,-2,1e308,-1", "at most 1e+70 (found 1e+308)"),
        ("-1e308,-2,1e308,-1", "at most 1e+70"),
    ],
)
def test_a_zoom_that_is_none(zoom, message, mesh, tmp_path):
    write_file(mesh, {}, {}, tmp_path / "a.msh")
    code, text = run("plot", tmp_path / "a.msh", "-o", tmp_path / "a.png", "--zoom", zoom)
    assert code == 2
    assert "--zoom" in text
    assert message in text


def test_zoom_is_view_with_commas(mesh, tmp_path):
    write_file(mesh, {}, {}, tmp_path / "a.msh")
    run("plot", tmp_path / "a.msh", "-o", tmp_path / "a.png", "--zoom", "-1,-1,1.5,1")
    run("plot", tmp_path / "a.msh", "-o", tmp_path / "b.png", "--view", -1, -1, 1.5, 1)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    code, text = run("plot", tmp_path / "a.msh", "--zoom", "0,0,1,1", "--view", 0, 0, 1, 1)
    assert (code, "drop one of them" in text) == (2, True)


@pytest.mark.parametrize(("option", "value"), [("--zoom", ["10,10,20,20"]), ("--view", [10, 10, 20, 20])])
def test_a_part_without_a_triangle_is_told_by_the_option_that_was_given(option, value, mesh, tmp_path):
    write_file(mesh, {}, {}, tmp_path / "a.msh")
    code, text = run("plot", tmp_path / "a.msh", "-o", tmp_path / "a.png", option, *value)
    assert code == 2
    assert f"{option}: no triangle is there" in text


def test_an_empty_color_is_no_default(mesh, tmp_path):
    write_file(mesh, {}, {}, tmp_path / "a.msh")
    code, text = run("plot", tmp_path / "a.msh", "-o", tmp_path / "a.png", "--color", "")
    assert code == 2
    assert "--color: must not be empty: give quality, size" in text


# Files of other programs


@pytest.mark.parametrize("name", [name for name in FORMATS if not name.startswith(("nodes", "openfoam", "pos"))])
def test_labels_regions_and_data_of_all_formats_are_found(name, mesh, data, tmp_path):
    fields = {"quality": radius_ratios(mesh.points, mesh.triangles), "target_spacing": data.cells["target_spacing"]}
    path = tmp_path / f"a{FORMATS[name].files[0]}"
    write_file(mesh, fields, {}, path)
    read, file = read_mesh(path), read_triangles(path)
    assert np.array_equal(read.mesh.points, file.points)
    assert np.array_equal(read.mesh.triangles, file.triangles)
    if name not in {"su2", "fort.14", "gr3", "slf"}:  # which leave regions out
        expected = np.bincount(mesh.triangle_regions).tolist()
        assert region_counts(read.mesh) == dict(zip(mesh.regions, expected, strict=True))
        (tmp_path / "a.labels.json").unlink(missing_ok=True)
        named = name.startswith(("msh", "xdmf", "inp", "med", "ngsolve", "dealii", "ugrid"))
        bare = dict(zip(mesh.regions if named else ("region 6", "region 7"), expected, strict=True))
        assert region_counts(read_mesh(path).mesh) == bare
    if name in {"vtu", "vtk", "pvtu", "xdmf", "dat"}:
        assert np.allclose(read.cell_data["target_spacing"], fields["target_spacing"], rtol=1e-15)
    if name in {"vtu", "vtk", "pvtu", "xdmf", "dat", "skfem", "sfepy"}:
        assert read.mesh.labels == ()
    elif not name.startswith("inp"):
        counts = np.bincount(mesh.facet_labels).tolist()
        assert label_counts(read.mesh) == dict(zip(mesh.labels, counts, strict=True))
        labels = [f"label {k}" for k in range(1, 6)] if name in {"mesh", "2dm"} else mesh.labels
        assert label_counts(read_mesh(path).mesh) == dict(zip(labels, counts, strict=True))


def region_counts(mesh):
    return dict(zip(mesh.regions, np.bincount(mesh.triangle_regions).tolist(), strict=True))


def label_counts(mesh):
    return dict(zip(mesh.labels, np.bincount(mesh.facet_labels).tolist(), strict=True))


@pytest.mark.parametrize("content", ["[1]", "{", '{"a": {"id": "x"}}', '{"a": 1}'])
def test_a_damaged_file_of_labels_is_told_and_left_out(content, mesh, tmp_path):
    write_file(mesh, {}, {}, tmp_path / "a.vtu")
    (tmp_path / "a.labels.json").write_text(content)
    read = read_mesh(tmp_path / "a.vtu")
    assert read.mesh.regions == ("region 6", "region 7")
    assert read.notes == (
        "a.labels.json beside it is no table of labels as this program writes it: names are left out",
    )


def test_a_mesh_of_su2_has_its_markers(tmp_path):
    (tmp_path / "a.su2").write_text(
        "% two triangles and a square\nNDIME= 2\nNELEM= 3\n5 0 1 2 0\n5 0 2 3 1\n9 1 4 5 2 2\n"
        "NPOIN= 6 6\n0 0 0\n1 0 1\n1 1 2\n0 1 3\n2 0 4\n2 1 5\nNMARK= 2\n"
        "MARKER_TAG= far field\nMARKER_ELEMS= 2\n3 0 1\n3 1 4\n"
        "MARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 1\nSEND_RECV= 1\n1 0 0\n"
    )
    read = read_mesh(tmp_path / "a.su2")
    assert read.left_out == ()
    assert label_counts(read.mesh) == {"far field": 2}
    assert (len(read.mesh.triangles), read.mesh.quads.tolist()) == (4, [[2, 3]])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("NDIME= 2", "NDIME= 3", "in space"),
        ("NELEM= 1", "NELEM= 2", "it has 1 of 2 elements"),
        ("NELEM= 1", "NELEM= x", "counts of elements are no whole numbers"),
        ("5 0 1 2 0", "10 0 1 2 0", "elements of the kind 10"),
        ("5 0 1 2 0", "5 0 1", "a triangle with fewer than 3 nodes"),
        ("5 0 1 2 0", "5 0 1 9 0", "a node that is not there"),
        ("0 1 2", "0 x 2", "no"),
    ],
)
def test_a_damaged_mesh_of_su2(old, new, message, tmp_path):
    good = "NDIME= 2\nNELEM= 1\n5 0 1 2 0\nNPOIN= 3\n0 0 0\n1 0 1\n0 1 2\nNMARK= 0\n"
    (tmp_path / "a.su2").write_text(good)
    assert len(read_mesh(tmp_path / "a.su2").mesh.triangles) == 1
    (tmp_path / "a.su2").write_text(good.replace(old, new))
    with pytest.raises(FileError, match=message):
        read_mesh(tmp_path / "a.su2")


def test_of_overlapping_sets_of_cells_the_smallest_counts(tmp_path):
    points = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)]
    cells = [("triangle", [(0, 1, 2), (0, 2, 3), (1, 4, 5), (1, 5, 2)])]
    sets = {"all but one": [[0, 1, 2]], "first": [[0]], "second": [[1]]}
    meshio.Mesh(points, cells, cell_sets=sets).write(tmp_path / "a.inp")
    read = read_mesh(tmp_path / "a.inp").mesh
    names = [read.regions[k] for k in read.triangle_regions]
    assert names == ["first", "second", "all but one", "no region"]


def test_damaged_edges_and_those_beside_the_triangles(tmp_path):
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 5, 0)]
    tags = {"gmsh:physical": [np.array([3, 4]), np.array([9])], "gmsh:geometrical": [np.array([1, 1]), np.array([1])]}
    good = meshio.Mesh(points, [("line", [(0, 1), (0, 3)]), ("triangle", [(0, 1, 2)])], cell_data=tags)
    good.write(tmp_path / "good.msh", file_format="gmsh22", binary=False)
    read = read_mesh(tmp_path / "good.msh").mesh
    assert (read.labels, len(read.facets)) == (("label 3",), 1)
    text = (tmp_path / "good.msh").read_text().replace("1 1 2 3 1 1 2", "1 1 2 3 1 1 9")
    (tmp_path / "bad.msh").write_text(text)
    with pytest.raises(FileError, match=r"bad\.msh: .*damaged|bad\.msh: is no mesh"):
        read_mesh(tmp_path / "bad.msh")


# The command


@pytest.fixture
def vtu(mesh, data, tmp_path):
    write_file(mesh, {"target_spacing": data.cells["target_spacing"]}, {}, tmp_path / "a.vtu")
    return tmp_path / "a.vtu"


@pytest.mark.long
def test_plot_writes_the_picture_that_is_named(vtu, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("plot", "a.vtu") == (0, "files      a.png\n")
    assert run("plot", "a.vtu", "-o", "new/a.pdf", "--style", "paper", "--color", "spacing", "--nodes")[0] == 0
    assert (
        run("plot", "a.vtu", "-o", "b.svg", "--view", "0", "-4", "2", "-1", "--range", "0", "1", "--title", "B")[0] == 0
    )
    assert (tmp_path / "new/a.pdf").read_bytes().startswith(b"%PDF")
    assert "<svg" in (tmp_path / "b.svg").read_text()
    assert png_size(tmp_path / "a.png")[0] > 800


@pytest.mark.parametrize(
    ("arguments", "exit_code", "message"),
    [
        (["-o", "a.gif"], 2, "error: a.gif: unknown ending '.gif' for a picture: choose one of .png, .svg, .pdf\n"),
        (["--color", "flux"], 2, "error: --color: unknown quantity 'flux'; known: quality, "),
        (["--color", "flux"], 2, "material, none, target_spacing\n"),
        (["--style", "poster"], 2, "error: --style: 'poster' is unknown: allowed: screen, paper"),
        (["--dpi", "0"], 2, "error: --dpi: is 0: "),
        (["--range", "2", "1"], 2, "error: --range: give two numbers"),
        (["-o", "a.vtu/b.png"], 5, "a.vtu"),
    ],
)
def test_errors_of_plot_name_the_option(arguments, exit_code, message, vtu, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, said = run("plot", "a.vtu", *arguments)
    assert code == exit_code
    assert message in said
    assert not {".png", ".svg", ".pdf", ".gif"} & {path.suffix for path in tmp_path.rglob("*")}


def test_a_file_that_is_no_mesh_is_not_drawn(tmp_path):
    (tmp_path / "a.vtu").write_text("no mesh")
    assert run("plot", tmp_path / "a.vtu", "-o", tmp_path / "a.png")[0] == 5
    assert run("plot", tmp_path / "b.vtu")[0] == 5
    assert not (tmp_path / "a.png").exists()


def test_ellipses_far_larger_than_the_mesh_are_drawn_no_larger_than_can_be_seen(mesh):
    tensors = {"metric_11": 1e-40, "metric_12": 0.0, "metric_22": 1e-30}
    data = MeshData({name: np.full(len(mesh.triangles), value) for name, value in tensors.items()})
    figure = mesh_figure(mesh, PlotOptions(ellipses=True), data)
    (ellipses,) = (part for part in figure.axes[0].collections if isinstance(part, EllipseCollection))
    np.testing.assert_allclose(ellipses._widths * 2, 10 * np.ptp(mesh.points, axis=0).max())


def test_ellipses_of_the_metric_are_drawn_at_the_nodes(mesh):
    count = len(mesh.triangles)
    tensors = {"metric_11": np.full(count, 25.0), "metric_12": np.zeros(count), "metric_22": np.full(count, 4.0)}
    figure = mesh_figure(mesh, PlotOptions(ellipses=True), MeshData(tensors))
    (ellipses,) = (part for part in figure.axes[0].collections if isinstance(part, EllipseCollection))
    np.testing.assert_allclose(ellipses.get_offsets(), mesh.points)
    np.testing.assert_allclose(ellipses._widths * 2, 0.5)
    np.testing.assert_allclose(ellipses._heights * 2, 0.2)
    np.testing.assert_allclose(np.abs(np.sin(ellipses._angles)), 1)
    assert any("in the metric" in axes.get_xlabel() + axes.get_ylabel() for axes in figure.axes)
    with pytest.raises(PlotOptionError, match="the mesh has no metric") as caught:
        mesh_figure(mesh, PlotOptions(ellipses=True))
    assert caught.value.option == "ellipses"
