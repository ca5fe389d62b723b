from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simtip.errors import InputError
from simtip.target import AsymmetricCircles, Charuco, Chessboard, CircleGrid, parse_target


@pytest.mark.parametrize(
    ("text", "target"),
    [
        ("chessboard:11x8:6", Chessboard(11, 8, 6.0)),
        (" Chessboard:9X6:25.4 ", Chessboard(9, 6, 25.4)),
        ("charuco:12x8:6:4.5", Charuco(12, 8, 6.0, 4.5)),
        ("charuco:12x9:6:4.5:dict_4x4_100", Charuco(12, 9, 6.0, 4.5, "DICT_4X4_100")),
        ("circles:11x8:6:3", CircleGrid(11, 8, 6.0, 3.0)),
        ("asymmetric:4x11:6:7", AsymmetricCircles(4, 11, 6.0, 7.0)),
    ],
)
def test_text_to_target(text: str, target: object):
    assert parse_target(text) == target
    assert parse_target(str(parse_target(text))) == target


@given(st.integers(2, 200), st.integers(2, 200), st.floats(1e-3, 1e4))
@settings(derandomize=True, deadline=None, max_examples=40)
def test_text_keeps_the_target(columns: int, rows: int, size_mm: float):
    for target in (
        Chessboard(columns, rows, size_mm),
        CircleGrid(columns, rows, size_mm, size_mm / 2),
        AsymmetricCircles(columns, rows, size_mm, size_mm / 2),
    ):
        back = parse_target(str(target))
        assert type(back) is type(target)
        assert str(back) == str(target)
        assert back.pitch_mm == pytest.approx(target.pitch_mm, rel=1e-11)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "no family"),
        ("checkers:11x8:6", "no family of targets is called 'checkers'"),
        ("chessboard:11x8", "1 parts"),
        ("chessboard:11x8:6:3", "3 parts"),
        ("chessboard:11:6", "'11' is no COLUMNSxROWS"),
        ("chessboard:11x8:six", "'six' is no length"),
        ("chessboard:11x8:nan", "'nan' is no length"),
        ("chessboard:11x8:1e999", "up to 10000 mm, not inf"),
        ("chessboard:11x8:-6", "above 0 and up to 10000 mm, not -6"),
        ("chessboard:1x8:6", "2 to 200 columns, not 1"),
        ("chessboard:11x201:6", "2 to 200 rows, not 201"),
        ("charuco:12x9:6", "2 parts"),
        ("charuco:12x9:6:4.5", "need 54 markers, DICT_4X4_50 has 50"),
        ("charuco:5x5:4.5:6", "does not fit"),
        ("charuco:5x5:6:6", "does not fit"),
        ("charuco:5x5:6:4:DICT_9X9", "no dictionary 'DICT_9X9'"),
        ("charuco:2x2:6:4", "a single corner"),
        ("circles:11x8:3:6", "touch"),
        ("circles:11x8:6:6", "touch"),
        ("asymmetric:4x11:6:8.5", "touch"),
    ],
)
def test_a_wrong_text_is_told_in_one_line(text: str, told: str):
    with pytest.raises(InputError) as caught:
        parse_target(text)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("target")


def test_chessboard_alone_is_the_papers():
    assert parse_target("chessboard") == Chessboard(11, 8, 6.0)
