// The edge between the sheet and what stands beside it: dragged, or moved with the arrow keys; the browser remembers it.

const PLACE = "beside";
const STEP = 16;

export function splitter() {
  const sheet = document.querySelector(".workbench > .sheet");
  const panels = document.getElementById("panels");
  if (!sheet || !panels) return;
  const bar = document.createElement("div");
  bar.className = "splitter";
  bar.tabIndex = 0;
  for (const [name, value] of Object.entries({
    role: "separator", "aria-orientation": "vertical", "aria-label": "Width of the sheet", "aria-controls": "panels", "aria-valuemin": 0, "aria-valuemax": 100,
  })) bar.setAttribute(name, value);
  sheet.append(bar);
  const kept = Number(localStorage.getItem(PLACE));
  if (kept) set(kept);
  else tell();

  bar.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    bar.setPointerCapture(event.pointerId);
    bar.focus();
    const right = panels.getBoundingClientRect().right;
    const move = (now) => set(right - now.clientX);
    bar.addEventListener("pointermove", move);
    bar.addEventListener("lostpointercapture", () => bar.removeEventListener("pointermove", move), { once: true });
  });
  bar.addEventListener("dblclick", () => {
    localStorage.removeItem(PLACE);
    document.documentElement.style.removeProperty("--beside");
    tell();
  });
  bar.addEventListener("keydown", (event) => {
    const wide = panels.offsetWidth;
    const to = { ArrowLeft: wide + STEP, ArrowRight: wide - STEP, Home: innerWidth, End: 0 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    set(to);
  });

  function set(width) {
    const wide = Math.round(Math.min(Math.max(width, 200), Math.max(innerWidth - 360, 200)));
    document.documentElement.style.setProperty("--beside", `${wide}px`);
    localStorage.setItem(PLACE, wide);
    tell();
  }

  function tell() {
    bar.setAttribute("aria-valuenow", Math.round((100 * sheet.offsetWidth) / Math.max(innerWidth, 1)));
  }
}
