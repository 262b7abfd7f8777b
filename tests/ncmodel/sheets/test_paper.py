"""Paper as a caller writes it."""

import pytest

from ncmodel.errors import ArgumentError
from ncmodel.sheets.paper import Paper, length, paper_of, ratio


@pytest.mark.parametrize(
    ("page", "margin", "paper"),
    [
        ("A4", "10mm", Paper(210.0, 297.0, 10.0)),
        ("a3-landscape", "0mm", Paper(420.0, 297.0, 0.0)),
        ("letter", "0.5in", Paper(215.9, 279.4, 12.7)),
        ("200x150mm", "1cm", Paper(200.0, 150.0, 10.0)),
        ("8.5x11in", "36pt", Paper(215.9, 279.4, 12.7)),
    ],
)
def test_papers(page: str, margin: str, paper: Paper) -> None:
    found = paper_of(page, margin)
    assert (found.width, found.height, found.margin) == pytest.approx((paper.width, paper.height, paper.margin))


def test_what_is_inside_the_margins() -> None:
    assert Paper(210.0, 297.0, 10.0).inside == (190.0, 277.0)
    assert length("margin", "96px") == pytest.approx(25.4)


@pytest.mark.parametrize(("text", "value"), [("1:2", 0.5), ("5:1", 5.0), ("1:2.5", 0.4)])
def test_scales(text: str, value: float) -> None:
    assert ratio(text) == value


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: paper_of("A9"), "page: found 'A9', expected A0, .*, or 200x300mm"),
        (lambda: paper_of("0x10mm"), "page: found 0 x 10 mm, expected sides of up to 5000 mm"),
        (lambda: paper_of("200x300"), "page: found '200x300'"),
        (lambda: paper_of("A4", "10"), "margin: found '10', expected a number and a unit of mm, cm, in, pt, px"),
        (lambda: paper_of("A4", "-1mm"), "margin: found '-1mm'"),
        (lambda: paper_of("A6", "60mm"), "margin: found 60 mm on a page of 105 x 148 mm, expected less than half"),
        (lambda: ratio("2"), "scale: found '2', expected paper:shape, as 1:2"),
        (lambda: ratio("1:0"), "scale: found '1:0'"),
        (lambda: ratio("0:1"), "scale: found '0:1'"),
    ],
)
def test_what_is_no_paper_is_told(call: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        call()  # type: ignore[operator]
