"use strict";
(function () {
  const by = (id) => document.getElementById(id);
  const NAMES = { P: "position", F: "force", L: "lifted" };
  const LOOKS = ["position", "force", "lifted"];
  const show = (value) => {
    if (value === 0) return "0";
    const size = Math.abs(value);
    return size >= 1e5 || size < 1e-3 ? value.toExponential(3) : String(+value.toPrecision(4));
  };

  // What is shown: set by present().
  let score = null, segments = [], links = [];
  let viewer = null, after_frame = () => {};
  const nodes = { fingers: [], contacts: [], links: [] };
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
    const render = viewer.render.bind(viewer);
    viewer.render = function () { render(); frames += 1; place_labels(); after_frame(); };
    viewer.set_3d_pane_size();
    window.addEventListener("resize", () => viewer.set_3d_pane_size());
  }

  function obey(packed) {
    for (const text of packed) {
      viewer.handle_command_bytearray(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)));
    }
  }

  // Replace the scene; the look from where one has turned to is kept.
  function populate(packed) {
    viewer.handle_command({ type: "delete", path: "/meshcat/world" });
    obey(packed);
    nodes.fingers = [];
    nodes.contacts = [];
    by("labels").replaceChildren();
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
    nodes.links = score.links.length ? score.links[0][0].map((_, k) => find(["link" + k])) : [];
    for (let k = 0; k < score.slots; k++) {
      const at = (...more) => find(["object", "contact" + k, ...more]);
      nodes.contacts.push({ root: at(), still: at("static"), sliding: at("sliding") });
    }
  }

  function place_labels() {
    const box = by("pane").getBoundingClientRect();
    for (const f of nodes.fingers) {
      const [x, y, ahead] = on_pane(f.root.getWorldPosition(viewer.camera.position.clone()), box);
      f.label.hidden = !f.root.visible || !ahead;
      f.label.style.left = x + "px";
      f.label.style.top = y + "px";
    }
  }

  // Where a point of meshcat's is drawn in the pane, and whether it is ahead of the camera.
  function on_pane(point, box) {
    const p = point.project(viewer.camera);
    return [(0.5 + 0.5 * p.x) * box.width, (0.5 - 0.5 * p.y) * box.height, p.z <= 1];
  }

  // Likewise of a point of the plan's.
  function project(point) {
    const at = viewer.camera.position.clone().set(...point);
    viewer.scene.updateMatrixWorld(true);
    return on_pane(nodes.world.localToWorld(at), by("pane").getBoundingClientRect());
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

  // Between two poses whose quaternions may have opposite signs.
  function pose_between(a, b, u) {
    const same = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] >= 0;
    return mix(a, same ? b : b.map((value, k) => k < 3 ? value : -value), u);
  }

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
    if (segment && nodes.links.length) {
      const rows = score.links[segment.step], step = score.steps[segment.step];
      const next = score.steps[segment.step + 1], end = next ? next.t : score.duration;
      const x = (rows.length - 1) * Math.min(1, Math.max(0, (time - step.t) / (end - step.t)));
      const k = Math.min(Math.floor(x), rows.length - 2);
      nodes.links.forEach((link, j) => set_pose(link, pose_between(rows[k][j], rows[k + 1][j], x - k)));
    }
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

  // Where the object is: its centre of mass, and how it is turned since the start.
  function place_of(row) {
    const round = (value) => show(Math.abs(value) < 1e-9 * score.size ? 0 : value);
    const at = "at [" + row.slice(0, 3).map(round).join(", ") + "]";
    const [w, x, y, z] = row.slice(3), [a, b, c, d] = score.poses[0].slice(3);
    const turn = [ // by the conjugate of the first
      w * a + x * b + y * c + z * d, x * a - w * b + z * c - y * d,
      y * a - w * c + x * d - z * b, z * a - w * d + y * b - x * c,
    ];
    const size = Math.hypot(...turn.slice(1)), sign = turn[0] < 0 ? -1 : 1;
    const angle = 2 * Math.atan2(size, Math.abs(turn[0])) * 180 / Math.PI;
    if (angle < 0.005) return at;
    const axis = turn.slice(1).map((value) => sign * value / size);
    const k = axis.findIndex((value) => Math.abs(value) > 0.99999);
    const about = k < 0 ? "[" + axis.map((value) => value.toFixed(3)).join(", ") + "]"
      : (axis[k] < 0 ? "-" : "+") + "xyz"[k];
    return at + ", turned " + angle.toFixed(1) + " deg about " + about;
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
    by("coordinates").textContent = score.names.length
      ? score.names
        .map((name, k) => name + " = " + show(step.from[k] + (step.to[k] - step.from[k]) * done))
        .join(", ")
      : place_of(along(score.poses, segment.pose, segment.poses, u));
    const link = score.chain.findIndex((one) => one.first <= segment.step && segment.step <= one.last);
    links.forEach((item, k) => {
      if ((k === link) === item.hasAttribute("aria-current")) return;
      item.toggleAttribute("aria-current", k === link);
      const list = by("links");
      if (k === link) list.scrollTop = item.offsetTop - list.offsetTop - list.clientHeight / 2;
    });
    if (shown === segment && !(segment.lifted >= 0)) return;
    shown = segment;
    by("step-line").textContent = "step " + (segment.step + 1) + " of " + score.steps.length + ", " +
      (segment.lifted >= 0 ? "regrasp, finger " + segment.lifted + " moves"
        : "displacement" + (link < 0 ? "" : ": " + score.chain[link].words));
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

  // When it is, as the program takes it: coordinates and the way they go, or a pose.
  function instant() {
    const segment = segments.length ? segment_at(time) : null;
    if (!segment) return { pose: score.poses[0] };
    const u = (time - segment.start) / (segment.end - segment.start || 1);
    const step = score.steps[segment.step], next = score.steps[segment.step + 1];
    const end = next ? next.t : score.duration;
    const done = Math.min(1, end > step.t ? (time - step.t) / (end - step.t) : 0);
    const way = step.to.map((value, k) => value - step.from[k]);
    if (!score.names.length) return { pose: along(score.poses, segment.pose, segment.poses, u) };
    return {
      q: way.map((value, k) => step.from[k] + value * done),
      direction: way.some((value) => value !== 0) ? way : null,
    };
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
      links: nodes.links.map((link) => ({
        position: world(link), quaternion: ["w", "x", "y", "z"].map((part) => link.quaternion[part]),
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

  // Show a plan: its score, its scene's messages and, the first time, its camera's. What the page
  // says in HTML already is the plan's. Time keeps its share of the whole.
  function present(its_score, packed, camera) {
    const share = score && score.duration > 0 ? time / score.duration : 0;
    score = its_score;
    segments = score.segments.map((r) => ({
      start: r[0], end: r[1], step: r[2], pose: r[3], poses: r[4], modes: r[5], force: r[6],
      z: r[7], hand: score.hands[r[8]], contacts: score.contacts[r[9]], lifted: r[10],
      target: r[11], path: r[12] < 0 ? null : score.paths[r[12]],
    }));
    links = Array.from(by("links").children);
    shown = null;
    if (viewer) { populate(packed); obey(camera); viewer.set_3d_pane_size(); }
    by("z-min").textContent = "z_min " + show(score.zMin);
    by("gauge-mark").style.left = 100 * Math.min(1, score.zMin / score.zTop) + "%";
    by("gauge").setAttribute("aria-valuemin", 0);
    by("gauge").setAttribute("aria-valuemax", score.zTop);
    by("chain").hidden = links.length === 0;
    by("time").hidden = segments.length === 0; // nothing to play
    if (!segments.length) play(false);
    seek(share * score.duration);
  }

  by("links").addEventListener("click", (event) => {
    const k = links.indexOf(event.target.closest("li"));
    if (k >= 0) stop_at(score.steps[score.chain[k].first].t);
  });
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
  by("bands").addEventListener("pointerdown", (event) => {
    const band = event.target.closest("svg");
    if (!band) return;
    band.setPointerCapture(event.pointerId);
    scrub(event);
  });
  by("bands").addEventListener("pointermove", (event) => {
    if (event.buttons && event.target.closest("svg")) scrub(event);
  });
  document.addEventListener("keydown", (event) => {
    const at = (selector) => event.target.closest(selector) !== null;
    if (event.ctrlKey || event.altKey || event.metaKey || at("select, .own-keys")) return;
    if (event.key === " " && (event.repeat || at("button, summary"))) return; // they act on it
    const action = { " ": () => play(!playing), ArrowLeft: () => step_by(-1),
      ArrowRight: () => step_by(1), Home: () => stop_at(0),
      End: () => stop_at(score.duration) }[event.key];
    if (action) { event.preventDefault(); action(); }
  });
  window.gmOmpl = {
    present, project, instant, state, seek, play: () => play(true), pause: () => play(false),
    get playing() { return playing; }, get frames() { return frames; },
    get duration() { return score.duration; },
    get steps() { return score.steps.map((step) => step.t); },
    set after_frame(action) { after_frame = action; },
    obstacle: (k) => viewer && viewer.scene_tree.find(["meshcat", "world", "obstacle" + k]).object,
    redraw: () => viewer && viewer.set_dirty(),
  };
})();
