// Live values in the grid: in the column of the examples each row shows its newest value, how old it is, and its error.
// Only the bodies of the table that are in sight are drawn; the others are known and cost nothing.

import { make, put } from "../elements.js";
import { age, clock, now } from "./time.js";

const LIT = 1; // s that a row is lit after a value: nothing flashes at camera rate
const OLD = 5; // s
const RENEWED = 8; // s for which it is told that an edited formula is used now
const WIDE = 152; // px of the column
const TITLES = { ended: "Last value, run ended", looking: "Value then, and its age" };

export function values(grid) {
  const head = [...grid.tHead.rows[0].cells].find((h) => h.classList.contains("of-example") || h.classList.contains("example"));
  if (!head) return;
  const place = head.cellIndex;
  const sheet = grid.dataset.sheet;
  let known = new Map(); // row id → { v, at, n, e }
  const inSight = new Set(); // bodies of the table
  let state = { phase: "none" };
  let wide = false;
  let off = false; // the behaviour is switched off

  const sight = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting) inSight.add(target);
      else inSight.delete(target);
      if (isIntersecting && live()) drawAll([target]);
    }
  }, { root: grid.closest(".grid-scroll"), rootMargin: "64px 0px" });
  const watch = () => {
    for (const body of grid.tBodies) sight.observe(body);
  };
  grid.addEventListener("rrp:rows", () => {
    watch();
    if (live()) drawAll();
  });
  watch();

  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id !== state.id) known = new Map();
    state = detail;
    off = detail.behaviours?.some((b) => b.name === sheet && !b.on) ?? false;
    const title = head.querySelector(".title") ?? head;
    put(title, !live() ? "Example" : TITLES[detail.phase] ?? "Live value and age");
    grid.classList.toggle("is-live", live());
    if (live() !== wide) document.dispatchEvent(new CustomEvent("rrp:column", { detail: { index: place, least: live() ? WIDE : 0 } }));
    wide = live();
    if (live()) drawAll();
    else restore();
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    if (detail.full) known = new Map();
    for (const [id, entry] of Object.entries(detail.rows ?? {})) if (!(known.get(id)?.n > entry.n)) known.set(id, entry);
    drawAll();
  });
  setInterval(() => {
    if (["running", "stopping", "finishing"].includes(state.phase) && !document.hidden) drawAll();
  }, 200);

  function live() {
    return state.phase !== "none";
  }

  function drawAll(bodies = inSight) {
    for (const body of bodies) {
      if (!body.isConnected) inSight.delete(body);
      for (const row of body.rows) draw(row);
    }
  }

  function draw(row) {
    const cell = row.cells[place];
    if (!cell) return;
    const parts = cell.live ?? build(row, cell);
    const entry = known.get(row.id);
    const isOff = off || row.classList.contains("off");
    const blank = !row.querySelector(".connector .word");
    const years = entry?.at == null ? null : now() - entry.at;
    put(parts.value, isOff ? (blank ? "" : "off") : entry?.e || entry?.v || (blank ? "" : "none yet"));
    const renewed = entry?.from !== undefined && now() - entry.from < RENEWED;
    put(parts.age, renewed ? `from ${clock(entry.from)}` : isOff || years === null || blank ? "" : age(years));
    parts.box.className = `live${isOff || !entry ? " none" : ""}${entry?.e ? " is-error" : ""}${years > OLD ? " old" : ""}`;
    put(parts.error, entry?.e ? `Row ${row.cells[0].textContent}: ${entry.e}` : "");
    parts.error.hidden = !entry?.e || isOff;
    cell.title = [entry?.e || entry?.v, entry?.from === undefined ? "" : `used from ${clock(entry.from)} on`].filter(Boolean).join("\n");
    const share = isOff || years === null || blank ? 0 : 1 / (1 + Math.max(years, 0) / 1.5);
    const width = `${Math.round(share * 100)}%`;
    if (parts.bar.style.width !== width) parts.bar.style.width = width;
    row.classList.toggle("lit", !isOff && years !== null && years < LIT && state.phase !== "ended");
  }

  function build(row, cell) {
    const value = make("span", { className: "value" });
    const old = make("span", { className: "age" });
    const box = make("div", { className: "live" }, value, old);
    const error = make("div", { className: "live-error is-error", hidden: true });
    const bar = make("div", { className: "age-bar" });
    cell.example = { text: cell.textContent, title: cell.title };
    cell.live = { value, age: old, box, error, bar };
    cell.replaceChildren(box, bar, error);
    row.classList.toggle("acts", Boolean(row.querySelector(".name.actuator")));
    return cell.live;
  }

  function restore() {
    for (const row of grid.querySelectorAll("tbody > tr")) {
      const cell = row.cells[place];
      row.classList.remove("lit");
      if (!cell?.live) continue;
      cell.textContent = cell.example.text;
      cell.title = cell.example.title;
      delete cell.live;
    }
  }
}
