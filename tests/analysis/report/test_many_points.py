"""Large sessions: figures and tables stay such that a browser opens them."""

from itertools import pairwise

from analysis.report.figures.drawing import MOST_POINTS, thinned, thinned_words
from analysis.report.html import MANY, page
from analysis.report.sections import Section
from analysis.report.tables.cells import Cell, Table


def test_thinned_points_are_bounded_even_and_told() -> None:
    for count in (1, MOST_POINTS, MOST_POINTS + 1, 7999):
        found = thinned(range(count))
        assert len(found) <= MOST_POINTS
        assert len({b - a for a, b in pairwise(found)}) <= 1
        assert bool(thinned_words(len(found), count)) == (count > MOST_POINTS)


def test_a_long_table_is_folded_and_whole() -> None:
    for rows in (MANY, MANY + 1):
        table = Table("Rows", "", ("n",), tuple((Cell(str(n), n),) for n in range(rows)))
        text = page("t", [], [Section("s", (), (), (table,))])
        assert text.count("<tr><td") == rows
        assert ("<details>" in text) == (rows > MANY)
