// What the formulas of the sheet compare streams with: drawn as lines in their plots.

/** The numbers that the formulas of the sheet compare a stream with: `distance < 0.5` → {Distance: [0.5]}. */
export function thresholds(grid = document.querySelector("table[role=grid]")) {
  const found = {};
  const heads = [...(grid?.tHead?.rows[0]?.cells ?? [])];
  const [inputs, formula] = ["inputs", "formula"].map((kind) => heads.findIndex((head) => head.dataset.kind === kind));
  if (inputs < 0 || formula < 0) return found;
  for (const row of grid.querySelectorAll("tbody > tr")) {
    const name = (row.cells[inputs]?.dataset.v ?? "").trim();
    const text = row.cells[formula]?.dataset.v ?? "";
    if (!name || /[,;\n]/.test(name)) continue;
    for (const [, word, number] of text.matchAll(/\b([A-Za-z]\w*)\s*[<>]=?\s*(-?\d+(?:\.\d+)?)/g)) put(found, name, word, number);
    for (const [, number, word] of text.matchAll(/(-?\d+(?:\.\d+)?)\s*[<>]=?\s*([A-Za-z]\w*)/g)) put(found, name, word, number);
  }
  return found;
}

function put(found, name, word, number) {
  const plain = (text) => text.toLowerCase().replace(/[^\p{L}\p{N}]/gu, "");
  if (plain(word) !== "value" && plain(word) !== plain(name)) return;
  (found[name] ??= []).push(Number(number));
}
