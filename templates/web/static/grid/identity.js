// Who this page is: the same after it was loaded again or left and come back to, so that one's own cells stay one's own.

const PLACE = "page";

/** A page's `id`, its `client` (the id and how often it was loaded), and the id of the page that this one is perhaps a
 *  copy of (`from`): a tab that was duplicated takes along what the other keeps, and must not speak for it. */
export function identity() {
  const kept = read();
  const again = Boolean(kept?.left);
  const id = again ? kept.id : [...crypto.getRandomValues(new Uint8Array(6))].map((b) => b.toString(16).padStart(2, "0")).join("");
  const loads = again ? kept.loads + 1 : 1;
  const keep = (left) => sessionStorage.setItem(PLACE, JSON.stringify({ id, loads, left }));
  keep(false);
  return { id, client: `${id}.${loads}`, from: kept?.id ?? "", leave: () => keep(true) };
}

function read() {
  try {
    return JSON.parse(sessionStorage.getItem(PLACE));
  } catch {
    return null;
  }
}
