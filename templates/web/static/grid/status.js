// The status line below the sheet. A message goes by itself after a time that suffices to read it; a warning stays longer,
// and an error until something else is done or it is closed. None goes while the pointer or the focus is on it, or while
// the page is out of sight.

const SHOWN = { told: 5_000, warning: 15_000, error: Infinity }; // milliseconds, besides the time to read
const LETTER = 50; // milliseconds to read a letter
const AT_LEAST = 5_000; // milliseconds that an error stays, whatever is done

const line = document.getElementById("status");
const place = line?.parentElement;
const button = place?.querySelector("button");
let left = 0; // milliseconds that the message still has
let since = 0; // when it was shown, or went on being shown
let timer = 0;

/** Show a message of a kind: `told`, `warning` or `error`. */
export function status(text, kind = "told") {
  if (!line) return;
  if (line.textContent === text && line.classList.contains("is-error")) return; // said again and again while it lasts
  line.textContent = text;
  for (const name of ["warning", "error"]) line.classList.toggle(`is-${name}`, name === kind);
  button.hidden = kind === "told" || !text;
  left = SHOWN[kind] + LETTER * text.length;
  since = Date.now();
  go();
}

/** Something else was done: an error has been seen by then, or soon. */
export function done() {
  if (!line?.classList.contains("is-error") || left !== Infinity) return;
  left = AT_LEAST;
  go();
}

function clear() {
  if (place.contains(document.activeElement)) document.querySelector("[role=grid] [tabindex='0']")?.focus({ preventScroll: true });
  line.textContent = "";
  line.classList.remove("is-warning", "is-error");
  button.hidden = true;
}

const paused = () => document.hidden || place.matches(":hover, :focus-within");

/** Count the time on, or stop counting. */
function go() {
  clearTimeout(timer);
  timer = 0;
  if (left === Infinity || !line.textContent || paused()) return;
  since = Date.now();
  timer = setTimeout(clear, left);
}

function pause() {
  if (timer) left = Math.max(0, left - (Date.now() - since));
  go();
}

button?.addEventListener("click", clear);
for (const kind of ["pointerenter", "pointerleave", "focusin"]) place?.addEventListener(kind, pause);
place?.addEventListener("focusout", () => setTimeout(pause)); // the focus is elsewhere a moment later
document.addEventListener("visibilitychange", () => place && pause());
