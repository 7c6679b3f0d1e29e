// Asking the server to do something to the run; who asks is told with it.

const bar = document.getElementById("runbar");

export const panel = bar?.dataset.url ?? "";

/** What was answered in the dialog of this workbook's last run, on this machine. */
export const settings = {
  key: `run-settings ${bar?.dataset.book}`,
  kept: () => JSON.parse(localStorage.getItem(settings.key) ?? "{}"),
  keep: (wish) => localStorage.setItem(settings.key, JSON.stringify(wish)),
};

/** One's own name as the others see it; on the run panel who has none is the operator that was named in the dialog. */
export function ownName(operates = true) {
  const name = document.documentElement.dataset.visitor || localStorage.getItem("name") || "Somebody";
  return name === "Somebody" && operates ? settings.kept().operator || name : name;
}

/** Do an action; answers what the server says, with a `message` when it was refused or could not be reached. */
export async function ask(action, body = {}, url = panel) {
  try {
    const response = await fetch(`${url}/${action}`, {
      method: "POST", headers: { "Content-Type": "application/json", "X-RRP": "grid" }, body: JSON.stringify({ ...body, name: ownName() }),
    });
    const answer = response.headers.get("Content-Type")?.startsWith("application/json") ? await response.json() : {};
    return response.ok ? answer : { message: `The server refused this (${response.status}). Reload the page.`, ...answer };
  } catch {
    return { message: "The server cannot be reached." };
  }
}

/** The same, and a refusal is told in the line below the run bar. */
export async function act(action, body) {
  const answer = await ask(action, body);
  if (answer.message) document.dispatchEvent(new CustomEvent("rrp:refused", { detail: answer }));
  return answer;
}
