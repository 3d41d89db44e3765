"""Scatter tables: what is read, in every layout the same; what is refused, by line and column."""

from __future__ import annotations

import math

import pytest

import gyroctl as gy
from gyroctl.studies.site import Scatter, read_scatter
from gyroctl.studies.site.periods import over_peak_period

ROWS = [(0.5, 5.0, 0.1), (0.5, 7.0, 0.2), (0.5, 9.0, 0.05), (1.5, 5.0, 0.05), (1.5, 7.0, 0.3), (1.5, 9.0, 0.3)]


def read(tmp_path, text: str, **said: str) -> Scatter:
    path = tmp_path / "scatter.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_scatter(path, **said)


def matrix(corner: str = '"Hs [m] \\ Tp [s], occurrence [%]"') -> str:
    return f"{corner},5,7,9\n0.5,10,20,5\n1.5,5,30,30\n"


SAME = {
    "matrix": matrix(),
    "mark of byte order, lines of Windows": "\ufeff" + matrix().replace("\n", "\r\n"),
    "semicolons and decimal commas": matrix()
    .replace(",", ";")
    .replace("0.5", "0,5")
    .replace("1.5", "1,5")
    .replace("; occ", ", occ"),
    "by period": '"Tp [s] \\ Hs [m], occurrence [%]",0.5,1.5\n5,10,5\n7,20,30\n9,5,30\n',
    "descending, with sums": '"Hs [m] / Tp [s], %",5,7,9,Sum\n1.5,5,30,30,65\n0.5,10,20,5,35\nTotal,15,50,35,100\n',
    "ranges": '"Hs (m) | Tp (s), %",4-6,6 - 8,8–10\n0..1,10,20,5\n1 to 2,5,30,30\n',
    "lower edges": "# bins: lower edges\n# occurrence: percent\nHs/Tp,4,6,8\n0,10,20,5\n1,5,30,30\n",
    "upper edges": "# bins: upper edges\n# occurrence: percent\nHs/Tp,6,8,10\n1,10,20,5\n2,5,30,30\n",
    "a line that says the separator": "sep=;\n"
    + matrix('"Hs [m] \\ Tp [s], occurrence [%]"').replace(",", ";").replace("; occ", ", occ"),
    "list": "hs_m,tp_s,percent\n" + "".join(f"{h},{t},{100 * p:g}\n" for h, t, p in ROWS),
    "list in another order": "occurrence [1];Peak period [s];Hm0\n"
    + "".join(f"{p};{t};{h}\n" for h, t, p in reversed(ROWS)),
    "hours": "Hs [m]\tTp [s]\thours\n" + "".join(f"{h}\t{t}\t{8766 * p!r}\n" for h, t, p in ROWS),
    "counts, with a state that never is": "Hs,Tp,counts\n"
    + "".join(f"{h},{t},{1000 * p}\n" for h, t, p in ROWS)
    + "3,9,0\n",
}


@pytest.mark.parametrize("text", SAME.values(), ids=list(SAME))
def test_the_same_table_in_every_layout(tmp_path, text):
    found = read(tmp_path, text)
    assert found.kind == "Tp"
    assert [(one.hs, one.period) for one in found.bins] == [row[:2] for row in ROWS]
    assert [one.share for one in found.bins] == pytest.approx([row[2] for row in ROWS], rel=1e-12)
    assert found.missing == 0.0


def test_what_the_file_does_not_say_may_be_said_beside_it(tmp_path):
    bare = ",5,7,9\n0.5,10,20,5\n1.5,5,30,30\n"
    found = read(tmp_path, bare, layout="matrix", period="Te", occurrence="percent")
    assert found.kind == "Te" and len(found.bins) == 6
    turned = read(
        tmp_path, ",0.5,1.5\n5,10,5\n7,20,30\n9,5,30\n", layout="matrix-by-period", period="Te", occurrence="percent"
    )
    assert turned.bins == found.bins


UNSAID = [
    (",5,7\n0.5,10,90\n", {"occurrence": "percent", "period": "Tp"}, "scatter"),
    ("Hs \\ T,5,7\n0.5,10,90\n", {"occurrence": "percent"}, "scatter"),
    ("Hs \\ Tp,5,7\n0.5,10,90\n", {}, "occurrence"),
    ("hs,tp,occurrence\n1,5,100\n", {}, "occurrence"),
    (",5,7\n0.5,10,90\n", {"layout": "matrix", "occurrence": "percent"}, "period"),
    ("Hs \\ Tp [s],5,7\n0.5,10,90\n", {"occurrence": "percent", "period": "Tz"}, "period"),
    ("hs,tp,percent\n1,5,100\n", {"occurrence": "counts"}, "occurrence"),
    ("Hs \\ Tp, %,5,7\n0.5,10,90\n", {"period": "peak"}, "period"),
]


@pytest.mark.parametrize(("text", "said", "field"), UNSAID)
def test_nothing_is_guessed(tmp_path, text, said, field):
    with pytest.raises(gy.InputError) as caught:
        read(tmp_path, text, **said)
    assert caught.value.field == field and caught.value.mend


HEAD = "hs [m],tp [s],hours\n"
REFUSED = {
    "four columns": ("hs [m],tp [s],heading [deg],hours\n1,5,0,100\n", "does not name three columns"),
    "two columns": ("hs [m],tp [s]\n1,5\n", "does not name three columns"),
    "negative": (HEAD + "1,5,100\n2,6,-3\n", "line 3, column 3"),
    "not a number": (HEAD + "1,5,100\n2,6,NaN\n", "line 3, column 3"),
    "infinite": (HEAD + "1,5,inf\n", "line 2, column 3"),
    "a word": (HEAD + "1,5,often\n", "line 2, column 3"),
    "missing": (HEAD + "1,5,100\n2,6,\n", "line 3, column 3"),
    "missing height": (HEAD + ",5,100\n", "line 2, column 1"),
    "a cell too few": (HEAD + "1,5,100\n2,6\n", "line 3"),
    "the same sea twice": (HEAD + "1,5,100\n2,6,3\n1.0,5.0,4\n", "line 4 has the sea state of line 2"),
    "more hours than a year": (HEAD + "1,5,8000\n2,6,8000\n", "sum of the table"),
    "percent that are parts": ("hs,tp,percent\n1,5,0.6\n2,6,0.4\n", "sum of the table"),
    "parts that are percent": ("hs,tp,fraction\n1,5,60\n2,6,40\n", "sum of the table"),
    "percent beyond rounding": ("hs,tp,percent\n1,5,60\n2,6,41\n", "sum of the table"),
    "nothing ever": (HEAD + "1,5,0\n2,6,0\n", "no sea state occurs"),
    "feet": ("hs [ft],tp [s],hours\n1,5,100\n", "unit of Hs"),
    "hertz": ("hs [m],tp [Hz],hours\n1,5,100\n", "unit of Tp"),
    "centimetres": (HEAD + "150,5,100\n", "line 2, column 1"),
    "milliseconds": (HEAD + "1,5000,100\n", "line 2, column 2"),
    "no period": (HEAD + "1,0,100\n", "a period of waves"),
    "negative height": (HEAD + "-1,5,100\n", "line 2, column 1"),
    "underscore": (HEAD + "1,5,1_0\n", "line 2, column 3"),
    "thousands": ('hs,tp,hours\n1,5,"1,000"\n', "line 2, column 3"),
    "both decimal signs": ("hs;tp;hours\n1,5;5.5;100\n", "decimal commas and decimal points"),
    "bins that overlap": ("Hs [m] \\ Tp [s] \\ %,4-6,5-8\n1,50,50\n", "overlaps"),
    "bins that repeat": ("Hs [m] \\ Tp [s] \\ %,5,5\n1,50,50\n", "repeats"),
    "ranges and middles": ("Hs [m] \\ Tp [s] \\ %,4-6,7\n1,50,50\n", "no range"),
    "a range backwards": ("Hs [m] \\ Tp [s] \\ %,6-4,7-8\n1,50,50\n", "no range"),
    "a row too long": ("Hs [m] \\ Tp [s] \\ %,5,7\n1,50,50,3\n", "line 2"),
    "a wrong sum of a row": ("Hs [m] \\ Tp [s] \\ %,5,7,sum\n1,50,30,80\n2,10,10,25\n", "sum of line 3"),
    "a wrong sum of a column": ("Hs [m] \\ Tp [s] \\ %,5,7\n1,50,30\n2,10,10\nsum,60,50\n", "sum of column 3"),
    "empty": ("", "0 lines"),
    "headings alone": (HEAD, "1 lines"),
}


@pytest.mark.parametrize(("text", "words"), REFUSED.values(), ids=list(REFUSED))
def test_bad_cells_are_refused_by_place(tmp_path, text, words):
    with pytest.raises(gy.InputError) as caught:
        read(tmp_path, text)
    assert words in str(caught.value) and caught.value.mend
    assert "\n" not in str(caught.value)


def test_what_is_not_in_the_table_is_said(tmp_path):
    found = read(tmp_path, "hs,tp,percent\n1,5,60\n2,6,27.7\n")
    assert found.missing == pytest.approx(0.123) and [one.share for one in found.bins] == pytest.approx([0.6, 0.277])
    assert any("12.3 %" in note for note in found.notes)
    calendar = read(tmp_path, "hs,tp,hours\n1,5,4000\n2,6,4760\n")
    assert calendar.missing == 0.0 and sum(one.share for one in calendar.bins) == pytest.approx(1.0)
    assert any("8760" in note for note in calendar.notes)
    rounded = read(tmp_path, "hs,tp,percent\n1,5,60.2\n2,6,40\n")
    assert sum(one.share for one in rounded.bins) == pytest.approx(1.0) and any(
        "100.2" in note for note in rounded.notes
    )
    blanks = read(tmp_path, "Hs [m] \\ Tp [s] \\ %,5,7\n1,50,\n2,,50\n")
    assert len(blanks.bins) == 2 and any("2 empty cells" in note for note in blanks.notes)


def test_periods_of_the_pierson_moskowitz_spectrum_are_those_of_its_moments():
    # m_n / m_0 of x^-5 exp(-5/4 x^-4) is (5/4)^(n/4) gamma(1 - n/4)
    def moment(n: int) -> float:
        return 1.25 ** (n / 4.0) * math.gamma(1.0 - n / 4.0)

    assert over_peak_period("Te", 1.0) == pytest.approx(moment(-1), rel=1e-7)
    assert over_peak_period("T1", 1.0) == pytest.approx(1.0 / moment(1), rel=1e-6)
    assert over_peak_period("Tz", 1.0) == pytest.approx(moment(2) ** -0.5, rel=1e-5)
    assert over_peak_period("Tp", 3.3) == 1.0
    assert over_peak_period("Te", 3.3) == pytest.approx(0.9034, abs=2e-4)  # as tables of JONSWAP have it, 0.903
    assert over_peak_period("Tz", 3.3) == pytest.approx(0.777, abs=1e-3)


@pytest.mark.parametrize(("name", "seas", "kind"), [("north_sea", 5, "Tp"), ("north_atlantic", 197, "Tz")])
def test_published_tables_are_read(name, seas, kind):
    from pathlib import Path

    found = read_scatter(Path(__file__).parents[1] / "docs" / "examples" / f"scatter_{name}.csv")
    assert len(found.bins) == seas and found.kind == kind and any("source" in note for note in found.notes)


@pytest.mark.parametrize("told", ["sep=;", '"sep=;"', "sep=;,,", "SEP=;"])
def test_a_line_that_names_another_sign_than_the_table_has_is_refused(tmp_path, told):
    with pytest.raises(gy.InputError, match="no line of the table has one") as caught:
        read(tmp_path, f"{told}\nHs [m],Tp [s],hours\n1,5,100\n2,6,200\n")
    assert caught.value.value == ";"
    assert len(read(tmp_path, f"{told}\nHs [m];Tp [s];hours\n1;5;100\n2;6;200\n").bins) == 2


def test_a_table_that_is_cut_in_its_last_number_is_told(tmp_path):
    whole = "Hs [m],Tp [s],hours\n1,5,100.25\n2,6,200.50\n3,7,300.75"
    for text, said in ((whole + "\n", 0), (whole, 0), (whole[:-1], 1), (whole[:-3], 1), (whole[:-1] + "\n", 0)):
        assert sum("is it cut?" in note for note in read(tmp_path, text).notes) == said, text
