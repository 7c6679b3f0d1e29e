// What is asked before a run: for whom, under which condition, by whom, and whether it counts. The last answers stay,
// but never for whom it was: the next child's session must not be recorded as the former one's.

import { ask, ownName, panel, settings } from "./ask.js";
import { make } from "../elements.js";

const kept = ["condition", "operator", "mode", "until"];

export function dialog(root) {
  const box = document.getElementById("run-dialog");
  const form = box.querySelector("form");
  const refused = form.querySelector(".run-refused");
  let speed = "1";

  form.querySelector("[value=cancel]").addEventListener("click", () => box.close());
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const wish = Object.fromEntries(kept.map((name) => [name, form.elements[name].value.trim()]));
    settings.keep(wish);
    form.querySelector("[type=submit]").disabled = true;
    const answer = await ask("start", { ...wish, participant: form.elements.participant.value.trim(), speed: Number(speed) });
    form.querySelector("[type=submit]").disabled = false;
    if (answer.message) return refuse(answer);
    box.close();
    if (!("panel" in root.dataset)) location.assign(`${panel}/${encodeURIComponent(document.querySelector("[role=grid]")?.dataset.sheet ?? "")}`);
    return undefined;
  });

  function refuse({ message, where }) {
    refused.hidden = false;
    refused.textContent = `${message} `;
    if (where) refused.append(make("a", { href: where, textContent: "Go to that run" }));
  }

  return (wanted) => {
    speed = wanted;
    refused.hidden = true;
    const before = settings.kept();
    form.elements.participant.value = "";
    for (const name of kept) if (before[name]) form.elements[name].value = before[name];
    if (!form.elements.operator.value && ownName() !== "Somebody") form.elements.operator.value = ownName();
    box.showModal();
    form.elements.participant.focus();
  };
}
