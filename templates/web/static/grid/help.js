// Help beside the grid: on the cell at hand (F1), on what is searched for, and on what its links lead to.

import { inputs, key } from "./suggest.js";

const PATIENCE = 250; // milliseconds after the last key, before it is searched

export function help(grid) {
  const panel = document.getElementById("help");
  const button = document.querySelector("[data-do=help]");
  let back = null; // what had the focus before
  let waiting; // until nothing more is typed
  let sought = ""; // what is shown was searched for

  document.addEventListener("keydown", (event) => {
    if (event.key !== "F1") return;
    event.preventDefault();
    if (panel.hidden || !panel.contains(document.activeElement)) open(atHand());
    else close();
  });
  document.addEventListener("rrp:help", (event) => open(event.detail ?? atHand()));
  panel.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.preventDefault();
    event.stopPropagation();
    close();
  });
  panel.addEventListener("click", (event) => {
    if (event.target.closest("[data-help-close]")) close();
    const link = event.target.closest("[data-help]");
    if (!link) return;
    event.preventDefault();
    show({ topic: [link.dataset.help] });
  });
  panel.addEventListener("submit", (event) => {
    event.preventDefault();
    seek(panel.querySelector("[name=q]").value);
  });
  panel.addEventListener("input", (event) => {
    clearTimeout(waiting);
    if (event.target.name === "q") waiting = setTimeout(() => seek(event.target.value), PATIENCE);
  });

  function open(topics) {
    back = document.activeElement?.closest("#help") ? back : document.activeElement;
    show({ topic: topics });
  }

  function close() {
    panel.hidden = true;
    button?.setAttribute("aria-expanded", "false");
    const to = back?.isConnected && back !== document.body ? back : grid?.selection.cell;
    to?.focus({ preventScroll: true });
  }

  async function ask(asked) {
    const query = new URLSearchParams();
    for (const [name, values] of Object.entries(asked)) for (const value of [values].flat()) query.append(name, value);
    const response = await fetch(`${panel.dataset.url}?${query}`);
    const holder = document.createElement("template");
    holder.innerHTML = response.ok ? await response.text() : ""; // made by our own server, all texts escaped
    return response.ok ? holder.content : null;
  }

  /** Search while one types: only what is found is new, the field stays as it is. */
  async function seek(text) {
    clearTimeout(waiting);
    if (text === sought) return;
    sought = text;
    const piece = await ask({ q: text });
    const now = panel.querySelector("#help-results");
    if (!piece || text !== sought) return;
    now?.replaceWith(piece.querySelector("#help-results"));
    const found = panel.querySelector("#help-results h3")?.textContent;
    if (found) grid?.spoken.say(found);
  }

  async function show(asked) {
    clearTimeout(waiting);
    sought = "";
    const piece = await ask(asked);
    if (!piece) return;
    panel.replaceChildren(piece);
    panel.style.top = `${Math.max(0, document.querySelector(".runbar")?.getBoundingClientRect().bottom ?? 56)}px`; // Stop stays in sight
    panel.hidden = false;
    panel.scrollTop = 0;
    button?.setAttribute("aria-expanded", "true");
    panel.tabIndex = -1;
    const first = panel.querySelector("input");
    first.focus({ preventScroll: true });
    first.select();
    grid?.spoken.say(`Help: ${panel.querySelector(".help-topic h3, h3")?.textContent ?? "overview"}`);
  }

  /** What there may be help on, for the cell with the cursor: what stands in it, its problems, its column. */
  function atHand() {
    if (!grid?.selection.cell) return ["keys"];
    const { row, cell } = grid.selection;
    const k = grid.selection.head.k;
    const text = grid.editor.isOpen ? grid.editor.field.value : grid.table.value(cell);
    const codes = [...cell.querySelectorAll("[data-code]")].map((m) => m.dataset.code);
    const { kind } = grid.table.headers[k].dataset;
    const where = { row, table: grid.table };
    const names = text.split(/[,\n]/).map((name) => name.trim()).filter(Boolean);
    const about = {
      inputs: () => [...names.map(device), "devices"], output: () => [...names.map(device), "devices"],
      connector: () => [text, "connectors"].filter(Boolean).slice(0, text ? 1 : 2),
      formula: () => [...functions(text), ...inputs(where).map(device), "formulas"].slice(0, 3),
      on: () => ["keys"], notes: () => ["keys"], device: () => [text, "devices"], setting: () => [grid.selection.sibling("device"), "devices"],
      actor: () => ["scene"], verb: () => ["scene"], value: () => ["scene"], tested: () => ["tests"], send: () => ["tests"], expect: () => ["tests"],
      fieldname: () => ["protocol"], fieldvalue: () => ["protocol"], amount: () => [grid.table.name(k) === "Priority" ? "priority" : grid.table.kind === "scene" ? "scene" : "tests"],
      helper: () => ["helpers"],
    }[kind]?.() ?? [];
    const words = new Set(text.match(/[\p{L}_]+/gu));
    const comment = row.classList.contains("comment") && text.trimStart().startsWith("#"); // help on what it speaks of
    if (comment) return [...(grid.words.connectors ?? []).map((c) => c.text).filter((name) => words.has(name)), "glossary"].slice(0, 4);
    const all = [...codes, ...about.filter(Boolean)];
    return [...new Set(all.length ? all : ["keys"])].slice(0, 4);
  }

  /** The device behind a stream's name, as the Devices sheet has it. */
  function device(name) {
    const found = [...(grid.words.sensors ?? []), ...(grid.words.actuators ?? [])].find((w) => key(w.text) === key(name));
    return found?.device ?? name;
  }

  function functions(text) {
    const found = [...text.matchAll(/([\p{L}_]\w*)\s*\(/gu)].map((m) => m[1]);
    return found.filter((name) => grid.words.functions?.some((f) => key(f.name) === key(name)));
  }
}
