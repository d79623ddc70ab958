"""Lists of points and tables as programs write them: airfoils, columns with names, decimal commas."""

import re

import numpy as np
import pytest
from geometry_files import area, domain, read_rings

from bubblemesh.errors import CaseError
from bubblemesh.readers import read_lines, read_points
from bubblemesh.readers.selection import Selection

TURN = np.linspace(0, np.pi, 31)
EDGE = (1 + np.cos(TURN)) / 2  # x from the trailing edge to the leading one
THICKNESS = 0.3 * np.sqrt(EDGE) * (1 - EDGE) + 0.002 * EDGE  # open at the trailing edge
UPPER = np.column_stack([EDGE, THICKNESS])
LOWER = UPPER[::-1] * [1, -1]
LOOP = np.vstack([UPPER, LOWER[1:]])


def rows(points, form="{:9.6f} {:9.6f}"):
    return "".join(form.format(*point) + "\n" for point in points)


def exact(points):
    x, y = np.asarray(points).T
    return abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2


FOIL = exact(LOOP)
AIRFOILS = {
    "selig": "SYM 30 (made up)\n" + rows(LOOP),
    "lednicer": f"SYM 30\n {len(UPPER):.1f}   {len(LOWER):.1f}\n\n{rows(UPPER[::-1])}\n{rows(LOWER)}",
    "lednicer in one": f"SYM 30\n {len(UPPER)}.  {len(LOWER)}.\n{rows(UPPER[::-1])}{rows(LOWER)}",
    "surfaces": f"SYM 30\n{rows(UPPER[::-1])}\n{rows(LOWER)}",
    "mses": f"SYM 30\n -2.0  3.0  -2.5  2.5\n{rows(LOOP)}",
    "text at the end": f"{rows(LOOP)}Made up for a test\nsee nowhere 1999\n",
    "commas": "SYM\n" + rows(LOOP).replace(".", ","),
    "leading point twice": rows(np.vstack([UPPER, LOWER])),
}


class TestAirfoils:
    """As Selig, Lednicer, XFOIL and MSES list them."""

    @pytest.mark.parametrize("name", AIRFOILS)
    def test_one_outline(self, written, name):
        path = written("foil.dat", AIRFOILS[name])
        (ring,) = read_rings(path, Selection())
        assert len(ring.vertices) == len(LOOP)
        assert area(path) == pytest.approx(FOIL, rel=1e-4)

    def test_what_is_taken_as_what_is_noted(self, written):
        expected = {
            "lednicer": "line 2 is taken as the numbers of points of the upper and the lower surface",
            "mses": "line 2 is taken as the box of MSES around the flow, and not used",
            "text at the end": "line 62 is taken as text after a ring: 'Made up for a test'",
            "commas": "commas are taken as decimal points",
        }
        for name, note in expected.items():
            (ring,) = read_rings(written("foil.dat", AIRFOILS[name]), Selection())
            assert ring.notes[0] == f"foil.dat: {note}"

    @pytest.mark.parametrize("between", ["999.9 999.9\n", "  999.0   999.0\n", "\n", "Flap\n", "NaN NaN\n"])
    def test_several_elements(self, written, between):
        path = written("high-lift.dat", f"SLAT AND MAIN\n{rows(LOOP)}{between}{rows(LOOP * 0.3 + [1.1, -0.2])}")
        first, second = read_rings(path, Selection())
        assert len(first.vertices) == len(second.vertices) == len(LOOP)
        assert area(path, feature=1) == pytest.approx(0.09 * FOIL, rel=1e-3)

    def test_numbers_of_points_that_do_not_fit(self, written):
        text = AIRFOILS["lednicer"].replace(" 31.0 ", " 35.0 ", 1)
        with pytest.raises(CaseError, match=r"line 2 gives 35 and 31 points .* but there are 62: correct the numbers"):
            domain(written("foil.dat", text))

    @pytest.mark.parametrize("form", ["selig", "lednicer", "commas"])
    @pytest.mark.parametrize("header", ["20-32C AIRFOIL", "74-130 WP2", "12% JOUKOWSKI AIRFOIL", '"2032c"'])
    def test_a_header_may_begin_with_a_digit(self, written, header, form):
        _, _, rest = AIRFOILS[form].partition("\n")
        path = written("foil.dat", f"{header}\n{rest}")
        (ring,) = read_rings(path, Selection())
        assert len(ring.vertices) == len(LOOP)
        assert f"foil.dat: line 1 is taken as a header: {header!r}" in ring.notes

    @pytest.mark.parametrize("remark", ["0.5 0.25 % the trailing edge", "# 12% thick", "! made up"])
    def test_a_remark_is_no_header(self, written, remark):
        (ring,) = read_rings(written("foil.dat", f"{remark}\n{rows(LOOP)}"), Selection())
        assert not ring.notes

    @pytest.mark.parametrize(
        ("header", "told"),
        [
            ("4412", "line 1: one number alone: a point has two; put # before a header"),
            ("63 412", r"line 1 gives 63 and 412 points .* are 61: correct the numbers, or put # before .* a header"),
        ],
    )
    def test_numbers_that_may_be_a_header_are_told(self, written, header, told):
        with pytest.raises(CaseError, match=told):
            read_rings(written("foil.dat", f"{header}\n{rows(LOOP)}"), Selection())
        (ring,) = read_rings(written("foil.dat", f"#{header}\n{rows(LOOP)}"), Selection())
        assert len(ring.vertices) == len(LOOP)

    def test_a_corner_at_999_is_a_corner_of_a_large_domain(self, written):
        (ring,) = read_rings(written("a.txt", "0 0\n1000 0\n999 999\n0 500\n"), Selection())
        assert len(ring.vertices) == 4


class TestColumns:
    """Columns that are taken by their names."""

    @pytest.mark.parametrize(
        "text",
        [
            "id,x,y,z\n1,0,0,5\n2,4,0,5\n3,4,4,5\n4,0,4,5\n",
            'name;Y;X\n"a; b";0,0;0,0\nb;0;4,0\nc;4,0;4\nd;4;0\n',
            "site\tEasting (m)\tNorthing (m)\nA\t0\t0\nB\t4\t0\nC\t4\t4\nD\t0\t4\n",
            'fid,lon,lat,remark\n1,0,0,"a, b"\n2,4,0,\n3,4,4,c\n4,0,4,d\n',
            "x y z\n0 0 1\n4 0 1\n4 4 1\n0 4 1\n",
            "id,x_m,y_m\n7,0,0\n8,4,0\n9,4,4\n10,0,4\n",
            "Nr;Rechtswert;Hochwert\n11;0;0\n12;4;0\n13;4;4\n14;0;4\n",
            "Punkt;Rechts;Hoch\nA1;0;0\nA2;4;0\nA3;4;4\nA4;0;4\n",
            "no,y [m],x [m]\n3,0,0\n4,0,4\n5,4,4\n6,4,0\n",
        ],
    )
    def test_columns_of_x_and_y(self, written, text):
        assert area(written("a.csv", text)) == pytest.approx(16)

    def test_what_is_taken_is_told(self, written):
        (ring,) = read_rings(written("a.csv", "id,X,Y\n1,0,0\n2,4,0\n3,4,4\n"), Selection())
        assert ring.notes == ("a.csv: columns 'X' and 'Y' are taken as x and y, others are not used",)
        (ring,) = read_rings(written("b.csv", "1,0,0\n2,4,0\n3,4,4\n4,0,4\n"), Selection())
        (note,) = ring.notes
        assert note.endswith("and the first, which counts the rows, is x: name columns x and y in the first line")

    @pytest.mark.parametrize(
        ("text", "told"),
        [
            ("id,x,y\n1,1,1\n1,3,1\n1,3,3\n2,7,7\n2,8,7\n2,8,8\n", ", not even 'id' with its 2 values: put blank"),
            ("id,x,y\n1,1,1\n1,3,1\n1,3,3\n\n2,7,7\n2,8,7\n2,8,8\n", "others are not used"),
            ("id,x,y\n1,1,1\n2,3,1\n3,3,3\n", "others are not used"),
            ("x,y,z\n1,1,1\n1,3,1\n2,3,3\n2,4,3\n", "others are not used"),
        ],
    )
    def test_an_id_that_parts_nothing_is_told(self, written, text, told):
        note = read_lines(written("a.csv", text), Selection())[0].notes[0]
        assert told in note
        assert note.endswith("not used") == told.endswith("not used")

    @pytest.mark.parametrize("name", ["ID", None])
    def test_columns_with_words_of_which_none_is_x_are_refused(self, written, name):
        with pytest.raises(CaseError, match=r"of the columns 'ID', 'E', 'N' none are known as x and y"):
            read_points(written("a.csv", "ID,E,N\na,1,1\nb,4,5\n"), Selection(), name)

    @pytest.mark.parametrize("read", [read_rings, lambda path, chosen: read_points(path, chosen, None)])
    def test_columns_of_which_none_is_x_are_refused(self, written, read):
        told = "line 2: of the columns 'no', 'a', 'b' none are known as x and y: call two of them x and y"
        with pytest.raises(CaseError, match=told):
            read(written("a.csv", "# made up\nno,a,b\n7,0,0\n8,4,0\n9,4,4\n"), Selection())

    def test_rows_of_nan_and_blank_lines_part_rings(self, written):
        text = "x,y,k\n0,0,1\n4,0,1\n4,4,1\nnan,nan,0\n1,1,2\n2,1,2\n2,2,2\n\n7,7,3\n8,7,3\n8,8,3\n"
        assert len(read_rings(written("a.csv", text), Selection())) == 3

    def test_a_cell_that_is_no_number_is_an_error_with_its_line(self, written):
        with pytest.raises(CaseError, match="line 3: x and y are no numbers: '2,4,O': correct it"):
            domain(written("a.csv", "id,x,y\n1,0,0\n2,4,O\n3,4,4\n"))

    def test_lines_of_one_file_may_have_different_separators(self, written):
        assert area(written("a.csv", "x, y\n0, 0\n4, 0\n4; 4\n0 4\n")) == pytest.approx(16)


class TestQuotes:
    """Cells in quotes, whose commas part no columns."""

    @pytest.mark.parametrize(
        "text",
        [
            '"0,5","0,25"\n"2,5","0,25"\n"2,5","3,25"\n"0,5","3,25"\n',
            'x,y\n"0,5","0,25"\n"2,5","0,25"\n"2,5","3,25"\n"0,5","3,25"\n',
            'id,x,y\n"a, b","0,5","0,25"\n2,"2,5","0,25"\n3,"2,5","3,25"\n4,"0,5","3,25"\n',
            '"1,000";"0"  # "9,000"\n"3,000";"0"\n"3";"3,000"\n"1";"3"\n',
        ],
    )
    def test_a_comma_is_a_decimal_point(self, written, text):
        assert area(written("a.csv", text)) == pytest.approx(6)

    @pytest.mark.parametrize("cell", ["1,000", "-12,500", "1,000,000", "1,000.5", "1.000,5"])
    @pytest.mark.parametrize("header", ["", "id,x,y\n"])
    def test_one_that_may_part_thousands_is_refused_with_its_line(self, written, cell, header):
        text = header + f'1,0,0\n2,"{cell}",0\n3,0,7\n'
        line = 2 + header.count("\n")
        told = f"line {line}: the comma in '{cell}' may be a decimal point or part thousands: write numbers without"
        with pytest.raises(CaseError, match=re.escape(told)):
            domain(written("a.csv", text))

    @pytest.mark.parametrize("header", ["20-32C wells", "2 wells", "12% of all", "O 0"])
    def test_a_header_of_points_with_digits_is_told(self, written, header):
        places, notes = read_points(written("a.csv", f"{header}\n10,5 20,5\n30,5 40,5\n"), Selection(), None)
        assert [place.at for place in places] == [(10.5, 20.5), (30.5, 40.5)]
        assert notes == (f"a.csv: line 1 is taken as a header: {header!r}",)

    def test_names_hold_commas_and_numbers(self, written):
        places, _ = read_points(written("a.csv", '"Well 3, north",10,20\n"Well #4; 5 6",30,40\n'), Selection(), None)
        assert [place.at for place in places] == [(10, 20), (30, 40)]
