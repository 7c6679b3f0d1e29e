// Mouse, pen and touch: selecting, extending, the fill handle, whole rows, opening a cell.

export function pointer(grid) {
  const { table, selection, scroll } = grid;
  const cellAt = (event) => {
    const cell = document.elementFromPoint(event.clientX, event.clientY)?.closest?.("[role=gridcell]");
    return cell && table.grid.contains(cell) && table.column(cell) >= 0 ? cell : null;
  };

  let touched = false; // two taps on one place are a double click to the browser, also when the table has scrolled between
  table.grid.addEventListener("pointerdown", (event) => {
    touched = event.pointerType === "touch";
    if (event.button !== 0 || event.target.closest("button, a")) return;
    const header = event.target.closest("[role=rowheader]");
    const cell = event.target.closest("[role=gridcell]");
    if (grid.editor.isOpen) grid.editor.close(true, null);
    if (event.target.closest("input")) {
      selection.go(cell.parentElement, table.column(cell), event.shiftKey);
      return;
    }
    if (header) {
      event.preventDefault();
      wholeRow(header.parentElement, event.shiftKey);
      return;
    }
    if (!cell || table.column(cell) < 0) return;
    if (event.pointerType === "touch") {
      tap(event, cell);
      return;
    }
    event.preventDefault();
    if (soonAfter(event) && table.row(pressed.row)) {
      selection.go(table.row(pressed.row), pressed.k, event.shiftKey);
      return;
    }
    pressed = { time: event.timeStamp, x: event.clientX, y: event.clientY, row: cell.parentElement.id, k: table.column(cell) };
    selection.go(cell.parentElement, table.column(cell), event.shiftKey);
    drag(event, (over) => selection.go(over.parentElement, table.column(over), true));
  });

  // the first click may have ended an edit, which can make its row higher: meant is the cell that was there then
  let pressed = { time: -1e9 };
  const forget = () => { pressed = { time: -1e9 }; };
  scroll.addEventListener("keydown", forget, true); // within a double click there is no key, and no press on a menu
  document.addEventListener("pointerdown", ({ target }) => table.grid.contains(target) || forget(), true);
  const soonAfter = (event) => event.timeStamp - pressed.time < 500
    && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < 5;
  table.grid.addEventListener("dblclick", (event) => {
    if (touched) return;
    const cell = soonAfter(event) ? table.cell(table.row(pressed.row), pressed.k) : event.target.closest("[role=gridcell]");
    if (cell && table.column(cell) >= 0) grid.editor.open(cell);
  });

  function wholeRow(row, extend) {
    const top = extend && selection.head ? selection.box().top : table.at(row);
    selection.spread(Math.min(top, table.at(row)), 0, Math.max(top, table.at(row)), table.width - 1);
  }

  // a tap selects; a tap on the selected cell edits it; a finger that moves scrolls
  function tap(event, cell) {
    const from = [event.clientX, event.clientY];
    const again = cell === selection.cell;
    const up = (end) => {
      stop();
      if (Math.hypot(end.clientX - from[0], end.clientY - from[1]) > 10) return;
      if (again) grid.editor.open(cell);
      else selection.go(cell.parentElement, table.column(cell), false);
    };
    const stop = () => {
      removeEventListener("pointerup", up);
      removeEventListener("pointercancel", stop);
    };
    addEventListener("pointerup", up);
    addEventListener("pointercancel", stop);
  }

  function drag(event, over, done = () => {}) {
    let last = null;
    const move = (now) => {
      const cell = cellAt(now);
      if (cell && cell !== last) over((last = cell));
    };
    const up = () => {
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", up);
      removeEventListener("pointercancel", up);
      done(last);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", up);
    addEventListener("pointercancel", up);
  }

  // the fill handle: by mouse it repeats the selection downwards; by touch it extends the selection
  selection.handle.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    const source = selection.cells().map((line) => line.map((cell) => table.value(cell)));
    const box = selection.box();
    const touch = event.pointerType === "touch";
    drag(event, (over) => {
      const to = touch ? table.column(over) : box.right;
      selection.anchor = { row: table.rows[box.top].id, k: box.left };
      selection.go(table.rows[Math.max(table.at(over.parentElement), touch ? 0 : box.bottom)], to, true);
    }, () => {
      if (touch) return;
      const lines = selection.cells().slice(source.length);
      grid.change(lines.flatMap((line, i) => line.map((cell, j) => [cell, source[i % source.length][j]])));
    });
  });

  scroll.addEventListener("contextmenu", (event) => {
    const row = event.target.closest("tr[id]");
    if (!row || grid.editor.isOpen) return;
    event.preventDefault();
    if (!grid.rows.selected().includes(row)) {
      const cell = event.target.closest("[role=gridcell]");
      selection.go(row, Math.max(cell ? table.column(cell) : 0, 0));
    }
    document.dispatchEvent(new CustomEvent("rrp:menu", { detail: { x: event.clientX, y: event.clientY } }));
  });
}
