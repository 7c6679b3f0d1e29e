// The sheet for who has two keys (a switch, say): Tab goes to the next cell or suggestion, Enter opens the cell or takes the suggestion.
// After the first blank row Tab leaves the sheet, and comes back to its beginning.

import { isComposed } from "../commands.js";
import { hasTwoKeys } from "../preferences.js";
import { t } from "../texts.js";

export function twoKeys(grid) {
  const { editor, scroll, selection, table, spoken } = grid;

  scroll.addEventListener("keydown", (event) => {
    const { key, shiftKey, ctrlKey, altKey, metaKey } = event;
    if (!hasTwoKeys() || shiftKey || ctrlKey || altKey || metaKey || isComposed(event) || !["Tab", "Enter"].includes(key)) return;
    if (!editor.isOpen && (!selection.cell || event.target.closest("button"))) return;
    if (key === "Tab" && !editor.isOpen) {
      if (!leaves()) return;
      editor.leave();
      event.stopImmediatePropagation(); // the browser's own Tab goes on from the first cell
      return;
    }
    if (!(key === "Enter" ? (editor.isOpen ? take : open) : next)()) return;
    event.preventDefault();
    event.stopImmediatePropagation();
  }, true);

  function leaves() {
    const empty = table.rows.length - table.room() === 0;
    const blank = empty ? table.rows[0] : table.step(table.lastFilled(), 1);
    const ends = selection.head.k === table.width - 1 && table.at(selection.row) >= table.at(blank);
    if (ends) selection.go(table.rows[0], 0);
    return ends;
  }

  function open() {
    if (selection.cell.classList.contains("on")) selection.cell.querySelector("input")?.click();
    else editor.open(selection.cell, "");
    return true;
  }

  /** The next suggestion; after the last comes none, which leaves the cell as it was. */
  function next() {
    const count = editor.found.items.length;
    if (!editor.offers || !count) return false;
    if (editor.chosen < count - 1) editor.choose(1);
    else {
      editor.chosen = -1;
      editor.point();
      spoken.say(t("No suggestion: the cell stays as it was."));
    }
    return true;
  }

  function take() {
    const { partial } = editor.found;
    if (editor.offers && editor.chosen >= 0) {
      editor.accept(editor.chosen);
      if (partial) editor.update(true); // a field or an argument follows
      else editor.close(true, "tab");
    } else if (editor.field.value === "" && editor.was !== "") editor.close(false, "tab");
    else editor.close(true, "tab");
    return true;
  }
}
