// The page: connects the session, the picture and the panel.
import { Connection } from './connection.js';
import { Panel } from './panel.js';
import { Stage } from './stage.js';

const element = (id) => document.getElementById(id);
// Descriptions of the colours by exactness.
const words = {
  moving: ['transfer vectors, coarser while moving', 'Precomputed transfer vectors update the colours while you edit.'],
  orbiting: ['transfer vectors, no indirect light in reflections', 'While the camera moves, specular reflections show ' +
    'direct light only. Indirect light in them follows when the camera rests.'],
  quick: ['shaded by fields', 'Occlusion by other objects is interpolated from visibility fields.'],
  exact: ['exact at vertices', 'Every vertex has its exact colour. ' +
    'Colours are interpolated between vertices, so shadow edges are only as sharp as the mesh allows. ' +
    'A bake adds vertices until its error is small.'],
};
const jobs = { vectors: 'vectors', shading: 'shading', exact: 'computing exact colours', ahead: 'preparing',
  measuring: 'measuring the error' };

const percent = (share) => `${(100 * share).toPrecision(2)} %`;

let steers = false;
let gesture = 0;
let light = null;
let gain = 1;
let frames = 0;

const stats = { frames: 0, last: null, applied: [], server: [], exact: 0, errors: [], tasks: [], autosave: null };

const connection = new Connection({
  open() {
    element('lost').hidden = true;
  },
  lost(seconds, isFinal) {
    element('lost').hidden = false;
    element('lost-text').textContent = isFinal
      ? `No answer from ${location.host} for ${Math.round(seconds)} s: haarfield view has ended. ` +
        'Start it again and open the address that it prints; each run has a new one.'
      : 'Reconnecting …';
    element('reconnect').hidden = !isFinal;
    stage.hasColours = false;
  },
  text(message) {
    receivers[message.type]?.(message);
  },
  frame(frame) {
    stage.show(frame);
    stats.last = frame;
    ++stats.frames;
    if (frame.exactness === 'exact') ++stats.exact;
    else stats.measured = null;
    const took = frame.message ? connection.since(frame.message) : undefined;
    if (took !== undefined && frame.exactness === 'moving') {
      stats.applied.push(took);
      stats.server.push(frame.milliseconds);
    }
    showStatus();
    waiting = frame.frame;
  },
});

function showStatus() {
  const missing = stage.missing();
  const isComplete = stats.last && missing === 0;
  const known = stats.last?.exactness === 'moving' && stats.lacksReflections ? 'orbiting' : stats.last?.exactness;
  const [text, title] = isComplete
    ? words[known]
    : [`loading ${missing} of ${stage.objects.size} objects`, 'Meshes and colours are being loaded.'];
  element('exactness').className = 'pill ' + (isComplete ? stats.last.exactness : 'moving');
  const measured = known === 'exact' && stats.measured?.error != null ? stats.measured : null;
  const error = measured ? `error ${percent(measured.error)}` : text;
  element('exactness').textContent = isComplete ? `${error} · ${stage.vertices().toLocaleString('en')} vertices` : text;
  const details = measured && `Relative error of this view, against rays: ${percent(measured.low)} to ` +
    `${percent(measured.high)} with 90 % confidence, of which ${percent(measured.between_vertices)} between vertices. `;
  element('exactness').title = (details ?? '') + title;
}


let waiting = 0; // the frame that is displayed with the next picture

const stage = new Stage(element('canvas'), {
  moved: () => panel.viewMoved(),
  arrived: showStatus,
  look: (lookGesture) => steers && connection.sendSoon('look', { gesture: lookGesture, ...looking() }),
  gesture: () => (gesture = connection.newGesture()),
  place: (id, change) => connection.sendSoon('place', { object: id, gesture, ...change }),
  placed: () => connection.flush(),
  turnLight: (quaternion) => {
    connection.sendSoon('turn_light', { rotation: quaternion.toArray(), gesture });
    panel.showTurn(quaternion);
  },
  pick: (id, material, part) => choose(id, material, part),
});

function looking() {
  const box = stage.canvas.parentElement;
  return {
    position: stage.camera.position.toArray(), target: stage.orbit.target.toArray(),
    vertical_fov: stage.camera.fov, width: Math.max(1, box.clientWidth), height: Math.max(1, box.clientHeight),
  };
}

function choose(id, material, part) {
  stage.choose(id);
  panel.choose(id, material, part);
  if (steers) connection.send('select', { object: id });
}

const panel = new Panel({
  send: (type, content) => {
    connection.flush(); // earlier edits
    if (steers) connection.send(type, content);
  },
  sendSoon: (type, content) => steers && connection.sendSoon(type, { gesture, ...content }),
  gesture: () => (gesture = connection.newGesture()),
  turn: (quaternion) => {
    stage.lightTurn.copy(quaternion);
    stage.lightHandle.quaternion.copy(quaternion);
    stage.dirty = true;
  },
  choose, stage,
  tool: (tool) => {
    stage.setTool(tool);
    for (const button of document.querySelectorAll('[data-tool]'))
      button.setAttribute('aria-pressed', button.dataset.tool === tool);
  },
});

function setLight(message) {
  light = message;
  gain = 2 ** message.stops;
  stage.setLight(message, gain).catch((error) => panel.notice(error.message));
  panel.setLight(message);
}

function takeState(message) {
  if (message.camera && (!steers || message.steps || message.type === 'scene')) stage.setCamera(message.camera);
  if (message.objects) {
    stage.setObjects(message.objects);
    panel.setObjects(message.objects, stage.chosen);
    if (stats.last) showStatus();
  }
  message.part_materials?.forEach((names, e) => names.forEach((name, m) => (stage.entities[e].parts[m].material = name)));
  if (message.lamps) panel.setLamps(message.lamps);
  if (message.materials) panel.setMaterials(message.materials);
  if (message.lights) panel.setLights(message.lights);
  if (message.light) setLight(message.light);
  element('undo').disabled = !(steers && message.can_undo);
  panel.setContent(message);
  element('redo').disabled = !(steers && message.can_redo);
}

function setSteering(value) {
  steers = stage.isSteering = value;
  document.body.classList.toggle('watching', !value);
  element('steer').hidden = value;
  stage.showGizmo();
}

const receivers = {
  scene(message) {
    setSteering(message.steers);
    if (stats.scene !== message.session) {
      stage.entities = message.entities;
      stage.meshes = [];
      stage.setObjects([]);
      stats.scene = message.session;
    }
    element('scene-name').textContent = message.name;
    document.title = message.name + ' – haarfield';
    panel.file = message.file;
    panel.bounces = message.bounces;
    takeState(message);
    if (steers) connection.send('look', looking());
  },
  state: takeState,
  steering({ steers: value }) {
    setSteering(value);
    panel.offerAutosave(value ? stats.autosave : null);
  },
  work({ doing, share, lacks_reflections: lacksReflections }) {
    element('work').classList.toggle('busy', doing !== '');
    element('work-name').textContent = jobs[doing] ?? '';
    element('work-bar').style.width = 100 * share + '%';
    stats.doing = doing;
    stats.lacksReflections = lacksReflections;
    showStatus();
  },
  error(message) {
    stats.errors.push(message);
    panel.notice(message.message);
  },
  rest(message) {
    stats.rest = message;
  },
  measured(message) {
    stats.measured = message;
    showStatus();
  },
  autosave({ file }) {
    stats.autosave = file;
    panel.offerAutosave(steers ? file : null);
  },
  saved({ file, instead_of: spared }) {
    stats.saved = file;
    const why = spared ? `. ${spared.split('/').pop()} has comments that would be lost, so it was left unchanged.` : '';
    panel.notice('Saved ' + file + why, true, spared ? 12000 : undefined);
  },
  task(message) {
    stats.tasks.push(message);
    panel.setTask(message);
  },
};

element('reconnect').onclick = () => {
  element('reconnect').hidden = true;
  element('lost-text').textContent = 'Reconnecting …';
  connection.retry();
};
element('steer').onclick = () => connection.send('steer');

// Before each picture, pending edits are sent. A frame counts as displayed once it is drawn.
let second = performance.now();
function next() {
  requestAnimationFrame(next);
  connection.flush();
  if (stage.draw()) ++frames;
  if (waiting) {
    connection.shown(waiting);
    waiting = 0;
  }
  const now = performance.now();
  if (now - second > 500) {
    const fps = frames === 0 ? '' : Math.round((1000 * frames) / (now - second)) + ' fps';
    const took = stats.applied.at(-1);
    element('rates').textContent = [fps, took === undefined ? '' : Math.round(took) + ' ms'].filter(Boolean).join(' · ');
    frames = 0;
    second = now;
  }
}
next();

// An interface for programs that drive the page, such as the tests.
window.haarfield = { stage, connection, panel, stats, isSteering: () => steers, light: () => light };
