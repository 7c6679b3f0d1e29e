// During a run the diagram is alive: what had a value in the last second is lit, streams show their newest value.

const FRESH = 1; // s
const WORD = 0.56; // of the size of the letters: how wide one is, about

/** Follow the run; `svg()` gives the drawing of the moment, `table()` the grid that it belongs to. */
export function lights(svg, table = () => document.querySelector("table[role=grid]")) {
  const rows = new Map(); // row id → { at, e }
  const streams = new Map(); // name → { v, at }
  let t = 0;
  let id;
  let going = false;
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
    going = ["running", "paused", "stopping", "looking"].includes(detail.phase);
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
    show();
  });
  document.addEventListener("visibilitychange", show);
  return { redrawn };
}

// a stream of a sheet has the sheet's name before its own when there are several of its name; one without a name its row's
function find(streams, sheet, { name, stream }) {
  if (!name) return streams.get(`${sheet}!${(stream ?? "").replace(/^.*!/, "")}`);
  return streams.get(`${sheet}!${name}`) ?? streams.get(name);
}

function write(box, now, text) {
  const room = Number(now.dataset.wide) / (Number(now.getAttribute("font-size")) * WORD);
  const shown = text.length > room ? `${text.slice(0, Math.max(1, Math.floor(room) - 1))}…` : text;
  if (now.textContent !== shown) now.textContent = shown;
  toggle(box, "has-value", shown !== "");
}

function toggle(element, name, on) {
  if (element.classList.contains(name) !== on) element.classList.toggle(name, on);
}
