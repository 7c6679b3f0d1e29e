// The keyboard, as in Excel.

export function keys(grid) {
  const { table, selection, scroll } = grid;
  scroll.addEventListener("keydown", (event) => {
    if (grid.editor.isOpen) {
      grid.editor.key(event);
      return;
    }
    if (event.isComposing || event.keyCode === 229) return; // an input method is at work
    if (!selection.head || event.target.closest("button, [role=menu]")) return;
    const control = event.ctrlKey || event.metaKey;
    const action = (control ? withControl(event) : plain(event)) ?? null;
    if (action === null) return;
    event.preventDefault();
    action();
  });

  function plain(event) {
    const { row } = selection;
    const { k } = selection.head;
    const shift = event.shiftKey;
    const page = Math.max(1, Math.floor(scroll.clientHeight / row.offsetHeight) - 1);
    const { key } = event;
    if (event.altKey) {
      return {
        ArrowUp: () => grid.rows.move(-1), ArrowDown: () => grid.rows.move(1),
        ArrowLeft: () => grid.columns.step(k, -1), ArrowRight: () => grid.columns.step(k, 1),
      }[key];
    }
    const known = {
      ArrowUp: () => selection.go(table.step(row, -1), k, shift),
      ArrowDown: () => selection.go(table.step(row, 1), k, shift),
      ArrowLeft: () => selection.go(row, Math.max(k - 1, 0), shift),
      ArrowRight: () => selection.go(row, Math.min(k + 1, table.width - 1), shift),
      Home: () => selection.go(row, 0, shift),
      End: () => selection.go(row, table.width - 1, shift),
      PageUp: () => selection.go(table.step(row, -page), k, shift),
      PageDown: () => selection.go(table.step(row, page), k, shift),
      Enter: () => grid.move(shift ? "raise" : "enter", row, k),
      F2: () => grid.editor.open(selection.cell),
      Delete: () => grid.clear(),
      Backspace: () => grid.clear(),
    };
    if (key === "Tab") {
      const first = k === 0 && table.at(row) === 0;
      const last = k === table.width - 1 && table.at(row) === table.rows.length - 1;
      return (shift ? first : last) ? null : () => grid.move(shift ? "back" : "tab", row, k);
    }
    if (key === " " && shift) return () => selection.spread(selection.box().top, 0, selection.box().bottom, table.width - 1);
    if (key === " " && selection.cell.classList.contains("on")) return () => selection.cell.querySelector("input")?.click();
    if (known[key]) return known[key];
    return [...key].length === 1 ? () => grid.editor.open(selection.cell, key) : null;
  }

  function withControl(event) {
    const { row } = selection;
    const { k } = selection.head;
    const shift = event.shiftKey;
    const jump = (down, right) => () => selection.go(...table.edge(row, k, down, right), shift);
    return {
      arrowup: jump(-1, 0), arrowdown: jump(1, 0), arrowleft: jump(0, -1), arrowright: jump(0, 1),
      home: () => selection.go(table.rows[0], 0, shift),
      end: () => selection.go(table.lastFilled(), table.width - 1, shift),
      a: () => selection.spread(0, 0, table.rows.length - 1, table.width - 1),
      d: () => grid.fillDown(),
      z: () => (shift ? grid.redo() : grid.undo()),
      y: () => grid.redo(),
      ".": () => grid.mending.go(),
      f: () => document.dispatchEvent(new CustomEvent("rrp:find")),
      "+": () => grid.rows.insert(), "-": () => grid.rows.remove(),
      " ": () => selection.spread(0, selection.box().left, table.rows.length - 1, selection.box().right),
    }[event.key.toLowerCase()];
  }
}
