// Other people: who is here, and where; one's own name, which the browser keeps; two who have edited the same cell.

import { isNamed, shownName } from "../api.js";
import { isComposed } from "../commands.js";
import { button, make } from "../elements.js";
import { listed, t, tn } from "../texts.js";
import { open } from "./dialog.js";

export function people(grid, listen) {
  const line = document.getElementById("people");
  const own = document.querySelector("[data-do=name]");
  let others = [];

  own.querySelector("span").textContent = shownName(grid.server.name);
  own.hidden = "visitor" in document.documentElement.dataset; // who has logged in has said it there
  listen.addEventListener("people", (event) => {
    others = JSON.parse(event.detail.data).people.filter((p) => !grid.spoken.own(p.client));
    line.textContent = others.length ? tn("{names} is here too", "{names} are here too", { n: others.length, names: listed(others.map(told)) }) : "";
    mark();
  });
  grid.table.grid.addEventListener("rrp:rows", mark);
  return { ask };

  function cellOf({ place }) {
    const [sheet, row, column] = place ?? [];
    if (sheet !== grid.server.sheet || !grid.table.row(row)) return null;
    const k = grid.table.placeOf(column);
    return k < 0 ? null : { row: grid.table.row(row), k };
  }

  function told(person) {
    const at = cellOf(person);
    const there = at ? `${grid.table.headers[at.k].dataset.letter}${at.row.cells[0].textContent}` : person.place?.[0];
    return there ? `${person.name} (${there})` : person.name;
  }

  function mark() {
    for (const old of grid.table.grid.querySelectorAll("[data-who]")) delete old.dataset.who;
    for (const person of others) {
      const at = cellOf(person);
      if (at) grid.table.cell(at.row, at.k).dataset.who = person.name;
    }
  }

  function ask() {
    const label = make("label", {}, t("Your name, as the others see it"), " ");
    label.className = "field";
    const field = make("input");
    field.value = isNamed(grid.server.name) ? grid.server.name : "";
    field.maxLength = 40;
    field.autocomplete = "given-name";
    label.append(field);
    const dialog = open(t("Who are you?"), [label]);
    const keep = () => {
      localStorage.setItem("name", field.value.trim());
      own.querySelector("span").textContent = shownName(grid.server.name);
      if (grid.selection.head) grid.server.stand(grid.selection.head.row, grid.selection.head.k);
      dialog.close();
    };
    field.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" || isComposed(event)) return;
      event.preventDefault(); // else the button that has the focus again would be pressed by it
      keep();
    });
    dialog.append(button(t("Keep"), keep), button(t("Cancel"), () => dialog.close()));
    field.focus();
  }
}

// Conflicts, where somebody else was quicker: both texts, to choose from. Nothing is lost without being shown.

/** Ask about each cell that somebody else has changed meanwhile: mine, theirs, or both, with mine as a note. */
export function conflict(grid, clashes) {
  const choices = new Map(clashes.map((clash) => [clash, null]));
  const list = clashes.map((clash) => {
    const row = grid.table.row(clash.row);
    const k = grid.table.placeOf(clash.column);
    const place = row && k >= 0 ? `${grid.table.headers[k].dataset.letter}${row.cells[0].textContent}` : t("a deleted row");
    const part = make("section");
    const who = shownName(clash.by);
    part.append(make("h3", t("{cell}: {name} has changed this cell", { cell: place, name: who })), pair(t("Yours"), clash.mine), pair(isNamed(clash.by) ? t("{name}’s", { name: who }) : t("Theirs"), clash.theirs));
    const ways = [[t("Keep mine"), "mine"], [t("Keep theirs"), "theirs"]];
    if (noteOf(clash)) ways.push([noteOf(clash).same ? t("Keep both") : t("Keep both: mine as a note"), "both"]);
    part.append(...ways.map(([text, choice]) => button(text, () => settle(clash, choice, part))));
    part.setAttribute("aria-label", place);
    return part;
  });
  const dialog = open(t("Somebody else was quicker"), list);
  if (clashes.length > 1) dialog.append(button(t("Keep all mine"), () => all("mine")), button(t("Keep all theirs"), () => all("theirs")));

  function all(wanted) {
    for (const [clash, choice] of choices) if (choice === null) choices.set(clash, wanted);
    finish();
  }

  /** The cell that takes one's own text beside the other's: the row's note, or the cell itself where that is a note. */
  function noteOf(clash) {
    const row = grid.table.row(clash.row);
    const k = grid.table.ofKind("notes");
    if (!row || k < 0 || !clash.mine) return null;
    const column = grid.table.sheetColumn(k);
    const same = column === clash.column;
    const was = same ? clash.theirs : grid.table.value(grid.table.cell(row, k));
    const mine = same ? clash.mine : `${grid.server.name}: ${clash.mine}`;
    return { row: clash.row, column, text: was ? `${was}\n${mine}` : mine, was, same };
  }

  function settle(clash, choice, part) {
    choices.set(clash, choice);
    part.remove();
    if ([...choices.values()].includes(null)) dialog.querySelector("button").focus();
    else finish();
  }

  function finish() {
    dialog.close();
    const cells = [...choices].flatMap(([clash, choice]) => {
      const { row, column, mine } = clash;
      if (choice === "mine") return [{ row, column, text: mine, was: null }];
      const note = choice === "both" && noteOf(clash);
      return note ? [{ row: note.row, column: note.column, text: note.text, was: note.was }] : [];
    });
    if (cells.length) grid.server.send("cells", { cells }, cells.map((c) => c.row));
    const made = new Set(choices.values());
    grid.say(made.has("both") ? t("Both texts are saved.") : made.has("mine") ? t("Your text is saved.") : t("Their text is saved."));
  }
}

/** Texts that the server would not take: shown, so that they can be copied. */
export function lost(grid, why, cells) {
  const texts = cells.map((c) => c.text).filter(Boolean);
  if (!texts.length) return;
  const area = make("textarea", texts.join("\n"));
  area.readOnly = true;
  area.rows = Math.min(8, texts.length + 1);
  area.setAttribute("aria-label", t("What was not saved"));
  const dialog = open(t("This was not saved"), [make("p", why), area]);
  dialog.append(button(t("Close"), () => dialog.close()));
}

function pair(name, text) {
  const line = make("p");
  line.className = "version";
  line.append(make("b", name), make("code", text || t("(empty)")));
  return line;
}
