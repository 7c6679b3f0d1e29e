// Files that are made when they are asked for: that takes some seconds, and is told until the browser has them.

const AFTER = 500; // ms: what is quicker needs no word
const EVERY = 250;
const MOST = 300; // s

/** A word that the server gives back, as a cookie, with the file. */
function token() {
  return Array.from(crypto.getRandomValues(new Uint8Array(8)), (n) => n.toString(16).padStart(2, "0")).join("");
}

function place() {
  const said = document.createElement("p");
  said.className = "making";
  said.setAttribute("role", "status");
  document.body.append(said);
  return said;
}

/** Tell what a page that comes takes its time for; one that one comes back to says it no longer. */
function look(words) {
  const said = place();
  setTimeout(() => said.append(words), AFTER);
  addEventListener("pageshow", () => said.remove(), { once: true });
}

/** Tell that a file is being made, until its answer has come. */
function tell(word) {
  const began = Date.now();
  const said = place();
  const timer = setInterval(() => {
    const seconds = Math.floor((Date.now() - began) / 1000);
    const came = document.cookie.includes(`made-${word}=`);
    if (came || seconds > MOST) {
      clearInterval(timer);
      said.remove();
      return;
    }
    if (!said.firstChild && Date.now() - began > AFTER) said.append("The file is being made …", document.createElement("span"));
    if (said.firstChild && seconds > 1) said.lastChild.textContent = ` ${seconds} s`; // the words are spoken once
  }, EVERY);
}

/** Links and buttons that ask for such a file say so. */
export function made(root) {
  root.addEventListener("click", (event) => {
    const link = event.target.closest("a[data-made], a[data-looks]");
    if (!link) return;
    if (link.dataset.looks) {
      if (!event.ctrlKey && !event.metaKey && !event.shiftKey) look(link.dataset.looks); // else it opens elsewhere
      return;
    }
    const word = token();
    const address = new URL(link.href);
    address.searchParams.set("made", word);
    link.href = address;
    tell(word);
  });
  root.addEventListener("submit", (event) => {
    const form = event.target;
    form.querySelector("[name=made]")?.remove();
    if (event.submitter?.dataset.looks) look(event.submitter.dataset.looks);
    if (!event.submitter?.matches("[data-made]") || !form.querySelector("[name=run]:checked")) return;
    const field = document.createElement("input");
    Object.assign(field, { type: "hidden", name: "made", value: token() });
    form.append(field);
    tell(field.value);
  });
}
