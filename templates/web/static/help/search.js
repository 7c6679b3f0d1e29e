// Search of the help pages: looks through `helpSections`, which search-index.js gives, and shows the hits in their context. It is
// no module, so that it also works on pages that are opened from a disk.

(() => {
  const MOST = 40; // hits that are shown
  const BEST = 4; // points of a word of a name
  const CONTEXT = 160; // letters of it around a hit, where a sentence is long
  const SMALL = new Set(globalThis.helpSmallWords);

  const fields = document.querySelectorAll("input[name=q]");
  const said = document.getElementById("found");
  const list = document.querySelector(".docs-hits");
  const plain = (text) => text.normalize("NFKC").toLowerCase();
  const WORD = /[\p{Script=Han}\p{Script=Hiragana}\p{Script=Katakana}ー々]+|(?:(?![\p{Script=Han}\p{Script=Hiragana}\p{Script=Katakana}ー々])[\p{L}\p{N}])+/gu;
  const PIECE = /[\p{Script=Han}々]+|[\p{Script=Katakana}ー]+|\p{Script=Hiragana}{4,}/gu;
  const isLatin = (word) => /^[ -~]*$/.test(word);
  const wordsOf = (text) => plain(text).match(WORD) ?? [];
  const sections = globalThis.helpSections.map((section) => {
    const names = [(section.part || section.title).replace(/\s*[（(].*/u, ""), ...section.words];
    const apart = names.map((name) => `${name.replace(/([a-z])(?=[A-Z])/g, "$1 ")} ${name}`); // combineLatest
    const all = plain(`${section.title} ${section.part} ${section.text}`);
    const titles = [names[0], ...section.others.map((anchor) => anchor.replaceAll("-", " "))].map(plain);
    return { ...section, titles, names: [...new Set(apart.flatMap(wordsOf).map(stem))], all };
  });

  /** A word without its English ending. */
  function stem(word) {
    const bare = word.replace(/(?:ing|(?<!e)ed|s)$/, "");
    if (bare.length < 3) return word;
    return bare !== word && bare.length > 3 && bare.at(-1) === bare.at(-2) ? bare.slice(0, -1) : bare;
  }

  /** The words of a query that tell what is asked for, each without its ending. */
  function asked(text) {
    const words = wordsOf(text);
    const telling = words.filter((word) => !SMALL.has(word) && (word.length > 2 || !isLatin(word)));
    return [...new Set((telling.length ? telling : words).map(stem))];
  }

  /** True when a Japanese word holds another one, or begins as it does. */
  const alike = (word, name) => name.includes(word) || (name.length > 1 && word.includes(name)) || (word.length > 3 && name.length > 3 && word.slice(0, 3) === name.slice(0, 3));

  /** How well a word fits a section: BEST for one of its names and plain words, 0 when it is nowhere. */
  function points({ names, all }, word) {
    if (names.includes(word)) return BEST;
    if (names.some((name) => name.startsWith(word))) return 3;
    if (!isLatin(word) && names.some((name) => alike(word, name))) return 2;
    return all.includes(word) ? 1 : 0;
  }

  /** The sections with some of the words; those that lack the fewest come first, then those that they fit best. */
  function ranked(words, whole) {
    const found = sections.map((section) => {
      const other = !section.titles.includes(whole);
      const each = words.map((word) => other ? points(section, word) : BEST);
      return { section, lacks: each.filter((n) => !n).length, other, sum: each.reduce((a, b) => a + b, 0) };
    });
    return found.filter(({ lacks }) => lacks < words.length).sort((a, b) => a.other - b.other || a.lacks - b.lacks || b.sum - a.sum);
  }

  function search(text) {
    const words = asked(text);
    let [used, found] = [words, ranked(words, plain(text).trim())];
    if (!found.length) {
      used = words.flatMap((word) => (isLatin(word) ? [word] : word.match(PIECE) ?? [])); // Japanese has no blanks
      found = ranked(used, "");
    }
    const full = found.filter(({ lacks }) => !lacks);
    return { words: used, found: (full.length ? full : found).map(({ section }) => section), whole: Boolean(full.length) };
  }

  /** The sentence of a text with the first of the words, or the beginning of the text. */
  function context(text, words) {
    const small = text.toLowerCase();
    const places = small.length === text.length ? words.map((word) => small.indexOf(word)).filter((at) => at >= 0) : [];
    const at = places.length ? Math.min(...places) : 0;
    const before = Math.max(text.lastIndexOf("\n", at), text.lastIndexOf(". ", at), text.lastIndexOf("。", at)) + 1;
    const start = Math.max(before, at - CONTEXT);
    const ends = ["\n", ". ", "。"].map((end) => text.indexOf(end, at)).filter((end) => end >= 0);
    const end = Math.min(...ends.map((e) => e + 1), at + CONTEXT, text.length);
    return `${start > before ? "…" : ""}${text.slice(start, end).trim()}${end === at + CONTEXT && end < text.length ? "…" : ""}`;
  }

  /** The text with the words marked, as nodes. */
  function marked(text, words) {
    const found = words.map((word) => word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&")).sort((a, b) => b.length - a.length);
    if (!found.length) return [text];
    return text.split(new RegExp(`(${found.join("|")})`, "giu")).filter(Boolean).map((part, n) => {
      if (!words.includes(plain(part))) return part;
      const mark = document.createElement("mark");
      mark.textContent = part;
      return mark;
    });
  }

  function hit(section, words) {
    const item = document.createElement("li");
    const link = document.createElement("a");
    link.href = section.page + (section.anchor ? `#${section.anchor}` : "");
    link.append(...marked(section.part && section.part !== section.title ? `${section.title} › ${section.part}` : section.title, words));
    const line = document.createElement("p");
    line.append(...marked(context(section.text, words), words));
    item.append(link, line);
    return item;
  }

  function show(text) {
    const { words, found, whole } = search(text);
    const template = !text.trim() ? "" : !found.length ? said.dataset.none : whole ? said.dataset.found : said.dataset.some;
    said.textContent = template.replace("{words}", () => text.trim()).replace("{n}", found.length);
    list.replaceChildren(...(text.trim() ? found.slice(0, MOST) : []).map((section) => hit(section, words)));
  }

  const query = new URLSearchParams(location.search);
  const first = (query.get("q") ?? "").slice(0, 200);
  for (const field of fields) {
    field.value = first;
    field.addEventListener("input", () => show(field.value));
  }
  show(first);
})();
