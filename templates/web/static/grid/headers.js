// The headers of the sheet: those of a table are renamed by F2, Enter or a double click; of other sheets they are fixed, and the
// sheet Devices gets a column for each setting.

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
    else if (!grid.refuses()) {
      grid.say(grid.table.kind === "devices" ? t("The headers of this sheet are fixed. To add a column, right-click a header or open Rows, then choose “Add a column …”.")
        : t("The headers of this sheet are fixed."));
    }
  }

  /** Ask which column to add to the sheet Devices. */
  add() {
    const { grid } = this;
    if (grid.held.takes(() => this.add()) || grid.refuses()) return;
    const settings = grid.words.columns ?? [];
    const dialog = open(t("Add a column"), [
      make("p", settings.length ? t("Settings of the devices in this sheet that have no column yet:") : t("Each setting of the devices in this sheet has a column already.")),
      make("div", { className: "settings" }, ...settings.map(({ text, name, help, streams }) => {
        const choice = button("", () => {
          dialog.close();
          this.send(name, text);
        }, "choice");
        choice.append(make("b", text), make("span", streams), make("small", help));
        return choice;
      })),
    ]);
    dialog.append(button(t("Cancel"), () => dialog.close()));
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
