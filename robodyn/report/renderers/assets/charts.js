// Charts by uPlot, one cursor in time for all of them and the robot, and peaks in tables that lead there.
// After the first paint, so that words and tables are there at once.
requestAnimationFrame(() => setTimeout(() => {
  const data = document.getElementById("data");
  if (!data) return;
  const { looks, arrays: packed } = JSON.parse(data.textContent), root = document.documentElement;
  const arrays = packed.map(({ values, n, low, step, levels }) => {
    if (values) return Float64Array.from(values, (x) => x ?? NaN);
    if (levels === undefined) return new Float64Array(n).fill(low);
    const raw = new Int32Array(Uint8Array.from(atob(levels), (c) => c.charCodeAt(0)).buffer);
    return Float64Array.from(raw, (level) => level === -(2 ** 31) ? NaN : low + step * (level + 2147483647));
  });
  const style = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim();
  const rgb = (name) => [1, 3, 5].map((k) => parseInt(style(name).slice(k, k + 2), 16) / 255);
  const short = (x) => x === null || Number.isNaN(x) ? "-" : Number(x.toPrecision(6)).toString();
  const made = new Map(), stages = [], shared = { time: null, range: null };

  function setTime(t, from) {
    shared.time = t;
    for (const chart of made.values()) if (chart !== from && chart.seen) chart.show?.(t);
    for (const stage of stages) if (stage !== from) stage.setTime(t);
  }
  function readout(figure, first, values) {
    figure.querySelector(".readout").replaceChildren(...[[null, first, ""], ...values].filter(([, label]) => label).map(([colour, label, text]) => {
      const key = element("i", {});
      key.style.background = `var(--${colour})`;
      return element("span", {}, ...(colour ? [key] : []), text === "" ? label : `${label} ${text}`);
    }));
  }
  // Decades of a logarithmic axis, every few of many, also 2 and 5 of few; even steps within one.
  const logTicks = (min, max) => {
    const first = Math.floor(Math.log10(min)), many = Math.ceil(Math.log10(max)) - first, every = Math.ceil(many / 9), ticks = [];
    const step = [1, 2, 5, 10].map((m) => m * 10 ** Math.floor(Math.log10((max - min) / 6))).find((each) => (max - min) / each <= 6);
    if (max < 10 * min) for (let k = Math.ceil(min / step); k * step <= max; k++) ticks.push(Number((k * step).toPrecision(9)));
    else for (let p = 0; p <= many; p++) if (p % every === 0) ticks.push(...(many > 4 ? [1] : [1, 2, 5]).map((m) => Number(`${m}e${first + p}`)));
    return ticks.filter((tick) => tick >= min && tick <= max);
  };
  const axes = (across, up, log) => [across, up].map((label, k) => ({
    stroke: () => style("ink"), label: label ?? undefined, labelSize: k ? 18 : 22, size: k ? 58 : 34, font: "12px system-ui, sans-serif",
    labelFont: "12px system-ui, sans-serif", grid: { stroke: () => style("grid"), width: 1 }, ticks: { stroke: () => style("grid"), width: 1 },
    values: (_, ticks) => ticks.map((tick) => (tick === null ? "" : tick && (Math.abs(tick) < 1e-3 || Math.abs(tick) >= 1e6) ? Number(tick.toPrecision(6)).toExponential() : short(tick)).replaceAll("-", "\u2212")),
    ...(log ? { splits: (_, axis, min, max) => logTicks(min, max), filter: (_, ticks) => ticks } : {}),
    space: k ? 34 : 60,
  }));
  // The chart's own look on top of uPlot's: what is drawn behind and before curves, within the axes.
  function within(u, draw) {
    u.ctx.save();
    u.ctx.beginPath();
    u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    u.ctx.clip();
    const place = (axis) => (value) => Number.isNaN(value) ? NaN : u.valToPos(value, axis, true); // NaN would be a log's end
    draw(u.ctx, devicePixelRatio, place("x"), place("y"));
    u.ctx.restore();
  }
  function stroke(ctx, colour, wide, points) {
    ctx.strokeStyle = style(colour);
    ctx.lineWidth = wide;
    ctx.beginPath();
    points.forEach(([x, y], k) => { // nan ends a line
      if (k && !Number.isNaN(points[k - 1][0])) ctx.lineTo(x, y); else ctx.moveTo(x, y);
    });
    ctx.stroke();
  }
  const shade = (look) => (u) => within(u, (ctx, ratio, across) => {
    ctx.fillStyle = style("grid");
    for (const [from, to] of look.spans) {
      const left = Math.max(across(from), u.bbox.left);
      ctx.fillRect(left, u.bbox.top, Math.max(Math.min(across(to), u.bbox.left + u.bbox.width) - left, 0), u.bbox.height);
    }
  });

  function timeChart(figure, look) {
    const host = figure.querySelector(".plot"), x = arrays[look.x], banded = look.series.some((each) => each.high !== null);
    const zigzag = (low, high) => Float64Array.from({ length: 2 * low.length }, (_, k) => (k % 2 ? high : low)[k >> 1]);
    const clean = (values) => Array.from(values, (v) => Number.isNaN(v) ? null : v);
    const data = [banded ? zigzag(x, x) : x, ...look.series.map(({ y, high }) => clean(banded ? zigzag(arrays[y], arrays[high ?? y]) : arrays[y]))];
    const self = { resize: (size) => u.setSize(size ?? room()) };
    const room = () => ({ width: Math.max(host.clientWidth, 200), height: look.height ?? 210 });
    // The sample nearest to a time, or the bucket of rows that holds it; times are rounded to 2^-32 of their range.
    const holding = (t) => banded ? 2 * between(x, t + 1e-9 * (x[x.length - 1] - x[0]))[0] : nearest(x, t);
    const tell = (idx) => {
      const k = banded ? idx >> 1 : idx, rows = look.rows === null ? null : arrays[look.rows];
      const last = rows && banded && k + 1 < rows.length ? rows[k + 1] - 1 : null;
      const row = rows ? `, row ${Math.round(rows[k])}${last !== null && last > rows[k] ? ` to ${Math.round(last)}` : ""}` : "";
      readout(figure, `${short(x[k])} s${row}`, look.series.map(({ label, colour, y, high }) => {
        const low = arrays[y][k], most = high === null ? low : arrays[high][k];
        return [colour, label, `${short(low)}${most === low ? "" : ` to ${short(most)}`} ${look.unit}`];
      }));
    };
    const u = new uPlot({
      ...room(),
      legend: { show: false },
      cursor: { y: false, points: banded ? { show: false } : { size: 7 }, drag: { x: true, y: false }, focus: { prox: -1 } },
      scales: { x: { time: false }, y: { range: (_, low, high) => {
        const most = Math.max(Math.abs(low), Math.abs(high)) || 1, near = look.levels.map(([v]) => v).filter((v) => Math.abs(v) <= 2 * most);
        const least = Math.min(low, ...near), top = Math.max(high, ...near), gap = 0.06 * (top - least || Math.abs(top) || 1);
        return [least - gap, top + gap];
      } } },
      axes: axes("time [s]", null, false),
      series: [{}, ...look.series.map(({ label, colour, held, wide }) => ({
        label, stroke: () => style(colour), width: wide ? 5 : 1.5, alpha: wide ? 0.5 : 1, points: { show: data[0].length === 1 },
        paths: held ? uPlot.paths.stepped({ align: 1 }) : undefined,
      }))],
      hooks: {
        drawClear: [shade(look)],
        draw: [(u) => within(u, (ctx, ratio, across, up) => {
          ctx.setLineDash([5 * ratio, 3 * ratio]);
          for (const [value] of look.levels) stroke(ctx, "bad", 1.2 * ratio, [0, u.bbox.width].map((x) => [u.bbox.left + x, up(value)]));
        })],
        setScale: [(u, key) => {
          if (key !== "x" || shared.zooming || !self.u) return;
          shared.zooming = true;
          shared.range = u.scales.x;
          for (const chart of made.values()) if (chart !== self) chart.zoom?.(shared.range);
          shared.zooming = false;
        }],
      },
    }, data, host);
    self.show = (t) => {
      u.setCursor({ left: Math.min(Math.max(u.valToPos(t, "x"), 0), u.over.clientWidth), top: 0 });
      tell(holding(t));
    };
    u.over.addEventListener("mousemove", (event) => {
      const idx = holding(u.posToVal(event.clientX - u.over.getBoundingClientRect().left, "x"));
      tell(idx);
      setTime(data[0][idx], self);
    });
    self.zoom = ({ min, max }) => u.setScale("x", { min, max });
    host.addEventListener("keydown", (event) => {
      const [first, last] = [data[0][0], data[0].at(-1)], { min, max } = u.scales.x, step = banded ? 2 : 1, end = data[0].length;
      const steps = { ArrowLeft: -step, ArrowRight: step, PageUp: -50, PageDown: 50, Home: -end, End: end }, parts = { "+": 0.5, "-": 2, Escape: Infinity };
      if (event.key in steps) {
        const at = holding(shared.time ?? first) + steps[event.key];
        setTime(data[0][Math.min(Math.max(at, 0), end - 1)]);
      } else if (event.key in parts) {
        const half = parts[event.key] * (max - min) / 2, middle = Math.min(Math.max(shared.time ?? (min + max) / 2, min), max);
        self.zoom({ min: Math.max(middle - half, first), max: Math.min(middle + half, last) });
      } else return;
      event.preventDefault();
    });
    readout(figure, "", look.series.map(({ label, colour }) => [colour, label, ""]));
    return Object.assign(self, { u });
  }

  function planeChart(figure, look) {
    const host = figure.querySelector(".plot"), points = look.series.map(({ x, y }) => [arrays[x], arrays[y]]);
    const range = (k) => {
      let least = Infinity, most = -Infinity;
      for (const values of [look.marks.map((mark) => mark[k]), ...points.map((pair) => pair[k])]) {
        for (const value of values) if (!Number.isNaN(value)) { least = Math.min(least, value); most = Math.max(most, value); }
      }
      if (look.log) return [least / 1.3 / (most / least) ** 0.05, 1.3 * most * (most / least) ** 0.05];
      const gap = 0.07 * (most - least || Math.abs(most) || 1);
      return [least - gap, most + gap];
    };
    const whole = [range(0), range(1)];
    let ranges = whole;
    const room = () => ({ width: Math.max(host.clientWidth, 200), height: look.height ?? (look.log ? 360 : 300) });
    const time = look.time === null ? null : arrays[look.time];
    const self = {}, at = element("div", { className: "at" });
    const paint = (u) => within(u, (ctx, ratio, across, up) => {
      const spot = (x, y, r) => { ctx.beginPath(); ctx.arc(x, y, r * ratio, 0, 7); ctx.fill(); };
      if (!look.log) for (const ends of [[[ranges[0][0], 0], [ranges[0][1], 0]], [[0, ranges[1][0]], [0, ranges[1][1]]]]) {
        stroke(ctx, "rule", ratio, ends.map(([x, y]) => [across(x), up(y)]));
      }
      look.series.forEach(({ colour, style: kind }, s) => {
        const places = Array.from(points[s][0], (x, k) => [across(x), up(points[s][1][k])]), r = 1.3 * ratio;
        ctx.fillStyle = style(colour);
        if (kind !== "dots") stroke(ctx, colour, 1.6 * ratio, places);
        else for (const [x, y] of places) if (places.length > 300) ctx.fillRect(x - r, y - r, 2 * r, 2 * r); else spot(x, y, 3);
      });
      for (const [x, y, , colour] of look.marks) { ctx.fillStyle = style(colour); spot(across(x), up(y), 5); }
      if (time && shared.time !== null) self.show(shared.time);
    });
    const scale = (k) => ({ time: false, distr: look.log ? 3 : 1, range: () => ranges[k] });
    const u = new uPlot({
      ...room(), legend: { show: false }, cursor: { drag: { x: true, y: true, uni: 20, setScale: false }, points: { show: false } },
      scales: { x: scale(0), y: scale(1) }, axes: axes(look.across, look.up, look.log), series: [{}, { points: { show: false } }],
      hooks: {
        drawClear: [shade(look)],
        draw: [paint],
        setSelect: [(u) => {
          const { left, top, width, height } = u.select;
          if (width < 4 && height < 4) return;
          ranges = [[left, left + width].map((p) => u.posToVal(p, "x")), [top + height, top].map((p) => u.posToVal(p, "y"))];
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          ends();
        }],
        setCursor: [(u) => {
          const { left, top } = u.cursor;
          if (left < 0) return;
          let best = [20 ** 2, null, null];
          const take = (x, y, s, k) => {
            const far = (u.valToPos(x, "x") - left) ** 2 + (u.valToPos(y, "y") - top) ** 2;
            if (far < best[0]) best = [far, s, k];
          };
          look.series.forEach(({ style: kind }, s) => { if (kind === "dots") for (let k = 0; k < points[s][0].length; k++) take(points[s][0][k], points[s][1][k], s, k); });
          look.marks.forEach(([x, y], k) => take(x, y, -1, k));
          if (best[1] === null) return;
          const [, s, k] = best, [x, y] = s < 0 ? look.marks[k] : [points[s][0][k], points[s][1][k]];
          const label = s < 0 ? look.marks[k][2] : look.series[s].names?.[k] ?? look.series[s].label;
          readout(figure, "", [[s < 0 ? look.marks[k][3] : look.series[s].colour, `${label}:`, `${look.across} ${short(x)}, ${look.up} ${short(y)}`]]);
          if (s === 0 && time) setTime(time[k], self);
        }],
      },
    }, [[], []], host);
    const ends = () => u.setData([ranges[0], [null, null]]);
    function fit() { // all there is, with one scale for both axes where they are equal
      const rooms = [u.width - 90, u.height - 60], unit = Math.max(...whole.map(([low, high], k) => (high - low) / rooms[k]));
      ranges = look.equal ? whole.map(([low, high], k) => [-1, 1].map((sign) => (low + high + sign * unit * rooms[k]) / 2)) : whole;
      ends();
    }
    fit();
    u.over.addEventListener("dblclick", fit);
    host.addEventListener("keydown", (event) => { if (event.key === "Escape") fit(); });
    if (time) self.show = (t) => {
      const k = nearest(time, t);
      at.style.translate = `${u.valToPos(points[0][0][k], "x")}px ${u.valToPos(points[0][1][k], "y")}px`;
      u.over.append(at);
    };
    readout(figure, "", [...look.series, ...look.marks.map(([, , label, colour]) => ({ label, colour }))].map(({ label, colour }) => [colour, label, ""]));
    return Object.assign(self, { u, resize: (size) => { u.setSize(size ?? room()); fit(); } });
  }

  function make(figure) {
    if (made.has(figure)) return;
    const look = looks[Number(figure.dataset.look)];
    const chart = look.kind === "time" ? timeChart(figure, look) : planeChart(figure, look);
    made.set(figure, chart);
    if (shared.range) chart.zoom?.(shared.range);
  }
  const waiting = new IntersectionObserver((entries) => entries.forEach(({ target, isIntersecting }) => {
    if (isIntersecting) make(target);
    const chart = made.get(target);
    if (chart) chart.seen = isIntersecting;
    if (isIntersecting && shared.time !== null) setTimeout(() => chart.show?.(shared.time)); // uPlot lays itself out first
  }), { rootMargin: "400px" });
  const figures = [...document.querySelectorAll("figure.chart")];
  figures.forEach((figure) => waiting.observe(figure));
  const all = (size) => {
    figures.forEach(make);
    made.forEach((chart) => { chart.resize(size); chart.u.redraw(false, true); });
    stages.forEach((stage) => stage.render());
  };
  // On paper: so many charts beside each other that they fit on one page, in the colours of paper.
  const homes = [...document.querySelectorAll(".gallery figure")].map((each) => [each, each.parentElement]);
  window.addEventListener("beforeprint", () => {
    homes.forEach(([each, home]) => { home.hidden = home !== homes[0][1]; homes[0][1].append(each); });
    const across = [3, 4, 5, 6, 7].find((n) => Math.ceil(homes.length / n) * (412 / n + 42) <= 940) ?? 8;
    root.style.setProperty("--across", across);
    root.classList.add("paper");
    all({ width: 1300 / across, height: 780 / across });
    for (const canvas of document.querySelectorAll(".stage canvas")) { // paper takes what WebGL drew before
      const still = canvas.cloneNode();
      still.className = "still";
      still.getContext("2d").drawImage(canvas, 0, 0);
      canvas.after(still);
    }
  });
  window.addEventListener("afterprint", () => {
    root.classList.remove("paper");
    homes.forEach(([each, home]) => { home.hidden = false; home.append(each); });
    document.querySelectorAll(".still").forEach((each) => each.remove());
    all();
  });
  new ResizeObserver(() => made.forEach((chart) => chart.resize())).observe(document.querySelector("main"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => all());
  for (const figure of document.querySelectorAll("figure.stage")) {
    const stage = makeViewer(figure, looks[Number(figure.dataset.look)], arrays, rgb, (t) => setTime(t, stage));
    if (stage) stages.push(stage);
  }
  // Times in tables lead there.
  for (const table of document.querySelectorAll("table")) {
    [...(table.tHead?.rows[0]?.cells ?? [])].forEach((head, column) => {
      if (!/^at \[s\]/.test(head.textContent)) return;
      for (const row of table.tBodies[0].rows) {
        const cell = row.cells[column], t = Number(cell.textContent);
        if (cell.textContent.trim() === "" || Number.isNaN(t)) continue;
        const button = element("button", { type: "button", className: "go", title: "show this moment" }, cell.textContent);
        button.addEventListener("click", () => setTime(t));
        cell.replaceChildren(button);
      }
    });
  }
  window.robodyn = { setTime, arrays, looks, charts: made, stages, all };
}));
