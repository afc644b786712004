// Charts by uPlot, one cursor in time for all of them and the robot, and peaks in tables that lead there.
// After the first paint, so that words and tables are there at once.
requestAnimationFrame(() => setTimeout(() => {
  const element = document.getElementById("data");
  if (!element) return;
  const { looks, arrays: packed } = JSON.parse(element.textContent);
  const arrays = packed.map(({ values, n, low, step, levels }) => {
    if (values) return Float64Array.from(values, (x) => x ?? NaN);
    if (levels === undefined) return new Float64Array(n).fill(low);
    const raw = new Int32Array(Uint8Array.from(atob(levels), (c) => c.charCodeAt(0)).buffer);
    return Float64Array.from(raw, (level) => level === -(2 ** 31) ? NaN : low + step * (level + 2147483647));
  });
  const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const rgb = (name) => [1, 3, 5].map((k) => parseInt(style(name).slice(k, k + 2), 16) / 255);
  const short = (x) => x === null || Number.isNaN(x) ? "-" : Number(x.toPrecision(6)).toString();
  const shared = { charts: [], stages: [], time: null };

  function setTime(t, from) {
    shared.time = t;
    for (const chart of shared.charts) if (chart !== from && chart.show) chart.show(t);
    for (const stage of shared.stages) if (stage !== from) stage.setTime(t);
  }
  const nearest = (xs, x) => {
    let low = 0, high = xs.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (xs[middle] <= x) low = middle; else high = middle;
    }
    return x - xs[low] <= xs[high] - x ? low : high;
  };
  function readout(figure, first, values) {
    const place = figure.querySelector(".readout");
    place.replaceChildren(...[[null, first, ""], ...values].filter(([, label]) => label).map(([colour, label, text]) => {
      const span = document.createElement("span");
      if (colour) {
        const key = document.createElement("i");
        key.style.background = `var(--${colour})`;
        span.append(key);
      }
      span.append(text === "" ? label : `${label} ${text}`);
      return span;
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
  // The chart's own look on top of uPlot's: what is drawn behind and before curves.
  function dashed(u, from, to, colour) {
    const { ctx } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    ctx.clip();
    ctx.strokeStyle = style(colour);
    ctx.setLineDash([5 * devicePixelRatio, 3 * devicePixelRatio]);
    ctx.lineWidth = 1.2 * devicePixelRatio;
    ctx.beginPath();
    ctx.moveTo(...from);
    ctx.lineTo(...to);
    ctx.stroke();
    ctx.restore();
  }

  const shade = (look) => (u) => {
    for (const [from, to] of look.spans) {
      const left = u.valToPos(Math.max(from, u.scales.x.min), "x", true), right = u.valToPos(Math.min(to, u.scales.x.max), "x", true);
      u.ctx.fillStyle = style("grid");
      if (right > left) u.ctx.fillRect(left, u.bbox.top, right - left, u.bbox.height);
    }
  };

  function timeChart(figure, look) {
    const host = figure.querySelector(".plot"), x = arrays[look.x], banded = look.series.some((each) => each.high !== null);
    const twice = (values) => { const out = new Float64Array(2 * values.length); values.forEach((v, k) => { out[2 * k] = out[2 * k + 1] = v; }); return out; };
    const zigzag = (low, high) => { const out = new Float64Array(2 * low.length); low.forEach((v, k) => { out[2 * k] = v; out[2 * k + 1] = high[k]; }); return out; };
    const clean = (values) => Array.from(values, (v) => Number.isNaN(v) ? null : v);
    const data = [banded ? twice(x) : x, ...look.series.map(({ y, high }) => clean(banded ? zigzag(arrays[y], arrays[high ?? y]) : arrays[y]))];
    const self = { resize: (size) => u.setSize(size ?? room()) };
    const room = () => ({ width: Math.max(host.clientWidth, 200), height: look.height ?? 210 });
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
        draw: [(u) => {
          for (const [value] of look.levels) {
            const y = u.valToPos(value, "y", true);
            if (y >= u.bbox.top && y <= u.bbox.top + u.bbox.height) dashed(u, [u.bbox.left, y], [u.bbox.left + u.bbox.width, y], "bad");
          }
        }],
        setScale: [(u, key) => {
          if (key !== "x" || shared.zooming) return;
          shared.zooming = true;
          for (const chart of shared.charts) if (chart !== self && chart.zoom) chart.zoom(u.scales.x.min, u.scales.x.max);
          shared.zooming = false;
        }],
      },
    }, data, host);
    self.show = (t) => {
      u.setCursor({ left: Math.min(Math.max(u.valToPos(t, "x"), 0), u.over.clientWidth), top: 0 });
      tell(nearest(data[0], t));
    };
    u.over.addEventListener("mousemove", (event) => {
      const idx = u.posToIdx(event.clientX - u.over.getBoundingClientRect().left);
      tell(idx);
      setTime(data[0][idx], self);
    });
    self.zoom = (min, max) => u.setScale("x", { min, max });
    host.addEventListener("keydown", (event) => {
      const at = nearest(data[0], shared.time ?? data[0][0]), { min, max } = u.scales.x, step = banded ? 2 : 1;
      const steps = { ArrowLeft: -step, ArrowRight: step, PageUp: -50, PageDown: 50, Home: -data[0].length, End: data[0].length };
      if (event.key in steps) {
        setTime(data[0][Math.min(Math.max(at + steps[event.key], 0), data[0].length - 1)]);
      } else if (event.key === "+" || event.key === "-") {
        const middle = shared.time ?? (min + max) / 2, part = event.key === "+" ? 0.5 : 2;
        u.setScale("x", { min: Math.max(middle + part * (min - middle), data[0][0]), max: Math.min(middle + part * (max - middle), data[0][data[0].length - 1]) });
      } else if (event.key === "Escape") u.setScale("x", { min: data[0][0], max: data[0][data[0].length - 1] });
      else return;
      event.preventDefault();
    });
    readout(figure, "", look.series.map(({ label, colour }) => [colour, label, ""]));
    return Object.assign(self, { u });
  }

  function planeChart(figure, look) {
    const host = figure.querySelector(".plot"), points = look.series.map(({ x, y }) => [arrays[x], arrays[y]]);
    const range = (k) => {
      const marks = look.marks.map((mark) => mark[k]), all = points.flatMap((pair) => [pair[k].reduce((a, b) => Math.min(a, Number.isNaN(b) ? a : b), Infinity), pair[k].reduce((a, b) => Math.max(a, Number.isNaN(b) ? a : b), -Infinity)]);
      const least = Math.min(...all, ...marks), most = Math.max(...all, ...marks);
      if (look.log) return [least / 1.3 / (most / least) ** 0.05, 1.3 * most * (most / least) ** 0.05];
      const gap = 0.07 * (most - least || Math.abs(most) || 1);
      return [least - gap, most + gap];
    };
    const whole = [range(0), range(1)];
    let ranges = whole;
    const room = () => ({ width: Math.max(host.clientWidth, 200), height: look.height ?? (look.log ? 360 : 300) });
    const time = look.time === null ? null : arrays[look.time];
    const self = { at: null };
    const paint = (u) => {
      const { ctx } = u, ratio = devicePixelRatio;
      ctx.save();
      ctx.beginPath();
      ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
      ctx.clip();
      const spot = (x, y, r) => { ctx.beginPath(); ctx.arc(u.valToPos(x, "x", true), u.valToPos(y, "y", true), r * ratio, 0, 7); ctx.fill(); };
      if (!look.log) {
        for (const [a, b] of [[[ranges[0][0], 0], [ranges[0][1], 0]], [[0, ranges[1][0]], [0, ranges[1][1]]]]) {
          ctx.strokeStyle = style("rule");
          ctx.beginPath();
          ctx.moveTo(u.valToPos(a[0], "x", true), u.valToPos(a[1], "y", true));
          ctx.lineTo(u.valToPos(b[0], "x", true), u.valToPos(b[1], "y", true));
          ctx.stroke();
        }
      }
      look.series.forEach(({ colour, style: kind }, s) => {
        const [xs, ys] = points[s];
        ctx.fillStyle = ctx.strokeStyle = style(colour);
        if (kind === "dots") {
          const small = xs.length > 300;
          for (let k = 0; k < xs.length; k++) {
            const x = u.valToPos(xs[k], "x", true), y = u.valToPos(ys[k], "y", true), r = (small ? 1.3 : 3) * ratio;
            if (small) ctx.fillRect(x - r, y - r, 2 * r, 2 * r); else spot(xs[k], ys[k], 3);
          }
        } else {
          ctx.lineWidth = 1.6 * ratio;
          ctx.beginPath();
          let open = false;
          for (let k = 0; k < xs.length; k++) {
            if (Number.isNaN(xs[k])) { open = false; continue; }
            const to = [u.valToPos(xs[k], "x", true), u.valToPos(ys[k], "y", true)];
            if (open) ctx.lineTo(...to); else ctx.moveTo(...to);
            open = true;
          }
          ctx.stroke();
        }
      });
      for (const [x, y, , colour] of look.marks) { ctx.fillStyle = style(colour); spot(x, y, 5); }
      if (self.at !== null) {
        ctx.strokeStyle = style("ink");
        ctx.lineWidth = 2 * ratio;
        ctx.beginPath();
        ctx.arc(u.valToPos(points[0][0][self.at], "x", true), u.valToPos(points[0][1][self.at], "y", true), 6 * ratio, 0, 7);
        ctx.stroke();
      }
      ctx.restore();
    };
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
    if (time) self.show = (t) => { self.at = nearest(time, t); u.redraw(false); };
    readout(figure, "", [...look.series, ...look.marks.map(([, , label, colour]) => ({ label, colour }))].map(({ label, colour }) => [colour, label, ""]));
    return Object.assign(self, { u, resize: (size) => { u.setSize(size ?? room()); fit(); } });
  }

  const made = new Map();
  function make(figure) {
    if (made.has(figure)) return;
    const look = looks[Number(figure.dataset.look)];
    const chart = look.kind === "time" ? timeChart(figure, look) : planeChart(figure, look);
    made.set(figure, chart);
    shared.charts.push(chart);
    if (shared.time !== null && chart.show) setTimeout(() => chart.show(shared.time)); // uPlot lays itself out first
  }
  const waiting = new IntersectionObserver((entries) => entries.forEach((entry) => {
    if (entry.isIntersecting) make(entry.target);
  }), { rootMargin: "400px" });
  const figures = [...document.querySelectorAll("figure.chart")];
  figures.forEach((figure) => waiting.observe(figure));
  const all = (size) => {
    figures.forEach(make);
    made.forEach((chart) => { chart.resize(size); chart.u.redraw(false, true); });
    shared.stages.forEach((stage) => stage.render());
  };
  // On paper: so many charts beside each other that they fit on one page, in the colours of paper.
  const root = document.documentElement, homes = [...document.querySelectorAll(".gallery figure")].map((each) => [each, each.parentElement]);
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
    if (stage) shared.stages.push(stage);
  }
  // Times in tables lead there.
  for (const table of document.querySelectorAll("table")) {
    [...(table.tHead?.rows[0]?.cells ?? [])].forEach((head, column) => {
      if (!/^at \[s\]/.test(head.textContent)) return;
      for (const row of table.tBodies[0].rows) {
        const cell = row.cells[column], t = Number(cell.textContent);
        if (cell.textContent.trim() === "" || Number.isNaN(t)) continue;
        const button = document.createElement("button");
        Object.assign(button, { type: "button", className: "go", textContent: cell.textContent, title: "show this moment" });
        button.addEventListener("click", () => setTime(t));
        cell.replaceChildren(button);
      }
    });
  }
  window.robodyn = { setTime, arrays, looks, charts: made, stages: shared.stages, all };
}));
