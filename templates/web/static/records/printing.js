// The Print page: what is chosen is shown at once, and the PDF is made before it is fetched, so that trouble can be told.

import { request, why } from "../api.js";
import { t } from "../texts.js";

const PDF_WITHIN_MS = 150_000; // as long as a protocol may take

const form = document.querySelector("[data-choices]");
const said = form.querySelector("[data-said]");
const button = form.querySelector("[data-pdf]");

/** Make the PDF with what is chosen; the browser then fetches it as a file. */
async function pdf() {
  const chosen = new URLSearchParams(new FormData(form));
  button.disabled = true;
  said.className = "print-said";
  said.textContent = t("Creating the PDF …");
  const { ok, status, text, json } = await request(`${button.dataset.pdf}?${chosen}`, { patience: PDF_WITHIN_MS });
  button.disabled = false;
  if (!ok || !json) return tell(why({ status, text }));
  if (json.trouble) return tell(json.trouble);
  location.assign(`${button.formAction}?${chosen}`);
  said.textContent = [t("The PDF is ready."), ...json.notes].join(" ");
  return undefined;
}

function tell(trouble) {
  said.classList.add("is-error");
  said.textContent = trouble;
}

form.addEventListener("submit", (event) => {
  if (event.submitter !== button) return;
  event.preventDefault();
  pdf();
});
form.addEventListener("change", (event) => {
  if (event.target.name !== "paper") form.requestSubmit(form.querySelector("[data-show]"));
});
form.querySelector("[data-show]").hidden = true;
