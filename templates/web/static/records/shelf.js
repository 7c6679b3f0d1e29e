// The shelf: what the chosen template is about, searching, and files that are dropped on the page.

import { t } from "../texts.js";

/** Say what the chosen template holds. */
function tell(select) {
  const line = select.form.querySelector(".about-template");
  line.textContent = select.selectedOptions[0]?.dataset.about ?? "";
}

/** Show the cards that have all the words. */
function search(field) {
  const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
  const cards = [...document.querySelectorAll(".card")];
  for (const card of cards) card.hidden = !words.every((word) => card.dataset.words.includes(word));
  const found = cards.filter((card) => !card.hidden).length;
  document.querySelector("[data-found]").textContent = words.length ? t("{n} of {all} workbooks", { n: found, all: cards.length }) : "";
  document.querySelector("[data-none]").hidden = found > 0;
}

const carriesFiles = (event) => [...(event.dataTransfer?.types ?? [])].includes("Files");

function over(event) {
  if (!carriesFiles(event)) return;
  event.preventDefault(); // else the browser would open the file
  event.dataTransfer.dropEffect = "copy";
  document.body.classList.add("dropping");
}

function drop(event) {
  document.body.classList.remove("dropping");
  if (!carriesFiles(event)) return;
  event.preventDefault();
  const form = document.querySelector("form.upload");
  form.elements.file.files = event.dataTransfer.files;
  form.requestSubmit();
}

/** Of a very tall diagram the beginning is shown: all of it would be a hairline. */
function fit(image) {
  image.classList.toggle("tall", image.naturalHeight > 2.5 * image.naturalWidth);
}

document.addEventListener("load", ({ target }) => target.matches?.("img.mini") && fit(target), true);
for (const image of document.querySelectorAll("img.mini")) if (image.complete) fit(image);
document.addEventListener("change", ({ target }) => target.name === "template" && tell(target));
document.addEventListener("input", ({ target }) => target.matches?.("[data-search]") && search(target));
document.addEventListener("dragover", over);
document.addEventListener("dragleave", (event) => event.relatedTarget || document.body.classList.remove("dropping"));
document.addEventListener("drop", drop);
