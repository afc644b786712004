"use strict";
const element = (tag, properties, ...inside) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...inside);
  return made;
};
for (const table of document.querySelectorAll("table:has(thead)")) {
  const body = table.tBodies[0];
  const heads = [...table.tHead.rows[0].cells];
  if (body.rows.length < 2) continue;
  const size = (text) => {
    const found = /^(<?)[^\d.]{0,4}?(\d*\.?\d+(?:e[+-]?\d+)?)/i.exec(text);
    return found ? parseFloat(found[2]) * (found[1] ? 0.99 : 1) : NaN;
  };
  heads.forEach((head, column) => {
    if (head.tagName !== "TH") return;
    const button = element("button", { type: "button" }, ...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const before = head.getAttribute("aria-sort");
      const down = before ? before === "ascending" : head.classList.contains("n");
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const rows = [...body.rows].map((row, place) => {
        const text = row.cells[column].textContent.trim();
        return { row, place, text, value: size(text) };
      });
      rows.sort((a, b) => {
        const empty = (a.text === "" || a.text === "-") - (b.text === "" || b.text === "-");
        if (empty) return empty;
        const both = !isNaN(a.value) && !isNaN(b.value);
        const order = both ? a.value - b.value : a.text.localeCompare(b.text);
        return (down ? -order : order) || a.place - b.place;
      });
      body.append(...rows.map((each) => each.row));
    });
  });
}
// A link to what is folded unfolds it.
const unfold = () => {
  const target = document.getElementById(location.hash.slice(1));
  if (target?.matches("details")) target.open = true;
};
window.addEventListener("hashchange", unfold);
unfold();
