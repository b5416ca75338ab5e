"use strict";
/* Plots of one row, drawn by uPlot. `plotRow` builds them and gives back what steers them. */

/** A style-sheet colour as a canvas understands it. */
function colour(name) {
  const probe = document.createElement("span");
  probe.style.color = `var(--${name})`;
  document.body.append(probe);
  const found = getComputedStyle(probe).color;
  probe.remove();
  return found;
}

/** A number with three significant digits. */
function number(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-5 || size >= 1e7)) return value.toExponential(2).replace(/-/g, "−");
  return String(Number(value.toPrecision(Math.max(digits, 1 + Math.floor(Math.log10(size || 1)))))).replace("-", "−");
}

const withUnit = (value, unit) => (unit && unit !== "1" ? `${number(value)}\u00a0${unit.replace(/ /g, "\u00a0")}` : number(value));
const labelled = (name, unit) => (unit && unit !== "1" ? `${name} (${unit})` : name);

function axis(label, size) {
  const soft = colour("soft"), rule = colour("rule");
  const font = "12px system-ui, sans-serif";
  const values = (_, ticks) => ticks.map((t) => (t === null ? "" : String(Number(t.toPrecision(6))).replace("-", "−")));
  return { label, stroke: soft, font, labelFont: font, labelSize: 18, size, values, grid: { stroke: rule, width: 1 }, ticks: { stroke: rule, width: 1, size: 5 } };
}

/** Band of ± two standard deviations of the noise. */
function noiseBand(noise) {
  return (u) => {
    if (!(noise > 0)) return;
    const { left, top, width, height } = u.bbox;
    const clamp = (y) => Math.min(Math.max(y, top), top + height);
    const high = clamp(u.valToPos(2 * noise, "y", true)), low = clamp(u.valToPos(-2 * noise, "y", true));
    u.ctx.save();
    u.ctx.globalAlpha = 0.25;
    u.ctx.fillStyle = colour("noise");
    u.ctx.fillRect(left, high, width, low - high);
    u.ctx.restore();
  };
}

/** A path builder that draws marks straight away: squares, or crosses for what must be told apart without colour. */
function marks(shape, name) {
  return (u, series) => {
    const { ctx, bbox } = u, xs = u.data[0], ys = u.data[series], r = devicePixelRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.fillStyle = ctx.strokeStyle = colour(name);
    ctx.globalAlpha = shape === "cross" ? 0.85 : 0.5;
    ctx.lineWidth = 1.2 * r;
    ctx.beginPath();
    for (let i = 0; i < xs.length; i++) {
      if (ys[i] === null || xs[i] === null) continue;
      const x = u.valToPos(xs[i], "x", true), y = u.valToPos(ys[i], "y", true);
      if (shape === "cross") {
        ctx.moveTo(x - 2.5 * r, y); ctx.lineTo(x + 2.5 * r, y);
        ctx.moveTo(x, y - 2.5 * r); ctx.lineTo(x, y + 2.5 * r);
      } else ctx.fillRect(x - 1.2 * r, y - 1.2 * r, 2.4 * r, 2.4 * r);
    }
    ctx.stroke();
    ctx.restore();
    return null;
  };
}

/** A box for a plot that can be focused. */
function box(parent, title, words) {
  const div = document.createElement("div"), head = document.createElement("h4");
  div.className = "plot";
  div.tabIndex = 0;
  div.setAttribute("role", "group");
  div.setAttribute("aria-label", words);
  head.textContent = title;
  div.append(head);
  parent.append(div);
  return div;
}

const widthOf = (element) => Math.max(120, Math.floor(element.clientWidth));

/** A line over time. */
function line(label, name, unit, width, dash) {
  return { label, stroke: () => colour(name), width, dash, points: { show: false }, value: (_, v) => withUnit(v, unit) };
}

function timePlot(parent, row, title, height, series, data, xLabel, abscissa, hooks, bandOfNoise) {
  const div = box(parent, title, `${title}, over ${abscissa.name}. Arrow keys move the window, plus and minus change it, 0 shows all.`);
  const options = {
    width: widthOf(div), height,
    scales: { x: { time: false } },
    legend: { markers: { dash: (u, i) => (u.series[i].dash ? "dashed" : "solid"), width: 3 } },
    cursor: { sync: { key: "time" }, drag: { x: true, y: false, setScale: true }, focus: { prox: 30 }, points: { size: 7 } },
    axes: [axis(xLabel, xLabel ? 36 : 28), axis("", 58)],
    series: [{ label: abscissa.name, value: (_, v) => (v === null ? "–" : `${Number(v.toFixed(4))} ${abscissa.unit}`) }, ...series],
    hooks: { setScale: [(u, key) => key === "x" && hooks.zoomed(u)], setCursor: [hooks.pointed], drawClear: bandOfNoise ? [noiseBand(row.noise)] : [] },
  };
  const plot = new uPlot(options, data, div);
  div.plot = plot;
  return plot;
}

function scatterPlot(div, row, signal) {
  const labels = row.after ? ["measured − nominal", row.label === "with effects" ? "explained by the effects" : "explained by the estimate"] : ["measured − nominal"];
  const series = labels.map((label, i) => ({
    label, stroke: () => colour(i ? "amended" : "nominal"), paths: marks(i ? "cross" : "square", i ? "amended" : "nominal"), points: { show: false }, value: (_, v) => withUnit(v, row.unit),
  }));
  const options = {
    width: widthOf(div), height: 260,
    scales: { x: { time: false, range: (_, low, high) => [low - 0.03 * (high - low), high + 0.03 * (high - low)] } },
    cursor: { drag: { x: true, y: true, uni: 20 } },
    legend: { show: false },
    axes: [axis(labelled(signal.name, signal.unit), 36), axis("", 58)],
    series: [{ label: signal.name, value: (_, v) => withUnit(v, signal.unit) }, ...series],
    hooks: { drawClear: [noiseBand(row.noise)] },
  };
  const plot = new uPlot(options, [[], ...labels.map(() => [])], div);
  const spot = document.createElement("div");
  spot.className = "spot";
  spot.hidden = true;
  plot.over.append(spot);
  div.plot = plot;
  return { plot, signal, spot };
}

/** Fills a scatter plot with the samples of a time window, in order of the signal. */
function fillScatter(scatter, row, low, high) {
  const fair = row.fair || row.time.map((_, i) => i), x = scatter.signal.values;
  const order = fair.filter((i) => row.time[i] >= low && row.time[i] <= high && x[i] !== null).sort((a, b) => x[a] - x[b]);
  const explained = (i) => (row.before[i] === null || row.after[i] === null ? null : row.before[i] - row.after[i]);
  const data = [order.map((i) => x[i]), order.map((i) => row.before[i])];
  if (row.after) data.push(order.map(explained));
  scatter.plot.setData(data);
}

/** Shows the sample under the cursor in a scatter plot. */
function mark(scatter, row, index) {
  const x = index === null || index === undefined ? null : scatter.signal.values[index];
  const y = x === null ? null : row.before[index];
  scatter.spot.hidden = x === null || y === null;
  if (scatter.spot.hidden) return;
  scatter.spot.style.left = `${scatter.plot.valToPos(x, "x")}px`;
  scatter.spot.style.top = `${scatter.plot.valToPos(y, "y")}px`;
}

/** All plots of several rows, below one another; they show the same times. */
function plotRows(list, abscissa, timeParent, scatterParent, window) {
  const states = [];
  const part = (parent) => parent.appendChild(document.createElement("div"));
  const follow = (min, max) => {
    for (const { plots: [plot] } of states) if (plot && (plot.scales.x.min !== min || plot.scales.x.max !== max)) plot.setScale("x", { min, max });
  };
  for (const row of list) {
    if (list.length > 1) scatterParent.appendChild(document.createElement("h4")).textContent = row.name;
    const scatters = part(scatterParent);
    scatters.className = "scatters";
    states.push(plotRow(row, abscissa, part(timeParent), scatters, window, follow));
  }
  const each = (name) => () => states.forEach((state) => state[name]());
  const first = (name) => (...values) => states[0][name](...values);
  return {
    get window() { return states[0].window; },
    zoom: first("zoom"), move: first("move"), scale: first("scale"), reset: first("reset"), resize: each("resize"),
    get plots() { return states.flatMap((state) => state.plots); },
    get scatters() { return states.flatMap((state) => state.scatters); },
    destroy() {
      each("destroy")();
      timeParent.replaceChildren();
      scatterParent.replaceChildren();
    },
  };
}

/** All plots of a row. `window`: the times that are shown, or null for all; `follow` is told of other ones. */
function plotRow(row, abscissa, timeParent, scatterParent, window, follow) {
  const first = row.time[0], last = row.time[row.time.length - 1];
  const state = { window: null, plots: [], scatters: [] };
  let timer = 0;
  const refill = () => state.scatters.forEach((s) => fillScatter(s, row, ...(state.window || [-Infinity, Infinity])));
  const hooks = {
    zoomed(u) {
      const { min, max } = u.scales.x;
      if (min === null || min === undefined) return;
      state.window = min <= first && max >= last ? null : [min, max];
      for (const other of state.plots) if (other !== u && (other.scales.x.min !== min || other.scales.x.max !== max)) other.setScale("x", { min, max });
      clearTimeout(timer);
      timer = setTimeout(refill, 120);
      follow(min, max);
    },
    pointed(u) { state.scatters.forEach((s) => mark(s, row, u.cursor.idx)); },
  };
  state.zoom = (low, high) => {
    const least = (last - first) / 5000, middle = (low + high) / 2;
    if (high - low < least) [low, high] = [middle - least / 2, middle + least / 2];
    [low, high] = high - low >= last - first ? [first, last] : low < first ? [first, first + high - low] : high > last ? [last - (high - low), last] : [low, high];
    state.plots[0].setScale("x", { min: low, max: high });
  };
  state.move = (part) => { const [a, b] = state.window || [first, last], d = part * (b - a); state.zoom(a + d, b + d); };
  state.scale = (factor) => { const [a, b] = state.window || [first, last], m = (a + b) / 2, h = ((b - a) / 2) * factor; state.zoom(m - h, m + h); };
  state.reset = () => state.zoom(first, last);
  state.destroy = () => {
    clearTimeout(timer);
    state.plots.concat(state.scatters.map((s) => s.plot)).forEach((p) => p.destroy());
    timeParent.replaceChildren();
    scatterParent.replaceChildren();
  };
  state.resize = () => {
    for (const p of state.plots.concat(state.scatters.map((s) => s.plot))) p.setSize({ width: widthOf(p.root.parentElement), height: p.height });
  };
  const minus = (a, b) => a.map((x, i) => (x === null || b[i] === null ? null : x - b[i]));
  const upper = [line("measured", "measured", row.unit, 3.5), line("nominal model", "nominal", row.unit, 1.8, [7, 3])];
  const lower = [line("measured − nominal", "nominal", row.unit, 1.2)];
  const signals = [row.time, row.measured, minus(row.measured, row.before)], errors = [row.time, row.before];
  if (row.after) {
    upper.push(line(row.label, "amended", row.unit, 1.3));
    signals.push(minus(row.measured, row.after));
    lower.push(line(`measured − ${row.label}`, "amended", row.unit, 1.2, [3, 1.5]));
    errors.push(row.after);
  }
  const what = labelled(row.name, row.unit);
  state.plots.push(timePlot(timeParent, row, `Measured and modelled: ${what}`, 270, upper, signals, "", abscissa, hooks, false));
  const band = row.noise > 0 ? `; grey: twice the noise of ${withUnit(row.noise, row.unit)}` : "";
  state.plots.push(timePlot(timeParent, row, `${labelled("Residual", row.unit)}${band}`, 210, lower, errors, labelled(abscissa.name, abscissa.unit), abscissa, hooks, true));
  // All boxes first: each is as wide as its share of the grid only when the others are there.
  const boxes = row.signals.map((signal) => box(scatterParent, `over ${signal.name}`, `Residual of ${row.name} over ${signal.name}`));
  state.scatters = row.signals.map((signal, i) => scatterPlot(boxes[i], row, signal));
  refill();
  if (window) state.zoom(Math.max(window[0], first), Math.min(window[1], last));
  return state;
}
