"""Cases whose rings or domain are in another file."""

import numpy as np
import pytest
from geometry_files import HOLE, PLATE, WKT, collection

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, FileError, GeometryError
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.groups import group_names
from bubblemesh.problem.domain import case_domain
from bubblemesh.run.pipeline import mesh_case


class TestCases:
    """In a case file."""

    def case(self, written, text):
        return load_case(written("case.yaml", f"domain: {text}\nspacing: 0.5\n"))

    def test_a_domain_is_a_file_beside_the_case(self, written):
        written("plate.wkt", WKT)
        case = self.case(written, "{file: plate.wkt, label: rim, hole_label: bore, units: mm}")
        found = case_domain(case)
        assert found.boundary.labels == ("rim", "bore")
        assert found.polygon.area == pytest.approx(15e-6)

    def test_rings_are_files_and_an_entry_of_holes_may_be_several(self, written):
        written("hole.csv", "1 1\n2 1\n2 2\n\n3 3\n3.5 3\n3.5 3.5\n")
        case = self.case(written, "{outer: {rectangle: [0, 0, 4, 4]}, holes: [{file: hole.csv, label: bore}]}")
        found = case_domain(case)
        assert found.hole_count == 2
        assert found.boundary.labels == ("outer", "bore")

    def test_the_outer_ring_is_one(self, written):
        written("two.csv", "1 1\n2 1\n2 2\n\n3 3\n3.5 3\n3.5 3.5\n")
        case = self.case(written, "{outer: {file: two.csv}}")
        with pytest.raises(
            GeometryError,
            match=r"the outer ring: .*two.csv: 2 separate areas .* part: largest.*1: area 0.125 at \(3, 3\)",
        ):
            case_domain(case)

    def test_errors_of_a_file_name_the_ring(self, written):
        case = self.case(written, "{outer: {rectangle: [0, 0, 4, 4]}, holes: [{file: a.csv}]}")
        with pytest.raises(FileError, match=r"hole 1: .*a\.csv: the file cannot be read: No such file"):
            case_domain(case)

    def test_labels_of_the_case_stand_above_those_of_the_file(self, written):
        written("plate.geojson", collection(PLATE, names=("plate",)))
        found = {"{file: plate.geojson}": ("plate", "hole-1")}
        found["{file: plate.geojson, label: rim, hole_label: bore}"] = ("rim", "bore")
        for text, labels in found.items():
            assert case_domain(self.case(written, text)).boundary.labels == labels

    @pytest.mark.long
    def test_all_rings_of_a_file_are_one_region(self, written):
        written("fibres.csv", "0.5 0.5\n1.5 0.5\n1.5 1.5\n0.5 1.5\n\n2.5 2.5\n3.5 2.5\n3.5 3.5\n2.5 3.5\n")
        region = "{name: fibres, ring: {file: fibres.csv}, spacing: 0.2}"
        other = "{name: core, ring: {rectangle: [0.75, 0.75, 1.25, 1.25]}}"
        case = self.case(written, "{outer: {rectangle: [0, 0, 4, 4]}, regions: [" + f"{region}, {other}" + "]}")
        mesh = mesh_case(case).mesh
        assert (mesh.labels, mesh.regions) == (("outer", "fibres-rim", "core-rim"), ("domain", "fibres", "core"))
        areas = np.bincount(mesh.triangle_regions, signed_areas(mesh.points, mesh.triangles))
        np.testing.assert_allclose(areas, [14, 1.75, 0.25])
        lengths = np.hypot(*(mesh.points[mesh.facets[:, 1]] - mesh.points[mesh.facets[:, 0]]).T)
        assert lengths[mesh.facet_labels == 1].max() < 0.27
        assert lengths[mesh.facet_labels == 0].min() > 0.27

    def test_a_region_keeps_its_name_though_the_file_calls_its_ring_the_same(self, written):
        written("fibre.geojson", collection({"type": "Polygon", "coordinates": [HOLE]}, names=("fibre",)))
        region = "{name: fibre, ring: {file: fibre.geojson}}"
        case = self.case(written, "{outer: {rectangle: [0, 0, 4, 4]}, regions: [" + region + "]}")
        mesh = mesh_case(case).mesh
        assert (mesh.labels, mesh.regions) == (("outer", "fibre-rim"), ("domain", "fibre"))
        assert group_names(mesh)["fibre"] == (4, 2)

    def test_names_in_a_base_are_relative_to_the_base(self, written, tmp_path):
        (tmp_path / "sub").mkdir()
        written("plate.wkt", WKT)
        written("base.yaml", "domain: {file: plate.wkt}\nspacing: 0.5\n")
        case = load_case(written("sub/case.yaml", "base: ../base.yaml\n"))
        assert case_domain(case).polygon.area == pytest.approx(15)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("{}", "domain: must be a mapping with exactly one of the keys outer, file"),
            ("{file: a.csv, feature: -1}", "domain.feature: must be a number from 0 on, or a property"),
            ("{file: a.csv, feature: {}}", "domain.feature: must be a number from 0 on, or a property"),
            ("{file: a.csv, units: parsec}", "domain.units: must be 'm', 'km'"),
            ("{file: a.csv, units: mm, scale: 2}", "domain.units: and scale exclude each other"),
            ("{file: a.csv, scale: 0}", "domain.scale: must be greater than 0"),
            ("{file: ''}", "domain.file: must not be empty"),
            ("{file: a.csv, fature: 1}", "domain.fature: unknown key; did you mean 'feature'"),
            ("{file: a.csv, smooth: true}", "domain.smooth: needs corners"),
            ("{outer: {file: a.csv, tolerance: 1}}", "domain.outer.tolerance: needs corners"),
            ("{file: a.csv, corners: 200}", "domain.corners: must be at most 180"),
        ],
    )
    def test_wrong_keys_are_refused(self, written, text, message):
        with pytest.raises(CaseError, match=message):
            self.case(written, text)
