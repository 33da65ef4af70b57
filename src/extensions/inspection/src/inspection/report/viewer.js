/* The 3D view of the report and its panel of photographs. The data stands in the page, as JSON. */
(function () {
  "use strict";
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("view-data").textContent);
  const COLOURS = [[143, 184, 154], [232, 163, 61], [178, 184, 192], [170, 178, 190]]; // seen, open, no reach, unknown
  const findingOf = new Map(data.findings.map((each) => [each.id, each]));
  let view = null;

  // ---- the panel: a photograph with the findings in it -----------------------------------------------------

  function showPhotograph(number, finding) {
    const shot = data.photographs[number];
    const link = document.querySelector(`[data-thumb="${number}"] a`);
    const held = link && link.querySelector("img");
    const frame = byId("photo-frame");
    frame.textContent = "";
    if (link) {
      const picture = document.createElement("img");
      picture.src = held ? held.src : link.href; // without a small picture, the original beside the page
      picture.alt = `Photograph ${shot.number}`;
      frame.append(picture);
      for (const [id, x, y, radius] of shot.marks) frame.append(markIn(picture, id, x, y, radius, id === finding));
    }
    byId("photo-name").textContent = `Photograph ${shot.number} of ${data.photographs.length}`;
    byId("photo-link").href = link ? link.href : "#";
    byId("photo-link").hidden = !link;
    byId("panel").dataset.photograph = String(number);
    byId("panel").classList.add("filled");
    if (view) view.showFrustum(number);
  }

  function markIn(picture, id, x, y, radius, chosen) {
    const mark = document.createElement("button");
    mark.className = "mark" + (chosen ? " chosen" : "");
    mark.title = `Finding ${id}`;
    mark.style.left = `${100 * x}%`;
    mark.style.top = `${100 * y}%`;
    mark.style.width = `${100 * Math.min(Math.max(2.4 * radius, 0.035), 0.9)}%`;
    mark.addEventListener("click", () => showFinding(id, false));
    return mark;
  }

  function showFinding(id, fly) {
    const finding = findingOf.get(id);
    if (!finding) return;
    for (const row of document.querySelectorAll("tr.chosen")) row.classList.remove("chosen");
    const row = byId(`finding-${id}`);
    if (row) row.classList.add("chosen");
    const panel = byId("panel");
    panel.dataset.finding = String(id);
    byId("finding-text").textContent = row ? row.dataset.told : `Finding ${id}`;
    byId("finding-link").href = `#finding-${id}`;
    byId("finding-link").hidden = !row;
    if (finding.photograph !== null) showPhotograph(finding.photograph, id);
    else {
      byId("photo-frame").textContent = "";
      byId("photo-name").textContent = "No photograph of this report shows it.";
      byId("photo-link").hidden = true;
      panel.classList.add("filled");
    }
    if (view) view.showPlace(finding, fly);
  }

  document.addEventListener("click", (event) => {
    const from = event.target.closest("[data-show-finding]");
    if (from) {
      event.preventDefault();
      showFinding(Number(from.dataset.showFinding), true);
      byId("view").scrollIntoView({ block: "start" });
    }
  });

  // ---- the surface ----------------------------------------------------------------------------------------

  function bytes(text) {
    const raw = atob(text);
    const out = new Uint8Array(raw.length);
    for (let k = 0; k < raw.length; k++) out[k] = raw.charCodeAt(k);
    return out.buffer;
  }

  function surfaceMesh(surface) {
    const places = new Uint16Array(bytes(surface.places));
    const corners = new Uint32Array(bytes(surface.corners));
    const states = new Uint8Array(bytes(surface.states));
    const at = new Float32Array(3 * corners.length);
    const colour = new Uint8Array(3 * corners.length);
    for (let k = 0; k < corners.length; k++) {
      const own = COLOURS[states[(k / 3) | 0]];
      for (let axis = 0; axis < 3; axis++) {
        at[3 * k + axis] = surface.low[axis] + surface.step * places[3 * corners[k] + axis];
        colour[3 * k + axis] = own[axis];
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(at, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(colour, 3, true));
    geometry.computeVertexNormals();
    const known = states.length && states[0] !== 3;
    const material = new THREE.MeshLambertMaterial({
      vertexColors: THREE.VertexColors, side: known ? THREE.FrontSide : THREE.DoubleSide,
      transparent: !known, opacity: known ? 1 : 0.35, depthWrite: known,
    });
    return new THREE.Mesh(geometry, material);
  }

  function edgeLines(surface) {
    const at = new Float32Array(bytes(surface.edges));
    for (let k = 0; k < at.length; k++) at[k] += surface.low[k % 3];
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(at, 3));
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x33414f, transparent: true, opacity: 0.45 }));
  }

  function frustumLines(shots, reach) {
    const [right, down] = data.extents;
    const at = [];
    for (const shot of shots) {
      const eye = new THREE.Vector3(...shot.at);
      const [x, y, z] = [0, 3, 6].map((k) => new THREE.Vector3(...shot.axes.slice(k, k + 3)));
      const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => eye.clone()
        .addScaledVector(z, reach).addScaledVector(x, a * right * reach).addScaledVector(y, b * down * reach));
      corners.forEach((corner, k) => at.push(eye, corner, corner, corners[(k + 1) % 4]));
    }
    return new THREE.BufferGeometry().setFromPoints(at);
  }

  function dot() {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 32;
    const draw = canvas.getContext("2d");
    draw.beginPath();
    draw.arc(16, 16, 13, 0, 2 * Math.PI);
    draw.fillStyle = "#fff";
    draw.fill();
    return new THREE.CanvasTexture(canvas);
  }

  class View {
    constructor(canvas) {
      this.canvas = canvas;
      this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
      this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
      this.renderer.setClearColor(0xffffff);
      this.scene = new THREE.Scene();
      this.scene.add(new THREE.HemisphereLight(0xffffff, 0xd5d8de, 0.78));
      this.lamp = new THREE.DirectionalLight(0xffffff, 0.3);
      this.scene.add(this.lamp, this.lamp.target);
      this.camera = new THREE.PerspectiveCamera(40, 1, 0.05, 2000);
      this.camera.up.set(0, 0, 1);
      this.controls = new THREE.OrbitControls(this.camera, canvas);
      this.controls.addEventListener("change", () => this.draw());
      this.controls.addEventListener("start", () => { this.isWhole = false; });
      this.shots = new THREE.LineSegments(frustumLines(data.photographs, 0.35),
        new THREE.LineBasicMaterial({ color: 0x2f5fa8, transparent: true, opacity: 0.55 }));
      this.chosenShot = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xd11149 }));
      this.scene.add(surfaceMesh(data.surface), edgeLines(data.surface), this.shots, this.chosenShot);
      this.addMarks();
      canvas.addEventListener("pointerdown", (event) => { this.pressed = [event.clientX, event.clientY]; });
      canvas.addEventListener("pointerup", (event) => this.onRelease(event));
      window.addEventListener("resize", () => this.resize());
      this.resize();
      this.whole();
    }

    addMarks() {
      const map = dot();
      const make = (size, color, vertexColors) => new THREE.Points(new THREE.BufferGeometry(),
        new THREE.PointsMaterial({ size, sizeAttenuation: false, map, alphaTest: 0.4, color, vertexColors }));
      this.ring = make(20, 0xd11149, THREE.NoColors);
      this.rim = make(13, 0xffffff, THREE.NoColors);
      this.marks = make(10, 0xffffff, THREE.VertexColors);
      this.scene.add(this.ring, this.rim, this.marks);
    }

    /* Marks on walls that are seen from behind are left out, as those walls are. */
    placeMarks() {
      const eye = this.camera.position;
      this.visible = byId("show-findings").checked ? data.findings.filter((each) => each.status !== "dismissed"
        && each.normal.reduce((sum, n, k) => sum + n * (eye.getComponent(k) - each.at[k]), 0) > 0) : [];
      const towards = (each, by) => new THREE.Vector3(...each.at).addScaledVector(new THREE.Vector3(...each.normal), by);
      const colours = [];
      for (const each of this.visible) new THREE.Color(data.colours[each.kind]).toArray(colours, colours.length);
      this.fill(this.rim, this.visible.map((each) => towards(each, 0.04)));
      this.fill(this.marks, this.visible.map((each) => towards(each, 0.05)));
      this.marks.geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(colours), 3));
      this.fill(this.ring, this.chosen ? [towards(this.chosen, 0.03)] : []);
    }

    fill(points, places) {
      points.visible = places.length > 0;
      if (places.length) points.geometry.dispose();
      if (places.length) points.geometry = new THREE.BufferGeometry().setFromPoints(places);
    }

    draw() {
      this.placeMarks();
      this.shots.visible = byId("show-photographs").checked;
      this.lamp.position.copy(this.camera.position);
      this.lamp.target.position.copy(this.controls.target);
      this.renderer.render(this.scene, this.camera);
    }

    resize() {
      const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      if (this.isWhole) this.whole(); // a telephone that is turned would cut it
      this.draw();
    }

    whole() {
      this.isWhole = true;
      const low = new THREE.Vector3(...data.surface.low);
      const high = new THREE.Vector3(...data.surface.high);
      const upright = Math.tan(Math.PI / 360 * this.camera.fov);
      const half = Math.atan(upright * Math.min(1, this.camera.aspect || 1));
      const away = 0.5 * high.distanceTo(low) / Math.sin(half); // the sphere around all fits
      this.controls.target.copy(low).add(high).multiplyScalar(0.5);
      this.camera.position.copy(this.controls.target).add(new THREE.Vector3(-0.6, -0.9, 0.75).setLength(away));
      this.controls.update();
    }

    showPlace(finding, fly) {
      this.chosen = finding;
      if (fly) {
        this.isWhole = false;
        const at = new THREE.Vector3(...finding.at);
        const away = new THREE.Vector3(...finding.normal).multiplyScalar(7).add(new THREE.Vector3(0.8, 0.8, 1.5));
        this.controls.target.copy(at);
        this.camera.position.copy(at).add(away);
        this.controls.update();
      }
      this.draw();
    }

    showFrustum(number) {
      this.chosenShot.geometry.dispose();
      this.chosenShot.geometry = frustumLines([data.photographs[number]], 2.0);
      this.draw();
    }

    onRelease(event) {
      if (!this.pressed || Math.hypot(event.clientX - this.pressed[0], event.clientY - this.pressed[1]) > 4) return;
      const finding = this.nearest(event, this.visible, 14);
      if (finding) return showFinding(finding.id, false);
      const shot = this.shots.visible ? this.nearest(event, data.photographs, 10) : null;
      if (shot) showPhotograph(shot.number - 1, null);
    }

    /* Where a place of the map is in the window, px; null behind the eye. */
    screen(at) {
      const box = this.canvas.getBoundingClientRect();
      const place = new THREE.Vector3(...at).project(this.camera);
      if (place.z > 1) return null;
      return [box.left + 0.5 * (1 + place.x) * box.width, box.top + 0.5 * (1 - place.y) * box.height];
    }

    nearest(event, things, reach) {
      let found = null;
      for (const each of things) {
        const place = this.screen(each.at);
        const away = place ? Math.hypot(event.clientX - place[0], event.clientY - place[1]) : Infinity;
        if (away < reach) [found, reach] = [each, away];
      }
      return found;
    }
  }

  // ---- begin ----------------------------------------------------------------------------------------------

  function hasWebGL() {
    const canvas = document.createElement("canvas");
    return Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
  }

  if (typeof THREE !== "undefined" && data.surface && hasWebGL()) {
    document.body.classList.add("with-3d");
    view = new View(byId("canvas"));
    byId("whole").addEventListener("click", () => view.whole());
    for (const id of ["show-findings", "show-photographs"]) byId(id).addEventListener("change", () => view.draw());
  }
  window.inspection = { data, showFinding, showPhotograph, view };
})();
