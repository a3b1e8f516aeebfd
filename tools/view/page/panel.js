// The panel: lights, the selected object, its material, saving and tasks.
import * as THREE from './three/build/three.module.js';

const element = (id) => document.getElementById(id);
const up = new THREE.Vector3(0, 1, 0);

const toHex = (colour) => '#' + new THREE.Color().fromArray(colour).convertLinearToSRGB().getHexString();
const fromHex = (hex) => new THREE.Color(hex).convertSRGBToLinear().toArray();

// Describes the light of a picture with this number of bounces.
function lightOf(bounces) {
  if (bounces === 'auto') return 'all significant bounces of light';
  if (bounces === 0) return 'direct light alone';
  return bounces === 1 ? 'direct light and one bounce' : `direct light and ${bounces} bounces`;
}

// A radiance is edited as a colour, whose largest component is 1, and a strength.
const strengthOf = (radiance) => Math.max(...radiance);
const colourOf = (radiance) => strengthOf(radiance) > 0 ? radiance.map((c) => c / strengthOf(radiance)) : [1, 1, 1];
const scaled = (colour, strength) => colour.map((c) => c * strength);

function valueOf(material, key) {
  if (key === 'emission') return colourOf(material.emission);
  if (key === 'emission.strength') return strengthOf(material.emission);
  return key.split('.').reduce((value, part) => value[part], material);
}

function setValue(material, key, value) {
  if (key === 'emission') material.emission = scaled(value, strengthOf(material.emission) || 1);
  else if (key === 'emission.strength') material.emission = scaled(colourOf(material.emission), value);
  else {
    const parts = key.split('.'), last = parts.pop();
    parts.reduce((object, part) => object[part], material)[last] = value;
  }
}

// The fields of a material: key, label and range. Colours have no range.
const plainFields = [
  ['diffuse', 'Colour'], ['specular', 'Specular'], ['shininess', 'Shininess', 1, 1000, true],
  ['emission', 'Emission'], ['emission.strength', 'Strength', 0, 20],
  ['convention', 'Convention', ['physical', 'povray']]];
const finishFields = [
  ['pigment', 'Colour'], ['finish.diffuse', 'Diffuse', 0, 1], ['finish.phong', 'Phong', 0, 2],
  ['finish.phong_size', 'Phong size', 1, 1000, true], ['finish.specular', 'Specular', 0, 2],
  ['finish.emission', 'Emission', 0, 20],
  ['finish.roughness', 'Roughness', 0.0005, 1, true], ['finish.metallic', 'Metallic', 0, 1]];

// The fields of a sky: key, slider and number of digits.
const skyFields = [['sun_elevation', 'sun-elevation', 1], ['sun_azimuth', 'sun-azimuth', 0], ['turbidity', 'turbidity', 1]];

export class Panel {
  // on: {send, sendSoon, gesture, turn, choose, tool, stage}
  constructor(on) {
    this.on = on;
    this.materials = {};
    this.lights = [];
    this.content = {}; // objects, light and materials in the session's last messages
    this.reference = null; // the reference that is computed or displayed: view, and content as text
    this.listenToLight();
    this.listenToObject();
    this.listenToKeep();
    this.listenToKeys();
    for (const button of document.querySelectorAll('[data-tool]'))
      button.onclick = () => on.tool(button.dataset.tool);
    queueMicrotask(() => on.tool('look'));
    element('material').onchange = () => this.showMaterial();
  }

  // Makes a slider send while it moves, with one gesture from press to release.
  slider(id, use) {
    const input = element(id);
    input.addEventListener('pointerdown', () => this.on.gesture());
    input.addEventListener('keydown', () => this.on.gesture());
    input.addEventListener('input', () => use(Number(input.value)));
    input.addEventListener('pointerup', () => this.on.gesture());
  }

  listenToLight() {
    this.slider('turn', (degrees) => {
      const turn = new THREE.Quaternion().setFromAxisAngle(up, (degrees * Math.PI) / 180);
      element('turn-value').textContent = degrees + '°';
      this.on.turn(turn);
      this.on.sendSoon('turn_light', { rotation: turn.toArray() });
    });
    this.slider('exposure', (stops) => {
      element('auto-exposure').checked = false;
      element('exposure-value').textContent = stops.toFixed(1);
      this.on.sendSoon('exposure', { stops });
    });
    element('auto-exposure').onchange = ({ target }) =>
      this.on.send('exposure', { stops: target.checked ? 'auto' : Number(element('exposure').value) });
    this.slider('share', (share) => {
      element('share-value').textContent = Math.round(100 * share) + ' %';
      this.on.sendSoon('mix', { share });
    });
    this.listenToSky();
    this.listenToLamps();
    element('second').onchange = ({ target }) => this.sendLights(this.light.light, target.value);
    element('light-file').onchange = ({ target }) => this.upload(target.files);
    for (const type of ['dragenter', 'dragover'])
      window.addEventListener(type, (event) => {
        event.preventDefault();
        element('drop').hidden = false;
      });
    window.addEventListener('dragleave', (event) => {
      if (!event.relatedTarget) element('drop').hidden = true;
    });
    window.addEventListener('drop', (event) => {
      event.preventDefault();
      element('drop').hidden = true;
      this.upload(event.dataTransfer.files);
    });
  }

  listenToSky() {
    for (const [key, id, digits] of skyFields)
      this.slider(id, (value) => {
        this.light.sky = { ...this.light.sky, [key]: value };
        element(id + '-value').textContent = value.toFixed(digits);
        this.on.sendSoon('sky', this.light.sky);
      });
  }

  showSky(sky) {
    element('sky-fields').hidden = !sky;
    if (!sky) return;
    for (const [key, id, digits] of skyFields) {
      if (document.activeElement !== element(id)) element(id).value = sky[key];
      element(id + '-value').textContent = sky[key].toFixed(digits);
    }
  }

  listenToLamps() {
    element('lamp').onchange = () => this.showLamp();
    const change = (changed) => {
      const lamp = Object.assign(this.lamp(), changed);
      this.on.sendSoon('lamp', { name: lamp.name, colour: lamp.colour, position: lamp.position });
      this.showLampValues();
    };
    element('lamp-colour').onpointerdown = () => this.on.gesture();
    element('lamp-colour').oninput = ({ target }) =>
      change({ colour: scaled(colourOf(fromHex(target.value)), strengthOf(this.lamp().colour) || 1) });
    this.slider('lamp-strength', (x) => change({ colour: scaled(colourOf(this.lamp().colour), x === 0 ? 0 : 1000 ** (x - 0.5)) }));
    this.slider('lamp-height', (x) => {
      const { position: [px, , pz] } = this.lamp();
      change({ position: [px, this.lampReach * x, pz] });
    });
  }

  setLamps(lamps) {
    this.lamps = lamps;
    element('lamp-section').hidden = lamps.length === 0;
    const select = element('lamp'), was = select.value;
    select.replaceChildren(...lamps.map(({ name }) => new Option(name, name)));
    if (lamps.some(({ name }) => name === was)) select.value = was;
    if (lamps.length > 0 && !element('lamp-section').contains(document.activeElement)) this.showLamp();
  }

  lamp() {
    return this.lamps.find(({ name }) => name === element('lamp').value);
  }

  showLamp() {
    const { colour, position } = this.lamp(), strength = strengthOf(colour);
    this.lampReach = Math.max(3, 2 * position[1]);
    element('lamp-colour').value = toHex(colourOf(colour));
    element('lamp-strength').value = strength === 0 ? 0 : 0.5 + Math.log(strength) / Math.log(1000);
    element('lamp-height').value = position[1] / this.lampReach;
    this.showLampValues();
  }

  showLampValues() {
    const { colour, position } = this.lamp();
    element('lamp-strength-value').textContent = Number(strengthOf(colour).toPrecision(3));
    element('lamp-height-value').textContent = position[1].toFixed(2);
  }

  sendLights(light, second) {
    const share = Number(element('share').value);
    this.on.send('light', second ? { light, second, share } : { light });
  }

  async upload(files) {
    for (const file of files) {
      const response = await fetch('lights/' + encodeURIComponent(file.name), { method: 'POST', body: file })
        .catch((error) => ({ ok: false, text: () => error.message }));
      const text = await response.text();
      if (!response.ok) {
        const trouble = text.startsWith('{') ? JSON.parse(text).error : text;
        return this.notice(trouble);
      }
      this.sendLights(JSON.parse(text).light, '');
      if (/\.(jpe?g|png|webp|bmp|tga)$/i.test(file.name))
        this.notice(`${file.name} is an 8-bit image with sRGB values of at most 1. ` +
          'A panorama with a high dynamic range gives sharper shadows from the sun and lamps.', true, 8000);
    }
  }

  setLights(names) {
    this.lights = names;
    const box = element('lights');
    for (const old of [...box.children]) if (!names.includes(old.dataset.light)) old.remove();
    for (const name of names) {
      if ([...box.children].some((child) => child.dataset.light === name)) continue;
      const button = document.createElement('button');
      button.dataset.light = name;
      button.title = name;
      button.setAttribute('role', 'option');
      const image = new Image();
      image.loading = 'lazy';
      image.alt = '';
      image.src = 'thumbnail/' + encodeURIComponent(name);
      const label = document.createElement('span');
      label.textContent = name.replace(/\.[a-z]+$/i, '');
      button.append(image, label);
      button.onclick = () => this.sendLights(name, element('second').value);
      box.append(button);
    }
    const second = element('second');
    second.replaceChildren(new Option('nothing', ''), ...names.map((name) => new Option(name, name)));
    if (this.light) this.setLight(this.light);
  }

  setLight(light) {
    this.light = light;
    for (const button of element('lights').children)
      button.setAttribute('aria-selected', button.dataset.light === light.light);
    element('second').value = light.second ?? '';
    element('share-row').hidden = !light.second;
    const quiet = (id, value, text) => {
      if (document.activeElement !== element(id)) element(id).value = value;
      element(id + '-value').textContent = text;
    };
    quiet('share', light.share, Math.round(100 * light.share) + ' %');
    quiet('exposure', light.stops, light.stops.toFixed(1));
    element('auto-exposure').checked = light.exposure === 'auto';
    this.showSky(light.sky);
    this.showTurn(new THREE.Quaternion().fromArray(light.rotation));
  }

  showTurn(quaternion) {
    const toSun = new THREE.Vector3(0, 0, 1).applyQuaternion(quaternion);
    const degrees = Math.round((Math.atan2(toSun.x, toSun.z) * 180) / Math.PI);
    if (document.activeElement !== element('turn')) element('turn').value = degrees;
    element('turn-value').textContent = degrees + '°';
  }

  listenToObject() {
    element('object').onchange = ({ target }) => this.on.choose(target.value === '' ? null : Number(target.value));
    element('clone').onclick = () => this.clone();
    element('delete').onclick = () => this.remove();
    element('frame-object').onclick = () => this.on.stage.lookAtObject(this.on.stage.chosen);
  }

  clone() {
    if (this.on.stage.chosen === null) return this.notice('Select an object first: click one.');
    this.choosesNew = true;
    this.on.send('clone', { object: this.on.stage.chosen });
  }

  remove() {
    if (this.on.stage.chosen === null) return this.notice('Select an object first: click one.');
    this.on.send('delete', { object: this.on.stage.chosen });
  }

  setObjects(objects, chosen) {
    const select = element('object');
    select.replaceChildren(
      new Option('none: click an object', ''), ...objects.map(({ id, name }) => new Option(name, id)));
    select.value = chosen ?? '';
    const last = objects[objects.length - 1];
    if (this.choosesNew && objects.length > (this.count ?? 0) && last) this.on.choose(last.id);
    this.choosesNew = false;
    this.count = objects.length;
    for (const id of ['clone', 'delete', 'frame-object']) element(id).disabled = chosen === null;
  }

  // Selects the next object in the list, or the previous one.
  chooseNext(step) {
    const ids = (this.content.objects ?? []).map(({ id }) => id), at = ids.indexOf(this.on.stage.chosen);
    if (ids.length > 0) this.on.choose(ids[at < 0 ? (step > 0 ? 0 : ids.length - 1) : (at + step + ids.length) % ids.length]);
  }

  choose(id, material, part) {
    const isOwn = id !== null && material === null && part !== undefined;
    element('own-row').hidden = !isOwn;
    element('own').onclick = () => {
      this.ownPart = { id, part };
      this.on.send('own_material', { object: id, part });
    };
    element('material-fields').hidden = element('material').hidden = isOwn;
    element('material-section').hidden = !isOwn && Object.keys(this.materials).length === 0;
    element('object').value = id ?? '';
    for (const button of ['clone', 'delete', 'frame-object']) element(button).disabled = id === null;
    if (material && this.materials[material]) {
      element('material').value = material;
      this.showMaterial();
    }
  }

  setMaterials(materials) {
    const names = Object.keys(materials), select = element('material');
    if (Object.keys(this.materials).join() !== names.join()) {
      const was = select.value;
      select.replaceChildren(...names.map((name) => new Option(name, name)));
      if (names.includes(was)) select.value = was;
    }
    this.materials = materials;
    element('material-section').hidden = names.length === 0;
    if (this.ownPart) {
      const { id, part } = this.ownPart;
      this.ownPart = null;
      this.on.choose(id, this.on.stage.materialOf(id, part), part);
    }
    if (!element('material-fields').contains(document.activeElement)) this.showMaterial();
  }

  showMaterial() {
    const name = element('material').value, material = this.materials[name];
    if (!material) return;
    const fields = material.finish ? finishFields : plainFields;
    element('material-fields').replaceChildren(...fields.map((field) => this.materialField(name, field)));
  }

  materialField(name, [key, title, lowest, highest, isLogarithmic]) {
    const get = () => valueOf(this.materials[name], key);
    const set = (value) => {
      const changed = structuredClone(this.materials[name]);
      delete changed.has_image;
      setValue(changed, key, value);
      this.materials[name] = { ...changed, has_image: this.materials[name].has_image };
      this.on.sendSoon('material', { name, ...changed });
    };
    const label = document.createElement('label');
    label.append(title);
    const input = document.createElement(Array.isArray(lowest) ? 'select' : 'input');
    input.dataset.key = key;
    if (Array.isArray(lowest)) {
      for (const value of lowest) input.append(new Option(value, value));
      input.value = get();
      input.onchange = () => (this.on.gesture(), set(input.value));
    } else if (lowest === undefined) {
      input.type = 'color';
      input.value = toHex(get());
      input.onpointerdown = () => this.on.gesture();
      input.oninput = () => set(fromHex(input.value));
    } else {
      const output = document.createElement('output');
      const tell = () => (output.textContent = Number(get().toPrecision(3)));
      input.type = 'range';
      input.min = 0;
      input.max = 1;
      input.step = 0.002;
      const toValue = (x) => isLogarithmic ? lowest * (highest / lowest) ** x : lowest + x * (highest - lowest);
      input.value = isLogarithmic ? Math.log(get() / lowest) / Math.log(highest / lowest) : (get() - lowest) / (highest - lowest);
      input.onpointerdown = () => this.on.gesture();
      input.oninput = () => {
        set(toValue(Number(input.value)));
        tell();
      };
      tell();
      label.append(input, output);
      return label;
    }
    label.append(input);
    return label;
  }

  listenToKeep() {
    element('undo').onclick = () => this.on.send('undo');
    element('redo').onclick = () => this.on.send('redo');
    element('save').onclick = () => this.on.send('save');
    element('save-as').onclick = () => {
      const name = prompt('Name of the scene file, in the folder of the opened scene', this.file.replace(/\.toml$/, '_2.toml'));
      if (name) this.on.send('save', { name });
    };
    for (const task of ['bake', 'picture', 'reference'])
      element(task).onclick = () => this.on.send('start', { task });
    for (const answer of ['restore', 'discard']) element(answer).onclick = () => this.on.send(answer);
    element('autosave').oncancel = (event) => event.preventDefault(); // a choice is required
    element('task-cancel').onclick = () => this.on.send('cancel');
    element('compare-button').onclick = () => this.compare(element('compare').hidden);
    element('reference').addEventListener('click', () => this.beginReference());
    element('compare-slider').oninput = ({ target }) =>
      (element('compare-image').style.clipPath = `inset(0 ${100 - target.value / 10}% 0 0)`);
    window.addEventListener('resize', () => this.placeComparison());
  }

  beginReference() {
    this.reference = { view: this.on.stage.view(), content: JSON.stringify(this.content) };
  }

  // Stores the scene state that a reference shows.
  setContent({ objects, light, materials }) {
    for (const [key, value] of Object.entries({ objects, light, materials })) if (value) this.content[key] = value;
    this.labelReference();
  }

  labelReference() {
    if (!this.reference?.light) return;
    const isStale = this.reference.content !== JSON.stringify(this.content);
    element('reference-light').textContent =
      (isStale ? 'reference of an earlier state of the scene: ' : 'reference: ') + this.reference.light;
  }

  // Ends a comparison when the view no longer matches the reference.
  viewMoved() {
    if (!element('compare').hidden && !this.on.stage.isAt(this.reference.view)) this.compare(false);
  }

  // Offers changes that an earlier session left unsaved; null: closes the offer.
  offerAutosave(file) {
    const box = element('autosave');
    if (file === null) return box.close();
    element('autosave-file').textContent = file;
    if (!box.open) box.showModal();
  }

  compare(isShown) {
    if (isShown && !this.on.stage.isAt(this.reference.view)) this.on.stage.lookFrom(this.reference.view);
    element('compare').hidden = !isShown;
    element('compare-button').setAttribute('aria-pressed', isShown);
    this.placeComparison();
  }

  placeComparison() {
    const box = this.on.stage.pictureBox();
    const { style } = element('compare'), { bottom } = element('tools').getBoundingClientRect();
    for (const side of ['left', 'top', 'width', 'height']) style[side] = box[side] + 'px';
    // Labels are below the toolbar, the slider is above the status.
    const stage = element('stage').getBoundingClientRect(), status = element('status').getBoundingClientRect();
    style.setProperty('--label-top', Math.max(8, bottom - stage.top + 8 - box.top) + 'px');
    style.setProperty('--slider-bottom', Math.max(8, box.top + box.height - (status.top - stage.top) + 8) + 'px');
  }

  setTask(message) {
    const isRunning = message.state === 'running';
    // Another page or a program may have started the task.
    if (message.task === 'reference' && isRunning && (!this.reference || this.reference.light)) this.beginReference();
    element('task').hidden = !isRunning;
    element('task-name').textContent = message.task + (message.stage ? ': ' + message.stage : '');
    element('task-bar').style.width = 100 * (message.share ?? 0) + '%';
    if (message.state === 'failed') this.notice(`${message.task}: ${message.message}`);
    if (message.state !== 'done') return;
    const list = element('files');
    list.replaceChildren(...message.files.map((name) => {
      const item = document.createElement('li'), link = document.createElement('a');
      link.href = 'made/' + encodeURIComponent(name);
      link.textContent = link.download = name;
      item.append(link);
      return item;
    }));
    if (message.task === 'reference') {
      element('compare-image').src = 'made/reference.png?' + Date.now();
      element('compare-button').disabled = false;
      if (!this.reference || this.reference.light) this.beginReference();
      this.reference.light = lightOf(message.bounces);
      this.labelReference();
      element('view-light').textContent = 'this view: ' + lightOf(this.bounces);
      if (!this.on.stage.isAt(this.reference.view))
        return this.notice('The reference is done. Compare returns to its view.', true, 8000);
      this.compare(true);
    }
    this.notice(`${message.task} is done.`, true);
  }

  listenToKeys() {
    const tools = { v: 'look', w: 'translate', e: 'rotate', r: 'scale', l: 'light' };
    window.addEventListener('keydown', (event) => {
      if (event.target.matches('input, select, textarea') || document.querySelector('dialog[open]')) return;
      const key = event.key.toLowerCase();
      if (event.ctrlKey || event.metaKey) {
        if (key === 'z') this.on.send(event.shiftKey ? 'redo' : 'undo');
        else if (key === 'y') this.on.send('redo');
        else if (key === 's') this.on.send('save');
        else return;
        event.preventDefault();
      } else if (tools[key]) this.on.tool(tools[key]);
      else if (key === 'd') this.clone();
      else if (key === 'delete' || key === 'backspace') this.remove();
      else if (key === '?') element('keys').showModal();
      else if (key === 'n') this.chooseNext(event.shiftKey ? -1 : 1);
      else if (key === 'f') this.on.stage.lookAtObject(this.on.stage.chosen);
      else if (key === 'escape') this.on.choose(null);
    });
    // Runs before OrbitControls, which pans with the arrow keys.
    window.addEventListener('keydown', (event) => {
      if (event.target.matches('input, select, textarea') || document.querySelector('dialog[open]')) return;
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (!this.on.stage.nudge(event.key.toLowerCase(), event.shiftKey, event.repeat)) return;
      event.preventDefault();
      event.stopImmediatePropagation();
    }, true);
    element('show-keys').onclick = () => element('keys').showModal();
  }

  notice(text, isGood = false, time = isGood ? 4000 : 8000) {
    const box = element('notice');
    box.textContent = text;
    box.classList.toggle('good', isGood);
    box.hidden = false;
    clearTimeout(this.noticeTimer);
    this.noticeTimer = setTimeout(() => (box.hidden = true), time);
  }
}
