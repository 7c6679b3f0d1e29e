"""State of a run in the run panel's server, without a browser: the newest values, the log, refusals."""

from __future__ import annotations

import json
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from browser import TOKEN, let_in

from rrp_sheets.documents import CellText
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.exchange import Notice, OperatorAction, WorldState
from rrp_sheets.model.values import Failure, record_from_mapping
from rrp_sheets.runs.check_worker import CheckWorker, Findings
from rrp_sheets.runs.run_data import RunStart
from rrp_sheets.texts import N_
from rrp_sheets.web import workbook_session
from rrp_sheets.web.app import create_app
from rrp_sheets.web.run_session import RunManager, RunOptions
from rrp_sheets.web.run_state import RunState
from rrp_sheets.web.workbook_session import EventStream, OpenWorkbooks, WorkbookSession, message
from rrp_sheets.workbook.files import make_workbook

START = RunStart(
    "Ball", 10_000_000, Path("runs/x"),
    streams={"redball": "Red ball", "a!distance": "A!Distance", "b!distance": "B!Distance", "a!#4": "A!#4",
             "a!near": "A!Near", "headtracker": "Head tracker", "headtrackerdone": "Head tracker done", "say": "Say",
             "go": "Go"},
    actuators={"headtracker": "Head tracker", "say": "Say"}, behaviours=(("A", True), ("B", False)),
    buttons=(("Go", "Start"),), resources={"headtracker": ("head",), "say": ("voice",)},
)  # fmt: skip
ROWS = {"A!2": "w2", "A!3": "w3", "A!5": "w5"}
BALL = record_from_mapping("Red ball", {"x": 0.1, "y": -0.2, "distance": 0.5, "colour": "red"})


def put_to(x: int) -> str:
    return N_("{thing} is placed at {place} m.", thing="Red ball", place=f"{x}, 0, 0")


@pytest.fixture
def run_state() -> RunState:
    run_state = RunState(ROWS, {"A!2": "m"}, lambda what: None)
    run_state.started(START)
    return run_state


def test_only_what_is_new_is_told_and_a_page_that_joins_is_told_all(run_state: RunState) -> None:
    for us in range(0, 1_000_000, 1_000):  # a flood: one row is told once, with its newest value
        run_state.event(us, "redball", "", BALL)
        run_state.event(us, "a!distance", "A!2", us / 2_000_000)
    run_state.frame(1_000_000)
    told, _ = run_state.news()
    assert told is not None
    assert told["rows"] == {"w2": {"v": "0.499 m", "at": 0.999, "n": 1000, "e": ""}}
    assert {n: s["kind"] for n, s in told["streams"].items()} == {"Red ball": "sensor", "A!Distance": "stream"}
    assert told["fields"]["Red ball"] == {"x": 0.1, "y": -0.2, "distance": 0.5, "colour": "red"}
    plots = dict(told["plots"])
    assert plots["A!Distance"][0] == [0.0, 0.0] and plots["A!Distance"][-1] == [0.999, 0.4995]
    assert all(len(points) <= 4 for points in plots.values()) and "Red ball.distance" in plots
    assert run_state.news() == (None, [])
    run_state.event(1_100_000, "a!near", "A!3", True)
    run_state.frame(1_100_000)
    assert list(run_state.news()[0]["rows"]) == ["w3"]
    everything, _ = run_state.all()
    assert everything["full"] and set(everything["rows"]) == {"w2", "w3"} and "Near" in everything["streams"]
    assert dict(everything["plots"])["A!Distance"] == plots["A!Distance"]


def test_an_error_stands_until_values_come_for_a_second_and_is_told_once(run_state: RunState) -> None:
    for us in (0, 100_000, 200_000):
        run_state.error(us, "A!2", Failure("FORM020", "This formula divides by zero."), ())
    run_state.event(300_000, "a!distance", "A!2", 1.0)
    told, lines = run_state.news()
    assert told["rows"]["w2"]["e"] == "This formula divides by zero."
    assert [(n["kind"], n["row"], n["id"]) for n in lines] == [("error", "A!2", "w2")]
    run_state.event(1_300_000, "a!distance", "A!2", 1.0)
    assert run_state.news()[0]["rows"]["w2"]["e"] == ""


def test_the_log_tells_commands_once_and_what_is_said_with_its_sound(run_state: RunState) -> None:
    for us in range(0, 3_000_000, 33_000):  # a tracker fed at camera rate
        run_state.event(us, "headtracker", "A!5", 0.5)
    run_state.event(3_000_000, "headtracker", "A!5", None)
    run_state.event(3_100_000, "say", "A!3", "Hello")
    run_state.notice(3_200_000, Notice("say", "Hello", "say", "A!3", "say-001.wav"))
    run_state.acted(3_300_000, OperatorAction("mark", "Kai laughs", "Mika"))
    for us in range(3_400_000, 4_000_000, 100_000):
        run_state.acted(us, OperatorAction("scene", put_to(1), "Mika", {"thing": "Red ball", "put": [1, 0, 0]}))
        run_state.refused("put", "Blue ball cannot be placed there.", "")
    lines = run_state.news()[1]
    assert [(n["kind"], n["text"], n["by"], n["sound"]) for n in lines] == [
        ("command", "0.5", "", ""), ("command", "stops", "", ""), ("speech", "Hello", "", "say-001.wav"),
        ("mark", "Kai laughs", "Mika", ""), ("scene", "Red ball is dragged to 1, 0, 0 m.", "Mika", ""),
        ("refused", "Blue ball cannot be placed there.", "", ""),
    ]  # fmt: skip
    assert run_state.news()[1] == [] and run_state.all()[1] == lines


def test_a_thing_that_is_dragged_is_one_line_that_tells_its_last_place(run_state: RunState) -> None:
    def put(us: int, x: int, by: str = "Mika") -> None:
        act = OperatorAction("scene", put_to(x), by, {"thing": "Red ball", "put": [x, 0, 0]})
        run_state.acted(us, act)

    put(0, 1)
    [first] = run_state.news()[1]
    for n in range(2, 30):
        put(n * 100_000, n)
        run_state.event(n * 100_000, "headtracker", "A!5", n / 10)  # what the robot does meanwhile does not divide it
    assert all(line["kind"] == "command" for line in run_state.news()[1]), "told again when it stands"
    run_state.acted(3_000_000, OperatorAction("mark", "Kai laughs", "Ken"))
    moved, mark = (line for line in run_state.news()[1] if line["kind"] != "command")
    assert (moved["text"], moved["t"], moved["instead"]) == ("Red ball is dragged to 29, 0, 0 m.", 2.9, first["i"])
    assert mark["text"] == "Kai laughs"
    put(3_100_000, 5)
    put(3_200_000, 6, "Ken")
    put(7_000_000, 7, "Ken")
    assert [line["text"][-10:] for line in run_state.news()[1]] == ["5, 0, 0 m.", "6, 0, 0 m.", "7, 0, 0 m."]
    kept = [line["text"] for line in run_state.all()[1] if line["kind"] == "scene"]
    assert len(kept) == 4 and "dragged" in kept[0]


def test_memory_stays_small_however_long_a_run_is(run_state: RunState) -> None:
    for us in range(0, 4_000_000_000, 1_000_000):
        run_state.event(us, "a!distance", "A!2", us / 1e9)
        run_state.acted(us, OperatorAction("mark", "x" * 500, "Mika"))
        run_state.state(us, WorldState({}, (0,) * 6, (0, 0, 0), "", {}, {"head": f"A!{us % 7}"}))
        run_state.frame(us)
        run_state.news()
    told, lines = run_state.all()
    assert len(lines) == 400 and len(lines[0]["text"]) == 300 and len(told["drives"]) == 400
    assert len(json.dumps(told)) < 60_000


def test_who_drives_what_goes_over_short_pauses(run_state: RunState) -> None:
    def see(us: int, **driving: str) -> list[list[object]]:
        run_state.state(us, WorldState({}, (0,) * 6, (1, 1, 1), "", {}, driving))
        run_state.frame(us)
        return run_state.news()[0].get("drives", [])

    assert see(0, head="A!5") == [["head", "A!5", 0.0, None]]
    assert see(80_000, head="A!5") == []
    assert see(160_000) == [["head", "A!5", 0.0, 0.16]]
    assert see(500_000, head="A!5") == [["head", "A!5", 0.0, None]]
    assert see(900_000, head="A!3") == [["head", "A!5", 0.0, 0.9], ["head", "A!3", 0.9, None]]
    assert run_state.all()[0]["drives"] == [["head", "A!5", 0.0, 0.9], ["head", "A!3", 0.9, None]]


def test_a_page_that_lags_behind_is_told_the_newest_instead_of_everything() -> None:
    listener = EventStream("a", "Mika")
    for number in range(200):
        listener.tell_live(message("live", {"t": number}))
    listener.tell(message("run", {"phase": "stopping"}))
    text = listener.take(lambda: [("live", {"full": True})])
    assert text.count("event: live") == 1 and '"full":true' in text and "stopping" in text
    listener.tell_live(message("live", {"t": 201}))
    assert '"t":201' in listener.take(list)


# ---- what is refused
HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = tmp_path_factory.mktemp("books")
    make_workbook({"T": [HEADER, ["", "Red ball", "map", "redBall.distence", "Distance", ""]]}, folder / "bad.xlsx")
    make_workbook({"T": [HEADER, ["", "Red ball", "subscribe", "", "Head tracker", ""]]}, folder / "b.xlsx")
    return let_in(create_app(folder, TOKEN))


def post(client, where: str, **sent):
    return client.post(where, json=sent, headers={"X-RRP": "grid", "Origin": "http://localhost"})


@pytest.mark.parametrize(
    ("action", "sent", "status"),
    [
        ("mark", {"note": "x"}, 409), ("pause", {}, 409), ("dance", {}, 404), ("clear", {}, 200),
        ("start", {"mode": "real"}, 400), ("start", {"speed": 3}, 400), ("start", {"participant": "x" * 61}, 400),
        ("start", {"name": ["a"]}, 400),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(client, action: str, sent: dict, status: int) -> None:
    assert post(client, f"/book/b.xlsx/run/{action}", **sent).status_code == status


def test_a_workbook_with_errors_does_not_run(client) -> None:
    while "checking" in client.get("/book/bad.xlsx/panels/T").text:
        pass
    answer = post(client, "/book/bad.xlsx/run/start")
    assert answer.status_code == 409 and "has errors" in answer.json["message"]
    assert client.get("/run/now").json == {"phase": "none", "book": ""}


def test_there_is_nothing_to_see_or_hear_without_a_run(client) -> None:
    assert post(client, "/book/b.xlsx/run/look", on=True).status_code == 409
    for name in ("say-001.wav", "..%2fb.xlsx", "trace.jsonl"):
        assert client.get(f"/run/sound/{name}").status_code == 404


def test_nobody_else_can_stop_a_run(client) -> None:
    where = "/run/stop"
    assert client.post(where, json={}).status_code == 403
    assert client.post(where, json={}, headers={"X-RRP": "grid", "Origin": "http://evil.test"}).status_code == 403


@pytest.mark.parametrize("sent", ["", "?name=", "?name=%ff%00%ed%a0%80", f"?name={'x' * 10_000}", "?name=A&name=B"])
def test_stop_is_not_refused_for_what_is_sent_with_it(client, sent: str) -> None:
    headers = {"X-RRP": "grid", "Origin": "http://localhost"}
    for body in (b"", b"{", b"\xff" * 100_000):
        answer = client.post(f"/run/stop{sent}", headers=headers, data=body, content_type="application/json")
        assert answer.status_code == 409 and answer.json == {"message": "No run is in progress."}


def test_stop_does_not_wait_for_a_workbook_that_is_being_opened(tmp_path: Path, monkeypatch) -> None:
    for name in ("b.xlsx", "large.xlsx"):
        make_workbook({"T": [["Input streams", "Connector", "Formula", "Output stream"]]}, tmp_path / name)
    client = let_in(create_app(tmp_path, TOKEN))
    opening, go_on = threading.Event(), threading.Event()

    def slowly(*_: object) -> None:
        opening.set()
        go_on.wait(600)
        raise SheetsError("It was too large.", "")

    monkeypatch.setattr(workbook_session, "Document", slowly)
    page = threading.Thread(target=lambda: client.get("/book/large.xlsx"))
    page.start()
    try:
        assert opening.wait(300)
        headers = {"X-RRP": "grid", "Origin": "http://localhost"}
        answered = []
        asked = threading.Thread(target=lambda: answered.append(client.post("/run/stop", headers=headers)), daemon=True)
        asked.start()
        asked.join(300)
        assert [answer.status_code for answer in answered] == [409]  # there is no run
    finally:
        go_on.set()
        page.join()


# ---- edits while it runs
class Held(CheckWorker):
    """A check whose answer comes when it is let go."""

    def __init__(self) -> None:
        super().__init__()
        self.answer, self.begun = threading.Event(), threading.Event()
        self.answer.set()

    def check(self, path: Path) -> Findings:
        found = super().check(path)
        self.begun.set()
        assert self.answer.wait(300)
        return found


@pytest.mark.slow
def test_a_mistake_that_is_mended_before_its_check_has_ended_does_not_stay_unused(tmp_path: Path) -> None:
    rows = [["", "Red ball", "map", "redBall.distance", "Distance", ""], ["", "Distance", "subscribe", "", "Print", ""]]
    make_workbook({"T": [HEADER, *rows]}, tmp_path / "b.xlsx")
    worker = Held()
    open_workbooks = OpenWorkbooks(tmp_path, worker)
    run_manager, session = RunManager(open_workbooks), open_workbooks.session(tmp_path / "b.xlsx")
    page = session.join("a", "Aya")
    session.analysis()  # begins the first check
    hear(page, "checked")
    run = run_manager.start(session, "b.xlsx", RunOptions("Aya", speed=0))
    hear(page, '"phase":"running"')
    worker.answer.clear()
    worker.begun.clear()
    put(session, "redBall.distence")
    assert worker.begun.wait(300)
    put(session, "redBall.distance + 7")
    worker.answer.set()
    assert "not used while there are errors" in hear(page, '"kind":"edit"')
    run.stop("Aya")
    assert '"restart":""' in hear(page, '"phase":"ended"')


def put(session: WorkbookSession, text: str) -> None:
    grid = session.document.grids["T"]
    cell = CellText(grid.rows[0], 4, text)
    assert not session.change("b", "Aya", "", lambda document: document.set_cells("Aya", "T", [cell])).get("message")


def hear(page: EventStream, words: str) -> str:
    """Events that a page gets, until some words come."""
    heard, until = "", time.monotonic() + 90
    while words not in heard:
        assert time.monotonic() < until, heard[-2000:]
        heard += page.take(str)
    return heard


def test_a_picture_is_told_by_its_number_and_who_joins_hears_how_old_it_is(run_state: RunState, monkeypatch) -> None:
    now = 100.0
    monkeypatch.setattr("rrp_sheets.web.run_state.time", SimpleNamespace(monotonic=lambda: now))
    run_state.state(0, WorldState({}, (), (), "", {}))
    run_state.picture(0, b"first")
    run_state.picture(0, b"second")
    told, _ = run_state.news()
    assert told is not None and (told["eye"], "eye_age" in told, run_state.jpeg) == (2, False, b"second")
    run_state.picture(0, bytes(b"second"[:6]))
    assert run_state.news()[0]["eye"] == 3
    now += 7.5
    told, _ = run_state.all()
    assert (told["eye"], told["eye_age"]) == (3, 7.5)


def test_of_the_robot_only_what_has_changed_is_told(run_state: RunState) -> None:
    def told(**joints: float) -> object:
        run_state.state(0, WorldState(joints, (0.0, 0.0, 0.3), (1.0, 1.0, 1.0), "", {"Ball": (1.0, 0.0, 0.4)}))
        news, _ = run_state.news()
        return news and news.get("robot")

    first = told(HeadYaw=0.1, HeadPitch=0.2)
    assert first["joints"] == {"HeadYaw": 0.1, "HeadPitch": 0.2} and first["things"] == {"Ball": [1.0, 0.0, 0.4]}
    assert told(HeadYaw=0.1, HeadPitch=0.2) is None
    assert told(HeadYaw=0.1, HeadPitch=0.3) == {"joints": {"HeadPitch": 0.3}}
    run_state.frame(1_000_000)
    assert told(HeadYaw=0.1, HeadPitch=0.3)["joints"] == {"HeadYaw": 0.1, "HeadPitch": 0.3}, "again each second"
    assert run_state.all()[0]["robot"]["joints"] == {"HeadYaw": 0.1, "HeadPitch": 0.3}, "a page that joins is told all"


def test_pictures_go_only_to_pages_that_show_them_and_never_queue(tmp_path: Path) -> None:
    make_workbook({"T": [HEADER]}, tmp_path / "b.xlsx")
    session = OpenWorkbooks(tmp_path, Held()).session(tmp_path / "b.xlsx")
    page, other = session.join("a", "Aya"), session.join("b", "Mika")
    for one in (page, other):
        one.take(str)
    assert not session.is_looked
    session.look("a", True, "picture 0 ")
    assert session.is_looked and page.take(str) == "picture 0 "
    session.tell_picture("picture 1 ")
    session.tell_picture("picture 2 ")
    session.tell_live([("values", {})])
    assert page.take(list) == "event: values\ndata: {}\n\npicture 2 ", "only the newest"
    assert other.take(list) == "event: values\ndata: {}\n\n"
    page.unsent = lambda: 50_000  # the browser reads slowly
    session.tell_picture("picture 3 ")
    assert page.take(str) == ""
    session.tell_picture("picture 4 ")
    session.tell_live([("values", {})])
    assert page.take(list) == "event: values\ndata: {}\n\n", "values and the phase do not wait for pictures"
    page.unsent = int
    assert page.take(str) == "picture 4 "
    session.look("a", False, "")
    session.tell_picture("picture 5 ")
    session.tell_live([("values", {})])
    assert page.take(list) == "event: values\ndata: {}\n\n" and not session.is_looked


def test_a_refusal_speaks_of_the_help_of_the_page_and_of_the_speed_there_is(run_state: RunState) -> None:
    run_state.speed = 4.0
    run_state.refused("send", "There is no function “RANDOM”.", N_("See `rrp-sheets help functions`."))
    told = run_state.news()[1][-1]["text"]
    assert told == "There is no function “RANDOM”. See Help (F1): functions." and run_state.speed == 4
    run_state.refused("speed", "An event loop has no speed.", "")
    assert run_state.speed == 1
