// The session column: the operator's buttons, a switch for each behaviour, marks, and values sent by hand.

import { act } from "./ask.js";
import { numberKeys } from "./keys.js";
import { icon, make, put } from "../elements.js";
import { now } from "./time.js";

const WAITS = "comes when it goes on";

export function session(root) {
  const press = document.getElementById("press");
  const switches = document.getElementById("switches");
  const mark = document.getElementById("mark");
  const send = document.getElementById("send");
  let state = { phase: "none" };
  let shape = "";
  let lost = false;

  document.addEventListener("rrp:run", ({ detail }) => {
    const fresh = JSON.stringify([detail.id, detail.phase === "starting", detail.buttons, detail.sensors, detail.behaviours?.map((b) => b.name)]);
    state = detail;
    if (fresh !== shape) build(detail);
    shape = fresh;
    for (const { name, on } of detail.behaviours ?? []) {
      const box = [...switches.querySelectorAll("input")].find((i) => i.value === name);
      if (box) box.checked = on;
    }
    if (detail.phase !== "paused") for (const button of press.children) count(button, Number(button.dataset.n));
    enable();
  });
  document.addEventListener("rrp:line", ({ detail }) => {
    lost = detail.lost;
    enable();
  });
  document.addEventListener("rrp:log", ({ detail }) => {
    for (const line of detail.lines) if (line.kind === "button" && now() - line.t < 0.05) wait(line.text); // on another page
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    for (const button of press.children) {
      const n = detail.streams?.[button.dataset.stream]?.n;
      if (n !== undefined) count(button, n);
    }
  });

  function build({ phase, buttons = [], behaviours = [], sensors = [] }) {
    press.replaceChildren(...buttons.map(({ stream, label, count: n }) => {
      const button = make("button", { type: "button", className: "button" }, icon("button"),
        make("span", {}, make("b", { textContent: label }), make("small")));
      button.dataset.stream = stream;
      count(button, n);
      button.addEventListener("click", () => {
        wait(label);
        act("press", { label });
      });
      return button;
    }));
    const keys = Math.min(buttons.length, 9);
    put(document.getElementById("hand-keys"), matchMedia("(pointer: coarse)").matches ? "" : keys > 1 ? `keys 1 to ${keys}` : keys ? "key 1" : "");
    document.getElementById("no-buttons").hidden = buttons.length > 0 || phase === "starting"; // they are not known yet
    document.getElementById("hand-head").hidden = press.hidden = !buttons.length;
    switches.replaceChildren(switches.firstElementChild, ...behaviours.map(({ name, on }) => {
      const box = make("input", { type: "checkbox", value: name, checked: on, role: "switch" });
      box.addEventListener("change", () => act("switch", { behaviour: name, on: box.checked }));
      return make("label", {}, box, name);
    }));
    const chosen = send.elements.stream.value;
    const shown = sensors.filter((s) => s.device !== "OperatorButton");
    send.elements.stream.replaceChildren(...shown.map((s) => make("option", { value: s.name, textContent: s.name })));
    if (shown.some((s) => s.name === chosen)) send.elements.stream.value = chosen;
    else example();
  }

  function count(button, n) {
    button.dataset.n = n;
    put(button.querySelector("small"), n === 0 ? "not yet" : n === 1 ? "pressed once" : `pressed ${n} times`);
  }

  /** What is pressed while the run stands still is counted with its next frame. */
  function wait(label) {
    if (state.phase !== "paused") return;
    for (const button of press.children) {
      if (button.querySelector("b").textContent === label) put(button.querySelector("small"), WAITS);
    }
  }

  function example() {
    const found = (state.sensors ?? []).find((s) => s.name === send.elements.stream.value);
    send.elements.text.value = found?.example ?? "";
  }

  function enable() {
    const on = ["running", "paused"].includes(state.phase) && !lost;
    for (const part of root.querySelectorAll("#press button, #switches input, #mark button, #send button")) part.disabled = !on;
  }

  numberKeys(press);
  send.elements.stream.addEventListener("change", example);
  send.addEventListener("submit", (event) => {
    event.preventDefault();
    act("send", { stream: send.elements.stream.value, text: send.elements.text.value });
  });
  mark.addEventListener("submit", async (event) => {
    event.preventDefault();
    const note = mark.elements.note.value;
    mark.elements.note.value = "";
    if ((await act("mark", { note })).message) mark.elements.note.value ||= note;
  });
}
