// The rows that drive the robot: a lane for each part of the robot, with bars that bear the numbers of the rows that drove it.

import { element } from "../elements.js";
import { listed, t } from "../texts.js";

const SPAN = 30; // s
const LANE = 20;
const BAR = 14;
const SIDE = 64; // px for the lanes' names
const MOST = 500; // bars kept
const DIGIT = 7; // px
const EMPTY = t("Parts of the robot and the rows that control them appear here during a run.");

/** Fill `#drives`. */
export function drives(root) {
  root.classList.add("drives");
  const svg = element("svg", { role: "img", hidden: "" });
  const nothing = document.createElement("p");
  nothing.className = "quiet";
  nothing.textContent = EMPTY;
  root.replaceChildren(nothing, svg);
  const view = { svg, nothing, lanes: [], bars: new Map(), t: 0 };
  let id;
  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id !== id) Object.assign(view, { lanes: [], bars: new Map(), t: 0 });
    id = detail.id;
    const known = Object.values(detail.resources ?? {}).flat();
    for (const name of [...new Set(known)].sort()) if (!view.lanes.includes(name)) view.lanes.push(name);
    draw(view);
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    if (detail.full) view.bars.clear();
    view.t = detail.t ?? view.t;
    for (const [lane, row, began, ended] of detail.drives ?? []) {
      if (!view.lanes.includes(lane)) view.lanes.push(lane);
      view.bars.set(`${lane} ${row} ${began}`, { lane, row, began, ended });
    }
    for (const [key, bar] of view.bars) {
      const over = bar.ended !== null && bar.ended < view.t - SPAN;
      if (over || view.bars.size > MOST) view.bars.delete(key);
    }
    if (!document.hidden && root.isConnected) draw(view);
  });
  new ResizeObserver(() => draw(view)).observe(root);
}

function draw(view) {
  const { svg, nothing, lanes, bars, t: seconds } = view;
  nothing.hidden = lanes.length > 0;
  svg.toggleAttribute("hidden", !lanes.length);
  const wide = svg.parentElement.clientWidth;
  if (!lanes.length || !wide) return;
  const high = lanes.length * LANE + 4;
  svg.setAttribute("viewBox", `0 0 ${wide} ${high}`);
  svg.setAttribute("width", wide);
  svg.setAttribute("height", high);
  const room = wide - SIDE;
  const begin = seconds - SPAN;
  const x = (at) => Math.min(Math.max((at - begin) / SPAN, 0), 1) * room;
  const parts = lanes.flatMap((lane, n) => {
    const name = element("text", { x: room + 6, y: n * LANE + 13 });
    name.textContent = lane;
    return [element("path", { class: "rule", d: `M0 ${n * LANE + LANE - 1.5}H${room}` }), name];
  });
  for (const { lane, row, began, ended } of bars.values()) {
    const y = lanes.indexOf(lane) * LANE + 2;
    const [left, right] = [x(began), x(ended ?? seconds)];
    if (right <= 0) continue;
    const bar = element("rect", { class: ended === null ? "busy now" : "busy", x: left + 0.5, y: y + 0.5, width: Math.max(right - left - 1, 2), height: BAR - 1 });
    const title = element("title");
    title.textContent = drove(lane, row, began.toFixed(1), ended?.toFixed(1));
    bar.append(title);
    parts.push(bar);
    const number = row.replace(/^.*!/, "");
    if (right - left < number.length * DIGIT + 5) continue;
    const words = element("text", { class: "row", x: left + 4, y: y + BAR - 3 });
    words.textContent = number;
    parts.push(words);
  }
  svg.replaceChildren(...parts);
  const tell = () => {
    view.telling = null;
    svg.setAttribute("aria-label", words(view.lanes, view.bars));
  };
  if (!svg.hasAttribute("aria-label")) tell();
  view.telling ??= setTimeout(tell, 500); // not with each drawing, nobody could listen to it
}

function drove(part, row, from, to) {
  return to === undefined ? t("{part}: row {row}, {from} s to now", { part, row, from }) : t("{part}: row {row}, {from} s to {to} s", { part, row, from, to });
}

function words(lanes, bars) {
  const now = new Map([...bars.values()].filter((b) => b.ended === null).map((b) => [b.lane, b.row]));
  const parts = lanes.map((part) => (now.has(part) ? t("{part}: row {row}", { part, row: now.get(part) }) : t("{part}: free", { part })));
  return t("Parts of the robot and the rows that control them now: {parts}", { parts: listed(parts) });
}
