// What the pages of runs, versions, comparisons and print do beyond links and forms.

import { made } from "./made.js";
import { record } from "./record.js";

/** The name that the grid asks for goes with what one keeps and brings back. */
function sign(event) {
  const author = event.target.elements?.author;
  if (author) author.value = localStorage.getItem("name") ?? "";
}

/** Before and after change places. */
function swap(button) {
  const form = button.closest("form");
  const { first, second } = form.elements;
  [first.value, second.value] = [second.value, first.value];
  if (first.value && second.value) form.requestSubmit();
}

/** The page can be printed when all its diagrams are there. */
function wait(button) {
  const drawing = () => document.querySelector("main [aria-busy='true'], main [data-trouble]");
  const tell = () => {
    button.disabled = Boolean(drawing());
    document.querySelector("[data-ready]").textContent = drawing() ? "" : "All diagrams are drawn.";
  };
  new MutationObserver(tell).observe(document.querySelector("main"), { childList: true, subtree: true });
  tell();
}

document.addEventListener("submit", sign, true); // before htmx takes the form
document.addEventListener("click", (event) => {
  if (event.target.closest("[data-print]")) window.print();
  const button = event.target.closest("[data-swap]");
  if (button) swap(button);
});
for (const button of document.querySelectorAll("[data-print]")) wait(button);
for (const button of document.querySelectorAll("[data-swap]")) button.hidden = false;
record(document.querySelector(".record"));
made(document);
