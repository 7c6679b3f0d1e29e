// The log: newest first, with the row that did it, and what the robot said to be heard (again).

import { shownName } from "../api.js";
import { icon, make } from "../elements.js";
import { t } from "../texts.js";
import { clock, EXACT } from "./time.js";

const KEPT = 300;
const icons = { speech: "say", person: "say", sound: "sound", error: "error", refused: "error", clamp: "warning", note: "flag", mark: "flag", button: "button", send: "send", scene: "ball", switch: "subscribe", edit: "sheet", start: "run", end: "stop" };
const said = { mark: t("Mark"), button: t("Pressed"), send: t("Sent"), scene: t("Scene"), switch: t("Switched"), edit: t("Edited") };

const byWhom = (name) => " " + t("by {name}", { name });
const hear = (text) => t("Hear “{text}”", { text });

export function log(root) {
  const address = document.querySelector("[role=grid]")?.dataset;
  const panel = document.getElementById("runbar").dataset.url;
  const sound = document.getElementById("sound");
  const voices = { robot: new Audio(), person: new Audio() }; // both can be heard at the same time
  let joined = true; // what was said before this page came is not said again
  let id = "";

  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id === id) return;
    id = detail.id;
    joined = detail.phase !== "starting";
    root.replaceChildren();
  });
  document.addEventListener("rrp:log", ({ detail }) => {
    for (const { instead } of detail.lines) if (instead) root.querySelector(`[data-line="${instead}"]`)?.remove();
    root.prepend(...detail.lines.toReversed().map(entry));
    while (root.children.length > KEPT) root.lastElementChild.remove();
    for (const isPerson of [false, true]) {
      const spoken = detail.lines.findLast((line) => line.sound && (line.kind === "person") === isPerson);
      if (spoken && !joined && document.body.dataset.sound === "on") play(spoken.sound);
    }
    joined = false;
  });

  function entry({ i, t: seconds, row, id: rowId, kind, text, by, stream, sound: file }) {
    const what = make("span", { className: "what" });
    if (icons[kind]) what.append(icon(icons[kind]), " ");
    if (row) what.append(link(row, rowId), " ");
    if (stream) what.append(make("span", { className: "name actuator", textContent: stream }), " ");
    what.append(words(kind, text));
    if (by) what.append(make("span", { className: "quiet", textContent: byWhom(shownName(by)) }));
    if (file) {
      const again = make("button", { type: "button", className: "button plain small", ariaLabel: hear(text) }, icon("sound"));
      again.addEventListener("click", () => play(file));
      what.append(" ", again);
    }
    const line = make("li", { className: kind === "error" || kind === "refused" ? "is-error" : kind === "clamp" ? "is-warning" : "" }, make("time", { textContent: clock(seconds, EXACT) }), what);
    Object.assign(line.dataset, { kind, line: i });
    return line;
  }

  function words(kind, text) {
    if (kind === "sound") return t("plays “{sound}”", { sound: text });
    if (kind === "speech") return t("“{text}”", { text });
    if (kind === "mark") return text ? t("Mark: {note}", { note: text }) : t("Mark");
    return text || said[kind] || "";
  }

  /** The row is shown where it stands now, also when rows were inserted above it meanwhile. */
  function link(row, rowId) {
    const cut = row.lastIndexOf("!");
    const sheet = row.slice(0, cut);
    const here = sheet === address?.sheet;
    const made = make("a", { href: `${here ? "" : `${panel}/${encodeURIComponent(sheet)}`}#${rowId}`, textContent: here ? t("Row {row}", { row: row.slice(cut + 1) }) : `${sheet} ${row.slice(cut + 1)}` });
    made.dataset.row = here ? rowId : "";
    made.dataset.cell = "";
    return made;
  }

  function play(file) {
    const voice = voices[file.startsWith("person") ? "person" : "robot"];
    voice.src = `/run/sound/${file}?run=${id}`;
    voice.play().catch(() => {}); // the browser lets no page speak before it was touched
  }

  function show(on) {
    document.body.dataset.sound = on ? "on" : "off";
    sound.ariaPressed = String(on);
    sound.querySelector("span").textContent = on ? t("Sound on") : t("Sound off");
    localStorage.setItem("sound", on ? "on" : "off");
    if (!on) for (const voice of Object.values(voices)) voice.pause();
  }
  sound.addEventListener("click", () => show(document.body.dataset.sound !== "on"));
  show(localStorage.getItem("sound") !== "off");
}
