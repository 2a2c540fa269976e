"use strict";
(function () {
  const score = JSON.parse(document.getElementById("score").textContent);
  const packed = JSON.parse(document.getElementById("messages").textContent);
  const by = (id) => document.getElementById(id);
  const NAMES = { P: "position", F: "force", L: "lifted" };
  const LOOKS = ["position", "force", "lifted"];
  const segments = score.segments.map((r) => ({
    start: r[0], end: r[1], step: r[2], pose: r[3], poses: r[4], modes: r[5], force: r[6], z: r[7],
    hand: score.hands[r[8]], contacts: score.contacts[r[9]], lifted: r[10], target: r[11],
    path: r[12] < 0 ? null : score.paths[r[12]],
  }));
  const show = (value) => {
    if (value === 0) return "0";
    const size = Math.abs(value);
    return size >= 1e5 || size < 1e-3 ? value.toExponential(3) : String(+value.toPrecision(4));
  };

  let viewer = null;
  const nodes = { fingers: [], contacts: [] };
  let time = 0, playing = false, last = null, frames = 0, shown = null;

  function build() {
    viewer = new MeshCat.Viewer(by("pane"));
    viewer.set_3d_pane_size = function () {
      const box = by("pane").getBoundingClientRect();
      const w = Math.max(1, box.width), h = Math.max(1, box.height);
      this.camera.aspect = w / h;
      // A narrow pane sees less to the sides: widen the view so that the scene fits.
      this.camera.zoom = Math.min(1, 1.1 * w / h);
      this.camera.updateProjectionMatrix();
      this.renderer.setSize(w, h);
      this.set_dirty();
    };
    for (const text of packed) {
      viewer.handle_command_bytearray(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)));
    }
    const find = (path) => viewer.scene_tree.find(["meshcat", "world"].concat(path)).object;
    nodes.world = find([]);
    nodes.object = find(["object"]);
    for (let i = 0; i < score.fingers; i++) {
      const at = (...more) => find(["object", "finger" + i, ...more]);
      const label = document.createElement("span");
      by("labels").appendChild(label);
      nodes.fingers.push({
        root: at(), position: at("position"), force: at("force"), lifted: at("lifted"),
        arrow: at("force", "arrow"), shaft: at("force", "arrow", "shaft"),
        head: at("force", "arrow", "head"), label,
      });
    }
    for (let k = 0; k < score.slots; k++) {
      const at = (...more) => find(["object", "contact" + k, ...more]);
      nodes.contacts.push({ root: at(), still: at("static"), sliding: at("sliding") });
    }
    const render = viewer.render.bind(viewer);
    viewer.render = function () { render(); frames += 1; place_labels(); };
    viewer.set_3d_pane_size();
    window.addEventListener("resize", () => viewer.set_3d_pane_size());
  }

  function place_labels() {
    const box = by("pane").getBoundingClientRect();
    for (const f of nodes.fingers) {
      const p = f.root.getWorldPosition(viewer.camera.position.clone()).project(viewer.camera);
      f.label.hidden = !f.root.visible || p.z > 1;
      f.label.style.left = (0.5 + 0.5 * p.x) * box.width + "px";
      f.label.style.top = (0.5 - 0.5 * p.y) * box.height + "px";
    }
  }

  function segment_at(t) {
    let low = 0, high = segments.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (segments[middle].start <= t) low = middle; else high = middle - 1;
    }
    return segments[low];
  }

  const mix = (a, b, u) => a.map((value, k) => value + (b[k] - value) * u);

  // Between neighbours of a list of points or poses; u runs from 0 to 1 over the whole list.
  function along(list, first, count, u) {
    if (count === 1) return list[first];
    const x = Math.min(Math.max(u, 0), 1) * (count - 1);
    const k = Math.min(Math.floor(x), count - 2);
    if (x === k) return list[first + k];
    if (x === k + 1) return list[first + k + 1];
    return mix(list[first + k], list[first + k + 1], x - k);
  }

  function set_pose(object, row) {
    object.position.set(row[0], row[1], row[2]);
    object.quaternion.set(row[4], row[5], row[6], row[3]).normalize();
  }

  function pose_scene(segment, u) {
    if (!viewer) return;
    set_pose(nodes.object, segment ? along(score.poses, segment.pose, segment.poses, u) : score.poses[0]);
    nodes.fingers.forEach((f, i) => {
      f.root.visible = segment !== null;
      if (!segment) return;
      const mode = NAMES[segment.modes[i]], moving = i === segment.lifted;
      const place = score.places[moving && u >= 0.5 ? segment.target : segment.hand[i]];
      const centre = moving && segment.path ? along(segment.path, 0, segment.path.length, u) : place.centre;
      f.root.position.set(centre[0], centre[1], centre[2]);
      f.root.quaternion.set(place.turn[1], place.turn[2], place.turn[3], place.turn[0]);
      for (const look of LOOKS) f[look].visible = look === mode;
      const part = segment.force[i] && score.fMax[i] > 0 ? segment.force[i] / score.fMax[i] : 0;
      f.arrow.visible = part > 0;
      f.shaft.scale.z = Math.max(part, 1e-6) * score.arrow;
      f.label.textContent = i + " " + mode;
      f.label.style.color = mode === "position" ? "#005a8f" : mode === "force" ? "#a84a00" : "#555";
    });
    nodes.contacts.forEach((c, k) => {
      const point = segment ? segment.contacts[k] : undefined;
      c.root.visible = point !== undefined;
      if (point === undefined) return;
      c.root.position.set(point[0], point[1], point[2]);
      c.still.visible = !point[3];
      c.sliding.visible = Boolean(point[3]);
    });
    viewer.set_dirty();
  }

  function read_out(segment, u) {
    const share = score.duration > 0 ? time / score.duration : 0;
    by("slider").value = share;
    by("cursor").style.left = 100 * share + "%";
    by("clock").textContent = time.toFixed(2) + " / " + score.duration.toFixed(2) + " s";
    if (!segment) { by("step-line").textContent = "no steps: the object at its start"; return; }
    const step = score.steps[segment.step];
    const end = score.steps[segment.step + 1] ? score.steps[segment.step + 1].t : score.duration;
    const done = end > step.t ? (time - step.t) / (end - step.t) : 0;
    by("coordinates").textContent = score.names
      .map((name, k) => name + " = " + show(step.from[k] + (step.to[k] - step.from[k]) * done))
      .join(", ");
    if (shown === segment && !(segment.lifted >= 0)) return;
    shown = segment;
    by("step-line").textContent = "step " + (segment.step + 1) + " of " + score.steps.length + ": " +
      (segment.lifted >= 0 ? "regrasp, finger " + segment.lifted + " moves" : "displacement");
    by("slider").setAttribute("aria-valuetext", by("step-line").textContent);
    for (let i = 0; i < score.fingers; i++) {
      const row = by("finger" + i);
      const moving = i === segment.lifted;
      row.className = segment.modes[i];
      row.querySelector(".place").textContent = moving
        ? score.places[segment.hand[i]].label + " \u2192 " + score.places[segment.target].label
        : score.places[segment.hand[i]].label;
      row.querySelector(".mode").textContent = NAMES[segment.modes[i]];
      const force = segment.force[i];
      row.querySelector(".f").textContent = force === null ? "\u2013" : show(force);
    }
    by("z").textContent = show(segment.z);
    by("gauge-fill").style.width = 100 * Math.min(1, Math.max(0, segment.z / score.zTop)) + "%";
    by("gauge-fill").classList.toggle("low", segment.z < score.zMin * (1 - 1e-6));
    by("gauge-fill").classList.toggle("over", segment.z > score.zTop);
    by("gauge").setAttribute("aria-valuenow", segment.z);
    by("costs").textContent = "cost of this step " + show(step.cost) + ", up to its end " +
      show(step.spent);
  }

  function seek(t) {
    time = Math.min(Math.max(t, 0), score.duration);
    const segment = segments.length ? segment_at(time) : null;
    const u = segment && segment.end > segment.start ? (time - segment.start) / (segment.end - segment.start) : 0;
    pose_scene(segment, u);
    read_out(segment, u);
  }

  function play(on) {
    playing = on && segments.length > 0;
    if (playing && time >= score.duration) time = 0;
    by("play").textContent = playing ? "Pause" : "Play";
    last = null;
    if (playing) requestAnimationFrame(tick);
  }

  function tick(now) {
    if (!playing) return;
    if (last !== null) seek(time + Math.max(0, now - last) / 1000 * Number(by("speed").value));
    last = now;
    if (time >= score.duration) play(false); else requestAnimationFrame(tick);
  }

  function stop_at(t) {
    play(false);
    seek(t);
  }

  function step_by(direction) {
    play(false);
    const slack = 1e-9 * Math.max(1, score.duration);
    const stops = score.steps.map((step) => step.t).concat([score.duration]);
    const next = direction > 0
      ? stops.find((t) => t > time + slack)
      : stops.reverse().find((t) => t < time - slack);
    if (next !== undefined) seek(next);
  }

  // The state as drawn, read back from the viewer's own nodes, in the plan's units.
  function state(t) {
    if (t !== undefined) stop_at(t);
    if (viewer) viewer.scene.updateMatrixWorld(true);
    const world = (object) => {
      const p = object.getWorldPosition(viewer.camera.position.clone());
      return nodes.world.worldToLocal(p).toArray();
    };
    const segment = segments.length ? segment_at(time) : null;
    const q = viewer && nodes.object.quaternion;
    return {
      time, step: segment ? segment.step : null,
      object: viewer && { position: world(nodes.object), quaternion: [q.w, q.x, q.y, q.z] },
      fingers: nodes.fingers.map((f) => ({
        position: world(f.root), looks: LOOKS.filter((look) => f[look].visible),
        arrow: f.force.visible && f.arrow.visible ? f.shaft.scale.z / score.arrow : 0,
        label: f.label.textContent,
      })),
      contacts: nodes.contacts.filter((c) => c.root.visible)
        .map((c) => ({ position: world(c.root), sliding: c.sliding.visible })),
      gauge: parseFloat(by("gauge-fill").style.width) / 100,
      text: {
        step: by("step-line").textContent, coordinates: by("coordinates").textContent,
        z: by("z").textContent, rows: Array.from(document.querySelectorAll("#readout tbody tr"))
          .map((row) => Array.from(row.cells).map((cell) => cell.textContent)),
      },
      cursor: parseFloat(by("cursor").style.left) / 100, slider: Number(by("slider").value),
    };
  }

  try {
    build();
  } catch (error) {
    viewer = null;
    by("trouble").hidden = false;
    by("trouble").textContent = "The scene cannot be drawn (" + error.message +
      "); it needs WebGL. Numbers and plots work without it.";
  }
  by("z-min").textContent = "z_min " + show(score.zMin);
  by("gauge-mark").style.left = 100 * Math.min(1, score.zMin / score.zTop) + "%";
  by("gauge").setAttribute("aria-valuemin", 0);
  by("gauge").setAttribute("aria-valuemax", score.zTop);
  by("time").hidden = segments.length === 0; // nothing to play
  by("play").addEventListener("click", () => play(!playing));
  by("back").addEventListener("click", () => step_by(-1));
  by("forth").addEventListener("click", () => step_by(1));
  by("slider").addEventListener("input", (event) => {
    stop_at(Number(event.target.value) * score.duration);
  });
  const scrub = (event) => {
    const box = by("plots").getBoundingClientRect();
    stop_at((event.clientX - box.left) / box.width * score.duration);
  };
  for (const band of document.querySelectorAll(".band svg")) {
    band.addEventListener("pointerdown", (event) => {
      band.setPointerCapture(event.pointerId);
      scrub(event);
    });
    band.addEventListener("pointermove", (event) => { if (event.buttons) scrub(event); });
  }
  document.addEventListener("keydown", (event) => {
    const at = (selector) => event.target.closest(selector) !== null;
    if (event.ctrlKey || event.altKey || event.metaKey || at("select")) return;
    if (event.key === " " && (event.repeat || at("button, summary"))) return; // they act on it
    const action = { " ": () => play(!playing), ArrowLeft: () => step_by(-1),
      ArrowRight: () => step_by(1), Home: () => stop_at(0),
      End: () => stop_at(score.duration) }[event.key];
    if (action) { event.preventDefault(); action(); }
  });
  seek(0);
  window.gmOmpl = {
    state, seek, play: () => play(true), pause: () => play(false),
    get playing() { return playing; }, get frames() { return frames; },
    duration: score.duration, steps: score.steps.map((step) => step.t),
  };
})();
