"""Findings of the check, and their cells."""

from __future__ import annotations

import keyword

import pytest
from play import check, findings, rows

from rrp_sheets.model.names import argument_name, is_reserved

ON = "| On | Input streams | Connector | Formula | Output stream |\n|---|---|---|---|---|\n"
OUT = "| X | subscribe | | Print |"

WRONG = [
    # rows, the expected findings
    ("| Red bal | map | 1 | X |\n" + OUT, [("GRAPH001", "A2")]),
    ("| Red ball | mapp | 1 | X |\n" + OUT, [("CONN002", "B2")]),
    ("| Red ball | | 1 | X |\n" + OUT, [("CONN001", "B2")]),
    ("| Red ball | map | | X |\n" + OUT, [("CONN005", "C2")]),
    ("| Red ball | filter | | X |\n" + OUT, [("CONN005", "C2")]),
    ("| Red ball | sample | | X |\n" + OUT, [("CONN007", "C2")]),
    ("| Red ball | sample | often | X |\n" + OUT, [("CONN008", "C2")]),
    ("| Red ball | sample | 3 | X |\n" + OUT, [("CONN010", "C2")]),
    ("| Red ball | sample | 0 | X |\n" + OUT, [("CONN008", "C2")]),
    ("| Red ball | timestamp | 5 | X |\n" + OUT, [("CONN006", "C2")]),
    ("| Red ball | merge | | X |\n" + OUT, [("CONN003", "A2")]),
    ("| Red ball, Head yaw | sample | 1 s | X |\n" + OUT, [("CONN004", "A2")]),
    ("| | map | 1 | X |\n" + OUT, [("GRAPH003", "A2")]),
    ("| Red ball | map | 1 | |\n| Red ball | subscribe | | Print |", [("GRAPH004", "D2")]),
    ("| Red ball | subscribe | | |", [("GRAPH005", "D2")]),
    ("| Red ball | subscribe | | Tell |", [("GRAPH006", "D2")]),
    ("| Red ball | subscribe | | Blue ball |", [("GRAPH006", "D2")]),
    ("| Red ball | map | 1 | Say |", [("GRAPH007", "D2")]),
    ("| Red ball | map | 1 | Say |\n| Red ball | subscribe | | Near |", [("GRAPH007", "D2")]),
    ("| Say | subscribe | | Print |", [("GRAPH009", "A2")]),
    ("| Red ball | map | 1 | X |\n| Ball | map | 2 | X |\n" + OUT, [("GRAPH002", "D3")]),
    ("| B | map | b | A |\n| A | map | a | B |\n| A | subscribe | | Print |", [("GRAPH010", "D2")]),
    ("| X | map | x | X |\n" + OUT, [("GRAPH010", "D2")]),
    ("| Red ball | map | 1 | X |\n| Red ball | subscribe | | Print |", [("GRAPH011", "D2")]),
    ("| Red ball | map | 1 | X, Y |\n| X | subscribe | | Print |", [("GRAPH013", "D2")]),
    ("| Red ball | map | 1 | ?? |\n| ?? | subscribe | | Print |", [("GRAPH013", "D2")]),
    ("| Red ball | map | 1 | In |\n| In | map | in + 1 | X |\n" + OUT, [("GRAPH018", "D2")]),
    ("| Red ball | map | redBall.distence | X |\n" + OUT, [("FORM007", "C2")]),
    ("| Red ball | map | redBal.distance | X |\n" + OUT, [("FORM004", "C2")]),
    ("| Red ball | map | sqr(4) | X |\n" + OUT, [("FORM005", "C2")]),
    ("| Red ball | map | sqrt() | X |\n" + OUT, [("FORM006", "C2")]),
    ("| Red ball | map | (1 | X |\n" + OUT, [("FORM001", "C2")]),
    ("| Red ball | map | redBall.__class__ | X |\n" + OUT, [("FORM003", "C2")]),
    ("| Red ball | subscribe | | Say parameter |", [("DEV008", "D2")]),
    ("| Red ball, red_ball | combineLatest | 1 | X |\n" + OUT, [("CONN009", "A2")]),
    (
        "| Ball (a), Ball [a] | combineLatest | 1 | X |\n| Ball | map | 1 | Ball (a) |\n| Ball | map | 2 | Ball [a] |\n"
        + OUT,
        [("FORM009", "C2")],
    ),
    ("| Red ball; Green ball | merge | | X |\n" + OUT, [("GRAPH001", "A2"), ("CONN003", "A2")][:1]),
    ("| Red ball | sample | " + "9" * 400 + " | X |\n" + OUT, [("CONN008", "C2")]),
]


@pytest.mark.slow
@pytest.mark.parametrize(("text", "expected"), WRONG)
def test_one_mistake_one_finding_at_its_cell(text, expected):
    assert findings(rows(text)) == expected


@pytest.mark.slow
@pytest.mark.parametrize(
    "word", sorted({*keyword.kwlist, *keyword.softkwlist, "blank", "null", "xor", "value", "pi"} - {"_"})
)
def test_every_name_can_be_used_or_says_what_to_do(word):
    """A name is refused where it stands, or a formula can use it as it is or as the remedy writes it."""
    text = f"| Red ball | map | redBall.distance | {word} |\n| {word} | filter | {word} > 1 | X |\n"
    report = check(rows(text + OUT)).report
    if is_reserved(word):
        assert report.flatten(["code", "cell"]) == [("GRAPH018", "D2")]
        return
    for finding in report.errors:
        assert finding.address.cell == "C3" and finding.remedy == f"Write {argument_name(word)} for “{word}”."
        again = f"| Red ball | map | redBall.distance | {word} |\n| {word} | filter | {argument_name(word)} > 1 | X |\n"
        assert findings(rows(again + OUT)) == []


@pytest.mark.parametrize(("sheet", "cell"), [
    ("## Devices\n| Stream | Device |\n|---|---|\n| Not | Operator button |\n", "A2"),
    ("## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| Far | in | 1 |\n", "B2"),
    ("## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| Blank | x | x + 1 |\n", "A2"),
])  # fmt: skip
def test_words_of_formulas_name_no_device_and_no_helper(sheet, cell):
    assert ("GRAPH018", cell) in findings(rows("| Red ball | map | redBall.distance | X |\n" + OUT) + "\n" + sheet)


def test_a_row_with_too_many_cells_is_told_once():
    assert findings(rows("| Red ball | map | a | b | X |\n| Red ball | subscribe | | Print |")) == [("SHEET017", "E2")]


@pytest.mark.parametrize("connector", ["subscibe", ""])
@pytest.mark.parametrize("name", ["挨拶", "Greeting"])
def test_rows_that_depend_on_an_unknown_connector_are_not_told(connector, name):
    text = f'| Red ball | {connector} | "a" | {name} |\n| Red ball | subscribe | "b" | {name} |\n| {name} done | subscribe | | Print |'
    assert [code for code, _ in findings(rows(text))] == ["CONN002" if connector else "CONN001"]
    assert ("GRAPH006", "D2") in findings(rows(text.replace(f"| {connector} |", "| subscribe |", 1)))


def test_everything_is_reported_at_once():
    text = "| Red bal | map | 1 | X |\n| X | mapp | 1 | Y |\n| Y | subscribe | | Tell |"
    assert [code for code, _ in findings(rows(text))] == ["GRAPH001", "CONN002", "GRAPH006"]


LOST = "| Red ball | map | 1 | Say |\n"  # nothing is given under a name of its own


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("| Green | map | 1 | Say |", [("GRAPH001", "A2"), ("GRAPH007", "D2")]),
        ("| Green | map | 1 | X |\n" + OUT + "\n" + LOST, [("GRAPH001", "A2"), ("GRAPH007", "D4")]),
        (LOST + "| Red bal | map | 1 | X |\n" + OUT, [("GRAPH007", "D2"), ("GRAPH001", "A3")]),
        (LOST + "| Green, Grey | merge | | X |\n" + OUT, [("GRAPH007", "D2"), ("GRAPH001", "A3"), ("GRAPH001", "A3")]),
        # what was meant to be given there
        (LOST + "| Side | subscribe | | Print |", [("GRAPH007", "D2")]),
        (LOST + "| Side | map | 2 | X |\n" + OUT + "\n| Side | subscribe | | Print |", [("GRAPH007", "D2")]),
        # names that are alike on purpose
        (
            "| Red ball | map | 1 | Step 1 |\n| Step 1 | map | 2 | |\n| Step 2 | subscribe | | Print |",
            [("GRAPH004", "D3")],
        ),
        (
            "| Red ball | map | 1 | New visitor |\n| New visitor | map | 2 | , |\n| Known visitor | subscribe | | Print |",
            [("GRAPH013", "D3")],
        ),
        (
            "| Red ball | map | 1 | Ball x |\n| Ball x | map | 2 | |\n| Ball y | subscribe | | Print |",
            [("GRAPH004", "D3")],
        ),
        # names above it, which it cannot be meant to give
        (
            "| Green | map | 1 | Ball |\n| Ball | map | 1 | Say |\n| Far ball | subscribe | | Print |",
            [("GRAPH001", "A2"), ("GRAPH007", "D3")],
        ),
    ],
)
def test_an_unknown_input_is_told_beside_a_wrong_output_unless_it_follows_from_it(text, expected):
    assert findings(rows(text)) == expected


def test_a_circle_prints_its_whole_path_with_cells():
    report = check(rows("| C | map | c | A |\n| A | map | a | B |\n| B | map | b | C |")).report
    (finding,) = report.errors
    assert "A (T!D2) → B (T!D3) → C (T!D4) → A (T!D2)" in finding.message


def test_two_producers_name_both_rows_and_propose_merge():
    report = check(rows("| Red ball | map | 1 | X |\n| Ball | map | 2 | X |\n" + OUT)).report
    (finding,) = report.errors
    assert "T!D2" in finding.message and "T!D3" in finding.message and "merge" in finding.remedy


@pytest.mark.parametrize(
    ("text", "guess"),
    [
        ("| Red bal | subscribe | | Print |", "Red ball"),
        ("| Red ball | subscrib | | Print |", "subscribe"),
        ("| Red ball | subscribe | | Head trackr |", "Head tracker"),
        ("| Red ball | filter | redBal.distance < 1 | X |\n| X | subscribe | | Print |", "redBall"),
        ("| Red ball | subscribe | redBall.distence | Print |", "distance"),
        ("| Red ball | map | redBall.distance | Distance |\n| Distnce | subscribe | | Print |", "Distance"),
    ],
)
def test_the_nearest_name_is_proposed(text, guess):
    (finding,) = check(rows(text)).report.errors
    assert f"Did you mean {guess}?" in finding.remedy


def test_a_row_that_is_off_may_be_wrong():
    text = "| no | Red bal | mapp | ( | X |\n| | Red ball | subscribe | | Print |"
    assert findings(rows(text, header=ON)) == []


def test_streams_fed_only_by_off_rows_are_inactive_and_no_error():
    checked = check(rows(
        "| no | Red ball | map | 1 | X |\n| | X | subscribe | | Print |\n| | Red ball | subscribe | | Print |", header=ON
    ))  # fmt: skip
    assert checked.report.flatten(["code"]) == []
    assert [s.active for s in checked.graph.behaviours[0].steps] == [False, False, True]


def test_a_switched_off_producer_leaves_its_name_to_another_row():
    text = "| no | Red ball | map | 1 | X |\n| | Ball | map | 2 | X |\n| | X | subscribe | | Print |"
    assert findings(rows(text, header=ON)) == []


def test_a_row_whose_taker_is_off_is_no_error():
    assert findings(rows("| | Head yaw | map | 1 | |\n| no | | subscribe | | Print |", header=ON)) == []


def test_a_chain_of_timestamps_is_bounded():
    lines = ["| Head yaw | timestamp | | |", *["| | timestamp | | |"] * 10, "| | subscribe | | Print |"]
    assert findings(rows("\n".join(lines))) == [("GRAPH015", "B12")]


def test_a_behaviour_with_every_row_off_is_a_warning():
    assert findings(rows("| no | Red ball | subscribe | | Print |", header=ON)) == [("GRAPH014", "B1")]


DEVICES = "## Devices\n| Stream | Device | Joint | Text | Rate |\n|---|---|---|---|---|\n"


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("| Neck | JointPosition | HeadYaw | | |", []),
        ("| Neck | JointPosition | Head yaw | | |", []),
        ("| Neck | JointPosition | Nose | | |", [("DEV004", "C2")]),
        ("| Neck | JointPosition | | | |", [("DEV003", "C2")]),
        ("| Neck | Jointposition | HeadYaw | hello | |", [("DEV007", "D2")]),
        ("| Neck | JointPositon | HeadYaw | | |", [("DEV001", "B2")]),
        ("| Neck | | HeadYaw | | |", [("DEV006", "B2")]),
        ("| | JointPosition | HeadYaw | | |", [("DEV005", "A2")]),
        ("| Neck | JointPosition | HeadYaw | | 1000 |", [("DEV004", "E2")]),
        ("| Neck | JointPosition | HeadYaw | | fast |", [("DEV004", "E2")]),
    ],
)
def test_devices(line, expected):
    reader = "| Neck | subscribe | | Print |" if line.startswith("| Neck") else "| Ball | subscribe | | Print |"
    found = findings(rows(reader, DEVICES + line))
    assert found == expected


def test_a_declared_sensor_as_output():
    book = rows(
        "| Red ball | map | redBall.x | Neck |\n| Neck | subscribe | | Print |",
        DEVICES + "| Neck | JointPosition | HeadYaw | | |",
    )
    assert ("GRAPH008", "D2") in findings(book)


def test_a_device_declared_twice():
    book = rows("| Neck | subscribe | | Print |", DEVICES + "| Neck | JointPosition | HeadYaw | | |\n"
                "| neck | JointPosition | HeadPitch | | |")  # fmt: skip
    assert findings(book) == [("DEV002", "A3")]


HELPERS = "## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lines", "use", "expected"),
    [
        ("| Twice | x | 2 * x |", "twice(redBall.x)", []),
        ("| Twice | x | 2 * y |", "twice(redBall.x)", [("FORM004", "C2")]),
        ("| Twice | x | |", "twice(redBall.x)", [("FORM015", "C2")]),
        ("| | x | 2 * x |", "1", [("FORM016", "A2")]),
        ("| Twice | x | 2 * x |\n| twice | x | 3 * x |", "1", [("FORM013", "A3")]),
        ("| Sqrt | x | 2 * x |", "sqrt(4)", [("FORM012", "A2")]),
        ("| Both | x, y | x + y |", "Both", [("FORM014", "C2")]),
        ("| A | x | b(x) |\n| B | x | a(x) |", "1", [("FORM011", "C2")]),
        ("| A | x | b(x) |\n| B | x | c(x) |\n| C | x | b(x) + a(x) |", "1", [("FORM011", "C2")]),
        (
            "| Limit | | nope |\n| Near | x | x < limit |\n| Far | x | not near(x) |",
            "far(redBall.x)",
            [("FORM004", "C2")],
        ),
    ],
)
def test_helpers(lines, use, expected):
    found = check(rows(f"| Red ball | map | {use} | X |\n{OUT}", HELPERS + lines)).report
    assert found.flatten(["code", "cell"]) == expected


def test_a_circle_of_helpers_prints_the_whole_circle():
    report = check(rows("| Red ball | subscribe | | Print |", HELPERS + "| A | x | b(x) |\n| B | x | a(x) |")).report
    assert "a (C2) → b (C3) → a (C2)" in report.errors[0].message


def _helpers_in_a_row(count, call="{next}(x) + 1"):
    lines = [f"| h{i} | x | {call.format(next=f'h{i + 1}')} |" for i in range(count - 1)]
    return HELPERS + "\n".join([*lines, f"| h{count - 1} | x | x |"])


@pytest.mark.parametrize("call", ["{next}(x) + 1", "{next}(x) + {next}(x)"])
def test_helpers_that_call_each_other_too_deep_are_told_once(call):
    row = f"| Red ball | map | h0(redBall.x) | X |\n{OUT}"
    report = check(rows(row, _helpers_in_a_row(300, call))).report
    assert report.flatten(["code", "cell"]) == [("FORM025", "C281")]
    assert "h279 (C281) → h280 (C282) → h281 (C283) → … → h299 (C301)" in report.errors[0].message
    assert check(rows(row, _helpers_in_a_row(20))).report.flatten(["code"]) == []


def test_long_formulas_in_many_helpers_are_reasoned_about_within_bounds():
    nested = "-(" * 24 + "{next}(x)" + ")" * 24
    row = f"| Red ball | filter | h0(redBall.x) < 1 | Y |\n| Y | map | h0(y.x) | X |\n{OUT}"
    report = check(rows(row, _helpers_in_a_row(20, nested))).report
    # whether the example can be worked out depends on how deep this process may go, which long chains of rows raise
    assert report.flatten(["code", "cell"]) in ([], [("LINT010", "C2")])
    assert all("nested too deeply" in d.message for d in report)


def test_a_helper_above_a_circle_of_helpers():
    helpers = HELPERS + "| A | x | b(x) |\n| B | x | 1 - c(x) - c(x) |\n| C | x | b(x) + b(x) |"
    report = check(rows(f"| Red ball | map | a(redBall.x) | X |\n{OUT}", helpers)).report
    assert [d.code for d in report.errors] == ["FORM011"]


PROTOCOL = "## Protocol\n| Field | Value |\n|---|---|\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("| Robot | NAO |", []),
        ("| Robot | peper |", [("PROT001", "B2")]),
        ("| Engine | warp |", [("PROT002", "B2")]),
        ("| Frame rate | 30 Hz |", []),
        ("| Frame rate | 50 |", [("PROT003", "B2")]),
        ("| Run | Tx |", [("PROT004", "B2")]),
        ("| Run | t |", []),
        ("| Seed | abc |", [("PROT005", "B2")]),
        ("| Time limit | soon |", [("PROT006", "B2")]),
        ("| Face memory | a week |", [("PROT007", "B2")]),
        ("| Language | Klingon |", [("PROT008", "B2")]),
        ("| Camera pictures | sometimes |", [("PROT009", "B2")]),
        ("| Camera pictures | Not kept |", []),
        ("| Data kept | Every value; no picture |", [("PROT010", "B2")]),
        ("| Data kept | Nothing |", [("PROT010", "B2")]),
        ("| Data kept | Values, camera images, and a film |", []),
        ("| Data kept | 値、カメラの画像、動画 |", []),
        ("| Data kept | 値と動画。画像は保存しません |", [("PROT010", "B2")]),
        ("| Data kept | Alle Messwerte |", []),
        ("| Language | 日本語 |", []),
        ("| Face memory | Kept |", []),
        ("| Time limit | 10 min |", []),
        ("| Favourite colour | blue |", []),
    ],
)
def test_protocol(line, expected):
    assert findings(rows("| Red ball | subscribe | | Print |", PROTOCOL + line)) == expected


@pytest.mark.parametrize(
    "text",
    [
        "| Red ball | mapp | 1 | |\n| | subscribe | | Print |",
        "| Red ball | map | 1 | |\n| Red ball | subscribe | | Print |",
        "| Red ball | map | 1 | Say |\n| | subscribe | | Print |",
        "| B | map | b | A |\n| A | map | a | B |\n| A | subscribe | | Print |",
        "| Red ball | sample | fast | X |\n| X | forgetAfter | | Y |\n| Y | subscribe | | Print |",
        "| Red ball | timestamp | 5 | X |\n| X | merge | | Y |\n| Y | subscribe | ( | Print |",
    ],
)
def test_a_wrong_workbook_can_still_be_drawn_and_explained(text, tmp_path):
    from rrp_sheets.render.output import draw, explain

    checked = check(rows(text))
    assert checked.report.errors
    draw(checked, tmp_path / "d.svg")
    assert explain(checked)


def test_a_setting_that_is_none_is_named_as_its_header_is_spelt():
    (found,) = list(check(rows("| Red ball | subscribe | | Head tracker |",
                               "## Devices\n| Stream | Device | Shoe size |\n|---|---|---|\n| Red ball | Red ball | 41 |\n")).report)  # fmt: skip
    assert found.code == "DEV007" and "“Shoe size”" in found.message
