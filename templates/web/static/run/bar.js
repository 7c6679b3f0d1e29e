// The run bar: run, pause, step, stop, speed, and what goes on; what is refused is told below it.

import { act, ask, canBeStopped, isNamed, NO_RUN, ownName, panel, settings, shownName, stop, takesActions } from "../api.js";
import { button, make, put } from "../elements.js";
import { t, tn } from "../texts.js";
import { clock, EXACT, now } from "./time.js";

const words = {
  none: t("No run"), starting: t("Starting …"), running: t("Running"), paused: t("Paused"), ended: t("Run ended"),
  stopping: t("Stopping: the robot is moving to its rest position …"), finishing: t("Stopping: the robot is moving to its rest position …"),
};
const UNKNOWN = t("This page no longer hears from the run. If the program has ended, the robot moves to its rest position by itself. If only the network is interrupted, the run continues: you can stop it at the computer that runs the program. Press Stop to try it from here.");
const SHOWN = 12000; // ms that a refusal is told
const SMALL = "button small"; // class of the buttons in lines of text
const modes = { simulated: t("Simulated"), pilot: t("Pilot rehearsal"), real: t("Real robot") };

export function bar(root) {
  const buttons = Object.fromEntries([...root.querySelectorAll("[data-run]")].map((b) => [b.dataset.run, b]));
  const phase = document.getElementById("run-phase");
  const watch = document.getElementById("run-clock");
  const mode = document.getElementById("run-mode");
  const speed = document.getElementById("run-speed");
  const why = document.getElementById("run-why");
  const problem = document.getElementById("run-problem");
  const notice = document.getElementById("run-notice");
  const lookback = document.getElementById("run-lookback");
  const openDialog = dialog(root);
  const notUsed = make("span");
  const again = button(t("Restart"), () => act("restart"), SMALL);
  let vanishing = 0;
  let state = { phase: "none" };
  let elsewhere = { phase: "none" };
  let lost = false; // the connection on which the server tells what happens
  let errors = Number(root.dataset.errors);
  let onTheWay = false; // to the first error: their number is told before their list has come
  speed.value = localStorage.getItem("run-speed") ?? "1";

  buttons.start.addEventListener("click", () => {
    if (errors) goToFirstError();
    else if (buttons.start.ariaDisabled !== "true") openDialog(speed.value);
  });
  buttons.stop.addEventListener("click", stop);
  buttons.pause.addEventListener("click", () => act(state.phase === "paused" ? "resume" : "pause"));
  buttons.step.addEventListener("click", () => act("step"));
  speed.addEventListener("change", () => {
    localStorage.setItem("run-speed", speed.value);
    if (acting()) act("speed", { speed: Number(speed.value) });
  });

  document.addEventListener("rrp:run", ({ detail }) => {
    state = detail;
    show();
  });
  document.addEventListener("rrp:connection", ({ detail }) => {
    lost = detail.lost;
    show();
  });
  document.addEventListener("rrp:elsewhere", ({ detail }) => {
    elsewhere = detail;
    show();
  });
  document.getElementById("listen").addEventListener("checked", ({ detail }) => {
    errors = JSON.parse(detail.data).errors;
    onTheWay &&= errors > 0;
    show();
  });
  document.addEventListener("rrp:refused", ({ detail }) => refused(detail.message));
  document.addEventListener("rrp:stop", ({ detail: { message, status } }) => {
    if (elsewhere.phase !== "none") return; // the strip shows it
    if (message && (status !== NO_RUN || canBeStopped(state.phase))) refused(message); // that there is none is no news
  });
  document.addEventListener("rrp:log", ({ detail }) => {
    const line = detail.lines.findLast((l) => l.kind === "refused");
    if (!line || now() - line.t >= 5) return;
    refused(line.text);
    if (acting()) speed.value = String(state.speed); // perhaps it was the speed that cannot be had
  });
  document.addEventListener("htmx:after:swap", () => {
    if (onTheWay) goToFirstError();
    show(); // the list of the problems has come: where the first one is
  });
  setInterval(() => {
    if (!watch.hidden) put(watch, clock(now(), state.phase === "paused" ? EXACT : 1));
  }, 100);

  function acting() {
    return takesActions(state.phase);
  }

  function show() {
    const going = !["none", "ended"].includes(state.phase);
    const unknown = lost && going;
    put(phase, unknown ? t("Not known") : words[state.phase]);
    phase.classList.toggle("is-warning", unknown);
    watch.hidden = state.phase === "none" || unknown;
    put(watch, clock(now(), state.phase === "paused" ? EXACT : 1));
    buttons.stop.disabled = !canBeStopped(state.phase);
    buttons.pause.disabled = !acting() || lost;
    lookback.hidden = state.phase !== "ended" || !state.folder; // it takes the place of Pause
    buttons.pause.hidden = !lookback.hidden;
    if (!lookback.hidden) lookback.href = `${root.dataset.runs}/${encodeURIComponent(state.folder)}/lookback`;
    buttons.pause.lastElementChild.textContent = state.phase === "paused" ? t("Continue") : t("Pause");
    buttons.pause.querySelector("use").setAttribute("href", `${icons()}#i-${state.phase === "paused" ? "run" : "pause"}`);
    buttons.step.disabled = state.phase !== "paused" || lost;
    speed.disabled = unknown;
    mode.hidden = state.phase === "none";
    put(mode, modes[state.mode] ?? "");
    if (acting() && document.activeElement !== speed) speed.value = String(state.speed);
    for (const name of ["participant", "condition", "operator", "by"]) {
      const place = document.getElementById(`run-${name}`);
      place.hidden = state.phase === "none" || !state[name] || (name === "by" && state.by === state.operator);
      put(place.querySelector("b"), name === "by" ? shownName(state.by) : state[name] ?? "");
    }
    document.getElementById("run-see")?.toggleAttribute("hidden", state.phase === "none");
    const reason = startReason(going);
    buttons.start.ariaDisabled = String(Boolean(reason));
    why.hidden = !reason || going;
    tellWhy(reason);
    if (reason) buttons.start.setAttribute("aria-describedby", "run-why");
    else buttons.start.removeAttribute("aria-describedby");
    shownEnd();
  }

  function errorsLeft() {
    return tn("Fix {n} error to run.", "Fix {n} errors to run.", { n: errors });
  }

  function startReason(going) {
    if (going) return t("A run is in progress.");
    if (elsewhere.phase !== "none") return t("{by} is running {book}. There is one robot, so one run at a time.", { ...elsewhere, by: shownName(elsewhere.by) });
    if (errors) return errorsLeft();
    return "";
  }

  /** Show the result of the run, or why edited rows are not used, with buttons for what can be done about it. */
  function shownEnd() {
    const { ended, restart } = state;
    const over = state.phase === "ended" && ended;
    const unknown = lost && !["none", "ended"].includes(state.phase);
    const unused = !unknown && restart && acting();
    const told = JSON.stringify([over, unknown, unused && restart, state.folder, errors > 0]);
    if (told === notice.dataset.told) return; // a button is not taken away from under a finger
    notice.dataset.told = told;
    notice.hidden = !over && !unused && !unknown;
    notice.className = `run-notice notice ${over?.broken ? "is-error" : unused || unknown ? "is-warning" : ""}`;
    if (unknown) notice.replaceChildren(make("span", { textContent: UNKNOWN }));
    else if (over) {
      notice.replaceChildren(make("span", { textContent: `${ended.words} ${ended.remedy}`.trim() }),
        ...(state.folder ? [link(t("Open the recording"), `${root.dataset.runs}/${encodeURIComponent(state.folder)}`)] : []),
        button(t("Show example values again"), () => act("clear"), SMALL));
    } else if (unused) {
      put(notUsed, t("Still running the old rows. {why}", { why: restart }));
      const parts = errors ? [notUsed] : [notUsed, again];
      if (notice.lastChild !== parts.at(-1)) notice.replaceChildren(...parts); // else a screen reader would read it again, and a press of the button would be lost
    }
  }

  /** Show for a while the message of a refused action. */
  function refused(text) {
    clearTimeout(vanishing);
    problem.hidden = false;
    problem.replaceChildren(make("span", { textContent: text }), button(t("Close"), () => {
      problem.hidden = true;
    }, SMALL));
    vanishing = setTimeout(() => {
      problem.hidden = true;
    }, SHOWN);
  }

  /** Show why a run cannot be started; of errors also the place of the first, which may be on another sheet and below the edge. */
  function tellWhy(reason) {
    const place = errors && reason === errorsLeft() ? firstError()?.textContent ?? "" : "";
    if (why.dataset.told === reason + place) return; // a link is not taken away from under a finger
    why.dataset.told = reason + place;
    why.replaceChildren(reason, ...(place ? [" ", button(t("Go to {place}", { place }), goToFirstError, SMALL)] : []));
  }

  function firstError() {
    return [...document.querySelectorAll(".problem-list li")].find((li) => li.querySelector(".severity.is-error"))?.querySelector("a");
  }

  function goToFirstError() {
    const link = firstError();
    onTheWay = !link;
    link?.click();
  }

  function icons() {
    return buttons.stop.querySelector("use").getAttribute("href").replace(/#.*/, "");
  }
}

function link(text, href) {
  return make("a", { href, textContent: text, className: SMALL });
}

// The questions before a run: its type and, of a session or a rehearsal, participant, condition and operator. The last answers
// stay, but never the participant: the next child's session must not be recorded as the former one's.

const TRY = "try"; // the type of a run for which no codes are asked
const kept = ["condition", "operator", "mode", "until"];

function dialog(root) {
  const box = document.getElementById("run-dialog");
  const form = box.querySelector("form");
  const refused = form.querySelector(".run-refused");
  let speed = "1";
  let sure = ""; // the code that is used although it looks like a name

  const codes = form.querySelector(".codes");
  const showCodes = () => { codes.hidden = form.elements.mode.value === TRY; };
  form.addEventListener("change", showCodes);
  form.querySelector("[value=cancel]").addEventListener("click", () => box.close());
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const wish = Object.fromEntries(kept.map((name) => [name, form.elements[name].value.trim()]));
    settings.keep(wish);
    form.querySelector("[type=submit]").disabled = true;
    const named = wish.mode === TRY ? { mode: "simulated", condition: "", operator: "" } : { participant: form.elements.participant.value.trim(), sure };
    const answer = await ask("start", { ...wish, ...named, speed: Number(speed) });
    form.querySelector("[type=submit]").disabled = false;
    if (answer.message) return refuse(answer);
    box.close();
    if (!("panel" in root.dataset)) location.assign(`${panel}/${encodeURIComponent(document.querySelector("[role=grid]")?.dataset.sheet ?? "")}`);
    return undefined;
  });

  function refuse({ message, where, sure: asked = "" }) {
    sure = asked;
    refused.hidden = false;
    refused.className = `run-refused ${asked ? "is-warning" : "is-error"}`;
    refused.textContent = `${message} `;
    if (where) refused.append(make("a", { href: where, textContent: t("Go to that run") }));
  }

  return (wanted) => {
    speed = wanted;
    refused.hidden = true;
    sure = "";
    const before = settings.kept();
    form.elements.participant.value = "";
    for (const name of kept) if (before[name]) form.elements[name].value = before[name];
    if (!form.elements.operator.value && isNamed(ownName())) form.elements.operator.value = ownName();
    showCodes();
    box.showModal();
    (codes.hidden ? form.querySelector("[type=submit]") : form.elements.participant).focus();
  };
}
