import io
import struct
import tracemalloc
import zipfile
import zlib

import meshio
import numpy as np
import pytest
from PIL import Image

from bubblemesh.errors import CaseError, FileError, LimitError
from bubblemesh.meshfiles.fields import PARTS, read_field
from bubblemesh.readers.grids import rasters
from bubblemesh.readers.grids.rasters import read_grey, read_gridded
from bubblemesh.readers.tables import read_columns
from bubblemesh.spacing.terms.field import MeshField

TRIANGLE = [[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]]
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5], [0.5, 0.5]]
NODES = {"triangle": TRIANGLE[:3], "triangle6": TRIANGLE, "quad": SQUARE[:4], "quad8": SQUARE[:8], "quad9": SQUARE}

SHORT = """# vtk DataFile Version 4.2
three values for four points
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 double
0 0 0  1 0 0  1 1 0  0 1 0
CELLS 2 8
3 0 1 2
3 0 2 3
CELL_TYPES 2
5
5
POINT_DATA 3
FIELD FieldData 1
h 1 3 double
1 1 1
"""


def in_space(points):
    return np.column_stack([points, np.zeros(len(points))])


def written(path, points, cells, **data):
    meshio.Mesh(in_space(np.array(points, float)), cells, **data).write(path)
    return path


def square(path, **data):
    """Two triangles after two lines."""
    return written(path, SQUARE[:4], [("line", [[0, 1], [1, 2]]), ("triangle", [[0, 1, 2], [0, 2, 3]])], **data)


class TestReadField:
    def test_every_kind_of_face_is_known(self):
        assert set(NODES) == set(PARTS)

    @pytest.mark.parametrize("kind", NODES)
    def test_faces_are_cut_in_triangles_that_use_all_nodes(self, kind, tmp_path):
        nodes = np.array(NODES[kind])
        values = np.random.default_rng(0).uniform(1, 2, len(nodes))
        path = written(tmp_path / "a.vtu", nodes, [(kind, [np.arange(len(nodes))])], point_data={"h": values})
        name, points, triangles, found, cells = read_field(path, None)
        assert (name, cells) == ("h", None)
        np.testing.assert_array_equal(found, values)
        (ux, uy), (vx, vy) = (points[triangles[:, 1:]] - points[triangles[:, :1]]).transpose(1, 2, 0)
        area = (ux * vy - uy * vx) / 2
        assert (area > 0).all()
        assert area.sum() == pytest.approx(0.5 if "triangle" in kind else 1)
        np.testing.assert_allclose(MeshField.of(points, triangles, found)(*nodes.T), values, rtol=1e-9)

    def test_cell_data_of_mixed_faces_goes_with_their_triangles(self, tmp_path):
        points = [*SQUARE[:4], [2, 0.5], [0.5, 2]]
        cells = [("line", [[0, 1]]), ("quad", [[0, 1, 2, 3]]), ("vertex", [[0]]), ("triangle", [[1, 4, 2], [2, 5, 3]])]
        data = {"size": [np.array([9.0]), np.array([0.1]), np.array([9.0]), np.array([0.2, 0.3])]}
        found = read_field(written(tmp_path / "a.vtu", points, cells, cell_data=data), "size")
        np.testing.assert_array_equal(found.values, [0.1, 0.2, 0.3])
        np.testing.assert_array_equal(found.cells, [0, 0, 1, 2])
        np.testing.assert_array_equal(found.triangles, [[0, 1, 2], [0, 2, 3], [1, 4, 2], [2, 5, 3]])
        assert not found.at_points

    def test_data_at_nodes_goes_before_data_of_cells(self, tmp_path):
        cell_data = {"h": [np.ones(2), np.ones(2)]}
        path = square(tmp_path / "a.vtu", point_data={"h": np.arange(1, 5.0)}, cell_data=cell_data)
        assert read_field(path, "h").at_points

    def test_numbers_of_nodes_stay_those_of_the_file(self, tmp_path):
        points = [[7, 7], *SQUARE[:4]]
        data = {"h": np.array([np.nan, 1, 2, 3, 4])}
        path = written(tmp_path / "a.vtu", points, [("triangle", [[1, 2, 3], [1, 3, 4]])], point_data=data)
        found = read_field(path, "h")
        np.testing.assert_array_equal(found.triangles, [[1, 2, 3], [1, 3, 4]])
        np.testing.assert_array_equal(found.values[1:], [1, 2, 3, 4])

    def test_numbers_that_a_format_keeps_are_no_data_unless_named(self, tmp_path):
        physical = {name: [np.array([1, 2]), np.array([3, 4])] for name in ("gmsh:physical", "gmsh:geometrical")}
        mesh = meshio.Mesh(
            in_space(SQUARE[:4]),
            [("line", [[0, 1], [1, 2]]), ("triangle", [[0, 1, 2], [0, 2, 3]])],
            point_data={"h": np.arange(1, 5.0)[:, None]},
            cell_data=physical,
        )
        mesh.write(tmp_path / "a.msh", file_format="gmsh22")
        assert read_field(tmp_path / "a.msh", None).name == "h"
        np.testing.assert_array_equal(read_field(tmp_path / "a.msh", "gmsh:physical").values, [3, 4])

    @pytest.mark.parametrize(
        ("data", "name", "message"),
        [
            ({}, None, r"has no data: write values"),
            ({}, "h", r"has no data 'h': it has none"),
            ({"h": np.ones(4), "g": np.ones(4)}, None, r"has data of 2 names \(h, g\): give the name of one"),
            ({"h": np.ones(4), "g": np.ones(4)}, "k", r"has no data 'k': it has h, g"),
            ({"u": np.ones((4, 3))}, "u", r"u has 3 components: a spacing is one number in each place"),
            ({"t": np.ones((4, 9))}, None, r"t has 9 components"),
        ],
    )
    def test_names_and_components(self, data, name, message, tmp_path):
        with pytest.raises(CaseError, match=f"a.vtu: {message}"):
            read_field(square(tmp_path / "a.vtu", point_data=data), name)

    @pytest.mark.parametrize(
        ("points", "cells", "message"),
        [
            (SQUARE[:4], [("line", [[0, 1]])], "holds no triangles"),
            ([*SQUARE[:4]], [("tetra", [[0, 1, 2, 3]])], "holds cells of the kind tetra"),
            ([[0, 0], [1, 0], [0, np.nan]], [("triangle", [[0, 1, 2]])], "node 2 has a coordinate that is no number"),
            ([[0, 0], [1, 0], [0, 1]], [("triangle", [[0, 1, 5]])], "a triangle has a node that is not there"),
            (1e-80 * np.array(SQUARE[:3]), [("triangle", [[0, 1, 2]])], "is smaller than 1e-70: choose another unit"),
        ],
    )
    def test_meshes_without_plane_triangles(self, points, cells, message, tmp_path):
        with pytest.raises(FileError, match=f"a.vtu: {message}"):
            read_field(written(tmp_path / "a.vtu", points, cells, point_data={"h": np.ones(len(points))}), "h")

    def test_surfaces_in_space_are_refused(self, tmp_path):
        mesh = meshio.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 1]], [("triangle", [[0, 1, 2]])], point_data={"h": [1, 1, 1]})
        mesh.write(tmp_path / "a.vtu")
        with pytest.raises(FileError, match="is a surface in space"):
            read_field(tmp_path / "a.vtu", "h")

    def test_files_that_cannot_be_read(self, tmp_path):
        with pytest.raises(FileError, match=r"none.vtu: the file cannot be read: No such file"):
            read_field(tmp_path / "none.vtu", "h")
        (tmp_path / "a.vtu").write_text("hello")
        with pytest.raises(FileError, match=r"a.vtu: is no XML: syntax error: line 1, column 0"):
            read_field(tmp_path / "a.vtu", "h")
        (tmp_path / "short.vtk").write_text(SHORT)
        with pytest.raises(FileError, match=r"short.vtk: is no mesh that can be read .*4, .*3"):
            read_field(tmp_path / "short.vtk", "h")


class TestReadGridded:
    def test_an_npy_file_holds_one_array(self, tmp_path):
        np.save(tmp_path / "sizes.npy", np.arange(6).reshape(2, 3))
        found = read_gridded(tmp_path / "sizes.npy", None)
        assert (found.name, found.x, found.y) == ("sizes", None, None)
        np.testing.assert_array_equal(found.values, [[0.0, 1, 2], [3, 4, 5]])
        assert found.values.dtype == float

    def test_the_only_array_beside_the_coordinates_needs_no_name(self, tmp_path):
        np.savez(tmp_path / "a.npz", x=[0, 1], y=[5, 6], d=np.ones((2, 2)))
        found = read_gridded(tmp_path / "a.npz", None)
        assert found.name == "d"
        np.testing.assert_array_equal(found.x, [0, 1])
        np.testing.assert_array_equal(found.y, [5, 6])

    def test_names_choose_among_several(self, tmp_path):
        np.savez(tmp_path / "a.npz", d=np.ones((2, 2)), e=np.zeros((2, 2)))
        assert read_gridded(tmp_path / "a.npz", "e").values.max() == 0
        with pytest.raises(CaseError, match=r"has 2 arrays \(d, e\): choose one by name"):
            read_gridded(tmp_path / "a.npz", None)
        with pytest.raises(CaseError, match=r"has no array 'f': allowed: d, e"):
            read_gridded(tmp_path / "a.npz", "f")

    @pytest.mark.parametrize("array", [np.array(["a"]), np.ones(2, complex), np.ones(2, bool)])
    def test_only_real_numbers_are_taken(self, array, tmp_path):
        np.savez(tmp_path / "a.npz", d=array)
        with pytest.raises(CaseError, match="d does not hold real numbers"):
            read_gridded(tmp_path / "a.npz", None)

    def test_other_files_in_an_archive_are_no_arrays(self, tmp_path):
        with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
            archive.writestr("notes.txt", "hello")
        with pytest.raises(CaseError, match=r"notes.txt does not hold real numbers \(found a file\)"):
            read_gridded(tmp_path / "a.npz", None)

    def test_files_that_cannot_be_read(self, tmp_path):
        with pytest.raises(FileError, match="cannot be read: No such file"):
            read_gridded(tmp_path / "none.npy", None)
        stream = io.BytesIO()
        np.savez_compressed(stream, d=np.arange(1000.0))
        whole = stream.getvalue()
        objects = io.BytesIO()
        np.save(objects, np.array([{}]), allow_pickle=True)
        for content in (b"", b"1, 2, 3\n", whole[:200], whole[:60] + b"??????" + whole[66:], objects.getvalue()):
            (tmp_path / "a.npz").write_bytes(content)
            with pytest.raises(FileError, match=r"is no .npy or .npz file of numbers, or a damaged one"):
                read_gridded(tmp_path / "a.npz", None)

    @pytest.mark.parametrize("name", ["g.csv", "lab.PNG", "none"])
    def test_a_file_of_another_kind_is_told_what_reads_it(self, name, tmp_path):
        (tmp_path / name).write_text("0, 0, 0.1\n")
        endings = ".npy, .npz, .nc, .grd, .tif, .tiff, .asc, .xyz"
        with pytest.raises(
            FileError, match=f"is no raster, which ends in {endings}: .* to scattered, a picture to image"
        ):
            read_gridded(tmp_path / name, None)
        np.save(tmp_path / "a.npy", np.ones((2, 2)))
        (tmp_path / "a.npy").rename(tmp_path / name)  # NumPy's files are known by what is in them
        assert read_gridded(tmp_path / name, None).values.shape == (2, 2)

    def test_arrays_too_large_for_the_memory_are_refused(self, tmp_path):
        zeros = np.broadcast_to(np.float64(0), (1, 10**12))
        for large in ("d", "x"):
            with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
                for name in ("d", "x"):
                    with archive.open(f"{name}.npy", "w") as member:
                        header = np.lib.format.header_data_from_array_1_0(zeros if name == large else np.ones(2))
                        np.lib.format.write_array_header_1_0(member, header)
                        member.write(np.ones(2).tobytes())
            with pytest.raises(LimitError, match=f"{large} has 1,000,000,000,000 values, more than the 25,000,000"):
                read_gridded(tmp_path / "a.npz", "d")

    def test_no_more_is_unpacked_than_is_used(self, tmp_path):
        with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
            for name in ("d", "e"):
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.save(member, np.ones((2, 2)))
                    for _ in range(30):
                        member.write(bytes(1_000_000))
        tracemalloc.start()
        np.testing.assert_array_equal(read_gridded(tmp_path / "a.npz", "d").values, np.ones((2, 2)))
        assert tracemalloc.get_traced_memory()[1] < 10_000_000
        tracemalloc.stop()

    def test_headers_that_promise_more_than_there_is(self, tmp_path):
        for shape in ("(5000, 5000)", "(-5, -5)", "(2.0, 2)"):
            header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}".ljust(117) + "\n"
            (tmp_path / "a.npy").write_bytes(b"\x93NUMPY\1\0v\0" + header.encode() + bytes(32))
            with pytest.raises(FileError, match=r"is no .npy or .npz file of numbers, or a damaged one"):
                read_gridded(tmp_path / "a.npy", None)

    def test_the_order_of_the_bytes_does_not_matter(self, tmp_path):
        values = np.arange(6.0).reshape(2, 3)
        for array in (np.asfortranarray(values), values.astype(">f4"), values.astype("<i2")):
            np.save(tmp_path / "a.npy", array)
            np.testing.assert_array_equal(read_gridded(tmp_path / "a.npy", None).values, values)


GREY = np.array([[0, 51, 102], [153, 204, 255]], np.uint8)
SHADES = np.array([[0, 0.2, 0.4], [0.6, 0.8, 1]])


class TestReadGrey:
    @pytest.mark.parametrize("mode", ["L", "LA", "P", "RGB", "RGBA"])
    @pytest.mark.parametrize("ending", [".png", ".tiff", ".webp"])
    def test_black_is_zero_and_white_one(self, mode, ending, tmp_path):
        if ending == ".webp" and mode not in ("RGB", "RGBA"):
            pytest.skip("WebP has colours only")
        options = {"lossless": True} if ending == ".webp" else {}
        Image.fromarray(GREY).convert(mode).save(tmp_path / f"a{ending}", **options)
        np.testing.assert_allclose(read_grey(tmp_path / f"a{ending}"), SHADES, atol=1e-12)

    def test_sixteen_bits_count_in_full(self, tmp_path):
        Image.fromarray(np.array([[0, 1, 32768, 65535]], np.uint16)).save(tmp_path / "a.png")
        np.testing.assert_allclose(read_grey(tmp_path / "a.png"), [[0, 1 / 65535, 32768 / 65535, 1]], rtol=1e-12)

    def test_one_bit(self, tmp_path):
        Image.fromarray(GREY > 100).save(tmp_path / "a.png")
        np.testing.assert_array_equal(read_grey(tmp_path / "a.png"), [[0, 0, 1], [1, 1, 1]])

    def test_transparent_pixels_are_white(self, tmp_path):
        pixels = np.array([[[0, 0, 0, 255], [0, 0, 0, 0], [0, 0, 0, 102]]], np.uint8)
        Image.fromarray(pixels).save(tmp_path / "a.png")
        np.testing.assert_allclose(read_grey(tmp_path / "a.png"), [[0, 1, 0.6]])

    def test_colours_count_by_their_brightness(self, tmp_path):
        Image.fromarray(np.eye(3, dtype=np.uint8)[None] * 255).save(tmp_path / "a.png")
        red, green, blue = read_grey(tmp_path / "a.png")[0]
        assert 0 < blue < red < green < 1
        assert red + green + blue == pytest.approx(1, abs=0.01)

    def test_what_is_no_picture_is_refused(self, tmp_path):
        Image.fromarray(GREY.astype(np.float32)).save(tmp_path / "float.tiff")
        with pytest.raises(CaseError, match="has pixels of the kind F: give a picture of grey values or colours"):
            read_grey(tmp_path / "float.tiff")
        with pytest.raises(FileError, match="cannot be read: No such file"):
            read_grey(tmp_path / "none.png")
        (tmp_path / "text.png").write_text("hello")
        with pytest.raises(FileError, match="is no picture of a known format"):
            read_grey(tmp_path / "text.png")
        Image.fromarray(GREY).save(tmp_path / "whole.png")
        (tmp_path / "cut.png").write_bytes((tmp_path / "whole.png").read_bytes()[:50])
        with pytest.raises(FileError, match="is no picture that can be read"):
            read_grey(tmp_path / "cut.png")

    def test_pictures_too_large_for_the_memory_are_refused(self, tmp_path, monkeypatch):
        Image.fromarray(GREY).save(tmp_path / "a.png")
        for most in (89_478_485, 4, 2):  # beyond the library's limit it warns, beyond twice the limit it refuses
            monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", most)
            monkeypatch.setattr(rasters, "MOST_VALUES", 5)
            with pytest.raises(LimitError, match="has more than 5 pixels: reduce it"):
                read_grey(tmp_path / "a.png")

    def test_a_picture_of_few_bytes_and_many_pixels(self, tmp_path):
        Image.new("1", (14_000, 14_000)).save(tmp_path / "a.png")  # Pillow itself refuses to open more than 13,377
        assert (tmp_path / "a.png").stat().st_size < 30_000
        with pytest.raises(LimitError, match="has more than 25,000,000 pixels"):
            read_grey(tmp_path / "a.png")

    def test_a_picture_of_few_pixels_in_a_huge_tile(self, tmp_path):
        tile = zlib.compress(bytes(10_000))
        tags = {256: 4, 257: 4, 258: 8, 259: 8, 262: 1, 277: 1, 322: 16_000, 323: 16_000, 324: 200, 325: len(tile)}
        entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags.items())
        head = b"II*\0" + struct.pack("<IH", 8, len(tags)) + entries + bytes(4)
        (tmp_path / "a.tiff").write_bytes(head.ljust(200, b"\0") + tile)
        with pytest.raises(LimitError, match="has more than 25,000,000 pixels"):
            read_grey(tmp_path / "a.tiff")

    def test_bands_do_not_show(self, tmp_path, monkeypatch):
        rng = np.random.default_rng(0)
        for name, values in (("a", rng.integers(0, 256, (7, 5, 4), np.uint8)), ("b", rng.integers(0, 65536, (7, 5)))):
            Image.fromarray(values.astype(np.uint16) if name == "b" else values).save(tmp_path / f"{name}.png")
            whole = read_grey(tmp_path / f"{name}.png")
            with monkeypatch.context() as patched:
                patched.setattr(rasters, "BAND", 10)
                np.testing.assert_array_equal(read_grey(tmp_path / f"{name}.png"), whole)

    def test_only_pictures_are_opened(self, tmp_path):
        """Pillow starts Ghostscript for some formats, whatever the file's ending."""
        Image.fromarray(GREY).save(tmp_path / "a.eps")
        (tmp_path / "a.eps").rename(tmp_path / "a.png")
        with pytest.raises(FileError, match=r"is no picture of a known format \(PNG, JPEG, TIFF"):
            read_grey(tmp_path / "a.png")


class TestReadColumns:
    def test_separators_comments_and_headers(self, tmp_path):
        (tmp_path / "a.csv").write_text(
            "\ufeffx, y, size\n# note\n0, 0, 0.1\n\n1;0;2e-1 # corner\n0 1\t.3\n0,5; 1,5; 0,4\n"
        )
        np.testing.assert_array_equal(
            read_columns(tmp_path / "a.csv", ("x", "y", "d")), [[0, 0, 0.1], [1, 0, 0.2], [0, 1, 0.3], [0.5, 1.5, 0.4]]
        )

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("", "there are no numbers in it: give x, y, d in each line"),
            ("x, y, d\n", "there are no numbers in it"),
            ("0, 0, 1\n1, 1\n", r"line 2: must have 3 numbers, x, y, d \(found '1, 1'\)"),
            ("0, 0, 1, 4\n", "line 1: must have 3 numbers"),
            ("0, 0, 1\nx, y, d\n", "line 2: must have 3 numbers"),
            ("0, 0, 1\n0,5, 1,5, 2,5\n", "line 2: must have 3 numbers"),
        ],
    )
    def test_lines_that_do_not_fit_are_named(self, text, message, tmp_path):
        (tmp_path / "a.csv").write_text(text)
        with pytest.raises(CaseError, match=message):
            read_columns(tmp_path / "a.csv", ("x", "y", "d"))

    def test_files_that_cannot_be_read(self, tmp_path):
        with pytest.raises(FileError, match="cannot be read: No such file"):
            read_columns(tmp_path / "none.csv", ("x", "y", "d"))
        (tmp_path / "a.csv").write_bytes(b"\xff\xfe1, 2, 3")
        with pytest.raises(CaseError, match="line 1: not UTF-8"):
            read_columns(tmp_path / "a.csv", ("x", "y", "d"))
