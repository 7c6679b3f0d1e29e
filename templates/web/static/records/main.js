// The pages of runs, versions, comparisons and print, beyond links and forms.

import { randomId, request } from "../api.js";
import { hasCalm } from "../preferences.js";
import { t } from "../texts.js";

const RECORD_WITHIN_MS = 150_000; // for the reading of a long record
const SECONDS_BEFORE = 2; // seconds that are shown before a moment, and after it
const SECONDS_AFTER = 8;
const AGAIN_MS = 1000; // before it is asked again for the last file of a record
const FIRST_CURVES = 8; // drawn at once
const WORDS_AFTER_MS = 500; // a file that takes longer is announced
const LOOK_EVERY_MS = 250; // between two looks for the cookie that comes with the file
const FILE_WITHIN_S = 300; // then nothing more is said of it

/** Show the marbles around a moment. */
function showMoment(seconds) {
  const form = document.querySelector("#marbles form");
  if (!form) return;
  form.elements.from.value = String(Math.max(0, Math.floor(seconds - SECONDS_BEFORE)));
  form.elements.to.value = String(Math.ceil(seconds + SECONDS_AFTER));
  form.requestSubmit();
  document.getElementById("marbles").scrollIntoView({ behavior: hasCalm() ? "auto" : "smooth", block: "start" });
}

/** Draw the curves with the module that draws them during a run. */
async function drawCurves(section) {
  const { json: series } = await request(section.dataset.series);
  if (!series?.length) return;
  const { plotRecord } = await import("../run/plots.js");
  section.hidden = false; // before it is drawn: a hidden place has no width
  plotRecord(section.querySelector("[data-plots]"), series.slice(0, FIRST_CURVES));
  const more = section.querySelector("details");
  more.hidden = series.length <= FIRST_CURVES;
  more.addEventListener("toggle", () => plotRecord(more.querySelector("div"), series.slice(FIRST_CURVES)), { once: true });
}

/** Show the whole record when its last file is there. */
async function awaitFiles(address) {
  const { ok, json } = await request(address);
  if (ok && json) location.reload();
  else setTimeout(awaitFiles, AGAIN_MS, address);
}

/** A long record is read, and then shown: the server keeps what it has read for a while. */
async function awaitRecord(notice) {
  const { ok } = await request(notice.dataset.reading, { patience: RECORD_WITHIN_MS });
  if (ok) location.replace(notice.querySelector("a").href);
  else notice.textContent = t("The recording could not be read now. Reload the page.");
}

/** Bring the page of a run to life; null on other pages. */
function record(root) {
  if (!root) return;
  root.addEventListener("click", (event) => {
    const at = event.target.closest("[data-at]");
    if (at) showMoment(Number(at.dataset.at));
  });
  root.addEventListener("submit", ({ target }) => target.querySelector(".choose-rows")?.removeAttribute("open"));
  const writing = root.querySelector("[data-writing]");
  if (writing) awaitFiles(writing.dataset.writing);
  const reading = root.querySelector("[data-reading]");
  if (reading) awaitRecord(reading);
  const curves = document.getElementById("curves");
  if (curves) drawCurves(curves).catch((error) => console.warn(error));
}

// Files that are made when they are asked for: that takes some seconds, and is told until the browser has them.

function line() {
  const said = document.createElement("p");
  said.className = "making";
  said.setAttribute("role", "status");
  document.body.append(said);
  return said;
}

/** Tell why the next page takes its time; a page that one comes back to says it no longer. */
function announce(words) {
  const said = line();
  setTimeout(() => said.append(words), WORDS_AFTER_MS);
  addEventListener("pageshow", () => said.remove(), { once: true });
}

/** Tell that a file is being made, until its answer has come. */
function follow(word) {
  const began = Date.now();
  const said = line();
  const timer = setInterval(() => {
    const seconds = Math.floor((Date.now() - began) / 1000);
    const came = document.cookie.includes(`made-${word}=`);
    if (came || seconds > FILE_WITHIN_S) {
      clearInterval(timer);
      said.remove();
      return;
    }
    if (!said.firstChild && Date.now() - began > WORDS_AFTER_MS) said.append(t("Creating the file …"), document.createElement("span"));
    if (said.firstChild && seconds > 1) said.lastChild.textContent = ` ${seconds} s`; // the words are spoken once
  }, LOOK_EVERY_MS);
}

/** Links and buttons that ask for such a file say so. */
function made(root) {
  root.addEventListener("click", (event) => {
    const link = event.target.closest("a[data-made], a[data-looks]");
    if (!link) return;
    if (link.dataset.looks) {
      if (!event.ctrlKey && !event.metaKey && !event.shiftKey) announce(link.dataset.looks); // else it opens elsewhere
      return;
    }
    const word = randomId(8);
    const address = new URL(link.href);
    address.searchParams.set("made", word);
    link.href = address;
    follow(word);
  });
  root.addEventListener("submit", (event) => {
    const form = event.target;
    form.querySelector("[name=made]")?.remove();
    if (event.submitter?.dataset.looks) announce(event.submitter.dataset.looks);
    if (!event.submitter?.matches("[data-made]") || !form.querySelector("[name=run]:checked")) return;
    const field = document.createElement("input");
    Object.assign(field, { type: "hidden", name: "made", value: randomId(8) });
    form.append(field);
    follow(field.value);
  });
}

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
    document.querySelector("[data-ready]").textContent = drawing() ? "" : t("All diagrams are drawn.");
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
