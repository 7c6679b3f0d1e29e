// The page: the grid, its menus, what others do, and the panels that follow the check.

import { identity, listening, request } from "../api.js";
import { command, press } from "../commands.js";
import { icon } from "../elements.js";
import { t } from "../texts.js";
import { diagram } from "./diagram.js";
import { finder } from "./find.js";
import { Grid } from "./grid.js";
import { help } from "./help.js";
import { lesson } from "./lesson.js";
import { menu } from "./menus.js";
import { people } from "./people.js";
import { rowWords } from "./row_words.js";
import { over as retract } from "./spoken.js";
import { sheetTabs } from "./tabs.js";
import { HEADER } from "./threads.js";
import { twoKeys } from "./two_keys.js";
import { splitter } from "./widths.js";

const LOOK_AGAIN = 500; // milliseconds until it is looked again whether somebody types

function renewed(grid, listen) {
  let waits = false;
  listen.addEventListener("program", ({ detail }) => {
    const { program } = listen.dataset;
    if (program && JSON.parse(detail.data).version !== program) wait(t("The program was updated."));
  });
  listen.addEventListener("reload", ({ detail }) => {
    const { sheet, why } = JSON.parse(detail.data);
    if (!sheet || sheet === grid.server.sheet) wait(why ?? t("This page is not up to date."));
  });

  function wait(why) {
    if (waits) return;
    waits = true;
    if (!load()) grid.say(t("{why} This page loads again when you have finished typing.", { why }));
  }

  function load() {
    const typing = grid.editor.isOpen || grid.server.unsent.entries.length || document.querySelector("dialog[open]")
      || document.activeElement?.matches("input:not([type=checkbox]), textarea:not(.waiting > *)");
    if (typing) {
      setTimeout(load, LOOK_AGAIN);
      return false;
    }
    const { row, cell } = grid.selection;
    if (cell) history.replaceState(history.state, "", grid.landing || `#${row.id}~${grid.table.address(cell)}`);
    location.reload();
    return true;
  }
}

// The workbook's tests: what they came to is shown anew when it is told, and what is new about it is said. A lesson in
// their list leads to its rows, a word beside it to its help.

function tests(grid, listen) {
  listen.addEventListener("tested", (event) => {
    if (!("orphan" in document.body.dataset)) htmx.trigger("#panels", "recheck");
    const { news } = JSON.parse(event.detail.data);
    if (news) grid.say(news);
  });
  document.addEventListener("click", (event) => {
    const term = event.target.closest("#panels [data-topic]");
    const lesson = event.target.closest("#panels [data-lesson]");
    if (event.ctrlKey || event.metaKey || !(term || lesson)) return; // a link opened in a tab of its own
    event.preventDefault();
    if (term) grid.help.open([term.dataset.topic]);
    else open(lesson.dataset.lesson);
  });

  /** The lesson to the top of the table, the cursor into its first row that is no comment. */
  function open(id) {
    const { table, scroll, selection } = grid;
    const heading = table.row(id);
    if (!heading) return;
    const rows = table.rows.slice(table.at(heading) + 1);
    const next = rows.findIndex((row) => /^#+\s*(?:lesson\s|レッスン)/i.test(table.value(row.querySelector("td[data-v]"))));
    const mine = next < 0 ? rows : rows.slice(0, next);
    const row = mine.find((one) => !one.classList.contains("comment")) ?? heading;
    scroll.scrollIntoView({ block: "nearest" });
    selection.go(row, Math.max(table.ofKind("inputs"), 0));
    scroll.scrollTop += heading.getBoundingClientRect().top - scroll.getBoundingClientRect().top - table.grid.tHead.offsetHeight;
  }
}

const scroll = document.getElementById("grid-scroll");
const listen = document.getElementById("listen");
const page = identity();
let wordsDigest = ""; // of the suggested words that are here
const grid = scroll.querySelector("[role=grid]") ? new Grid(scroll, page, listen) : null;

diagram(document.getElementById("panels"));
if (grid) {
  const who = new URLSearchParams({ client: grid.server.client, name: grid.server.name, had: listen.dataset.told });
  listen.setAttribute("hx-sse:connect", `${listen.getAttribute("hx-sse:connect")}?${who}`);
  listen.dataset.client = grid.server.client;
  listening(listen);
  icons(grid.table.rows);
  grid.table.grid.addEventListener("rrp:rows", ({ detail }) => icons(detail.came));
  grid.menu = menu(grid);
  grid.finder = finder(grid);
  grid.people = people(grid, listen);
  grid.help = help(grid);
  rowWords(grid);
  document.addEventListener("keydown", (event) => event.defaultPrevented || press("page", event, grid)); // not a key that a cell, for example, has taken
  splitter();
  sheetTabs(grid, listen);
  renewed(grid, listen);
  tests(grid, listen);
  lesson(grid, listen);
  twoKeys(grid);
  if (document.getElementById("panels").ariaBusy !== "true") fetchWords(); // else they come with the check
  fetchRest(grid).catch(() => {}).then(() => {
    grid.complete();
    document.body.toggleAttribute("data-ready", true);
    grid.drafts.offer();
    grid.threads.offer();
    if (id === HEADER) grid.threads.open(grid.table.named(place));
  });
  const [id, place] = decodeURIComponent(location.hash.slice(1)).split("~"); // a row, perhaps with the cell in it
  const wanted = id && document.getElementById(id);
  const first = (wanted && wanted.closest("tr")) || grid.table.rows.find((row) => !row.classList.contains("comment")) || grid.table.rows[0];
  const begin = grid.table.headers.findIndex((header) => header.dataset.kind !== "on");
  const at = grid.table.headers.findIndex((header) => header.dataset.letter === /^[A-Z]+/.exec(place ?? "")?.[0]);
  grid.selection.go(first, Math.max(at < 0 ? begin : at, 0), false, Boolean(wanted) || !(location.hash || document.getElementById("session")));
}

// a long sheet comes in pieces: its beginning is in the page, and each piece begins below the last row of the one before
async function fetchRest({ table, server }) {
  const url = table.grid.dataset.more.replace(/0$/, "");
  const wanted = Number(table.grid.dataset.count);
  let last = table.rows.at(-1)?.id;
  for (let count = table.rows.length; count < wanted;) {
    const { ok, json } = await request(`${url}${count}?after=${last}`);
    const holder = document.createElement("template");
    holder.innerHTML = ok ? json.html : "";
    const rows = [...holder.content.querySelectorAll("tr")];
    if (!rows.length) return;
    last = rows.at(-1).id;
    count += rows.length;
    server.piece([...holder.content.children], json.made);
    await new Promise((resume) => setTimeout(resume, 0));
  }
}

listen.addEventListener("checked", async ({ detail }) => {
  if (!("orphan" in document.body.dataset)) htmx.trigger("#panels", "recheck"); // else its sheet is gone
  if (grid && JSON.parse(detail.data).words !== wordsDigest) await fetchWords();
  document.getElementById("panels").removeAttribute("aria-busy");
});

async function fetchWords() {
  const { ok, json, etag } = await request(`${grid.server.url}/vocabulary`);
  if (ok) {
    grid.words = json;
    wordsDigest = etag?.replaceAll('"', "");
  }
  grid.editor.renew();
  document.body.toggleAttribute("data-words", true); // what can be suggested is here
}

// who closes the page is gone for the others at once; a page that comes back from the browser's memory begins anew
window.addEventListener("pagehide", () => {
  page.leave();
  grid?.server.part();
});
window.addEventListener("pageshow", (event) => event.persisted && location.reload());
if (!grid) listen.addEventListener("reload", () => location.reload());
listen.addEventListener("notice", (event) => {
  const line = document.getElementById("notice");
  if (line) line.textContent = JSON.parse(event.detail.data).text;
});
listen.addEventListener("trouble", (event) => {
  const { message, over } = JSON.parse(event.detail.data);
  retract(over);
  if (message) grid?.say(message, "error");
});

document.addEventListener("click", (event) => {
  if (!grid) return; // a workbook without sheets
  const button = event.target.closest("[data-do]");
  if (button) command(button.dataset.do, grid, button);
  const example = event.target.closest("[data-first-row]");
  if (example) firstRow(JSON.parse(example.dataset.firstRow));
  const fix = event.target.closest("[data-fix]");
  if (fix) grid.fix(fix);
  const link = event.target.closest("a[data-row]");
  if (link?.dataset.row && grid.table.row(link.dataset.row)) {
    event.preventDefault();
    const letter = /^[A-Z]+/.exec(link.dataset.cell)?.[0];
    const k = grid.table.headers.findIndex((h) => h.dataset.letter === letter);
    grid.selection.go(grid.table.row(link.dataset.row), Math.max(k, 0));
  }
});

/** An example in the first blank row, as one edit: texts by the number of the column. */
function firstRow(cells) {
  const { table, selection } = grid;
  const row = table.rows.find((one) => table.places.every((at) => !table.value(one.cells[at])));
  if (!row) return;
  grid.change(Object.entries(cells).map(([column, text]) => [table.cell(row, table.placeOf(Number(column))), text]));
  selection.go(row, 0);
  grid.say(t("The example is in row {n}. Press Ctrl+Z to undo.", { n: row.cells[0].textContent }));
}

// a box of the diagram was chosen
document.addEventListener("rrp:goto", ({ detail }) => {
  const row = grid && [...grid.table.rows].find((r) => r.cells[0].textContent === String(detail.number));
  if (row) grid.selection.go(row, Math.max(grid.table.ofKind("connector"), 0));
});
document.addEventListener("htmx:after:swap", () => grid?.stand());

// connectors show their icon
function icons(rows) {
  for (const word of rows.flatMap((row) => [...row.querySelectorAll(".word[data-icon]")])) {
    word.before(icon(word.dataset.icon));
    delete word.dataset.icon;
  }
}
