/* Moving and zooming with the pointer: Shift-drag with a mouse; one finger moves, two zoom. uPlot itself zooms with the mouse. */
function steerByPointer(parent, current) {
  const fingers = new Map();
  let span = null;
  const overPlot = (event) => event.target.closest(".u-over");
  const time = (over, x) => current().plots[0].posToVal(x - over.getBoundingClientRect().left, "x");
  // Before uPlot sees it: no selection starts while the window is moved.
  parent.addEventListener("mousedown", (event) => { if (event.shiftKey && overPlot(event)) event.stopPropagation(); }, true);
  parent.addEventListener("pointerdown", (event) => {
    const over = overPlot(event);
    if (!over || (event.pointerType === "mouse" && !event.shiftKey)) return;
    fingers.set(event.pointerId, event.clientX);
    over.setPointerCapture(event.pointerId);
    span = null;
  });
  parent.addEventListener("pointermove", (event) => {
    const over = overPlot(event);
    if (!over || !fingers.has(event.pointerId)) return;
    const before = [...fingers.values()];
    fingers.set(event.pointerId, event.clientX);
    const after = [...fingers.values()], { min, max } = current().plots[0].scales.x;
    if (after.length === 1) {
      const shift = time(over, before[0]) - time(over, after[0]);
      current().zoom(min + shift, max + shift);
    } else if (after.length === 2) {
      // The times under the two fingers stay under them.
      span = span || before.map((x) => time(over, x));
      const [a, b] = after, [s, t] = span, left = over.getBoundingClientRect().left, width = over.clientWidth;
      if (Math.abs(b - a) < 20) return;
      const perPixel = (t - s) / (b - a), low = s - (a - left) * perPixel;
      if (perPixel > 0) current().zoom(low, low + width * perPixel);
    }
  });
  for (const end of ["pointerup", "pointercancel"]) parent.addEventListener(end, (event) => { fingers.delete(event.pointerId); span = null; });
}
