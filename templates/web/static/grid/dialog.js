// Dialogs of the grid's page.

import { make } from "../elements.js";

/** A dialog that is shown at once; the focus goes to its first button, and to the grid when it closes, or stays in an editor
 *  that was opened then. */
export function open(title, parts) {
  const dialog = make("dialog");
  dialog.className = "ask";
  dialog.setAttribute("aria-label", title);
  dialog.append(make("h2", title), ...parts);
  dialog.addEventListener("close", () => {
    dialog.remove();
    if (!document.activeElement?.closest(".editor")) document.querySelector("[role=grid] [tabindex='0']")?.focus({ preventScroll: true });
  });
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}
