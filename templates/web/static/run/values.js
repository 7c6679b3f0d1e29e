// Live values in the grid: in the column of the examples each row shows its newest value, how old it is, and its error.
// Only the bodies of the table that are in sight are drawn; the others are known and cost nothing.

import { canBeStopped, hasAges } from "../api.js";
import { hasCalm } from "../preferences.js";
import { make, put } from "../elements.js";
import { t } from "../texts.js";
import { age, clock, now } from "./time.js";

const LIT = 1; // s that a row is lit after a value: nothing flashes at camera rate
const OLD = 5; // s
const RENEWED = 8; // s for which it is told that an edited formula is used now
const WIDE = 152; // px of the column
const QUIET = 2; // s without a value, after which a value is news: what the camera gives all the time moves nothing
const HANDS_OFF = 8000; // ms since somebody last used the table
const PACE = 2500; // ms between two moves of the table: one can read what is shown
const KEPT = "run-follow"; // the key of the switch in the browser's storage
const CALM_TICKS = 5; // of the ages, after which they are drawn again where nothing is to move by itself
const TITLES = { ended: t("Last value, run ended"), looking: t("Value and age then") };

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
    put(title, !live() ? t("Example") : TITLES[detail.phase] ?? t("Live value and age"));
    grid.classList.toggle("is-live", live());
    if (live() !== wide) document.dispatchEvent(new CustomEvent("rrp:column", { detail: { index: place, least: live() ? WIDE : 0 } }));
    wide = live();
    if (live()) drawAll();
    else restore();
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    if (detail.full) known = new Map();
    for (const [id, entry] of Object.entries(detail.rows ?? {})) if (!(known.get(id)?.n > entry.n)) known.set(id, entry);
    if (!hasCalm() || !hasAges(state.phase)) drawAll();
  });
  let ticks = 0;
  setInterval(() => {
    if (hasAges(state.phase) && !document.hidden && (++ticks % CALM_TICKS === 0 || !hasCalm())) drawAll();
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
    const exact = entry?.at == null ? null : now() - entry.at;
    const seconds = exact !== null && hasCalm() ? Math.floor(exact) : exact;
    put(parts.value, isOff ? (blank ? "" : t("off")) : entry?.e || entry?.v || (blank ? "" : t("none yet")));
    const renewed = entry?.from !== undefined && now() - entry.from < RENEWED;
    put(parts.age, renewed ? t("from {time}", { time: clock(entry.from) }) : isOff || seconds === null || blank ? "" : age(seconds));
    parts.box.className = `live${isOff || !entry ? " none" : ""}${entry?.e ? " is-error" : ""}${seconds > OLD ? " old" : ""}`;
    put(parts.error, entry?.e ? t("Row {row}: {error}", { row: row.cells[0].textContent, error: entry.e }) : "");
    parts.error.hidden = !entry?.e || isOff;
    cell.title = [entry?.e || entry?.v, entry?.from === undefined ? "" : t("used from {time} on", { time: clock(entry.from) })].filter(Boolean).join("\n");
    const share = isOff || seconds === null || blank ? 0 : 1 / (1 + Math.max(seconds, 0) / 1.5);
    const width = `${Math.round(share * 100)}%`;
    if (parts.bar.style.width !== width) parts.bar.style.width = width;
    row.classList.toggle("lit", !isOff && seconds !== null && seconds < LIT && state.phase !== "ended");
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

// During a run the table goes along with the rows that act: a row that was quiet and now gives something comes into sight,
// unless somebody is at the table himself. A switch in the run bar turns that off; the browser remembers it.

export function follow(grid, label) {
  const scroll = grid.closest(".grid-scroll");
  const box = label.querySelector("input");
  let last = new Map(); // row id → when it last gave something, on the run's clock
  let used = -HANDS_OFF;
  let moved = -PACE;
  let id;
  let running = false;
  box.checked = localStorage.getItem(KEPT) !== "off";

  box.addEventListener("change", () => {
    localStorage.setItem(KEPT, box.checked ? "on" : "off");
    used = -HANDS_OFF;
  });
  for (const event of ["pointerdown", "wheel", "touchmove", "keydown"]) {
    scroll.addEventListener(event, () => { used = performance.now(); }, { passive: true, capture: true });
  }
  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id !== id) last = new Map();
    id = detail.id;
    running = detail.phase === "running";
    label.hidden = !canBeStopped(detail.phase);
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    const acted = news(detail.rows ?? {}, detail.full);
    if (acted.length && wanted() && !acted.some(inSight)) show(acted[0]);
  });

  /** The rows that gave something after they were quiet, the newest first: only those that let the robot act, if any does. */
  function news(rows, known) {
    const found = [];
    for (const [row, { at }] of Object.entries(rows)) {
      if (at === null || at === undefined) continue;
      const before = last.get(row);
      last.set(row, at);
      if (known || (before !== undefined && at - before < QUIET)) continue;
      const element = document.getElementById(row);
      if (element && grid.contains(element)) found.push({ element, acts: Boolean(element.querySelector(".name.actuator")), at });
    }
    const acts = found.some((one) => one.acts);
    return found.filter((one) => one.acts === acts).sort((a, b) => b.at - a.at).map((one) => one.element);
  }

  function inSight(line) {
    const [frame, mine] = [scroll.getBoundingClientRect(), line.getBoundingClientRect()];
    return mine.top >= frame.top + grid.tHead.offsetHeight && mine.bottom <= frame.top + scroll.clientHeight;
  }

  function wanted() {
    const now = performance.now();
    return box.checked && running && !document.hidden && now - used > HANDS_OFF && now - moved > PACE
      && !scroll.querySelector(".editor") && !document.querySelector("dialog[open]");
  }

  function show(line) {
    moved = performance.now();
    const [frame, mine] = [scroll.getBoundingClientRect(), line.getBoundingClientRect()];
    const head = grid.tHead.offsetHeight;
    const top = scroll.scrollTop + mine.top - frame.top - head - (scroll.clientHeight - head) / 3;
    scroll.scrollTo({ top, behavior: hasCalm() ? "instant" : "smooth" }); // only the table: never the page, nor the cursor
  }
}
