// Lists, sliders and ticks for who has two keys: Enter opens a list or slider, Tab goes to its next choice or step (after the last
// to the first), Enter takes it. A tick is set or taken away by Enter, of a group the next one is set.

import { make, put } from "./elements.js";
import { hasTwoKeys } from "./preferences.js";
import { t } from "./texts.js";

const STEPS = 10; // from one end of a slider to the other

const said = make("p", { className: "only-spoken", role: "status" });
let open = null; // { field, was }: what is being chosen

document.addEventListener("keydown", (event) => {
  const { key, target: field, shiftKey, ctrlKey, altKey, metaKey } = event;
  if (!hasTwoKeys() || shiftKey || ctrlKey || altKey || metaKey || !["Tab", "Enter", "Escape"].includes(key)) return;
  if (open?.field === field) {
    if (key === "Tab") next(field);
    else end(key === "Enter");
  } else if (key === "Enter" && ["checkbox", "radio"].includes(field.type)) another(field).click();
  else if (key === "Enter" && ["select-one", "range"].includes(field.type)) begin(field);
  else return;
  event.preventDefault();
  event.stopImmediatePropagation();
}, true);
document.addEventListener("focusout", ({ target }) => open?.field === target && end(false));

function begin(field) {
  open = { field, was: field.value };
  field.classList.add("choosing");
  if (!said.isConnected) document.body.append(said);
  say(t("Tab: next choice. Enter: take it."));
}

function next(field) {
  if (field.type === "range") {
    const [least, most] = [Number(field.min || 0), Number(field.max || 100)];
    const now = Number(field.value);
    field.value = now >= most ? least : Math.min(now + (most - least) / STEPS, most);
  } else {
    const choices = [...field.options].filter((one) => !one.disabled && !one.hidden);
    choices[(choices.indexOf(field.selectedOptions[0]) + 1) % choices.length].selected = true;
  }
  tell(field, "input");
  say(field.selectedOptions?.[0].textContent ?? field.value);
}

function end(takes) {
  const { field, was } = open;
  open = null;
  field.classList.remove("choosing");
  if (field.value === was) return;
  if (!takes) field.value = was;
  tell(field, takes ? "change" : "input");
}

/** The tick itself; of a group, the one after it. */
function another(field) {
  if (field.type === "checkbox") return field;
  const group = [...document.getElementsByName(field.name)].filter((one) => one.form === field.form && !one.disabled);
  return group[(group.indexOf(field) + 1) % group.length];
}

const tell = (field, name) => field.dispatchEvent(new Event(name, { bubbles: true }));
const say = (text) => put(said, text);
