// The page: the grid, its menus, what others do, and the panels that follow the check.

import { Grid } from "./grid.js";
import { diagram } from "./diagram.js";
import { finder } from "./find.js";
import { help } from "./help.js";
import { identity } from "./identity.js";
import { listening } from "./listening.js";
import { menu } from "./menu.js";
import { people } from "./people.js";
import { renewed } from "./renewed.js";
import { splitter } from "./splitter.js";
import { tabs } from "./tabs.js";
import { tests } from "./tests.js";

const scroll = document.getElementById("grid-scroll");
const listen = document.getElementById("listen");
const page = identity();
let wordsDigest = ""; // of the suggested words that are here
const grid = scroll.querySelector("[role=grid]") ? new Grid(scroll, page) : null;

diagram(document.getElementById("panels"));
if (grid) {
  const who = new URLSearchParams({ client: grid.server.client, name: grid.server.name, had: listen.dataset.told, knows: document.getElementById("panels").ariaBusy === "true" ? "no" : "yes" });
  listen.setAttribute("hx-sse:connect", `${listen.getAttribute("hx-sse:connect")}?${who}`);
  listening(listen);
  icons(grid.table.rows);
  grid.table.grid.addEventListener("rrp:rows", ({ detail }) => icons(detail.came));
  menu(grid);
  finder(grid);
  people(grid, listen);
  help(grid);
  splitter();
  tabs(grid, listen);
  renewed(grid, listen);
  tests(grid, listen);
  if (document.getElementById("panels").ariaBusy !== "true") fetchWords(); // else they come with the check
  fetchRest(grid).catch(() => {}).then(() => {
    grid.complete();
    document.body.toggleAttribute("data-ready", true);
    grid.drafts.offer();
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
    const response = await fetch(`${url}${count}?after=${last}`);
    const html = response.ok ? await response.text() : "";
    const holder = document.createElement("template");
    holder.innerHTML = html;
    const rows = [...holder.content.querySelectorAll("tr")];
    if (!rows.length) return;
    last = rows.at(-1).id;
    count += rows.length;
    server.piece([...holder.content.children]);
    await new Promise((resume) => setTimeout(resume, 0));
  }
}

listen.addEventListener("grid", (event) => {
  grid?.server.receive(JSON.parse(event.detail.data));
});
listen.addEventListener("checked", async ({ detail }) => {
  if (!("orphan" in document.body.dataset)) htmx.trigger("#panels", "recheck"); // else its sheet is gone
  if (JSON.parse(detail.data).words !== wordsDigest) await fetchWords();
  document.getElementById("panels").removeAttribute("aria-busy");
});

async function fetchWords() {
  const response = await fetch(`${grid.server.url}/vocabulary`);
  if (response.ok) {
    grid.words = await response.json();
    wordsDigest = response.headers.get("ETag")?.replaceAll('"', "");
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
listen.addEventListener("trouble", (event) => grid?.say(JSON.parse(event.detail.data).message, "error"));

// F6: from the sheet to what stands beside it, and back
document.addEventListener("keydown", (event) => {
  if (event.key !== "F6" || !grid) return;
  event.preventDefault();
  const beside = [...document.querySelectorAll("#panels a[href], #panels button, #panels [tabindex='0']")].find((part) => part.checkVisibility());
  if (!beside || document.activeElement.closest("#panels")) grid.selection.cell?.focus({ preventScroll: true });
  else beside.focus();
});

document.addEventListener("click", (event) => {
  const action = event.target.closest("[data-do]")?.dataset.do;
  if (action === "undo") grid.undo();
  if (action === "redo") grid.redo();
  if (action === "help") document.dispatchEvent(new CustomEvent("rrp:help"));
  if (action === "find") document.dispatchEvent(new CustomEvent("rrp:find"));
  if (action === "rows") {
    const box = event.target.closest("[data-do]").getBoundingClientRect();
    document.dispatchEvent(new CustomEvent("rrp:menu", { detail: { x: box.left, y: box.bottom } }));
  }
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

// a box of the diagram was chosen
document.addEventListener("rrp:goto", ({ detail }) => {
  const row = grid && [...grid.table.rows].find((r) => r.cells[0].textContent === String(detail.number));
  if (row) grid.selection.go(row, Math.max(grid.table.headers.findIndex((h) => h.dataset.kind === "connector"), 0));
});
document.addEventListener("htmx:after:swap", () => grid?.look());

// connectors show their icon
function icons(rows) {
  const source = document.querySelector(".topbar use").getAttribute("href").replace(/#.*/, "");
  for (const word of rows.flatMap((row) => [...row.querySelectorAll(".word[data-icon]")])) {
    const holder = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    holder.setAttribute("class", "icon");
    holder.setAttribute("aria-hidden", "true");
    const use = document.createElementNS("http://www.w3.org/2000/svg", "use");
    use.setAttribute("href", `${source}#i-${word.dataset.icon}`);
    holder.append(use);
    delete word.dataset.icon;
    word.before(holder);
  }
}
