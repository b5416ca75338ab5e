/* Choosing a row, keys. */
(() => {
  const payload = JSON.parse(document.getElementById("numbers").textContent);
  const rows = payload.rows, abscissa = { name: payload.abscissa, unit: payload.abscissa_unit };
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const timeParent = document.getElementById("time-plots"), scatterParent = document.getElementById("scatter-plots");
  const buttons = all("#rows button[data-row]"), discs = all("#robot .joint[data-row]");
  const boxes = all("#rows input[data-also]"), also = new Set();
  let chosen = -1, state = null;

  function draw() {
    const window = state && state.window;
    if (state) state.destroy();
    state = null;
    const shown = [chosen, ...[...also].sort((a, b) => a - b)].map((index) => rows[index]).filter((row) => row && row.time.length > 1);
    if (timeParent && shown.length) state = plotRows(shown, abscissa, timeParent, scatterParent, window);
  }

  /** Marks what is shown: one row in words, others beside it in plots alone. */
  function markRows() {
    for (const element of buttons.concat(discs)) {
      const index = Number(element.dataset.row), main = index === chosen;
      element.setAttribute("aria-pressed", String(main || also.has(index)));
      element.setAttribute("tabindex", main ? "0" : "-1");
    }
    for (const box of boxes) {
      const index = Number(box.dataset.also);
      box.checked = index === chosen || also.has(index);
    }
    if (!timeParent) return;
    const more = [...also].sort((a, b) => a - b).map((index) => `${index + 1}. ${rows[index].name}`);
    document.getElementById("chosen").textContent = [`${chosen + 1}. ${rows[chosen].name}`, ...more].join(", ");
  }

  /** Shows a row beside the others, or no longer; one always stays. */
  function toggle(index) {
    if (index < 0 || index >= rows.length) return;
    if (index !== chosen) {
      if (!also.delete(index)) also.add(index);
    } else if (also.size) {
      const next = Math.min(...also);
      also.delete(next);
      return choose(next, true);
    }
    markRows();
    draw();
  }

  function choose(index, keep) {
    if (index < 0 || index >= rows.length || (index === chosen && !also.size)) return;
    if (!keep) also.clear();
    chosen = index;
    markRows();
    const row = rows[index], words = buttons[index].closest("tr").dataset.words;
    const thinned = row.time.length < row.total ? ` ${row.time.length} of ${row.total} samples are drawn, all extremes among them.` : "";
    if (timeParent) {
      document.getElementById("chosen-numbers").textContent = words + thinned;
      document.getElementById("chosen-note").textContent = row.note;
      showParts(row);
    }
    draw();
  }

  /** The error by what the joint was doing. */
  function showParts(row) {
    const parent = document.getElementById("parts");
    parent.replaceChildren();
    if (!row.parts.length) return;
    const table = document.createElement("table");
    const heads = row.after ? ["while", "samples", "error, nominal", row.label] : ["while", "samples", "error, nominal"];
    const fill = (section, cells, kind) => {
      const tr = section.insertRow();
      cells.forEach((text, i) => {
        const cell = document.createElement(kind || (i ? "td" : "th"));
        cell.textContent = text;
        if (i) cell.className = "number";
        else cell.scope = kind ? "col" : "row";
        tr.append(cell);
      });
    };
    table.createCaption().textContent = `Error of ${row.name}, root mean square`;
    fill(table.createTHead(), heads, "th");
    const body = table.createTBody();
    for (const p of row.parts) {
      const cells = [p.name, String(p.samples), withUnit(p.before, row.unit)];
      fill(body, row.after ? [...cells, withUnit(p.after, row.unit)] : cells);
    }
    parent.append(table);
  }

  /* Arrow keys walk through the rows in the table as in the drawing; one tab stop each. */
  function walk(elements) {
    for (const element of elements) {
      element.addEventListener("click", (event) => {
        const index = Number(element.dataset.row);
        if (event.ctrlKey || event.metaKey || event.shiftKey) toggle(index); else choose(index);
      });
      element.addEventListener("keydown", (event) => {
        const here = elements.findIndex((e) => e === element);
        const step = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 }[event.key];
        let next = null;
        if (step) next = (here + step + elements.length) % elements.length;
        else if (event.key === "Home") next = 0;
        else if (event.key === "End") next = elements.length - 1;
        else if ((event.key === "Enter" || event.key === " ") && element.tagName !== "BUTTON") next = here;
        if (next === null) return;
        event.preventDefault();
        choose(Number(elements[next].dataset.row));
        elements[next].focus();
      });
    }
  }
  for (const box of boxes) box.addEventListener("change", () => toggle(Number(box.dataset.also)));
  for (const disc of discs) {
    disc.setAttribute("role", "button");
    disc.setAttribute("aria-label", disc.querySelector("title").textContent);
  }
  discs.sort((a, b) => a.dataset.row - b.dataset.row);
  walk(buttons);
  walk(discs);

  for (const button of all("[data-show]")) button.addEventListener("click", () => {
    for (const other of all("[data-show]")) other.setAttribute("aria-pressed", String(other === button));
    for (const disc of discs) disc.setAttribute("class", `joint u${disc.dataset[button.dataset.show]}`);
  });

  /* Copying: where the browser refuses it, the command stands marked, to be copied by keys. */
  for (const button of all("[data-copy]")) {
    const code = button.parentElement.querySelector("code");
    button.hidden = false;
    button.addEventListener("click", () => {
      getSelection().selectAllChildren(code);
      button.textContent = document.execCommand("copy") ? "Copied" : "Marked";
      setTimeout(() => { button.textContent = "Copy"; }, 1500);
    });
  }

  const actions = {
    in: () => state.scale(0.5), out: () => state.scale(2), left: () => state.move(-0.25), right: () => state.move(0.25), reset: () => state.reset(),
  };
  for (const button of all("[data-plot]")) button.addEventListener("click", () => state && actions[button.dataset.plot]());
  const keys = { ArrowLeft: "left", ArrowRight: "right", "+": "in", "=": "in", "-": "out", 0: "reset", Escape: "reset" };
  if (timeParent) timeParent.addEventListener("keydown", (event) => {
    if (!state || !keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[keys[event.key]]();
  });
  if (timeParent) steerByPointer(timeParent, () => state);

  steerTheme(draw, () => state && state.resize());
  if (rows.length) choose(Number(document.getElementById("rows").dataset.first));
})();
