// Texts in the language of the page: `make texts` finds them by `t("…")` and `tn("…", "…", …)`. They are written in
// English; the page brings the translations, except for English. A place is a name in braces.

const language = globalThis.document?.documentElement.lang || "en";
const translated = JSON.parse(globalThis.document?.getElementById("texts")?.textContent ?? "{}");
const plurals = new Intl.PluralRules(language);
const PLACE = /\{(\w+)\}/g;

const filled = (text, places) => text.replace(PLACE, (place, name) => (name in places ? places[name] : place));

/** A text: `t("Row {n} is gone.", { n: 3 })`. */
export const t = (text, places = {}) => filled(translated[text] ?? text, places);

/** A text with a number `n`: `tn("{n} row", "{n} rows", { n })`. */
export function tn(one, many, places) {
  const forms = translated[one];
  return filled(forms?.[plurals.select(places.n)] ?? forms?.other ?? (places.n === 1 ? one : many), places);
}

/** Several as one text; in English with nothing but a joiner. */
export function listed(things, joiner = ", ") {
  return language === "en" ? things.join(joiner) : new Intl.ListFormat(language).format(things);
}
