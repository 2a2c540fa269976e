"use strict";
(function () {
  const setup = JSON.parse(document.getElementById("setup").textContent);
  const by = (id) => document.getElementById(id);
  const made = (tag, more) => Object.assign(document.createElement(tag), more);
  const WAIT = 60; // ms between the last turn of a knob and the question

  // What is asked for: values, as --set takes them, by their keys. The address keeps it, so that
  // a reload, or another window, goes on from here.
  const settings = new Map();
  let planner = setup.planners[0];
  let answer = null, flight = null, timer = null, asked = 0, count = 0;

  function remember() {
    const words = new URLSearchParams();
    if (planner !== setup.planners[0]) words.append("planner", planner);
    for (const [key, text] of settings) words.append("set", key + "=" + text);
    history.replaceState(null, "", "#" + words);
  }

  function recall() {
    const words = new URLSearchParams(location.hash.slice(1));
    settings.clear();
    for (const word of words.getAll("set")) put(word);
    const wanted = words.get("planner");
    planner = setup.planners.includes(wanted) ? wanted : setup.planners[0];
  }

  function put(word) {
    const at = word.indexOf("=");
    if (at > 0) settings.set(word.slice(0, at).trim(), word.slice(at + 1).trim());
    return at > 0;
  }

  // Something has changed: the search under way is for something else.
  function changed() {
    if (flight) flight.abort();
    flight = null;
    hide_map();
    remember();
    list();
    clearTimeout(timer);
    timer = setTimeout(ask, WAIT);
    busy();
  }

  function busy() {
    document.body.dataset.state = "planning";
    by("status").textContent = "planning …";
  }

  async function ask() {
    const mine = flight = new AbortController();
    asked = performance.now();
    const patience = setTimeout(() => {
      if (flight === mine && document.body.dataset.state === "planning")
        by("status").textContent = "still planning … (the very first time compiles for minutes)";
    }, 5000);
    try {
      const response = await fetch("plan", {
        method: "POST", signal: mine.signal, headers: { "Content-Type": "application/json" },
        body: JSON.stringify({ settings: words(), planner }),
      });
      if (!response.ok) refuse([await response.text()]);
      else for await (const line of lines(response.body)) {
        if (flight === mine) receive(JSON.parse(line));
      }
    } catch (error) {
      if (flight === mine)
        refuse(["no answer (" + error.message + "): is gm-ompl explore still running?"]);
    }
    clearTimeout(patience);
  }

  const words = () => Array.from(settings, ([key, text]) => key + "=" + text);

  async function* lines(stream) {
    const reader = stream.pipeThrough(new TextDecoderStream()).getReader();
    for (let rest = "";;) {
      const { value, done } = await reader.read();
      if (done) return;
      const parts = (rest + value).split("\n");
      rest = parts.pop();
      yield* parts;
    }
  }

  const ACTIONS = ["save-plan", "save-scenario", "ask-map"];

  // The map of the instant that is shown.
  let mapping = null;
  function hide_map() {
    if (mapping) mapping.abort();
    mapping = null;
    by("map").hidden = true;
  }

  async function ask_map() {
    hide_map();
    const mine = mapping = new AbortController();
    by("map").hidden = false;
    by("map-image").hidden = true;
    by("map-lines").textContent = "";
    by("map-status").textContent = "mapping …";
    try {
      const response = await fetch("map", {
        method: "POST", signal: mine.signal, headers: { "Content-Type": "application/json" },
        body: JSON.stringify({ settings: words(), instant: gmOmpl.instant() }),
      });
      const text = await response.text(), told = response.ok ? JSON.parse(text) : { lines: [text] };
      if (mapping !== mine) return;
      by("map-status").textContent = told.kind === "map"
        ? "where a finger may be at this instant" : "no map";
      by("map-lines").textContent = told.lines.join("\n");
      by("map-image").hidden = !told.image;
      if (told.image) by("map-image").src = "data:image/png;base64," + told.image;
    } catch (error) {
      if (mapping === mine) by("map-status").textContent = "no answer (" + error.message + ")";
    }
  }

  function refuse(texts) {
    document.body.dataset.state = "refused";
    by("status").textContent = "not planned";
    by("refused").replaceChildren(...texts.map((text) => made("li", { textContent: text })));
    by("refused").hidden = false;
    document.querySelector("main").classList.add("outdated");
    for (const id of ACTIONS) by(id).disabled = true;
  }

  function receive(told) {
    if (told.kind === "refused") { refuse(told.lines); return; }
    const took = ((performance.now() - asked) / 1000).toFixed(1) + " s";
    const first = answer === null;
    answer = told;
    by("refused").hidden = true;
    document.querySelector("main").classList.remove("outdated");
    for (const id of ACTIONS) by(id).disabled = false;
    // The server has escaped what users wrote.
    by("summary").innerHTML = told.pieces.SUMMARY;
    by("bands").innerHTML = told.pieces.BANDS;
    by("links").innerHTML = told.pieces.CHAIN;
    by("fingers").innerHTML = told.pieces.FINGERS;
    gmOmpl.present(told.score, told.messages, first ? told.camera : []);
    set_handles(told.handles);
    by("status").textContent = (told.solved
      ? (told.optimal ? "the best plan on the lattice" : "a plan, by " + told.planner)
      : told.sentence) + " (" + took + ")" +
      (told.final ? "" : "; looking for the best …") +
      told.warnings.map((text) => "; " + text).join("");
    document.body.dataset.state = told.final ? "done" : "better to come";
    count += 1;
  }

  // The list of changes.
  function list() {
    by("count").textContent = settings.size || "nothing";
    by("changed").replaceChildren(...words().map((word) => {
      const item = made("li"), key = word.slice(0, word.indexOf("="));
      const off = made("button", { type: "button", textContent: "undo" });
      off.setAttribute("aria-label", "undo " + key);
      off.addEventListener("click", () => { settings.delete(key); show_knobs(); changed(); });
      item.append(made("code", { textContent: word }), off);
      return item;
    }));
    const quoted = (text) => "'" + text.replaceAll("'", "'\\''") + "'";
    by("command").textContent =
      [setup.command, ...words().map((word) => "--set " + quoted(word))].join(" ");
  }

  // Sliders.
  const PARTS = 1000;
  const tidy = (value) => Number(value.toPrecision(12));

  function from_slider(knob, part) {
    const u = part / PARTS;
    if (knob.logarithmic)
      return Number((knob.low * (knob.high / knob.low) ** u).toPrecision(3));
    const value = knob.low + u * (knob.high - knob.low);
    return knob.step ? tidy(Math.round(value / knob.step) * knob.step) : Number(value.toPrecision(3));
  }

  function to_slider(knob, value) {
    const u = knob.logarithmic ? Math.log(value / knob.low) / Math.log(knob.high / knob.low)
      : (value - knob.low) / (knob.high - knob.low);
    return Math.round(PARTS * Math.min(1, Math.max(0, Number.isNaN(u) ? 0 : u)));
  }

  function make_knob(knob, k) {
    const row = made("div", { className: "knob" }), head = made("div", { className: "row" });
    const label = made("label", { htmlFor: "knob" + k, textContent: knob.label });
    const number = made("input", { type: "number", step: "any", className: "own-keys" });
    const range = made("input", { type: "range", id: "knob" + k, min: 0, max: PARTS, step: 1,
      className: "own-keys" });
    number.setAttribute("aria-label", knob.label + (knob.unit ? " [" + knob.unit + "]" : ""));
    const turn = (value) => {
      if (value === knob.value) settings.delete(knob.key);
      else settings.set(knob.key, value + (knob.unit ? " " + knob.unit : ""));
      say(value);
      changed();
    };
    const say = (value) => {
      if (document.activeElement !== number) number.value = value;
      range.setAttribute("aria-valuetext", value + (knob.unit ? " " + knob.unit : ""));
    };
    range.addEventListener("input", () => turn(from_slider(knob, Number(range.value))));
    number.addEventListener("change", () => {
      if (number.value === "" || !Number.isFinite(number.valueAsNumber)) return show();
      range.value = to_slider(knob, number.valueAsNumber);
      turn(number.valueAsNumber);
    });
    const show = () => {
      const text = settings.get(knob.key), value = text === undefined ? knob.value : parseFloat(text);
      range.value = to_slider(knob, value);
      number.value = value;
      say(value);
    };
    head.append(label, number);
    row.append(head, range);
    by("sliders").append(row);
    return show;
  }

  let shows = [];
  function show_knobs() {
    for (const show of shows) show();
    by("planner").value = planner;
  }

  // Handles: a button over the scene for everything that can be dragged.
  const board = made("div", { id: "handles" });
  by("scene").append(board);
  const grips = new Map(); // by kind and name: its button and what the last answer says of it
  let drag = null;

  function set_handles(handles) {
    const now = new Set(handles.map((handle) => handle.kind + " " + handle.name));
    for (const [id, grip] of grips) if (!now.has(id)) { grip.button.remove(); grips.delete(id); }
    for (const handle of handles) {
      const id = handle.kind + " " + handle.name;
      if (!grips.has(id)) grips.set(id, make_grip(handle));
      const grip = grips.get(id);
      if (!drag || drag.grip !== grip) grip.handle = handle;
      grip.nodes = handle.nodes;
    }
    place_handles();
  }

  function make_grip(handle) {
    const what = handle.name || handle.kind;
    const button = made("button", { type: "button", textContent: what, title: what,
      className: handle.kind + " own-keys" });
    button.setAttribute("aria-label", handle.kind + " " + handle.name +
      ": drag it, or move it with the arrow keys");
    const grip = { button, handle, nodes: handle.nodes };
    button.addEventListener("pointerdown", (event) => {
      button.setPointerCapture(event.pointerId);
      drag = { grip, from: [event.clientX, event.clientY], handle: grip.handle, last: "" };
    });
    button.addEventListener("pointermove", (event) => {
      if (!drag || drag.grip !== grip) return;
      const [x, y] = drag.from;
      move(grip, drag.handle, reach(drag.handle, event.clientX - x, event.clientY - y, event.shiftKey));
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
      button.addEventListener(end, () => { drag = null; });
    button.addEventListener("keydown", (event) => {
      const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1],
        ArrowDown: [0, 1] }[event.key] || [0, 0];
      if (!dx && !dy) return;
      event.preventDefault();
      move(grip, grip.handle, step_towards(grip.handle, dx, dy));
    });
    board.append(button);
    return grip;
  }

  // How many pixels a step along each axis is, (right, down).
  function pixels(handle) {
    const [x, y] = gmOmpl.project(handle.at);
    return handle.axes.map((axis, k) => {
      const [a, b] = gmOmpl.project(handle.at.map((v, i) => v + axis[i] * handle.steps[k]));
      return [a - x, b - y];
    });
  }

  // Whole steps along the axes that come nearest to so many pixels; of three axes the last, the
  // vertical, is for the shift key.
  function reach(handle, dx, dy, shift) {
    const rows = pixels(handle), steps = rows.map(() => 0);
    const used = rows.length < 3 ? rows.map((_, k) => k) : shift ? [2] : [0, 1];
    const [a, b = [0, 0]] = used.map((k) => rows[k]);
    // Least squares; what is seen end on is not moved far.
    const damp = 1e-3 * (a[0] * a[0] + a[1] * a[1] + b[0] * b[0] + b[1] * b[1]) + 1e-12;
    const aa = a[0] * a[0] + a[1] * a[1] + damp, bb = b[0] * b[0] + b[1] * b[1] + damp;
    const ab = a[0] * b[0] + a[1] * b[1], det = aa * bb - ab * ab;
    const p = a[0] * dx + a[1] * dy, q = b[0] * dx + b[1] * dy;
    steps[used[0]] = Math.round((bb * p - ab * q) / det);
    if (used.length > 1) steps[used[1]] = Math.round((aa * q - ab * p) / det);
    return steps;
  }

  function step_towards(handle, dx, dy) {
    const rows = pixels(handle), steps = rows.map(() => 0);
    const along = rows.map(([x, y]) => (x * dx + y * dy) / (Math.hypot(x, y) || 1));
    const best = along.reduce((k, v, i) => (Math.abs(v) > Math.abs(along[k]) ? i : k), 0);
    steps[best] = along[best] < 0 ? -1 : 1;
    return steps;
  }

  function shifted(value, by, axis) {
    if (axis !== null) return value.map((v) => tidy(v + by[axis]));
    if (Array.isArray(value[0])) return value.map((row) => shifted(row, by, null));
    return value.map((v, k) => (typeof v === "number" ? tidy(v + by[k]) : v));
  }

  function move(grip, from, steps) {
    if (drag && drag.last === String(steps)) return;
    if (drag) drag.last = String(steps);
    const by_ = [0, 1, 2].map((i) =>
      from.axes.reduce((sum, axis, k) => sum + axis[i] * from.steps[k] * steps[k], 0));
    const moved = from.moved.map((one) => ({ ...one, value: shifted(one.value, by_, one.axis) }));
    const shift = from.at.map((v, i) => v + by_[i] - grip.handle.at[i]);
    grip.handle = { ...from, moved, at: from.at.map((v, i) => v + by_[i]) };
    for (const one of moved) settings.set(one.key, JSON.stringify(one.value).replaceAll('"', ""));
    for (const k of grip.nodes) { // until the answer comes
      const node = gmOmpl.obstacle(k);
      if (node) node.position.set(...node.position.toArray().map((v, i) => v + shift[i]));
    }
    gmOmpl.redraw();
    place_handles();
    changed();
  }

  function place_handles() {
    if (answer === null) return;
    const box = board.getBoundingClientRect();
    for (const { button, handle } of grips.values()) {
      const [x, y, ahead] = gmOmpl.project(handle.at);
      button.hidden = !ahead;
      button.style.left = Math.min(Math.max(x, 30), box.width - 30) + "px";
      button.style.top = Math.min(Math.max(y, 16), box.height - 16) + "px";
    }
  }

  function save(text, kind, type) {
    const name = (setup.name.replace(/[^\w-]+/g, "-").replace(/^-+|-+$/g, "") || "scenario") + kind;
    const link = made("a", { download: name, href: URL.createObjectURL(new Blob([text], { type })) });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  by("planner").replaceChildren(...setup.planners.map((name) => made("option", { textContent: name })));
  by("planner").addEventListener("change", () => { planner = by("planner").value; changed(); });
  by("other").addEventListener("submit", (event) => {
    event.preventDefault();
    if (!put(by("setting").value)) { refuse(["another setting: must be KEY=VALUE"]); return; }
    by("setting").value = "";
    show_knobs();
    changed();
  });
  by("reset").addEventListener("click", () => { settings.clear(); show_knobs(); changed(); });
  by("save-plan").addEventListener("click", () => save(answer.plan, ".plan.json", "application/json"));
  by("save-scenario").addEventListener("click", () => save(answer.scenario, ".yaml", "application/yaml"));
  by("ask-map").addEventListener("click", ask_map);
  addEventListener("hashchange", () => { recall(); show_knobs(); changed(); });
  gmOmpl.after_frame = place_handles;
  by("legend").open = false; // room for what changes
  recall();
  shows = setup.knobs.map(make_knob);
  show_knobs();
  list();
  busy();
  ask();
  window.gmExplore = { get answers() { return count; }, get answer() { return answer; } };
})();
