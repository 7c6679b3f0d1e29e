// The page loads again when the server was started again, or asks for it for another reason; but not while something is being
// typed or is not saved yet. The cursor comes back to its cell.

const AGAIN = 500; // milliseconds until it is looked again whether somebody types

export function renewed(grid, listen) {
  let waits = false;
  listen.addEventListener("program", ({ detail }) => {
    const { program } = listen.dataset;
    if (program && JSON.parse(detail.data).version !== program) wait("The program was renewed.");
  });
  listen.addEventListener("reload", ({ detail }) => {
    const { sheet, why } = JSON.parse(detail.data);
    if (!sheet || sheet === grid.server.sheet) wait(why ?? "This page is not up to date.");
  });

  function wait(why) {
    if (waits) return;
    waits = true;
    if (!load()) grid.say(`${why} This page loads again when you have finished typing.`);
  }

  function load() {
    const typing = grid.editor.isOpen || grid.server.unsent.entries.length || document.querySelector("dialog[open]")
      || document.activeElement?.matches("input:not([type=checkbox]), textarea");
    if (typing) {
      setTimeout(load, AGAIN);
      return false;
    }
    const { row, cell } = grid.selection;
    if (cell) history.replaceState(history.state, "", `#${row.id}~${grid.table.address(cell)}`);
    location.reload();
    return true;
  }
}
