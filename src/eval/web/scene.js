// The report's 3-D scene: surface, cameras and sparse points, to turn by mouse, touch and keys.
// Frames: the page gives cameras and points in the world, z up, and world_from_surface. Colours are
// display sRGB from end to end, so that the surface looks as the photos do: what glTF stores as
// linear is converted back, and three.js converts nothing.
(() => {
  const box = document.querySelector('.scene');
  if (!box) return;
  const canvas = box.querySelector('canvas'), message = box.querySelector('[role=status]');
  const control = (name) => box.querySelector(`[name=${name}]`);
  const fail = (text) => {
    box.dataset.state = 'failed';
    message.textContent = text;
    canvas.hidden = true;
  };
  const bytes = (name) => Uint8Array.from(atob(box.dataset[name] || ''), (c) => c.charCodeAt(0));
  const floats = (name) => new Float32Array(bytes(name).buffer);

  if (!document.createElement('canvas').getContext('webgl')) {
    fail('This browser has no WebGL, which the 3-D scene needs. The pictures below show the surface.');
    return;
  }
  const renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true});
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(45, 1, 0.01, 1000);
  camera.up.set(...JSON.parse(box.dataset.up));
  const light = new THREE.DirectionalLight(0xffffff, 0.75);  // from the viewer
  camera.add(light);
  scene.add(camera, new THREE.AmbientLight(0xffffff, 0.3));

  let requested = false;
  const draw = () => {
    if (requested) return;
    requested = true;
    requestAnimationFrame(() => {
      requested = false;
      renderer.render(scene, camera);
    });
  };

  // Sparse points.
  const positions = floats('points'), colors = bytes('colors');
  const cloud = new THREE.BufferGeometry();
  cloud.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  cloud.setAttribute('color', new THREE.BufferAttribute(colors, 3, true));
  const points = new THREE.Points(cloud, new THREE.PointsMaterial({
    size: 2, sizeAttenuation: false, vertexColors: THREE.VertexColors}));
  scene.add(points);

  // Cameras: centre and four corners of the picture each, as the lines of a pyramid.
  const kPyramid = [0, 1, 0, 2, 0, 3, 0, 4, 1, 2, 2, 3, 3, 4, 4, 1];
  const corners = floats('cameras'), held_out = bytes('heldOut');
  const cornerOf = (view, i) => new THREE.Vector3().fromArray(corners, 15 * view + 3 * i);
  const cameras = new THREE.Group();
  for (const kind of [0, 1]) {
    const lines = [];
    for (let view = 0; view < held_out.length; ++view) {
      if (held_out[view] === kind) for (const i of kPyramid) lines.push(cornerOf(view, i));
    }
    const geometry = new THREE.BufferGeometry().setFromPoints(lines);
    cameras.add(new THREE.LineSegments(
        geometry, new THREE.LineBasicMaterial({color: kind ? 0xe07b00 : 0x3d8fd1})));
  }
  scene.add(cameras);

  // Home: all of the subject, from the side of the first camera.
  const kFieldOfView = 45;
  const center = new THREE.Vector3(...JSON.parse(box.dataset.center));
  const radius = Number(box.dataset.radius);
  const controls = new THREE.OrbitControls(camera, canvas);
  controls.enableKeys = false;   // those move the target, and listen to the whole page
  controls.enableZoom = false;   // until the scene has the focus: a wheel over it scrolls the page
  controls.minDistance = 0.02 * radius;
  const goHome = () => {
    const side = held_out.length ? cornerOf(0, 0).sub(center) : new THREE.Vector3(1, -2, 1);
    camera.fov = kFieldOfView;
    const narrow = Math.min(1, camera.aspect);
    controls.target.copy(center);
    camera.position.copy(side.setLength(1.1 * radius / (narrow * Math.sin(kFieldOfView / 360 * Math.PI))))
        .add(center);
    camera.updateProjectionMatrix();
    controls.update();
    draw();
  };
  // From where a photo was taken, its whole picture in sight. The horizon stays level.
  const lookFrom = (view) => {
    const eye = cornerOf(view, 0), [a, b, c, d] = [1, 2, 3, 4].map((i) => cornerOf(view, i));
    const middle = a.clone().add(b).add(c).add(d).multiplyScalar(0.25);
    const depth = middle.distanceTo(eye);
    const height = Math.max(a.distanceTo(d), a.distanceTo(b) / camera.aspect) / 2;
    camera.fov = Math.atan(height / depth) * 360 / Math.PI;
    camera.position.copy(eye);
    controls.target.copy(middle.sub(eye).setLength(Math.max(center.distanceTo(eye), radius / 10)).add(eye));
    camera.updateProjectionMatrix();
    controls.update();
    draw();
  };

  // Turns around the target: by `turn` around the up axis, by `rise` towards it [rad].
  const orbit = (turn, rise, zoom) => {
    const upright = new THREE.Quaternion().setFromUnitVectors(camera.up, new THREE.Vector3(0, 1, 0));
    const offset = camera.position.clone().sub(controls.target).applyQuaternion(upright);
    const angles = new THREE.Spherical().setFromVector3(offset);
    angles.theta += turn;
    angles.phi = Math.min(Math.max(angles.phi - rise, 0.01), Math.PI - 0.01);
    angles.radius = Math.max(angles.radius * zoom, controls.minDistance);
    offset.setFromSpherical(angles).applyQuaternion(upright.inverse());
    camera.position.copy(offset).add(controls.target);
    controls.update();
    draw();
  };
  const kStep = Math.PI / 36, kZoom = 1.1;
  const keys = {
    ArrowLeft: () => orbit(-kStep, 0, 1), ArrowRight: () => orbit(kStep, 0, 1),
    ArrowUp: () => orbit(0, kStep, 1), ArrowDown: () => orbit(0, -kStep, 1),
    '+': () => orbit(0, 0, 1 / kZoom), '=': () => orbit(0, 0, 1 / kZoom),
    '-': () => orbit(0, 0, kZoom), Home: goHome,
  };
  canvas.addEventListener('keydown', (event) => {
    const action = !event.ctrlKey && !event.altKey && !event.metaKey && keys[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
  canvas.addEventListener('focus', () => { controls.enableZoom = true; });
  canvas.addEventListener('blur', () => { controls.enableZoom = false; });
  canvas.addEventListener('touchstart', () => canvas.focus({preventScroll: true}), {passive: true});
  controls.addEventListener('change', draw);

  const resize = () => {
    const width = Math.max(1, canvas.clientWidth), height = Math.max(1, canvas.clientHeight);
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    draw();
  };
  resize();
  new ResizeObserver(resize).observe(canvas);

  let reach = 50 * radius;
  for (let i = 0; i < positions.length; i += 3) {
    reach = Math.max(reach, 2 * new THREE.Vector3().fromArray(positions, i).distanceTo(center));
  }
  camera.near = 0.005 * radius;
  camera.far = reach;
  goHome();

  // Surface.
  const surface = new THREE.Group();
  scene.add(surface);
  const clay = new THREE.MeshPhongMaterial({color: 0xccc7bf, shininess: 0, side: THREE.DoubleSide});
  const wires = new THREE.MeshBasicMaterial({color: 0x888888, wireframe: true});
  // Vertices at the borders of texture charts are there once for each chart. They all get the sum
  // of their normals, so that the borders do not look like creases.
  const addSmoothNormals = (geometry) => {
    geometry.computeVertexNormals();
    const {position, normal} = geometry.attributes, sums = new Map();
    const keyOf = (i) => `${position.getX(i)} ${position.getY(i)} ${position.getZ(i)}`;
    const normalOf = (i) => new THREE.Vector3(normal.getX(i), normal.getY(i), normal.getZ(i));
    for (let i = 0; i < position.count; ++i) {
      sums.set(keyOf(i), normalOf(i).add(sums.get(keyOf(i)) || new THREE.Vector3()));
    }
    for (const sum of sums.values()) sum.normalize();
    for (let i = 0; i < position.count; ++i) {
      const sum = sums.get(keyOf(i));
      normal.setXYZ(i, sum.x, sum.y, sum.z);
    }
  };
  const show = () => {
    const look = control('look').value;
    surface.visible = look !== 'none';
    surface.traverse((mesh) => {
      if (!mesh.isMesh) return;
      if (look === 'clay' && !mesh.geometry.attributes.normal) addSmoothNormals(mesh.geometry);
      mesh.material = look === 'clay' ? clay : look === 'wires' ? wires : mesh.userData.colored;
    });
    points.visible = control('points').checked;
    cameras.visible = control('cameras').checked;
    draw();
  };
  const srgbOfLinear = (x) => x <= 0.0031308 ? 12.92 * x : 1.055 * Math.pow(x, 1 / 2.4) - 0.055;
  const keepSrgb = (mesh) => {
    mesh.material.side = THREE.DoubleSide;
    if (mesh.material.map) mesh.material.map.encoding = THREE.LinearEncoding;
    const linear = mesh.geometry.attributes.color;
    if (linear) {
      const display = new Uint8Array(3 * linear.count);
      for (let i = 0; i < linear.count; ++i) {
        [linear.getX(i), linear.getY(i), linear.getZ(i)].forEach((value, c) => {
          const share = linear.normalized ? value / (linear.array instanceof Uint8Array ? 255 : 65535) : value;
          display[3 * i + c] = Math.round(255 * srgbOfLinear(share));
        });
      }
      mesh.geometry.setAttribute('color', new THREE.BufferAttribute(display, 3, true));
    }
    mesh.userData.colored = mesh.material;
  };
  const ready = () => {
    for (const name of ['look', 'points', 'cameras']) control(name).addEventListener('change', show);
    control('from').addEventListener('change', (event) => {
      event.target.value === '' ? goHome() : lookFrom(Number(event.target.value));
    });
    box.querySelector('button').addEventListener('click', () => {
      control('from').value = '';
      goHome();
    });
    show();
    message.textContent = '';
    box.dataset.state = 'ready';
  };
  if (!box.dataset.surface) {
    ready();
    return;
  }
  new THREE.GLTFLoader().parse(bytes('surface').buffer, '', (gltf) => {
    gltf.scene.traverse((mesh) => { if (mesh.isMesh) keepSrgb(mesh); });
    surface.add(gltf.scene);
    surface.applyMatrix(new THREE.Matrix4().fromArray(JSON.parse(box.dataset.worldFromSurface)));
    ready();
  }, (error) => fail(`The surface cannot be shown: ${error.message || error}`));
})();
