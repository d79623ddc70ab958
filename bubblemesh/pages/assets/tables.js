// Tables sorted by a click on a column's head: numbers by value, text by the alphabet, gaps last. What belongs together
// is a body of the table, sorted by its first row.

document.documentElement.classList.add("scripted");

function sortBodies(table, column, ascending) {
  const bodies = [...table.tBodies];
  const numeric = table.tHead.rows[0].cells[column].dataset.kind === "number";
  const value = (body) => body.rows[0].cells[column].dataset.value;
  const order = (a, b) => (numeric ? Number(a) - Number(b) : a.localeCompare(b, "en", { numeric: true }));
  const missing = (text) => text === undefined || text === "";
  bodies.sort((first, second) => {
    const [a, b] = [value(first), value(second)];
    if (missing(a) || missing(b)) return missing(a) - missing(b);
    return ascending ? order(a, b) : order(b, a);
  });
  table.append(...bodies);
}

for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((cell, column) => {
    cell.querySelector("button")?.addEventListener("click", () => {
      const ascending = cell.getAttribute("aria-sort") !== "ascending";
      for (const other of heads) other.removeAttribute("aria-sort");
      cell.setAttribute("aria-sort", ascending ? "ascending" : "descending");
      sortBodies(table, column, ascending);
    });
  });
}
