"""Small files as solvers write them: each function writes a plane mesh of triangles, with the solution u at its nodes.

They return the path of the file to read.
"""

import base64
import zlib

import h5py
import numpy as np

TYPES = {"f8": "Float64", "f4": "Float32", "i4": "Int32", "i8": "Int64", "u1": "UInt8"}


def apart(points, triangles, u):
    """The same with nodes of its own for each triangle."""
    return points[triangles].reshape(-1, 2), np.arange(triangles.size).reshape(triangles.shape), u[triangles].ravel()


def in_space(points, z=0.0):
    return np.column_stack([points, np.full(len(points), z)])


def block(array, how, header="<u4"):
    """Bytes or text of an array: joint or separate base64, raw, or compressed in blocks."""
    content = array.tobytes()
    size = np.dtype(header).itemsize
    if how == "compressed":
        parts = [content[k : k + 1000] for k in range(0, len(content), 1000)] or [b""]
        packed = [zlib.compress(part) for part in parts]
        head = np.array([len(parts), 1000, len(parts[-1]) % 1000, *map(len, packed)], header).tobytes()
        return base64.b64encode(head).decode() + base64.b64encode(b"".join(packed)).decode()
    head = len(content).to_bytes(size, "little" if header[0] == "<" else "big")
    if how == "raw":
        return head + content
    if how == "separate":
        return base64.b64encode(head).decode() + base64.b64encode(content).decode()
    return base64.b64encode(head + content).decode()


def vtu(path, points, cells, data, how="ascii", kind=5, real="f8", order="<", header="u4", attributes='version="1.0"'):
    """A grid of one piece, of cells (c, k) of one kind; how: ascii, joint, separate, compressed, raw or base64."""
    width = cells.shape[1]
    arrays = {
        "Points": [("Points", in_space(points).astype(order + real))],
        "Cells": [
            ("connectivity", cells.ravel().astype(order + "i4")),
            ("offsets", (width * np.arange(1, len(cells) + 1)).astype(order + "i4")),
            ("types", np.full(len(cells), kind, "u1")),
        ],
        "PointData": [(name, values.astype(order + real)) for name, values in data.items()],
    }
    text, tail = "", b""
    for section, members in arrays.items():
        text += f"<{section}>"
        for name, values in members:
            form = {"ascii": "ascii", "raw": "appended", "base64": "appended"}.get(how, "binary")
            count = values.shape[1] if values.ndim > 1 else 1
            name_of = "" if section == "Points" else f'Name="{name}" '
            text += (
                f'<DataArray type="{TYPES[values.dtype.str[1:]]}" {name_of}NumberOfComponents="{count}" format="{form}"'
            )
            if form == "appended":
                text += f' offset="{len(tail)}"/>\n'
                tail += block(values, "raw", order + header) if how == "raw" else block(values, "joint").encode()
            else:
                inside = " ".join(map(repr, values.ravel().tolist())) if how == "ascii" else None
                text += ">\n" + (inside or block(values, how, order + header)) + "\n</DataArray>\n"
        text += f"</{section}>"
    attributes += f' byte_order="{"LittleEndian" if order == "<" else "BigEndian"}"'
    attributes += ' header_type="UInt64"' if header == "u8" else ""
    attributes += ' compressor="vtkZLibDataCompressor"' if how == "compressed" else ""
    begin = f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" {attributes}>\n<UnstructuredGrid>\n'
    begin += (
        f'<Piece NumberOfPoints=" {len(points)}" NumberOfCells="{len(cells)}">{text}</Piece>\n</UnstructuredGrid>\n'
    )
    if tail:
        begin += f'<AppendedData encoding="{how}">\n_'
        path.write_bytes(begin.encode() + tail + b"\n</AppendedData>\n</VTKFile>\n")
    else:
        path.write_text(begin + "</VTKFile>\n")
    return path


def dolfinx_xdmf(path, points, triangles, u, times=(0.0, 0.5, 1.0)):
    """A mesh, and u times (1 + t) at some times, each of which includes the mesh."""
    heavy = path.with_suffix(".h5").name
    with h5py.File(path.with_suffix(".h5"), "w") as file:
        file["Mesh/mesh/topology"], file["Mesh/mesh/geometry"] = triangles.astype("i8"), points
        steps, first = "", "/Xdmf/Domain/Grid[@GridType='Uniform'][1]"
        for t in times:
            place = f"Function/u/{str(t).replace('.', '_')}"
            file[place] = (u * (1 + t))[:, None]
            steps += f"""
      <Grid Name="u" GridType="Uniform">
        <xi:include xpointer="xpointer({first}/*[self::Topology or self::Geometry])" />
        <Time Value="{t}" />
        <Attribute Name="u" AttributeType="Scalar" Center="Node">
          <DataItem Dimensions="{len(u)} 1" Format="HDF">{heavy}:/{place}</DataItem>
        </Attribute>
      </Grid>"""
    path.write_text(f"""<?xml version="1.0"?>
<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>
<Xdmf Version="3.0" xmlns:xi="http://www.w3.org/2001/XInclude">
  <Domain>
    <Grid Name="mesh" GridType="Uniform">
      <Topology TopologyType="Triangle" NumberOfElements="{len(triangles)}" NodesPerElement="3">
        <DataItem Dimensions="{len(triangles)} 3" NumberType="Int" Format="HDF">{heavy}:/Mesh/mesh/topology</DataItem>
      </Topology>
      <Geometry GeometryType="XY">
        <DataItem Dimensions="{len(points)} 2" Format="HDF">{heavy}:/Mesh/mesh/geometry</DataItem>
      </Geometry>
    </Grid>
    <Grid Name="u" GridType="Collection" CollectionType="Temporal">{steps}
    </Grid>
  </Domain>
</Xdmf>
""")
    return path


def frd(path, points, triangles, u, layer=False, times=(1.0,)):
    """Results of CalculiX, of a layer of wedges or plane: u is the temperature NDTEMP, and DISP has it first."""
    n = len(points)
    places = np.vstack([in_space(points, -0.5), in_space(points, 0.5)]) if layer else in_space(points)
    values = np.tile(u, 2) if layer else u
    cells = np.hstack([triangles, triangles + n]) if layer else triangles
    number = np.arange(len(places)) + 7  # the numbers of nodes need not begin at 1
    lines = ["    1C", f"    2C{len(places):30d}{'':37s}1"]
    lines += [f" -1{k:10d}" + "".join(f"{x:12.5E}" for x in at) for k, at in zip(number, places, strict=True)]
    lines += [" -3", f"    3C{len(cells):30d}{'':37s}1"]
    for k, cell in enumerate(number[cells], start=1):
        lines += [f" -1{k:10d}{2 if layer else 7:5d}{0:5d}{1:5d}", " -2" + "".join(f"{node:10d}" for node in cell)]
    lines += [" -3"]
    for step, t in enumerate(times, start=1):
        head = f"  100CL  101{t:12.9f}{len(places):12d}{'':21s}{step:2d}{'':12s}1"
        lines += [f"    1PSTEP{'':25s}{step}", head, " -4  DISP        4    1"]
        lines += [f" -5  D{k}          1    2    {k}    0" for k in (1, 2, 3)]
        lines += [" -5  ALL         1    2    0    0    1ALL"]
        lines += [f" -1{k:10d}{t * v:12.5E}{0:12.5E}{0:12.5E}" for k, v in zip(number, values, strict=True)]
        lines += [" -3", head, " -4  NDTEMP      1    1", " -5  T           1    1    0    0"]
        lines += [f" -1{k:10d}{t * v:12.5E}" for k, v in zip(number, values, strict=True)] + [" -3"]
    path.write_text("\n".join([*lines, " 9999", ""]))
    return path


def medit(path, points, triangles, u):
    """A mesh of FreeFEM's savemesh, with the solution of its savesol beside it."""
    rows = ["MeshVersionFormatted 1", "", "Dimension", "2", "", "Identifier", '"a, 1"', "", "Vertices", len(points)]
    rows += [f"{x!r} {y!r} 0" for x, y in points.tolist()] + ["", "Triangles", len(triangles)]
    rows += [f"{a} {b} {c} 3" for a, b, c in (triangles + 1).tolist()]
    rows += ["", "SubDomainFromMesh", "1", "3 1 1 3", "", "End", ""]
    path.write_text("\n".join(map(str, rows)))
    values = "\n".join(f"{v!r} " for v in u.tolist())
    text = f"MeshVersionFormatted 1\n\nDimension 2\n\nSolAtVertices\n{len(u)}\n1 1 \n\n{values}\n\nEnd\n"
    path.with_suffix(".sol").write_text(text)
    return path


def freefem_msh(path, points, triangles, edges):
    """A mesh of FreeFEM's own format, which has no place for a solution."""
    rows = [f"{len(points)} {len(triangles)} {len(edges)}"]
    rows += [f"{x!r} {y!r} 0" for x, y in points.tolist()] + [f"{a} {b} {c} 3" for a, b, c in (triangles + 1).tolist()]
    path.write_text("\n".join([*rows, *(f"{a} {b} 1" for a, b in (edges + 1).tolist()), ""]))
    return path


def vtk_binary(path, points, triangles, u):
    """Legacy VTK as FreeFEM writes it: binary, with a table of colours."""
    head = "# vtk DataFile Version 2.0\na, Created by Freefem++ \nBINARY\nDATASET UNSTRUCTURED_GRID\n"
    n, t = len(points), len(triangles)
    cells = np.column_stack([np.full(t, 3), triangles]).astype(">i4").tobytes()
    content = head.encode() + f"POINTS {n} double\n".encode() + in_space(points).astype(">f8").tobytes()
    content += f"\nCELLS {t} {4 * t}\n".encode() + cells + f"\nCELL_TYPES {t}\n".encode()
    content += np.full(t, 5, ">i4").tobytes() + f"\nCELL_DATA {t}\nScalars  Label int 1\n".encode()
    content += b"LOOKUP_TABLE FreeFempp_table\n" + np.full(t, 3, ">i4").tobytes()
    content += b"\nLOOKUP_TABLE FreeFempp_table 2\n" + bytes(8) + f"\nPOINT_DATA {n}\nFIELD FieldData 1\n".encode()
    content += f"u 1 {n} double\n".encode() + u.astype(">f8").tobytes() + b"\n"
    path.write_bytes(content)
    return path
