// The Print page: what is chosen is shown at once, and the PDF is made before it is fetched, so that trouble can be told.

import { why } from "../api.js";

const form = document.querySelector("[data-choices]");
const said = form.querySelector("[data-said]");
const button = form.querySelector("[data-pdf]");

/** Make the PDF with what is chosen; the browser then fetches it as a file. */
async function pdf() {
  const chosen = new URLSearchParams(new FormData(form));
  button.disabled = true;
  said.className = "print-said";
  said.textContent = "The PDF is being made …";
  try {
    const answer = await fetch(`${button.dataset.pdf}?${chosen}`);
    if (!answer.ok) return tell(why({ response: answer, text: await answer.text() }));
    const { trouble, notes } = await answer.json();
    if (trouble) return tell(trouble);
    location.assign(`${button.formAction}?${chosen}`);
    said.textContent = ["The PDF is made.", ...notes].join(" ");
  } catch {
    tell(why({}));
  } finally {
    button.disabled = false;
  }
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
