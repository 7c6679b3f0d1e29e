// The widths of the columns: dragged at the edge of a header, by Alt+Left and Alt+Right, or fitted by a double click; the
// browser remembers them for each sheet. And the width of the sheet beside its panels.

import { t } from "../texts.js";

const LEAST = 36; // px, of a column
const MOST = 900; // px, of a column
const STEP = 8; // px, of an arrow key at a column
const NARROW = { connector: 116, inputs: 108, output: 128, formula: 120 }; // px at least, the one to be narrowed first first
const BESIDE = "beside"; // the key of the panels' width in the browser's storage
const NUDGE = 16; // px, of an arrow key at the edge of the panels

export class Columns {
  constructor(grid) {
    this.grid = grid;
    this.table = grid.table;
    this.heads = [...this.table.grid.tHead.rows[0].cells];
    this.place = `widths:${grid.server.url}/${grid.server.sheet}`;
    this.kept = read(this.place);
    this.pen = document.createElement("canvas").getContext("2d");
    this.widths = this.heads.map((head, i) => (i ? this.kept[this.nameOf(i)] ?? this.usual(i) : this.margin()));
    this.show();
    if (this.table.kind === "own") this.heads.forEach((_, i) => i && !(this.nameOf(i) in this.kept) && this.set(i, this.fitting(i), false));
    const head = this.table.grid.tHead;
    head.addEventListener("pointerdown", (event) => this.drag(event));
    head.addEventListener("dblclick", (event) => {
      const i = this.at(event);
      if (i) this.fit(i);
    });
    head.addEventListener("keydown", (event) => this.key(event));
    addEventListener("resize", () => this.freeze());
    grid.scroll.addEventListener("scroll", () => grid.selection.isFrozen(grid.selection.cell) && (grid.selection.hold(), grid.editor.mend()), { passive: true });
    document.addEventListener("rrp:column", ({ detail: { index, least } }) => {
      this.set(index, Math.max(this.kept[this.nameOf(index)] ?? this.usual(index), least), false);
      this.beside = [index, least > 0];
      this.narrow(...this.beside);
    });
    addEventListener("resize", () => this.beside && this.narrow(...this.beside));
  }

  /** While a column beside them must be seen (`on`), those before it are narrower, as far as they can be and nobody has set them. */
  narrow(index, on) {
    const places = Object.keys(NARROW).map((kind) => this.heads.findIndex((head) => head.dataset.kind === kind));
    const free = places.filter((i) => i >= 0 && !(this.nameOf(i) in this.kept));
    const whole = this.widths.slice(0, index + 1).reduce((sum, width, i) => sum + (free.includes(i) ? this.usual(i) : width), 0);
    let over = on ? whole - this.grid.scroll.clientWidth : 0;
    for (const i of free) {
      const usual = this.usual(i);
      const wanted = over > 0 ? Math.max(Math.min(NARROW[this.heads[i].dataset.kind], usual), usual - over) : usual;
      over -= usual - wanted;
      if (wanted !== this.widths[i]) this.set(i, wanted, false);
    }
  }

  nameOf(i) {
    return (this.heads[i].dataset.name || this.heads[i].dataset.letter) ?? this.heads[i].querySelector(".title").textContent;
  }

  /** The width that a column has by its kind; never less than its header's words need. */
  usual(i) {
    return Math.max(Number(this.heads[i].dataset.pixels), Math.ceil(this.measure(this.heads[i], this.nameOf(i))) + 18);
  }

  /** Room for the numbers of the rows. */
  margin() {
    const last = this.table.first + Number(this.table.grid.dataset.count);
    return Math.max(40, Math.ceil(this.measure(this.heads[0], String(last))) + 16);
  }

  measure(element, text) {
    const { fontStyle, fontWeight, fontSize, fontFamily } = getComputedStyle(element); // .font is blank beside font-variant
    this.pen.font = `${fontStyle} ${fontWeight} ${fontSize} ${fontFamily}`;
    return this.pen.measureText(text).width;
  }

  /** The first column stays in sight beside the rows' numbers, and with the narrow column On the next one too: as far as both leave
   *  at least half of the width to the others. */
  freeze() {
    const { grid } = this.table;
    const live = grid.classList.contains("is-live") ? this.widths[this.heads.findIndex((head) => head.classList.contains("of-example"))] ?? 0 : 0;
    const room = (this.grid.scroll.clientWidth - live) / 2;
    const wide = (count) => this.widths.slice(0, count + 1).reduce((sum, width) => sum + width, 0);
    const most = this.heads[1]?.dataset.kind === "on" ? 2 : 1;
    const count = [2, 1].find((n) => n <= most && wide(n) <= room) ?? 0;
    grid.classList.toggle("frozen-1", count > 0);
    grid.classList.toggle("frozen-2", count > 1);
    grid.style.setProperty("--left-1", `${wide(0)}px`);
    grid.style.setProperty("--left-2", `${wide(1)}px`);
    this.grid.selection.frozen = { count, width: wide(count) };
  }

  show() {
    this.table.grid.style.setProperty("--columns", this.widths.map((w) => `${w}px`).join(" "));
    this.freeze();
    this.heads.forEach((head, i) => head.querySelector(".widen")?.setAttribute("aria-valuenow", this.widths[i]));
    this.grid.selection.paint();
    this.grid.editor.mend();
  }

  set(i, width, keep = true) {
    this.widths[i] = Math.round(Math.min(Math.max(width, LEAST), MOST));
    this.show();
    if (!keep) return;
    this.kept[this.nameOf(i)] = this.widths[i];
    localStorage.setItem(this.place, JSON.stringify(this.kept));
  }

  /** As wide as the longest of its lines. */
  fit(i) {
    this.set(i, this.fitting(i));
    this.grid.say(t("{column} is now as wide as its longest text.", { column: this.nameOf(i) }));
  }

  fitting(i) {
    let wide = this.measure(this.heads[i], this.nameOf(i)) + 18;
    const kind = this.heads[i].dataset.kind;
    const extra = { connector: 24, inputs: 14, output: 14 }[kind] ?? 0;
    for (const row of this.table.rows) {
      const cell = row.cells[i];
      const text = cell.dataset.v ?? (kind ? "" : cell.textContent);
      if (!text) continue;
      const element = cell.querySelector(".formula") ?? cell;
      for (const line of text.split("\n")) wide = Math.max(wide, this.measure(element, line) + 20 + extra);
      if (cell.classList.contains("flagged")) wide += 8;
    }
    return Math.ceil(Math.min(wide, 640));
  }

  /** Alt+Left and Alt+Right in a cell. */
  step(k, by) {
    const i = this.table.places[k];
    this.set(i, this.widths[i] + by * STEP);
    this.grid.spoken.say(t("{column} is {n} wide.", { column: this.nameOf(i), n: this.widths[i] }));
  }

  at(event) {
    const edge = event.target.closest(".widen");
    return edge ? this.heads.indexOf(edge.closest("th")) : 0;
  }

  drag(event) {
    const i = this.at(event);
    if (!i || event.button !== 0) return;
    event.preventDefault();
    const edge = event.target.closest(".widen");
    const from = event.clientX - this.widths[i];
    edge.setPointerCapture(event.pointerId);
    edge.focus({ preventScroll: true });
    const move = (now) => this.set(i, now.clientX - from, false);
    const up = () => {
      edge.removeEventListener("pointermove", move);
      this.set(i, this.widths[i]);
    };
    edge.addEventListener("pointermove", move);
    edge.addEventListener("lostpointercapture", up, { once: true });
  }

  key(event) {
    const i = this.at(event);
    if (!i) return;
    const action = {
      ArrowLeft: () => this.set(i, this.widths[i] - STEP), ArrowRight: () => this.set(i, this.widths[i] + STEP),
      Enter: () => this.fit(i), Escape: () => this.grid.selection.cell?.focus({ preventScroll: true }),
    }[event.key];
    if (!action) return;
    event.preventDefault();
    event.stopPropagation();
    action();
  }
}

function read(place) {
  try {
    return JSON.parse(localStorage.getItem(place)) ?? {};
  } catch {
    return {};
  }
}

export function splitter() {
  const sheet = document.querySelector(".workbench > .sheet");
  const panels = document.getElementById("panels");
  if (!sheet || !panels) return;
  const bar = document.createElement("div");
  bar.className = "splitter";
  bar.tabIndex = 0;
  for (const [name, value] of Object.entries({
    role: "separator", "aria-orientation": "vertical", "aria-label": t("Width of the sheet"), "aria-controls": "panels", "aria-valuemin": 0, "aria-valuemax": 100,
  })) bar.setAttribute(name, value);
  sheet.append(bar);
  const kept = Number(localStorage.getItem(BESIDE));
  if (kept) set(kept);
  else tell();

  bar.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    bar.setPointerCapture(event.pointerId);
    bar.focus();
    const right = panels.getBoundingClientRect().right;
    const move = (now) => set(right - now.clientX);
    bar.addEventListener("pointermove", move);
    bar.addEventListener("lostpointercapture", () => bar.removeEventListener("pointermove", move), { once: true });
  });
  bar.addEventListener("dblclick", () => {
    localStorage.removeItem(BESIDE);
    document.documentElement.style.removeProperty("--beside");
    tell();
  });
  bar.addEventListener("keydown", (event) => {
    const wide = panels.offsetWidth;
    const to = { ArrowLeft: wide + NUDGE, ArrowRight: wide - NUDGE, Home: innerWidth, End: 0 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    set(to);
  });

  function set(width) {
    const wide = Math.round(Math.min(Math.max(width, 200), Math.max(innerWidth - 360, 200)));
    document.documentElement.style.setProperty("--beside", `${wide}px`);
    localStorage.setItem(BESIDE, wide);
    tell();
  }

  function tell() {
    bar.setAttribute("aria-valuenow", Math.round((100 * sheet.offsetWidth) / Math.max(innerWidth, 1)));
  }
}
