// What was taken back, or done again: told in words, and shown.

/** Go to what an undo or redo has changed, and tell it. */
export function retrace(grid, entries, again) {
  const here = entries.filter((entry) => entry.sheet === grid.server.sheet);
  const others = [...new Set(entries.map((entry) => entry.sheet))].filter((name) => name !== grid.server.sheet);
  const told = here.map((entry) => tell(grid, entry)).filter(Boolean);
  if (others.length) told.push(`changed in ${others.join(", ")}`);
  grid.say(`${again ? "Done again" : "Undone"}: ${told.slice(0, 3).join("; ") || "nothing to be seen"}.`);
}

function tell(grid, { cells, insert, remove, move }) {
  const { table, selection } = grid;
  if (cells?.length) {
    const places = cells.map(([row, column]) => [table.row(row), table.headers.findIndex((h) => Number(h.dataset.c) === column)]);
    const known = places.filter(([row, k]) => row && k >= 0);
    if (!known.length) return "";
    const [row, k] = known[0];
    selection.go(row, k);
    const cell = table.cell(row, k);
    const text = table.value(cell);
    if (known.length > 1) return `${known.length} cells from ${table.address(cell)} on`;
    return `${table.address(cell)} ${text ? `is “${short(text)}”` : "is empty"} again`;
  }
  if (insert?.length || move?.length) {
    const ids = insert?.length ? insert.map(({ html }) => /id="([^"]+)"/.exec(html)[1]) : move.map((m) => m.id);
    const numbers = ids.map((id) => Number(table.row(id)?.cells[0].textContent)).filter(Boolean).sort((a, b) => a - b);
    const first = [...table.rows].find((row) => Number(row.cells[0].textContent) === numbers[0]);
    if (first) selection.go(first, selection.head.k);
    const span = numbers.length > 1 ? `rows ${numbers[0]} to ${numbers.at(-1)}` : `row ${numbers[0]}`;
    return insert?.length ? `${span} ${numbers.length > 1 ? "are" : "is"} there` : `${span} moved`;
  }
  if (remove?.length) return remove.length === 1 ? "a row is gone" : `${remove.length} rows are gone`;
  return "";
}

const short = (text) => (text.length > 60 ? `${text.slice(0, 59)}…` : text);
