// The commands of keys, menus and buttons: one table, of which each place takes its own. A shortcut is an entry here and a line in
// rrp_sheets/help/keys.md. Keys within one part of a page (diagram, dialogs, column widths, look back) are in that part's module.
// An entry has what it needs of these:
//   section, told, help: its line of the help on keys (rrp_sheets/help/keys.md); an entry without `told` belongs to the line above it
//   name, label: for menus and for buttons with `data-do`
//   at: the place where its keys work: `cell`, `editor`, `row` (both), `page`, `tab` (of a sheet), `operator`, `views`, `anywhere`
//   keys: names of keys as the browser has them. `Ctrl+` is also Cmd; `Any+` stands for whatever is held; `Character` for what types one.
//     Shift may always be held, unless there is another entry with it; `Escape Escape` is one key twice
//   when: whether it can be done now; else the key does what it did without us
//   run: does it. Both are given what the place is about (the grid, mostly), then the event

import { t } from "./texts.js";

const WAYS = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }; // rows down, columns to the right
const ARROWS = Object.keys(WAYS);
const TYPED = "input:not([type=range], [type=checkbox], [type=radio]), textarea, select, [role=grid], dialog, .editor";
const TWICE = 1500; // ms between two presses of a key: time for a slow hand, too
const SPOKEN = { Ctrl: t("Control"), ".": t("point") };
const SHOWN = { ArrowUp: "↑", ArrowDown: "↓", "-": "−", Delete: "Del" };

export const COMMANDS = [
  { section: "Moving", told: "arrows, Tab, Enter", help: "to the next cell; with Shift back; Enter after Tabs goes below the cell where they began",
    at: "cell", keys: ARROWS, run: ({ selection }, { key, shiftKey }) => selection.step(...WAYS[key], shiftKey) },
  { at: "cell", keys: ["Tab"], when: ({ selection }, { shiftKey }) => !selection.isLast(shiftKey), run: (grid, { shiftKey }) => grid.move(shiftKey ? "back" : "tab") },
  { at: "cell", keys: ["Enter"], run: (grid, { shiftKey }) => grid.move(shiftKey ? "raise" : "enter") },
  { told: "Ctrl + arrow", help: "to the edge of what is filled",
    at: "cell", keys: ARROWS.map((key) => `Ctrl+${key}`), run: ({ selection }, { key, shiftKey }) => selection.jump(...WAYS[key], shiftKey) },
  { told: "Home, End", help: "to the first, the last cell of the row; with Ctrl of the sheet",
    at: "cell", keys: ["Home"], run: ({ selection }, { shiftKey }) => selection.go(selection.row, 0, shiftKey) },
  { at: "cell", keys: ["End"], run: ({ selection, table }, { shiftKey }) => selection.go(selection.row, table.width - 1, shiftKey) },
  { at: "cell", keys: ["Ctrl+Home"], run: ({ selection, table }, { shiftKey }) => selection.go(table.shown[0], 0, shiftKey) },
  { at: "cell", keys: ["Ctrl+End"], run: ({ selection, table }, { shiftKey }) => selection.go(table.lastFilled(), table.width - 1, shiftKey) },
  { told: "PageUp, PageDown", help: "a page up, down",
    at: "cell", keys: ["PageUp"], run: ({ selection }, { shiftKey }) => selection.step(-selection.page, 0, shiftKey) },
  { at: "cell", keys: ["PageDown"], run: ({ selection }, { shiftKey }) => selection.step(selection.page, 0, shiftKey) },
  { told: "Shift + any of these", help: "selects cells on the way" },
  { name: "addRange", told: "Ctrl + click", help: "selects further cells; by keys: Ctrl + Shift + F8, then the arrows, Esc to end",
    at: "cell", keys: ["Ctrl+Shift+F8"], run: ({ selection }) => selection.add() },
  { at: "cell", keys: ["Escape"], when: ({ selection }) => selection.adding, run: ({ selection }) => selection.ends() },
  { told: "Shift + Space, Ctrl + Space, Ctrl + A", help: "selects the row, the column, everything",
    at: "cell", keys: ["Shift+Space"], run: ({ selection, table }) => selection.surround(selection.box().top, 0, selection.box().bottom, table.width - 1) },
  { at: "cell", keys: ["Ctrl+Space"], run: ({ selection, table }) => selection.surround(0, selection.box().left, table.rows.length - 1, selection.box().right) },
  { at: "cell", keys: ["Ctrl+a"], run: ({ selection, table }) => selection.surround(0, 0, table.rows.length - 1, table.width - 1) },

  { section: "Editing", told: "any letter", help: "replaces what is in the cell",
    at: "cell", keys: ["Character"], run: ({ editor, selection }, { key }) => editor.open(selection.cell, key) },
  { told: "F2", help: "edits it; arrows then move within the text",
    at: "cell", keys: ["F2"], run: ({ editor, selection }) => editor.open(selection.cell) },
  { at: "editor", keys: ["Any+F2"], run: ({ editor }) => editor.change() },
  { at: "editor", keys: ["Any+ArrowDown"], when: ({ editor }) => editor.offers, run: ({ editor }) => editor.choose(1) },
  { at: "editor", keys: ["Any+ArrowUp"], when: ({ editor }) => editor.offers, run: ({ editor }) => editor.choose(-1) },
  { at: "editor", keys: ARROWS.map((key) => `Any+${key}`), when: ({ editor }) => editor.mode === "enter" && !editor.offers,
    run: ({ editor }, { key }) => editor.close(true, key.slice(5).toLowerCase()) },
  { name: "keep", told: "Enter, Tab", help: "saves it; Tab takes the first suggestion in a formula",
    at: "editor", keys: ["Any+Enter", "Any+Tab"], run: ({ editor }, event) => editor.end(event) },
  { name: "keepHere", told: "Ctrl + Enter", help: "writes the text into all selected cells; saves a changed name in this cell only, where Enter renames it everywhere",
    at: "editor", keys: ["Ctrl+Enter"], run: (grid) => grid.fillAll() },
  { name: "showCells", told: "Ctrl + Shift + Enter", help: "shows the cells in which a changed name would change",
    at: "editor", keys: ["Ctrl+Shift+Enter"], run: ({ editor }) => editor.look() },
  { told: "Alt + Enter", help: "a new line in the cell", at: "editor", keys: ["Alt+Enter"], run: ({ editor }) => editor.newLine() },
  { told: "Esc", help: "cancels what was typed", at: "editor", keys: ["Any+Escape"], run: ({ editor }) => editor.escape() },
  { name: "clear", label: t("Clear"), told: "Delete", help: "empties the selected cells", at: "cell", keys: ["Delete", "Backspace"], run: (grid) => grid.clear() },
  { name: "renameName", label: t("Rename everywhere …"), when: ({ renaming, selection }) => renaming.names(selection.cell).length > 0,
    run: ({ renaming, selection }) => renaming.ask(renaming.names(selection.cell)) },
  { name: "renameColumn", label: t("Rename column …"), when: ({ table }) => table.kind === "table", run: ({ renaming }) => renaming.askColumn() },
  { name: "addColumn", label: t("Add a column …"), when: ({ table }) => Boolean(table.kind), run: ({ headers }) => headers.add() },
  { name: "comment", label: t("Comment …"), told: "Shift + F2", help: "shows the comments of the cell, to read, write and answer",
    at: "cell", keys: ["Shift+F2"], run: ({ threads }) => threads.open() },
  { name: "commentHeader", label: t("Comment …"), run: ({ threads, table, selection }) => threads.open(table.headers[table.column(selection.cell)]) },
  { name: "comments", label: t("All comments"), run: ({ threads }) => threads.list() },
  { name: "bold", label: t("Bold"), told: "Ctrl + B", help: "makes the selected cells bold, or not bold", at: "cell", keys: ["Ctrl+b"], run: ({ looks }) => looks.bold() },
  { name: "fillColour", label: t("Fill colour …"), run: ({ looks }) => looks.choose() },
  { name: "wrap", label: t("Wrap text"), run: ({ looks }) => looks.wrap() },
  { told: "Space", help: "ticks the On column",
    at: "cell", keys: ["Space"], when: ({ selection }) => selection.cell.classList.contains("on"), run: ({ selection }) => selection.cell.querySelector("input")?.click() },
  { name: "mend", told: "Ctrl + .", help: "fixes the problem of the cell, as its message proposes", at: "cell", keys: ["Ctrl+."], run: ({ mending }) => mending.go() },
  { name: "uncomment", at: "row", keys: ["Ctrl+."], when: ({ comments }) => comments.can(), run: ({ comments }) => comments.uncomment() },
  { name: "undo", told: "Ctrl + Z, Ctrl + Y", help: "undoes the last change, redoes it", at: "cell", keys: ["Ctrl+z"], run: (grid) => grid.undo() },
  { name: "redo", at: "cell", keys: ["Ctrl+y", "Ctrl+Shift+z"], run: (grid) => grid.redo() },
  { at: "page", keys: ["Ctrl+z"], when: elsewhere, run: (grid) => grid.undo() },
  { at: "page", keys: ["Ctrl+y", "Ctrl+Shift+z"], when: elsewhere, run: (grid) => grid.redo() },
  { told: "Ctrl + S", help: "is not needed: everything that you enter is saved at once",
    at: "page", keys: ["Ctrl+s"], run: enterNow },

  { section: "Copying", told: "Ctrl + C, X, V", help: "copies, cuts, pastes, also from and to Excel and LibreOffice" }, // the browser's own: clipboard.js
  { name: "cut", label: t("Cut"), keys: ["Ctrl+x"], run: ({ clipboard }) => clipboard.cut() },
  { name: "copy", label: t("Copy"), keys: ["Ctrl+c"], run: ({ clipboard }) => clipboard.copy() },
  { name: "paste", label: t("Paste"), keys: ["Ctrl+v"], run: ({ clipboard }) => clipboard.fromMenu() },
  { name: "fillDown", label: t("Fill down"), told: "Ctrl + D, Ctrl + R", help: "fills the selection with its first row, its first column; a single cell with the one above, at the left",
    at: "cell", keys: ["Ctrl+d"], run: (grid) => grid.fill() },
  { name: "fillRight", label: t("Fill right"), at: "cell", keys: ["Ctrl+r"], run: (grid) => grid.fill(true) },
  { name: "find", told: "Ctrl + F, Ctrl + H", help: "finds and replaces", at: "cell", keys: ["Ctrl+f", "Ctrl+h"], run: ({ finder }) => finder.open() },

  { section: "Rows and columns", name: "insertAbove", label: t("Insert above"), told: "Ctrl + Plus, Ctrl + Minus", help: "inserts, deletes the selected rows",
    at: "cell", keys: ["Ctrl++"], run: ({ rows }) => rows.insert() },
  { name: "deleteRows", label: t("Delete rows"), at: "cell", keys: ["Ctrl+-"], run: ({ rows }) => rows.remove() },
  { name: "insertBelow", label: t("Insert below"), run: ({ rows }) => rows.insert(true) },
  { name: "duplicateRows", label: t("Duplicate"), run: ({ rows }) => rows.duplicate() },
  { name: "moveUp", label: t("Move up"), told: "Alt + Up, Alt + Down", help: "moves them", at: "cell", keys: ["Alt+ArrowUp"], run: ({ rows }) => rows.move(-1) },
  { name: "moveDown", label: t("Move down"), at: "cell", keys: ["Alt+ArrowDown"], run: ({ rows }) => rows.move(1) },
  { told: "Alt + Left, Alt + Right", help: "makes the column narrower, wider",
    at: "cell", keys: ["Alt+ArrowLeft"], run: ({ columns, selection }) => columns.step(selection.head.k, -1) },
  { at: "cell", keys: ["Alt+ArrowRight"], run: ({ columns, selection }) => columns.step(selection.head.k, 1) },
  { name: "fitColumn", label: t("Fit column width"), told: "double click on a header’s right edge", help: "makes the column as wide as its texts",
    run: ({ columns, table, selection }) => columns.fit(table.places[selection.head.k]) },
  { name: "filter", label: t("Filter this column …"), told: "Ctrl + Shift + L", help: "filters the rows by the values of the column, as ▾ in its header does",
    at: "cell", keys: ["Ctrl+Shift+l"], run: ({ filter }) => filter.open() },
  { name: "filterAgain", label: t("Apply the filter again"), told: "Ctrl + Alt + L", help: "applies the filter again, after edits",
    at: "cell", keys: ["Ctrl+Alt+l"], when: ({ filter }) => filter.active, run: ({ filter }) => filter.apply() },
  { name: "showAll", label: t("Show all rows"), when: ({ filter }) => filter.active, run: ({ filter }) => filter.showAll() },
  { name: "onlyProblems", run: ({ filter }) => filter.onlyProblems() },
  { told: "right click on a header", help: "everything that you can do with the column; in the sheet Devices: adds a column for a setting" }, // selection.js
  { name: "rows", told: "Menu key", help: "everything that you can do with rows", run: ({ menu }, button) => menu.below(button) }, // the key is the browser's own

  { section: "Sheets", name: "renameSheet", label: t("Rename"), told: "F2, Delete at a tab",
    help: "renames the sheet, deletes it; Menu key or right click: everything that you can do with it", at: "tab", keys: ["Any+F2"], run: ({ tabs, sheet }) => tabs.rename(sheet) },
  { name: "duplicateSheet", label: t("Duplicate"), when: ({ kind }) => ["behaviour", "test", "table"].includes(kind), run: ({ tabs, sheet }) => tabs.send("duplicate", { of: sheet }) },
  { name: "moveSheetLeft", label: t("Move left"), run: ({ tabs, sheet }) => tabs.send("move", { of: sheet, by: -1 }) },
  { name: "moveSheetRight", label: t("Move right"), run: ({ tabs, sheet }) => tabs.send("move", { of: sheet, by: 1 }) },
  { name: "deleteSheet", label: t("Delete"), at: "tab", keys: ["Any+Delete"], run: ({ tabs, sheet }) => tabs.remove(sheet) },
  { told: "+ after the tabs", help: "adds a behaviour, a test, a table, or what is missing" },

  { section: "Elsewhere", name: "help", told: "F1", help: "help on the cell", at: "page", keys: ["Any+F1"], run: ({ help }) => help.toggle() },
  { name: "nextProblem", told: "F8", help: "to the next problem in the sheet, errors first; with Shift to the one before",
    at: "page", keys: ["F8"], run: ({ statusBar }) => statusBar.step(1) },
  { name: "previousProblem", at: "page", keys: ["Shift+F8"], run: ({ statusBar }) => statusBar.step(-1) },
  { told: "F6", help: "to the diagram and the problems, and back to the sheet", at: "page", keys: ["Any+F6"], run: (grid) => grid.beside() },
  { name: "test", run: ({ server }) => server.send("test", {}) },
  { name: "name", run: ({ people }) => people.ask() },

  { section: "During a run", told: "Esc Esc", help: "stops the run, wherever you are", at: "anywhere", keys: ["Escape Escape"], run: (stop) => stop() },
  { told: "1 to 9", help: "press the operator’s buttons, except while you type in a cell or a field", at: "operator", keys: [..."123456789"],
    when: (place, { key, repeat, target }) => !repeat && !target.closest?.(TYPED) && nth(place, key)?.disabled === false, run: (place, { key }) => nth(place, key).click() },
  // browsers let a page have these, though they change the tab by them where a page does not take them
  { told: "Ctrl + 1 to 8", help: "choose what is shown below the rows", at: "views", keys: [..."12345678"].map((key) => `Ctrl+${key}`),
    when: (tabs, { key }) => Number(key) <= tabs.length && noDialog(), run: (tabs, { key }) => tabs[Number(key) - 1].click() },
];

function noDialog() {
  return !document.querySelector("dialog[open]");
}

function enterNow(grid) {
  grid.editor.close(true, null);
  grid.say(t("Everything that you enter is saved at once."));
}

// a field has its own undo, a cell the entries above
function elsewhere(grid, { target }) {
  return !target.closest?.(TYPED) && noDialog();
}

/** True for a key that belongs to an input method, as Enter at the end of what it composes; Safari tells that by the code alone. */
export const isComposed = ({ isComposing, keyCode }) => isComposing || keyCode === 229;

const COPYING = ["cut", "copy", "paste", "clear", ""];
const COLUMN = ["fitColumn", "filter", "filterAgain", "showAll"];
const ROWS = ["", "insertAbove", "insertBelow", "duplicateRows", "moveUp", "moveDown", "deleteRows"];
const MENUS = {
  cell: [...COPYING, "renameName", "renameColumn", "addColumn", "comment", "comments", "", "bold", "fillColour", "wrap", "", "fillDown", "fillRight", ...ROWS, "", ...COLUMN],
  rows: [...COPYING, "fillDown", ...ROWS, "addColumn"],
  head: ["renameColumn", "addColumn", "commentHeader", "comments", "", ...COLUMN],
  tab: ["renameSheet", "duplicateSheet", "moveSheetLeft", "moveSheetRight", "deleteSheet"],
};

const nth = (place, key) => place.querySelectorAll("button")[Number(key) - 1];
const named = (name) => COMMANDS.find((command) => command.name === name);

/** Run the command of a key at a place; true if there is one. */
export function press(at, event, about) {
  for (const key of names(event)) {
    const found = COMMANDS.find((one) => one.at === at && one.keys.includes(key) && (one.when?.(about, event) ?? true));
    if (!found) continue;
    event.preventDefault();
    found.run(about, event);
    return true;
  }
  return false;
}

// how the table may call a key, the most exact name first
function names({ key, ctrlKey, metaKey, altKey, shiftKey }) {
  const name = key === " " ? "Space" : key;
  const control = ctrlKey || metaKey;
  const plain = !control && !altKey;
  const held = [...(control && altKey ? ["Ctrl+Alt+"] : []), ...(control ? ["Ctrl+"] : []), ...(altKey ? ["Alt+"] : []), ...(plain ? [""] : [])];
  const exact = held.flatMap((before) => {
    const one = before.startsWith("Ctrl+") && name.length === 1 ? name.toLowerCase() : name;
    return shiftKey ? [`${before}Shift+${one}`, before + one] : [before + one];
  });
  return [...exact, ...(plain && [...key].length === 1 ? ["Character"] : []), `Any+${name}`];
}

/** Run the command of a key that is pressed twice, wherever the focus is; each press also has its own effect. */
export function pressTwice(at, about) {
  let first = {};
  window.addEventListener("keydown", ({ key, timeStamp, repeat }) => {
    if (repeat) return;
    const twice = key === first.key && timeStamp - first.timeStamp < TWICE;
    first = twice ? {} : { key, timeStamp };
    if (twice) COMMANDS.find((one) => one.at === at && one.keys.includes(`${key} ${key}`))?.run(about);
  }, { capture: true });
}

/** Run the command that a button with `data-do` names, if it can be done now. */
export function command(name, about, button) {
  const { when, run } = named(name);
  if (when?.(about) ?? true) run(about, button);
}

/** The items of a menu, as `menuOf` takes them; null for a line between two. */
export function items(menu, about) {
  const found = MENUS[menu].map((name) => (name ? named(name) : null)).filter((one) => one?.when?.(about) ?? true);
  return found.map((one) => one && [one.label, () => one.run(about), hint(one)]);
}

/** The keys of a command as a menu names them: `Ctrl D`. */
export function hint({ keys: [first = ""] = [] }) {
  const [, held, key] = /^(?:Any\+)?((?:(?:Ctrl|Alt|Shift)\+)*)(.*)$/.exec(first);
  return held.replaceAll("+", " ") + (SHOWN[key] ?? (key.length === 1 ? key.toUpperCase() : key));
}

/** The same for the command of a name. */
export const hintOf = (name) => hint(named(name));

/** The same in words, for a screen reader: `Control point`. */
export const spokenHintOf = (name) => hintOf(name).split(" ").map((part) => SPOKEN[part] ?? part).join(" ");
