// During a run the table goes along with the rows that act: a row that was quiet and now gives something comes into sight,
// unless somebody is at the table himself. A switch in the run bar turns that off; the browser remembers it.

const QUIET = 2; // s without a value, after which a value is news: what the camera gives all the time moves nothing
const HANDS_OFF = 8000; // ms since somebody last used the table
const PACE = 2500; // ms between two moves: one can read what is shown
const KEPT = "run-follow";

export function follow(grid, label) {
  const scroll = grid.closest(".grid-scroll");
  const box = label.querySelector("input");
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
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
    label.hidden = !["starting", "running", "paused"].includes(detail.phase);
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
      const line = document.getElementById(row);
      if (line && grid.contains(line)) found.push({ line, acts: Boolean(line.querySelector(".name.actuator")), at });
    }
    const acts = found.some((one) => one.acts);
    return found.filter((one) => one.acts === acts).sort((a, b) => b.at - a.at).map((one) => one.line);
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
    scroll.scrollTo({ top, behavior: calm.matches ? "instant" : "smooth" }); // only the table: never the page, nor the cursor
  }
}
