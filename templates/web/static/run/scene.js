// The things of the scene: where each is, moved by sliders, and what it can be made to do by hand.

import { act } from "./ask.js";
import { make, put } from "./make.js";
import { move, ways } from "./moving.js";

const quick = { ball: ["appears", "circles", "disappears"], person: ["enters", "looks away", "looks back", "leaves", "says", "touches"] };

export function scene(root) {
  const holder = document.getElementById("things");
  const known = JSON.parse(document.getElementById("acts").textContent);
  let things = new Map(); // name → what moves its sliders

  document.addEventListener("rrp:run", ({ detail }) => {
    const names = (detail.things ?? []).map((t) => `${t.kind} ${t.name}`).join("\n");
    if (names !== holder.dataset.names) {
      holder.dataset.names = names;
      const parts = (detail.things ?? []).filter((t) => quick[t.kind]).map((t) => thing(t));
      things = new Map(parts.map((p) => [p.name, p]));
      holder.replaceChildren(...parts.map((p) => p.element));
    }
    root.hidden = detail.phase === "none" || !things.size;
    const on = ["running", "paused"].includes(detail.phase);
    for (const part of holder.querySelectorAll("input, button, select")) part.disabled = !on;
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    if (!detail.robot) return;
    for (const [name, part] of things) part.at(detail.robot.things[name]);
  });

  document.addEventListener("rrp:moved", ({ detail }) => things.get(detail.thing)?.moved(detail.at));

  function thing({ name, kind, at }) {
    const rows = ways.map(([word, min, max]) => slider(name, word, min, max));
    let held = 0; // until when the sliders are the user's
    for (const row of rows) {
      row.input.addEventListener("input", () => {
        row.show();
        move(name, rows.map((r) => Number(r.input.value)));
      });
    }
    const sliders = make("div", { className: "sliders" }, ...rows.flatMap((r) => [r.label, r.input, r.output]));
    const away = make("p", { className: "quiet", textContent: "Not in the scene now. Move a slider, and it appears there.", hidden: true });
    const element = make("section", { className: "thing" }, make("h3", { textContent: name }), sliders, away, acts(name, kind));
    const part = {
      name, element,
      at(place) {
        away.hidden = Boolean(place);
        if (place && performance.now() > held) rows.forEach((r, i) => r.set(place[i]));
      },
      moved(place) { // by hand, here or in the picture
        held = performance.now() + 1200;
        rows.forEach((r, i) => r.set(place[i]));
      },
    };
    part.at(at);
    return part;
  }

  function acts(name, kind) {
    const line = make("div", { className: "hand-acts" });
    for (const verb of quick[kind]) {
      const example = known[kind][verb] ?? "";
      const word = make("button", { type: "button", className: "button small", textContent: verb });
      const choice = verb === "says" ? make("input", { value: example, maxLength: 100, ariaLabel: `What ${name} says` })
        : verb === "touches" ? make("select", { ariaLabel: `What ${name} touches` }, ...known.zones.map((zone) => make("option", { textContent: zone }))) : null;
      word.addEventListener("click", () => act("scene", { thing: name, verb, value: choice ? choice.value : example }));
      line.append(choice ? make("span", { className: "act" }, word, make("label", { className: "field" }, choice)) : word);
    }
    return line;
  }
}

function slider(thing, word, min, max) {
  const id = `slide-${thing.replaceAll(/\W/g, "-")}-${word}`;
  const input = make("input", { type: "range", id, min, max, step: 0.01, ariaLabel: `${thing}: ${word}` });
  const output = make("output", {});
  const show = () => {
    put(output, `${Number(input.value).toFixed(2)} m`);
    input.ariaValueText = `${input.value} metres`;
  };
  return {
    label: make("label", { htmlFor: id, textContent: word }), input, output, show,
    set(value) {
      const text = value.toFixed(2);
      if (input.value === text) return;
      input.value = text;
      show();
    },
  };
}
