// The headers of the sheet: those of a table are renamed by F2, Enter or a double click; of other sheets they are fixed. Each sheet
// gets the columns that its kind may have, a table any.

import { button, make } from "../elements.js";
import { t } from "../texts.js";
import { open } from "./dialog.js";

export class Headers {
  constructor(grid) {
    this.grid = grid;
    const { table, selection } = grid;
    const renamed = table.kind === "table"; // these are reached by Tab, too
    const focus = (k) => {
      if (renamed) for (const [i, head] of table.headers.entries()) head.tabIndex = i === k ? 0 : -1;
      table.headers[k].focus({ preventScroll: true });
    };
    for (const [k, head] of table.headers.entries()) {
      head.tabIndex = renamed && !k ? 0 : -1;
      head.addEventListener("dblclick", (event) => event.target.closest(".widen, button") || this.edit(k));
      head.addEventListener("click", (event) => event.target.closest(".widen, button") || focus(k));
      head.addEventListener("keydown", (event) => {
        if (event.target !== head) return;
        const { key, ctrlKey, metaKey, altKey, shiftKey } = event;
        const to = { ArrowLeft: k - 1, ArrowRight: k + 1 }[key];
        const types = !(ctrlKey || metaKey || altKey) && ([...key].length === 1 || ["F2", "Enter", "Delete", "Backspace"].includes(key));
        if (key === "F2" && shiftKey) grid.threads.open(head);
        else if (types) this.edit(k); // what is typed is not for the cell where the cursor was
        else if (key === "ArrowDown") selection.go(table.rows[0], k);
        else if (table.headers[to]) focus(to);
        else return;
        event.preventDefault();
        event.stopPropagation();
      });
    }
  }

  /** Ask for another name of a table's column; tell of another sheet that its headers are fixed. */
  edit(k) {
    const { grid } = this;
    if (grid.table.kind === "table") grid.renaming.askColumn(k);
    else if (!grid.refuses()) grid.say(t("The headers of this sheet are fixed. To add a column, right-click a header or open Rows, then choose “Add a column …”."));
  }

  /** Ask which column to add. */
  add() {
    const { grid } = this;
    if (grid.held.takes(() => this.add()) || grid.refuses()) return;
    const { kind } = grid.table;
    const add = (name, text) => {
      dialog.close();
      this.send(name, text);
    };
    const columns = grid.words.columns?.[grid.server.sheet] ?? [];
    const title = columns.length ? { devices: t("Settings of the devices in this sheet that have no column yet:"), gestures: t("Joints of the robot that have no column yet:") }[kind] ?? ""
      : t("This sheet has all columns that it may have.");
    const field = make("input", { required: true, maxLength: 100, autocomplete: "off" });
    const form = make("form", {}, make("label", { className: "field" }, t("Name"), " ", field), make("button", { className: "button first", textContent: t("Add") }));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (field.value.trim()) add(field.value.trim(), field.value.trim());
    });
    const dialog = open(t("Add a column"), kind === "table" ? [form] : [
      make("p", title),
      make("div", { className: "settings" }, ...columns.map(({ text, name, help, streams }) => {
        const choice = button("", () => add(name, text), "choice");
        choice.append(make("b", text), make("span", streams), make("small", help));
        return choice;
      })),
    ]);
    (kind === "table" ? form : dialog).append(button(t("Cancel"), () => dialog.close()));
  }

  send(setting, text) {
    const { grid } = this;
    const { row } = grid.selection;
    grid.held.until(async () => {
      const { rows = [] } = await grid.server.send("column", { setting, row: row.id, title: text });
      if (!rows.length) return;
      grid.say(t("Added the column {header}. Press Ctrl+Z to undo.", { header: text }));
      grid.lead(rows);
    });
  }
}
