"""Runs as tables and plots: what is in them, where they say that they come from, and hostile records."""

from __future__ import annotations

import csv
import io
import json
import re
import shutil
import sqlite3
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest
from click.testing import CliRunner
from PIL import Image
from recorded import END, EVENT, HEADER, HOSTILE, write_run

from rrp_sheets import api, help
from rrp_sheets.cli.main import group
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.graph import StreamKind
from rrp_sheets.help.recording_columns import KINDS
from rrp_sheets.help.site import page
from rrp_sheets.model.run_files import ACTIONS, ORPHANED, RecordedFailure, Stamp
from rrp_sheets.recording import exporting
from rrp_sheets.recording.deleting import search_code
from rrp_sheets.recording.exporting import ExportKind
from rrp_sheets.recording.folder import stamp_pictures
from rrp_sheets.recording.metadata import stamp_of
from rrp_sheets.recording.table import SENT, properties_of
from rrp_sheets.render.svg import frame
from rrp_sheets.resources import bundled
from rrp_sheets.services import bundles
from rrp_sheets.workbook.table import write_table

SVG = "{http://www.w3.org/2000/svg}"
BALL = {"x": 0.1, "distance": 1.5, "colour": "red"}
STAMP = ["workbook", "workbook_sha256", "program", "mode", "seed", "operator", "began", "ended", "complete"]


def sensed(t: float, distance: float) -> dict[str, Any]:
    return {"t": t, "stream": "Red ball", "row": "", "value": {**BALL, "distance": distance}}


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """A run with numbers, speech, a button, a mark, an error."""
    return write_run(
        tmp_path, "2026-a", HEADER, *(sensed(n / 10, 1 + n / 100) for n in range(40)),
        {"t": 1.0, "stream": "Tracking!Distance", "row": "Tracking!2", "value": 0.5},
        {"t": 1.5, "happening": "say", "text": "Hello", "row": "Tracking!3"},
        {"t": 2.0, "happening": "press", "text": "Start", "by": "Aya"},
        {"t": 2.5, "happening": "mark", "text": "Kai laughs", "by": "Aya"},
        {"t": 3.0, "row": "Tracking!4", "error": "This formula divides by zero.", "code": "FORM101", "inputs": []},
        {"t": 3.5, "stream": "Tracking!Distance", "row": "Tracking!2", "value": 0.75}, END,
    )  # fmt: skip


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        return list(csv.DictReader(file))


# ---- tables ----


def test_a_csv_says_in_every_row_where_it_comes_from(session: Path, tmp_path: Path) -> None:
    target = tmp_path / "run.csv"
    assert api.export([session], target) == []
    assert target.read_bytes().startswith(
        b"\xef\xbb\xbftime_s,kind,stream,row,value,message,blank,by,x_rad,distance_m,"
    )
    rows = rows_of(target)
    assert len(rows) == 46
    for row in rows:
        assert [row[n] for n in STAMP] == ["good.md", "0" * 64, "RRP Sheets 0.2.0", "simulated", "7", "Aya",
                                           "2026-11-02T09:05:00.000+00:00", "time", "TRUE"]  # fmt: skip
        assert (row["run"], row["participant"], row["condition"]) == ("2026-a", "P-01", "Control")
    assert (rows[3]["time_s"], rows[3]["distance_m"], rows[3]["colour"]) == ("0.300000", "1.03", "red")
    assert [(r["kind"], r["message"], r["by"]) for r in rows if r["message"]] == [
        ("say", "Hello", ""), ("press", "Start", "Aya"), ("mark", "Kai laughs", "Aya"),
        ("error", "This formula divides by zero.", ""),
    ]  # fmt: skip


def test_a_study_is_one_long_table(session: Path, tmp_path: Path) -> None:
    other = write_run(
        tmp_path, "2026-b", HEADER | {"participant": "P-02", "condition": "寒い", "mode": "pilot"}, EVENT, END
    )
    notes = api.export([session, other / "trace.jsonl"], tmp_path / "study.csv")
    assert notes == ["A pilot, whose data never counts as a session: 2026-b. See the column mode."]
    rows = rows_of(tmp_path / "study.csv")
    assert list(rows[0])[:4] == ["run", "participant", "condition", "time_s"]
    assert {(r["run"], r["participant"], r["condition"], r["mode"]) for r in rows} == {
        ("2026-a", "P-01", "Control", "simulated"), ("2026-b", "P-02", "寒い", "pilot"),
    }  # fmt: skip
    assert rows[-1]["value"] == "1.5" and rows[-1]["distance_m"] == ""
    api.export([session, other], tmp_path / "study.xlsx")
    book = openpyxl.load_workbook(tmp_path / "study.xlsx", read_only=True)
    assert book.sheetnames == ["runs", "Movements", "About these runs", "Streams", "Columns"]
    about = list(book["About these runs"].iter_rows(values_only=True))
    assert about[0][:3] == ("run", "workbook", "workbook_sha256") and [r[0] for r in about[1:]] == ["2026-a", "2026-b"]


@pytest.mark.parametrize("language", ["en", "ja"])
def test_an_xlsx_and_the_help_explain_every_column_and_kind(session: Path, tmp_path: Path, language: str) -> None:
    other = write_run(tmp_path, "2026-b", HEADER | {"language": language}, sensed(0.5, 2), EVENT, END)
    for name, traces in (("one", [other]), ("two", [other, session])):
        api.export(traces, tmp_path / f"{name}.xlsx")
        book = openpyxl.load_workbook(tmp_path / f"{name}.xlsx", read_only=True)
        header, *lines = book.worksheets[0].iter_rows(values_only=True)
        (_, unit, meaning), *told = book["Columns"].iter_rows(values_only=True)
        assert (unit, meaning) == (("Unit", "Meaning") if language == "en" else ("単位", "意味"))
        assert [line[0] for line in told][: len(header)] == list(header) and all(line[2] for line in told)
        kinds = {f"kind: {line[header.index('kind')]}" for line in lines}
        assert kinds <= {line[0] for line in told} and ("distance_m", "m") in {line[:2] for line in told}
        answer = CliRunner().invoke(group, ["help", "recordings", "--language", language]).output
        shown = re.sub(r"\s", "", answer)
        assert "Columns-of-the-tables" in {section.anchor for section in page("recordings.html", language).headings}
        fixed = [line for line in told if line[0] not in ("x_rad", "distance_m", "colour")]
        assert all(re.sub(r"\s", "", line[2]) in shown for line in fixed)
    assert {kind.value for kind in StreamKind} | ACTIONS | {SENT, RecordedFailure.kind} <= KINDS.keys()


def test_an_xlsx_has_numbers_and_a_sheet_about_the_run(session: Path, tmp_path: Path) -> None:
    api.export([session], tmp_path / "run.xlsx")
    book = openpyxl.load_workbook(tmp_path / "run.xlsx")
    assert book.sheetnames == ["run", "Movements", "About this run", "Streams", "Columns"]
    sheet = book["run"]
    assert sheet.cell(2, 1).value == 0 and sheet.cell(5, 10).value == 1.03 and sheet.freeze_panes == "A2"
    about = {a: b for a, b in book["About this run"].iter_rows(values_only=True)}  # noqa: C416
    assert about["Seed"] == 7 and about["Ended"] == "time" and about["Began"] == "2026-11-02T09:05:00.000+00:00"
    assert about["Workbook SHA-256"] == "0" * 64 and about["Participant"] == "P-01" and about["Run"] == "2026-a"
    assert ["Red ball", "sensor", "RedBall", "x: rad, y: rad, width: rad, height: rad, distance: m"] in [
        list(r) for r in book["Streams"].iter_rows(values_only=True)
    ]
    assert "P-01" in book.properties.description and book.properties.title == "Run 2026-a of good.md"


def test_an_xlsx_says_when_joints_began_and_ended_to_move(tmp_path: Path) -> None:
    streams = [("Wave", "Gesture"), ("Follow", "Tracker"), ("Words", "SayInput")]
    header = HEADER | {"streams": [{"stream": n, "kind": "actuator", "device": d} for n, d in streams]}
    sent = [(1.02, "Wave", "A!2", "Wave"), (2.0, "Words", "A!3", "Hi"), (3.0, "Follow", "A!4", 1),
            (3.4, "Follow", "A!4", 2), (3.8, "Follow", "A!4", None), (5.0, "Wave", "A!2", "Wave"), (6.0, "Wave", "A!5", "Nod"),
            (7.0, "Follow", "A!6", 1), (8.02, "Wave", "A!7", "Wave")]  # fmt: skip
    names = ("t", "stream", "row", "value")
    place = write_run(tmp_path, "2026-m", header, *(dict(zip(names, s, strict=True)) for s in sent), END)

    def sheet() -> list[tuple[Any, ...]]:
        api.export([place], tmp_path / "m.xlsx")
        return list(openpyxl.load_workbook(tmp_path / "m.xlsx")["Movements"].iter_rows(min_row=2, values_only=True))

    commands = [(1.02, "Wave", "A!2", "Wave", 1), (3, "Follow", "A!4", "1", 2), (5, "Wave", "A!2", "Wave", 1),
                (6, "Wave", "A!5", "Nod", 1), (7, "Follow", "A!6", "1", 1),
                (8.02, "Wave", "A!7", "Wave", 1)]  # fmt: skip
    assert [(*row[:3], str(row[3]), row[4]) for row in sheet()] == commands
    assert {row[5:] for row in sheet()} == {(None, None, None)}  # no poses were recorded
    arm, head = {"A!2": ["RElbowRoll"]}, {"A!4": ["HeadYaw"]}
    poses: list[dict[str, Any]] = [
        {"t": 0.0, "full": True, "joints": {"RElbowRoll": 1.0, "HeadYaw": 0.0}},
        {"t": 1.1, "drives": arm, "joints": {"RElbowRoll": 1.01, "HeadYaw": 0.5}},  # the head is not the arm's
        {"t": 1.2, "joints": {"RElbowRoll": 1.03}}, {"t": 1.3, "joints": {"RElbowRoll": 1.5}},
        {"t": 1.4, "joints": {"RElbowRoll": 1.51}}, {"t": 1.5, "drives": {}},
        {"t": 3.1, "drives": head}, {"t": 3.2, "joints": {"HeadYaw": 0.8}}, {"t": 3.7, "joints": {"HeadYaw": 0.9}},
        {"t": 3.9, "joints": {"HeadYaw": 1.0}, "drives": {}},
        {"t": 5.1, "drives": arm, "joints": {"RElbowRoll": 10**400}}, {"t": 5.3, "joints": {"RElbowRoll": 1.0}},
        {"t": 5.4, "drives": {"A!6": ["RElbowRoll"]}, "joints": {"RElbowRoll": 1.2}},  # another row takes over
        {"t": 7.2, "drives": {"A!6": 5}}, {"t": 8.0, "joints": {"RElbowRoll": 1.3}},  # it still moves
        {"t": 8.1, "drives": {"A!7": ["RElbowRoll"]}, "joints": {"RElbowRoll": 1.4}}, {"t": 8.2, "joints": {"RElbowRoll": 1.5}},
        {"t": 8.9, "drives": {}},
    ]  # fmt: skip
    (place / "poses.jsonl").write_text("".join(json.dumps(pose) + "\n" for pose in poses), encoding="utf-8")
    assert [row[5:] for row in sheet()] == [
        (1.2, 1.3, 0.18), (3.2, None, 0.2), (5.3, None, 0.3), (None, None, None), (None, None, None), (None, 8.2, None),
    ]  # fmt: skip


def test_texts_are_never_formulas(tmp_path: Path) -> None:
    bad = '=HYPERLINK("http://evil.example")'
    place = write_run(tmp_path, bad.replace("/", "-"), HEADER | {"participant": bad, "name": "@evil.xlsx"},
                      EVENT | {"value": bad, "stream": "+1"}, EVENT | {"value": {"=1+1": "-2", "n": -2}}, END)  # fmt: skip
    api.export([place], tmp_path / "t.csv")
    first, second = rows_of(tmp_path / "t.csv")
    assert (first["value"], first["stream"], first["participant"], first["workbook"]) == (
        f"'{bad}", "'+1", f"'{bad}", "'@evil.xlsx",
    )  # fmt: skip
    assert first["run"].startswith("'=") and second["n"] == "-2" and second["field_1_1"] == "'-2"
    api.export([place], tmp_path / "t.xlsx")
    for sheet in openpyxl.load_workbook(tmp_path / "t.xlsx"):
        assert {cell.data_type for row in sheet.iter_rows() for cell in row} <= {"s", "n", "b", "inlineStr"}


R_RESERVED = frozenset(
    [
        "if",
        "else",
        "repeat",
        "while",
        "function",
        "for",
        "next",
        "break",
        "TRUE",
        "FALSE",
        "NULL",
        "Inf",
        "NaN",
        "NA",
        "in",
        "NA_integer_",
        "NA_real_",
        "NA_character_",
    ]
)
ODD = {"Value": 1, "Zone": "Head", "zone": "Hand", "time": 2.5, "Time (s)": 3, "if": 4, "2nd": 5, "": 6, "_": 7,
       "Run": 8, "by": 9, "距離": 10, "a b": 11, "a_b": 12, "aB": 13, "Complete": 14, "blank": 15, "SELECT": 16}  # fmt: skip


def make_names(names: list[str]) -> list[str]:
    """A table's header as R's make.names and make.unique change it (their documentation, R 4)."""
    found: list[str] = []
    for name in names:
        plain = "".join(c if c.isalnum() or c in "._" else "." for c in name)
        if not re.match(r"(?:[^\W\d_]|\.(?!\d))", plain):
            plain = f"X{plain}"
        found.append(f"{plain}." if plain in R_RESERVED else plain)
    return [name if name not in found[:n] else f"{name}.{n}" for n, name in enumerate(found)]


@pytest.fixture
def odd(tmp_path: Path) -> list[Path]:
    """Three runs: with fields of all kinds of names, broken off, and cut."""
    lines = [EVENT | {"value": ODD}, EVENT | {"value": {"Zone": "Head", "distance": None}}, EVENT | {"value": None},
             EVENT | {"value": [1, {"a": "é", "b": None}, True]}, EVENT | {"value": {"zone": {"x": [1, 2]}}},
             EVENT | {"value": {}}, EVENT | {"value": False, "t": 1 / 3}, EVENT | {"value": "", "t": 12.0}]  # fmt: skip
    one = write_run(tmp_path, "one", HEADER, *lines, END)
    two = write_run(tmp_path, "two", HEADER, EVENT, END | {"ended": "broken", "why": "The simulator is gone."})
    three = write_run(tmp_path, "three", HEADER | {"seed": 12}, EVENT, EVENT)
    return [one, two, three]


def test_column_names_are_taken_as_they_are_by_other_programs(odd: list[Path], tmp_path: Path) -> None:
    for runs in ([odd[0]], odd):
        api.export(runs, tmp_path / "t.csv")
        api.export(runs, tmp_path / "t.xlsx")
        with (tmp_path / "t.csv").open(encoding="utf-8-sig", newline="") as file:
            header, *rows = csv.reader(file, strict=True)
        assert len({h.casefold() for h in header}) == len(header) and {len(r) for r in rows} == {len(header)}
        assert make_names(header) == header
        table = sqlite3.connect(":memory:")
        table.execute(f"CREATE TABLE events ({', '.join(f'{chr(34)}{name}{chr(34)}' for name in header)})")
        table.executemany(f"INSERT INTO events VALUES ({', '.join('?' * len(header))})", rows)
        found = table.execute("SELECT zone, field_value, field_time_s, time_s, field_run FROM events").fetchone()
        assert found == ("Head", "1", "3", "0.500000", "8")
        book = openpyxl.load_workbook(tmp_path / "t.xlsx")
        names = [cell.value for cell in book.worksheets[0][1]]
        assert len({n.casefold() for n in names}) == len(names) and set(names) <= set(header)
        assert {row[0] for row in book["Streams"].iter_rows(values_only=True)} >= {"one" if runs == odd else "Red ball"}


def test_fields_spelt_alike_share_a_column_unless_one_record_has_both(tmp_path: Path) -> None:
    place = write_run(tmp_path, "x", HEADER, EVENT | {"value": {"Zone": 1}}, EVENT | {"value": {"zone": 2}}, END)
    api.export([place], tmp_path / "t.csv")
    assert [r["zone"] for r in rows_of(tmp_path / "t.csv")] == ["1", "2"]
    place = write_run(tmp_path, "y", HEADER, EVENT | {"value": {"Zone": 1, "zone": 2}}, END)
    api.export([place], tmp_path / "t.csv")
    assert [(r["zone"], r["zone_2"]) for r in rows_of(tmp_path / "t.csv")] == [("1", "2")]


def test_a_blank_is_not_the_same_as_nothing_and_lists_are_json(odd: list[Path], tmp_path: Path) -> None:
    api.export([odd[0]], tmp_path / "t.csv")
    rows = rows_of(tmp_path / "t.csv")
    assert [(r["value"], r["blank"], r["distance"]) for r in rows[1:3]] == [("", "distance", ""), ("", "value", "")]
    assert json.loads(rows[3]["value"]) == [1, {"a": "é", "b": None}, True]
    assert json.loads(rows[4]["zone_2"]) == {"x": [1, 2]} and json.loads(rows[5]["value"]) == {}
    assert [(r["value"], r["blank"], r["time_s"]) for r in rows[6:]] == [
        ("FALSE", "", "0.333333"), ("", "", "12.000000"),
    ]  # fmt: skip
    api.export([odd[0]], tmp_path / "t.xlsx")
    header, *lines = openpyxl.load_workbook(tmp_path / "t.xlsx")["run"].iter_rows(values_only=True)
    table = [dict(zip(header, line, strict=True)) for line in lines]
    assert table[6]["time_s"] == 0.333333 and table[6]["value"] is False and table[2]["blank"] == "value"


def test_every_table_says_how_its_runs_ended(odd: list[Path], tmp_path: Path) -> None:
    api.export(odd, tmp_path / "t.csv")
    ended = {r["run"]: (r["ended"], r["complete"], r["seed"]) for r in rows_of(tmp_path / "t.csv")}
    assert ended == {"one": ("time", "TRUE", "7"), "two": ("broken", "FALSE", "7"), "three": ("cut", "FALSE", "12")}
    api.export(odd, tmp_path / "t.xlsx")
    book = openpyxl.load_workbook(tmp_path / "t.xlsx")
    for name in ("runs", "About these runs"):
        header, *lines = book[name].iter_rows(values_only=True)
        told = {
            row["run"]: (row["ended"], row["complete"]) for row in (dict(zip(header, r, strict=True)) for r in lines)
        }
        assert told == {"one": ("time", True), "two": ("broken", False), "three": ("cut", False)}
        assert name == "runs" or lines[2][header.index("seed")] == 12
    api.export([odd[1]], tmp_path / "one.xlsx")
    header, line = openpyxl.load_workbook(tmp_path / "one.xlsx")["run"].iter_rows(values_only=True)
    assert line[header.index("ended")] == "broken" and line[header.index("complete")] is False


def test_a_table_tells_the_end_of_the_program_from_a_person_who_stopped_the_run(tmp_path: Path) -> None:
    stopped = {
        "type": "summary",
        "ended": "stopped",
        "simulated_seconds": 8.0,
        "events": {},
        "errors": {},
        "actuator_commands": {},
    }
    places = [
        write_run(tmp_path, name, HEADER, {"t": 0.1, "stream": "Red ball", "row": "", "value": 1}, {**stopped, **by})
        for name, by in (("one", {"stopped_by": "Aya"}), ("two", {"stopped_by": ORPHANED}), ("three", {}))
    ]
    api.export(places, tmp_path / "t.csv")
    ended = {r["run"]: (r["ended"], r["complete"]) for r in rows_of(tmp_path / "t.csv")}
    assert ended == {"one": ("stopped", "TRUE"), "two": ("killed", "FALSE"), "three": ("stopped", "TRUE")}
    shown = CliRunner().invoke(group, ["runs", str(tmp_path)]).output
    assert "stopped by Aya" in shown and "stopped because the program that started it ended" in shown
    help_text = (Path(help.__file__).parent / "recordings.md").read_text(encoding="utf-8")
    assert (
        "* killed | " in help_text and "complete is FALSE" in help_text.partition("* killed | ")[2].partition("\n")[0]
    )


def test_what_is_printed_stands_there_once(tmp_path: Path) -> None:
    streams = [*HEADER["streams"], {"stream": "Print", "kind": "actuator", "device": "Print"}]
    place = write_run(
        tmp_path, "x", HEADER | {"streams": streams}, {"t": 1.0, "stream": "Print", "row": "T!2", "value": 4},
        {"t": 1.03, "happening": "note", "stream": "Print", "row": "T!2", "text": "4"},
        {"t": 2.0, "happening": "note", "text": "A note of the room."}, END,
    )  # fmt: skip
    api.export([place], tmp_path / "t.csv")
    assert [(r["kind"], r["value"], r["message"]) for r in rows_of(tmp_path / "t.csv")] == [
        ("actuator", "4", ""), ("note", "", "A note of the room."),
    ]  # fmt: skip


def test_a_table_of_an_earlier_version_may_be_replaced(session: Path, tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("Time (s),Kind,Run,Workbook,Workbook SHA-256\n0.1,stream,a,b,c\n")
    assert api.export([session], tmp_path / "t.csv") == []


# ---- pictures ----


def words_in(svg: Path) -> list[str]:
    return [e.text or "" for e in ET.parse(svg).iter(f"{SVG}text")]


def test_plots_have_one_axis_a_line_per_stream_and_what_happened(session: Path, tmp_path: Path) -> None:
    api.export([session], tmp_path / "p.svg")
    words = words_in(tmp_path / "p.svg")
    assert words[0] == "good.md, P-01, Control, 2026-11-02 09:05"
    for expected in ("Distance", "Red ball.distance", "in m", "sensor, 40 values", "Said", "Hello", "Button", "Start",
                     "Mark", "Kai laughs", "Error", "This formula divides by zero.", "Time (s)", "1.39"):  # fmt: skip
        assert expected in words
    assert words[-1].startswith("good.md · 000000000000 · RRP Sheets 0.2.0 · simulated · seed 7 · P-01 · Control")
    told = {e.get("name"): e.text for e in ET.parse(tmp_path / "p.svg").iter("{urn:rrp-sheets:about}entry")}
    assert told["Workbook SHA-256"] == "0" * 64 and told["Participant"] == "P-01"
    ways = [e.get("d", "") for e in ET.parse(tmp_path / "p.svg").iter(f"{SVG}path") if "#1f5fa8" in e.attrib.values()]
    assert [way.count("L") for way in ways] == [39, 39]  # its x never changes: a level line
    assert len({piece.split()[1] for piece in ways[0][1:].split("L")}) == 1
    dots = [e for e in ET.parse(tmp_path / "p.svg").iter(f"{SVG}circle") if e.get("fill") == "#2e7d32"]
    assert len(dots) == 2  # two values far apart are no curve


def test_only_the_streams_that_were_named(session: Path, tmp_path: Path) -> None:
    api.export([session], tmp_path / "p.svg", streams=["red  BALL.distance"])
    assert "Red ball.distance" in words_in(tmp_path / "p.svg") and "Distance" not in words_in(tmp_path / "p.svg")
    with pytest.raises(SheetsError, match="No stream called Blue ball") as caught:
        api.export([session], tmp_path / "p.svg", streams=["Blue ball"])
    assert "Distance, Red ball.x, Red ball.distance" in caught.value.remedy


def test_a_curve_rises_with_its_values_within_its_frame_and_its_name_stands_above_what_it_is(tmp_path: Path) -> None:
    place = write_run(tmp_path, "rise", HEADER, *(EVENT | {"t": n / 10, "value": n / 10} for n in range(30)), END)
    api.export([place], tmp_path / "r.svg")
    tree = ET.parse(tmp_path / "r.svg")
    way = next(e.get("d", "") for e in tree.iter(f"{SVG}path") if e.get("stroke") == "#2e7d32")
    heights = [float(piece.split()[1]) for piece in way[1:].split("L")]
    assert heights == sorted(heights, reverse=True)
    frame = next(e for e in tree.iter(f"{SVG}rect") if e.get("fill") == "none")
    top = float(frame.get("y", ""))
    assert top <= heights[-1] < heights[0] <= top + float(frame.get("height", ""))
    texts = {e.text: float(e.get("y", "")) for e in tree.iter(f"{SVG}text")}
    assert top < texts["Distance"] < next(y for text, y in texts.items() if text and "30 values" in text)


def test_a_line_does_not_go_across_a_gap(tmp_path: Path) -> None:
    times = [*(n / 10 for n in range(30)), *(20 + n / 10 for n in range(30))]
    place = write_run(tmp_path, "gap", HEADER, *(EVENT | {"t": t, "value": t} for t in times), END)
    api.export([place], tmp_path / "g.svg")
    ways = [e for e in ET.parse(tmp_path / "g.svg").iter(f"{SVG}path") if e.get("stroke") == "#2e7d32"]
    assert [e.get("d", "").count("L") for e in ways] == [29, 29]


def test_units_are_those_of_the_robot_in_the_folder_of_the_run(tmp_path: Path) -> None:
    event = {"t": 0.5, "stream": "Red ball", "value": {"x": 0.1, "y": 0.2, "width": 0.1, "distance": 1.5}}
    place = write_run(tmp_path, "one", {**HEADER, "robot": "labnao"}, event, END)
    api.export([place], tmp_path / "without.csv")
    shutil.copytree(bundled("robots", "nao"), place / "robots" / "labnao")
    api.export([place], tmp_path / "with.csv")
    header = [
        (tmp_path / f"{name}.csv").read_text(encoding="utf-8-sig").splitlines()[0] for name in ("without", "with")
    ]
    assert "distance_m" not in header[0] and "distance_m" in header[1]
    (place / "robots" / "labnao" / "robot.toml").write_text("[broken", encoding="utf-8")
    api.export([place], tmp_path / "broken.csv")


def film(place: Path, seconds: int) -> None:
    from rrp_sheets.sim.camera import Shot
    from rrp_sheets.sim.film import FilmFile

    outside = np.full((320, 560, 3), 200, np.uint8)
    file = FilmFile(place / "film.gif")
    for n in range(seconds):
        file.add(Shot(n * 1_000_000, outside, outside[:96, :128], "", (1, 0, 0), f"moment {n}", 0.0))


def test_hostile_names_are_text_in_every_picture(tmp_path: Path) -> None:
    header = HEADER | {"participant": HOSTILE, "name": "a" * 300, "condition": "\u202eタロウ\x00", "streams": [
        {"stream": HOSTILE, "kind": HOSTILE, "device": None}]}  # fmt: skip
    lines = [EVENT | {"stream": HOSTILE, "value": {HOSTILE: v, "y" * 300: v}, "t": v} for v in range(9)]
    marks = [{"t": 2.0, "happening": k, "text": HOSTILE * 20} for k in ("say", "mark", "press", "what", HOSTILE)]
    place = write_run(tmp_path, "x", header, *lines, *marks, END)
    api.export([place], tmp_path / "p.svg")
    root = ET.parse(tmp_path / "p.svg").getroot()
    assert {e.tag.rpartition("}")[2] for e in root.iter()} <= {
        "svg", "title", "desc", "metadata", "about", "entry", "rect", "text", "path", "circle",
    }  # fmt: skip
    assert any("<script>" in (e.text or "") for e in root.iter())
    api.export([place], tmp_path / "t.xlsx")


def test_any_value_comes_back_from_a_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    values = [None, 1, -2.5e-7, True, " a ", "a\nb", "a<b>&c", "=1+1", "日本 😀", "\x01x", float("nan"), 10**20, ""]
    write_table(tmp_path / "t.xlsx", "t", [f"h{n}" for n in range(len(values))], [values, values[::-1]], [9.0])
    sheet = openpyxl.load_workbook(tmp_path / "t.xlsx")["t"]
    told = [None, 1, -2.5e-7, True, " a ", "a\nb", "a<b>&c", "=1+1", "日本 😀", "\ufffdx", "nan", 1e20, ""]
    assert [c.value for c in sheet[2]] == told and [c.value for c in sheet[3]] == told[::-1]
    assert sheet["H2"].data_type != "f" and sheet["A1"].font.bold and sheet.freeze_panes == "A2"
    monkeypatch.setattr("rrp_sheets.workbook.table._MOST_ROWS", 3)
    write_table(tmp_path / "t.xlsx", "t", ["n"], ([n] for n in range(8)), [9.0], count=7)  # one came meanwhile
    book = openpyxl.load_workbook(tmp_path / "t.xlsx")
    found = {s.title: [row[0] for row in s.values] for s in book}
    assert found == {"t": ["n", 0, 1, 2], "t 2": ["n", 3, 4, 5], "t 3": ["n", 6, 7]}


# ---- the stamp ----


def test_every_picture_says_where_it_comes_from_and_is_found_by_the_code(session: Path, tmp_path: Path) -> None:
    film(session, 4)
    shutil.copy(bundled("workbooks") / "simple-tracking.xlsx", tmp_path / "good.xlsx")
    out = tmp_path / "out"
    out.mkdir()
    for kind in ("svg", "pdf", "png"):
        api.export([session], out / f"plots.{kind}")
    for kind in ("svg", "pdf", "png"):
        api.draw_marbles(api.marbles(session)[1] or [], out / f"marbles.{kind}")
    Image.new("RGB", (4, 4)).save(session / "strip.png")
    (session / "diagram.svg").write_text(frame("", 9, 9, ident="d", title="T", description="D"))
    stamp_pictures(session)
    for name in ("film.gif", "strip.png", "diagram.svg"):
        shutil.copy(session / name, out / name)
    api.pack(tmp_path / "good.xlsx", out / "bundle.zip", runs=[session.name])
    with zipfile.ZipFile(out / "bundle.zip") as packed:
        written = {p.name: p.read_bytes() for p in out.iterdir()} | {"bundle.zip": packed.read(bundles.VERSIONS_FILE)}
    for told in ("0" * 64, "0.2.0", "simulated", "7", "P-01"):
        assert [name for name, data in written.items() if told.encode() not in data] == [], told
    packed = ("film.gif", "marbles.pdf", "plots.pdf")  # not searched
    left = search_code("P-01", out)
    assert sorted(left.found) == sorted(p.name for p in out.iterdir() if p.name not in packed)
    assert {u.name for u in left.unsearched} == set(packed)
    with Image.open(out / "film.gif") as picture:  # it is still a film
        assert picture.n_frames == 4
    with Image.open(out / "marbles.png") as picture:
        assert "Participant: P-01" in picture.text["Description"]


def test_a_film_that_is_none_is_left_as_it_is(session: Path) -> None:
    for data in (b"", b"GIF89a P-01", b"GIF89a P-01;"):
        (session / "film.gif").write_bytes(data)
        stamp_pictures(session)
        assert (session / "film.gif").read_bytes().startswith(data[:-1])


# ---- what goes wrong ----


@pytest.mark.parametrize("form", ["svg", "txt"])
def test_marbles_say_at_their_foot_where_they_come_from(session: Path, tmp_path: Path, form: str) -> None:
    target = tmp_path / f"marbles.{form}"
    assert api.draw_marbles(api.marbles(session)[1] or [], target) == []
    assert stamp_of(session).line() in target.read_text(encoding="utf-8")


def test_no_two_kinds_of_exports_share_a_suffix_and_tables_are_also_xlsx() -> None:
    suffixes = [suffix for kind in exporting.EXPORTS for suffix in kind.types]
    assert len(suffixes) == len(set(suffixes))
    assert all(".xlsx" in kind.types for kind in exporting.EXPORTS if not kind.picture)


def test_the_title_of_a_table_is_in_the_language_of_its_run() -> None:
    stamp = Stamp(run="2026-a", workbook="挨拶.xlsx", language="ja")
    assert (
        properties_of([stamp])["title"] == "挨拶.xlsxの実行2026-a"
        and properties_of([stamp] * 2)["title"] == "2回の実行"
    )


@pytest.mark.parametrize("reason", ["No space left on device", None])
def test_a_file_that_cannot_be_written_is_told_with_a_reason(
    session: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reason: str | None
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, reason) if reason else OSError("?")

    monkeypatch.setattr("rrp_sheets.recording.table.os.replace", full)
    with pytest.raises(SheetsError) as caught:
        api.export([session], tmp_path / "run.csv")
    assert str(caught.value.message).endswith(f"cannot be written: {reason or 'the system refuses it'}.")


def test_what_cannot_be_exported_is_told_with_a_remedy(session: Path, tmp_path: Path) -> None:
    other = write_run(tmp_path, "b", HEADER, EVENT, END)
    broken = write_run(tmp_path, "c", "PK garbage")
    damaged = io.BytesIO()
    with zipfile.ZipFile(damaged, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("xl/workbook.xml", "<sheet/>" * 50)
    begin = damaged.getvalue().index(b"workbook.xml") + len(b"workbook.xml")
    damaged.getbuffer()[begin : begin + 8] = b"\xff" * 8
    (tmp_path / "damaged.xlsx").write_bytes(damaged.getvalue())
    for runs, target, more, message in (
        ([session], "damaged.xlsx", {}, "already exists and is not a table of a run"),
        ([session], "run.doc", {}, "cannot be exported as “.doc”"),
        ([session], "run", {}, "cannot be exported as “run”"),
        ([session, other], "p.svg", {}, "A picture is of one run"),
        ([session], "p.csv", {"streams": ["x"]}, "chosen for plots"),
        ([session, session], "p.csv", {}, "is named twice"),
        ([broken], "p.csv", {}, "is not the recording of a run"),
        ([tmp_path / "none"], "p.csv", {}, "There is no run"),
        ([session], "no/such/folder/p.csv", {}, "cannot be written"),
        ([session], "runs/2026-a/protocol.xlsx", {}, "belongs to the record"),
        ([other], "p.svg", {}, "has no numbers that change"),
    ):
        with pytest.raises(SheetsError) as caught:
            api.export(runs, tmp_path / target, **more)  # type: ignore[arg-type]
        assert message in caught.value.message and caught.value.remedy, message
    assert not list(tmp_path.glob("*.part"))


def test_a_record_that_was_cut_off_gives_what_it_has(tmp_path: Path) -> None:
    place = write_run(tmp_path, "cut", HEADER, EVENT, EVENT, '{"t": 1.0, "stre')
    for suffix in ("csv", "xlsx"):
        api.export([place], tmp_path / f"t.{suffix}")
    assert len(rows_of(tmp_path / "t.csv")) == 2


def test_a_record_that_is_damaged_in_its_middle_leaves_no_half_file(tmp_path: Path) -> None:
    place = write_run(tmp_path, "x", HEADER, EVENT, "garbage", EVENT, END)
    for suffix in ("csv", "xlsx", "svg"):
        with pytest.raises(UnreadableFile):
            api.export([place], tmp_path / f"t.{suffix}")
    assert not list(tmp_path.glob("t.*"))


def test_what_lies_beside_the_runs_is_left_out(tmp_path: Path) -> None:
    place = write_run(tmp_path, "one", HEADER, EVENT, END)
    faces = tmp_path / "runs" / "faces.json"
    faces.write_text("{}")
    target = tmp_path / "study.csv"
    assert api.export(sorted(faces.parent.iterdir()), target) == []
    api.export([place], tmp_path / "alone.csv")
    assert target.read_bytes() == (tmp_path / "alone.csv").read_bytes()
    with pytest.raises(UnreadableFile, match=r"faces.json” is not the recording"):
        api.export([faces], tmp_path / "none.csv")


def test_a_further_kind_is_in_the_help_and_the_refusal_and_is_written(
    session: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(traces: Sequence[Path], target: Path, streams: Sequence[str]) -> list[str]:
        target.write_text("\n".join(trace.parent.name for trace in traces))
        return ["Only their names."]

    names = ExportKind("names", "a list of names", {".lst": "text/plain"}, write, links={".lst": "their names"})
    monkeypatch.setattr(exporting, "EXPORTS", (*exporting.EXPORTS, names))
    helped = " ".join(CliRunner().invoke(group, ["export", "--help"]).output.split())
    assert "--output PATH .xlsx or .csv: a table; " in helped and "; .lst: a list of names [required]" in helped
    with pytest.raises(SheetsError) as caught:
        api.export([session], tmp_path / "run.doc")
    assert caught.value.remedy.startswith("Let the file's name end with .xlsx, .csv for a table, ")
    assert caught.value.remedy.endswith(", .svg, .pdf, .png for plots, .lst for a list of names.")
    result = CliRunner().invoke(group, ["export", str(session), "-o", str(tmp_path / "a.lst")])
    assert result.output == f"Note: Only their names.\nWritten: {tmp_path / 'a.lst'}\n"
    assert (tmp_path / "a.lst").read_text() == session.name


def test_the_command(session: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(group, ["export", str(session), "-o", str(tmp_path / "a.csv")])
    assert result.exit_code == 0 and result.output == f"Written: {tmp_path / 'a.csv'}\n"
    helped = CliRunner().invoke(group, ["export", "--help"]).output
    assert "Exit code" in helped and "study.csv" in helped
