// The line on which the page is told what happens: says so when it is missing (and tells `rrp:line`), and tries again for some
// minutes, then when somebody wants it (`rrp:again`) or looks at the page again.

import { button } from "./conflict.js";

const AGAIN = 5000; // milliseconds until the next try
const MOST = 120; // tries in a row: some ten minutes
const FINAL = new Set([403, 404]); // nothing changes by itself then
const WORDS = {
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
    line.textContent = words || (WORDS[status] ?? WORDS[0]);
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
    if (!stopped && tries && (FINAL.has(last) || tries > MOST)) {
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
    }, AGAIN);
  }
}
