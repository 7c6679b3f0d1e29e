// What is shown below the rows during a run and when one looks back: one view at a time, chosen by tabs and kept for the
// person; and which of the pictures beside them is large.

import { press } from "../commands.js";
import { put } from "../elements.js";
import { hasTwoKeys } from "../preferences.js";

const KEPT = "run-view"; // the key of the choice in the browser's storage
const STEPS = { ArrowRight: 1, ArrowLeft: -1 };

/** The tabs of the views; `key` is where the browser keeps which was chosen. */
export function views(root, key = KEPT) {
  const below = root.parentElement;
  const tabs = [...root.querySelectorAll("[role=tab]")];
  const tab = (view) => tabs.find((one) => one.dataset.view === view);

  function choose(wanted, focus = false) {
    for (const one of tabs) {
      one.ariaSelected = String(one === wanted);
      one.tabIndex = one === wanted || hasTwoKeys() ? 0 : -1;
    }
    below.dataset.view = wanted.dataset.view;
    if (focus) wanted.focus();
  }

  root.addEventListener("click", ({ target }) => {
    const wanted = target.closest("[role=tab]");
    if (!wanted) return;
    choose(wanted);
    localStorage.setItem(key, wanted.dataset.view);
  });
  root.addEventListener("keydown", (event) => {
    const at = tabs.indexOf(event.target.closest("[role=tab]"));
    const to = { Home: 0, End: tabs.length - 1 }[event.key] ?? (event.key in STEPS ? at + STEPS[event.key] : -1);
    if (to === -1 && !(event.key in STEPS)) return;
    event.preventDefault();
    const wanted = tabs[(to + tabs.length) % tabs.length];
    choose(wanted, true);
    localStorage.setItem(key, wanted.dataset.view);
  });
  document.addEventListener("keydown", (event) => press("views", event, tabs.filter((one) => !one.hidden)));
  document.addEventListener("htmx:after:swap", count);
  document.addEventListener("rrp:preferences", () => choose(tabs.find((one) => one.ariaSelected === "true")));
  choose(tab(localStorage.getItem(key)) ?? tabs[0]);
  swaps();
  columns();
  count();

  /** The numbers of tests and problems stand in their tabs: nothing opens by itself. */
  function count() {
    if (!tab("problems")) return;
    put(tab("problems").lastElementChild, String(below.querySelectorAll(".problem-list > li").length || ""));
    put(tab("tests").lastElementChild, below.querySelector(".tests-count")?.dataset.short ?? "");
    tab("tests").hidden = !below.querySelector(".tests-panel");
  }
}

/** A phone shows of each row its number, output and value, unless all columns are wanted. */
function columns() {
  const button = document.getElementById("all-columns");
  button.addEventListener("click", () => {
    button.ariaPressed = String(button.closest("main").classList.toggle("all-columns"));
  });
}

/** The robot's eye large and the room small, or the other way round. */
function swaps() {
  const button = document.getElementById("swap");
  button.addEventListener("click", () => {
    button.ariaPressed = String(document.getElementById("pictures").classList.toggle("swapped"));
  });
}
