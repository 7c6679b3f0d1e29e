// The page of one run: a moment of the log is shown in the marbles; the curves are drawn.

const BEFORE = 2; // seconds that are shown before a moment, and after it
const AFTER = 8;
const AGAIN = 1000; // ms
const FIRST = 8; // curves that are drawn at once

/** Show the marbles around a moment. */
function show(seconds) {
  const form = document.querySelector("#marbles form");
  if (!form) return;
  form.elements.from.value = String(Math.max(0, Math.floor(seconds - BEFORE)));
  form.elements.to.value = String(Math.ceil(seconds + AFTER));
  form.requestSubmit();
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  document.getElementById("marbles").scrollIntoView({ behavior: still ? "auto" : "smooth", block: "start" });
}

/** Draw the curves with the module that draws them during a run. */
async function draw(section) {
  const answer = await fetch(section.dataset.series);
  if (!answer.ok) return;
  const series = await answer.json();
  const { plotRecord } = await import("../run/plotrecord.js");
  if (!plotRecord || !series.length) return;
  section.hidden = false; // before it is drawn: a hidden place has no width
  plotRecord(section.querySelector("[data-plots]"), series.slice(0, FIRST));
  const more = section.querySelector("details");
  more.hidden = series.length <= FIRST;
  more.addEventListener("toggle", () => plotRecord(more.querySelector("div"), series.slice(FIRST)), { once: true });
}

/** Show the whole record when its last file is there. */
async function look(address) {
  const answer = await fetch(address).catch(() => null);
  if (answer?.ok && (await answer.json())) location.reload();
  else setTimeout(look, AGAIN, address);
}

/** A long record is read, and then shown: the server keeps what it has read for a while. */
async function wait(notice) {
  const answer = await fetch(notice.dataset.reading).catch(() => null);
  if (answer?.ok) location.replace(notice.querySelector("a").href);
  else notice.textContent = "The record could not be read now. Load the page again.";
}

/** Bring the page of a run to life; null on other pages. */
export function record(root) {
  if (!root) return;
  root.addEventListener("click", (event) => {
    const at = event.target.closest("[data-at]");
    if (at) show(Number(at.dataset.at));
  });
  root.addEventListener("submit", ({ target }) => target.querySelector(".choose-rows")?.removeAttribute("open"));
  const writing = root.querySelector("[data-writing]");
  if (writing) look(writing.dataset.writing);
  const reading = root.querySelector("[data-reading]");
  if (reading) wait(reading);
  const curves = document.getElementById("curves");
  if (curves) draw(curves).catch((error) => console.warn(error));
}
