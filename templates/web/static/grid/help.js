// Help beside the grid: on the cell at hand (F1), on what is searched for, and on what its links lead to.

import { request, why } from "../api.js";
import { t } from "../texts.js";
import { inputs, key } from "./editor.js";

const NAME = /[\p{L}_][\p{L}\p{N}_]*/gu;
const CALLED = /([\p{L}_][\p{L}\p{N}_]*)\s*\(/gu;
const SEARCH_AFTER_MS = 250; // without a key in the field

export function help(grid) {
  const panel = document.getElementById("help");
  const button = document.querySelector("[data-do=help]");
  let back = null; // what had the focus before
  let waiting; // until nothing more is typed
  let sought = ""; // what is shown was searched for

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
    if (event.target.name === "q") waiting = setTimeout(() => seek(event.target.value), SEARCH_AFTER_MS);
  });

  return { open, toggle };

  /** Help on the cell at hand; away with it for who is reading it. */
  function toggle() {
    if (panel.hidden || !panel.contains(document.activeElement)) open(atHand());
    else close();
  }

  function open(topics) {
    if (!document.activeElement?.closest("#help")) back = grid.editor.field ?? document.activeElement;
    show({ topic: topics });
  }

  function close() {
    panel.hidden = true;
    button?.setAttribute("aria-expanded", "false");
    const to = back?.isConnected && back !== document.body ? back : grid.selection.cell;
    to?.focus({ preventScroll: true });
  }

  async function ask(asked) {
    const query = new URLSearchParams();
    for (const [name, values] of Object.entries(asked)) for (const value of [values].flat()) query.append(name, value);
    query.set("book", panel.dataset.book);
    const { ok, status, text } = await request(`${panel.dataset.url}?${query}`);
    if (!ok) {
      grid.say(t("Help is not available now. {why}", { why: why({ status, text }) }), "error");
      return null;
    }
    const holder = document.createElement("template");
    holder.innerHTML = text; // made by our own server, all texts escaped
    return holder.content;
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
    if (found) grid.spoken.say(found);
  }

  async function show(asked) {
    clearTimeout(waiting);
    sought = "";
    const piece = await ask(asked);
    if (!piece) {
      if (panel.hidden) grid.editor.field?.focus({ preventScroll: true });
      return;
    }
    panel.replaceChildren(piece);
    panel.style.top = `${Math.max(0, document.querySelector(".runbar")?.getBoundingClientRect().bottom ?? 56)}px`; // Stop stays in sight
    panel.hidden = false;
    panel.scrollTop = 0;
    button?.setAttribute("aria-expanded", "true");
    panel.tabIndex = -1;
    const first = panel.querySelector("input");
    first.focus({ preventScroll: true });
    first.select();
    grid.spoken.say(t("Help: {topic}", { topic: panel.querySelector(".help-topic h3, h3")?.textContent ?? t("overview") }));
  }

  /** The topics of help on the cell with the cursor: its text, its problems, its column. */
  function atHand() {
    if (!grid.selection.cell) return ["keys"];
    const { row, cell } = grid.selection;
    const k = grid.selection.head.k;
    const text = grid.editor.isOpen ? grid.editor.field.value : grid.table.value(cell);
    const codes = [...cell.querySelectorAll("[data-code]")].map((m) => m.dataset.code);
    const { kind, helpTopic } = grid.table.headers[k].dataset;
    const where = { row, table: grid.table };
    const names = text.split(/[,\n]/).map((name) => name.trim()).filter(Boolean);
    const about = {
      inputs: () => [...names.flatMap(stream), helpTopic], output: () => [...names.flatMap(stream), helpTopic],
      tested: () => [...names.flatMap(stream), helpTopic], stream: () => [...names.flatMap(stream), helpTopic],
      connector: () => [text || helpTopic],
      formula: () => [...atCaret(), ...helpers(text), ...functions(text), ...inputs(where).flatMap(stream), helpTopic].slice(0, 4),
      device: () => [text, helpTopic], setting: () => [grid.selection.sibling("device"), helpTopic],
      helper: () => [...helpers(text), helpTopic],
    }[kind]?.() ?? [helpTopic];
    const words = new Set(text.match(/[\p{L}_]+/gu));
    const comment = row.classList.contains("comment") && text.trimStart().startsWith("#"); // help on what it speaks of
    if (comment) return [...(grid.words.connectors ?? []).map((c) => c.text).filter((name) => words.has(name)), "glossary"].slice(0, 4);
    const all = [...codes, ...about.filter(Boolean)];
    return [...new Set(all.length ? all : ["keys"])].slice(0, 4);
  }

  /** What a stream's name means: its device, and what this workbook does with it. */
  function stream(name) {
    return [device(name), `stream:${name.includes("!") ? name : `${grid.server.sheet}!${name}`}`].filter(Boolean);
  }

  /** The word in which the caret stands while a formula is edited: a helper, else a function, else a stream. */
  function atCaret() {
    const { field } = grid.editor;
    if (!field) return [];
    const before = /[\p{L}\p{N}_]*$/u.exec(field.value.slice(0, field.selectionStart))[0];
    const word = before + /^[\p{L}\p{N}_]*/u.exec(field.value.slice(field.selectionStart))[0];
    const meant = inputs({ row: grid.selection.row, table: grid.table }).find((name) => key(name) === key(word));
    return word ? [...helpers(word), ...functions(`${word}(`), ...(meant ? stream(meant) : [])] : [];
  }

  /** The device behind a stream's name, as the Devices sheet has it; nothing for a stream of the user's own. */
  function device(name) {
    const is = (word) => key(word.text) === key(name);
    const found = [...(grid.words.sensors ?? []), ...(grid.words.actuators ?? [])].find(is);
    const own = (grid.words.streams ?? []).some((word) => is(word) && word.kind === "stream");
    return found?.device ?? (own && !found ? "" : name);
  }

  /** The helpers of the workbook that a text names, called or alone; `helper:` tells them from what is built in. */
  function helpers(text) {
    const words = new Set([key(text), ...(text.match(NAME) ?? []).map(key)]);
    return (grid.words.helpers ?? []).filter((h) => words.has(key(h.text)) || words.has(key(h.name))).map((h) => `helper:${h.text}`);
  }

  /** The library's functions that a formula calls; one that a helper of the same name hides is not called. */
  function functions(text) {
    const hidden = new Set((grid.words.helpers ?? []).map((h) => key(h.text)));
    const called = [...text.matchAll(CALLED)].map((m) => key(m[1])).filter((name) => !hidden.has(name));
    return called.map((name) => grid.words.functions?.find((f) => f.names.some((n) => key(n) === name))?.name).filter(Boolean);
  }
}
