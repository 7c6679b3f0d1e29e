// Keys that work anywhere on the page: twice Esc stops the run, 1 to 9 press the operator's buttons.

const TWICE = 1500; // ms between the two presses of Esc: time for a slow hand, too
const fields = "input:not([type=range], [type=checkbox], [type=radio]), textarea, select, [role=grid], dialog, .editor";

/** Whether a run in this phase can be stopped. */
export function going(phase) {
  return ["starting", "running", "paused"].includes(phase);
}

/** Twice Esc stops, wherever the focus is. */
export function stopKeys(stop) {
  let first = -TWICE;
  window.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") {
      first = -TWICE;
    } else if (!event.repeat) {
      const twice = event.timeStamp - first < TWICE;
      first = twice ? -TWICE : event.timeStamp;
      if (twice) stop();
    }
  }, { capture: true });
}

/** 1 to 9 press the buttons of a place, unless one is typing. */
export function numberKeys(place) {
  document.addEventListener("keydown", (event) => {
    if (!/^[1-9]$/.test(event.key) || event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target.closest?.(fields)) return;
    const button = place.querySelectorAll("button")[Number(event.key) - 1];
    if (!button || button.disabled) return;
    event.preventDefault();
    button.click();
  });
}
