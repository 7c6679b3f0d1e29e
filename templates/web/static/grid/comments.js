// A row whose first cell begins with # is a comment, which the robot leaves out: whoever types into one is told at once.

/** The cell with the # that makes a row a comment; undefined when it is none. */
export function markOf(table, row) {
  const first = table.places.map((at) => row.cells[at]).find((cell) => table.value(cell).trim());
  return first && table.value(first).trimStart().startsWith("#") ? first : undefined;
}

/** What is told above the editor of a cell beside a comment, with a button where the # is all that is to go; else null. */
export function noteOf(table, cell) {
  const mark = markOf(table, cell.parentElement);
  if (!mark || mark === cell) return null;
  const note = document.createElement("div");
  note.className = "mend is-warning is-comment";
  const title = document.createElement("b");
  title.className = "severity";
  title.textContent = "Comment";
  const words = document.createElement("span");
  words.textContent = `${spoken(table, cell)} `;
  note.append(title, " ", words);
  if (alone(table, mark)) note.append(offer());
  return note;
}

/** The same, to be told aloud; empty for a cell that is beside no comment. */
export function spoken(table, cell) {
  const mark = markOf(table, cell.parentElement);
  if (!mark || mark === cell) return "";
  const does = alone(table, mark) ? "Without the # it counts." : "Write your row into an empty one (Esc leaves this cell).";
  return `This row begins with #: the robot leaves it out. ${does}`;
}

/** What the keys and the button beside a comment do; `look` lets a row look like what was typed into it at once. */
export function comments(grid) {
  const { table, scroll } = grid;
  scroll.addEventListener("pointerdown", (event) => {
    if (!event.target.closest("[data-uncomment]")) return;
    event.preventDefault(); // else the editor closes before
    uncomment(table.row(grid.editor.rowId));
  });
  scroll.addEventListener("keydown", (event) => {
    const { row, cell } = grid.selection;
    if (event.key !== "." || !(event.ctrlKey || event.metaKey) || !row) return;
    const mark = markOf(table, row);
    if (!mark || !alone(table, mark) || (mark === cell && grid.editor.isOpen)) return;
    event.preventDefault();
    event.stopPropagation();
    uncomment(row);
  }, true);

  function uncomment(row) {
    const mark = row && markOf(table, row);
    if (!mark || grid.refuses()) return;
    grid.change([[mark, table.value(mark).trimStart().replace(/^#+\s*/, "")]]);
    if (grid.editor.isOpen) grid.editor.mend();
    grid.say("The # is taken away: the row counts. Ctrl+Z takes it back.");
  }

  function look(row) {
    const mark = row && markOf(table, row);
    if (!row) return;
    row.classList.toggle("comment", Boolean(mark));
    row.classList.toggle("buried", Boolean(mark) && table.places.some((at) => row.cells[at] !== mark && table.value(row.cells[at])));
  }

  return { look };
}

// whether the row is whole without its #: there is nothing else in the cell, or it is the name of a stream
function alone(table, mark) {
  const { kind } = table.headers[table.column(mark)].dataset;
  return kind === "inputs" || !table.value(mark).replaceAll("#", "").trim();
}

function offer() {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "button small";
  button.tabIndex = -1;
  button.dataset.uncomment = "";
  const key = document.createElement("kbd");
  key.textContent = "Ctrl .";
  button.append("Take the # away", " ", key);
  return button;
}
