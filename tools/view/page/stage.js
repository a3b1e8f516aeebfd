// The picture: objects with the colours of the last frame, the background, camera and gizmos.
import * as THREE from './three/build/three.module.js';
import { OrbitControls } from './three/examples/jsm/controls/OrbitControls.js';
import { TransformControls } from './three/examples/jsm/controls/TransformControls.js';
import { backgroundMaterial, shared, surfaceMaterial } from './shaders.js';

const fadeTime = 250; // [ms], from coarser to exact colours
const keyTurn = 0.08; // [rad] per key press
const keyZoom = 1.1;
const keyAngle = (5 * Math.PI) / 180; // [rad] of rotation of an object or the light per key press
const keyScale = 1.05;
const lookPause = 500; // [ms], after which keys and wheel start a new gesture

// Directions of keys: right, away from the eye, up.
const keyDirections = {
  arrowleft: [-1, 0, 0], arrowright: [1, 0, 0], arrowup: [0, 1, 0], arrowdown: [0, -1, 0],
  pageup: [0, 0, 1], pagedown: [0, 0, -1],
};

async function fetched(path) {
  const response = await fetch(path);
  if (!response.ok) throw new Error(await response.text());
  return response.arrayBuffer();
}

export class Stage {
  // on: {look(gesture), moved(), place(id, change), placed(id), turnLight(quaternion), pick(id, part), gesture(),
  //      arrived()}
  constructor(canvas, on) {
    this.canvas = canvas;
    this.on = on;
    const context = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true });
    if (!context) throw new Error('This browser has no WebGL 2.');
    this.renderer = new THREE.WebGLRenderer({ canvas, context });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.autoClear = false;
    this.scene = new THREE.Scene();
    this.helpers = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.01, 1000);
    this.picture = { fov: 35, aspect: 4 / 3 }; // of the scene's camera
    this.objects = new Map(); // by id: THREE.Group
    this.colours = new Map(); // by id: of the last frame
    this.entities = [];
    this.meshes = []; // by entity: promise of geometry and materials
    this.looks = {}; // isPressed, gesture, time of the last change [ms]
    this.backgrounds = new Map(); // by light: promise of texture
    this.makeBackground();
    this.makeControls();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  makeBackground() {
    this.background = new THREE.Mesh(new THREE.PlaneBufferGeometry(2, 2), backgroundMaterial());
    this.background.frustumCulled = false;
    this.background.renderOrder = -1;
    this.scene.add(this.background);
    this.lightTurn = new THREE.Quaternion();
  }

  makeControls() {
    this.orbit = new OrbitControls(this.camera, this.canvas);
    this.orbit.enableDamping = false;
    this.orbit.screenSpacePanning = true;
    this.orbit.minDistance = 0.01;
    this.orbit.addEventListener('change', () => {
      this.dirty = true;
      this.on.moved();
      if (!this.isPlacing) this.on.look(this.lookGesture());
    });
    this.canvas.addEventListener('pointerdown', ({ isPrimary }) => {
      if (isPrimary) this.looks = { isPressed: true };
    });
    for (const type of ['pointerup', 'pointercancel'])
      window.addEventListener(type, ({ isPrimary }) => {
        if (isPrimary) this.looks = {};
      });
    this.gizmo = new TransformControls(this.camera, this.canvas);
    this.gizmo.setSize(0.8);
    this.helpers.add(this.gizmo);
    this.lightHandle = new THREE.Object3D();
    this.helpers.add(this.lightHandle);
    this.gizmo.addEventListener('dragging-changed', ({ value }) => {
      this.orbit.enabled = !value;
      this.dragged = value ? this.gizmo.object : null;
      this.on.gesture();
      if (!value && this.gizmo.object !== this.lightHandle) this.on.placed();
    });
    this.gizmo.addEventListener('change', () => (this.dirty = true));
    this.gizmo.addEventListener('objectChange', () => this.onGizmo());
    this.tool = 'look';
    this.chosen = null;
    let pressed = null;
    this.canvas.addEventListener('pointerdown', (event) => (pressed = [event.clientX, event.clientY]));
    this.canvas.addEventListener('pointerup', (event) => {
      const moved = pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]);
      if (event.button === 0 && moved < 4 && !this.gizmo.axis) this.pick(event);
      pressed = null;
    });
    this.canvas.addEventListener('keydown', (event) => this.onKey(event));
  }

  onGizmo() {
    const object = this.gizmo.object;
    if (object === this.lightHandle) {
      this.lightTurn.copy(object.quaternion);
      this.on.turnLight(object.quaternion);
    } else if (this.tool === 'rotate') {
      this.on.place(object.userData.id, { rotation: object.quaternion.toArray() });
    } else if (this.tool === 'scale') {
      // Scaling is uniform: uses the component that was dragged.
      const { x, y, z } = object.scale, was = object.userData.scale;
      const far = [x, y, z].reduce((a, b) => (Math.abs(b - was) > Math.abs(a - was) ? b : a));
      const scale = Math.min(1e3, Math.max(1e-3, far));
      object.scale.setScalar(scale);
      object.userData.scale = scale;
      this.on.place(object.userData.id, { scale });
    } else {
      this.on.place(object.userData.id, { translate: object.position.toArray() });
    }
    this.dirty = true;
  }

  // Returns the gesture: one from press to release, and one for keys or wheel until a pause.
  lookGesture() {
    const { isPressed, gesture, time } = this.looks, now = performance.now();
    const goesOn = gesture && (isPressed || now - time < lookPause);
    this.looks = { isPressed, gesture: goesOn ? gesture : this.on.gesture(), time: now };
    return this.looks.gesture;
  }

  // Arrows pan (OrbitControls). With Shift they orbit. + and - move closer and away.
  onKey(event) {
    const offset = this.camera.position.clone().sub(this.orbit.target);
    const at = new THREE.Spherical().setFromVector3(offset);
    if (event.shiftKey && event.key === 'ArrowLeft') at.theta -= keyTurn;
    else if (event.shiftKey && event.key === 'ArrowRight') at.theta += keyTurn;
    else if (event.shiftKey && event.key === 'ArrowUp') at.phi -= keyTurn;
    else if (event.shiftKey && event.key === 'ArrowDown') at.phi += keyTurn;
    else if (event.key === '+' || event.key === '=') at.radius /= keyZoom;
    else if (event.key === '-') at.radius *= keyZoom;
    else return;
    event.preventDefault();
    event.stopPropagation();
    at.makeSafe();
    this.camera.position.setFromSpherical(at).add(this.orbit.target);
    this.orbit.update();
  }

  // Moves, rotates or scales the selected object, or rotates the light, by a key. Returns true if the key was
  // used.
  nudge(key, isFine, isRepeated) {
    const [right, away, up] = keyDirections[key] ?? [0, 0, 0];
    const object = this.tool === 'light' ? this.lightHandle : this.objects.get(this.chosen);
    if (!keyDirections[key] || this.tool === 'look' || !object || !this.isSteering) return false;
    if (!isRepeated) {
      this.on.placed(); // each key press is a separate step
      this.on.gesture();
    }
    this.gizmo.attach(object);
    const amount = isFine ? 0.1 : 1, axis = this.floorAxis();
    const side = new THREE.Vector3(-axis.z, 0, axis.x);
    if (this.tool === 'translate') {
      const step = amount * this.keyStep();
      object.position.addScaledVector(side, right * step).addScaledVector(axis, away * step);
      object.position.y += up * step;
    } else if (this.tool === 'scale') {
      object.scale.multiplyScalar(keyScale ** (amount * (right + away + up)));
    } else {
      const turn = new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(0, 1, 0), amount * (right + up) * keyAngle);
      turn.multiply(new THREE.Quaternion().setFromAxisAngle(side, -amount * away * keyAngle));
      object.quaternion.premultiply(turn).normalize();
    }
    this.onGizmo();
    return true;
  }

  // Returns the horizontal world axis that points most away from the eye.
  floorAxis() {
    const { x, z } = this.orbit.target.clone().sub(this.camera.position);
    return Math.abs(x) > Math.abs(z) ? new THREE.Vector3(Math.sign(x), 0, 0) : new THREE.Vector3(0, 0, Math.sign(z) || 1);
  }

  // Returns the distance per key press: about 1/50 of the viewing distance, as 1, 2 or 5 times a power of
  // ten. [m]
  keyStep() {
    const wanted = this.camera.position.distanceTo(this.orbit.target) / 50;
    const power = 10 ** Math.floor(Math.log10(wanted));
    return power * [5, 2, 1].find((digit) => digit * power <= wanted * 1.0001);
  }

  setTool(tool) {
    this.tool = tool;
    this.showGizmo();
  }

  choose(id) {
    if (this.chosen !== null) this.tint(this.chosen, 0);
    this.chosen = id;
    if (id !== null) {
      this.tint(id, 0.35);
      setTimeout(() => this.tint(id, 0), 180);
    }
    this.showGizmo();
  }

  tint(id, amount) {
    this.objects.get(id)?.traverse((part) => {
      if (part.isMesh) for (const material of part.material) material.uniforms.tint.value = amount;
    });
    this.dirty = true;
  }

  showGizmo() {
    const object = this.objects.get(this.chosen);
    this.gizmo.detach();
    if (this.tool === 'light') {
      this.lightHandle.position.copy(this.orbit.target);
      this.lightHandle.quaternion.copy(this.lightTurn);
      this.gizmo.setMode('rotate');
      this.gizmo.setSpace('world');
      this.gizmo.attach(this.lightHandle);
    } else if (this.tool !== 'look' && object && this.isSteering) {
      this.gizmo.setMode(this.tool);
      this.gizmo.setSpace(this.tool === 'translate' ? 'world' : 'local');
      this.gizmo.attach(object);
    }
    this.dirty = true;
  }

  pick(event) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(
      (2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const [hit] = ray.intersectObjects([...this.objects.values()], true);
    if (!hit) return this.on.pick(null);
    const group = hit.object.parent;
    const parts = this.entities[group.userData.entity].parts, part = hit.face.materialIndex;
    this.on.pick(group.userData.id, parts[part]?.material ?? null, part);
  }

  // Returns the name of the scene's material of an object's part; null if the part has its model's material.
  materialOf(id, part) {
    return this.entities[this.objects.get(id)?.userData.entity]?.parts[part].material ?? null;
  }

  lookAtObject(id) {
    const group = this.objects.get(id);
    if (!group) return;
    this.looks = {};
    const sphere = new THREE.Box3().setFromObject(group).getBoundingSphere(new THREE.Sphere());
    const along = this.camera.position.clone().sub(this.orbit.target).normalize();
    this.orbit.target.copy(sphere.center);
    const distance = sphere.radius / Math.sin((this.camera.fov * Math.PI) / 360);
    this.camera.position.copy(sphere.center).addScaledVector(along, distance);
    this.orbit.update();
  }

  // Applies the session's list of objects, except to an object that is being dragged.
  setObjects(list) {
    const known = new Set(list.map(({ id }) => id));
    for (const [id, group] of this.objects)
      if (!known.has(id)) {
        this.scene.remove(group);
        group.traverse((part) => part.geometry?.dispose());
        this.objects.delete(id);
        if (this.chosen === id) this.on.pick(null);
      }
    for (const described of list) {
      let group = this.objects.get(described.id);
      if (!group) {
        group = new THREE.Group();
        // After an undone deletion, the last frame still has the colours.
        group.userData = { id: described.id, entity: described.entity, colours: this.colours.get(described.id) };
        this.objects.set(described.id, group);
        this.scene.add(group);
        this.dress(group);
      }
      group.userData.name = described.name;
      if (group === this.dragged) continue;
      group.position.fromArray(described.translate);
      group.quaternion.fromArray(described.rotation);
      group.scale.setScalar(described.scale);
      group.userData.scale = described.scale;
    }
    this.dirty = true;
  }

  // Gives a group its mesh and separate colours.
  async dress(group) {
    const { geometry, parts } = await this.mesh(group.userData.entity);
    const own = new THREE.BufferGeometry();
    own.setIndex(geometry.index);
    own.setAttribute('position', geometry.attributes.position);
    if (geometry.attributes.uv) own.setAttribute('uv', geometry.attributes.uv);
    own.groups = geometry.groups;
    own.boundingSphere = geometry.boundingSphere;
    own.boundingBox = geometry.boundingBox;
    const materials = parts.map(({ texture, cut_out }) => surfaceMaterial(texture, cut_out, false));
    group.userData.geometry = own;
    group.userData.materials = materials;
    if (group.userData.colours) this.colour(group, group.userData.colours, false);
  }

  mesh(number) {
    return (this.meshes[number] ??= this.loadMesh(this.entities[number]));
  }

  async loadMesh(entity) {
    const bytes = await fetched(entity.mesh);
    const [vertices, triangles, hasUvs, materials] = new Uint32Array(bytes, 0, 4);
    const starts = [...new Uint32Array(bytes, 16, materials), triangles];
    let at = 16 + 4 * materials;
    const geometry = new THREE.BufferGeometry();
    const take = (Type, count) => {
      const taken = new Type(bytes, at, count);
      at += 4 * count;
      return taken;
    };
    geometry.setAttribute('position', new THREE.BufferAttribute(take(Float32Array, 3 * vertices), 3));
    if (hasUvs) geometry.setAttribute('uv', new THREE.BufferAttribute(take(Float32Array, 2 * vertices), 2));
    geometry.setIndex(new THREE.BufferAttribute(take(Uint32Array, 3 * triangles), 1));
    for (let m = 0; m < materials; ++m)
      if (starts[m + 1] > starts[m]) geometry.addGroup(3 * starts[m], 3 * (starts[m + 1] - starts[m]), m);
    geometry.computeBoundingSphere();
    geometry.computeBoundingBox();
    const parts = await Promise.all(entity.parts.map(async ({ texture, cut_out }) => ({
      texture: texture && (await this.image(texture)), cut_out })));
    return { geometry, parts };
  }

  image(path) {
    return new Promise((resolve, reject) =>
      new THREE.TextureLoader().load(path, (texture) => {
        texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
        resolve(texture);
      }, undefined, reject));
  }

  // Displays a frame. Exact colours fade in if other colours were displayed.
  show(frame) {
    const fades = frame.exactness === 'exact' && this.hasColours && !matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.colours = frame.objects;
    for (const [id, colours] of frame.objects) {
      const group = this.objects.get(id);
      if (!group) continue;
      group.userData.colours = colours;
      if (group.userData.geometry) this.colour(group, colours, fades);
    }
    this.hasColours = true;
    this.fadeStart = fades ? performance.now() : -Infinity;
    this.dirty = true;
  }

  colour(group, { under, over }, fades) {
    const { geometry, materials } = group.userData;
    const now = geometry.attributes.under;
    const set = (name, array) => {
      const attribute = geometry.attributes[name];
      if (!attribute) {
        geometry.setAttribute(name, new THREE.BufferAttribute(array, 3).setUsage(THREE.DynamicDrawUsage));
      } else {
        attribute.array = array;
        attribute.needsUpdate = true;
      }
    };
    set('underBefore', fades && now ? now.array : under);
    set('under', under);
    if (over) set('over', over);
    for (const material of materials)
      if (('OVER' in material.defines) !== Boolean(over)) {
        if (over) material.defines.OVER = 1;
        else delete material.defines.OVER;
        material.needsUpdate = true;
      }
    if (group.children.length > 0) return;
    group.add(new THREE.Mesh(geometry, materials));
    this.on.arrived();
  }

  // Applies the session's light.
  async setLight({ light, second, share, rotation, sky }, gain) {
    const { uniforms } = this.background.material;
    if (this.dragged !== this.lightHandle) {
      this.lightTurn.fromArray(rotation);
      this.lightHandle.quaternion.copy(this.lightTurn);
    }
    uniforms.gain.value = gain;
    uniforms.share.value = second ? share : 0;
    const current = (this.lightNumber = (this.lightNumber ?? 0) + 1);
    const [first, other] = await Promise.all([this.panorama(light, sky), second && this.panorama(second)]);
    if (this.lightNumber !== current) return;
    uniforms.first.value = first;
    uniforms.second.value = other || first;
    this.dirty = true;
  }

  // Returns the texture of a light. A changed sky is fetched again, and the previous texture is disposed of.
  panorama(name, sky = null) {
    const version = JSON.stringify(sky);
    const known = this.backgrounds.get(name);
    if (known?.version === version) return known.texture;
    known?.texture.then((texture) => texture.dispose());
    const texture = this.loadPanorama(name);
    this.backgrounds.set(name, { version, texture });
    return texture;
  }

  async loadPanorama(name) {
    const bytes = await fetched('background/' + encodeURIComponent(name));
    const [width, height] = new Uint32Array(bytes, 0, 2);
    const texture = new THREE.DataTexture(
      new Uint16Array(bytes, 8), width, height, THREE.RGBAFormat, THREE.HalfFloatType, THREE.UVMapping,
      THREE.RepeatWrapping, THREE.ClampToEdgeWrapping, THREE.LinearFilter, THREE.LinearFilter);
    texture.needsUpdate = true;
    return texture;
  }

  // Returns the position and target of the camera.
  view() {
    return { position: this.camera.position.toArray(), target: this.orbit.target.toArray() };
  }

  isAt({ position, target }) {
    const near = 1e-4 * this.camera.position.distanceTo(this.orbit.target);
    return this.camera.position.distanceTo(new THREE.Vector3().fromArray(position)) < near &&
      this.orbit.target.distanceTo(new THREE.Vector3().fromArray(target)) < near;
  }

  lookFrom({ position, target }) {
    this.looks = {};
    this.camera.position.fromArray(position);
    this.orbit.target.fromArray(target);
    this.orbit.update();
  }

  // Returns the number of vertices of all objects.
  vertices() {
    return [...this.objects.values()].reduce((sum, { userData }) => sum + this.entities[userData.entity].vertices, 0);
  }

  // Returns the number of objects whose mesh or colours have not arrived.
  missing() {
    return [...this.objects.values()].filter((group) => group.children.length === 0).length;
  }

  setCamera({ position, target, vertical_fov, width, height }) {
    this.picture = { fov: vertical_fov, aspect: width / height };
    this.isPlacing = true;
    this.camera.position.fromArray(position);
    this.orbit.target.fromArray(target);
    this.resize();
    this.orbit.update();
    this.isPlacing = false;
  }

  // Shows the whole picture of the scene's camera, with margins on two sides if the window has another aspect
  // ratio.
  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    const half = Math.tan((this.picture.fov * Math.PI) / 360);
    const wanted = half * Math.max(1, this.picture.aspect / this.camera.aspect);
    this.camera.fov = (Math.atan(wanted) * 360) / Math.PI;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  // Returns the rectangle of the scene's picture in the window. [CSS pixels]
  pictureBox() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    const wide = width / height > this.picture.aspect;
    const w = wide ? height * this.picture.aspect : width, h = wide ? height : width / this.picture.aspect;
    return { left: (width - w) / 2, top: (height - h) / 2, width: w, height: h };
  }

  // Draws if something has changed. Returns whether it did.
  draw() {
    const fade = Math.min(1, (performance.now() - (this.fadeStart ?? -Infinity)) / fadeTime);
    if (shared.fade.value !== fade) this.dirty = true;
    shared.fade.value = fade;
    if (!this.dirty) return false;
    this.dirty = false;
    const { uniforms } = this.background.material;
    this.camera.updateMatrixWorld();
    uniforms.toWorld.value.setFromMatrix4(this.camera.matrixWorld);
    uniforms.toLight.value.setFromMatrix4(
      new THREE.Matrix4().makeRotationFromQuaternion(this.lightTurn.clone().conjugate()));
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    uniforms.corner.value.set(half * this.camera.aspect, half);
    this.background.visible = uniforms.first.value !== null;
    this.fitDepth();
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    if (this.gizmo.object) {
      this.renderer.clearDepth();
      this.renderer.render(this.helpers, this.camera);
    }
    return true;
  }

  // Sets near and far planes that suit small and large scenes.
  fitDepth() {
    const distance = this.camera.position.distanceTo(this.orbit.target);
    this.camera.near = Math.max(1e-4, distance / 100);
    this.camera.far = Math.max(distance * 100, 100);
    this.camera.updateProjectionMatrix();
  }
}
