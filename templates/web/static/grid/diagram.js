// The diagram beside the grid: zoom, keys, the way from a box to its row and back. The server draws it anew after each
// edit and morphs it in; what is kept here (zoom, place, where the keys are) is put back on the new one.

import { hasLights } from "../api.js";
import { hasCalm } from "../preferences.js";

const LEAST_TEXT = 8; // px: at first the smallest words are not made smaller to fit the width, it scrolls instead
const SMALLEST = 8; // of the words in the picture, in its own units
const UNIT = 96 / 72; // px of one of the picture's units at zoom 1
const LEAST = 0.2;
const LARGEST = 3;
const STEP = 1.2;
const TOO_LARGE = 1.15; // a small diagram is not blown up beyond this to fill the panel
const DRAG = 4; // px, from which on a press is a drag
const CALM_MS = 1000; // between two drawings of the values where nothing is to move by itself
const FRESH = 1; // s, for which a box is lit after a value
const LETTER_WIDTH = 0.56; // about, of the size of the letters

/** Bring the diagram in `panels` to life. */
export function diagram(panels) {
  if (!panels || "diagram" in panels.dataset) return;
  panels.dataset.diagram = "";
  const view = new View(panels);
  const live = lights(() => view.svg);
  document.addEventListener("htmx:after:swap", () => {
    view.redrawn();
    live.redrawn();
  });
  document.addEventListener("rrp:row", ({ detail }) => view.light(detail.number));
  part(panels);
  view.redrawn();
  live.redrawn();
}

const RESTS_MS = 300; // the cursor on a row, before the rows around it are drawn

/** The rows of a long sheet that are drawn: all, those below a heading, or those around the row with the cursor. */
function part(panels) {
  const address = panels.getAttribute("hx-get");
  let here = 0;
  let timer = 0;
  const wanted = () => document.getElementById("diagram-part")?.value ?? "";
  const show = () => {
    const name = wanted() === "around" ? `around-${here}` : wanted();
    const from = name ? `${address}?part=${name}` : address;
    if (panels.getAttribute("hx-get") === from) return;
    panels.setAttribute("hx-get", from);
    htmx.trigger("#panels", "recheck");
  };
  panels.addEventListener("click", ({ target }) => {
    const { part: chosen } = target.closest("[data-part]")?.dataset ?? {};
    if (!chosen) return;
    const select = document.getElementById("diagram-part");
    select.value = chosen;
    select.focus({ preventScroll: true });
    show();
  });
  panels.addEventListener("change", ({ target }) => target.id === "diagram-part" && show());
  document.addEventListener("rrp:row", ({ detail }) => {
    here = detail.number;
    clearTimeout(timer);
    timer = setTimeout(show, RESTS_MS);
  });
}

class View {
  constructor(panels) {
    this.panels = panels;
    this.zoom = 0; // chosen by hand, or 0
    this.whole = false; // fitted to the width by hand, however small its words become
    this.here = "";
    panels.addEventListener("click", (event) => this.click(event));
    panels.addEventListener("keydown", (event) => this.key(event));
    panels.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    panels.addEventListener("pointerdown", (event) => this.down(event));
    panels.addEventListener("focusin", (event) => this.focused(event));
    for (const type of ["pointerdown", "wheel", "keydown"]) panels.addEventListener(type, () => { this.touched = true; }, { passive: true });
    new ResizeObserver(() => {
      if (!this.svg) return;
      this.scale();
      this.begin();
    }).observe(panels);
  }

  get root() {
    return document.getElementById("diagram");
  }

  get svg() {
    return this.root?.querySelector("svg") ?? null;
  }

  get boxes() {
    return [...this.svg.querySelectorAll("[role=button]")];
  }

  /** There is a new drawing: what belongs to the page and not to the drawing is put on it. */
  redrawn() {
    if (!this.svg) return;
    this.scale();
    const stop = document.getElementById(this.stop) ?? this.boxes[0];
    stop?.setAttribute("tabindex", "0");
    this.light(this.here);
    this.begin();
  }

  /** A large drawing is not first seen where it is empty; once somebody has touched it, it stays as it is. */
  begin() {
    if (!this.touched && this.boxes.length) this.reveal(this.svg.querySelector("[role=button].here") ?? this.boxes[0]);
  }

  /** Set the size: the one chosen by hand, or one that fills the width without becoming unreadable. */
  scale() {
    if (!this.svg) return;
    const wide = this.svg.viewBox.baseVal.width * UNIT;
    const room = this.root.clientWidth;
    const least = this.whole ? LEAST : LEAST_TEXT / (SMALLEST * UNIT);
    const fitted = Math.min(Math.max((room - 2) / wide, least), TOO_LARGE);
    this.shown = this.zoom || fitted;
    // on an element that no morph touches
    this.panels.style.setProperty("--zoom", this.shown);
    const label = this.panels.querySelector("[data-zoom=fit]");
    label?.setAttribute("aria-pressed", String(this.whole && !this.zoom));
  }

  /** Zoom by a factor about a point of the window, or the middle. */
  by(factor, at) {
    const box = this.root.getBoundingClientRect();
    const [x, y] = at ? [at.clientX - box.left, at.clientY - box.top] : [box.width / 2, box.height / 2];
    const [left, top] = [(this.root.scrollLeft + x) / this.shown, (this.root.scrollTop + y) / this.shown];
    this.zoom = Math.min(Math.max(this.shown * factor, LEAST), LARGEST);
    this.scale();
    this.root.scrollTo(left * this.shown - x, top * this.shown - y);
  }

  fit() {
    this.zoom = 0;
    this.whole = true;
    this.scale();
    this.root.scrollTo(0, 0);
  }

  click(event) {
    const act = event.target.closest("[data-zoom]")?.dataset.zoom;
    if (act === "in") this.by(STEP);
    if (act === "out") this.by(1 / STEP);
    if (act === "fit") this.fit();
    const box = event.target.closest("#diagram [role=button]");
    if (box && !this.dragged) this.goto(box);
  }

  /** To the box's row; of a stream, to the row that makes it, or else that uses it first. */
  goto(box) {
    const row = box.dataset.row ? box : this.across(box, "to", "from") ?? this.across(box, "from", "to");
    if (!row?.dataset.row) return;
    const detail = { number: Number(row.dataset.row) };
    document.dispatchEvent(new CustomEvent("rrp:goto", { detail }));
  }

  across(box, mine, other) {
    const arrow = this.svg.querySelector(`.arrow:not(.world)[data-${mine}="${box.id}"]`);
    return arrow && document.getElementById(arrow.dataset[other]);
  }

  key(event) {
    const box = event.target.closest("#diagram [role=button]");
    if (!box || event.ctrlKey || event.metaKey || event.altKey) return;
    const ways = { ArrowUp: [0, -1], ArrowDown: [0, 1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };
    const acts = {
      Enter: () => this.goto(box), " ": () => this.goto(box), "+": () => this.by(STEP), "=": () => this.by(STEP),
      "-": () => this.by(1 / STEP), 0: () => this.fit(), Home: () => this.to(this.boxes[0]), End: () => this.to(this.boxes.at(-1)),
    };
    const act = ways[event.key] ? () => this.to(this.next(box, ways[event.key])) : acts[event.key];
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  }

  /** The nearest box that way; what lies aside counts double. */
  next(box, [dx, dy]) {
    const middle = (element) => {
      const { left, right, top, bottom } = element.getBoundingClientRect();
      return [(left + right) / 2, (top + bottom) / 2];
    };
    const [x, y] = middle(box);
    let best = [Infinity, null];
    for (const other of this.boxes) {
      const [ox, oy] = middle(other);
      const ahead = (ox - x) * dx + (oy - y) * dy;
      const aside = Math.abs((ox - x) * dy) + Math.abs((oy - y) * dx);
      if (ahead > 1 && ahead + 2 * aside < best[0]) best = [ahead + 2 * aside, other];
    }
    return best[1];
  }

  to(box) {
    if (!box) return;
    box.focus({ preventScroll: true });
    box.scrollIntoView({ block: "nearest", inline: "nearest" });
  }

  // one box is reached by Tab, the others from it by the arrows
  focused(event) {
    const box = event.target.closest("#diagram [role=button]");
    if (!box) return;
    for (const other of this.svg.querySelectorAll("[role=button][tabindex='0']")) other.setAttribute("tabindex", "-1");
    box.setAttribute("tabindex", "0");
    this.stop = box.id;
  }

  wheel(event) {
    if (!event.ctrlKey || !event.target.closest("#diagram")) return;
    event.preventDefault();
    this.by(Math.exp(-event.deltaY * (event.deltaMode ? 0.04 : 0.002)), event);
  }

  // drag with the mouse; fingers scroll as everywhere
  down(event) {
    this.dragged = false;
    const root = this.root;
    if (event.pointerType !== "mouse" || event.button !== 0 || !event.target.closest?.("#diagram svg")) return;
    const start = { x: event.clientX, y: event.clientY, left: root.scrollLeft, top: root.scrollTop };
    const move = ({ clientX, clientY }) => {
      const [x, y] = [clientX - start.x, clientY - start.y];
      if (Math.hypot(x, y) > DRAG) this.dragged = true;
      if (!this.dragged) return;
      root.classList.add("dragging");
      root.scrollTo(start.left - x, start.top - y);
    };
    const up = () => {
      root.classList.remove("dragging");
      window.removeEventListener("pointermove", move);
      window.removeEventListener("pointerup", up);
    };
    window.addEventListener("pointermove", move);
    window.addEventListener("pointerup", up);
  }

  /** The row with the cursor: its box, and the wires into and out of it. */
  light(number) {
    const changed = this.here !== number;
    this.here = number;
    if (!this.svg) return;
    for (const old of this.svg.querySelectorAll(".here")) old.classList.remove("here");
    const box = this.svg.querySelector(`[data-row="${Number(number) || 0}"]`);
    if (!box) return;
    box.classList.add("here");
    for (const wire of this.svg.querySelectorAll(`[data-from="${box.id}"], [data-to="${box.id}"]`)) wire.classList.add("here");
    if (changed) this.reveal(box);
  }

  // within the diagram only: the page itself must not jump
  reveal(box) {
    const [mine, frame] = [box.getBoundingClientRect(), this.root.getBoundingClientRect()];
    const over = (low, high, least, most) => (low < least ? low - least - 16 : high > most ? high - most + 16 : 0);
    const [x, y] = [over(mine.left, mine.right, frame.left, frame.right), over(mine.top, mine.bottom, frame.top, frame.bottom)];
    if (x || y) this.root.scrollBy(x, y);
  }
}

// During a run the diagram is alive: what had a value in the last second is lit, streams show their newest value.

/** Follow the run; `svg()` gives the drawing of the moment, `table()` the grid that it belongs to. */
export function lights(svg, table = () => document.querySelector("table[role=grid]")) {
  const rows = new Map(); // row id → { at, e }
  const streams = new Map(); // name → { v, at }
  let t = 0;
  let id;
  let going = false;
  let drawn = 0; // when
  let boxes = [];
  let wires = [];

  const redrawn = () => {
    const drawing = svg();
    boxes = drawing ? [...drawing.querySelectorAll("[data-row], [data-name]")] : [];
    wires = drawing ? [...drawing.querySelectorAll(".arrow")] : [];
    show();
  };

  const show = () => {
    if (!boxes.length || document.hidden) return;
    const numbers = new Map();
    for (const [row, entry] of rows) {
      const line = document.getElementById(row);
      const number = line?.cells[0]?.textContent;
      if (number && table()?.contains(line)) numbers.set(number, entry);
    }
    const sheet = table()?.dataset.sheet;
    const lit = new Set();
    for (const box of boxes) {
      const entry = box.dataset.row ? numbers.get(box.dataset.row) : find(streams, sheet, box.dataset);
      const fresh = going && entry !== undefined && entry.at !== null && t - entry.at < FRESH;
      if (fresh) lit.add(box.id);
      toggle(box, "lit", fresh);
      toggle(box, "failed", Boolean(box.dataset.row && entry?.e));
      const now = box.querySelector(".now");
      if (now) write(box, now, entry?.v ?? "");
    }
    for (const wire of wires) toggle(wire, "lit", lit.has(wire.dataset.from) && lit.has(wire.dataset.to));
  };

  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id !== id) {
      rows.clear();
      streams.clear();
      t = 0;
    }
    id = detail.id;
    going = hasLights(detail.phase);
    show();
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    if (detail.full) {
      rows.clear();
      streams.clear();
    }
    t = detail.t ?? t;
    for (const [row, entry] of Object.entries(detail.rows ?? {})) rows.set(row, entry);
    for (const [name, entry] of Object.entries(detail.streams ?? {})) streams.set(name, entry);
    if (hasCalm() && performance.now() - drawn < CALM_MS) return;
    drawn = performance.now();
    show();
  });
  document.addEventListener("visibilitychange", show);
  return { redrawn };
}

// the keys of `streams`: the stream's name, `sheet!name` where several sheets have a stream of that name, `sheet!row` without a name
function find(streams, sheet, { name, stream }) {
  if (!name) return streams.get(`${sheet}!${(stream ?? "").replace(/^.*!/, "")}`);
  return streams.get(`${sheet}!${name}`) ?? streams.get(name);
}

function write(box, now, text) {
  const room = Number(now.dataset.wide) / (Number(now.getAttribute("font-size")) * LETTER_WIDTH);
  const shown = text.length > room ? `${text.slice(0, Math.max(1, Math.floor(room) - 1))}…` : text;
  if (now.textContent !== shown) now.textContent = shown;
  toggle(box, "has-value", shown !== "");
}

function toggle(element, name, on) {
  if (element.classList.contains(name) !== on) element.classList.toggle(name, on);
}
