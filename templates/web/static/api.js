// What is asked for by hx-* attributes: an error is told in words where the answer would have been, and never shown as if
// it were the answer (`noSwap` in parts.html). The line of events (#listen) tells of itself: grid/listening.js.

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
