// The picture, by vtk.js: objects with their names on a floor, where the hand is (HIP, red), where it would be if it could not
// penetrate (IHIP, blue), and the force (1 cm a newton; green, orange, red as it nears the limit).
import '@kitware/vtk.js/Rendering/Profiles/Geometry';
import vtkActor from '@kitware/vtk.js/Rendering/Core/Actor';
import vtkArrowSource from '@kitware/vtk.js/Filters/Sources/ArrowSource';
import vtkCellArray from '@kitware/vtk.js/Common/Core/CellArray';
import vtkDataArray from '@kitware/vtk.js/Common/Core/DataArray';
import vtkInteractor from '@kitware/vtk.js/Rendering/Core/RenderWindowInteractor';
import vtkMapper from '@kitware/vtk.js/Rendering/Core/Mapper';
import vtkOpenGLRenderWindow from '@kitware/vtk.js/Rendering/OpenGL/RenderWindow';
import vtkPolyData from '@kitware/vtk.js/Common/DataModel/PolyData';
import vtkRenderer from '@kitware/vtk.js/Rendering/Core/Renderer';
import vtkRenderWindow from '@kitware/vtk.js/Rendering/Core/RenderWindow';
import vtkSphereSource from '@kitware/vtk.js/Filters/Sources/SphereSource';
import vtkTrackball from '@kitware/vtk.js/Interaction/Style/InteractorStyleTrackballCamera';

import {badNumber, bodiesOf, dentsOf} from './limits.js';
import {decodeAsset, dent, normalsOf, openJaws, restShape} from './shapes.js';
import {hex} from './scene.js';

// As the viewer's (palette.h).
const BACKGROUND = [0.93, 0.94, 0.96], HIP = [0.86, 0.16, 0.2], IHIP = [0.05, 0.42, 0.9];
const FORCES = [[0.1, 0.62, 0.3], [0.95, 0.6, 0.05], [0.85, 0.1, 0.1]], FLOOR = [0.74, 0.76, 0.785];
const FLOOR_MARGIN = 0.12, MOST_LINES = 80, USUAL_FORCE_N = 5;
const LEAST_FPS = 25, LEAST_SCALE = 0.4, SETTLED_MS = 2500, PAUSE_MS = 500;
const PIT_BRIGHTNESS = 0.72, PEAK_BRIGHTNESS = 1.06;  // of the viewer, too
const BALL_M = 0.004, METRES_PER_NEWTON = 0.01, LEAST_FORCE_N = 0.02;

/** Whether WebGL is computed by the processor, where smooth edges cost four times the time. */
function isDrawnInSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const names = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/** Of a linear colour, as a screen wants it. */
const shown = ({red, green, blue}) => [red, green, blue].map((x) => Math.min(Math.max(x || 0, 0), 1) ** (1 / 2.2));
const xyz = (vector) => [vector?.x || 0, vector?.y || 0, vector?.z || 0];
const IDENTITY = {w: 1, x: 0, y: 0, z: 0};

/** Column by column, as vtk.js has it. */
function matrixOf({position, rotation}) {
  const {w, x, y, z} = rotation || IDENTITY;
  return [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0,
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0,
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0, ...xyz(position), 1];
}

function actorOf(source, color) {
  const mapper = vtkMapper.newInstance(), actor = vtkActor.newInstance();
  mapper.setInputConnection(source.getOutputPort());
  actor.setMapper(mapper);
  actor.getProperty().setColor(...color);
  actor.setVisibility(false);
  return actor;
}

/** Of a force that is this share of the limit. */
function forceColor(share) {
  const at = 2 * Math.min(share, 1), from = Math.min(Math.floor(at), 1);
  return FORCES[from].map((k, i) => k + (at - from) * (FORCES[from + 1][i] - k));
}

/** A grid below a box, whose lines are a power of ten in metres apart: that, and its lines. */
function gridBelow([west, east, south, north, bottom]) {
  const margin = FLOOR_MARGIN * Math.max(east - west, north - south);
  const spacing = 10 ** Math.ceil(Math.log10((Math.max(east - west, north - south) + 2 * margin) / MOST_LINES));
  const [left, right, front, back] = [west - margin, east + margin, south - margin, north + margin];
  const points = [], cells = [];
  const line = (...ends) => {
    cells.push(2, points.length / 3, points.length / 3 + 1);
    points.push(...ends);
  };
  for (let x = Math.ceil(left / spacing) * spacing; x <= right; x += spacing) line(x, front, bottom, x, back, bottom);
  for (let y = Math.ceil(front / spacing) * spacing; y <= back; y += spacing) line(left, y, bottom, right, y, bottom);
  const data = vtkPolyData.newInstance();
  data.getPoints().setData(Float32Array.from(points), 3);
  data.setLines(vtkCellArray.newInstance({values: Uint32Array.from(cells)}));
  return {spacing, data};
}

/** Of each point, by its height in the texture: red, green, blue. */
function colorsOf(heights, {red, green, blue}) {
  const byHeight = Array.from({length: 256}, (_, height) => {
    const brightness = PIT_BRIGHTNESS + (PEAK_BRIGHTNESS - PIT_BRIGHTNESS) * height / 255;
    return shown({red, green, blue}).map((x) => Math.round(255 * Math.min(1, brightness * x)));
  });
  const colors = new Uint8Array(3 * heights.length);
  heights.forEach((height, i) => colors.set(byHeight[height], 3 * i));
  return vtkDataArray.newInstance({name: 'Colors', values: colors, numberOfComponents: 3});
}

/** One object: its data is made once its mesh is here, and anew once its textured surface is. */
class Shown {
  constructor(state, surface) {
    this.state = state;
    this.surface = surface;
    this.actor = null;
    this.dents = [];
    this.opening_rad = 0;
    this.refusal = badNumber(state);
  }

  /** Lowest and highest as drawn, of 0 to 255; null without a texture, or before it is here. */
  get heights() {
    const heights = this.mesh?.heights;
    return heights ? [heights.reduce((a, b) => Math.min(a, b)), heights.reduce((a, b) => Math.max(a, b))] : null;
  }

  /** `mesh`: of the scene, or the textured surface, which has the shape at rest. */
  make(mesh, moved) {
    this.mesh = mesh;
    const isTextured = Boolean(mesh.heights);
    this.rest = isTextured ? mesh.vertices : restShape(mesh, this.state.deformation, moved);
    this.data = vtkPolyData.newInstance();
    const cells = new Uint32Array(mesh.triangles.length / 3 * 4);
    for (let from = 0, to = 0; from < mesh.triangles.length; from += 3, to += 4) {
      cells[to] = 3;
      cells.set(mesh.triangles.subarray(from, from + 3), to + 1);
    }
    this.data.setPolys(vtkCellArray.newInstance({values: cells}));
    this.setPoints(this.rest);
    const mapper = vtkMapper.newInstance();
    mapper.setInputData(this.data);
    mapper.setScalarVisibility(isTextured);
    if (isTextured) this.data.getPointData().setScalars(colorsOf(mesh.heights, this.state.color || {}));
    this.actor = vtkActor.newInstance();
    this.actor.setMapper(mapper);
    const property = this.actor.getProperty();
    property.setColor(...shown(this.state.color || {}));
    property.setAmbient(0.25);
    property.setDiffuse(0.75);
    if (!this.state.shading && !isTextured) property.setInterpolationToFlat();
    this.place(this.pose || this.state.pose);
    const {dents} = this;
    this.dents = [];
    this.setDents(dents);
    const {opening_rad} = this;
    this.opening_rad = 0;
    this.setOpening(opening_rad);
  }

  /** Gives back what it took of the processor's and the graphics card's memory. */
  remove(renderer) {
    if (!this.actor) return;
    renderer.removeActor(this.actor);
    for (const part of [this.actor.getMapper(), this.actor, this.data]) part.delete();
    this.actor = null;
  }

  setPoints(points) {
    this.data.getPoints().setData(points, 3);
    const normals = vtkDataArray.newInstance({name: 'Normals', values: normalsOf(points, this.mesh.triangles), numberOfComponents: 3});
    this.data.getPointData().setNormals(normals);
    this.data.modified();
  }

  place(pose) {
    this.pose = pose;
    this.actor?.setUserMatrix(matrixOf(pose || {}));
  }

  /** Dents as of now; nothing is computed while there are none. */
  setDents(dents) {
    const softness = this.state.deformation?.softness;
    if (!this.actor || !softness || (dents.length === 0 && this.dents.length === 0)) return;
    this.dents = dents;
    const points = this.rest.slice();
    dent(points, dents, softness);
    this.setPoints(points);
  }

  /** How far the jaws of a tool are open. */
  setOpening(opening_rad) {
    const jaws = this.state.motion?.tool?.jaws;
    if (!jaws || opening_rad === this.opening_rad) return;
    this.opening_rad = opening_rad;
    if (this.actor) this.setPoints(openJaws(this.rest, jaws, opening_rad));
  }
}

export class Picture {
  constructor(container) {
    this.container = container;
    this.window = vtkRenderWindow.newInstance();
    this.renderer = vtkRenderer.newInstance({background: BACKGROUND});
    this.window.addRenderer(this.renderer);
    this.view = vtkOpenGLRenderWindow.newInstance();
    // The first to ask for the context says how it is.
    this.view.getCanvas().getContext('webgl2',
      {antialias: !isDrawnInSoftware(), depth: true, alpha: true, powerPreference: 'high-performance'});
    this.view.setContainer(container);
    this.window.addView(this.view);
    const interactor = vtkInteractor.newInstance();
    interactor.setInteractorStyle(vtkTrackball.newInstance());
    interactor.setView(this.view);
    interactor.initialize();
    interactor.bindEvents(container);
    this.objects = new Map();  // by id, as text
    this.assets = new Map();   // by hash
    this.hands = [0, 1].map(() => this.addHand());
    this.frames = [];          // when they were drawn
    this.isChanged = true;
    this.isFitted = false;
    this.limit_N = 0;          // of the device; 0: not known
    this.spacing_m = 0;        // of the floor's lines
    this.floor = this.addFloor();
    this.names = null;         // an element for the objects' names, or none
    this.scale = 1;            // of the picture's pixels to those of the screen
    container.addEventListener('pointerdown', () => { this.isFitted = true; });
    interactor.onAnimation(() => {
      this.count();
      this.placeNames();
    });
    new ResizeObserver(() => this.resize()).observe(container);
    this.resize();
    document.addEventListener('visibilitychange', () => { this.judged = undefined; });
    const draw = () => {
      requestAnimationFrame(draw);
      this.keepUp();
      if (!this.isChanged) return;
      this.isChanged = false;
      this.renderer.resetCameraClippingRange();
      this.window.render();
      this.placeNames();
      this.count();
    };
    draw();
  }

  count() {
    const now = performance.now();
    this.frames = this.frames.filter((at) => now - at < 2000);
    this.frames.push(now);
  }

  /** Frames a second, over the last two. */
  fps() {
    return this.frames.length / 2;
  }

  /** A machine that draws too slowly gets fewer pixels. A page that is hidden or covered, or where nothing changes, is not slow. */
  keepUp() {
    const now = performance.now();
    const hasPaused = now - this.turned > PAUSE_MS;
    this.turned = now;
    if (this.judged === undefined || hasPaused) {
      this.judged = now + SETTLED_MS;
      this.turns = 0;
    }
    ++this.turns;
    if (now < this.judged) return;
    const perSecond = 1000 * this.turns / (now - this.judged + SETTLED_MS);
    this.judged = undefined;
    if (perSecond >= LEAST_FPS || this.scale <= LEAST_SCALE) return;
    this.scale = Math.max(LEAST_SCALE, 0.75 * this.scale);
    this.resize();
  }

  resize() {
    const {clientWidth, clientHeight} = this.container;
    const pixels = this.scale * (window.devicePixelRatio || 1);
    this.view.setSize(
      Math.max(1, Math.floor(pixels * clientWidth)), Math.max(1, Math.floor(pixels * clientHeight)));
    if (!this.isFitted) this.fit();
    else this.renderer.getActiveCamera().dolly(this.fittingShare() / this.fitted);
    this.fitted = this.fittingShare();
    this.isChanged = true;
  }

  /** Of the height that the width of the picture has. */
  fittingShare() {
    return Math.min(1, this.container.clientWidth / Math.max(1, this.container.clientHeight));
  }

  addFloor() {
    const actor = vtkActor.newInstance();
    actor.setMapper(vtkMapper.newInstance());
    actor.getProperty().setColor(...FLOOR);
    actor.getProperty().setLighting(false);
    actor.setVisibility(false);
    this.renderer.addActor(actor);
    return actor;
  }

  /** Around all objects that are drawn; null: there are none. */
  bounds() {
    const boxes = [...this.objects.values()].filter(({actor}) => actor).map(({actor}) => actor.getBounds());
    if (boxes.length === 0) return null;
    return boxes[0].map((_, i) => Math[i % 2 ? 'max' : 'min'](...boxes.map((box) => box[i])));
  }

  placeFloor() {
    const bounds = this.bounds();
    this.floor.setVisibility(Boolean(bounds));
    if (!bounds || bounds.every((k, i) => k === this.floored?.[i])) return;
    this.floored = bounds;
    const {spacing, data} = gridBelow(bounds);
    this.spacing_m = spacing;
    this.floor.getMapper().setInputData(data);
  }

  /** Below their objects. */
  placeNames() {
    if (!this.names) return;
    const {clientWidth, clientHeight} = this.container;
    const drawn = [...this.objects.values()].filter(({actor}) => actor);
    while (this.names.childElementCount > drawn.length) this.names.lastChild.remove();
    while (this.names.childElementCount < drawn.length) this.names.append(document.createElement('span'));
    drawn.forEach(({state, actor}, i) => {
      const [west, east, south, north, bottom] = actor.getBounds(), label = this.names.children[i];
      const [x, y, depth] = this.renderer.worldToNormalizedDisplay((west + east) / 2, (south + north) / 2, bottom,
        clientWidth / Math.max(1, clientHeight));
      label.hidden = !(depth < 1);
      if (label.textContent !== state.name) label.textContent = state.name;
      label.style.left = `${x * clientWidth}px`;
      label.style.top = `${(1 - y) * clientHeight}px`;
    });
  }

  addHand() {
    const ball = vtkSphereSource.newInstance({radius: BALL_M, thetaResolution: 16, phiResolution: 16});
    const arrow = vtkArrowSource.newInstance({tipResolution: 12, shaftResolution: 12});
    const hand = {hip: actorOf(ball, HIP), ihip: actorOf(ball, IHIP), force: actorOf(arrow, FORCES[1])};
    for (const actor of Object.values(hand)) this.renderer.addActor(actor);
    return hand;
  }

  showScene(scene) {
    for (const [id, object] of this.objects) {
      if (scene.objects.get(id)?.state === object.state) continue;
      object.remove(this.renderer);
      this.objects.delete(id);
    }
    for (const [id, {state, surface}] of scene.objects) {
      if (!this.objects.has(id)) this.objects.set(id, new Shown(state, surface));
    }
    this.makeObjects();
  }

  addAsset(name, bytes) {
    this.assets.set(name, decodeAsset(bytes));
    this.makeObjects();
  }

  dropAsset(name) {
    this.assets.delete(name);
  }

  makeObjects() {
    for (const object of this.objects.values()) {
      if (object.refusal) continue;
      const residue = object.state.deformation?.residue?.asset;
      const mesh = this.assets.get(hex(object.state.mesh)), moved = residue?.length ? this.assets.get(hex(residue)) : null;
      const surface = this.assets.get(object.surface);
      if (object.actor ? object.mesh.heights || !surface : !surface && (!mesh || moved === undefined)) continue;
      object.remove(this.renderer);
      try {
        if (surface ? !surface.heights : !mesh.triangles || (moved && !moved.vertex)) throw new Error('an asset of another kind');
        object.make(surface || mesh, moved);
      } catch (error) {
        object.refusal = error.message;
        continue;
      }
      this.renderer.addActor(object.actor);
      if (!this.isFitted) this.fit();
    }
    this.placeFloor();
    this.isChanged = true;
  }

  /** All objects, seen from the front and above; until somebody turns the picture. */
  fit() {
    const camera = this.renderer.getActiveCamera();
    camera.setViewUp(0, 0, 1);
    camera.setFocalPoint(0, 0, 0);
    camera.setPosition(0, -1, 0.6);
    this.renderer.resetCamera(this.bounds() || undefined);
    camera.dolly(1.2 * this.fittingShare());  // it fits the height
    this.fitted = this.fittingShare();
    this.isChanged = true;
  }

  showSample(sample) {
    [sample, sample.second_hand].forEach((felt, i) => this.showHand(this.hands[i], felt));
    for (const body of bodiesOf(sample)) {
      const object = this.objects.get(String(body.object));
      // What is driven was so in the sample's scene: an edit since may have put it back.
      if (object && (object.state.motion || Number(sample.scene_revision) >= Number(object.state.revision)))
        object.place(body.pose);
    }
    const dents = dentsOf(sample);
    const {tool} = sample, opening_rad = tool?.grip?.opening_rad;
    for (const [id, object] of this.objects) {
      object.setDents(dents.filter((d) => String(d.object) === id));
      object.setOpening(String(tool?.object) === id && Number.isFinite(opening_rad) ? opening_rad : 0);
    }
    this.isChanged = true;
  }

  showHand({hip, ihip, force}, felt) {
    for (const actor of [hip, ihip, force]) actor.setVisibility(Boolean(felt));
    if (!felt) return;
    hip.setPosition(...xyz(felt.hip));
    ihip.setPosition(...xyz(felt.ihip));
    const written = xyz(felt.force?.written), length = Math.hypot(...written);
    force.setVisibility(length > LEAST_FORCE_N);
    force.getProperty().setColor(...forceColor(length / (this.limit_N || USUAL_FORCE_N)));
    if (length <= LEAST_FORCE_N) return;
    const [x, y, z] = written.map((k) => k / length), scale = METRES_PER_NEWTON * length;
    // The arrow points along x: two axes across it make it a turn.
    const across = Math.abs(z) < 0.9 ? [-y, x, 0] : [0, -z, y];
    const size = Math.hypot(...across), [bx, by, bz] = across.map((k) => k / size);
    const [cx, cy, cz] = [y * bz - z * by, z * bx - x * bz, x * by - y * bx];
    force.setUserMatrix([x, y, z, 0, bx, by, bz, 0, cx, cy, cz, 0, ...xyz(felt.ihip), 1].map((k, i) => i < 12 && i % 4 < 3 ? k * scale : k));
  }
}
