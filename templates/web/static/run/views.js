// What is shown below the rows during a run: one view at a time, chosen by tabs and kept for the person.

import { put } from "../elements.js";
import { hasTwoKeys } from "../preferences.js";

const KEPT = "run-view"; // the key of the choice in the browser's storage
const STEPS = { ArrowRight: 1, ArrowLeft: -1 };

export function views(root) {
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
    localStorage.setItem(KEPT, wanted.dataset.view);
  });
  root.addEventListener("keydown", (event) => {
    const at = tabs.indexOf(event.target.closest("[role=tab]"));
    const to = { Home: 0, End: tabs.length - 1 }[event.key] ?? (event.key in STEPS ? at + STEPS[event.key] : -1);
    if (to === -1 && !(event.key in STEPS)) return;
    event.preventDefault();
    const wanted = tabs[(to + tabs.length) % tabs.length];
    choose(wanted, true);
    localStorage.setItem(KEPT, wanted.dataset.view);
  });
  document.addEventListener("htmx:after:swap", count);
  document.addEventListener("rrp:preferences", () => choose(tabs.find((one) => one.ariaSelected === "true")));
  choose(tab(localStorage.getItem(KEPT)) ?? tabs[0]);
  count();

  /** The numbers of tests and problems stand in their tabs: nothing opens by itself. */
  function count() {
    put(tab("problems").lastElementChild, String(below.querySelectorAll(".problem-list > li").length || ""));
    put(tab("tests").lastElementChild, below.querySelector(".tests-count")?.dataset.short ?? "");
    tab("tests").hidden = !below.querySelector(".tests-panel");
  }
}
