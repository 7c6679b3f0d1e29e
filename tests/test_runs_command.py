"""Listing runs, and deleting them: nothing of a participant's code is left, and what stays is told."""

from __future__ import annotations

import fcntl
import json
import os
import shlex
import shutil
import subprocess
import zipfile
from contextlib import suppress
from datetime import date
from pathlib import Path
from typing import Any

import forked
import numpy as np
import openpyxl
import pytest
from click.testing import CliRunner, Result
from PIL import Image
from recorded import END, EVENT, HEADER, HOSTILE, write_run

from rrp_sheets.cli.main import group
from rrp_sheets.documents.document import Journal
from rrp_sheets.engine import file_lock
from rrp_sheets.engine.file_lock import lock, locked
from rrp_sheets.errors import SheetsError
from rrp_sheets.perception.face_memory import FaceMemory, kept, write_memory
from rrp_sheets.recording.deleting import delete, plan, search_code
from rrp_sheets.recording.metadata import metadata_of
from rrp_sheets.render.output import png_with
from rrp_sheets.resources import bundled

CODE = "P-07"
FACES = {"stream": "Face", "kind": "sensor", "device": "FaceDetection"}
REMEMBER = {"stream": "Remember", "kind": "actuator", "device": "RememberFace"}


def of(participant: str, began: str = "2026-11-02T09:05:00+00:00", **more: Any) -> dict[str, Any]:
    return HEADER | {"participant": participant, "began": began, "faces": "kept", "streams": [FACES, REMEMBER]} | more


def remembers(name: str) -> dict[str, Any]:
    return {
        "t": 2.0,
        "happening": "note",
        "text": f"The face is remembered as {name}.",
        "stream": "Remember",
        "row": "A!1",
    }


def recognises(name: str) -> str:
    line = {"t": 3.0, "stream": "Face", "row": "", "value": {"id": 1, "name": name, "recognised": True}}
    return json.dumps(line, separators=(",", ":"))  # as traces are written


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three runs of P-07, two of others, with all kinds of files."""
    made = tmp_path / "study"
    for name, participant in (("1-a", CODE), ("2-b", CODE), ("3-c", "P-08"), ("4-d", "p 07"), ("5-e", CODE)):
        place = write_run(made, name, HEADER | {"participant": participant}, EVENT, END)
        words = b"something of P-07" if participant == CODE else b"something"
        for file in ("film.gif", "say-001.wav", "camera.zip"):
            (place / file).write_bytes(words)
        with zipfile.ZipFile(place / "run.xlsx", "w") as packed:
            packed.writestr("words.txt", words)
    (made / "runs" / "5-e" / "more").mkdir()
    (made / "runs" / "5-e" / "more" / "deep.txt").write_text(CODE)
    return made


def run(*arguments: object, typed: str = "") -> Result:
    return CliRunner().invoke(group, ["runs", *map(str, arguments)], input=typed)


def bytes_with(folder: Path, code: str = CODE) -> list[str]:
    """The files whose name or bytes have the code."""
    return [str(p) for p in folder.rglob("*") if code in p.name or (p.is_file() and code.encode() in p.read_bytes())]


# ---- the list ----


def test_the_list_is_a_table_of_what_there_is(folder: Path) -> None:
    write_run(
        folder, "6-タロウ", HEADER | {"participant": "参加者", "mode": "pilot"}, EVENT, END | {"ended": "stopped"}
    )
    write_run(folder, "7-x", "garbage")
    lines = run(folder).output.splitlines()
    assert lines[0].split() == [
        "When",
        "Workbook",
        "Participant",
        "Condition",
        "Mode",
        "Length",
        "How",
        "it",
        "ended",
        "Run",
    ]
    assert "cannot be read" in lines[1] and lines[1].endswith("7-x")
    assert "pilot: never data" in lines[2] and "stopped manually" in lines[2] and lines[2].endswith("6-タロウ")
    assert len(lines) == 8
    assert [line.split()[-1] for line in run("list", folder, "--participant", CODE).output.splitlines()[1:]] == [
        "5-e", "2-b", "1-a",
    ]  # fmt: skip
    assert run(folder / "runs", "--workbook", "good").output.count("good.md") == 6
    assert run(folder, "--participant", "none").output == "No runs found.\n"
    told = json.loads(run(folder, "--json").output)
    assert told["schema"] == 1 and told["runs"][-1]["participant"] == CODE and told["runs"][-1]["seconds"] == 8.0


def test_the_newest_stands_first_whatever_the_folders_are_called(tmp_path: Path) -> None:
    for name, began in (("demo", "08:00:00+00:00"), ("2026-a", "09:00:00+00:00"), ("2026-b", "10:30:00+02:00")):
        write_run(tmp_path, name, of(CODE, f"2026-11-02T{began}"), EVENT, END)
    assert [line.split()[-1] for line in run(tmp_path).output.splitlines()[1:]] == ["2026-a", "2026-b", "demo"]


def test_no_runs_no_folder_and_a_link_that_leads_out(tmp_path: Path) -> None:
    assert run(tmp_path).output == "There are no runs here yet.\n"
    with pytest.raises(SheetsError, match="There is no folder"):
        CliRunner().invoke(group, ["runs", str(tmp_path / "none")], catch_exceptions=False)
    (tmp_path / "a").mkdir()
    write_run(tmp_path / "secret", "1", HEADER | {"participant": CODE}, END)
    (tmp_path / "a" / "runs").symlink_to(tmp_path / "secret" / "runs")
    with pytest.raises(SheetsError, match="leads to another folder"):
        plan(tmp_path / "a", CODE)


# ---- deleting ----


def test_a_participant_who_withdraws_leaves_nothing(folder: Path) -> None:
    with_code = {Path(p).name for p in bytes_with(folder)}
    assert {"trace.jsonl", "film.gif", "deep.txt"} <= with_code
    told = run("delete", folder, "--participant", CODE, typed=f"{CODE}\n")
    assert told.exit_code == 0
    assert "To be deleted: 3 runs of P-07 with 16 files" in told.output and "6 pictures and films" in told.output
    assert "There are also runs of “p 07”. They stay." in told.output
    assert told.output.endswith("Deleted: 3 runs, 0 remembered faces.\n")
    assert bytes_with(folder) == [] and sorted(p.name for p in (folder / "runs").iterdir()) == ["3-c", "4-d"]
    write_run(folder, "9-new", HEADER | {"participant": CODE}, END)  # the code is used again
    assert [f.run for f in plan(folder, CODE).runs] == ["9-new"] and plan(folder, CODE).elsewhere == ()


def test_nothing_is_deleted_without_the_code_typed_again(folder: Path) -> None:
    before = bytes_with(folder)
    for typed in ("", "\n", "yes\n", "p-07\n"):
        assert run("delete", folder, "--participant", CODE, typed=typed).exit_code != 0
    answer = run("delete", folder, "--participant", CODE, "--json")
    told = json.loads(answer.output.replace("Nothing was deleted.\n", ""))
    assert answer.exit_code == 1 and told["deleted"] is False and len(told["runs"]) == 3
    assert run("delete", folder, "--run", "1-a", typed="n\n").exit_code == 1
    assert (
        run("delete", folder).exit_code == 2
        and run("delete", folder, "--run", "1", "--participant", "P").exit_code == 2
    )
    assert bytes_with(folder) == before


def test_single_runs_by_name(folder: Path) -> None:
    told = json.loads(run("delete", folder, "--run", "1-a", "--run", "3-c", "--yes", "--json").output)
    assert told["deleted"] and [r["run"] for r in told["runs"]] == ["1-a", "3-c"]
    assert sorted(p.name for p in (folder / "runs").iterdir()) == ["2-b", "4-d", "5-e"]
    for name in ("1-a", "..", "../runs/2-b", "", "."):
        with pytest.raises(SheetsError, match="There is no run"):
            plan(folder, names=[name])
    with pytest.raises(SheetsError, match="is a run itself"):
        plan(folder / "runs" / "2-b", CODE)


def test_a_code_that_nobody_has_is_told_with_those_that_there_are(folder: Path) -> None:
    for typed, hint in (
        ("P07", "Did you mean P-07 or p 07?"),
        ("X", "Codes here: P-07, P-08, p 07."),
        (HOSTILE, "Codes"),
    ):
        with pytest.raises(SheetsError) as caught:
            plan(folder, typed)
        assert caught.value.remedy.startswith(hint)


def test_a_run_that_goes_on_is_refused(folder: Path) -> None:
    trace = write_run(folder, "8-now", HEADER | {"participant": CODE}, EVENT) / "trace.jsonl"
    with trace.open("a") as written:
        assert metadata_of(trace.parent).ended == "cut"
        lock(written)
        assert metadata_of(trace.parent).ended == "going"  # although nothing was written for long
        with pytest.raises(SheetsError, match="8-now is still in progress"):
            plan(folder, CODE)
    planned = plan(folder, CODE)
    assert len(planned.runs) == 4
    with pytest.raises(SheetsError, match="1-a is still in progress"):
        plan(folder, CODE, going={"1-a"})
    with trace.open("a") as written:
        lock(written)
        with pytest.raises(SheetsError, match="8-now is still in progress"):
            delete(planned)
    assert (folder / "runs" / "1-a").is_dir()  # nothing went before that was seen


def test_a_run_is_held_although_somebody_looks_whether_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with tmp_path.joinpath("looked at").open("w") as file:
        looking = os.open(file.name, os.O_RDONLY)
        fcntl.flock(looking, fcntl.LOCK_SH)
        monkeypatch.setattr(file_lock.time, "sleep", lambda seconds: os.close(looking))  # that takes no longer
        lock(file)
        assert file_lock.is_locked(Path(file.name))


def test_what_was_half_deleted_is_gone_on_with(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(self: Path, missing_ok: bool = False) -> None:
        if self.name == "say-001.wav":
            raise PermissionError(13, "Permission denied", str(self))
        real(self, missing_ok)

    real = Path.unlink
    monkeypatch.setattr(Path, "unlink", fails)
    with pytest.raises(SheetsError, match=r"say-001\.wav” cannot be deleted \(Permission denied\)"):
        delete(plan(folder, CODE))
    monkeypatch.undo()
    assert len(plan(folder, CODE).runs) == 3  # its record is still there, and says whose it is
    delete(plan(folder, CODE))
    assert bytes_with(folder) == []


def test_links_in_a_run_are_taken_away_and_not_followed(folder: Path, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "mine.txt").write_text("keep me")
    (folder / "runs" / "1-a" / "link").symlink_to(outside)
    (folder / "runs" / "2-b" / "film2.gif").symlink_to(outside / "mine.txt")
    (folder / "runs" / "0-link").symlink_to(folder / "runs" / "1-a")
    delete(plan(folder, CODE))
    assert (outside / "mine.txt").read_text() == "keep me" and not (folder / "runs" / "1-a").exists()


def test_where_the_code_stands_elsewhere_is_told(folder: Path) -> None:
    book = openpyxl.Workbook()
    book.active["P07"] = 1  # a cell of that name is no participant
    book.active["A1"] = "=P07+1"
    book.save(folder / "cells.xlsx")
    book.active["B1"] = "Session with P07"
    book.save(folder / "texts.xlsx")
    with zipfile.ZipFile(folder / "bundle.zip", "w") as packed:
        packed.write(folder / "texts.xlsx", "inside/texts.xlsx")
    (folder / "P07 consent.pdf").write_bytes(b"")
    (folder / "notes.md").write_text("XP07 P070 P07x")
    (folder / "table.csv").write_text("a,P07,b")
    Image.new("1", (1, 1)).save(folder / "plain.png")
    stamped = png_with((folder / "plain.png").read_bytes(), {"Title": "x.xlsx, P07"})
    (folder / "plain.png").write_bytes((folder / "plain.png").read_bytes() + b" P07 ")  # by chance
    (folder / "contact.png").write_bytes(stamped)
    (folder / "plots.pdf").write_bytes(b"%PDF-1.7\n" + b"/Filter stream\n" * 2_000 + b"<</Subject(Participant: P07)>>")
    os.utime(folder / "plots.pdf", (1.7e9, 1.7e9))
    (folder / "film.gif").write_bytes(b"GIF89a P07;")
    with zipfile.ZipFile(
        folder / "letters.docx", "w", zipfile.ZIP_DEFLATED
    ) as packed:  # packed texts of other programs
        packed.writestr("word/document.xml", "<w:t>Dear P07</w:t>" * 9)
    with zipfile.ZipFile(folder / "papers.zip", "w") as packed:
        packed.writestr("protocol.pdf", b"%PDF P07")
        packed.writestr("runs/1/film.gif", b"GIF89a P07;")
    with zipfile.ZipFile(folder / "nameless.zip", "w") as packed:
        packed.writestr("evil", "with P07")
    (folder / "nameless.zip").write_bytes((folder / "nameless.zip").read_bytes().replace(b"evil", b"\0vil"))
    (folder / "damaged.zip").write_bytes(b"PK\x03\x04 no zip")
    with zipfile.ZipFile(folder / "scratched.zip", "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("a.txt", "nothing " * 99)
        packed.writestr("b.txt", "nothing")
    scratched = bytearray((folder / "scratched.zip").read_bytes())
    scratched[35:45] = b"\xff" * 10  # in what is compressed
    (folder / "scratched.zip").write_bytes(scratched)
    journal = Journal(folder)
    journal.keep_version("x.xlsx", "with P07", "Aya", "digest", (folder / "cells.xlsx").read_bytes())
    journal.keep_version("x.xlsx", "another", "Aya", "digest", (folder / "texts.xlsx").read_bytes())
    journal.keep_version("x.xlsx", "clean", "Aya", "digest", (folder / "cells.xlsx").read_bytes())
    for software in (folder / ".venv", folder / "node_modules"):
        software.mkdir()
        (software / "font.ttf").write_bytes(b"\0P07\0")
    (folder / ".venv" / "pyvenv.cfg").touch()
    write_run(folder, "8-x", HEADER | {"participant": "P07"}, EVENT, END)
    write_run(folder, "9-x", HEADER, {"t": 1.0, "happening": "mark", "text": "like P07", "by": "Aya"}, END)
    write_run(folder, "7-x", HEADER, EVENT, END)
    (folder / "runs" / "7-x" / "film.gif").write_bytes(b"GIF89a")  # goes with its run
    planned = plan(folder, "P07")
    found = [place for place in planned.elsewhere if "-wal" not in place]
    assert sorted(found) == [
        ".rrp-sheets/journal.sqlite (the version “another” of x.xlsx)",
        ".rrp-sheets/journal.sqlite (the version “with P07” of x.xlsx)",
        "P07 consent.pdf (its name)", "bundle.zip", "contact.png",
        "letters.docx", "nameless.zip", "runs/9-x/trace.jsonl", "table.csv", "texts.xlsx",
    ]  # fmt: skip
    today = f"{date.today().day} {date.today():%B %Y}"
    assert sorted(map(str, planned.unsearched)) == [
        f"P07 consent.pdf ({today})", f"damaged.zip ({today})", f"film.gif ({today})",
        f"papers.zip: protocol.pdf ({today})", "plots.pdf (14 November 2023)", f"scratched.zip: a.txt ({today})",
    ]  # fmt: skip
    journal.close()


def test_when_the_time_is_over_the_rest_is_named_as_not_searched(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in "abc":
        (folder / f"{name}.txt").write_text("with P-07")
    (folder / "P-07.txt").write_text("")
    monkeypatch.setattr("rrp_sheets.recording.deleting._MOST_SECONDS", -1.0)
    left = search_code(CODE, folder, frozenset({(folder / "runs").resolve()}))
    monkeypatch.undo()
    assert left.found == ["P-07.txt (its name)"] and left.whole
    assert {"a.txt", "b.txt", "c.txt"} <= {u.name for u in left.unsearched}
    planned = plan(folder, CODE)
    assert not planned.unsearched and planned.as_dict()["looked_through_everything"]


# ---- folders below ----


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """Runs of P-07 in a folder and in two below it, one deep; and what looks like more."""
    made = tmp_path / "study"
    write_run(made, "1-a", HEADER | {"participant": CODE}, EVENT, END)
    write_run(made, "2-b", HEADER, EVENT, END)
    write_run(made / "group B", "1-a", HEADER | {"participant": CODE}, EVENT, END)
    write_run(made / "group B", "2-b", HEADER, EVENT, END)
    write_run(made / "group 'C'" / "タロウ", "3-c", of(CODE), remembers("Guest 1"), END)
    remember(made / "group 'C'" / "タロウ", "Guest 1", CODE)
    write_run(made / "runs" / "2-b" / "inside", "1-x", HEADER | {"participant": CODE}, EVENT, END)
    write_run(made / ".venv", "1-x", HEADER | {"participant": CODE}, EVENT, END)
    (made / ".venv" / "pyvenv.cfg").touch()
    write_run(tmp_path / "other study", "9-x", HEADER | {"participant": CODE}, EVENT, END)
    (made / "link").symlink_to(tmp_path / "other study")
    return made


def test_runs_in_folders_below_are_told_and_stay(study: Path) -> None:
    told = run("delete", study, "--participant", CODE, typed=f"{CODE}\n")
    assert told.exit_code == 0 and "To be deleted: 1 run of P-07" in told.output
    assert f"1 run in group B: rrp-sheets runs delete '{study}/group B' --participant P-07" in told.output
    assert "group 'C'/タロウ: rrp" in told.output and "All of them go with --below." in told.output
    assert (
        "9-x" not in told.output
        and "also appears in these files, which were not changed:\n  runs/2-b/inside/" in told.output
    )
    assert told.output.endswith("Deleted: 1 run, 0 remembered faces.\n")
    assert (study / "group B" / "runs" / "1-a").is_dir() and not (study / "runs" / "1-a").exists()
    with pytest.raises(SheetsError, match="are in folders below: group 'C'/タロウ, group B"):
        CliRunner().invoke(group, ["runs", "delete", str(study), "--participant", CODE], catch_exceptions=False)
    command = shlex.split(told.output.split("group B: rrp-sheets ")[1].splitlines()[0])
    assert CliRunner().invoke(group, [*command, "--yes"]).exit_code == 0
    assert [p.name for p in (study / "group B" / "runs").iterdir()] == ["2-b"]


def test_with_below_everything_of_the_code_goes(study: Path, tmp_path: Path) -> None:
    told = json.loads(run("delete", study, "--participant", CODE, "--below", "--yes", "--json").stdout)
    assert [(d["folder"], len(d["runs"])) for d in told["below"]] == [("group 'C'/タロウ", 1), ("group B", 1)]
    assert told["below_deleted"] is True and told["begun_meanwhile"] == []
    left = [p.relative_to(study).parts[0] for p in map(Path, bytes_with(study))]
    assert set(left) == {".venv", "runs"}  # what is in a run, or in software, is none of the folder's runs
    assert kept(study / "group 'C'" / "タロウ") == []
    assert (tmp_path / "other study" / "runs" / "9-x").is_dir()
    assert "goes with --participant" in run("delete", study, "--run", "2-b", "--below").output


# ---- a run that begins meanwhile ----


def test_a_run_that_begins_is_told_when_it_may_be_of_the_code(study: Path) -> None:
    planned = plan(study, CODE)
    new = study / "runs" / "8-new"
    new.mkdir()
    with locked(new):
        with pytest.raises(SheetsError, match="8-new has just started"):
            plan(study, CODE)
        with pytest.raises(SheetsError, match="8-new has just started"):
            delete(planned)
    assert (study / "runs" / "1-a").is_dir()
    write_run(study, "9-new", HEADER | {"participant": CODE}, EVENT, END)
    assert delete(planned) == ("9-new",)  # it came after what was told, and stays whole
    assert not (study / "runs" / "1-a").exists() and (study / "runs" / "9-new" / "trace.jsonl").is_file()


def test_a_run_whose_last_files_are_written_is_refused(study: Path) -> None:
    with (
        locked(study / "runs" / "1-a"),
        pytest.raises(SheetsError, match="1-a is still in progress, or is still being written"),
    ):
        plan(study, CODE)
    assert len(plan(study, CODE).runs) == 1


def test_deleting_while_a_run_of_the_code_begins_leaves_nothing_half(tmp_path: Path) -> None:
    shutil.copy(bundled("workbooks") / "simple-tracking.xlsx", tmp_path / "book.xlsx")
    write_run(tmp_path, "1-a", HEADER | {"participant": CODE}, EVENT, END)
    command = [*forked.COMMAND, "run", "book.xlsx", "--fast", "--for", "0.5s", "--participant", CODE]
    refused = set[str]()
    with forked.Forked(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        while process.poll() is None:
            try:
                delete(plan(tmp_path, CODE))
            except SheetsError as error:
                refused.add(error.message)
            with suppress(subprocess.TimeoutExpired):
                process.wait(0.01)
    assert process.returncode == 0 and any("in progress, or is still being written" in said for said in refused)
    places = [p for p in (tmp_path / "runs").iterdir() if p.is_dir()]
    for place in places:  # when it was not deleted, it is whole
        assert {"trace.jsonl", "protocol.xlsx", "run.xlsx", "diagram.svg"} <= {p.name for p in place.iterdir()}
    if places:
        delete(plan(tmp_path, CODE))
    assert bytes_with(tmp_path / "runs") == []


# ---- remembered faces ----


def remember(folder: Path, *names: str) -> None:
    memory = FaceMemory()
    for number, name in enumerate(names, 1):
        memory.add(number, name, [np.full(128, 0.1, np.float32)])
    write_memory(folder / "runs" / "faces.json", memory)


def test_faces_go_with_the_session_that_remembered_them(tmp_path: Path) -> None:
    write_run(tmp_path, "1", of(CODE, "2026-11-01T09:00:00+00:00"), remembers("Guest 1"), remembers("Guest 2"), END)
    write_run(tmp_path, "2", of("P-08", "2026-11-03T09:00:00+00:00"), remembers("Guest 2"), remembers("Guest 3"), END)
    write_run(tmp_path, "3", of(CODE, "2026-11-04T09:00:00+00:00"), recognises("Guest 3"), recognises("Guest 1"), END)
    write_run(tmp_path, "4", of("P-09", "2026-11-05T09:00:00+00:00", faces="forgotten"), remembers("Guest 1"), END)
    remember(tmp_path, "Guest 1", "Guest 2", "Guest 3", "Guest 4", CODE)
    fates = {f.name: (f.goes, f.why) for f in plan(tmp_path, CODE).faces}
    assert fates == {
        "Guest 1": (True, "it was remembered in the run 1"),
        "Guest 2": (False, "it was remembered in the run 2 of P-08."),  # the name was used again
        "Guest 3": (False, "it was remembered in the run 2 of P-08. It was recognised in a run that is deleted."),
        "Guest 4": (False, "no run here has its participant."),
        CODE: (True, "it has that code as its name"),
    }
    told = run("delete", tmp_path, "--participant", CODE, "--yes").output
    assert "Remembered face “Guest 1” will be deleted" in told and "Is it the same person? Then delete it too" in told
    assert kept(tmp_path) == ["Guest 2", "Guest 3", "Guest 4"] and bytes_with(tmp_path) == []


def test_a_note_of_another_device_claims_no_face(tmp_path: Path) -> None:
    write_run(tmp_path, "1", of(CODE), remembers("Guest 1") | {"stream": "Say"}, "garbage", END)
    remember(tmp_path, "Guest 1")
    assert [f.goes for f in plan(tmp_path, CODE).faces] == [False]


def test_faces_that_cannot_be_read_are_told_and_the_runs_go(tmp_path: Path) -> None:
    write_run(tmp_path, "1", of(CODE), remembers("Guest 1"), END)
    (tmp_path / "runs" / "faces.json").write_text("garbage")
    told = run("delete", tmp_path, "--participant", CODE, "--yes")
    assert "cannot be read" in told.output and told.exit_code == 0 and not (tmp_path / "runs" / "1").exists()


def test_faces_wait_for_a_run_that_would_write_them_again(tmp_path: Path) -> None:
    write_run(tmp_path, "1", of(CODE), remembers("Guest 1"), END)
    other = write_run(tmp_path, "2", of("P-08"), EVENT) / "trace.jsonl"
    remember(tmp_path, "Guest 1")
    with other.open("a") as written:
        lock(written)
        with pytest.raises(SheetsError, match="would write the remembered faces again"):
            delete(plan(tmp_path, CODE))
    assert kept(tmp_path) == ["Guest 1"] and (tmp_path / "runs" / "1").is_dir()
    shutil.rmtree(other.parent)
    delete(plan(tmp_path, CODE))
    assert kept(tmp_path) == []


def test_two_people_who_delete_the_same_runs_at_once_leave_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in (1, 2):
        write_run(tmp_path, f"run-{number}", of(CODE), END)
    planned, again = plan(tmp_path, CODE), plan(tmp_path, CODE)
    unlink = Path.unlink

    def a_moment_late(path: Path, missing_ok: bool = False) -> None:
        os.unlink(path)
        unlink(path, missing_ok)

    with monkeypatch.context() as late:
        late.setattr(Path, "unlink", a_moment_late)
        delete(planned)
    assert list((tmp_path / "runs").iterdir()) == []
    delete(again)
    write_run(tmp_path, "run-3", of(CODE), END)
    monkeypatch.setattr("rrp_sheets.recording.deleting._files", lambda place: [place / "gone"])
    with pytest.raises(SheetsError, match="just deleted"):
        plan(tmp_path, CODE)
