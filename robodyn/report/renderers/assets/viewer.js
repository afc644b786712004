// The robot in WebGL 2: bodies placed by their joints, arrows of what acts on them, one body picked and told in numbers.
function between(time, t) { // the rows on both sides of a time, and how far it is between them
  let low = 0, high = time.length - 1;
  if (t <= time[0]) return [0, 0, 0];
  if (t >= time[high]) return [high, high, 0];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (time[middle] <= t) low = middle; else high = middle;
  }
  return [low, high, (t - time[low]) / (time[high] - time[low] || 1)];
}
const nearest = (time, t) => {
  const [low, high, part] = between(time, t);
  return part > 0.5 ? high : low;
};

function makeViewer(figure, stage, arrays, rgb, onTime) {
  const $ = (name) => figure.querySelector(`[data-part="${name}"]`);
  const canvas = $("canvas"), gl = canvas.getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
  if (!gl) {
    $("message").textContent = "This browser has no WebGL 2, which draws the robot. The tables have all numbers.";
    figure.querySelectorAll(".room, .controls").forEach((idle) => idle.remove());
    return null;
  }

  // Matrices by columns, as WebGL has them: a rotation [r00 r10 r20 ...] and a place make 16 numbers.
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
  const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
  const size = (a) => Math.hypot(a[0], a[1], a[2]);
  const place = (R, p) => [R[0], R[3], R[6], 0, R[1], R[4], R[7], 0, R[2], R[5], R[8], 0, p[0], p[1], p[2], 1];
  const turned = (M, v) => [0, 1, 2].map((i) => M[i] * v[0] + M[4 + i] * v[1] + M[8 + i] * v[2]);
  const turnedBack = (M, v) => [0, 4, 8].map((j) => M[j] * v[0] + M[j + 1] * v[1] + M[j + 2] * v[2]);
  const moved = (M, v) => add(turned(M, v), M.slice(12, 15));
  const product = (A, B) => Array.from({ length: 16 }, (_, k) => {
    const i = k % 4, j = k - i;
    return A[i] * B[j] + A[4 + i] * B[j + 1] + A[8 + i] * B[j + 2] + A[12 + i] * B[j + 3];
  });
  const ofQuaternion = (given) => {
    const length = Math.hypot(...given) || 1, [x, y, z, w] = given.map((each) => each / length);
    return [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w),
      1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)];
  };

  const state = { time: 0, playing: false, speed: 1, motion: 0, picked: null, layers: {}, sliders: {} };
  const robots = stage.robots;
  const motionOf = (robot) => robot.motions[Math.min(state.motion, robot.motions.length - 1)];
  const span = () => {
    const times = robots.map((robot) => motionOf(robot).time).filter((time) => time !== null).map((time) => arrays[time]);
    return times.length ? [Math.min(...times.map((t) => t[0])), Math.max(...times.map((t) => t.at(-1)))] : [0, 0];
  };
  const sample = (values, [low, high, part]) => values[low] + part * (values[high] - values[low]);
  const valueOf = (entry, at) => typeof entry === "object" ? entry[0] : sample(arrays[entry], at); // of all rows, or one that stays

  function configuration(robot) {
    const motion = motionOf(robot);
    if (motion.time === null) { // a slider may move coordinates of several robots, each in its own sense
      const q = [...motion.rest];
      for (const { q: k, of = k, sign = 1, offset = 0 } of motion.sliders) {
        if (of in state.sliders) q[k] = sign * state.sliders[of] + offset;
      }
      return q;
    }
    const at = between(arrays[motion.time], state.time);
    const q = motion.q.map((entry) => valueOf(entry, at));
    for (const { kind, q: k } of robot.bodies) { // q and -q are one rotation: between them the shorter way
      if (kind !== "floating") continue;
      const [one, other] = [at[0], at[1]].map((row) => motion.q.slice(k + 3, k + 7).map((entry) => valueOf(entry, [row, row, 0])));
      if (one.reduce((sum, x, i) => sum + x * other[i], 0) < 0) one.forEach((x, i) => { q[k + 3 + i] = x - at[2] * (other[i] + x); });
    }
    return q;
  }

  // As `joint_motion`: where each joint puts its body.
  function poses(robot, q) {
    const found = [];
    for (const body of robot.bodies) {
      const k = body.q, at = body.ratio * q[k] + body.offset;
      let local = place(body.R, body.p);
      if (body.kind === "floating") local = product(local, place(ofQuaternion(q.slice(k + 3, k + 7)), q.slice(k, k + 3)));
      else if (body.kind === "revolute") local = product(local, place(ofQuaternion([...times(body.axis, Math.sin(at / 2)), Math.cos(at / 2)]), [0, 0, 0]));
      else if (body.kind === "prismatic") local = product(local, place([1, 0, 0, 0, 1, 0, 0, 0, 1], times(body.axis, at)));
      found.push(body.parent < 0 ? local : product(found[body.parent], local));
    }
    return found;
  }

  // One program for solids, lines and picking: flat shading by the derivatives of the place.
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, `#version 300 es
    in vec3 at; uniform mat4 model, view, lens; out vec3 seen;
    void main() { vec4 p = view * model * vec4(at, 1.0); seen = p.xyz; gl_Position = lens * p; }`], [gl.FRAGMENT_SHADER, `#version 300 es
    precision highp float; in vec3 seen; uniform vec4 colour; uniform float shaded; out vec4 shown;
    void main() {
      vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
      float light = mix(1.0, 0.45 + 0.55 * abs(dot(n, normalize(vec3(0.3, 0.5, 1.0)))), shaded);
      shown = vec4(colour.rgb * light, colour.a);
    }`]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.bindAttribLocation(program, 0, "at");
  gl.linkProgram(program);
  const uniform = Object.fromEntries(["model", "view", "lens", "colour", "shaded"].map(
    (name) => [name, gl.getUniformLocation(program, name)]));

  function solid(corners, indices) {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(corners), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.STATIC_DRAW);
    return { array, count: indices.length };
  }
  // Surfaces of revolution about z by their outline [radius, height].
  function lathe(outline, around = 16) {
    const corners = [], indices = [];
    outline.forEach(([r, z], row) => {
      for (let k = 0; k < around; k++) {
        const a = 2 * Math.PI * k / around;
        corners.push(r * Math.cos(a), r * Math.sin(a), z);
        if (row) {
          const one = row * around + k, next = row * around + (k + 1) % around;
          indices.push(one - around, next - around, one, next, one, next - around);
        }
      }
    });
    return solid(corners, indices);
  }
  const cylinder = [[0, 0], [1, 0], [1, 1], [0, 1]], shaft = lathe(cylinder), disc = lathe(cylinder, 64), head = lathe([[0, 0], [1, 0], [0, 1]]);
  const ball = lathe(Array.from({ length: 13 }, (_, k) => [Math.sin(Math.PI * k / 12), -Math.cos(Math.PI * k / 12)]), 24);
  const lines = Array.from({ length: 21 }, (_, k) => k - 10).flatMap((k) => [k, -10, 0, k, 10, 0, -10, k, 0, 10, k, 0]);
  const grid = solid(lines, lines.slice(0, 84).map((_, k) => k));
  const meshes = stage.meshes.map(({ low, step, corners, indices }) => {
    const raw = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
    const grid = new Uint16Array(raw(corners)), at = new Float32Array(grid.length);
    grid.forEach((value, k) => { at[k] = low[k % 3] + step * value; });
    const faces = at.length / 3 > 65536 ? new Uint32Array(raw(indices)) : new Uint16Array(raw(indices));
    const every = Math.ceil(at.length / 600), some = Array.from({ length: Math.floor(at.length / 3 / every) }, (_, k) => at.slice(3 * k * every, 3 * k * every + 3));
    return { ...solid(at, faces), some };
  });

  // How far the base has gone since the start; the view goes with it where that is far.
  const floats = stage.loop ? -1 : robots[0].bodies.findIndex((body) => body.kind === "floating");
  let start = null;
  const gone = (all) => floats < 0 ? [0, 0, 0] : add(all[floats].slice(12, 15), times(start ??= all[floats].slice(12, 15), -1));

  // The room that all robots take along the motion, by the corners of their meshes and their joints, or seen from the base.
  const room = (followed) => {
    const points = [], [from, to] = span();
    for (let moment = 0; moment <= (to > from ? 8 : 0); moment++) {
      state.time = from + moment * (to - from) / 8;
      for (const robot of robots) {
        const all = poses(robot, configuration(robot)), way = followed ? gone(all) : [0, 0, 0];
        robot.bodies.forEach((body, k) => {
          const own = [[0, 0, 0], body.centre, ...body.meshes.flatMap((mesh) => meshes[mesh].some)];
          points.push(...own.map((point) => add(moved(all[k], point), times(way, -1))));
        });
      }
    }
    const [low, high] = [Math.min, Math.max].map((extreme) => [0, 1, 2].map((i) => points.reduce((most, point) => extreme(most, point[i]), points[0][i])));
    return { middle: times(add(low, high), 0.5), size: Math.max(size(add(high, times(low, -1))), 1e-6), floor: low[2] };
  };
  const near = room(true), whole = room(false), follows = whole.size > 2 * near.size, reach = follows ? near : whole;
  const home = { yaw: 0.9, pitch: 0.35, distance: 1.5 * reach.size, target: [...reach.middle] };
  let eye = { ...home, target: [...home.target] };

  // How long arrows are: the longest force, and moment, of the whole motion is a quarter of the robot.
  const unitOf = ({ moment }) => moment ? "N m" : "N";
  const scales = {};
  function rescale() {
    const most = {};
    for (const arrow of robots.flatMap((robot) => motionOf(robot).arrows)) {
      const unit = unitOf(arrow), rows = Math.max(...arrow.values.map((v) => typeof v === "object" ? 1 : arrays[v].length));
      for (let k = 0; k < rows; k++) most[unit] = Math.max(most[unit] ?? 0, size(arrow.values.map((v) => valueOf(v, [k, k, 0]))));
    }
    for (const unit of ["N", "N m"]) scales[unit] = 0.25 * reach.size / (most[unit] || 1);
    const words = Object.keys(most).sort().map((unit) => `0.1 m of arrow: ${Number((0.1 / scales[unit]).toPrecision(3))} ${unit}`);
    $("scale").textContent = words.join("; ") + (words.length ? "." : "");
  }

  function arrowsOf(robot, all) {
    const motion = motionOf(robot);
    if (motion.time === null && motion.arrows.some((arrow) => arrow.values.some((v) => typeof v !== "object"))) return [];
    const at = motion.time === null ? [0, 0, 0] : between(arrays[motion.time], state.time);
    return motion.arrows.map((arrow) => {
      const own = arrow.values.map((v) => valueOf(v, at)), value = size(own);
      const vector = arrow.axes === null ? own : turned(all[arrow.axes], own);
      return { ...arrow, vector, value, from: moved(all[arrow.body], arrow.point), length: value * scales[unitOf(arrow)] };
    });
  }

  let now = null;
  const placed = () => now = robots.map((robot) => {
    const all = poses(robot, configuration(robot));
    return { robot, all, arrows: arrowsOf(robot, all) };
  });

  function lens(width, height) {
    const near = eye.distance / 100, far = eye.distance * 20, f = 1 / Math.tan(0.35);
    return [f * Math.min(1, height / width), 0, 0, 0, 0, f * Math.min(1, width / height), 0, 0,
      0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
  }
  function basis() {
    const back = [Math.cos(eye.pitch) * Math.cos(eye.yaw), Math.cos(eye.pitch) * Math.sin(eye.yaw), Math.sin(eye.pitch)];
    const right = [-Math.sin(eye.yaw), Math.cos(eye.yaw), 0], up = cross(back, right);
    return { back, right, up };
  }
  function view() {
    const { back, right, up } = basis(), way = state.layers.follow ? gone(now[0].all) : [0, 0, 0];
    const from = add(add(eye.target, way), times(back, eye.distance));
    return [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
      -dot(right, from), -dot(up, from), -dot(back, from), 1];
  }
  const along = (from, vector, radius, length) => {
    const z = times(vector, 1 / (size(vector) || 1)), other = Math.abs(z[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
    const x = cross(other, z), one = times(x, 1 / size(x)), two = cross(z, one);
    return [...times(one, radius), 0, ...times(two, radius), 0, ...times(z, length), 0, ...from, 1];
  };
  const useColour = (share) => share > 1 ? rgb("bad") : share > 0.8 ? rgb("doubtful") : share >= 0 ? mix(rgb("body"), rgb("good"), share / 0.8) : rgb("body");
  const mix = (a, b, s) => a.map((x, k) => x + s * (b[k] - x));

  function draw(model, shape, colour, alpha = 1, shaded = 1, kind = gl.TRIANGLES) {
    gl.uniformMatrix4fv(uniform.model, false, model);
    gl.uniform4f(uniform.colour, ...colour, alpha);
    gl.uniform1f(uniform.shaded, shaded);
    gl.bindVertexArray(shape.array);
    gl.drawElements(kind, shape.count, gl.UNSIGNED_INT, 0);
  }
  function useOf(robot, k) {
    const motion = motionOf(robot), use = motion.use && motion.use[k];
    if (!use || motion.time === null) return -1;
    return Math.abs(sample(arrays[use.values], between(arrays[motion.time], state.time))) / use.limit;
  }
  // Bodies: their meshes, or bars from joint to joint where there are none; `paint` gives the colour.
  function drawBodies(paint, wanted = () => true) {
    const thin = 0.006 * reach.size;
    now.forEach(({ robot, all }, r) => robot.bodies.forEach((body, k) => {
      const [colour, alpha, shaded] = paint(robot, r, body, k);
      if (!wanted(alpha)) return;
      for (const mesh of body.meshes) draw(all[k], meshes[mesh], colour, alpha, shaded);
      if (body.meshes.length && !stage.bars) return;
      const ends = robot.bodies.flatMap((child, c) => child.parent === k ? [all[c].slice(12, 15)] : []);
      if (!ends.length) ends.push(moved(all[k], body.centre));
      const from = all[k].slice(12, 15);
      for (const end of ends) {
        const bar = end.map((x, i) => x - from[i]);
        if (size(bar)) draw(along(from, bar, thin, size(bar)), shaft, colour, alpha, shaded);
      }
      if (!body.meshes.length) draw(along(from, [0, 0, 1], 2 * thin, 2 * thin), ball, colour, alpha, shaded);
    }));
  }
  function frame(back) {
    const { width, height } = canvas;
    placed();
    gl.viewport(0, 0, width, height);
    gl.useProgram(program);
    gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix4fv(uniform.view, false, view());
    gl.uniformMatrix4fv(uniform.lens, false, lens(width, height));
    gl.clearColor(...back, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }
  function render() {
    dirty = false;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((each) => Math.max(1, Math.round(each * devicePixelRatio)));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    frame(rgb("raised"));
    const step = 10 ** Math.floor(Math.log10(reach.size)) / 2;
    const [x, y] = state.layers.follow ? gone(now[0].all).map((each) => step * Math.round(each / step)) : [0, 0];
    const ground = [step, 0, 0, 0, 0, step, 0, 0, 0, 0, 1, 0, x, y, stage.floor ?? reach.floor, 1];
    draw(ground, grid, rgb("grid"), 1, 0, gl.LINES);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    const see = state.layers.through ? 0.35 : 1;
    const paint = (robot, r, body, k) => {
      const picked = state.picked && state.picked[0] === r && state.picked[1] === k;
      const colour = picked ? rgb("c1") : body.lit ? rgb(body.lit) : robot.colour ? rgb(robot.colour) : useColour(useOf(robot, k));
      return [colour, (robot.alpha ?? 1) * see, 1];
    };
    drawBodies(paint, (alpha) => alpha === 1);
    const thin = 0.008 * reach.size, radius = 0.012 * reach.size;
    for (const { robot, all, arrows } of now) {
      if (state.layers.centres) robot.bodies.forEach((body, k) => {
        if (body.mass) draw(along(moved(all[k], body.centre), [0, 0, 1], radius, radius), ball, rgb(robot.colour ?? "c3"));
      });
      // Arrows shine through what hides them: faintly on top of all, then as they stand.
      for (const through of [true, false]) for (const arrow of arrows) {
        if (!state.layers[arrow.kind] || arrow.length < 1e-4 * reach.size) continue;
        gl[through ? "disable" : "enable"](gl.DEPTH_TEST);
        const colour = rgb(stage.kinds[arrow.kind].colour), tip = Math.min(4 * thin, 0.5 * arrow.length), unit = times(arrow.vector, 1 / size(arrow.vector));
        const tips = arrow.moment ? [tip, Math.min(1.8 * tip, arrow.length)] : [tip]; // of moments two, by the right-hand rule
        const alpha = through ? 0.35 : 1;
        draw(along(arrow.from, unit, thin * 0.6, arrow.length - tip), shaft, colour, alpha);
        for (const before of tips) draw(along(add(arrow.from, times(unit, arrow.length - before)), unit, 0.5 * tip, tip), head, colour, alpha);
      }
      gl.enable(gl.DEPTH_TEST);
    }
    const marks = stage.marks.filter(({ what }) => state.layers[what]), drawMarks = (wanted) => marks.filter(wanted).forEach(
      ({ colour, alpha, pieces }) => pieces.forEach(([at, vector, wide]) => draw(along(at, vector, wide, size(vector)), disc, rgb(colour), alpha)));
    drawMarks(({ alpha }) => alpha === 1);
    // What is seen through comes last, hides nothing, and gives way where a solid has the same surface.
    gl.depthMask(false);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    drawBodies(paint, (alpha) => alpha < 1);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    drawMarks(({ alpha }) => alpha < 1);
    for (const { robot, all, arrows } of now) {
      if (state.layers.inertia) robot.bodies.forEach((body, k) => {
        if (!body.ellipsoid) return;
        const [axes, half] = body.ellipsoid, own = place(axes, body.centre);
        const M = product(all[k], own.map((x, i) => i < 12 ? x * half[i >> 2] : x));
        draw(M, ball, rgb(robot.colour ?? "c4"), 0.4);
      });
      for (const arrow of arrows) {
        if (!state.layers[arrow.kind] || !arrow.cone) continue;
        const [mu, ...normal] = arrow.cone, up = 0.12 * reach.size;
        draw(along(add(arrow.from, times(normal, up)), times(normal, -1), mu * up, up), head, rgb(stage.kinds[arrow.kind].colour), 0.2);
      }
    }
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }
  let dirty = false;
  const redraw = () => {
    if (!dirty) requestAnimationFrame(render);
    dirty = true;
  };

  // Picking: bodies in colours that are their numbers, read below the pointer.
  function pick(x, y) {
    const target = gl.createFramebuffer(), colour = gl.createTexture(), depth = gl.createRenderbuffer();
    gl.bindTexture(gl.TEXTURE_2D, colour);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, canvas.width, canvas.height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, canvas.width, canvas.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colour, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    frame([0, 0, 0]);
    drawBodies((robot, r, body, k) => [[(r + 1) / 255, (k >> 8) / 255, (k & 255) / 255], 1, 0]);
    const ratio = canvas.width / canvas.clientWidth, found = new Uint8Array(4);
    gl.readPixels(Math.round(x * ratio), canvas.height - 1 - Math.round(y * ratio), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, found);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    for (const [what, one] of [["Framebuffer", target], ["Texture", colour], ["Renderbuffer", depth]]) gl[`delete${what}`](one);
    choose(found[0] ? [found[0] - 1, 256 * found[1] + found[2]] : null);
  }

  // The free body of the picked link, in its axes about its origin: what acts on it adds up to the rate of its momentum.
  function freeBody({ robot, all, arrows }, k) {
    const at = all[k].slice(12, 15), parts = {};
    for (const { body, kind, what, from, moment, vector } of arrows) {
      const sign = body === k ? 1 : robot.bodies[body].parent === k && kind === "reaction" ? -1 : 0;
      if (!sign || kind === "torque") continue;
      const part = parts[`${body} ${what}`] ??= [sign < 0 ? `${what}, opposite` : what, 0, 0, 0, 0, 0, 0], own = times(turnedBack(all[k], vector), sign);
      const turn = moment ? own : times(turnedBack(all[k], cross(add(from, times(at, -1)), vector)), sign);
      for (let i = 0; i < 3; i++) {
        if (!moment) part[1 + i] += own[i];
        part[4 + i] += turn[i];
      }
    }
    return Object.values(parts);
  }
  const summed = (robot) => motionOf(robot).arrows.some(({ kind }) => kind === "reaction" || kind === "base");
  function tell() {
    const panel = $("panel");
    panel.replaceChildren();
    panel.hidden = !state.picked;
    if (!state.picked) return;
    const [r, k] = state.picked, { robot } = now[r], body = robot.bodies[k], share = useOf(robot, k), rows = freeBody(now[r], k);
    const number = (x, most = 1) => Math.abs(x) < 1e-7 * most ? "0" : Number(x.toPrecision(5)).toString();
    panel.append(element("h3", {}, nameOf(robot, body)));
    panel.append(element("p", {}, `${number(body.mass)} kg, mass centre (${body.centre.map((x) => number(x)).join(", ")}) m${body.words ? `; ${body.words}` : ""}`));
    if (share >= 0) panel.append(element("p", {}, `joint ${body.joint}: ${number(100 * share)} % of its limit now`));
    if (!rows.length) return;
    const line = (tag, scope, [what, ...cells]) => element("tr", {}, element("th", { scope }, what), ...cells.map((cell) => element(tag, scope === "col" ? { scope } : {}, cell)));
    const sum = ["sum", 1, 2, 3, 4, 5, 6].map((i) => i === "sum" ? i : rows.reduce((all, row) => all + row[i], 0));
    const most = [1, 4].map((i) => Math.max(...rows.flatMap((row) => row.slice(i, i + 3).map(Math.abs))));
    const numbers = ([what, ...values]) => [what, ...values.map((value, i) => number(value, most[i < 3 ? 0 : 1]))];
    panel.append(element("table", {},
      element("thead", {}, line("th", "col", ["in its axes, about its origin", "fx [N]", "fy", "fz", "mx [N m]", "my", "mz"])),
      element("tbody", {}, ...[...rows, ...(summed(robot) ? [sum] : [])].map((row) => line("td", "row", numbers(row))))));
    if (!summed(robot)) panel.append(element("p", {}, "What joints bear is not among these: robodyn torques computes it."));
  }
  const nameOf = (robot, body) => robots.length > 1 && robot.name !== body.name ? `${robot.name}: ${body.name}` : body.name;
  function choose(what) {
    state.picked = what;
    $("links").value = what ? what.join() : "";
    changed();
  }
  function changed() {
    placed();
    tell();
    redraw();
  }

  const clockWords = () => {
    const motion = motionOf(robots[0]);
    if (motion.time === null) return "";
    const number = motion.rows === null ? "" : `, row ${Math.round(sample(arrays[motion.rows], between(arrays[motion.time], state.time)))}`;
    return `${Number(state.time.toPrecision(7))} s${number}`;
  };
  function setTime(t, told = false) {
    const [first, last] = span();
    state.time = Math.min(Math.max(t, first), last);
    $("time").value = state.time;
    $("clock").textContent = clockWords();
    $("time").setAttribute("aria-valuetext", clockWords());
    if (!told) onTime(state.time);
    if (state.picked) changed(); else redraw();
  }

  // Controls: every one is an element that the keyboard reaches.
  const [first, last] = span(), moves = last > first;
  $("player").hidden = !moves;
  Object.assign($("time"), { min: first, max: last, step: "any", value: first });
  $("time").addEventListener("input", (event) => setTime(Number(event.target.value)));
  $("play").addEventListener("click", () => play(!state.playing));
  function play(on) {
    const [first, last] = span(), pace = stage.loop ? (last - first) / 5 : 1; // a pass in 5 s, however fast it really is
    state.playing = on;
    $("play").textContent = on ? "Pause" : "Play";
    if (on && state.time >= last) setTime(first);
    let before = null;
    const step = (stamp) => {
      if (!state.playing) return;
      if (before !== null) setTime(state.time + pace * state.speed * (stamp - before) / 1000);
      before = stamp;
      if (state.time >= last && !stage.loop) return play(false);
      if (state.time >= last) setTime(first);
      requestAnimationFrame(step);
    };
    if (on) requestAnimationFrame(step);
  }
  $("speed").addEventListener("change", (event) => { state.speed = Number(event.target.value); });
  $("home").addEventListener("click", () => { eye = { ...home, target: [...home.target] }; redraw(); });
  const present = new Set(robots.flatMap((robot) => robot.motions.flatMap((motion) => motion.arrows.map((arrow) => arrow.kind))));
  const some = (key) => robots.some((robot) => robot.bodies.some((body) => body[key]));
  const layers = Object.entries(stage.kinds).filter(([kind]) => present.has(kind)).map(([kind, { what, on, colour }]) => [kind, what, on, colour]);
  if (some("mass")) layers.push(["centres", "mass centres", stage.ellipsoids || stage.marks.length > 0]);
  if (some("ellipsoid")) layers.push(["inertia", "ellipsoids of inertia", stage.ellipsoids]);
  if (floats >= 0 && motionOf(robots[0]).time !== null) layers.push(["follow", "follow the base", follows]);
  layers.push(["through", "see through", stage.through], ...stage.marks.map(({ what, on, colour }) => [what, what, on, colour]));
  for (const [kind, what, on, colour] of layers) {
    const box = element("input", { type: "checkbox", checked: Boolean(on), value: kind }), dot = element("i", {});
    state.layers[kind] = on;
    box.addEventListener("change", () => { state.layers[kind] = box.checked; redraw(); });
    dot.style.background = `var(--${colour})`;
    $("layers").append(element("label", {}, box, ...(colour ? [dot] : []), ` ${what}`));
  }
  robots.forEach((robot, r) => robot.bodies.forEach((body, k) => {
    const empty = !body.mass && !body.meshes.length, named = robot.bodies.filter(({ name }) => name === body.name);
    if (!empty || named.length < 2) $("links").append(new Option(nameOf(robot, body), `${r},${k}`)); // a planar joint has three
  }));
  $("links").addEventListener("change", (event) => choose(event.target.value ? event.target.value.split(",").map(Number) : null));
  const names = robots[0].motions.map((motion) => motion.name);
  $("motions").parentElement.hidden = names.length < 2;
  names.forEach((name, k) => $("motions").append(new Option(name, k)));
  $("motions").addEventListener("change", (event) => {
    state.motion = Number(event.target.value);
    const [from, to] = span();
    Object.assign($("time"), { min: from, max: to });
    rescale();
    showSliders();
    setTime(from);
  });
  function showSliders() {
    state.sliders = {};
    $("sliders").replaceChildren(...(motionOf(robots[0]).sliders ?? []).map(sliderOf));
  }
  function sliderOf({ name, q, unit, lower, upper, value }) {
    const input = element("input", { type: "range", min: lower, max: upper, step: "any", value }), output = element("output", {});
    const show = (x) => { output.textContent = `${Number(x.toPrecision(4))} ${unit}`; };
    input.addEventListener("input", () => {
      state.sliders[q] = Number(input.value);
      show(state.sliders[q]);
      changed();
    });
    show(value);
    return element("label", {}, name, input, output);
  }
  showSliders();

  const fingers = new Map();
  let far = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    far = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId), to = [event.offsetX, event.offsetY];
    if (!before) return;
    const step = [to[0] - before[0], to[1] - before[1]], other = [...fingers.values()].find((each) => each !== before);
    const gap = (point) => Math.hypot(point[0] - other[0], point[1] - other[1]) || 1;
    far += Math.hypot(...step);
    if (other) {
      eye.distance *= gap(before) / gap(to);
      orbit(step[0] / 2, step[1] / 2);
    } else (event.shiftKey || event.buttons === 2 ? pan : orbit)(...step);
    fingers.set(event.pointerId, to);
    redraw();
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (event) => {
    if (kind === "pointerup" && fingers.size === 1 && far < 4) pick(event.offsetX, event.offsetY);
    fingers.delete(event.pointerId);
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return; // the page scrolls
    event.preventDefault();
    eye.distance *= Math.exp(event.deltaY / 600);
    redraw();
  }, { passive: false });
  function orbit(x, y) {
    eye.yaw -= x / 150;
    eye.pitch = Math.min(Math.max(eye.pitch + y / 150, -1.55), 1.55);
  }
  function pan(x, y) {
    const { right, up } = basis(), unit = eye.distance / canvas.clientHeight;
    eye.target = add(eye.target, add(times(right, -x * unit), times(up, y * unit)));
  }
  canvas.addEventListener("keydown", (event) => {
    const ways = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, -12], ArrowDown: [0, 12] };
    const zooms = { "+": 1 / 1.15, "=": 1 / 1.15, "-": 1.15 };
    if (ways[event.key]) (event.shiftKey ? pan : orbit)(...ways[event.key]);
    else if (zooms[event.key]) eye.distance *= zooms[event.key];
    else return;
    event.preventDefault();
    redraw();
  });
  new ResizeObserver(redraw).observe(canvas);
  rescale();
  setTime(first, true);
  return {
    setTime: (t) => setTime(t, true),
    redraw,
    render,
    pick: (r, k) => choose([r, k]),
    // What tests read back: where every link is, and how long arrows are.
    poses: () => placed().map(({ robot, all }) => Object.fromEntries(robot.bodies.map((body, k) => [body.name, all[k]]))),
    arrows: () => placed().flatMap(({ robot, arrows }) => arrows.map((arrow) => ({ ...arrow, body: robot.bodies[arrow.body].name }))),
    scales: () => ({ ...scales }),
  };
}
