// Requests to the server, and the line on which it tells what happens: who asks, what is sent, why there was no answer.

import { button } from "./elements.js";

const SERVER = "The server cannot be reached. Check that the program is running, then try again.";
const WORDS = {
  403: "You are not logged in any more, or the program was started again. Load the page again.",
  404: "It is not there any more: somebody renamed, moved or deleted it. Load the page again.",
};

/** Why there is no answer; the server's own words where it has any. */
export function why({ response, text }) {
  if (!response) return SERVER;
  const { status } = response;
  if (status < 400) return "The answer could not be shown. Load the page again.";
  if (WORDS[status]) return WORDS[status];
  const page = new DOMParser().parseFromString(text ?? "", "text/html");
  const told = [...page.querySelectorAll("main.message > p:not(.line)")].map((p) => p.textContent.replace(/^→\s*/, ""));
  return told.join(" ") || `The server answered with an error (${status}). Try again.`;
}

/** Tell it in the place that waits for the answer, or behind the form that asked. */
function tell(source, words) {
  const line = document.createElement("p");
  line.className = "notice is-error";
  line.setAttribute("role", "alert");
  line.dataset.trouble = "";
  line.textContent = words;
  clear(source);
  if (source.matches("form")) return source.after(line);
  if (source.id === "panels") return source.prepend(line);
  const again = document.createElement("button");
  again.type = "button";
  again.className = "button small";
  again.textContent = "Try again";
  again.addEventListener("click", () => {
    source.replaceChildren("Asking again …");
    source.setAttribute("aria-busy", "true");
    htmx.ajax("GET", source.getAttribute("hx-get"), { source, target: source, swap: source.getAttribute("hx-swap") });
  });
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
  if (failed && asks(ctx.sourceElement)) tell(ctx.sourceElement, why(ctx));
});

// Who this page is: the same after it was loaded again or left and come back to, so that one's own cells stay one's own.

const PAGE = "page";

/** A page's `id`, its `client` (the id and how often it was loaded), and the id of the page that this one is perhaps a
 *  copy of (`from`): a tab that was duplicated takes along what the other keeps, and must not speak for it. */
export function identity() {
  const kept = earlier();
  const again = Boolean(kept?.left);
  const id = again ? kept.id : [...crypto.getRandomValues(new Uint8Array(6))].map((b) => b.toString(16).padStart(2, "0")).join("");
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

// Asking the server to do something to the run; who asks is told with it.

const bar = document.getElementById("runbar");

export const panel = bar?.dataset.url ?? "";

/** What was answered in the dialog of this workbook's last run, on this machine. */
export const settings = {
  key: `run-settings ${bar?.dataset.book}`,
  kept: () => JSON.parse(localStorage.getItem(settings.key) ?? "{}"),
  keep: (wish) => localStorage.setItem(settings.key, JSON.stringify(wish)),
};

/** One's own name as the others see it; on the run panel who has none is the operator that was named in the dialog. */
export function ownName(operates = true) {
  const name = document.documentElement.dataset.visitor || localStorage.getItem("name") || "Somebody";
  return name === "Somebody" && operates ? settings.kept().operator || name : name;
}

/** Do an action; answers what the server says, with a `message` when it was refused or could not be reached. */
export async function ask(action, body = {}, url = panel) {
  try {
    const response = await fetch(`${url}/${action}`, {
      method: "POST", headers: { "Content-Type": "application/json", "X-RRP": "grid" }, body: JSON.stringify({ ...body, name: ownName() }),
    });
    const answer = response.headers.get("Content-Type")?.startsWith("application/json") ? await response.json() : {};
    return response.ok ? answer : { message: `The server refused this (${response.status}). Reload the page.`, ...answer };
  } catch {
    return { message: "The server cannot be reached." };
  }
}

/** The same, and a refusal is told in the line below the run bar. */
export async function act(action, body) {
  const answer = await ask(action, body);
  if (answer.message) document.dispatchEvent(new CustomEvent("rrp:refused", { detail: answer }));
  return answer;
}

// The line on which the page is told what happens: says so when it is missing (and tells `rrp:line`), and tries again for some
// minutes, then when somebody wants it (`rrp:again`) or looks at the page again.

const RECONNECT = 5000; // milliseconds until the next try
const MOST_TRIES = 120; // tries in a row: some ten minutes
const FINAL = new Set([403, 404]); // nothing changes by itself then
const LOST = {
  403: "This browser is signed out. Open the link that the server prints, or log in; then choose Try again.",
  404: "The workbook was renamed or moved. Go to the shelf.",
  503: "So many pages are open that this one is not told what happens. Close another one; this one then goes on by itself.",
  0: "The server cannot be reached. This page tries again by itself.",
};

export function listening(listen) {
  const line = document.createElement("p");
  line.id = "line-lost";
  line.className = "line-lost";
  line.setAttribute("role", "status");
  document.body.append(line);

  let tries = 0;
  let last = 0;
  let stopped = false;

  const lost = (status, words) => {
    tries += 1;
    last = status;
    line.textContent = words || (LOST[status] ?? LOST[0]);
    document.dispatchEvent(new CustomEvent("rrp:line", { detail: { lost: true } }));
  };
  listen.addEventListener("htmx:sse:before:connection", (event) => over() && event.preventDefault());
  listen.addEventListener("htmx:sse:after:connection", () => {
    tries = 0;
    stopped = false;
    line.textContent = "";
    document.dispatchEvent(new CustomEvent("rrp:line", { detail: { lost: false } }));
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

  /** Whether it is not tried any more by itself; a button is offered then. */
  function over() {
    if (!stopped && tries && (FINAL.has(last) || tries > MOST_TRIES)) {
      stopped = true;
      line.append(" ", button("Try again", () => document.dispatchEvent(new Event("rrp:again"))));
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
    }, RECONNECT);
  }
}
