// Keys that work anywhere on the page: twice Esc stops the run, 1 to 9 press the operator's buttons.

const TWICE = 600; // ms between the two presses of Esc
const going = ["starting", "running", "paused"];
const fields = "input:not([type=range], [type=checkbox], [type=radio]), textarea, select, [role=grid], dialog, .editor";

/** Twice Esc stops the run whose state `state` gives. */
export function stopKeys(state, stop) {
  let first = -TWICE;
  document.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") {
      first = -TWICE;
      return;
    }
    if (event.repeat) return;
    if (event.timeStamp - first < TWICE && going.includes(state().phase)) stop();
    first = event.timeStamp;
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
