"""Fixes: each, applied, silences its finding and leaves the check clean."""

from __future__ import annotations

import json
import re
from hashlib import sha256
from itertools import pairwise

import openpyxl
import pytest
from panel import HEADER
from play import check, rows
from test_run import rrp
from typed import run

from rrp_sheets import api
from rrp_sheets.diagnostics.report import Replace
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import Address
from rrp_sheets.resources import bundled

COLUMNS = "| On | Input streams | Connector | Formula | Output stream |\n|---|---|---|---|---|\n"
JAPANESE = "| 有効 | 入力 | コネクター | 式 | 出力 |\n|---|---|---|---|---|\n"
PRINT = "\n| | X | subscribe | | Print |"
DEVICES = "## Devices\n| Stream | Device | Joint |\n|---|---|---|\n"


def fixed(text: str, tmp_path, *apply: str, suffix: str = ".md", more: str = "", header: str = COLUMNS):
    """The changes and what the check of the corrected copy says; the original is as it was."""
    source = tmp_path / "source.md"
    source.write_text(rows(text, more, header=header), encoding="utf-8")
    before = sha256(source.read_bytes()).hexdigest()
    chosen = dict(a.split(":") for a in apply)
    changes, checked = api.fix(source, tmp_path / f"out{suffix}", chosen)
    assert sha256(source.read_bytes()).hexdigest() == before
    return changes, checked.report.flatten(["code", "cell"])


SAFE = [
    # the row, the place that changes, the new text of the cell
    ("| | Red ball | flter | redBall.x < 1 | X |" + PRINT, "T!C2", "filter"),
    ("| | Red bal | filter | value.x < 1 | X |" + PRINT, "T!B2", "Red ball"),
    ("| | Red ball, Gren ball | merge | | X |" + PRINT, "T!B2", "Red ball, Green ball"),
    ("| | Red ball | map | redBall.distence * 2 | X |" + PRINT, "T!D2", "redBall.distance * 2"),
    ("| | Red ball | map | abs(redBal.x) | X |" + PRINT, "T!D2", "abs(redBall.x)"),
    ("| | Red ball | map | SQRRT(redBall.x) | X |" + PRINT, "T!D2", "SQRT(redBall.x)"),
    ("| | Red ball | filter | redBall.x < 1,5 | X |" + PRINT, "T!D2", "redBall.x < 1.5"),
    ("| | Red ball | sample | 3 | X |" + PRINT, "T!D2", "3 s"),
    ("| | Red ball | sample | 0,5 s | X |" + PRINT, "T!D2", "0.5 s"),
    ("| | Red ball | map | redBall.x | X |\n| | X | subscribe | | Eye brightnes |", "T!E3", "Eye brightness"),
    ('| | Red ball | map | "redBal" & redBal.colour | X |' + PRINT, "T!D2", '"redBal" & redBall.colour'),
]


@pytest.mark.parametrize("suffix", [".md", ".xlsx"])
@pytest.mark.parametrize(("text", "place", "new"), SAFE)
def test_a_safe_fix_is_applied_and_the_check_is_clean(text, place, new, suffix, tmp_path):
    changes, found = fixed(text, tmp_path, suffix=suffix)
    assert [(c.place, c.new) for c in changes] == [(place, new)]
    assert found == []


def test_several_fixes_in_one_cell_and_one_sheet(tmp_path):
    text = (
        "| | Red bal, Gren ball | mrge | | X |\n| | X | filter | x.distence < 1,5 | Y |\n| | Y | subscribe | | Prnt |"
    )
    changes, found = fixed(text, tmp_path)
    assert found == [] and {c.place for c in changes} == {"T!B2", "T!C2", "T!D3", "T!E4"}


def test_a_setting_that_a_device_lacks_leads_to_the_device_that_has_it(tmp_path):
    text, devices = (
        "| | Red ball | subscribe | | Praise |",
        DEVICES.replace("Joint", "Text") + "| Praise | Say | Hello |",
    )
    changes, found = fixed(text, tmp_path, more=devices)
    assert changes == [] and found[0] == ("DEV007", "C2")  # it may as well be the text that is too much
    changes, found = fixed(text, tmp_path, "DEV007:use-say-parameter", more=devices)
    assert "DEV007" not in dict(found) and [(c.place, c.new) for c in changes] == [("Devices!B2", "Say parameter")]


@pytest.mark.parametrize("suffix", [".md", ".xlsx"])
@pytest.mark.parametrize(
    ("devices", "changed"),
    [
        ("| Stream | Device | Language |\n|---|---|---|\n| Ask | Say | en |\n", {"Devices!C2": "ja"}),
        ("| Stream | Device |\n|---|---|\n| Ask | Say |\n", {"Devices!C1": "Language", "Devices!C2": "ja"}),
        ("| Device | Stream | Notes |\n|---|---|---|\n| Timer | Tick | often |\n",
         {"Devices!D1": "Language", "Devices row 3": "Say | Ask | ja"}),
    ],
)  # fmt: skip
def test_the_language_of_a_voice_is_written_beside_its_stream(devices, changed, suffix, tmp_path):
    says = "Ask" if "Ask" in devices else "Say"
    text = f'| | Chest button | subscribe | "こんにちは" | {says} |\n| | Tick | sample | 1 s | X |{PRINT}'
    text = text if "Tick" in devices else text.replace("Tick", "Red ball")
    changed = {place: new.replace("Ask", says) for place, new in changed.items()}
    changes, found = fixed(text, tmp_path, more=f"## Devices\n{devices}")
    assert changes == [] and found == [("LINT018", "D2")]
    changes, found = fixed(text, tmp_path, "LINT018:other-language", more=f"## Devices\n{devices}", suffix=suffix)
    assert found == [] and {str(c.place): c.new for c in changes} == changed
    lines = (tmp_path / f"out{suffix}").read_text(encoding="utf-8").splitlines() if suffix == ".md" else []
    assert all(line.count("|") == above.count("|") for above, line in pairwise(lines) if line.startswith("|---"))


JOINED = [
    # the row, the fixes that are offered, the chosen one, what is written, a part of the remedy
    ("Red ball, Head yaw | sample | 1 s", ["alone", "merge"], "alone", {"T!B2": "Red ball"}, "“Red ball” alone"),
    ("Red ball, Blue ball | sample | 1 s", ["alone", "merge"], "merge",
     {"T row 2": "Red ball, Blue ball | merge", "T!B3": ""}, "with merge"),
    ("Red ball, Blue ball | changes |", ["merge"], "merge",
     {"T row 2": "Red ball, Blue ball | merge", "T!B3": ""}, "merge passes on"),
    ("Red ball, Head yaw | throttle | redBall.x + headYaw", ["combine"], "combine", {"T!C2": "combineLatest"},
     "combineLatest as"),
]  # fmt: skip


@pytest.mark.parametrize("suffix", [".md", ".xlsx"])
@pytest.mark.parametrize(("row", "offered", "chosen", "written", "told"), JOINED)
def test_too_many_inputs_are_joined_or_the_first_is_taken(row, offered, chosen, written, told, suffix, tmp_path):
    text = f"| | {row} | X |{PRINT}"
    (finding,) = check(rows(text, header=COLUMNS)).report
    assert finding.code == "CONN004" and [fix.id for fix in finding.fixes] == offered and told in finding.remedy
    changes, found = fixed(text, tmp_path, f"CONN004:{chosen}", suffix=suffix)
    assert {str(c.place): c.new for c in changes} == written and not any(
        code[:4] in ("CONN", "FORM") for code, _ in found
    )


LACKING = [
    # the sheet Devices, the row's output, the code with its fix, what is written, what the check says then
    ("| Stream | Device |\n|---|---|\n| Ask | Say parameter |", "Ask", "DEV003:add-column",
     {"Devices!C1": "Text"}, [("DEV003", "C2")]),
    ("| Stream | Device | Notes |\n|---|---|---|\n| Ask | Say parameter | often |\n| Nod | Set joint position | |", "Ask",
     "DEV003:add-column", {"Devices!D1": "Text", "Devices!E1": "Joint"}, [("DEV003", "D2"), ("DEV003", "E3")]),
    ("| ストリーム | デバイス | メモ |\n|---|---|---|\n| Ask | Say parameter | |", "Ask", "DEV003:add-column",
     {"Devices!D1": "せりふ"}, [("DEV003", "D2")]),
    ("| Stream | Device |\n|---|---|\n| Tick | Timer |", "Say parameter", "DEV008:declare",
     {"Devices!C1": "Text", "Devices row 3": "Say parameter | Say parameter"}, [("DEV003", "C3")]),
    ("| Stream | Device | Text |\n|---|---|---|\n| Tick | Timer | |", "Say parameter", "DEV008:declare",
     {"Devices row 3": "Say parameter | Say parameter"}, [("DEV003", "C3")]),
]  # fmt: skip


@pytest.mark.parametrize("suffix", [".md", ".xlsx"])
@pytest.mark.parametrize(("devices", "output", "chosen", "written", "then"), LACKING)
def test_the_column_of_a_setting_that_is_needed_is_added(devices, output, chosen, written, then, suffix, tmp_path):
    text, more = f"| | Red ball | sample | 10 s | Now |\n| | Now | subscribe | | {output} |", f"## Devices\n{devices}\n"
    code, header = chosen.partition(":")[0], COLUMNS if devices.isascii() else JAPANESE
    assert {code for code, _ in fixed(text, tmp_path, more=more, header=header)[1]} == {code}
    missing = [d for d in check(rows(text, more, header=header)).report if d.code == "DEV003"]
    assert all(
        d.remedy.startswith(("Add the column Text", "Add the column Joint", "Add the column せりふ")) for d in missing
    )
    changes, found = fixed(text, tmp_path, chosen, suffix=suffix, more=more, header=header)
    assert {str(c.place): c.new for c in changes} == written and found == then


MOVED = [
    # the sheet Devices, the formula, the output, the title of the fix, what it writes
    ("| Stream | Device |\n|---|---|\n| Wave | Gesture |", "1", "Wave", "Add the column Name and write Wave",
     {"Devices!C1": "Name", "Devices!C2": "Wave"}),
    ("| Stream | Device | Name |\n|---|---|---|\n| Greeting | Gesture | |", '"Wafe"', "Greeting",
     "Write Wave into the column Name", {"Devices!C2": "Wave"}),
    ("| Stream | Device |\n|---|---|\n| Welcome | Gesture |", "1", "Welcome", "Add the column Name",
     {"Devices!C1": "Name"}),
    ("| ストリーム | デバイス |\n|---|---|\n| うなずく | 身ぶり |", "1", "うなずく",
     "Add the column 名前 and write うなずく", {"Devices!C1": "名前", "Devices!C2": "うなずく"}),
    ("| ストリーム | デバイス |\n|---|---|\n| Sit | 姿勢 |", "1", "Sit", "Add the column 名前 and write 座位",
     {"Devices!C1": "名前", "Devices!C2": "座位"}),
]  # fmt: skip


@pytest.mark.parametrize("suffix", [".md", ".xlsx"])
@pytest.mark.parametrize(("devices", "formula", "output", "title", "written"), MOVED)
def test_the_name_of_a_movement_is_filled_in(devices, formula, output, title, written, suffix, tmp_path):
    text, more = f"| | Touch | subscribe | {formula} | {output} |", f"## Devices\n{devices}\n"
    header = COLUMNS if "Stream" in devices else JAPANESE
    (finding,) = check(rows(text, more, header=header)).report
    (fix,) = finding.fixes
    assert (finding.code, str(fix.title)) == ("LINT012", title)
    changes, found = fixed(text, tmp_path, f"LINT012:{fix.id}", suffix=suffix, more=more, header=header)
    assert {str(c.place): c.new for c in changes} == written
    assert found == ([] if len(written) == 2 or "Wave" in title else [("LINT012", "D2")])


NAMED = [
    # the headers, the row, the finding, its remedy, what its fix writes
    (JAPANESE, "| | Timer | subscribe | | 言う |", "GRAPH006", "Did you mean 発話?", {"T!E2": "発話"}),
    (JAPANESE, "| | 触る | subscribe | | Print |", "GRAPH001", "Did you mean 接触?", {"T!B2": "接触"}),
    (JAPANESE, "| | Timer | subscribe | | Sey |", "GRAPH006", "Did you mean Say?", {"T!E2": "Say"}),
    (COLUMNS, "| | Timer | subscribe | | 言う |", "GRAPH006", "Did you mean Say?", {"T!E2": "Say"}),
]  # fmt: skip


@pytest.mark.parametrize("suffix", [".md", ".xlsx"])
@pytest.mark.parametrize(("header", "text", "code", "remedy", "written"), NAMED)
def test_a_device_is_named_in_the_language_of_the_workbook(header, text, code, remedy, written, suffix, tmp_path):
    heads = "| ストリーム | デバイス |" if header == JAPANESE else "| Stream | Device |"
    devices = f"## Devices\n{heads}\n|---|---|\n| Tick | Timer |\n"
    (finding,) = [d for d in check(rows(text, devices, header=header)).report if d.code == code]
    assert str(finding.remedy).startswith(remedy)
    changes, found = fixed(text, tmp_path, f"{code}:correct-spelling", suffix=suffix, more=devices, header=header)
    assert {str(c.place): c.new for c in changes} == written
    assert not [one for one in found if one[0].startswith(("GRAPH00", "DEV0"))]


def test_no_column_is_added_where_there_is_one_or_no_sheet():
    text = "| | Red ball | sample | 10 s | Now |\n| | Now | subscribe | | Say parameter |"
    (bare,) = check(rows(text, "", header=COLUMNS)).report
    devices = "## Devices\n| Stream | Device | Text |\n|---|---|---|\n| Say parameter | Say parameter | |\n"
    (blank,) = check(rows(text, devices, header=COLUMNS)).report
    assert (bare.code, bare.fixes, blank.code, blank.fixes) == ("DEV008", (), "DEV003", ())


def test_texts_of_two_languages_are_left_to_the_user(tmp_path):
    text = (
        '| | Chest button | subscribe | "こんにちは" | Say |\n| | Bumper | subscribe | "Please touch my head" | Say |'
    )
    with pytest.raises(SheetsError, match="No problem here has the fix"):
        fixed(
            text, tmp_path, "LINT018:other-language", more="## Devices\n| Stream | Device |\n|---|---|\n| Say | Say |"
        )


def test_headers_and_devices(tmp_path):
    text = "| | Neck | subscribe | | Print |"
    changes, found = fixed(text, tmp_path, more=DEVICES + "| Neck | JointPositon | HeadYaw |")
    assert found == [] and [(c.place, c.new) for c in changes] == [("Devices!B2", "Joint position")]
    source = tmp_path / "header.md"
    source.write_text("## T\n| Input streams | Conector | Formula | Output stream |\n|---|---|---|---|\n"
                      "| Red ball | subscribe | | Print |\n")  # fmt: skip
    changes, checked = api.fix(source, tmp_path / "header-out.md")
    assert [(c.place, c.new) for c in changes] == [("T!B1", "Connector")]
    assert checked.report.flatten(["code"]) == []


@pytest.mark.parametrize(
    "text",
    [
        # two names are as near, or the proposed one is far away
        "| | Red ball | map | 1 | Left hend |\n| | Red ball | map | 2 | Left hand |\n| | Red ball | map | 3 | Left hond |\n"
        "| | Left hund | subscribe | | Print |",
        "| | Red ball | map | 1 | Score |\n| | Sce | subscribe | | Print |",
        "| | Red ball | map | SQTR(redBall.x) | X |" + PRINT,  # SQRT or STR
        # what is alike on purpose, or may be what a row should have given
        "| | Red ball | map | 1 | Step 1 |\n| | Step 2 | subscribe | | Print |",
        "| | Red ball | map | 1 | Arm x |\n| | Arm y | subscribe | | Print |",
        "| | Red ball | map | 1 | |\n| | Red bal | subscribe | | Print |",
    ],
)
def test_what_may_mean_two_things_is_left_to_the_user(text, tmp_path):
    changes, found = fixed(text, tmp_path)
    assert changes == [] and {"GRAPH001", "FORM005"} & {code for code, _ in found}


DISTANCE = "| | Red ball | map | redBall.distance | D |\n| | D | filter | d < 0.5 | Close |\n"
STALE = [
    DISTANCE + "| | Close, D | combineLatest | d * 2 | X |" + PRINT,
    DISTANCE
    + "| | Close, D | combineLatest | d * 2 - close | X |\n| | X | map | x + 1 | Y |\n| | Y | subscribe | | Print |",
    DISTANCE + '| | D, Close | combineLatest | IF(d > 1; "close"; close) | |\n| | | subscribe | | Print |',
]


@pytest.mark.parametrize("fix", ["forget-old-value", "join-close-in-time"])
@pytest.mark.parametrize("text", STALE)
def test_both_remedies_for_a_stale_combination(text, fix, tmp_path):
    changes, found = fixed(text, tmp_path, f"LINT001:{fix}")
    assert found == [] and any(c.old is None for c in changes)


@pytest.mark.slow
@pytest.mark.parametrize("fix", ["forget-old-value", "join-close-in-time"])
def test_the_classic_mistake_mended_stays_mended_and_keeps_the_users_notes(fix, tmp_path):
    out = tmp_path / "out.xlsx"
    _, checked = api.fix(bundled("workbooks", "complex-tracking.xlsx"), out, {"LINT001": fix})
    assert checked.report.flatten(["code"]) == []
    again = api.check(out)
    assert again.report.flatten(["code"]) == []
    _, outcome = api.test(out)
    assert outcome is not None and all(case.passed for case in outcome.cases)
    notes = [r.notes for r in again.workbook.behaviours[0].rows]
    assert "far: the head" in notes and "close: the arm on that side" in notes


@pytest.mark.parametrize("fix", ["throttle", "changes"])
@pytest.mark.parametrize(
    "text",
    [
        "| | Red ball | map | redBall.colour | X |\n| | X | subscribe | | Say |",
        "| | Red ball | map | redBall.colour | |\n| | | subscribe | | Say |",
        '| | Face | subscribe | "Hello!" | Say |',
    ],
)
def test_endless_speech_is_slowed_down(text, fix, tmp_path):
    changes, found = fixed(text, tmp_path, f"LINT002:{fix}")
    assert found == [] and len([c for c in changes if c.old is None]) == 1


def test_fixes_that_need_a_choice_are_not_applied_without_one(tmp_path):
    changes, found = fixed(STALE[0], tmp_path)
    assert changes == [] and [code for code, _ in found] == ["LINT001"]


def test_the_command_says_what_it_changed_and_never_touches_the_original(tmp_path):
    source = tmp_path / "w.md"
    source.write_text(rows("| | Red bal | subscribe | | Print |", header=COLUMNS))
    done = rrp("check", source, "--fix", tmp_path / "w2.md")
    assert done.returncode == 0 and "T!B2 “Red bal” → “Red ball”" in done.stdout
    assert rrp("check", source).returncode == 1
    assert rrp("check", source, "--fix", source).returncode == 2
    assert rrp("check", source, "--apply", "LINT001:forget-old-value").returncode == 2
    assert rrp("check", source, "--fix", tmp_path / "x.md", "--apply", "everything").returncode == 2


def test_json_lists_findings_fixes_examples_and_changes(tmp_path):
    book = bundled("workbooks", "complex-tracking.xlsx")
    found = json.loads(rrp("check", book, "--json").stdout)
    (finding,) = found["findings"]
    assert [(f["id"], f["safe"]) for f in finding["fixes"]] == [
        ("forget-old-value", False),
        ("join-close-in-time", False),
    ]
    assert finding["severity"] == "warning" and finding["details"]["rare"] in finding["message"]
    assert found["examples"]["Tracking!2"] == {
        "value": 0.5,
        "shown": "0.5",
        "kind": "number",
        "unit": "m",
        "sure": True,
    }
    out = json.loads(
        rrp("check", book, "--json", "--fix", tmp_path / "o.xlsx", "--apply", "LINT001:forget-old-value").stdout
    )
    assert out["findings"] == [] and out["changes"][0]["old"] is None


def test_the_ids_of_a_finding_differ_and_have_one_form(tmp_path):
    for text in (*(text for text, *_ in SAFE), *STALE):
        for finding in check(rows(text, "", header=COLUMNS)).report:
            ids = [fix.id for fix in finding.fixes]
            assert len(set(ids)) == len(ids) and all(re.fullmatch(r"[a-z]+(-[a-z]+)*", i) for i in ids)


def test_a_proposed_name_may_end_with_a_question_mark():
    text = "| | Red ball | sample | 1 s | Ready? |\n| | Redy? | subscribe | | Print |"
    (finding, *_) = check(rows(text, "", header=COLUMNS)).report
    assert finding.details["guess"] == "Ready?" and finding.remedy.startswith("Did you mean Ready??")
    (fix,) = finding.fixes
    assert fix.id == "correct-spelling" and fix.edits == (Replace(Address("T", 3, 2), "Redy?", "Ready?"),)


# the formula of a row, its connector and output, and the formula as the first fix writes it; None without a fix
WRITTEN = [
    ("Nod", "map", "Move", '"Nod"'),
    ("stand init", "subscribe", "Posture", '"StandInit"'),
    ("Arms up", "map", "Move", '"Arms up"'),
    ("It's near", "subscribe", "Say", '"It\'s near"'),
    ("Red ball is gone, good bye", "subscribe", "Say", '"Red ball is gone, good bye"'),
    ('The "red" one is here', "subscribe", "Say", '"The ""red"" one is here"'),
    ('"It is near', "subscribe", "Say", '"It is near"'),
    ("“It is near", "map", "X", '"It is near"'),
    ("redBall.x > 0 AND NOT redBall.y > 0", "filter", "X", "redBall.x > 0 and not redBall.y > 0"),
    ("redBall.x => 1", "filter", "X", "redBall.x >= 1"),
    ("redBall.colour = red", "filter", "X", 'redBall.colour = "red"'),
    ("redBal.x > 0 and 1", "filter", "X", "redBall.x > 0 and 1"),
    ("near", "map", "X", None),
    ("Near ball", "filter", "X", None),
    ("redBall near", "map", "X", None),
    ("Red bal distance", "map", "X", None),
    ("distance between 1 and 2", "map", "X", None),
    ("if distance then near else far", "map", "X", None),
    ("very bright", "subscribe", "Eye brightness", None),
    ('IF(redBall.x > 0; "a; "b")', "map", "X", None),
]


@pytest.mark.parametrize(("formula", "connector", "output", "new"), WRITTEN)
def test_the_first_fix_writes_the_formula_as_the_remedy_says(formula, connector, output, new, tmp_path):
    end = "Gesture" if output == "Move" else "Print"
    more = "" if connector == "subscribe" else f"\n| | {output} | subscribe | | {end} |"
    text = f"| | Red ball | {connector} | {formula} | {output} |{more}"
    (finding,) = [d for d in check(rows(text, header=COLUMNS)).report if d.address.cell == "D2"]
    if new is None:
        assert not any(fix.id in ("put-in-quotes", "correct-formula") for fix in finding.fixes)
        return
    changes, found = fixed(text, tmp_path, f"{finding.code}:{finding.fixes[0].id}")
    assert (changes[-1].place, changes[-1].new, changes[-1].title[:6]) == ("T!D2", new, "Write ")
    assert not [code for code, _ in found if code.startswith("FORM")]
    if finding.fixes[0].id == "put-in-quotes":
        assert finding.message == "This formula cannot be read: a text needs quotes."
        assert finding.remedy == f"Write {new}."


def test_two_misspellings_of_one_name_in_one_cell_are_both_corrected(tmp_path):
    changes, found = fixed("| | Red ball | map | redBal.x + redBll.y | X |" + PRINT, tmp_path)
    assert found == [] and changes[-1].new == "redBall.x + redBall.y"


@pytest.mark.parametrize(
    ("above", "name"),
    [
        ("", "Value for Say"),
        ("| | Red ball | map | 1 | Value for Say |" + PRINT.replace("X", "Value for Say") + "\n", "Value for Say 2"),
    ],
)
def test_an_actuator_as_output_gets_a_subscribe_row(above, name, tmp_path):
    changes, found = fixed(f'{above}| | Chest button | map | "Hello" | Say |', tmp_path, "GRAPH007:add-subscribe-row")
    assert found == [] and [c.new for c in changes] == [name, f"{name} | subscribe | Say"]


def test_a_choice_without_an_id_is_the_only_fix(tmp_path):
    text = "| | Red ball | map | 1 | Score |\n| | Sce | subscribe | | Print |"
    changes, _ = fixed(text, tmp_path, "GRAPH001:")
    assert [(c.place, c.new) for c in changes] == [("T!B3", "Score")]
    changes, found = fixed(STALE[0], tmp_path, "LINT001:")
    assert changes == [] and [code for code, _ in found] == ["LINT001"]


def test_a_code_is_given_one_fix(tmp_path):
    source = tmp_path / "w.md"
    source.write_text(rows(STALE[0], header=COLUMNS))
    twice = ("--apply", "LINT001:forget-old-value", "--apply", "LINT001:join-close-in-time")
    code, told = run("check", source, "--fix", tmp_path / "w2.md", *twice)
    assert code == 2 and "--apply takes one fix for a code" in told and not (tmp_path / "w2.md").exists()


@pytest.mark.parametrize("apply", ["LINT001:forget-old-valeu", "LINT002:throttle", "LINT002:"])
def test_a_fix_that_no_finding_has_is_refused_with_those_there_are(apply, tmp_path):
    with pytest.raises(SheetsError) as told:
        fixed(STALE[0], tmp_path, apply)
    assert apply.removesuffix(":") in told.value.message
    assert told.value.remedy == "There are: LINT001:forget-old-value, LINT001:join-close-in-time."
    assert not (tmp_path / "out.md").exists()
    source = tmp_path / "source.md"
    code, said = run("check", source, "--fix", tmp_path / "out.md", "--apply", apply.removesuffix(":"))
    assert code == 2 and told.value.remedy in said


def test_a_wrong_choice_does_not_keep_the_safe_fix_away(tmp_path):
    with pytest.raises(SheetsError) as told:
        fixed("| | Red bal | subscribe | | Print |", tmp_path, "GRAPH001:throttle")
    assert told.value.remedy == "There are: GRAPH001:correct-spelling."


def test_fixes_of_devices_are_chosen_by_their_printed_names(tmp_path):
    source, out = tmp_path / "w.md", tmp_path / "w2.md"
    devices = DEVICES.replace("Joint", "Text") + "| Praise | Say | Hello |"
    source.write_text(rows("| | Red ball | subscribe | | Praise |", devices, header=COLUMNS))
    _, told = run("check", source)
    (choice,) = re.findall(r"--apply (DEV007:\S+)", told)
    code, told = run("check", source, "--fix", out, "--apply", choice)
    assert code == 0 and "“Say” → “Say parameter”" in told


def test_a_safe_fix_alone_needs_no_choice_and_is_not_listed(tmp_path):
    source = tmp_path / "w.md"
    source.write_text(rows("| | Red bal | subscribe | | Print |", header=COLUMNS))
    assert "--apply" not in run("check", source)[1]


def test_a_number_that_a_fix_writes_is_a_number_as_in_the_grid(tmp_path):
    book = openpyxl.Workbook()
    book.active.title = "T"
    for row in (HEADER, ["", "Red ball", "map", "1,5", "Far"], ["", "Far", "subscribe", "", "Print"]):
        book.active.append(row)
    book.save(tmp_path / "a.xlsx")
    api.fix(tmp_path / "a.xlsx", tmp_path / "b.xlsx", {})
    cells = openpyxl.load_workbook(tmp_path / "b.xlsx")["T"][2]
    assert [cell.value for cell in cells][3] == 1.5
