// The scene: loads the GLB, plays it, colours it, finds what is under the pointer.
import {
  AmbientLight, AnimationMixer, Box3, Color, DirectionalLight, HemisphereLight,
  BufferAttribute, BufferGeometry, Mesh, MeshStandardMaterial, PCFShadowMap, PerspectiveCamera, Raycaster, Scene,
  Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { DIRECTED, NEUTRAL, SAMPLED, SOLVED, viridis } from "./colours.js";

/// Materials of the speed scale; a piece takes the nearest.
const SPEED_BINS = 32;
/// Below this scale a piece is not there: the export hides it by a scale of zero.
const THERE = 1e-3;

export class Stage {
  constructor(canvas, report) {
    this.report = report;
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.scene = new Scene();
    this.scene.background = new Color("#e9edf2");
    this.camera = new PerspectiveCamera(40, 1, 0.001, 1000);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.time = 0;
    this.mode = "object";
    this.selected = null;
    this.pieces = new Map();
    this.sheets = [];
    this.cache = new Map();
    this.duration = report.duration;
    this.light();
    this.warm();
  }

  /// Begins to make the programs of the model, so that they are there when it is read. Nothing waits for them here.
  warm() {
    const geometry = new BufferGeometry();
    for (const name of ["position", "normal"]) geometry.setAttribute(name, new BufferAttribute(new Float32Array(9), 3));
    const mesh = new Mesh(geometry, new MeshStandardMaterial());
    mesh.receiveShadow = true;
    this.scene.add(mesh);
    this.renderer.compile(this.scene, this.camera);
    this.scene.remove(mesh);
  }

  async load(bytes) {
    const gltf = await new GLTFLoader().parseAsync(bytes, "");
    this.root = gltf.scene;
    this.scene.add(this.root);
    this.mixer = new AnimationMixer(this.root);
    let clipEnd = 0;
    for (const clip of gltf.animations) {
      this.mixer.clipAction(clip).play();
      clipEnd = Math.max(clipEnd, clip.duration);
    }
    // The last moment before a clip begins again: earlier, a fast piece would not yet be where it ends.
    this.clipEnd = clipEnd * (1 - Number.EPSILON);
    this.duration = Math.max(clipEnd, this.report.duration);
    this.root.traverse((node) => {
      if (node.userData.id !== undefined) {
        this.pieces.set(node.userData.id, this.pieceOf(node));
      } else if (node.userData.grain !== undefined) {
        node.traverse((mesh) => { if (mesh.isMesh) mesh.castShadow = true; });
      } else if (node.userData.sheet !== undefined) {
        this.sheets.push(node);
        node.traverse((mesh) => { if (mesh.isMesh) mesh.castShadow = mesh.receiveShadow = true; });
      }
    });
    this.seek(0);
    this.shine();
    this.look();
  }

  /// Draws from now on.
  show() {
    this.shown = true;
    this.resize();
  }

  /// A body: its node, its meshes with the materials that the file gave them.
  pieceOf(node) {
    const meshes = [];
    node.traverse((mesh) => {
      if (!mesh.isMesh) return;
      mesh.castShadow = !node.userData.fixed;
      mesh.receiveShadow = true;
      meshes.push({ mesh, own: mesh.material, crack: mesh.geometry.hasAttribute("_damage_time") });
    });
    return { node, meshes, facts: node.userData, last: new Vector3(), speed: 0 };
  }

  light() {
    this.scene.add(new HemisphereLight("#ffffff", "#9aa0a8", 1.1), new AmbientLight("#ffffff", 0.35));
    this.sun = new DirectionalLight("#fff6e8", 2.1);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.scene.add(this.sun, this.sun.target);
  }

  /// Puts the sun where it lights all that moves.
  shine() {
    const { sun } = this;
    const box = this.movingBox();
    const size = Math.max(box.getSize(new Vector3()).length(), 1e-3);
    const middle = box.getCenter(new Vector3());
    sun.position.copy(middle).add(new Vector3(0.6, 1.4, 0.8).multiplyScalar(size));
    sun.target.position.copy(middle);
    const { camera } = sun.shadow;
    [camera.left, camera.right, camera.bottom, camera.top] = [-size, size, -size, size];
    [camera.near, camera.far] = [0.01 * size, 5 * size];
    sun.shadow.bias = -2e-4;
    sun.shadow.normalBias = 2e-3 * size;
    camera.updateProjectionMatrix();
  }

  /// Box around what moves, or around all where nothing does.
  movingBox() {
    const box = new Box3();
    const all = new Box3();
    const own = new Box3();
    for (const { node, facts } of this.pieces.values()) {
      if (facts.parent !== undefined) continue;
      own.setFromObject(node);
      if (own.isEmpty()) continue;
      all.union(own);
      if (!facts.fixed) box.union(own);
    }
    for (const node of this.sheets) {
      // Those that are there at first.
      if (node.scale.x > THERE) box.union(own.setFromObject(node));
    }
    return box.isEmpty() ? all : box;
  }

  /// Looks from where the scene says, or so that all that moves is seen.
  look() {
    const { view } = this.report;
    const box = this.movingBox();
    const size = Math.max(box.getSize(new Vector3()).length(), 1e-3);
    this.camera.near = 1e-3 * size;
    this.camera.far = 1e3 * size;
    if (view) {
      this.camera.position.set(view.eye[0], view.eye[2], -view.eye[1]);
      this.controls.target.set(view.target[0], view.target[2], -view.target[1]);
      this.camera.fov = view.fov;
    } else {
      const middle = box.getCenter(new Vector3());
      this.controls.target.copy(middle);
      this.camera.position.copy(middle).add(new Vector3(0.7, 0.45, 1.0).multiplyScalar(1.1 * size));
    }
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /// Shows the moment `time` [s].
  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.duration);
    if (this.mode === "speed") this.measureSpeeds();
    this.play(this.time);
    if (this.mode === "speed") this.colour();
    for (const piece of this.pieces.values()) piece.node.visible = piece.node.scale.x > THERE;
    this.draw();
  }

  /// Puts the bodies where they are at `time` [s]. At its very end a clip would begin again.
  play(time) {
    this.mixer.setTime(Math.min(time, this.clipEnd));
  }

  /// Speeds over the last frame, from places [m/s].
  measureSpeeds() {
    const step = 1 / 60;
    const before = Math.max(this.time - step, 0);
    const span = Math.max(this.time - before, 1e-9);
    this.play(before);
    for (const piece of this.pieces.values()) piece.last.copy(piece.node.position);
    this.play(this.time);
    for (const piece of this.pieces.values()) {
      const old = piece.facts.birth_s > before;
      piece.speed = old ? 0 : piece.last.distanceTo(piece.node.position) / span;
    }
  }

  draw() {
    if (this.shown) this.renderer.render(this.scene, this.camera);
  }

  /// Colours all pieces by `mode`: object, share, damage or speed.
  setMode(mode) {
    this.mode = mode;
    if (mode === "speed") this.measureSpeeds();
    this.colour();
    this.draw();
  }

  colour() {
    for (const piece of this.pieces.values()) {
      for (const part of piece.meshes) part.mesh.material = this.materialOf(piece, part);
    }
    this.highlight();
  }

  materialOf(piece, part) {
    const { facts } = piece;
    if (this.mode === "object") return part.own;
    if (this.mode === "share") {
      if (facts.sampled === undefined) return this.plain(NEUTRAL);
      if (facts.directed) return this.plain(DIRECTED);
      return this.plain(facts.sampled ? SAMPLED : SOLVED);
    }
    if (this.mode === "damage") {
      if (!part.crack) return this.plain(NEUTRAL);
      this.paintDamage(part.mesh.geometry);
      return this.plain(null);
    }
    if (facts.fixed) return this.plain(NEUTRAL);
    const top = Math.max(this.report.fastest, 1e-6);
    const share = Math.sqrt(Math.min(piece.speed / top, 1));
    return this.plain(viridis(Math.round(share * SPEED_BINS) / SPEED_BINS));
  }

  /// A material of one colour, or of the colours of the vertices; each is made once.
  plain(colour) {
    const key = colour ? colour.getHexString() : "vertices";
    if (!this.cache.has(key)) {
      const made = new MeshStandardMaterial({ roughness: 0.7, vertexColors: !colour });
      if (colour) made.color.copy(colour);
      this.cache.set(key, made);
    }
    return this.cache.get(key);
  }

  paintDamage(geometry) {
    if (geometry.hasAttribute("color")) return;
    const times = geometry.getAttribute("_damage_time");
    const { damage } = this.report;
    const span = Math.max(damage[1] - damage[0], 1e-12);
    const colours = new Float32Array(3 * times.count);
    for (let k = 0; k < times.count; k += 1) {
      viridis((times.getX(k) - damage[0]) / span).toArray(colours, 3 * k);
    }
    geometry.setAttribute("color", new BufferAttribute(colours, 3));
  }

  /// The piece under a point of the canvas [pixels].
  pick(x, y) {
    const { width, height } = this.canvas.getBoundingClientRect();
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    const shown = [...this.pieces.values()].filter((piece) => piece.node.visible);
    const hits = ray.intersectObjects(shown.map((piece) => piece.node), true);
    for (const { object } of hits) {
      let node = object;
      while (node && node.userData.id === undefined) node = node.parent;
      if (node) return node.userData.id;
    }
    return null;
  }

  select(id) {
    this.selected = id;
    this.colour();
    this.draw();
  }

  highlight() {
    const piece = this.pieces.get(this.selected);
    if (!piece) return;
    for (const { mesh } of piece.meshes) {
      mesh.material = mesh.material.clone();
      mesh.material.emissive = new Color("#ffb000");
      mesh.material.emissiveIntensity = 0.55;
    }
  }
}
