"use strict";
// Charts: lines or envelopes over time, linked by one span of time; nothing here is input.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const floats = (text) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Float32Array(bytes.buffer);
  };
  window.hydrosim = { data, floats, time: null, charts: [] };
  const time = floats(data.time);
  const COLOURS = ["#0072B2", "#E69F00", "ink", "#009E73", "#D55E00", "#56B4E9", "#CC79A7"];
  const DASHES = [[], [6, 3], [2, 2]];
  const MODES = [["stick", "#0072B2"], ["slip", "#E69F00"], ["open", "#BBBBBB"]];
  const LEFT = 64, RIGHT = 10, TOP = 8, BOTTOM = 24;
  const whole = [time.length ? time[0] : 0, data.end];
  let span = whole.slice();
  let cursor = null;
  const charts = [];
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const colour = (k) => (COLOURS[k % 7] === "ink" ? css("--ink") : COLOURS[k % 7]);
  const digits = (x) => (Number.isFinite(x) ? String(Number(x.toPrecision(5))) : "–");

  function ticks(low, high, count) {
    const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find((m) => m * power >= raw);
    const found = [];
    for (let k = Math.ceil(low / step); k * step <= high * (1 + 1e-12); k++) found.push(k * step);
    return found.map((x) => (Math.abs(x) < 1e-9 * step ? 0 : x));
  }

  class Chart {
    constructor(canvas, given) {
      Object.assign(this, { canvas, given, hidden: new Set() });
      this.rows = given.values.map(floats);
      this.legend = canvas.parentElement.querySelector(".legend");
      this.visible = false;
      this.drawLegend();
      this.listen();
    }

    get stretches() { return this.given.modes ? this.rows[0].length / 2 : time.length; }

    at(t) {
      const n = this.stretches;
      if (this.given.modes) return Math.min(n - 1, Math.floor((t - whole[0]) / (whole[1] - whole[0]) * n));
      let low = 0, high = n - 1;
      while (low < high) { const mid = (low + high + 1) >> 1; if (time[mid] <= t) low = mid; else high = mid - 1; }
      return low;
    }

    values(row, k) {
      const n = this.stretches, s = this.given.scale;
      return this.rows[row].length > n ? [s * this.rows[row][k], s * this.rows[row][n + k]] : [s * this.rows[row][k]];
    }

    range() {
      let low = Infinity, high = -Infinity;
      const a = this.at(span[0]), b = this.at(span[1]);
      this.rows.forEach((_, row) => {
        if (this.hidden.has(row)) return;
        for (let k = a; k <= b; k++) for (const y of this.values(row, k)) { if (y < low) low = y; if (y > high) high = y; }
      });
      if (!(low <= high)) return [-1, 1];
      const pad = 0.05 * (high - low) || 0.05 * Math.abs(high) || 1;
      return [low - pad, high + pad];
    }

    draw() {
      const canvas = this.canvas, ratio = window.devicePixelRatio || 1;
      const width = canvas.clientWidth, height = canvas.clientHeight;
      if (!width || !this.visible) return;
      canvas.width = width * ratio; canvas.height = height * ratio;
      const g = canvas.getContext("2d");
      g.scale(ratio, ratio);
      g.font = "12px system-ui, sans-serif";
      this.box = { width: width - LEFT - RIGHT, height: height - TOP - BOTTOM };
      const x = (t) => LEFT + (t - span[0]) / (span[1] - span[0]) * this.box.width;
      this.shade(g, x);
      this.axes(g, x, this.given.modes ? null : this.range());
      g.save();
      g.beginPath(); g.rect(LEFT, TOP, this.box.width, this.box.height); g.clip();
      if (this.given.modes) this.bands(g, x); else this.rows.forEach((_, row) => this.line(g, x, row));
      if (cursor !== null) { g.fillStyle = css("--soft"); g.fillRect(x(cursor), TOP, 1, this.box.height); }
      g.restore();
      this.read();
    }

    shade(g, x) {
      g.fillStyle = css("--shade");
      data.phases.filter((_, k) => k % 2).forEach(([, from, to]) => {
        const left = x(Math.max(from, span[0])), right = x(Math.min(to, span[1]));
        if (left < right) g.fillRect(left, TOP, right - left, this.box.height);
      });
    }

    axes(g, x, range) {
      g.fillStyle = css("--soft"); g.strokeStyle = css("--line"); g.lineWidth = 1;
      g.textAlign = "center"; g.textBaseline = "top";
      for (const t of ticks(...span, Math.max(this.box.width / 90, 2))) {
        g.beginPath(); g.moveTo(x(t), TOP); g.lineTo(x(t), TOP + this.box.height); g.stroke();
        g.fillText(digits(t) + " s", Math.min(x(t), LEFT + this.box.width - 16), TOP + this.box.height + 6);
      }
      g.textAlign = "right"; g.textBaseline = "middle";
      if (!range) return;
      this.y = (v) => TOP + (range[1] - v) / (range[1] - range[0]) * this.box.height;
      for (const v of ticks(...range, 5)) {
        g.beginPath(); g.moveTo(LEFT, this.y(v)); g.lineTo(LEFT + this.box.width, this.y(v)); g.stroke();
        g.fillText(digits(v), LEFT - 6, this.y(v));
      }
    }

    line(g, x, row) {
      if (this.hidden.has(row)) return;
      const style = this.given.styles[row];
      g.strokeStyle = g.fillStyle = colour(style);
      g.setLineDash(DASHES[Math.floor(style / 7) % 3]); g.lineWidth = 1.2;
      g.beginPath();
      let down = false;
      const first = Math.max(this.at(span[0]) - 1, 0), last = Math.min(this.at(span[1]) + 1, this.stretches - 1);
      for (let k = first; k <= last; k++) {
        const found = this.values(row, k);
        if (!found.every(Number.isFinite)) { down = false; continue; }
        for (const v of found) { if (down) g.lineTo(x(time[k]), this.y(v)); else g.moveTo(x(time[k]), this.y(v)); down = true; }
      }
      g.stroke(); g.setLineDash([]);
    }

    bands(g, x) {
      const n = this.stretches, each = this.box.height / this.rows.length, dt = (whole[1] - whole[0]) / n;
      this.rows.forEach((shares, row) => {
        for (let k = this.at(span[0]); k <= this.at(span[1]); k++) {
          const a = x(whole[0] + k * dt), width = x(whole[0] + (k + 1) * dt) - a + 0.5;
          const parts = [shares[k], shares[n + k], 1 - shares[k] - shares[n + k]];
          let top = TOP + each * (row + 1) - 0.1 * each;
          parts.forEach((part, m) => {
            const height = 0.8 * each * part;
            g.fillStyle = MODES[m][1]; top -= height; g.fillRect(a, top, width, height);
          });
        }
        g.fillStyle = css("--ink"); g.textAlign = "left"; g.textBaseline = "bottom";
      });
      g.restore(); g.save();
      g.fillStyle = css("--soft"); g.textAlign = "right"; g.textBaseline = "middle";
      this.rows.forEach((_, row) => {
        const name = this.given.names[row], label = name.length > 14 ? "…" + name.slice(-13) : name;
        g.fillText(label, LEFT - 6, TOP + each * (row + 0.5), LEFT - 8);
      });
    }

    drawLegend() {
      const names = this.given.modes ? MODES.map(([name]) => name) : this.given.names;
      this.buttons = names.map((name, row) => {
        const button = document.createElement("button");
        const swatch = button.appendChild(document.createElement("span"));
        swatch.className = "swatch";
        swatch.style.background = this.given.modes ? MODES[row][1] : colour(this.given.styles[row]) || "currentColor";
        button.label = button.appendChild(document.createElement("span"));
        button.label.textContent = name;
        button.name_ = name;
        if (!this.given.modes) {
          button.setAttribute("aria-pressed", "true");
          button.addEventListener("click", () => {
            if (!this.hidden.delete(row)) this.hidden.add(row);
            button.setAttribute("aria-pressed", String(!this.hidden.has(row)));
            this.draw();
          });
        }
        this.legend.appendChild(button);
        return button;
      });
      this.when = this.legend.appendChild(document.createElement("span"));
    }

    read() {
      const phase = data.phases.find(([, from, to]) => from <= cursor && cursor <= to);
      this.when.textContent = cursor === null ? "" : `at ${digits(cursor)} s${phase ? `, ${phase[0]}` : ""}`;
      if (this.given.modes) return;
      this.buttons.forEach((button, row) => {
        const found = cursor === null ? [] : this.values(row, this.at(cursor)).map(digits);
        const text = found.length ? `: ${found.join(" to ")} ${this.given.unit}` : "";
        button.label.textContent = button.name_ + text;
      });
    }

    listen() {
      const when = (event) => {
        const x = event.clientX - this.canvas.getBoundingClientRect().left - LEFT;
        return span[0] + Math.min(Math.max(x / this.box.width, 0), 1) * (span[1] - span[0]);
      };
      let from = null;
      this.canvas.addEventListener("pointerdown", (event) => { from = when(event); });
      this.canvas.addEventListener("pointermove", (event) => { cursor = when(event); all(); });
      this.canvas.addEventListener("pointerleave", () => { from = null; cursor = null; all(); });
      this.canvas.addEventListener("pointerup", (event) => {
        const to = when(event);
        if (from !== null && Math.abs(to - from) > 0.01 * (span[1] - span[0])) show(Math.min(from, to), Math.max(from, to));
        from = null;
      });
      this.canvas.addEventListener("dblclick", () => show(...whole));
      this.canvas.addEventListener("keydown", (event) => {
        const width = span[1] - span[0], middle = cursor === null ? (span[0] + span[1]) / 2 : cursor;
        const acts = {
          ArrowLeft: () => { cursor = Math.max(middle - width / 100, span[0]); all(); },
          ArrowRight: () => { cursor = Math.min(middle + width / 100, span[1]); all(); },
          "+": () => show(middle - width / 4, middle + width / 4),
          "-": () => show(middle - width, middle + width),
          0: () => show(...whole),
          Escape: () => { cursor = null; all(); },
        };
        if (acts[event.key]) { event.preventDefault(); acts[event.key](); }
      });
    }
  }

  let asked = false;
  function all() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; charts.forEach((chart) => chart.draw()); });
  }
  function show(from, to) {
    span = [Math.max(from, whole[0]), Math.min(to, whole[1])];
    all();
  }

  for (const canvas of document.querySelectorAll("canvas[data-chart]")) {
    charts.push(new Chart(canvas, data.charts[Number(canvas.dataset.chart)]));
  }
  window.hydrosim.charts = charts;
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      const chart = charts.find((one) => one.canvas === entry.target);
      chart.visible = entry.isIntersecting;
    }
    all();
  }, { rootMargin: "300px" });
  charts.forEach((chart) => seen.observe(chart.canvas));
  window.addEventListener("resize", all);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", all);
  window.addEventListener("beforeprint", () => charts.forEach((chart) => { chart.visible = true; chart.draw(); }));
})();
