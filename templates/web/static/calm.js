// Whether what moves is to be still: as the system says it, or as the setting in the page's menu (`data-calm` of the document).

const system = matchMedia("(prefers-reduced-motion: reduce)");

/** True when nothing is to move by itself. */
export const hasCalm = () => system.matches || document.documentElement.dataset.calm === "yes";
