/* Choosing a row, keys. */
(() => {
  const payload = JSON.parse(document.getElementById("numbers").textContent);
  const rows = payload.rows, abscissa = { name: payload.abscissa, unit: payload.abscissa_unit };
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const timeParent = document.getElementById("time-plots"), scatterParent = document.getElementById("scatter-plots");
  const buttons = all("#rows button[data-row]"), discs = all("#robot .joint[data-row]");
  let chosen = -1, state = null;

  function draw() {
    const window = state && state.window;
    if (state) state.destroy();
    state = null;
    const row = rows[chosen];
    if (timeParent && row && row.time.length > 1) state = plotRow(row, abscissa, timeParent, scatterParent, window);
  }

  function choose(index) {
    if (index < 0 || index >= rows.length || index === chosen) return;
    chosen = index;
    for (const element of buttons.concat(discs)) {
      const here = Number(element.dataset.row) === index;
      element.setAttribute("aria-pressed", String(here));
      element.setAttribute("tabindex", here ? "0" : "-1");
    }
    const row = rows[index], words = buttons[index].closest("tr").dataset.words;
    const thinned = row.time.length < row.total ? ` ${row.time.length} of ${row.total} samples are drawn, all extremes among them.` : "";
    if (timeParent) {
      document.getElementById("chosen").textContent = `${index + 1}. ${row.name}`;
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
      element.addEventListener("click", () => choose(Number(element.dataset.row)));
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
