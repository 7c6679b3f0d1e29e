// The session column: the operator's buttons, a switch for each behaviour, marks, values sent by hand, the things of the scene.

import { act, takesActions } from "../api.js";
import { press as pressKey } from "../commands.js";
import { icon, make, put } from "../elements.js";
import { t, tn } from "../texts.js";
import { move, ways } from "./robot.js";
import { now } from "./time.js";

const WAITS = t("sent when the run continues");
const QUICK = { // verbs of the buttons beside a thing, by its kind
  ball: ["appears", "circles", "disappears"],
  person: ["enters", "looks away", "looks back", "leaves", "says", "touches", "pushes"],
  cup: ["appears", "disappears"], box: ["appears", "disappears"],
  table: ["appears", "disappears"], wall: ["appears", "disappears"],
};
const VERBS = { // as shown
  appears: t("appears"), circles: t("circles"), disappears: t("disappears"), enters: t("enters"), "looks away": t("looks away"),
  "looks back": t("looks back"), leaves: t("leaves"), says: t("says"), touches: t("touches"), pushes: t("pushes"),
};
const BRINGS = ["appears", "enters"]; // verbs for a thing that is not there
const GROUNDED = ["table", "wall"]; // kinds that stay on the floor
const LEVELS = [["Light", t("Light"), "light", 1], ["Noise", t("Noise"), "noise", 0]]; // of the room: name, also as shown, field of the event, at first

export function session() {
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
  document.addEventListener("rrp:connection", ({ detail }) => {
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
    put(document.getElementById("hand-keys"), matchMedia("(pointer: coarse)").matches ? "" : keys ? tn("key {n}", "keys 1 to {n}", { n: keys }) : "");
    document.getElementById("no-buttons").hidden = buttons.length > 0 || phase === "starting"; // they are not known yet
    press.hidden = !buttons.length;
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
    put(button.querySelector("small"), n === 0 ? t("not yet") : tn("pressed once", "pressed {n} times", { n }));
  }

  /** Say of a button that its press counts with the next frame, while the run stands still. */
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
    const on = takesActions(state.phase) && !lost;
    for (const part of document.querySelectorAll("#press button, #switches input, #mark button, #send button")) part.disabled = !on;
  }

  document.addEventListener("keydown", (event) => pressKey("operator", event, press));
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

// The things of the scene: where each is, moved by sliders, and what it can be made to do by hand.

export function scene(root) {
  const holder = document.getElementById("things");
  const known = JSON.parse(document.getElementById("acts").textContent);
  let things = new Map(); // name → what moves its sliders
  const room = levelsOf();
  let running = false;
  let lost = false; // the connection to the server

  document.addEventListener("rrp:run", ({ detail }) => {
    const names = (detail.things ?? []).map(({ kind, name }) => `${kind} ${name}`).join("\n");
    if (names !== holder.dataset.names) {
      holder.dataset.names = names;
      putBack();
      const parts = (detail.things ?? []).filter(({ kind }) => QUICK[kind]).map((one) => thing(one));
      things = new Map(parts.map((p) => [p.name, p]));
      holder.replaceChildren(...parts.map((p) => p.element), room.element);
    }
    root.hidden = detail.phase === "none";
    running = takesActions(detail.phase);
    enable();
  });
  document.addEventListener("rrp:connection", ({ detail }) => {
    lost = detail.lost;
    enable();
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    if (!detail.robot) return;
    for (const [name, part] of things) part.at(detail.robot.things[name]);
    room.at(detail.robot);
  });

  // a thing that is chosen in the picture has its part there, in a card
  const card = document.getElementById("thing-card");
  const putBack = () => {
    card.hidden = true;
    const part = card.querySelector(".thing");
    if (part) holder.append(part);
  };
  document.addEventListener("rrp:chosen", ({ detail }) => {
    putBack();
    const part = things.get(detail.thing);
    if (!part) return;
    put(card.querySelector("h3"), part.title);
    card.append(part.element);
    card.hidden = false;
  });
  for (const button of [card.querySelector("button"), document.querySelector("#views [data-view=scene]")]) button.addEventListener("click", putBack);
  card.addEventListener("keydown", ({ key }) => key === "Escape" && putBack());

  document.addEventListener("rrp:moved", ({ detail }) => things.get(detail.thing)?.moved(detail.at));

  function enable() {
    const on = running && !lost;
    for (const part of [holder, ...card.querySelectorAll(".thing")].flatMap((place) => [...place.querySelectorAll("input, button, select")])) part.disabled = !on || part.closest("[data-absent] .hand-acts [data-needs]") !== null;
  }

  function thing({ name, title = name, kind, at }) {
    const rows = ways.slice(0, GROUNDED.includes(kind) ? 2 : 3).map(([word, min, max]) => slider(name, word, min, max));
    let usersUntil = 0; // ms: the sliders are the user's, and do not follow the thing
    let absent = false;
    for (const row of rows) {
      row.input.addEventListener("input", () => {
        row.show();
        move(name, [...rows.map((r) => Number(r.input.value)), 0].slice(0, 3));
      });
    }
    const sliders = make("div", { className: "sliders" }, ...rows.flatMap((r) => [r.label, r.input, r.output]));
    const away = make("p", { className: "quiet", textContent: t("Not in the scene now. Move a slider, and it appears there."), hidden: true });
    const element = make("section", { className: "thing" }, make("h3", { textContent: title }), sliders, away, acts(name, kind));
    const part = {
      name, title, element,
      at(place) {
        away.hidden = Boolean(place);
        if (element.toggleAttribute("data-absent", !place) !== absent) {
          absent = !place;
          enable();
        }
        if (place && performance.now() > usersUntil) rows.forEach((r, i) => r.set(place[i]));
      },
      moved(place) { // by hand, here or in the picture
        usersUntil = performance.now() + 1200;
        rows.forEach((r, i) => r.set(place[i]));
      },
    };
    part.at(at);
    return part;
  }

  function acts(name, kind) {
    const buttons = make("div", { className: "hand-acts" });
    for (const verb of QUICK[kind]) {
      const example = known[kind][verb] ?? "";
      const word = make("button", { type: "button", className: "button small", textContent: VERBS[verb] });
      const choice = verb === "says" ? make("input", { value: example, maxLength: 100, ariaLabel: t("What {name} says", { name }) })
        : verb === "touches" ? make("select", { ariaLabel: t("What {name} touches", { name }) }, ...known.zones.map(([zone, label]) => make("option", { value: zone, textContent: label }))) : null;
      word.toggleAttribute("data-needs", !BRINGS.includes(verb)); // the thing itself
      if (choice) choice.toggleAttribute("data-needs", true);
      word.addEventListener("click", () => act("scene", { thing: name, verb, value: choice ? choice.value : example }));
      buttons.append(choice ? make("span", { className: "act" }, word, make("label", { className: "field" }, choice)) : word);
    }
    return buttons;
  }
}

// Sliders for the light and the noise of the room.
function levelsOf() {
  const rows = LEVELS.map(([name, word, key, first]) => {
    const row = slider(t("Room"), word, 0, 100, 1, (value) => `${Math.round(value)} %`);
    let usersUntil = 0; // ms: it is the user's, and does not follow the room
    let timer = 0;
    row.set(first * 100);
    row.input.addEventListener("input", () => {
      usersUntil = performance.now() + 1200;
      row.show();
      clearTimeout(timer);
      timer = setTimeout(() => act("scene", { thing: name, verb: "set to", value: `${row.input.value} %` }), 120);
    });
    return { ...row, at: (robot) => robot[key] !== undefined && performance.now() > usersUntil && row.set(robot[key] * 100) };
  });
  const sliders = make("div", { className: "sliders" }, ...rows.flatMap((r) => [r.label, r.input, r.output]));
  const element = make("section", { className: "thing" }, make("h3", { textContent: t("Room") }), sliders);
  return { element, at: (robot) => rows.forEach((r) => r.at(robot)) };
}

function slider(thing, word, min, max, step = 0.01, shown = (value) => `${Number(value).toFixed(2)} m`) {
  const id = `slide-${thing.replaceAll(/\W/g, "-")}-${word}`;
  const input = make("input", { type: "range", id, min, max, step, ariaLabel: `${thing}: ${word}` });
  const output = make("output", {});
  const show = () => {
    put(output, shown(input.value));
    input.ariaValueText = step === 1 ? shown(input.value) : t("{n} metres", { n: input.value });
  };
  return {
    label: make("label", { htmlFor: id, textContent: word }), input, output, show,
    set(value) {
      const text = step === 1 ? String(Math.round(value)) : value.toFixed(2);
      if (input.value === text) return;
      input.value = text;
      show();
    },
  };
}
