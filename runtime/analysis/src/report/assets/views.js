/* Views of the robot on canvases: side, front, above, and one in space. World axes: x forward, y left, z up, metres. */

/** Turns a vector by a quaternion x y z w at `at` in an array of whole numbers. */
function placer(pose, at, film) {
  const p = [0, 1, 2].map((i) => pose[at + i] / film.per_metre);
  let [x, y, z, w] = [3, 4, 5, 6].map((i) => pose[at + i]);
  const n = 1 / Math.hypot(x, y, z, w);
  x *= n; y *= n; z *= n; w *= n;
  const m = [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)];
  return ([a, b, c]) => [p[0] + m[0] * a + m[1] * b + m[2] * c, p[1] + m[3] * a + m[4] * b + m[5] * c, p[2] + m[6] * a + m[7] * b + m[8] * c];
}

/** Seven numbers between two frames: linear, quaternions by the shorter way. */
function between(a, b, part) {
  if (!part) return a;
  const out = new Array(a.length);
  for (let i = 0; i < a.length; i += 7) {
    const same = a[i + 3] * b[i + 3] + a[i + 4] * b[i + 4] + a[i + 5] * b[i + 5] + a[i + 6] * b[i + 6] < 0 ? -1 : 1;
    for (let k = 0; k < 7; k++) out[i + k] = a[i + k] + part * ((k > 2 ? same : 1) * b[i + k] - a[i + k]);
  }
  return out;
}

/** What is seen at a time. Poses are taken between frames, forces are those of the nearest one. */
function scene(film, time) {
  const { times } = film;
  let low = 0, high = times.length - 1;
  while (high - low > 1) { const m = (low + high) >> 1; if (times[m] <= time) low = m; else high = m; }
  const gap = times[high] - times[low], part = gap > 0 ? Math.min(Math.max((time - times[low]) / gap, 0), 1) : 0;
  const near = part < 0.5 ? low : high, pose = between(film.poses[low], film.poses[high], part);
  const places = [], world = (p) => p;
  for (let i = 0; i < pose.length; i += 7) places.push(placer(pose, i, film));
  const at = (body, p) => (body === null ? world : places[body])(p);
  const forces = film.points.map((point, i) => ({
    foot: point.foot, at: at(point.body, point.place), force: [0, 1, 2].map((k) => (film.forces[near][3 * i + k] || 0) / film.per_newton),
  }));
  const metres = (list) => list.map((x) => x / film.per_metre);
  const center = film.centers[low].map((x, k) => (x + part * (film.centers[high][k] - x)) / film.per_metre);
  return { at, forces, center, pressure: film.pressures[near].length ? metres(film.pressures[near]) : null, balance: film.words.length && film.balance[near].length ? metres(film.balance[near]) : null, frame: near };
}

/** Corners of all parts, their depth in the view, and the outward light of their faces. */
function solids(film, seen, view) {
  const list = film.parts.map((part) => {
    const world = part.corners.map((c) => seen.at(part.body, c)), drawn = world.map(view.project);
    let depth = 0;
    for (const d of drawn) depth += d[2] / drawn.length;
    return { part, world, drawn, depth };
  });
  return list.sort((a, b) => a.depth - b.depth);
}

/** Part of full light on a face: from above, from the front right. */
function light([a, b, c]) {
  const u = [0, 1, 2].map((k) => b[k] - a[k]), v = [0, 1, 2].map((k) => c[k] - b[k]);
  const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...n) || 1;
  return 0.78 + (0.22 * (0.35 * n[0] - 0.45 * n[1] + 0.82 * n[2])) / length;
}

const shaded = (rgb, part) => `rgb(${rgb.map((x) => Math.round(Math.min(255, x * part))).join(" ")})`;

/** Convex outline of points in the plane (Andrew's monotone chain). */
function outline(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1) {
        const [o, a] = chain.slice(-2);
        if ((a[0] - o[0]) * (p[1] - o[1]) - (a[1] - o[1]) * (p[0] - o[0]) > 0) break;
        chain.pop();
      }
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  const all = [...half(sorted), ...half(sorted.reverse())];
  return all.length ? all : points;
}

/** A canvas with a way of looking. `project` gives right, up, towards the viewer in metres; pixels follow from `window`. */
class View {
  constructor(canvas, project, film, size) {
    Object.assign(this, { canvas, project, film, size, ctx: canvas.getContext("2d") });
  }
  /** Fits the canvas to its box; colours are those of the theme now. */
  prepare() {
    const r = devicePixelRatio || 1, { canvas } = this;
    this.width = canvas.clientWidth; this.height = canvas.clientHeight;
    canvas.width = Math.round(this.width * r); canvas.height = Math.round(this.height * r);
    this.ctx.setTransform(r, 0, 0, r, 0, 0);
    const rgb = (name) => (colour(name).match(/[\d.]+/g) || [0, 0, 0]).slice(0, 3).map(Number);
    this.colours = Object.fromEntries(["left", "right", "middle"].map((name) => [name, rgb(name)]));
    for (const name of ["force", "polygon", "mark", "ink", "soft", "rule", "paper", "raised", "amended"]) this.colours[name] = colour(name);
  }
  /** Shows `size` metres (across, up) around a middle. */
  look(middle) {
    this.middle = middle;
    this.scale = Math.min((this.width - 16) / this.size[0], (this.height - 40) / this.size[1]);
  }
  px(p) {
    return [this.width / 2 + (p[0] - this.middle[0]) * this.scale, this.height / 2 + 8 - (p[1] - this.middle[1]) * this.scale];
  }
  at(point) { return this.px(this.project(point)); }
  path(points, close = true) {
    const { ctx } = this;
    ctx.beginPath();
    points.forEach((p, i) => (i ? ctx.lineTo(p[0], p[1]) : ctx.moveTo(p[0], p[1])));
    if (close) ctx.closePath();
  }
  stroke(style, width) { Object.assign(this.ctx, { strokeStyle: style, lineWidth: width, lineJoin: "round", lineCap: "round" }); this.ctx.stroke(); }
  fill(style, alpha = 1) { this.ctx.globalAlpha = alpha; this.ctx.fillStyle = style; this.ctx.fill(); this.ctx.globalAlpha = 1; }

  robot(seen, alpha = 1) {
    const { ctx, colours } = this;
    ctx.globalAlpha = alpha;
    for (const { part, world, drawn } of solids(this.film, seen, this)) {
      const spots = drawn.map((d) => this.px(d)), base = colours[part.side];
      if (!part.faces.length) {
        this.path(spots, false);
        this.stroke(shaded(base, 0.95), Math.max(2, part.width * this.scale));
        continue;
      }
      for (const face of part.faces) {
        let area = 0;
        face.forEach((index, i) => {
          const p = spots[index], q = spots[face[(i + 1) % face.length]];
          area += p[0] * q[1] - p[1] * q[0];
        });
        // Pixels count downwards: faces that look at us go round the other way.
        if (area >= 0) continue;
        const style = shaded(base, light(face.slice(0, 3).map((i) => world[i])));
        this.path(face.map((i) => spots[i]));
        ctx.fillStyle = style;
        ctx.fill();
        this.stroke(style, 0.6);
      }
    }
    ctx.globalAlpha = 1;
  }

  /** The hull of the loaded contact points. */
  polygon(seen) {
    const least = 0.002 * this.film.weight, closed = seen.forces.filter((f) => f.force[2] > least);
    if (!closed.length) return;
    const corners = outline(closed.map((f) => this.at([f.at[0], f.at[1], 0])));
    this.path(corners);
    this.fill(this.colours.polygon, 0.2);
    this.stroke(this.colours.polygon, 1.6);
  }

  arrow(from, force, width) {
    const { ctx } = this, per = this.arrowLength / this.film.weight, size = Math.hypot(...force) * per;
    const cut = Math.min(1, (2.4 * this.arrowLength) / (size || 1));
    const to = this.at([0, 1, 2].map((k) => from[k] + cut * per * force[k])), a = this.at(from);
    const d = [to[0] - a[0], to[1] - a[1]], length = Math.hypot(...d);
    if (length < 2) return;
    const e = [d[0] / length, d[1] / length], head = Math.min(4.2 * width, length), neck = [to[0] - head * e[0], to[1] - head * e[1]];
    this.path([a, neck], false);
    this.stroke(this.colours.force, width);
    this.path([to, [neck[0] - 0.5 * head * e[1], neck[1] + 0.5 * head * e[0]], [neck[0] + 0.5 * head * e[1], neck[1] - 0.5 * head * e[0]]]);
    this.fill(this.colours.force);
    if (cut < 1) {
      const m = [(a[0] + to[0]) / 2, (a[1] + to[1]) / 2];
      this.path([[m[0] - 5 * e[1] - 3 * e[0], m[1] + 5 * e[0] - 3 * e[1]], [m[0] + 5 * e[1] + 3 * e[0], m[1] - 5 * e[0] + 3 * e[1]]], false);
      this.stroke(this.colours.force, 1.5);
    }
    ctx.globalAlpha = 1;
  }
  /** Thin ones at the corners, a thick one for each foot at its centre of pressure. */
  arrows(seen) {
    const sums = this.film.feet.map(() => ({ force: [0, 0, 0], moment: [0, 0, 0] }));
    for (const { foot, at, force } of seen.forces) {
      if (force[2] <= 0) continue;
      this.arrow(at, force, 1.2);
      for (let k = 0; k < 3; k++) { sums[foot].force[k] += force[k]; sums[foot].moment[k] += force[2] * at[k]; }
    }
    for (const { force, moment } of sums) if (force[2] > 0.005 * this.film.weight) this.arrow(moment.map((m) => m / force[2]), force, 2.8);
  }
  ring(point, radius, fill) {
    const [x, y] = this.at(point), { ctx } = this;
    ctx.beginPath();
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
    if (fill) this.fill(fill);
    this.stroke(this.colours.ink, 1.8);
  }
  marks(seen) {
    const { ctx, colours } = this, [cx, cy, cz] = seen.center;
    if (Number.isFinite(cx)) {
      if (this.film.feet.length) {
        this.path([this.at([cx, cy, cz]), this.at([cx, cy, 0])], false);
        ctx.setLineDash([2, 4]);
        this.stroke(colours.ink, 1);
        ctx.setLineDash([]);
        this.ring([cx, cy, 0], 4.5, null);
      }
      this.ring([cx, cy, cz], 5.5, colours.paper);
      const [x, y] = this.at([cx, cy, cz]);
      ctx.beginPath();
      ctx.arc(x, y, 2, 0, 2 * Math.PI);
      this.fill(colours.ink);
    }
    if (seen.pressure) {
      const [x, y] = this.at([...seen.pressure, 0]);
      for (const [style, width] of [[colours.paper, 5.5], [colours.mark, 2.6]]) {
        this.path([[x - 6, y], [x + 6, y]], false); this.stroke(style, width);
        this.path([[x, y - 6], [x, y + 6]], false); this.stroke(style, width);
      }
    }
  }
  /** A square on the ground, on its corner or not. */
  square([x, y], radius, style, turned, filled) {
    const [a, b] = this.at([x, y, 0]), r = radius;
    this.path(turned ? [[a - r, b], [a, b - r], [a + r, b], [a, b + r]] : [[a - r, b - r], [a + r, b - r], [a + r, b + r], [a - r, b + r]]);
    if (filled) this.fill(style);
    this.stroke(style, 1.8);
  }
  /** What the controller knows: zero moment point, divergent component as it is wished and as it is. */
  balance(seen) {
    if (!seen.balance) return;
    const [x, y, a, b, p, q] = seen.balance, { amended, mark } = this.colours;
    this.square([p, q], 4.5, mark, false, false);
    this.square([a, b], 6, amended, true, false);
    this.square([x, y], 4.5, amended, true, true);
  }
  /** Where feet stood until now. */
  prints(time) {
    for (const print of this.footprints || []) {
      if (print.from > time) break;
      this.path(print.corners.map((c) => this.at(c)));
      this.stroke(this.colours.soft, 1);
    }
  }
  /** None on a stand; else a line with ticks every tenth of a metre, numbers every half; or squares of a quarter. */
  ground() {
    const { ctx, colours } = this;
    if (!this.film.feet.length) return;
    if (this.flat) {
      const y = this.at([0, 0, 0])[1], across = this.width / this.scale, from = this.middle[0] - across / 2;
      ctx.fillStyle = colours.rule;
      ctx.globalAlpha = 0.45;
      ctx.fillRect(0, y, this.width, this.height - y);
      ctx.globalAlpha = 1;
      this.path([[0, y], [this.width, y]], false);
      this.stroke(colours.soft, 1.5);
      ctx.font = "11px system-ui, sans-serif"; ctx.textAlign = "center"; ctx.fillStyle = colours.soft;
      for (let i = Math.ceil(from * 10); i <= (from + across) * 10; i++) {
        const x = this.px([i / 10, 0])[0], whole = i % 5 === 0;
        this.path([[x, y], [x, y + (whole ? 7 : 4)]], false);
        this.stroke(colours.soft, 1);
        if (whole && x > 22 && x < this.width - 22) ctx.fillText(`${String(i / 10).replace("-", "−")} m`, x, y + 19);
      }
      return;
    }
    const n = 5, step = 0.25, x0 = Math.round(this.focus[0] / step) * step, y0 = Math.round(this.focus[1] / step) * step;
    for (let i = -n; i <= n; i++) {
      for (const line of [[[x0 + i * step, y0 - n * step, 0], [x0 + i * step, y0 + n * step, 0]], [[x0 - n * step, y0 + i * step, 0], [x0 + n * step, y0 + i * step, 0]]]) {
        this.path(line.map((p) => this.at(p)), false);
        this.stroke(colours.rule, 1);
      }
    }
  }
  /** Where centre of mass and centre of pressure were in the last half second. */
  trail(time) {
    const { film, colours } = this, { times } = film;
    const then = times.map((t, i) => i).filter((i) => times[i] <= time && times[i] > time - 0.5);
    const line = (points, style) => { this.path(points, false); this.stroke(style, 1.2); };
    line(then.map((i) => this.at([film.centers[i][0] / film.per_metre, film.centers[i][1] / film.per_metre, 0])), colours.ink);
    line(then.filter((i) => film.pressures[i].length).map((i) => this.at([film.pressures[i][0] / film.per_metre, film.pressures[i][1] / film.per_metre, 0])), colours.mark);
  }
  draw(seen, time) {
    this.ctx.clearRect(0, 0, this.width, this.height);
    this.ground();
    if (!this.flat) this.prints(time);
    if (this.isAbove) {
      this.robot(seen, 0.28);
      this.polygon(seen);
      this.trail(time);
    } else {
      if (!this.flat) this.polygon(seen);
      this.robot(seen);
      this.arrows(seen);
    }
    this.marks(seen);
    this.balance(seen);
  }
}

/** Outlines of the feet of a walk, each in the middle of a time for which it was loaded, in the order of time. */
function footprints(film) {
  if (!film.words.length) return [];
  const prints = film.feet.flatMap((foot, index) => foot.loaded.filter(([a, b]) => b - a > 0.1).map(([a, b]) => {
    const places = scene(film, (a + b) / 2).forces.filter((force) => force.foot === index).map((force) => force.at);
    return { from: a, corners: outline(places.map((p) => [p[0], p[1], 0])) };
  }));
  return prints.sort((a, b) => a.from - b.from);
}

/** How far the robot reaches, in its largest frames, and how far it goes. */
function extent(film) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], span = [0.2, 0.2, 0.2];
  const count = Math.min(60, film.times.length);
  for (let k = 0; k < count; k++) {
    const seen = scene(film, film.times[Math.round((k * (film.times.length - 1)) / Math.max(1, count - 1))]);
    const l = [Infinity, Infinity, Infinity], h = [-Infinity, -Infinity, -Infinity];
    for (const part of film.parts) for (const corner of part.corners) {
      seen.at(part.body, corner).forEach((x, i) => { l[i] = Math.min(l[i], x); h[i] = Math.max(h[i], x); });
    }
    for (let i = 0; i < 3; i++) {
      low[i] = Math.min(low[i], l[i]); high[i] = Math.max(high[i], h[i]); span[i] = Math.max(span[i], h[i] - l[i]);
    }
  }
  return { low, high, span };
}

/** The four views of a film; `draw(time)` draws them. */
function makeViews(film) {
  const get = (id) => document.getElementById(id), { low, high, span } = extent(film);
  const stands = film.feet.length > 0;
  if (stands) low[2] = Math.min(low[2], 0);
  const tall = high[2] - low[2], whole = [high[0] - low[0], high[1] - low[1]], wide = [0, 1].map((i) => Math.min(whole[i], Math.max(span[i], 1.4 * tall)));
  // What travels further than its picture is followed.
  const follow = [0, 1].map((i) => whole[i] > wide[i] + 1e-9), middle = [0, 1, 2].map((i) => (low[i] + high[i]) / 2);
  const angle = { turn: -0.95, lift: 0.28 }, reach = Math.hypot(tall, ...span.slice(0, 2)), distance = 3.2 * reach;
  const space = new View(get("solid"), null, film, [Math.max(0.62 * reach, 0.9 * Math.hypot(...wide)), 1.12 * Math.max(tall, 0.75 * reach)]);
  space.project = (p) => {
    const d = [0, 1, 2].map((i) => p[i] - space.focus[i]), [s, c, l, m] = [Math.sin(angle.turn), Math.cos(angle.turn), Math.sin(angle.lift), Math.cos(angle.lift)];
    const near = d[0] * m * c + d[1] * m * s + d[2] * l, factor = distance / Math.max(0.2 * distance, distance - near);
    return [factor * (d[1] * c - d[0] * s), factor * (d[2] * m - l * (d[0] * c + d[1] * s)), near];
  };
  const side = new View(get("side"), (p) => [p[0], p[2], -p[1]], film, [1.1 * wide[0], 1.1 * tall]);
  const front = new View(get("front"), (p) => [p[1], p[2], p[0]], film, [1.1 * wide[1], 1.1 * tall]);
  const above = new View(get("above"), (p) => [p[0], p[1], p[2]], film, [1.12 * wide[0], 1.12 * wide[1]]);
  side.flat = front.flat = true;
  above.isAbove = true;
  const all = [side, front, space, above];
  const prints = footprints(film);
  for (const view of all) { view.arrowLength = 0.4 * tall; view.footprints = prints; }
  const views = {
    prepare() { for (const view of all) view.prepare(); },
    draw(time) {
      const seen = scene(film, time), known = seen.center.every(Number.isFinite);
      const focus = [0, 1].map((i) => (follow[i] && known ? seen.center[i] : middle[i])).concat(middle[2]);
      for (const view of all) view.focus = focus;
      side.look([focus[0], middle[2]]);
      front.look([focus[1], middle[2]]);
      above.look([focus[0], focus[1]]);
      space.look([0, 0]);
      // The same scale from the side and from the front.
      side.scale = front.scale = Math.min(side.scale, front.scale);
      for (const view of all) view.draw(seen, time);
      return seen;
    },
  };
  /* Turning the view in space: drag, or arrow keys while it has the focus. */
  views.turn = (turn, lift) => { angle.turn += turn; angle.lift = Math.min(1.5, Math.max(-0.2, angle.lift + lift)); };
  return views;
}
