"use strict";
(() => {
  const save = (name, type, text) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };

  // cycle: the system's colours, the other ones, the same as the system's
  const theme = document.getElementById("theme");
  const root = document.documentElement;
  const dark = () => matchMedia("(prefers-color-scheme: dark)").matches;
  const name = () => { theme.textContent = root.dataset.theme ? "Theme: " + root.dataset.theme : "Theme: system"; };
  theme.hidden = false;
  theme.addEventListener("click", () => {
    const first = dark() ? "light" : "dark";
    const second = dark() ? "dark" : "light";
    if (!root.dataset.theme) root.dataset.theme = first;
    else if (root.dataset.theme === first) root.dataset.theme = second;
    else delete root.dataset.theme;
    name();
  });
  name();

  // a table starts in its written order; a click on a heading sorts, a second click reverses; cells without a number go last
  const words = new Intl.Collator("en", { numeric: true });
  const sort = (table, column, down) => {
    const body = table.tBodies[0];
    const of = (row) => row.cells[column];
    const order = (a, b) => {
      const [x, y] = [of(a).dataset.v, of(b).dataset.v];
      if (x !== undefined && y !== undefined) return (down ? -1 : 1) * (Number(x) - Number(y));
      if (x !== undefined) return -1;
      if (y !== undefined) return 1;
      return (down ? -1 : 1) * words.compare(of(a).textContent, of(b).textContent);
    };
    [...body.rows].sort(order).forEach((row) => body.append(row));
  };
  const field = (cell) => {
    const text = cell.dataset.v ?? cell.textContent.trim();
    return /[",\n]/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text;
  };
  for (const table of document.querySelectorAll("table")) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
      head.setAttribute("aria-sort", "none");
      button.addEventListener("click", () => {
        const down = head.getAttribute("aria-sort") === "ascending";
        heads.forEach((other) => other.setAttribute("aria-sort", "none"));
        head.setAttribute("aria-sort", down ? "descending" : "ascending");
        sort(table, column, down);
      });
    });
    if (table.closest(".strip")) continue;
    const line = document.createElement("p");
    const button = document.createElement("button");
    line.className = "csv";
    button.type = "button";
    button.textContent = "Save as CSV";
    button.addEventListener("click", () => {
      const rows = [...table.rows].map((row) => [...row.cells].map(field).join(","));
      save(table.id + ".csv", "text/csv", rows.join("\n") + "\n");
    });
    line.append(button);
    table.parentElement.after(line);
  }

  const records = document.getElementById("save");
  records.hidden = false;
  records.addEventListener("click", () => {
    save("records.jsonl", "application/x-ndjson", document.getElementById("records").textContent);
  });
})();
