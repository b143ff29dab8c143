"use strict";
// The replay: bodies, water, contacts and lines by WebGL 2; nothing here is input.
(() => {
  const { data, floats } = window.hydrosim;
  const given = data.replay, root = document.getElementById("replay");
  const canvas = root.querySelector("canvas");
  const gl = canvas.getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
  if (!gl) { root.querySelector(".grave").hidden = false; return; }
  const time = floats(given.time), position = floats(given.position);
  const modes = floats(given.modes), forces = floats(given.forces), tensions = floats(given.tensions), levels = floats(given.levels);
  const bodies = given.bodies.length, contacts = given.contacts.length, lines = given.lines.length, tanks = given.tanks.length;
  const largest = (values) => values.reduce((most, x) => (x > most ? x : most), 1e-9);
  const HANGING = 13;  // points of a catenary
  const hung = given.lines.map((line) => line.shape ? floats(line.shape) : null);
  const hardest = largest(forces), tightest = largest(tensions);
  const waves = given.waves.map((set) => {
    const found = { ramp: set.ramp };
    for (const name of ["omega", "amplitude", "phase", "wavenumber", "heading"]) found[name] = floats(set[name]);
    return found;
  });
  const hollow = new Set(given.tanks.map((tank) => tank.body));  // bodies that one looks into
  const OPEN = [0.75, 0.75, 0.75], MODES = [OPEN, [0, 0.45, 0.7], [0.9, 0.62, 0]];
  const HULLS = [[0.62, 0.25, 0.2], [0.78, 0.68, 0.42], [0.4, 0.5, 0.35], [0.5, 0.42, 0.6]];
  const lengths = given.length_unit, decimals = Math.min(Math.max(2 - Math.floor(Math.log10(hardest * given.force_unit.factor)), 0), 6);
  const read = (force) => (force * given.force_unit.factor).toFixed(decimals);  // about three digits of the largest
  const N = 64;  // lines of the water each way

  const multiply = (a, b) => {
    const c = new Float32Array(16);
    for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
    return c;
  };
  const minus = (a, b) => a.map((x, k) => x - b[k]);
  const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
  const unit = (a) => { const n = Math.hypot(...a) || 1; return a.map((x) => x / n); };
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const apply = (m, p) => [0, 1, 2].map((i) => m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i]);
  function perspective(angle, aspect, near, far) {
    const f = 1 / Math.tan(angle / 2), m = new Float32Array(16);
    m[0] = f / aspect; m[5] = f; m[10] = (far + near) / (near - far); m[11] = -1; m[14] = 2 * far * near / (near - far);
    return m;
  }
  function lookAt(eye, at) {
    const z = unit(minus(eye, at)), x = unit(cross([0, 0, 1], z)), y = cross(z, x);
    return new Float32Array([x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1]);
  }
  // rotations are intrinsic z-y'-x''
  function placed(place, roll, pitch, yaw) {
    const [a, b, c, d, e, f] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch), Math.cos(roll), Math.sin(roll)];
    return new Float32Array([
      a * c, b * c, -d, 0, a * d * f - b * e, b * d * f + a * e, c * f, 0,
      a * d * e + b * f, b * d * e - a * f, c * e, 0, ...place, 1]);
  }
  const IDENTITY = placed([0, 0, 0], 0, 0, 0);

  function program(vertex, fragment) {
    const made = gl.createProgram();
    for (const [kind, code] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + code);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.bindAttribLocation(made, 0, "p");
    gl.linkProgram(made);
    return made;
  }
  const shading = program(
    "in vec3 p; uniform mat4 model, view; out vec3 w; void main() { w = (model * vec4(p, 1.0)).xyz; gl_Position = view * vec4(w, 1.0); }",
    `in vec3 w; uniform vec4 colour; uniform float lit, swell; out vec4 seen;
     void main() {
       vec3 n = normalize(cross(dFdx(w), dFdy(w)));
       float light = mix(1.0, 0.45 + 0.55 * abs(dot(n, normalize(vec3(0.4, 0.25, 0.88)))), lit);
       seen = vec4(colour.rgb * light + swell * w.z, colour.a);
     }`);
  gl.useProgram(shading);
  const at = (name) => gl.getUniformLocation(shading, name);
  const U = { model: at("model"), view: at("view"), colour: at("colour"), lit: at("lit"), swell: at("swell") };
  function buffer(values, indices) {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const points = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, points);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    if (indices) { gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer()); gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW); }
    return { array, points, count: indices ? indices.length : values.length / 3, indexed: Boolean(indices) };
  }
  function draw(mesh, model, colour, lit = 1, kind = gl.TRIANGLES) {
    gl.bindVertexArray(mesh.array);
    gl.uniformMatrix4fv(U.model, false, model);
    gl.uniform4fv(U.colour, colour);
    gl.uniform1f(U.lit, lit);
    if (mesh.indexed) gl.drawElements(kind, mesh.count, gl.UNSIGNED_SHORT, 0); else gl.drawArrays(kind, 0, mesh.count);
  }

  const hulls = given.bodies.map((body) => buffer(floats(body.triangles)));
  const sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  const faces = sides.flatMap((q) => [q[0], q[1], q[2], q[0], q[2], q[3]]).flatMap((k) => [k >> 2, (k >> 1) & 1, k & 1]);
  const cube = buffer(new Float32Array(faces));  // from 0 to 1 each way
  const tip = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], marker = [];
  for (const z of [1, -1]) for (let k = 0; k < 4; k++) marker.push(...tip[k], ...tip[(k + 1) % 4], 0, 0, z);
  const point = buffer(new Float32Array(marker));
  const planes = given.planes.map((plane) => {
    const fan = [];
    for (let k = 1; k + 1 < plane.corners.length; k++) fan.push(...plane.corners[0], ...plane.corners[k], ...plane.corners[k + 1]);
    return { body: plane.body, mesh: buffer(new Float32Array(fan)) };
  });
  const supports = given.supports.map((one) => ({ body: one.body, contact: one.contact, mesh: buffer(floats(one.triangles)) }));
  const joints = given.joints.map((joint) => ({ ...joint, mesh: buffer(floats(joint.triangles)) }));
  const string = buffer(new Float32Array(6));
  const R = given.size, middle = [0, 1, 2].map((i) => given.rest.reduce((sum, x) => sum + x[i], 0) / bodies);
  const surface = new Float32Array(3 * N * N), cells = new Uint16Array(6 * (N - 1) * (N - 1));
  const places = Float32Array.from({ length: N }, (_, k) => R * (4 * k / (N - 1) - 2));
  for (let i = 0, c = 0; i < N - 1; i++) for (let j = 0; j < N - 1; j++) {
    const k = i * N + j;
    cells.set([k, k + 1, k + N, k + 1, k + N + 1, k + N], c); c += 6;
  }
  const water = buffer(surface, cells);
  // still water around the patch of waves, so that it does not end in a void
  const FAR = 25 * R, EDGE = 1.998 * R, ring = [];
  for (const [x1, x2, y1, y2] of [[-FAR, FAR, -FAR, -EDGE], [-FAR, FAR, EDGE, FAR], [-FAR, -EDGE, -EDGE, EDGE], [EDGE, FAR, -EDGE, EDGE]]) {
    const [a, b, c, d] = [[x1, y1], [x2, y1], [x2, y2], [x1, y2]].map(([x, y]) => [x + middle[0], y + middle[1], 0]);
    ring.push(...a, ...b, ...c, ...a, ...c, ...d);
  }
  const horizon = buffer(new Float32Array(ring));
  const rough = Math.sqrt(waves.reduce((sum, set) => sum + dot(Array.from(set.amplitude), Array.from(set.amplitude)) / 2, 1e-6));
  // e^(i k (x cos b + y sin b)) is a product of what depends on x and what depends on y
  for (const set of waves) {
    const n = set.omega.length;
    for (const [key, along] of [["x", Math.cos], ["y", Math.sin]]) {
      set[key] = [new Float32Array(N * n), new Float32Array(N * n)];
      for (let k = 0; k < N; k++) for (let m = 0; m < n; m++) {
        const angle = set.wavenumber[m] * along(set.heading[m]) * (places[k] + middle[key === "x" ? 0 : 1]);
        set[key][0][k * n + m] = Math.cos(angle); set[key][1][k * n + m] = Math.sin(angle);
      }
    }
  }
  function elevate(t, factor) {
    const heights = new Float32Array(N * N);
    for (const set of waves) {
      const n = set.omega.length, grown = set.ramp > 0 ? Math.min(t / set.ramp, 1) : 1;
      const rise = 0.5 * (1 - Math.cos(Math.PI * grown));
      const re = new Float32Array(n), im = new Float32Array(n), a = new Float32Array(n), b = new Float32Array(n);
      for (let m = 0; m < n; m++) {
        const angle = set.omega[m] * t + set.phase[m];
        re[m] = rise * set.amplitude[m] * Math.cos(angle); im[m] = rise * set.amplitude[m] * Math.sin(angle);
      }
      for (let i = 0; i < N; i++) {
        for (let m = 0; m < n; m++) {
          const c = set.x[0][i * n + m], s = set.x[1][i * n + m];
          a[m] = re[m] * c + im[m] * s; b[m] = im[m] * c - re[m] * s;
        }
        for (let j = 0; j < N; j++) {
          let sum = 0;
          const c = set.y[0], s = set.y[1], o = j * n;
          for (let m = 0; m < n; m++) sum += a[m] * c[o + m] + b[m] * s[o + m];
          heights[i * N + j] += sum;
        }
      }
    }
    for (let i = 0; i < N; i++) for (let j = 0; j < N; j++) {
      surface.set([places[i] + middle[0], places[j] + middle[1], factor * heights[i * N + j]], 3 * (i * N + j));
    }
  }

  const state = { t: time[0], playing: false, speed: 10, factor: given.factor, follow: false, turn: -0.9, tilt: 0.35, away: 3.2 };
  const VIEWS = { quarter: [-0.9, 0.35, 3.2], side: [-Math.PI / 2, 0.06, 2.8], bow: [0, 0.1, 2.6], top: [-Math.PI / 2, 1.5, 3.2] };
  const slider = root.querySelector("input[type=range]"), output = root.querySelector("output");
  const pressed = root.querySelector(".forces"), play = root.querySelector("[data-act=play]");
  slider.min = time[0]; slider.max = time[time.length - 1];

  function moment(t) {
    let low = 0, high = time.length - 2;
    while (low < high) { const mid = (low + high + 1) >> 1; if (time[mid] <= t) low = mid; else high = mid - 1; }
    return [low, Math.min(Math.max((t - time[low]) / (time[low + 1] - time[low]), 0), 1)];
  }
  function modelOf(body, [k, part]) {
    const q = [0, 1, 2, 3, 4, 5].map((i) => {
      const a = position[(k * bodies + body) * 6 + i], b = position[((k + 1) * bodies + body) * 6 + i];
      return state.factor * ((Number.isFinite(b) ? a + part * (b - a) : a) || 0);
    });
    return placed(given.rest[body].map((x, i) => x + q[i]), q[3], q[4], q[5] + given.heading[body]);
  }

  // names, axes, directions of the waves and a scale, drawn over the scene
  const sheet = root.querySelector("canvas.names"), pen = sheet.getContext("2d");
  const towards = waves.map((set) => {
    const weight = Array.from(set.amplitude, (a) => a * a);
    const sum = (along) => weight.reduce((total, w, m) => total + w * along(set.heading[m]), 0);
    return unit([sum(Math.cos), sum(Math.sin), 0]);
  });
  function seen(view, p, width, height) {
    const clip = [0, 1, 3].map((i) => view[i] * p[0] + view[4 + i] * p[1] + view[8 + i] * p[2] + view[12 + i]);
    return clip[2] > 0 ? [(0.5 + 0.5 * clip[0] / clip[2]) * width, (0.5 - 0.5 * clip[1] / clip[2]) * height] : null;
  }
  function write(text, x, y) {
    pen.lineWidth = 3; pen.strokeStyle = "rgba(255, 255, 255, 0.8)"; pen.strokeText(text, x, y);
    pen.fillStyle = "#14181c"; pen.fillText(text, x, y);
  }
  function point2d(from, along, length, text) {
    const n = Math.hypot(...along) || 1, [dx, dy] = [along[0] / n, along[1] / n], [x, y] = [from[0] + length * dx, from[1] + length * dy];
    pen.lineWidth = 2; pen.strokeStyle = pen.fillStyle = "#14181c";
    pen.beginPath(); pen.moveTo(...from); pen.lineTo(x, y); pen.stroke();
    pen.beginPath(); pen.moveTo(x + 4 * dx, y + 4 * dy); pen.lineTo(x - 6 * dx - 4 * dy, y - 6 * dy + 4 * dx); pen.lineTo(x - 6 * dx + 4 * dy, y - 6 * dy - 4 * dx); pen.fill();
    write(text, x + 12 * dx, y + 12 * dy);
  }
  // points of a catenary: shares of the way between its ends, and heights above the straight line
  function sagging(shape, moment, start, end) {
    const first = moment * 2 * HANGING, points = [];
    for (let k = 0; k < HANGING; k++) {
      const share = shape[first + 2 * k], sag = shape[first + 2 * k + 1];
      points.push(start.map((x, i) => x + share * (end[i] - x) + (i === 2 ? sag : 0)));
    }
    return points;
  }
  function annotate(view, models, target, far) {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    sheet.width = width * ratio; sheet.height = height * ratio;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "13px system-ui, sans-serif"; pen.textAlign = "center"; pen.textBaseline = "middle";
    const at = (p) => seen(view, p, width, height), middleSeen = at(target);
    const turned = (d) => { const tip = at(target.map((x, i) => x + 0.05 * R * d[i])); return tip && middleSeen ? minus(tip, middleSeen) : [1, 0]; };
    given.bodies.forEach((body, k) => { const place = at(Array.from(models[k].slice(12, 15))); if (place) write(body.name, ...place); });
    given.lines.slice(0, 12).forEach((line) => {
      const start = line.body < 0 ? line.point : apply(models[line.body], line.point), place = at(start);
      if (place) write(line.name, ...place);
    });
    joints.slice(0, 12).forEach((joint) => { const place = at(apply(models[joint.body], joint.point)); if (place) write(joint.name, ...place); });
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis, k) => point2d([60, height - 60], turned(axis), 30, "xyz"[k]));
    towards.forEach((along, k) => point2d([width - 110 - 100 * k, 50], turned(along), 36, towards.length > 1 ? `waves ${k + 1}` : "waves"));
    const pixels = height / (2 * Math.tan(0.3) * far * lengths.factor), power = 10 ** Math.floor(Math.log10(140 / pixels));
    const length = [5, 2, 1].map((m) => m * power).find((x) => x * pixels <= 140);
    pen.lineWidth = 2; pen.strokeStyle = "#14181c"; pen.beginPath();
    pen.moveTo(width - 24, height - 32); pen.lineTo(width - 24 - length * pixels, height - 32); pen.stroke();
    write(`${length} ${lengths.unit}`, width - 24 - 0.5 * length * pixels, height - 18);
  }

  let shown = -1;
  function render() {
    const ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * ratio; canvas.height = canvas.clientHeight * ratio;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0.81, 0.87, 0.91, 1); gl.enable(gl.DEPTH_TEST); gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const now = moment(state.t), models = given.bodies.map((_, body) => modelOf(body, now));
    const modelFor = (body) => (body < 0 ? IDENTITY : models[body]);
    const target = state.follow ? Array.from(models[0].slice(12, 15)) : middle;
    const aspect = canvas.width / Math.max(canvas.height, 1);
    const far = state.away * R * Math.max(1, 1.3 / aspect), flat = Math.cos(state.tilt);
    const eye = [target[0] + far * flat * Math.cos(state.turn), target[1] + far * flat * Math.sin(state.turn), target[2] + far * Math.sin(state.tilt)];
    const view = multiply(perspective(0.6, aspect, 0.02 * R, 30 * R), lookAt(eye, target));
    gl.uniformMatrix4fv(U.view, false, view);
    hulls.forEach((hull, body) => { if (!hollow.has(body)) draw(hull, models[body], [...HULLS[body % 4], 1]); });
    for (let k = 0; k < tanks; k++) {
      const { body, low, high } = given.tanks[k], full = Math.min(Math.max(levels[now[0] * tanks + k] || 0, 0), 1);
      const model = new Float32Array(models[body]), size = [0, 1, 2].map((i) => (high[i] - low[i]) * (i < 2 ? 1 : Math.max(full, 1e-3)));
      for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) model[4 * i + j] *= size[i];
      model.set(apply(models[body], low), 12);
      draw(cube, model, [0.13, 0.45, 0.75, 1]);
    }
    for (let c = 0; c < contacts; c++) {
      const { body, point: place } = given.contacts[c];
      const force = forces[now[0] * contacts + c] || 0, mode = modes[now[0] * contacts + c] || 0;
      const s = R * (0.018 + 0.04 * Math.sqrt(Math.max(force, 0) / hardest)), model = new Float32Array(IDENTITY);
      model[0] = model[5] = model[10] = s; model.set(apply(modelFor(body), place), 12);
      draw(point, model, [...MODES[mode], 1]);
    }
    for (const { body, contact, mesh } of supports) {
      const force = forces[now[0] * contacts + contact] || 0, mode = modes[now[0] * contacts + contact] || 0;
      const share = 0.3 + 0.7 * Math.sqrt(Math.max(force, 0) / hardest);
      draw(mesh, modelFor(body), [...MODES[mode].map((x, i) => share * x + (1 - share) * OPEN[i]), 1]);
    }
    for (const { body, mesh } of joints) draw(mesh, modelFor(body), [0.95, 0.75, 0.1, 1]);
    for (let l = 0; l < lines; l++) {
      const line = given.lines[l], share = (tensions[now[0] * lines + l] || 0) / tightest;
      const ends = [apply(modelFor(line.body), line.point), apply(modelFor(line.anchor_body), line.anchor)];
      const points = hung[l] ? sagging(hung[l], now[0], ...ends) : ends;
      gl.bindBuffer(gl.ARRAY_BUFFER, string.points);
      for (let k = 1; k < points.length; k++) {
        gl.bufferSubData(gl.ARRAY_BUFFER, 0, new Float32Array([...points[k - 1], ...points[k]]));
        draw(string, IDENTITY, [0.15 + 0.75 * share, 0.2, 0.6 * (1 - share), 1], 0, gl.LINES);
      }
    }
    // after what is inside them; near and far sides of a hull that one looks into do not hide each other
    gl.depthMask(false);
    for (const body of hollow) draw(hulls[body], models[body], [...HULLS[body % 4], 0.25]);
    gl.depthMask(true);
    if (shown !== state.t + 1e9 * state.factor) {
      elevate(state.t, state.factor); shown = state.t + 1e9 * state.factor;
      gl.bindBuffer(gl.ARRAY_BUFFER, water.points); gl.bufferSubData(gl.ARRAY_BUFFER, 0, surface);
    }
    gl.uniform1f(U.swell, 0.06 / (state.factor * rough));
    draw(water, IDENTITY, [0.16, 0.4, 0.56, 0.66]);
    draw(horizon, IDENTITY, [0.16, 0.4, 0.56, 0.66]);
    gl.uniform1f(U.swell, 0);
    for (const plane of planes) draw(plane.mesh, modelFor(plane.body), [0.35, 0.35, 0.4, 0.55]);
    annotate(view, models, target, far);
    slider.value = state.t;
    output.textContent = `${state.t.toFixed(1)} s`;
    pressed.textContent = given.contacts.slice(0, 12).map((contact, c) => {
      const k = now[0] * contacts + c;
      return `${contact.name}: ${["open", "stick", "slip"][modes[k]] || ""} ${read(forces[k] || 0)} ${given.force_unit.unit}`;
    }).join("; ");
  }

  let asked = false, last = 0;
  function ask() {
    if (asked) return;
    asked = true;
    requestAnimationFrame((stamp) => {
      asked = false;
      if (state.playing) {
        state.t += Math.min(stamp - last, 100) / 1000 * state.speed; last = stamp;
        if (state.t >= time[time.length - 1]) { state.t = time[time.length - 1]; setPlaying(false); }
      }
      render();
      if (state.playing) ask();
    });
  }
  function setPlaying(on) {
    if (on && state.t >= time[time.length - 1]) state.t = time[0];
    state.playing = on; last = performance.now(); play.textContent = on ? "Pause" : "Play"; ask();
  }
  play.addEventListener("click", () => setPlaying(!state.playing));
  slider.addEventListener("input", () => { state.t = Number(slider.value); ask(); });
  for (const of of ["speed", "factor"]) {
    const select = root.querySelector(`[data-of=${of}]`);
    select.value = String(state[of]);
    select.addEventListener("change", () => { state[of] = Number(select.value); ask(); });
  }
  root.querySelector("[data-of=follow]").addEventListener("change", (event) => { state.follow = event.target.checked; ask(); });
  for (const button of root.querySelectorAll("[data-view]")) {
    button.addEventListener("click", () => { [state.turn, state.tilt, state.away] = VIEWS[button.dataset.view]; ask(); });
  }
  let from = null;
  const turn = (x, y) => { state.turn -= x; state.tilt = Math.min(Math.max(state.tilt + y, -1.5), 1.5); ask(); };
  const closer = (by) => { state.away = Math.min(Math.max(state.away * by, 0.1), 12); ask(); };
  canvas.addEventListener("pointerdown", (event) => { from = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointermove", (event) => {
    if (!from) return;
    turn(0.008 * (event.clientX - from[0]), 0.008 * (event.clientY - from[1]));
    from = [event.clientX, event.clientY];
  });
  canvas.addEventListener("pointerup", () => { from = null; });
  canvas.addEventListener("wheel", (event) => { if (event.ctrlKey || document.activeElement === canvas) { event.preventDefault(); closer(Math.exp(0.001 * event.deltaY)); } }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const acts = {
      ArrowLeft: () => turn(0.1, 0), ArrowRight: () => turn(-0.1, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1),
      "+": () => closer(0.85), "-": () => closer(1.18), " ": () => setPlaying(!state.playing),
    };
    if (acts[event.key]) { event.preventDefault(); acts[event.key](); }
  });
  window.addEventListener("resize", ask);
  window.hydrosim.replay = { places, middle, surface, models: (t) => given.bodies.map((_, body) => Array.from(modelOf(body, moment(t)))) };
  ask();
})();
