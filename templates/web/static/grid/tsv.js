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

// A quote at the beginning of a cell opens a quoted cell only if it is closed before a tab, a line break or the end:
// a formula such as "near" & x is copied by some programs as it stands.
function closes(source, open) {
  for (let i = open + 1; i < source.length; i++) {
    if (source[i] !== '"') continue;
    if (source[i + 1] === '"') i++;
    else return i + 1 === source.length || source[i + 1] === "\t" || source[i + 1] === "\n";
  }
  return false;
}

/** The text of some rows of cells: each ends with a line break, so that a last blank one is there too; one cell has none. */
export function format(rows) {
  const lines = rows.map((cells) => cells.map(quote).join("\t"));
  return rows.length === 1 && rows[0].length === 1 ? lines[0] : `${lines.join("\n")}\n`;
}

function quote(text) {
  return /[\t\n\r"]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
