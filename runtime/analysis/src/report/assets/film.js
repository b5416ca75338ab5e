/* The player: play, pause, scrub, speed, keys; the strip of loaded feet; plots with the time that is shown. */
(() => {
  const film = JSON.parse(document.getElementById("numbers").textContent), get = (id) => document.getElementById(id);
  const plotParent = get("film-plots"), joints = get("joints"), hasFilm = film.times.length > 0 && get("film");
  const first = film.times[0] || 0, last = film.times[film.times.length - 1] || 0;
  const views = hasFilm ? makeViews(film) : null, strip = get("strip"), scrub = get("scrub"), play = get("play"), speed = get("speed");
  let now = first, playing = false, before = 0, plots = [];

  /* Time */
  function show(time) {
    now = Math.min(Math.max(time, first), last);
    if (!hasFilm) return;
    const seen = views.draw(now);
    scrub.value = String(now);
    scrub.setAttribute("aria-valuetext", `${now.toFixed(3)} s`);
    get("now").textContent = `${now.toFixed(3)} s of ${number(last, 4)} s`;
    get("film").dataset.frame = String(seen.frame);
    if (get("limits")) {
      const [phase, ...limits] = film.said[seen.frame].map((place) => film.words[place]);
      get("limits").textContent = phase ? `${phase} — ${limits.join("; ") || "no limit is active"}` : "";
      get("limits").classList.toggle("active", limits.length > 0);
    }
    drawStrip();
    for (const plot of plots) placeHead(plot);
  }
  function frameAt(time) {
    let index = film.times.findIndex((t) => t > time + 1e-9);
    return (index < 0 ? film.times.length : index) - 1;
  }
  function step(count) {
    pause();
    const index = Math.min(Math.max(frameAt(now) + count, 0), film.times.length - 1);
    show(film.times[index]);
  }
  function tick(stamp) {
    if (!playing) return;
    const elapsed = before ? Math.min((stamp - before) / 1000, 0.1) : 0;
    before = stamp;
    show(now + elapsed * Number(speed.value));
    if (now >= last) pause(); else requestAnimationFrame(tick);
  }
  function pause() { playing = false; label(); }
  function start() {
    if (now >= last) show(first);
    playing = true; before = 0; label();
    requestAnimationFrame(tick);
  }
  function label() {
    play.textContent = playing ? "❚❚ pause" : "▶ play";
    play.setAttribute("aria-pressed", String(playing));
  }
  function faster(by) {
    speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + by, 0), speed.options.length - 1);
  }

  /* Which feet are loaded. Inset as the thumb of the slider below, so that times stand above each other. */
  const INSET = 8, ROW = 27, BAR = 12, LABELS = 16;
  const place = (time, width) => INSET + ((time - first) / (last - first || 1)) * (width - 2 * INSET);
  let ready = null;
  /** The strip without the time that is shown: drawn once for each size and theme. */
  function prepareStrip() {
    if (!strip) return;
    const r = devicePixelRatio || 1, width = strip.clientWidth, height = film.feet.length * ROW + LABELS;
    strip.style.height = `${height}px`;
    strip.width = Math.round(width * r); strip.height = Math.round(height * r);
    ready = document.createElement("canvas");
    ready.width = strip.width; ready.height = strip.height;
    const ctx = ready.getContext("2d");
    ctx.scale(r, r);
    ctx.font = "11px system-ui, sans-serif";
    film.feet.forEach((foot, i) => {
      ctx.fillStyle = colour("raised");
      ctx.fillRect(INSET, (i + 1) * ROW - BAR, width - 2 * INSET, BAR - 2);
      ctx.fillStyle = colour(foot.side === "middle" ? "soft" : foot.side);
      for (const [a, b] of foot.loaded) ctx.fillRect(place(a, width), (i + 1) * ROW - BAR, Math.max(1, place(Math.min(b, last), width) - place(a, width)), BAR - 2);
      const words = `${foot.name} loaded`;
      ctx.fillStyle = colour("ink");
      ctx.fillText(words, INSET + 5, (i + 1) * ROW - BAR - 4);
    });
    const raw = (last - first) / Math.max(2, width / 90), power = 10 ** Math.floor(Math.log10(raw || 1)), unit = power * [1, 2, 5, 10].find((k) => k * power >= raw);
    ctx.textAlign = "center"; ctx.fillStyle = colour("soft");
    for (let t = Math.ceil(first / unit - 1e-9) * unit; t <= last + 1e-9; t += unit) {
      const x = Math.min(Math.max(place(t, width), 16), width - 16);
      ctx.fillText(`${Number(t.toPrecision(6))} s`, x, height - 3);
    }
  }
  function drawStrip() {
    if (!strip || !ready) return;
    const ctx = strip.getContext("2d"), r = devicePixelRatio || 1, x = place(now, strip.clientWidth) * r;
    ctx.clearRect(0, 0, strip.width, strip.height);
    ctx.drawImage(ready, 0, 0);
    ctx.fillStyle = markColour;
    ctx.fillRect(x - r, 0, 2 * r, film.feet.length * ROW * r);
  }
  let markColour = "";

  /* Plots */
  const dashes = [undefined, [7, 3], [2, 3]];
  const names = (plot, i) => plot.title.startsWith("Vertical") ? (film.feet[i] && film.feet[i].side !== "middle" ? film.feet[i].side : "soft") : ["nominal", "amended", "ink"][i % 3];
  /* Impacts would leave nothing to see of the weight. */
  const MOST = 3 * film.weight;
  const isCut = (data) => data.title.startsWith("Vertical") && data.values.some((list) => list.some((x) => x > MOST));
  function makePlot(data) {
    const title = labelled(data.joint ? `${data.title} of ${data.joint}` : data.title, data.unit) + (isCut(data) ? ", peaks cut off" : "");
    const div = box(plotParent, title, `${title}, over time`);
    return { data, div };
  }
  function fillPlot({ data, div }) {
    const series = data.names.map((name, i) => line(name, names(data, i), data.unit, 1.6, dashes[i % 3]));
    const plot = new uPlot({
      width: widthOf(div), height: 220, scales: { x: { time: false }, ...(isCut(data) ? { y: { range: [Math.min(0, -0.05 * MOST), MOST] } } : {}) },
      legend: { markers: { dash: (u, i) => (u.series[i].dash ? "dashed" : "solid"), width: 3 } },
      cursor: { sync: { key: "time" }, drag: { x: true, y: false, setScale: true }, points: { size: 7 } },
      axes: [axis("time (s)", 36), axis("", 58)],
      series: [{ label: "time", value: (_, v) => (v === null ? "–" : `${Number(v.toFixed(4))} s`) }, ...series],
      // Axes have their size only when it is drawn.
      hooks: { setScale: [(u, key) => key === "x" && u.head && zoomed(u)], draw: [(u) => u.head && placeHead(u)] },
    }, [data.time, ...data.values], div);
    plot.head = document.createElement("div");
    plot.head.className = "head";
    plot.over.append(plot.head);
    let down = 0;
    plot.over.addEventListener("pointerdown", (event) => { down = event.clientX; });
    plot.over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - down) > 3) return;
      pause();
      show(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x"));
    });
    div.plot = plot;
    placeHead(plot);
    return plot;
  }
  /** All plots show the same time. */
  function zoomed(u) {
    const { min, max } = u.scales.x;
    for (const other of plots) if (other !== u && (other.scales.x.min !== min || other.scales.x.max !== max)) other.setScale("x", { min, max });
    placeHead(u);
  }
  function placeHead(plot) {
    const { min, max } = plot.scales.x;
    plot.head.hidden = !(now >= min && now <= max);
    plot.head.style.left = `${plot.valToPos(now, "x")}px`;
  }
  function drawPlots() {
    for (const plot of plots) plot.destroy();
    plots = [];
    if (!plotParent) return;
    plotParent.replaceChildren();
    const ticked = new Set(joints ? [...joints.querySelectorAll("input:checked")].map((box) => box.value) : []);
    const chosen = film.plots.filter((p) => p.joint === null || ticked.has(p.joint));
    // All boxes first: each is as wide as its share of the grid only when the others are there.
    plots = chosen.map(makePlot).map(fillPlot);
  }

  function draw() {
    markColour = colour("mark");
    if (hasFilm) views.prepare();
    prepareStrip();
    drawPlots();
    show(now);
  }

  if (joints) joints.addEventListener("change", drawPlots);
  if (hasFilm) {
    scrub.min = String(first); scrub.max = String(last);
    const keys = {
      " ": () => (playing ? pause() : start()), k: () => (playing ? pause() : start()),
      ArrowLeft: (e) => step(e.shiftKey ? -10 : -1), ArrowRight: (e) => step(e.shiftKey ? 10 : 1),
      Home: () => { pause(); show(first); }, End: () => { pause(); show(last); }, "<": () => faster(-1), ">": () => faster(1),
    };
    addEventListener("keydown", (event) => {
      const other = event.target.closest("select, input[type=checkbox], .plot, summary, a, button:not(#play, [data-film])");
      if (!keys[event.key] || other || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      keys[event.key](event);
    });
    // The key has done it already; a button would do it again when the key is let go.
    addEventListener("keyup", (event) => { if (event.key === " " && event.target.closest("#play, [data-film]")) event.preventDefault(); });
    play.addEventListener("click", () => (playing ? pause() : start()));
    scrub.addEventListener("input", () => { pause(); show(Number(scrub.value)); });
    for (const button of document.querySelectorAll("[data-film]")) button.addEventListener("click", () => step(button.dataset.film === "on" ? 1 : -1));
    if (strip) {
      const seek = (event) => {
        if (!event.buttons) return;
        const { left, width } = strip.getBoundingClientRect();
        pause();
        show(first + ((event.clientX - left - INSET) / (width - 2 * INSET)) * (last - first));
      };
      strip.addEventListener("pointerdown", (event) => { strip.setPointerCapture(event.pointerId); seek(event); });
      strip.addEventListener("pointermove", seek);
    }
    const solid = get("solid");
    let from = null;
    solid.addEventListener("pointerdown", (event) => { solid.setPointerCapture(event.pointerId); from = [event.clientX, event.clientY]; });
    solid.addEventListener("pointermove", (event) => {
      if (!event.buttons || !from) return;
      views.turn((from[0] - event.clientX) * 0.01, (event.clientY - from[1]) * 0.01);
      from = [event.clientX, event.clientY];
      show(now);
    });
    label();
  }
  steerTheme(draw, draw);
})();
