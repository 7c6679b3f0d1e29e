// On every page: that a run goes on, and Stop. A workbook's page hears it from the server's events, the others ask.

import { ask, request } from "../api.js";
import { pressTwice } from "../commands.js";

const strip = document.getElementById("run-strip");
const EVERY = 2000; // ms
let run = { phase: "none" };

function show(now) {
  run = now;
  strip.hidden = now.phase === "none";
  if (now.phase === "none") return;
  strip.dataset.mode = now.mode;
  strip.querySelector(".badge").textContent = now.mode === "pilot" ? "Pilot rehearsal" : "Simulated";
  const minutes = Math.max(0, Math.round((Date.now() / 1000 - now.since) / 60));
  const since = minutes < 1 ? "less than a minute" : minutes === 1 ? "a minute" : `${minutes} minutes`;
  const who = now.participant ? ` with ${now.participant}` : "";
  strip.querySelector(".what").textContent = now.phase === "stopping" || now.phase === "finishing"
    ? `${now.book} is being stopped.` : `${now.by} is running ${now.book}${who}, for ${since}.`;
  strip.querySelector("a").href = `/book/${encodeURIComponent(now.book)}/run`;
  strip.querySelector(".stop").disabled = !["starting", "running", "paused"].includes(now.phase);
}

strip.querySelector(".stop").addEventListener("click", stop);
pressTwice("anywhere", () => run.phase !== "none" && stop());

async function stop() {
  await ask("stop", {}, `/book/${encodeURIComponent(run.book)}/run`);
  if (!document.getElementById("listen")) await look();
}

async function look() {
  if (document.hidden) return;
  const { ok, json } = await request(strip.dataset.now);
  if (ok) show(json);
  else if (run.phase !== "none") strip.querySelector(".what").textContent = `Whether ${run.book} still runs is not known: the server cannot be reached.`;
}

if (document.getElementById("listen")) document.addEventListener("rrp:elsewhere", ({ detail }) => show(detail));
else {
  look();
  setInterval(look, EVERY);
  document.addEventListener("visibilitychange", look);
}
