// Copying and pasting as tab-separated text, as Excel and LibreOffice do.

import { withoutHeaders } from "./headerrows.js";
import { format, parse } from "./tsv.js";

export class Clipboard {
  constructor(grid) {
    this.grid = grid;
    const mine = () => !grid.editor.isOpen && grid.selection.head && grid.scroll.contains(document.activeElement);
    const take = (event) => {
      event.preventDefault();
      event.clipboardData.setData("text/plain", this.copied());
      return counted(grid.selection.box());
    };
    document.addEventListener("copy", (event) => mine() && grid.say(`${take(event)} copied.`));
    document.addEventListener("cut", (event) => {
      if (!mine()) return;
      const what = take(event);
      grid.clear();
      grid.say(`${what} cut.`);
    });
    document.addEventListener("paste", (event) => {
      if (!mine()) return;
      event.preventDefault();
      this.pasted(event.clipboardData.getData("text/plain"));
    });
  }

  /** The same as the events do, when they had to wait; gives what was copied. */
  copy() {
    const text = this.copied();
    navigator.clipboard?.writeText(text).catch(() => {});
    this.grid.say(`${counted(this.grid.selection.box())} copied.`);
    return text;
  }

  cut() {
    const text = this.copy();
    this.grid.clear();
    this.grid.say(`${counted(this.grid.selection.box())} cut.`);
    return text;
  }

  pasted(text) {
    if (text) this.paste(parse(text));
    else this.grid.say("There is no text to paste.");
  }

  /** The selected cells as text. */
  copied() {
    const { selection, table } = this.grid;
    return format(selection.cells().map((line) => line.map((cell) => table.value(cell))));
  }

  /** Lines of texts into the cells from the selection's first cell on; one value fills the whole selection. */
  paste(lines) {
    const { grid } = this;
    const { selection, table } = grid;
    const box = selection.box();
    if (!box) return;
    if (lines.length === 1 && lines[0].length === 1) {
      grid.change(selection.cells().flat().map((cell) => [cell, lines[0][0]]));
      return;
    }
    if (grid.refuses()) return;
    const block = withoutHeaders(lines, table, box.left);
    const { left } = block;
    if (block.said) grid.say(block.said, block.lost);
    if (!block.lines.length) return;
    const height = box.bottom - box.top + 1;
    const times = height % block.lines.length === 0 ? height / block.lines.length : 1;
    const all = Array.from({ length: times }, () => block.lines).flat();
    if (grid.waits(box.top + all.length, () => this.paste(lines))) return;
    grid.rows.reserve(Math.max(0, box.top + all.length - table.rows.length + table.room()));
    const pairs = all.flatMap((line, i) => line.slice(0, table.width - left).map((text, j) => [
      table.cell(table.rows[box.top + i], left + j), text,
    ]));
    grid.change(pairs.filter(([, text]) => text !== undefined));
    const wide = Math.max(...all.map((line) => line.length));
    if (wide > table.width - left) {
      const tooMany = wide - (table.width - left);
      grid.say(`${block.said} ${tooMany === 1 ? "1 column" : `${tooMany} columns`} did not fit in and ${tooMany === 1 ? "was" : "were"} left out.`.trim(), true);
    }
    selection.spread(box.top, left, Math.min(box.top + all.length, table.rows.length) - 1,
      Math.min(left + wide, table.width) - 1);
  }
}

function counted(box) {
  const count = (box.bottom - box.top + 1) * (box.right - box.left + 1);
  return count === 1 ? "One cell" : `${count} cells`;
}
