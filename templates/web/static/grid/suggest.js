// What could be meant by what is being typed: names for the cell's kind, and in formulas names, functions and fields.

import { cellHelp, inCell } from "./suggestcells.js";

const WORD = /[\p{L}\p{N}_]*$/u;
const MOST = 12;
// Words of formulas that are complete as they are, though functions begin with them.
const COMPLETE = new Set(["value", "total", "true", "false", "none", "blank", "pi", "e", "and", "or", "not", "in", "if", "else", "mod", "xor"]);

export const key = (text) => text.normalize("NFKC").toLowerCase().replace(/[\s_\-\u00a0\u2010-\u2015]+/g, "");

/** Suggestions for a cell: `items`, where the replaced text begins, and how sure they are: `sure` when the first one
 *  continues what is typed, so that Enter and Tab take it; then (whole) the cell is left, or (partial) one goes on typing. */
export function suggest(words, where, before, text) {
  const { kind } = where;
  if (kind === "formula") return inFormula(words, where, before);
  if (kind === "inputs") {
    const from = Math.max(before.lastIndexOf(","), before.lastIndexOf("\n")) + 1;
    const start = from + (before.slice(from).length - before.slice(from).trimStart().length);
    return pick([...streams(words, where), ...words.sensors, ...words.dones], before.slice(start), start, true);
  }
  const other = inCell(words, where, before, text);
  if (other) return other;
  const choices = {
    connector: words.connectors, device: words.devices, on: [{ text: "TRUE" }, { text: "FALSE", help: "skips the row" }],
    output: isSubscribe(where) ? words.actuators : [], fieldname: words.fields, tested: [...words.streams, ...words.dones],
  }[kind] ?? [];
  return pick(choices, text, 0, true, kind === "device");
}

/** Help on the function around the caret: its usage with a line of explanation, or null. */
export function signature(words, where, before) {
  if (where.kind !== "formula") return shown(cellHelp(words, where));
  let depth = 0;
  for (let i = before.length - 1; i >= 0; i--) {
    if (before[i] === ")") depth++;
    if (before[i] !== "(" || depth-- > 0) continue;
    const name = WORD.exec(before.slice(0, i))[0];
    const found = [...words.functions, ...words.helpers].find((f) => key(f.name ?? f.text) === key(name));
    if (!found) return null;
    return shown([found.label, found.example ? `${found.help} For example ${found.example}` : found.help]);
  }
  return null;
}

function shown(texts) {
  return texts && texts.map((text, i) => {
    const part = document.createElement(i ? "p" : "code");
    part.textContent = text;
    return part;
  });
}

/** Those of the choices that begin with what is typed, then those that hold it. Nothing is offered for what is complete,
 *  but with `longer` the names that go on from there are shown beside it. */
export function pick(choices, typed, from, whole, longer = false) {
  const wanted = key(typed);
  const starts = [];
  const holds = [];
  let complete = false;
  for (const choice of choices ?? []) {
    const k = key(choice.text);
    if (k === wanted && wanted) complete = true;
    if (k.startsWith(wanted)) starts.push(choice);
    else if (wanted && k.includes(wanted)) holds.push(choice);
  }
  if (complete) return { items: longer && starts.length > 1 ? starts : [], from, sure: false };
  const items = [...starts, ...holds].slice(0, wanted ? MOST : 40);
  return { items, from, sure: wanted !== "" && starts.length > 0, whole, partial: false };
}

function inFormula(words, where, before) {
  const none = { items: [], from: 0, sure: false };
  if (within(before, '"') || within(before, "'")) return none;
  const word = WORD.exec(before)[0];
  const from = before.length - word.length;
  if (before[from - 1] === ".") {
    const owner = WORD.exec(before.slice(0, from - 1))[0];
    const record = words.records[key(owner)] ?? (owner === "value" ? words.records[key(inputs(where)[0] ?? "")] : null);
    return { ...pick(record?.fields ?? [], word, from, false), partial: true };
  }
  if (/^\d/.test(word) || COMPLETE.has(word.toLowerCase())) return none;
  if (word && /\d\s*$/.test(before.slice(0, from))) return none; // a unit
  const mine = inputs(where).map((name) => words.names[key(name)] ?? unchecked(name)).filter(Boolean);
  const period = words.periods?.includes(connector(where));
  if (period) return before.trim() ? none : { ...pick(words.durations, "", 0, true), sure: false };
  const all = [...mine, ...words.helpers, ...words.tables, ...(word ? words.functions : [])];
  if (!word && before.trim()) return none;
  return { ...pick(all, word, from, false), partial: true };
}

function within(text, quote) {
  return (text.split(quote).length - 1) % 2 === 1;
}

export const named = (where, kind) => {
  const k = where.table.headers.findIndex((h) => h.dataset.kind === kind);
  return k < 0 ? "" : where.table.value(where.table.cell(where.row, k));
};

const connector = (where) => key(named(where, "connector"));
const isSubscribe = (where) => connector(where) === "subscribe";

/** The names of a row's input streams; a blank cell means the output of the row above. */
export function inputs(where) {
  const own = (named(where, "inputs") || named(where, "parameters")).split(/[,\n]/).map((n) => n.trim()).filter(Boolean);
  if (own.length || where.table.kind === "helpers") return own;
  for (let i = where.table.at(where.row) - 1; i >= 0; i--) {
    const above = { ...where, row: where.table.rows[i] };
    if (!named(above, "connector")) continue;
    if (isSubscribe(above)) return inputs(above);
    return [named(above, "output")].filter(Boolean);
  }
  return [];
}

// A stream that the check has not seen yet, as it was named a moment ago; a name that is spelled otherwise in formulas
// (a digit first, a word of the language) waits for the check.
function unchecked(name) {
  const parts = name.normalize("NFKC").split(/[\s_\-\u00a0\u2010-\u2015]+/).filter(Boolean);
  if (!parts.length || !/^\p{L}/u.test(parts[0]) || !parts.every((part) => /^[\p{L}\p{N}]+$/u.test(part))) return null;
  const first = parts[0] === parts[0].toUpperCase() ? parts[0].toLowerCase() : parts[0][0].toLowerCase() + parts[0].slice(1);
  return { text: first + parts.slice(1).map((part) => part[0].toUpperCase() + part.slice(1)).join(""), kind: "stream", help: "" };
}

function streams(words, where) {
  const k = where.table.headers.findIndex((h) => h.dataset.kind === "output");
  if (k < 0) return words.streams;
  const found = new Map();
  for (const row of where.table.rows) {
    const name = where.table.value(where.table.cell(row, k));
    if (name && row !== where.row && !words.actuators.some((a) => key(a.text) === key(name))) found.set(key(name), name);
  }
  return [...found.values()].map((text) => ({ text, kind: "stream", help: words.names[key(text)]?.help ?? "" }));
}
