'use strict';
// Asks the server for pictures: small ones while the camera moves, as many as it answers in time,
// and a full one when it rests.
const canvas = document.querySelector('canvas'), form = document.querySelector('form');
const message = document.querySelector('[role=status]');
const context = canvas.getContext('2d');
const kDraftMs = 90, kRestMs = 180, kFlightMs = 700, kFewestPixels = 3000;
const kLongestSide = 4096;
const kPhotoModes = ['photo', 'error'];
const kSilence = 'The viewer does not answer; is tetrec-view still running?';
const kLegends = {
  color: '', photo: '', slice: 'a plane across the view; grey: tets without density',
  depth: 'bright: near', normals: 'red: right, green: up, blue: to the camera',
  tets: 'yellow: small, blue: large', error: 'black: 0, white: a quarter of the range or more'
};

// Vectors are arrays of three numbers, in world coordinates; z is up.
const add = (a, b, t = 1) => a.map((x, i) => x + t * b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [0, 1, 2].map(i => a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]);
const unit = a => a.map(x => x / Math.hypot(...a));
const mix = (a, b, t) => a.map((x, i) => x + t * (b[i] - x));

let scene, home, flight = 0, isFlying = false;
// `view` is the index of the photo's camera where the camera stands, or null.
let camera = {eye: [0, -3, 1], target: [0, 0, 0], up: [0, 0, 1], fov: 45, view: null};
let draftPixels = 30000, isBusy = false, wanted = null, restTimer = 0;

const forwardOf = c => unit(add(c.target, c.eye, -1));
const distanceOf = c => Math.hypot(...add(c.target, c.eye, -1));

// While the camera flies, no photo matches its view.
function shownMode() {
  const mode = form.mode.value;
  return camera.view === null && kPhotoModes.includes(mode) ? 'color' : mode;
}

// The largest picture of the window that the server paints; both sides shrink alike.
function fullSize() {
  const box = canvas.parentElement.getBoundingClientRect();
  const ratio = Math.min(devicePixelRatio, 2, kLongestSide / Math.max(box.width, box.height, 1));
  return {width: box.width * ratio, height: box.height * ratio};
}

function addressOf(isDraft) {
  const full = fullSize();
  const scale = isDraft ? Math.min(1, Math.sqrt(draftPixels / (full.width * full.height))) : 1;
  const side = length => Math.max(8, Math.round(length * scale));
  const query = new URLSearchParams({
    mode: shownMode(), w: side(full.width), h: side(full.height), draft: isDraft ? 1 : 0
  });
  if (shownMode() === 'slice') {
    const depth = distanceOf(camera) + (form.slice.value - 0.5) * 1.8 * scene.subject.size;
    query.set('slice', Math.max(depth, 1e-3 * scene.subject.size));
  }
  if (camera.view !== null) {
    query.set('view', camera.view);
  } else {
    query.set('eye', camera.eye);
    query.set('forward', forwardOf(camera));
    query.set('up', camera.up);
    query.set('fov', camera.fov);
  }
  return 'picture?' + query;
}

// The newest wish counts; there is one request at a time, but a draft does not wait for a full
// picture, which the server then gives up.
function ask(isDraft) {
  wanted = {isDraft};
  canvas.ariaBusy = true;
  if (!isBusy || (isBusy === 'full' && isDraft)) fetchWanted();
}

function askAtRest() {
  clearTimeout(restTimer);
  restTimer = setTimeout(() => { restTimer = 0; ask(false); }, kRestMs);
}

function move() {
  ask(true);
  askAtRest();
}

let newest = 0;
async function fetchWanted() {
  const {isDraft} = wanted, number = ++newest;
  wanted = null;
  isBusy = isDraft ? 'draft' : 'full';
  const begin = performance.now();
  try {
    const answer = await fetch(addressOf(isDraft));
    if (answer.status === 204) {  // given up for a draft, of another window if this is the newest
      if (number === newest) askAtRest();
    } else if (answer.ok) {
      const bitmap = await createImageBitmap(await answer.blob());
      if (number === newest) show(bitmap, isDraft, performance.now() - begin);
    } else {
      say(await answer.text());
    }
  } catch (error) {
    say(kSilence);
  }
  if (number !== newest) return;
  isBusy = false;
  if (wanted) fetchWanted();
  else canvas.ariaBusy = isFlying || restTimer !== 0;
}

function show(bitmap, isDraft, ms) {
  canvas.width = bitmap.width;
  canvas.height = bitmap.height;
  context.drawImage(bitmap, 0, 0);
  say('');
  const facts = document.body.dataset;
  facts.pictures = Number(facts.pictures || 0) + 1;
  facts.kind = isDraft ? 'draft' : 'full';
  facts.ms = Math.round(ms);
  if (!isDraft) return;
  facts.draftMs = Math.round(ms);
  const full = fullSize();
  const wished = draftPixels * Math.min(1.4, Math.max(0.4, kDraftMs / ms));
  draftPixels = Math.max(kFewestPixels, Math.min(full.width * full.height, wished));
}

function say(text) {
  if (message.textContent !== text) message.textContent = text;
}

// Of the camera that the user has moved: it no longer stands at a photo.
function leaveView() {
  flight++;
  isFlying = false;
  camera.view = null;
  form.view.value = '';
  camera.up = [0, 0, 1];
  offerModes();
}

function offerModes() {
  for (const name of kPhotoModes) {
    const option = form.mode.querySelector(`[value=${name}]`);
    option.disabled = camera.view === null;
    if (option.disabled && form.mode.value === name) form.mode.value = 'color';
  }
  document.querySelector('.slice').hidden = form.mode.value !== 'slice';
  document.querySelector('.legend').textContent = kLegends[form.mode.value];
}

function turn(dx, dy) {
  leaveView();
  const offset = add(camera.eye, camera.target, -1), radius = Math.hypot(...offset);
  const around = Math.atan2(offset[1], offset[0]) - dx;
  const up = Math.max(-1.55, Math.min(1.55, Math.asin(offset[2] / radius) + dy));
  camera.eye = add(camera.target, [Math.cos(up) * Math.cos(around), Math.cos(up) * Math.sin(around),
                                   Math.sin(up)], radius);
  move();
}

function shift(dx, dy) {
  leaveView();
  const right = unit(cross(forwardOf(camera), camera.up)), down = cross(forwardOf(camera), right);
  const step = add(right.map(x => -x * dx), down, -dy);
  camera.eye = add(camera.eye, step, distanceOf(camera));
  camera.target = add(camera.target, step, distanceOf(camera));
  move();
}

function zoom(factor) {
  leaveView();
  const radius = Math.min(1e3, Math.max(1e-3, distanceOf(camera) * factor / scene.subject.size));
  camera.eye = add(camera.target, forwardOf(camera), -radius * scene.subject.size);
  move();
}

// The camera of a photo looks at the point of its axis that is nearest to the subject.
function cameraOf(index) {
  const {eye, forward, up, fov} = scene.views[index];
  const ahead = dot(add(scene.subject.center, eye, -1), forward);
  const distance = Math.max(ahead, 0.1 * scene.subject.size);
  return {eye, target: add(eye, forward, distance), up, fov, view: index};
}

function fly(to) {
  const from = {...camera}, begin = performance.now(), mine = ++flight;
  const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
  const step = now => {
    if (mine !== flight) return;
    const t = still ? 1 : Math.min(1, Math.max(0, (now - begin) / kFlightMs));
    const s = t * t * (3 - 2 * t);
    camera = t >= 1 ? {...to} : {
      eye: mix(from.eye, to.eye, s), target: mix(from.target, to.target, s),
      up: mix(from.up, to.up, s), fov: from.fov + s * (to.fov - from.fov), view: null
    };
    isFlying = t < 1;
    if (!isFlying) offerModes();
    move();
    if (isFlying) requestAnimationFrame(step);
  };
  canvas.ariaBusy = isFlying = true;
  form.view.value = to.view === null ? '' : to.view;
  requestAnimationFrame(step);
}

function flyToNeighbor(step) {
  const count = scene.views.length, at = form.view.value === '' ? (step > 0 ? -1 : 0) : Number(form.view.value);
  fly(cameraOf((at + step + count) % count));
}

const pointers = new Map();
canvas.addEventListener('pointerdown', event => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
});
for (const name of ['pointerup', 'pointercancel'])
  canvas.addEventListener(name, event => pointers.delete(event.pointerId));
canvas.addEventListener('pointermove', event => {
  const last = pointers.get(event.pointerId);
  if (!last || !scene) return;
  const now = [event.clientX, event.clientY], height = canvas.clientHeight;
  const others = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
  pointers.set(event.pointerId, now);
  const [dx, dy] = [now[0] - last[0], now[1] - last[1]];
  if (others.length) {
    const apart = at => Math.max(1, Math.hypot(at[0] - others[0][0], at[1] - others[0][1]));
    zoom(apart(last) / apart(now));
  } else if (event.shiftKey || event.buttons & 6) {
    const perPixel = 2 * Math.tan(camera.fov * Math.PI / 360) / height;
    shift(dx * perPixel, dy * perPixel);
  } else {
    turn(dx * Math.PI / height, dy * Math.PI / height);
  }
});
canvas.addEventListener('contextmenu', event => event.preventDefault());
canvas.addEventListener('wheel', event => {
  event.preventDefault();
  const lines = event.deltaMode === 0 ? event.deltaY / 16 : event.deltaY;
  if (scene) zoom(Math.exp(0.03 * Math.max(-20, Math.min(20, lines))));
}, {passive: false});

// Shift moves sideways, as it does while dragging.
const turnOrShift = (dx, dy) => event => (event.shiftKey ? shift : turn)(dx, dy);
const keys = {
  ArrowLeft: turnOrShift(-0.1, 0), ArrowRight: turnOrShift(0.1, 0),
  ArrowUp: turnOrShift(0, 0.1), ArrowDown: turnOrShift(0, -0.1),
  '+': () => zoom(0.9), '=': () => zoom(0.9), '-': () => zoom(1 / 0.9),
  n: () => flyToNeighbor(1), p: () => flyToNeighbor(-1), h: () => fly(home)
};
addEventListener('keydown', event => {
  // These keys do nothing on a button, which has the focus once it has been clicked.
  const isField = event.target.closest('select, input');
  // Letters are upper case with Shift or Caps Lock.
  const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!scene || !action || isField || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  action(event);
});
form.addEventListener('submit', event => event.preventDefault());
form.mode.addEventListener('change', () => { offerModes(); move(); });
form.slice.addEventListener('input', move);
form.view.addEventListener('change', () => {
  if (form.view.value === '') { leaveView(); move(); } else fly(cameraOf(Number(form.view.value)));
});
form.next.addEventListener('click', () => flyToNeighbor(1));
form.previous.addEventListener('click', () => flyToNeighbor(-1));
form.home.addEventListener('click', () => fly(home));
new ResizeObserver(() => { if (scene) move(); }).observe(canvas.parentElement);

// The scene, or another one once the stages of the run were repeated: then the camera stays at its
// photo, or where it is if there is no such photo any more.
function takeScene(next) {
  const name = form.view.value && scene.views[form.view.value].name;
  scene = next;
  form.view.length = 1;
  scene.views.forEach((view, i) => form.view.add(new Option(view.name, i)));
  home = {...cameraOf(0), target: scene.subject.center, up: [0, 0, 1], view: null};
  const index = scene.views.findIndex(view => view.name === name);
  if (index < 0) return leaveView();
  flight++;
  isFlying = false;
  camera = cameraOf(index);
  form.view.value = index;
  offerModes();
}

let loaded = 0;
async function refresh() {
  try {
    const status = await (await fetch('status')).json();
    document.querySelector('.facts').textContent =
        `${status.field}, ${status.tets.toLocaleString('en')} tets`;
    if (status.scene !== scene.number) {
      takeScene(await (await fetch('scene')).json());
      move();
    } else if ((status.loaded !== loaded && loaded) || message.textContent === kSilence) {
      ask(false);  // clears the message, too
    }
    loaded = status.loaded;
    document.body.dataset.loaded = loaded;
    if (status.problem) say('Still the last field: ' + status.problem);
  } catch (error) {
    say(kSilence);
  }
  setTimeout(refresh, document.hidden ? 10000 : 2000);
}

async function start() {
  say('Loading');
  takeScene(await (await fetch('scene')).json());
  camera = {...home};
  move();
  refresh();
}
start().catch(error => say(String(error)));
