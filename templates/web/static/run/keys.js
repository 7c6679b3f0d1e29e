// Keys that work anywhere on the page: twice Esc stops the run, 1 to 9 press the operator's buttons.

import { act } from "./ask.js";

const TWICE = 600; // ms between the two presses of Esc
const going = ["starting", "running", "paused"];

export function stopKeys(state) {
  let first = -TWICE;
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      if (event.timeStamp - first < TWICE && going.includes(state().phase)) act("stop");
      first = event.repeat ? -TWICE : event.timeStamp;
      return;
    }
    first = -TWICE;
    if (!/^[1-9]$/.test(event.key) || event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target.closest("input:not([type=range], [type=checkbox]), textarea, select, [role=grid], dialog, .editor")) return;
    const button = document.querySelectorAll("#press button")[Number(event.key) - 1];
    if (button && !button.disabled) {
      event.preventDefault();
      button.click();
    }
  }, { capture: true });
}
