// The tutorial beside the sheet: one lesson at a time. The server renders it and says whether its test passes; where one is, and that
// the panel is closed, is remembered for the workbook in this browser. “Show me” writes a step above the sheet and takes it away
// again: nothing is sent, so nothing of anybody's is lost, and no test passes by it.

import { hasCalm } from "../preferences.js";
import { make } from "../elements.js";
import { t } from "../texts.js";

const LETTER_MS = 60; // between two letters that are shown
const PAUSE_MS = 500; // between two cells
const LASTS_MS = 3000; // what was shown, in the end

export function lesson(grid, listen) {
  const panel = document.getElementById("lesson");
  if (!panel) return;
  const key = `lesson ${grid.server.url}`;
  const known = remembered();
  const [address, place] = /^(.*\/lesson\/)\d+(.*)$/.exec(panel.getAttribute("hx-get")).slice(1);
  const show = player(grid);
  let going = 0; // to another lesson, which is to be told when it is there

  document.addEventListener("htmx:after:swap", told);
  for (const event of ["checked", "tested"]) listen.addEventListener(event, renew);
  panel.addEventListener("click", (event) => {
    const { lessonGo, lessonDo, to, cells } = event.target.closest("button")?.dataset ?? {};
    if (lessonGo) go(Number(lessonGo));
    else if (lessonDo === "close") close();
    else if (lessonDo === "show") show(JSON.parse(cells));
    else if (lessonDo === "next") next(event.target.closest("button"), Number(to));
  });
  document.addEventListener("click", (event) => { // in the help; it leads to the workbooks where there is no lesson
    if (!event.target.closest("[data-tutorial]")) return;
    event.preventDefault();
    document.querySelector("[data-help-close]").click();
    open();
  });
  panel.hidden = Boolean(known.closed);
  if (known.at && String(known.at) !== panel.dataset.first) {
    panel.classList.add("waits"); // for the lesson where one was: the server does not know it
    window.addEventListener("load", () => go(known.at, false));
    setTimeout(() => panel.classList.remove("waits"), LASTS_MS); // it is gone, perhaps
  }

  function remembered() {
    try {
      return JSON.parse(localStorage.getItem(key)) ?? {};
    } catch {
      return {};
    }
  }

  function keep(what) {
    Object.assign(known, what);
    try {
      localStorage.setItem(key, JSON.stringify(known));
    } catch { // it is remembered as long as the page is open
    }
  }

  function go(number, tell = true) {
    keep({ at: number });
    going = tell ? number : 0;
    panel.setAttribute("hx-get", `${address}${number}${place}`);
    renew();
  }

  function at() {
    return Number(panel.querySelector("[data-lesson-go][aria-current]").dataset.lessonGo);
  }

  function renew() {
    if (!panel.hidden && !("orphan" in document.body.dataset)) htmx.trigger("#lesson", "recheck");
  }

  function told() {
    if (at() === known.at) panel.classList.remove("waits");
    if (!going || at() !== going) return;
    going = 0;
    const [where, title] = ["lesson-place", "lesson-title"].map((id) => document.getElementById(id).textContent);
    grid.say(t("{lesson}: {title}", { lesson: where, title }));
    panel.scrollTop = 0;
  }

  function next(button, to) {
    if (button.ariaDisabled === "true") grid.say(t("This lesson is not done yet. Finish it, or choose Skip."), true);
    else if (to) go(to);
    else close();
  }

  function close() {
    panel.hidden = true;
    keep({ closed: true });
    grid.selection.cell?.focus({ preventScroll: true });
    grid.say(t("The tutorial is closed. You can open it again from Help."));
  }

  function open() {
    panel.hidden = false;
    keep({ closed: false });
    renew();
    panel.scrollIntoView({ block: "nearest" });
    document.getElementById("lesson-title").focus();
  }
}

/** Shows cells as they are to be written, in a layer above the sheet; the next key or press anywhere ends it. */
function player({ table, scroll, selection, say }) {
  let over = () => {};
  return async (cells) => {
    over();
    const shown = [];
    let goes = true;
    const end = () => {
      goes = false;
      for (const one of shown) one.remove();
      for (const event of ["keydown", "pointerdown"]) window.removeEventListener(event, end, true);
    };
    over = end;
    const known = cells.filter(({ row, kind }) => table.row(row) && table.ofKind(kind) >= 0);
    if (!known.length) return;
    const [{ row, kind }] = known;
    selection.go(table.row(row), table.ofKind(kind));
    setTimeout(() => goes && ["keydown", "pointerdown"].forEach((event) => window.addEventListener(event, end, true)));
    say(t("This is an example. Nothing was changed in your workbook: now do it yourself."));
    for (const cell of known) {
      if (!await write(cell, shown, () => goes)) return;
    }
    await rest(LASTS_MS);
    if (goes && !hasCalm()) end(); // who wants no motion ends it by a key
  };

  async function write({ row, kind, text }, shown, goes) {
    const cell = table.cell(table.row(row), table.ofKind(kind));
    const box = make("div", { className: "shown-step", ariaHidden: "true" });
    const [mine, frame] = [cell.getBoundingClientRect(), scroll.getBoundingClientRect()];
    Object.assign(box.style, {
      left: `${mine.left - frame.left + scroll.scrollLeft}px`, top: `${mine.top - frame.top + scroll.scrollTop}px`,
      minWidth: `${mine.width}px`, minHeight: `${mine.height}px`,
    });
    shown.push(box);
    scroll.append(box);
    const whole = kind === "on" ? "✓" : text;
    for (let n = hasCalm() ? whole.length : 1; n <= whole.length && goes(); n++) {
      box.textContent = whole.slice(0, n);
      if (n < whole.length) await rest(LETTER_MS);
    }
    if (!hasCalm()) await rest(PAUSE_MS);
    return goes();
  }
}

const rest = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
