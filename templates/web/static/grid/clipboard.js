// Copying and pasting as a table and as tab-separated text, as Excel and LibreOffice do.

import { make } from "../elements.js";
import { listed, t, tn } from "../texts.js";
import { key } from "./editor.js";

export class Clipboard {
  constructor(grid) {
    this.grid = grid;
    const mine = () => !grid.editor.isOpen && grid.selection.head && grid.scroll.contains(document.activeElement);
    const take = (event) => {
      event.preventDefault();
      this.cutCells = null;
      const cells = this.taken();
      if (!cells) return 0;
      const { text, html } = this.copied(cells);
      event.clipboardData.setData("text/plain", text);
      event.clipboardData.setData("text/html", html);
      return cells.flat().length;
    };
    document.addEventListener("copy", (event) => {
      const n = mine() && take(event);
      if (n) grid.say(copied(n));
    });
    document.addEventListener("cut", (event) => {
      const n = mine() && take(event);
      if (!n) return;
      this.keepCut();
      grid.clear();
      grid.say(cut(n));
    });
    document.addEventListener("paste", (event) => {
      const copied = copiedOf(event.clipboardData);
      if (event.target === grid.editor.field && copied.text) insert(copied);
      else if (mine()) this.pasted(copied);
      else return;
      event.preventDefault();
    });
  }

  /** The same as the events do, when they had to wait; gives what was copied. */
  copy() {
    this.cutCells = null;
    const cells = this.taken();
    if (!cells) return NOTHING;
    const found = this.copied(cells);
    const part = (type, text) => [type, new Blob([text], { type })];
    const parts = [part("text/plain", found.text), part("text/html", found.html)];
    navigator.clipboard?.write([new ClipboardItem(Object.fromEntries(parts))]).catch(() => {});
    this.grid.say(copied(cells.flat().length));
    return found;
  }

  cut() {
    const found = this.copy();
    if (!found.text) return found;
    this.keepCut();
    this.grid.clear();
    this.grid.say(cut(this.grid.selection.all().length));
    return found;
  }

  /** Paste by the menu, for which a browser may ask, or refuse it. */
  async fromMenu() {
    const found = await readClipboard().catch(() => null);
    if (!found) this.grid.say(t("The browser does not let the menu read what was copied. Press Ctrl+V."), true);
    else if (!this.grid.held.takes(() => this.pasted(found))) this.pasted(found);
  }

  /** Remember which cells are cut: their comments go where they are pasted first. */
  keepCut() {
    const cells = this.taken();
    this.cutCells = cells && { text: this.copied(cells).text, cells: cells.map((line) => line.map((cell) => this.grid.threads.at(cell))) };
  }

  /** The comments that go with cut cells: pairs of a cell that had some and the one where it is pasted. */
  carried(pairs, width) {
    const from = this.now?.cells;
    this.now = null;
    if (!from || from.flat().length !== pairs.length || from[0].length !== width) return [];
    const { table } = this.grid;
    return pairs.flatMap(([to], i) => {
      const { row, k } = from.flat()[i];
      const cell = table.cell(table.row(row), k);
      if (!cell?.classList.contains("commented") || !to || cell === to) return [];
      return [{ row, column: table.sheetColumn(k), to: { row: to.parentElement.id, column: table.sheetColumn(table.column(to)) } }];
    });
  }

  pasted({ text, html }) {
    this.now = this.cutCells?.text.replace(/\n$/, "") === text.replace(/\r\n?/g, "\n").replace(/\n$/, "") ? this.cutCells : null;
    this.cutCells = null;
    if (text || tableOf(html)) this.paste(cellsOf({ text, html }));
    else this.grid.say(t("There is no text to paste."));
  }

  /** The cells to copy, row by row; null, with a message, for ranges that neither are in the same rows nor in the same columns. */
  taken() {
    const { selection, table } = this.grid;
    const boxes = selection.boxes();
    const spans = (from, to) => boxes.flatMap((box) => Array.from({ length: box[to] - box[from] + 1 }, (_, i) => box[from] + i));
    const ordered = (places) => [...new Set(places)].sort((a, b) => a - b);
    const alike = (from, to) => boxes.every((box) => box[from] === boxes[0][from] && box[to] === boxes[0][to]);
    if (!alike("left", "right") && !alike("top", "bottom")) {
      this.grid.say(t("Several selections can be copied together only if they are in the same rows or in the same columns."), true);
      return null;
    }
    const rows = ordered(spans("top", "bottom")).map((i) => table.rows[i]).filter((row) => !table.hidden.has(row.id));
    return rows.map((row) => ordered(spans("left", "right")).map((k) => table.cell(row, k)));
  }

  copied(cells) {
    const rows = cells.map((line) => line.map((cell) => this.grid.table.value(cell)));
    return { text: format(rows), html: tableWith(rows) };
  }

  /** Lines of texts into the cells from the selection's first cell on; one value fills the whole selection. */
  paste(lines) {
    const { grid } = this;
    const { selection, table } = grid;
    const box = selection.box();
    if (!box) return;
    if (lines.length === 1 && lines[0].length === 1) {
      const pairs = selection.all().map((cell) => [cell, lines[0][0]]);
      grid.change(pairs, this.carried(pairs, 1));
      return;
    }
    if (grid.refuses()) return;
    if (selection.others.length) {
      grid.say(t("Select one block of cells to paste into."), true);
      return;
    }
    const block = withoutHeaders(lines, table, box.left);
    const { left } = block;
    if (block.said) grid.say(block.said, block.lost);
    if (!block.lines.length) return;
    const height = selection.cells().length;
    const times = height % block.lines.length === 0 ? height / block.lines.length : 1;
    const all = Array.from({ length: times }, () => block.lines).flat();
    if (grid.waits(table.hidden.size ? Infinity : box.top + all.length, () => this.paste(lines))) return;
    const filled = table.rows.length - table.room();
    const below = () => table.shown.slice(table.spot(selection.near(box.top))); // hidden rows stay as they are
    const free = below().filter((row) => table.at(row) < filled).length;
    grid.rows.reserve(Math.max(0, all.length - free + Math.max(0, box.top - filled)));
    const rows = below().slice(0, all.length);
    const pairs = all.slice(0, rows.length).flatMap((line, i) => line.slice(0, table.width - left).map((text, j) => [
      table.cell(rows[i], left + j), text,
    ]));
    grid.change(pairs.filter(([, text]) => text !== undefined), this.carried(pairs, all[0].length));
    const wide = Math.max(...all.map((line) => line.length));
    if (wide > table.width - left) {
      const n = wide - (table.width - left);
      const leftOut = tn("{n} column did not fit and was skipped.", "{n} columns did not fit and were skipped.", { n });
      grid.say(`${block.said} ${leftOut}`.trim(), true);
    }
    selection.spread(table.at(rows[0]), left, table.at(rows.at(-1)),
      Math.min(left + wide, table.width) - 1);
  }
}

const ONE_LINE = /^[^\n]*\n$/; // programs end a single cell with a line break, which is none of its text

/** What is copied when nothing is. */
export const NOTHING = { text: "", html: "" };

/** What a paste event brings: a `text`, and `html` if a program has given that too. */
export function copiedOf(data) {
  return { text: data.getData("text/plain"), html: data.getData("text/html") };
}

async function readClipboard() {
  const items = await navigator.clipboard.read();
  const as = async (type) => {
    const item = items.find(({ types }) => types.includes(type));
    return item ? (await item.getType(type)).text() : "";
  };
  return { text: await as("text/plain"), html: await as("text/html") };
}

/** Put what was copied into the cell's editor as if it were pasted there; of a single cell, its text. */
export function insert({ text, html }) {
  const cell = tableOf(html)?.flat().length === 1 ? cellsOf({ text, html })[0][0] : undefined;
  const lines = text.replace(/\r\n?/g, "\n");
  document.execCommand("insertText", false, cell ?? (ONE_LINE.test(lines) ? lines.slice(0, -1) : lines));
}

const copied = (n) => tn("One cell copied.", "{n} cells copied.", { n });
const cut = (n) => tn("One cell cut.", "{n} cells cut.", { n });

// Header rows within pasted cells: the sheet has its own, so they are left out, and tell which column is which.

/** Pasted lines without their header rows, with their cells in the sheet's columns.
 *
 *  Gives `lines` whose cells begin in column `left` (an undefined cell stays as it is), what the person is told (`said`,
 *  empty without a header row), and whether anything else was left out (`lost`). */
function withoutHeaders(lines, table, left) {
  const columns = table.headers.map((head) => head.dataset.spellings.split(" ").filter(Boolean));
  const required = table.headers.flatMap((head, k) => ("required" in head.dataset ? [k] : []));
  const oneColumn = lines.length > 1 && lines.every((line) => line.length === 1);
  const kept = []; // pairs [column, text] of each line
  const unknown = new Set(); // headers that the sheet has not
  let count = 0;
  let moved = false;
  let unnamed = false; // true when a text stands under no header
  let places = null; // columns by place in the line, below a header row
  for (const [i, line] of lines.entries()) {
    const found = oneColumn ? (i === 0 && columns[left].includes(key(line[0])) ? [left] : null) : headerOf(line);
    if (found) {
      count += 1;
      places = found;
      for (const [j, text] of line.entries()) if (text.trim() && places[j] === undefined) unknown.add(text.trim());
      continue;
    }
    const pairs = line.map((text, j) => [places ? places[j] : left + j, text]);
    moved ||= pairs.some(([k], j) => k !== undefined && k !== left + j);
    unnamed ||= !unknown.size && pairs.some(([k, text]) => k === undefined && text.trim());
    kept.push(pairs.filter(([k]) => k !== undefined));
  }
  if (!count) return { lines, left, said: "", lost: false };
  const first = Math.min(...kept.flat().map(([k]) => k));
  const said = [tn("The header row was not pasted: the sheet has one.", "{n} header rows were not pasted: the sheet has one.", { n: count })];
  if (moved) said.push(t("Each cell was pasted into the column with the same name."));
  if (unknown.size) said.push(t("Columns that this sheet does not have were left out: {names}.", { names: listed([...unknown]) }));
  if (unnamed) said.push(t("Cells without a header above them were not pasted."));
  const placed = kept.map((pairs) => {
    const cells = Array(Math.max(0, ...pairs.map(([k]) => k - first + 1))).fill(undefined);
    for (const [k, text] of pairs) cells[k - first] = text;
    return cells;
  });
  return { lines: placed, left: first, said: said.join(" "), lost: unknown.size > 0 || unnamed };

  /** The column of each cell of a header row, undefined where the sheet has none; null for any other line. */
  function headerOf(line) {
    const places = [];
    for (const [j, text] of line.entries()) {
      const k = text.trim() ? columns.findIndex((spellings) => spellings.includes(key(text.trim()))) : -1;
      places[j] = k >= 0 && !places.includes(k) ? k : undefined;
    }
    const known = places.filter((k) => k !== undefined);
    const whole = required.length > 0 && required.every((k) => known.includes(k));
    const others = line.filter((text) => text.trim()).length - known.length;
    return known.length > 1 && (whole || 2 * others <= known.length) ? places : null;
  }
}

// Spreadsheets put a table on the clipboard, and a text with the same cells, in which spaces are as they were typed. Pages,
// mails and word processors give a table without such a text.

/** The cells of what was copied, row by row. */
export function cellsOf({ text, html }) {
  const table = tableOf(html);
  const cells = markdownOf(text) ?? parse(text);
  return !table || JSON.stringify(table.map(plain)) === JSON.stringify(cells.map(plain)) ? cells : table;
}

const plain = (row) => row.map((text) => text.replace(/\s+/g, " ").trim());

/** The cells of a copied table, row by row; null if there is none, several, or other text around it. */
function tableOf(html) {
  if (!html) return null;
  const unstyled = html.replace(/<style[^]*?<\/style>/gi, "").replace(/<[^>]*>/g, (tag) => tag.replace(/\sstyle\s*=\s*("[^"]*"|'[^']*')/gi, ""));
  const { body } = new DOMParser().parseFromString(unstyled, "text/html"); // a style would be a breach of the page's policy
  for (const one of body.querySelectorAll("script")) one.remove();
  const [table, ...others] = body.querySelectorAll("table");
  table?.remove();
  if (!table?.rows.length || others.length || body.textContent.trim()) return null;
  const rows = Array.from(table.rows, () => []);
  for (const [i, row] of Array.from(table.rows).entries()) {
    let k = 0;
    for (const cell of row.cells) {
      while (rows[i][k] !== undefined) k += 1;
      const covered = rows.slice(i, i + cell.rowSpan); // of cells that are joined, the first has the text
      for (const line of covered) for (let j = k; j < k + cell.colSpan; j++) line[j] = "";
      rows[i][k] = textOf(cell).replaceAll("\u00a0", " ").replace(/ *\n[ \n]*/g, "\n").trim();
    }
  }
  const width = Math.max(...rows.map((row) => row.length));
  return width ? rows.map((row) => Array.from({ length: width }, (_, j) => row[j] ?? "")) : null;
}

function textOf(node) {
  if (node.nodeType === Node.TEXT_NODE) return node.data.replace(/[ \t\r\n\f]+/g, " ");
  if (node.nodeName === "BR") return "\n";
  const inside = Array.from(node.childNodes, textOf).join("");
  return /^(P|DIV|LI)$/.test(node.nodeName) ? `\n${inside}\n` : inside;
}

/** The table of some rows of cells, for other programs. */
function tableWith(rows) {
  const cell = (text) => make("td", {}, ...text.split("\n").flatMap((line, i) => (i ? [make("br"), line] : [line])));
  return make("table", {}, ...rows.map((row) => make("tr", {}, ...row.map(cell)))).outerHTML;
}

// Rows of a Markdown table, as workbooks in Markdown have them; the row of dashes below the header is none.
const MARKDOWN_ROW = /^\s*\|(.*)\|\s*$/;
const MARKDOWN_RULE = /^[\s:|-]*-[\s:|-]*$/;

function markdownOf(text) {
  const lines = text.trim().split(/\r\n?|\n/).map((line) => MARKDOWN_ROW.exec(line)?.[1]);
  if (lines.includes(undefined)) return null;
  const rows = lines.filter((line, i) => i > 1 || !MARKDOWN_RULE.test(line));
  return rows.length ? rows.map((line) => line.split(/(?<!\\)\|/).map(fromMarkdown)) : null;
}

function fromMarkdown(cell) {
  const text = cell.trim().replaceAll("\\|", "|").replace(/(\\?)<br\s*\/?>/gi, (all, mark) => (mark ? all.slice(1) : "\n"));
  return /^`[^`]+`$/.test(text) ? text.slice(1, -1) : text.replace(/^\\(?=\\*`)/, "");
}

// Tab-separated text, as Excel and LibreOffice put it on the clipboard: a cell with tabs, line breaks or quotes stands
// between quotes, and its quotes are doubled.

/** The cells of a text, row by row; a last line break ends the last row and does not begin another. */
export function parse(text) {
  const rows = [[]];
  let cell = "";
  let quoted = false;
  const source = text.replace(/\r\n?/g, "\n").replace(/\n$/, "");
  for (let i = 0; i < source.length; i++) {
    const c = source[i];
    if (quoted) {
      if (c !== '"') cell += c;
      else if (source[i + 1] === '"') cell += source[i++];
      else quoted = false;
    } else if (c === '"' && cell === "" && closes(source, i)) quoted = true;
    else if (c === "\t") rows.at(-1).push(take());
    else if (c === "\n") {
      rows.at(-1).push(take());
      rows.push([]);
    } else cell += c;
  }
  rows.at(-1).push(cell);
  return rows;

  function take() {
    const done = cell;
    cell = "";
    return done;
  }
}

// A quote at the beginning of a cell opens a quoted cell only if it is closed before a tab, a line break or the end, and
// something between needs the quotes: formulas such as "near" & x and "Hello" are copied by some programs as they stand.
function closes(source, open) {
  let needed = false;
  for (let i = open + 1; i < source.length; i++) {
    if (source[i] === "\t" || source[i] === "\n") needed = true;
    if (source[i] !== '"') continue;
    if (source[i + 1] !== '"') return needed && (i + 1 === source.length || source[i + 1] === "\t" || source[i + 1] === "\n");
    needed = true;
    i++;
  }
  return false;
}

/** The text of some rows of cells: each ends with a line break, so that a last blank one is there too; one filled cell has none. */
export function format(rows) {
  const lines = rows.map((cells) => cells.map(quote).join("\t"));
  return rows.length === 1 && rows[0].length === 1 && lines[0] ? lines[0] : `${lines.join("\n")}\n`;
}

function quote(text) {
  return /[\t\n\r"]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
