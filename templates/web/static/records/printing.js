// The Print page: what is chosen is shown at once, and the PDF is made before it is fetched, so that trouble can be told.

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
    if (!answer.ok) throw new Error(answer.statusText);
    const { trouble, notes } = await answer.json();
    if (trouble) return tell(trouble);
    location.assign(`${button.formAction}?${chosen}`);
    said.textContent = ["The PDF is made.", ...notes].join(" ");
  } catch {
    tell("The server did not answer. Is the program still running? Try again.");
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
for (const kind of ["htmx:responseError", "htmx:sendError", "htmx:timeout"]) {
  document.addEventListener(kind, () => {
    const waiting = document.querySelector("main [aria-busy='true']");
    waiting?.removeAttribute("aria-busy");
    if (waiting) waiting.textContent = "The protocol could not be shown. Load the page again.";
  });
}
