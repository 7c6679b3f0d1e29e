// Header rows within pasted cells: the sheet has its own, so they are left out, and tell which column is which.

import { key } from "./suggest.js";

/** Pasted lines without their header rows, with their cells in the sheet's columns.
 *
 *  Gives `lines` whose cells begin in column `left` (an undefined cell stays as it is), what the person is told (`said`,
 *  empty without a header row), and whether anything else was left out (`lost`). */
export function withoutHeaders(lines, table, left) {
  const columns = table.headers.map((head) => head.dataset.spellings.split(" ").filter(Boolean));
  const required = table.headers.flatMap((head, k) => ("required" in head.dataset ? [k] : []));
  const oneColumn = lines.length > 1 && lines.every((line) => line.length === 1);
  const kept = []; // pairs [column, text] of each line
  const unknown = new Set(); // headers that the sheet has not
  let count = 0;
  let moved = false;
  let unnamed = false; // whether a text stands under no header
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
  const said = [count === 1 ? "The header row was not pasted: the sheet has one." : `${count} header rows were not pasted: the sheet has one.`];
  if (moved) said.push("The cells went to the columns of the same names.");
  if (unknown.size) said.push(`Not pasted, as this sheet has no such column: ${[...unknown].join(", ")}.`);
  if (unnamed) said.push("Cells without a header above them were not pasted.");
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
    const only = known.length === line.filter((text) => text.trim()).length;
    return known.length > 1 && (whole || only) ? places : null;
  }
}
