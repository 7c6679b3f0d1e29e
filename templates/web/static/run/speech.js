// The robot's words, in a line of its own: a bubble while it speaks and a moment longer, then the last sentence with
// its age, quietly. (log.js plays the sound.)

import { takesActions } from "../api.js";
import { put } from "../elements.js";
import { t } from "../texts.js";

const FADES = 8; // s after it was said
export const NOTHING = t("The robot hasn’t spoken yet");

export const quoted = (text) => t("“{text}”", { text });
export const lastSaid = (text) => t("last said: {text}", { text });
export const secondsAgo = (n) => t("{n} s ago", { n });
const says = (text) => t("The robot says: {text}", { text });

/** Fill `#speech`. */
export function speech(root) {
  root.classList.add("speech");
  const bubble = document.createElement("p");
  bubble.className = "bubble past";
  bubble.setAttribute("aria-hidden", "true"); // read to the end, its age would be told again and again
  const words = document.createElement("span");
  words.textContent = NOTHING;
  const age = document.createElement("small");
  bubble.append(words, age);
  const spoken = document.createElement("p");
  spoken.className = "only-spoken";
  spoken.setAttribute("aria-live", "polite");
  root.replaceChildren(bubble, spoken);

  let id;
  let last = null; // { text, t, now }
  const show = (seconds) => {
    const since = last && !last.now ? Math.max(0, seconds - last.t) : 0;
    const past = !last || since > FADES;
    put(words, last ? (past ? lastSaid(last.text) : last.text) : NOTHING);
    put(age, last && !last.now ? ago(since) : "");
    words.title = last?.text ?? ""; // only its beginning may have room
    bubble.classList.toggle("now", Boolean(last?.now));
    bubble.classList.toggle("past", past);
    bubble.classList.toggle("none", !last);
  };
  const say = (text, seconds, now) => {
    if (last?.text === text && seconds - last.t < 1) Object.assign(last, { now: last.now || now });
    else {
      last = { text, t: seconds, now };
      spoken.textContent = says(text);
    }
  };

  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id !== id) {
      last = null;
      spoken.textContent = "";
    }
    if (last && !takesActions(detail.phase)) last.now = false;
    id = detail.id;
    show(detail.t ?? 0);
  });
  let now = 0;
  document.addEventListener("rrp:live", ({ detail }) => {
    now = detail.t ?? now;
    const saying = detail.robot?.saying;
    if (saying) {
      if (last?.now && last.text === saying) last.t = now;
      else say(saying, now, true);
    } else if (saying === "" && last?.now) Object.assign(last, { now: false, t: now });
    show(now);
  });
  document.addEventListener("rrp:log", ({ detail }) => {
    const lines = detail.lines.filter((line) => line.kind === "speech");
    const line = lines.at(-1);
    const known = last && (last.t > line?.t || (last.now && line?.text.includes(last.text)));
    if (line && !known) say(bare(line.text), line.t, false);
    show(Math.max(now, line?.t ?? 0));
  });
}

/** “Hello Kai”, as it stands in a line of the log, without its quotes and what follows them. */
function bare(text) {
  return /[“"](.+)[”"]/.exec(text)?.[1] ?? text;
}

function ago(seconds) {
  if (seconds < 1) return t("just now");
  return seconds < 90 ? secondsAgo(Math.floor(seconds)) : t("{n} min ago", { n: Math.floor(seconds / 60) });
}
