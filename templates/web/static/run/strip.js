// On every page: that a run goes on, and Stop. A workbook's page hears it from the server's events, the others ask.

import { canBeStopped, isEnding, NO_RUN, request, shownName, stop, why } from "../api.js";
import { pressTwice } from "../commands.js";
import { put } from "../elements.js";
import { t, tn } from "../texts.js";

const strip = document.getElementById("run-strip");
const what = strip.querySelector(".what");
const listen = document.getElementById("listen"); // on a workbook's page, whose run bar tells of its own run
const EVERY = 2000; // ms
const REFUSAL_SHOWN = 12000; // ms
let run = { phase: "none" };
let refusal = ""; // why Stop did nothing, while that is shown
let unknown = ""; // why nothing is known of the run, since the server has not answered
let vanishing = 0;
let asked = 0; // questions so far, of which
let answered = 0; // this is the newest that has its answer: one that comes later is out of date

function show(now) {
  const isOver = run.phase !== "none" && now.phase === "none";
  run = now;
  unknown = "";
  if (isOver) refused(""); // that was about this run
  else draw();
}

function draw() {
  const none = run.phase === "none"; // as far as the page knows: Stop may still have failed for a run it has not heard of
  const [badge, link] = [strip.querySelector(".badge"), strip.querySelector("a")];
  strip.hidden = none && !refusal;
  badge.hidden = link.hidden = none;
  put(what, words());
  strip.querySelector(".stop").disabled = !none && !canBeStopped(run.phase);
  strip.dataset.mode = none ? "" : run.mode;
  if (none) return;
  badge.textContent = run.mode === "pilot" ? t("Pilot rehearsal") : t("Simulated");
  link.href = `/book/${encodeURIComponent(run.book)}/run`;
}

function words() {
  if (refusal || unknown || run.phase === "none") return refusal || unknown;
  if (isEnding(run.phase)) return t("{book} is being stopped.", run);
  const minutes = Math.max(0, Math.round((Date.now() / 1000 - run.since) / 60));
  const time = minutes < 1 ? t("less than a minute") : tn("a minute", "{n} minutes", { n: minutes });
  const told = { ...run, by: shownName(run.by), time };
  return run.participant ? t("{by} has been running {book} with {participant} for {time}.", told) : t("{by} has been running {book} for {time}.", told);
}

strip.querySelector(".stop").addEventListener("click", stop);
pressTwice("anywhere", stop);
document.addEventListener("rrp:stop", ({ detail: { message = "", status } }) => {
  const none = run.phase === "none";
  if (none && listen) return; // the run bar shows it
  refused(none && status === NO_RUN ? "" : message); // that there is none is no news
  if (!message && !listen) poll();
});

/** Show for a while why Stop did nothing; an empty text shows the run again. */
function refused(message) {
  clearTimeout(vanishing);
  refusal = message;
  what.removeAttribute("role");
  if (message) {
    what.setAttribute("role", "alert");
    vanishing = setTimeout(refused, REFUSAL_SHOWN, "");
  }
  draw();
}

async function poll() {
  if (document.hidden) return;
  const question = ++asked;
  const { ok, status, text, json } = await request(strip.dataset.now);
  if (question < answered) return;
  answered = question;
  if (ok && json) show(json);
  else if (run.phase !== "none") {
    unknown = t("This page cannot tell if {book} is still running. {why}", { book: run.book, why: why({ status, text }) });
    put(what, words());
  }
}

if (listen) document.addEventListener("rrp:elsewhere", ({ detail }) => show(detail));
else {
  poll();
  setInterval(poll, EVERY);
  document.addEventListener("visibilitychange", poll);
}
