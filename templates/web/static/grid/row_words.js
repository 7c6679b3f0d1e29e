// The rows in words: the row under the pointer and its sentence show each other, and so do the row with the cursor and its own.

export function rowWords(grid) {
  const { grid: table } = grid.table;
  const panels = document.getElementById("panels");
  let here = 0; // the number of the row with the cursor

  const sentence = (number) => panels.querySelector(`#row-words > [data-number="${number}"]`);
  function mark(name, number) {
    panels.querySelector(`#row-words > .${name}`)?.classList.remove(name);
    sentence(number)?.classList.add(name);
  }

  document.addEventListener("rrp:row", ({ detail }) => {
    here = detail.number;
    mark("here", here);
  });
  document.addEventListener("htmx:after:swap", () => mark("here", here));
  table.addEventListener("pointerover", ({ target }) => mark("pointed", Number(target.closest("tr[id]")?.cells[0].textContent) || 0));
  table.addEventListener("pointerleave", () => mark("pointed", 0));

  let shown = null; // the row that a sentence points to
  function show(words) {
    shown?.classList.remove("pointed");
    shown = words ? grid.table.row(words.querySelector("a").dataset.row) : null;
    shown?.classList.add("pointed");
  }
  for (const event of ["pointerover", "focusin"]) panels.addEventListener(event, ({ target }) => show(target.closest("#row-words > [data-number]")));
  for (const event of ["pointerleave", "focusout"]) panels.addEventListener(event, () => show(null));
}
