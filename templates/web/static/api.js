// Requests to the server, and the connection on which it tells what happens: how they are sent and sent again, who asks, and why
// there is no answer, in words.

import { button, make } from "./elements.js";
import { t } from "./texts.js";

const ANSWER_WITHIN_MS = 60_000; // as htmx waits
const PAUSES_S = [0.5, 1, 2, 4, 8, 15, 30, 30, 30, 30, 30, 30]; // before the next try of an edit; then it waits for a person
const AWAY = new Set([502, 503, 504]); // statuses of a server that starts again
export const UNREACHED = t("This page has no connection to the program. Check that the program is running, then try again.");
const WORDS = { // why there is nothing to show, by status
  403: t("You are not logged in any more, or the program was started again."),
  404: t("This is no longer there: somebody has renamed, moved or deleted it. Reload the page to see what there is now."),
};
const STOPPED = { // why an edit waits for a person, by status
  0: t("This page has no connection to the program. Start the program again, then choose Try again."),
  403: t("This browser is signed out. Open the link that the program shows in its window, then choose Try again."),
  404: t("The workbook was renamed or moved. Copy your changes, then open it from the page Workbooks."),
};
const TOO_MUCH = t("That is too much at once. Paste it in smaller pieces.");
const RECONNECT_MS = 5000; // before the next try of the connection
const MOST_TRIES = 120; // of the connection, in a row: some ten minutes
const FINAL = new Set([403, 404]); // statuses of the connection that nothing changes by itself
const LOST = { // why there is no connection, by status
  403: t("This browser is signed out. Open the link that the program shows in its window, or log in; then choose Try again."),
  404: t("The workbook was renamed or moved. Go to Workbooks."),
  503: t("You have too many pages open, so this page is not updated. Close another page, and this page continues."),
  0: t("This page has no connection to the program. It tries again by itself."),
};
const PAGE = "page"; // the key of this page's identity in the tab's storage

const bar = document.getElementById("runbar");

/** The address of the run panel of this workbook; empty on other pages. */
export const panel = bar?.dataset.url ?? "";

/** Send a GET, or a POST of `body` (an object, or its JSON). The promise is never rejected. It resolves to the answer's `ok`,
 *  `status` (0: no answer in time), `text`, `json` (null: not JSON) and `etag`. JSON that cannot be read is not `ok`. */
export async function request(url, { body, patience = ANSWER_WITHIN_MS, keepalive = false } = {}) {
  const post = body && { method: "POST", headers: { "Content-Type": "application/json", "X-RRP": "grid" }, body: typeof body === "string" ? body : JSON.stringify(body) };
  const signal = keepalive ? null : AbortSignal.timeout(patience);
  try {
    const response = await fetch(url, { ...post, keepalive, signal });
    const { ok, status, headers } = response;
    const text = await response.text();
    const json = headers.get("Content-Type")?.startsWith("application/json") ? parsed(text) : null;
    return { ok: ok && json !== undefined, status, text, json: json ?? null, etag: headers.get("ETag") };
  } catch {
    return { ok: false, status: 0, text: "", json: null, etag: null };
  }
}

/** The value of a JSON text; undefined when it cannot be read, such as one that was cut off. */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch (error) {
    console.warn(error);
    return undefined;
  }
}

/** Send the JSON of an edit once: its answer, or the status of a server that takes nothing from this page now; 0 when there
 *  is none. */
export async function once(url, text) {
  const { ok, status, json } = await request(url, { body: text });
  if (json) return { answer: json };
  if (AWAY.has(status) || (!ok && status < 400)) return { status: 0 }; // away, or an answer that cannot be read
  if (status in STOPPED) return { status };
  return { answer: { message: status === 413 ? TOO_MUCH : refusal(status), refused: true } };
}

let wake = () => {};
for (const event of ["rrp:again", "rrp:connection"]) document.addEventListener(event, ({ detail }) => detail?.lost || wake());
window.addEventListener("online", () => wake());

/** Send it until there is an answer. `tell` is told why there is none yet, then with an empty text that there is one. */
export async function deliver(url, text, tell) {
  for (let tries = 0; ; tries++) {
    const { status, answer } = await once(url, text);
    if (answer) {
      tell("");
      return answer;
    }
    const pause = status ? undefined : PAUSES_S[tries];
    if (pause === undefined) {
      tell(STOPPED[status]);
      await until();
      tries = -1;
    } else {
      if (tries) tell(t("This page has no connection to the program. It keeps your changes and sends them when the connection is back."));
      await until(pause * 1000);
    }
  }
}

/** Wait so many milliseconds, or until a person or the connection to the server says that it can be tried again. */
function until(milliseconds) {
  return new Promise((resume) => {
    const timer = milliseconds === undefined ? 0 : setTimeout(resume, milliseconds);
    wake = () => {
      clearTimeout(timer);
      resume();
    };
  });
}

/** The message about an action that was not done. */
export function refusal(status) {
  if (status && status < 400) return t("The answer could not be shown. Reload the page.");
  return status ? t("The program did not take your last action (error {status}). Reload the page, then try again.", { status }) : UNREACHED;
}

/** The reason why there is nothing to show, and what to do; the server's own words where it has any. */
export function why(answer) {
  const { words, remedy } = reason(answer);
  return [words, remedy].filter(Boolean).join(" ");
}

/** The reason in words, and what to do about it (`remedy`, which a button may say instead): `reload` tells which. */
function reason({ status, text }) {
  if (!status) return { words: UNREACHED };
  const old = status < 400 ? t("The answer could not be shown.") : WORDS[status];
  if (old) return { words: old, remedy: t("Reload the page."), reload: true };
  const page = new DOMParser().parseFromString(text ?? "", "text/html");
  const told = [...page.querySelectorAll("main.message > p:not(.line)")].map((p) => p.textContent.replace(/^→\s*/, ""));
  if (told.length) return { words: told.join(" ") };
  return { words: t("The program reported an error ({status}).", { status }), remedy: t("Try again.") };
}

// Requests by hx-* attributes: an error is told in words where the answer would have been, and never shown as if
// it were the answer (`noSwap` in parts.html). The line of events (#listen) tells of itself, see `listening`.

/** Tell it in the place that waits for the answer, with a button that does something about it, or behind the form that asked. */
function tell(source, answer) {
  const plain = source.matches("form") || source.id === "panels";
  const { words, reload } = reason(answer);
  const line = make("p", plain ? why(answer) : words);
  line.className = "notice is-error";
  line.setAttribute("role", "alert");
  line.dataset.trouble = "";
  clear(source);
  if (source.matches("form")) return source.after(line);
  if (source.id === "panels") return source.prepend(line);
  const again = reload ? button(t("Reload the page"), () => location.reload(), "button small") : button(t("Try again"), () => {
    source.replaceChildren(t("Asking again …"));
    source.setAttribute("aria-busy", "true");
    htmx.ajax("GET", source.getAttribute("hx-get"), { source, target: source, swap: source.getAttribute("hx-swap") });
  }, "button small");
  line.append(" ", again);
  source.removeAttribute("aria-busy");
  return source.replaceChildren(line);
}

function clear(source) {
  const old = source.matches("form") ? source.nextElementSibling : source.firstElementChild;
  if (old && "trouble" in old.dataset) old.remove();
}

const asks = (source) => source?.isConnected && source.id !== "listen" && source.matches("[hx-get], [hx-post]");

document.addEventListener("htmx:before:request", ({ detail: { ctx } }) => asks(ctx.sourceElement) && clear(ctx.sourceElement));
document.addEventListener("htmx:finally:request", ({ detail: { ctx } }) => {
  const failed = ctx.response?.status >= 400 || ctx.status.startsWith("error"); // an error has no response: unreachable, too late
  if (failed && asks(ctx.sourceElement)) tell(ctx.sourceElement, { status: ctx.response?.status, text: ctx.text });
});

// The identity of this page: the same after it was loaded again or left and come back to, so that one's own cells stay one's own.

/** An id that nobody else can guess, of so many bytes. */
export function randomId(bytes) {
  return [...crypto.getRandomValues(new Uint8Array(bytes))].map((b) => b.toString(16).padStart(2, "0")).join("");
}

/** A page's `id`, its `client` (the id and how often it was loaded), and the id of the page that this one is perhaps a
 *  copy of (`from`): a tab that was duplicated takes along what the other keeps, and must not speak for it. */
export function identity() {
  const kept = earlier();
  const again = Boolean(kept?.left);
  const id = again ? kept.id : randomId(6);
  const loads = again ? kept.loads + 1 : 1;
  const keep = (left) => sessionStorage.setItem(PAGE, JSON.stringify({ id, loads, left }));
  keep(false);
  return { id, client: `${id}.${loads}`, from: kept?.id ?? "", leave: () => keep(true) };
}

function earlier() {
  try {
    return JSON.parse(sessionStorage.getItem(PAGE));
  } catch {
    return null;
  }
}

// Another page of this browser may have chosen another language meanwhile: what comes from now on would be in that one.

const chosen = () => /(?:^|; )rrp-language=(\w+)/.exec(document.cookie)?.[1];
document.addEventListener("visibilitychange", () => {
  const now = document.hidden ? undefined : chosen();
  if (now && now !== document.documentElement.lang) location.reload();
});

// Asking the server to do something to the run; who asks is told with it.

/** The answers in the dialog of this workbook's last run, on this machine. */
export const settings = {
  key: `run-settings ${bar?.dataset.book}`,
  kept: () => JSON.parse(localStorage.getItem(settings.key) ?? "{}"),
  keep: (wish) => localStorage.setItem(settings.key, JSON.stringify(wish)),
};

const UNNAMED = "Somebody"; // in requests and events, who has no name

/** True when a person has given a name. */
export const isNamed = (name) => Boolean(name) && name !== UNNAMED;

/** A person's name in the words of the page. */
export const shownName = (name) => (isNamed(name) ? name : t("Somebody"));

/** One's own name as the others see it; on the run panel who has none is the operator that was named in the dialog. */
export function ownName(operates = true) {
  const name = document.documentElement.dataset.visitor || localStorage.getItem("name") || UNNAMED;
  return operates && !isNamed(name) ? settings.kept().operator || name : name;
}

// What holds in which phase of a run: none, starting, running, paused, stopping, finishing, ended; looking while one looks back.
const inPhases = (...phases) => (phase) => phases.includes(phase);
export const canBeStopped = inPhases("starting", "running", "paused");
export const takesActions = inPhases("running", "paused"); // presses, marks, moves of things
export const isEnding = inPhases("stopping", "finishing");
export const isUnderWay = inPhases("running", "paused", "stopping", "finishing"); // the camera may see something new
export const hasAges = inPhases("running", "stopping", "finishing"); // the values in the rows grow older
export const hasLights = inPhases("running", "paused", "stopping", "looking"); // rows that give something light up in the diagram

/** Do an action; gives the server's answer, with a `message` and the `status` when it was refused or could not be reached. */
export async function ask(action, body = {}) {
  return answered(await request(`${panel}/${action}`, { body: { ...body, name: ownName() } }));
}

const answered = ({ ok, status, json }) => ok ? json ?? {} : { message: refusal(status), ...json, status };

/** The same, and a refusal is told in the line below the run bar. */
export async function act(action, body) {
  const answer = await ask(action, body);
  if (answer.message) document.dispatchEvent(new CustomEvent("rrp:refused", { detail: answer }));
  return answer;
}

/** The status of the answer to a Stop when no run is going. */
export const NO_RUN = 409;

/** Stop the run of whichever workbook, also one that this page has not heard of yet; `rrp:stop` tells the answer. */
export async function stop() {
  const answer = answered(await request(`/run/stop?${new URLSearchParams({ name: ownName() })}`, { body: {} }));
  document.dispatchEvent(new CustomEvent("rrp:stop", { detail: answer }));
}

// The connection on which the page is told what happens: says so when it is missing (and tells `rrp:connection`), and tries again for some
// minutes, then when somebody wants it (`rrp:again`) or looks at the page again.

export function listening(listen) {
  const notice = document.createElement("p");
  notice.id = "line-lost";
  notice.className = "line-lost";
  notice.setAttribute("role", "status");
  document.body.append(notice);

  let tries = 0;
  let last = 0;
  let stopped = false;

  const lost = (status, words) => {
    tries += 1;
    last = status;
    notice.textContent = words || (LOST[status] ?? LOST[0]);
    document.dispatchEvent(new CustomEvent("rrp:connection", { detail: { lost: true } }));
  };
  listen.addEventListener("htmx:sse:before:connection", (event) => over() && event.preventDefault());
  listen.addEventListener("htmx:sse:after:connection", () => {
    tries = 0;
    stopped = false;
    notice.textContent = "";
    document.dispatchEvent(new CustomEvent("rrp:connection", { detail: { lost: false } }));
    // htmx closes the event stream of a hidden page on "visibilitychange", but listens for that only once the stream is
    // open: a page that is hidden by now would keep it
    if (document.hidden) setTimeout(() => document.dispatchEvent(new Event("visibilitychange")));
  });
  listen.addEventListener("htmx:sse:error", ({ detail }) => lost(detail.status ?? 0)); // it tries again by itself
  listen.addEventListener("htmx:response:error", ({ detail: { ctx } }) => {
    lost(ctx.response.status, ctx.response.status === 503 ? ctx.text : "");
    again();
  });
  listen.addEventListener("htmx:error", () => {
    lost(0);
    again();
  });

  document.addEventListener("rrp:again", resume);
  document.addEventListener("visibilitychange", () => document.hidden || resume());

  /** True when it is not tried any more by itself; a button is offered then. */
  function over() {
    if (!stopped && tries && (FINAL.has(last) || tries > MOST_TRIES)) {
      stopped = true;
      notice.append(" ", button(t("Try again"), () => document.dispatchEvent(new Event("rrp:again"))));
    }
    return stopped;
  }

  function resume() {
    if (!stopped) return;
    stopped = false;
    tries = 0;
    connect();
  }

  function connect() {
    htmx.ajax("GET", listen.getAttribute("hx-sse:connect"), { source: listen, swap: "none" });
  }

  // the first connection is made once only
  function again() {
    if (over()) return;
    setTimeout(() => {
      if (document.hidden) document.addEventListener("visibilitychange", again, { once: true });
      else connect();
    }, RECONNECT_MS);
  }
}
