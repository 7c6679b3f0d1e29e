// Who else is here, and where; and one's own name, which the browser keeps.

import { button, make, open } from "./conflict.js";

export function people(grid, listen) {
  const line = document.getElementById("people");
  const own = document.querySelector("[data-do=name]");
  let others = [];

  own.querySelector("span").textContent = grid.server.name;
  own.hidden = "visitor" in document.documentElement.dataset; // who has logged in has said it there
  own.addEventListener("click", ask);
  listen.addEventListener("people", (event) => {
    others = JSON.parse(event.detail.data).people.filter((p) => !grid.spoken.own(p.client));
    line.textContent = others.length ? `${others.map(told).join(", ")} ${others.length > 1 ? "are" : "is"} here too` : "";
    mark();
  });
  grid.table.grid.addEventListener("rrp:rows", mark);

  function cellOf({ place }) {
    const [sheet, row, column] = place ?? [];
    if (sheet !== grid.server.sheet || !grid.table.row(row)) return null;
    const k = grid.table.headers.findIndex((h) => Number(h.dataset.c) === column);
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
    const label = make("label", "Your name, as the others see it ");
    label.className = "field";
    const field = make("input");
    field.value = grid.server.name === "Somebody" ? "" : grid.server.name;
    field.maxLength = 40;
    field.autocomplete = "given-name";
    label.append(field);
    const dialog = open("Who are you?", [label]);
    const keep = () => {
      localStorage.setItem("name", field.value.trim() || "Somebody");
      own.querySelector("span").textContent = grid.server.name;
      if (grid.selection.head) grid.server.stand(grid.selection.head.row, grid.selection.head.k);
      dialog.close();
    };
    field.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault(); // else the button that has the focus again would be pressed by it
      keep();
    });
    dialog.append(button("Keep", keep), button("Cancel", () => dialog.close()));
    field.focus();
  }
}
