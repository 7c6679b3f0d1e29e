// Search of the help pages: looks through `helpSections`, which search-index.js gives, and shows the hits in their context. It is
// no module, so that it also works on pages that are opened from a disk.

(() => {
  const MOST = 40; // hits that are shown
  const CONTEXT = 160; // letters of it around a hit, where a sentence is long
  const SMALL = new Set(globalThis.helpSmallWords);

  const fields = document.querySelectorAll("input[name=q]");
  const said = document.getElementById("found");
  const list = document.querySelector(".docs-hits");
  const plain = (text) => text.normalize("NFKC").toLowerCase();
  const sections = globalThis.helpSections.map((section) => ({ ...section, titles: plain(`${section.part || section.title}`), all: plain(`${section.title} ${section.part} ${section.text}`) }));

  /** How well a section fits: 0 is best; the number of the words that it lacks counts first. */
  function rank(section, words) {
    const lacks = words.filter((word) => !section.all.includes(word)).length;
    const title = section.titles;
    const whole = words.join(" ");
    const place = title === whole ? 0 : title.startsWith(whole) ? 1 : words.every((word) => title.includes(word)) ? 2 : words.some((word) => title.includes(word)) ? 3 : 4;
    return lacks * 10 + place;
  }

  function search(text) {
    const words = plain(text).split(/[\s、。？?！!,.]+/u).filter(Boolean);
    const ranked = (wanted) => sections.map((section) => [rank(section, wanted), section]).filter(([r]) => r < wanted.length * 10).sort(([a], [b]) => a - b);
    const full = ranked(words).filter(([r]) => r < 10);
    if (full.length || !words.length) return { words, found: full.map(([, section]) => section), whole: true };
    const pieces = words.flatMap((word) => word.match(/[a-z0-9]+|\p{Script=Han}+|[\p{Script=Katakana}ー]+/gu) ?? [word]); // Japanese has no blanks
    const telling = pieces.filter((word) => (word.length > 2 || !/[a-z0-9]/.test(word)) && !SMALL.has(word)).map((word) => word.replace(/(ing|s)$/, ""));
    return { words: telling, found: ranked(telling).map(([, section]) => section), whole: false };
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
