// The run so far as a line of time below the tabs: what was said, pressed, marked, touched, and what failed. A click opens Look back
// at that time, in a tab of its own: the page of the run stays.

import { make, put } from "../elements.js";
import { t } from "../texts.js";
import { clock, now } from "./time.js";

const GROUPS = { // kinds of log lines by what they are in Look back, which gives their colours
  error: "error", refused: "error", mark: "mark", edit: "edit", speech: "say", command: "say", sound: "say", person: "person", clamp: "warning",
  button: "hand", send: "hand", scene: "hand", switch: "hand",
};
const SPANS = [30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 28800, 86400]; // s that the line is long
const PARTS = 6; // between two of its figures
const PLACES = 250; // for marks: those of a kind that lie together are one
const KEPT = 1000; // lines of the log
const EVERY = 250; // ms

const minutes = (seconds) => clock(seconds).slice(0, -2); // without tenths

export function timeline(root) {
  const here = make("b");
  const pointed = make("em");
  let lines = []; // { t, group }
  let state = { phase: "none" };
  let whole = SPANS[0];
  const drawn = make("span", { ariaHidden: "true" });
  root.replaceChildren(make("span", { className: "only-spoken", textContent: t("Timeline: look back at this run") }), drawn);

  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id !== state.id) lines = [];
    state = detail;
    root.hidden = detail.phase === "none";
    if (detail.folder) root.href = `${document.getElementById("runbar").dataset.runs}/${encodeURIComponent(detail.folder)}/lookback`;
    else root.removeAttribute("href");
    draw();
  });
  document.addEventListener("rrp:log", ({ detail }) => {
    const fresh = detail.lines.filter(({ kind }) => kind in GROUPS).map(({ t: at, kind }) => ({ at, group: GROUPS[kind] }));
    if (!fresh.length) return;
    lines = [...lines, ...fresh].slice(-KEPT);
    draw();
  });
  setInterval(() => {
    if (!root.hidden && !document.hidden) move();
  }, EVERY);

  root.addEventListener("pointermove", (event) => {
    const at = timeAt(event);
    put(pointed, root.href ? t("Look back at {time}", { time: clock(at) }) : "");
    pointed.style.left = `${Math.min(Math.max((at / whole) * 100, 12), 88)}%`;
  });
  root.addEventListener("pointerleave", () => put(pointed, ""));
  root.addEventListener("click", (event) => { // by the keyboard: now
    root.hash = `t=${(event.detail ? timeAt(event) : now()).toFixed(1)}`;
  });

  function timeAt({ clientX }) {
    const { left, width } = root.getBoundingClientRect();
    return Math.min(Math.max(((clientX - left) / width) * whole, 0), now());
  }

  function draw() {
    whole = SPANS.find((span) => span >= now()) ?? SPANS.at(-1);
    const taken = new Set();
    const marks = lines.filter(({ at, group }) => {
      const place = `${group} ${Math.floor((at / whole) * PLACES)}`;
      return !taken.has(place) && taken.add(place);
    });
    const figures = Array.from({ length: PARTS }, (_, n) => placed(make("small", { textContent: minutes((n * whole) / PARTS) }), (n * whole) / PARTS));
    drawn.replaceChildren(...figures, ...marks.map(({ at, group }) => placed(make("i", { className: `of-${group}` }), at)), here, pointed);
    move();
  }

  function move() {
    if (now() > whole && whole !== SPANS.at(-1)) return draw();
    placed(here, Math.min(now(), whole));
    return undefined;
  }

  function placed(element, at) {
    element.style.left = `${(at / whole) * 100}%`;
    return element;
  }
}
