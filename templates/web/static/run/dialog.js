// What is asked before a run: for whom, under which condition, by whom, and whether it counts. The last answers stay.

import { ask, ownName, panel } from "./ask.js";
import { make } from "./make.js";

const kept = ["participant", "condition", "operator", "mode", "until"];

export function dialog(root) {
  const box = document.getElementById("run-dialog");
  const form = box.querySelector("form");
  const refused = form.querySelector(".run-refused");
  const key = `run-settings ${root.dataset.book}`;
  let speed = "1";

  form.querySelector("[value=cancel]").addEventListener("click", () => box.close());
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const wish = Object.fromEntries(kept.map((name) => [name, form.elements[name].value.trim()]));
    localStorage.setItem(key, JSON.stringify(wish));
    form.querySelector("[type=submit]").disabled = true;
    const answer = await ask("start", { ...wish, speed: Number(speed) });
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
    const before = JSON.parse(localStorage.getItem(key) ?? "{}");
    for (const name of kept) if (before[name]) form.elements[name].value = before[name];
    if (!form.elements.operator.value && ownName() !== "Somebody") form.elements.operator.value = ownName();
    box.showModal();
    form.elements.participant.select();
  };
}
