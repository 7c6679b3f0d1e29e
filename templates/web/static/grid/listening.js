// The line on which the page is told what happens: says so when it is missing (and tells `rrp:line`), and keeps trying.

const AGAIN = 5000; // milliseconds until the next try
const WORDS = {
  403: "You are not logged in any more, or the server was started anew. Open the address that it has printed.",
  404: "The workbook was renamed or moved. Go to the shelf.",
  503: "So many pages are open that this one is not told what happens. Close another one; this one then goes on by itself.",
  0: "The server cannot be reached. This page keeps trying.",
};

export function listening(listen) {
  const line = document.createElement("p");
  line.id = "line-lost";
  line.className = "line-lost";
  line.setAttribute("role", "status");
  document.body.append(line);

  const lost = (status, words) => {
    line.textContent = words || (WORDS[status] ?? WORDS[0]);
    document.dispatchEvent(new CustomEvent("rrp:line", { detail: { lost: true } }));
  };
  listen.addEventListener("htmx:sse:after:connection", () => {
    line.textContent = "";
    document.dispatchEvent(new CustomEvent("rrp:line", { detail: { lost: false } }));
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

  // the first connection is made once only
  function again() {
    setTimeout(() => {
      if (document.hidden) document.addEventListener("visibilitychange", again, { once: true });
      else htmx.ajax("GET", listen.getAttribute("hx-sse:connect"), { source: listen, swap: "none" });
    }, AGAIN);
  }
}
