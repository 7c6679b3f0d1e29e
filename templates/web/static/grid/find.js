// Find and replace in the sheet that is shown, or in all sheets, with a list of what was found.

import { UNREACHED, request } from "../api.js";
import { isComposed } from "../commands.js";
import { button, make, put } from "../elements.js";
import { listed, t, tn } from "../texts.js";
import { key } from "./editor.js";

const RESTS_MS = 150; // after the last key, before the list is made
const MOST_LISTED = 100; // cells
const NAMES = /[\p{L}_][\p{L}\p{N}_]*/gu; // in a formula

export function finder(grid) {
  const { table, server } = grid;
  const bar = document.getElementById("find-bar");
  const { find, by, sameCase, whole, names, scope } = bar.elements;
  const count = bar.querySelector(".found");
  const list = document.getElementById("found");
  const kept = `find:${server.url}`; // in the browser's storage, on the way to another sheet
  let timer = 0;
  let newest = 0; // the number of the newest question for the other sheets
  let others = []; // what was found in them

  bar.addEventListener("submit", (event) => {
    event.preventDefault();
    next();
  });
  bar.addEventListener("input", ({ target }) => {
    if (target === by) return;
    clearTimeout(timer);
    timer = setTimeout(show, RESTS_MS);
  });
  for (const part of [bar, list]) {
    part.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && !isComposed(event)) close();
    });
  }
  bar.addEventListener("click", (event) => {
    const action = event.target.closest("[data-find]")?.dataset.find;
    if (action === "close") close();
    if (action === "one" && replaces()) {
      const { cell } = grid.selection;
      const hit = cell && hitOf(cell);
      if (hit && matcher()(hit)) grid.change([[hit.cell, replaced(hit)]]);
      next();
      show();
    }
    if (action === "all" && replaces()) replaceAll();
  });
  table.grid.addEventListener("rrp:rows", () => {
    if (bar.hidden) return;
    clearTimeout(timer);
    timer = setTimeout(show, RESTS_MS);
  });

  const pattern = () => {
    const text = find.value.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
    return new RegExp(whole.checked ? `^${text}$` : text, sameCase.checked ? "gu" : "giu");
  };
  // a cell, as the other sheets' are told; hidden rows are not searched
  const hitOf = (cell) => ({ cell, sheet: server.sheet, text: table.value(cell), kind: table.headers[table.column(cell)].dataset.kind });
  const here = () => table.shown.flatMap((row) => table.headers.map((_, k) => hitOf(table.cell(row, k)))).filter(matcher());

  restore();
  return { open };

  // what tells whether a cell is meant: a name is one of those between commas, or one in a formula
  function matcher() {
    if (!find.value) return () => false;
    if (!names.checked) {
      const found = pattern();
      return ({ text }) => text.search(found) >= 0;
    }
    const wanted = key(find.value);
    return ({ text, kind }) => (kind === "formula" ? text.match(NAMES) ?? [] : text.split(/[,\n]/)).some((name) => key(name) === wanted);
  }

  function replaces() {
    if (names.checked) grid.say(t("To change a name, use “Rename everywhere” in the menu of its cell."), true);
    return !names.checked && !grid.refuses();
  }

  function replaced({ text }) {
    return text.replace(pattern(), () => by.value);
  }

  /** What is found in the other sheets, as the server has them now; null when it does not answer. The list has the newest. */
  async function elsewhere() {
    const mine = ++newest;
    if (!scope.value || !find.value) return (others = []);
    const { ok, json } = await request(`${server.url}/texts`);
    if (!ok) {
      grid.say(UNREACHED, "error");
      return null;
    }
    const has = matcher();
    const all = json.filter(({ sheet }) => sheet !== server.sheet).flatMap(({ sheet, columns, rows }) => rows.flatMap(([row, number, texts]) => (
      columns.map(([column, letter, kind]) => ({ sheet, row, column, kind, text: texts[column] ?? "", address: `${letter}${number}` })))));
    const hits = all.filter(has);
    if (mine === newest) others = hits;
    return hits;
  }

  async function replaceAll() {
    if (grid.held.takes(replaceAll)) return;
    if (!scope.value) {
      const cells = here();
      grid.change(cells.map((hit) => [hit.cell, replaced(hit)]));
      tell(cells);
      show();
      return;
    }
    if (grid.waits(Infinity, replaceAll)) return;
    await grid.held.until(async () => {
      const hits = await elsewhere();
      if (!hits) return;
      const cells = [...here(), ...hits].filter((hit) => replaced(hit) !== hit.text);
      const sent = ({ cell, row, column, text }, to) => (cell
        ? { row: cell.parentElement.id, column: table.sheetColumn(table.column(cell)), text: to, was: text } : { row, column, text: to, was: text });
      const sheets = [...Map.groupBy(cells, (hit) => hit.sheet)].map(([sheet, hits]) => ({ sheet, cells: hits.map((hit) => sent(hit, replaced(hit))) }));
      const answer = sheets.length ? await server.send("replace", { sheets }) : {};
      if (!answer.message) tell(cells);
    });
    show();
  }

  function tell(cells) {
    const places = [...Map.groupBy(cells, (hit) => hit.sheet)].map(([sheet, { length }]) => tn("{n} cell of {sheet}", "{n} cells of {sheet}", { n: length, sheet }));
    if (!cells.length) grid.say(t("Not found."));
    else if (!scope.value) grid.say(tn("Replaced in {n} cell.", "Replaced in {n} cells.", { n: cells.length }));
    else grid.say(t("Replaced in {places}. Press Ctrl+Z to undo.", { places: listed(places) }));
  }

  async function next() {
    const cells = here().map(({ cell }) => cell);
    const at = grid.selection.cell;
    const following = cells.find((cell) => at.compareDocumentPosition(cell) & Node.DOCUMENT_POSITION_FOLLOWING);
    const further = following ? null : after((await elsewhere()) ?? []);
    if (further) leave(further);
    else if (following ?? cells[0]) go(following ?? cells[0]);
    else grid.say(t("Not found."));
  }

  // the first cell of the sheets after this one, else of those before it
  function after(hits) {
    const sheets = [...document.querySelectorAll("#tabs a[data-sheet]")].map((tab) => tab.dataset.sheet);
    const place = sheets.indexOf(server.sheet);
    const turns = ({ sheet }) => (sheets.indexOf(sheet) - place + sheets.length) % sheets.length;
    return hits.reduce((first, hit) => (first && turns(first) <= turns(hit) ? first : hit), null);
  }

  function go(cell) {
    grid.selection.go(cell.parentElement, table.column(cell), false, false);
    grid.say(t("Found in {cell}.", { cell: grid.bar.querySelector("b").textContent }));
  }

  /** To a cell of another sheet, where the search goes on. */
  function leave({ sheet, row, address }) {
    const fields = Object.fromEntries([find, by].map((field) => [field.name, field.value]));
    const ticks = [sameCase, whole, names].filter((tick) => tick.checked).map((tick) => tick.name);
    sessionStorage.setItem(kept, JSON.stringify({ fields, ticks }));
    const tab = [...document.querySelectorAll("#tabs a[data-sheet]")].find((one) => one.dataset.sheet === sheet);
    location.href = `${tab?.href ?? `${server.url}/sheet/${encodeURIComponent(sheet)}`}#${row}~${address}`;
  }

  function restore() {
    const text = sessionStorage.getItem(kept);
    sessionStorage.removeItem(kept);
    if (!text) return;
    const { fields, ticks } = JSON.parse(text);
    for (const [name, value] of Object.entries(fields)) bar.elements[name].value = value;
    for (const name of ticks) bar.elements[name].checked = true;
    scope.value = "all";
    bar.hidden = false;
    show();
  }

  async function show() {
    await elsewhere();
    const all = [...here(), ...others];
    put(count, find.value ? tn("{n} cell", "{n} cells", { n: all.length }) : "");
    list.hidden = !all.length;
    const sheets = Map.groupBy(all.slice(0, MOST_LISTED), (hit) => hit.sheet);
    list.replaceChildren(...[...sheets].flatMap(([sheet, hits]) => [...(scope.value ? [make("li", { className: "hits-of" }, sheet)] : []), ...hits.map(item)]));
    if (all.length > MOST_LISTED) list.append(make("li", t("… and {n} more", { n: all.length - MOST_LISTED })));
  }

  function item(hit) {
    const one = button("", () => (hit.cell ? hit.cell.isConnected && go(hit.cell) : leave(hit)), "hit");
    one.append(make("b", hit.cell ? table.address(hit.cell) : hit.address), ` ${hit.text}`);
    return make("li", {}, one);
  }

  function open() {
    bar.hidden = false;
    find.focus();
    find.select();
    show();
  }

  function close() {
    bar.hidden = true;
    list.hidden = true;
    grid.selection.cell?.focus({ preventScroll: true });
  }
}
