// The messages below a cell and their buttons: Ctrl+. applies the remedy, or leads to the buttons where there are several.

export class Mending {
  constructor(grid) {
    this.grid = grid;
    grid.scroll.addEventListener("keydown", (event) => this.key(event), true);
    grid.scroll.addEventListener("focusin", () => grid.scroll.classList.remove("left"));
    grid.scroll.addEventListener("focusout", (event) => {
      grid.scroll.classList.toggle("left", Boolean(event.relatedTarget) && !grid.scroll.contains(event.relatedTarget));
    });
  }

  buttons() {
    return [...(this.grid.selection.cell?.querySelectorAll(".mend [data-fix]") ?? [])];
  }

  /** Ctrl+. in a cell. */
  go() {
    const buttons = this.buttons();
    if (!buttons.length) this.grid.say("There is no remedy to apply in this cell.");
    else if (buttons.length === 1) this.grid.fix(buttons[0]);
    else buttons[0].focus();
  }

  key(event) {
    const button = event.target.closest?.(".mend [data-fix]");
    if (!button) return;
    const buttons = this.buttons();
    const at = buttons.indexOf(button);
    const to = { ArrowDown: at + 1, ArrowRight: at + 1, ArrowUp: at - 1, ArrowLeft: at - 1 }[event.key];
    if (event.key === "Escape") this.grid.selection.cell.focus({ preventScroll: true });
    else if (event.key === "Tab") buttons[(at + (event.shiftKey ? buttons.length - 1 : 1)) % buttons.length].focus();
    else if (to !== undefined) buttons[(to + buttons.length) % buttons.length].focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Keep the messages of the cell with the cursor within what is seen of the sheet. */
  place() {
    const box = this.grid.selection.cell?.querySelector(":scope > .mends");
    if (!box) return;
    box.classList.remove("above");
    box.style.marginLeft = "";
    const frame = this.grid.scroll.getBoundingClientRect();
    const mine = box.getBoundingClientRect();
    if (!mine.height) return;
    const cell = box.parentElement.getBoundingClientRect();
    const top = frame.top + this.grid.table.grid.tHead.offsetHeight;
    if (mine.bottom > frame.top + this.grid.scroll.clientHeight && cell.top - mine.height > top) box.classList.add("above");
    const over = mine.right - (frame.left + this.grid.scroll.clientWidth);
    if (over > 0) box.style.marginLeft = `${-Math.min(over, Math.max(mine.left - frame.left, 0))}px`;
  }
}
