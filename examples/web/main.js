// Shows a GLB file of `glowworm bake`: orbit by mouse, compare with plain light, see texels and the atlas.
// Query: ?scene=NAME  &view=WIDTHxHEIGHT (one picture by the file's first camera, without the bar)  &texels  &atlas  &split=0..1  &picture=NAME (sends it to serve.js)
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { sendPicture } from "./picture.js";

const query = new URLSearchParams(location.search);
const element = (id) => document.getElementById(id);
const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.toneMapping = THREE.NoToneMapping;
document.body.appendChild(renderer.domElement);
document.body.classList.toggle("plain", query.has("view"));

const scene = new THREE.Scene();
const sky = new THREE.HemisphereLight(0xffffff, 0x666666, 2);
let camera = new THREE.PerspectiveCamera(50, 1, 0.01, 1000);
const controls = new OrbitControls(camera, renderer.domElement);
const state = { root: null, baked: [], plain: [], picture: null };

/** Gray material that the other lights of the page shade, in place of baked light. */
function plainOf(material) {
  return new THREE.MeshLambertMaterial({ color: 0xaaaaaa, side: material.side });
}

function textureOf(material) {
  return material.lightMap ?? material.emissiveMap ?? (material.isMeshBasicMaterial ? material.map : null);
}

/** Irradiance by the file's extension MOZ_lightmap; three.js has no loader for it. */
async function addLightmaps(gltf) {
  const work = [];
  gltf.scene.traverse((object) => {
    const data = object.material?.userData.gltfExtensions?.MOZ_lightmap;
    if (!data) return;
    work.push(gltf.parser.getDependency("texture", data.index).then((shared) => {
      // Others may read the parser's texture by other coordinates.
      const texture = shared.clone();
      texture.channel = data.texCoord;
      texture.colorSpace = THREE.SRGBColorSpace;
      object.material.lightMap = texture;
      object.material.lightMapIntensity = data.intensity;
      object.material.needsUpdate = true;
    }));
  });
  await Promise.all(work);
}

function setTexels(visible) {
  for (const { material } of state.baked) {
    const texture = textureOf(material);
    if (!texture) continue;
    texture.magFilter = visible ? THREE.NearestFilter : THREE.LinearFilter;
    texture.needsUpdate = true;
  }
}

function setAtlas(visible) {
  state.picture?.removeFromParent();
  state.picture = null;
  const texture = state.baked.map(({ material }) => textureOf(material)).find((t) => t);
  if (!visible || !texture) return;
  const flat = texture.clone();
  flat.channel = 0;
  const geometry = new THREE.PlaneGeometry(2, 2);
  // Rows of glTF's textures run downwards.
  const uv = geometry.attributes.uv;
  for (let i = 0; i < uv.count; ++i) uv.setY(i, 1 - uv.getY(i));
  state.picture = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ map: flat, depthTest: false }));
}

function frame(box) {
  const center = box.getCenter(new THREE.Vector3());
  const size = box.getSize(new THREE.Vector3()).length();
  camera.near = size / 1000;
  camera.far = size * 10;
  camera.position.copy(center).add(new THREE.Vector3(0, 0.2, 1).multiplyScalar(size));
  controls.target.copy(center);
}

/** Puts the page's camera where the file's first one is; controls turn around a point ahead of it. */
function follow(source, box) {
  source.updateWorldMatrix(true, false);
  camera.fov = THREE.MathUtils.radToDeg(2 * Math.atan(Math.tan(THREE.MathUtils.degToRad(source.fov) / 2)));
  source.getWorldPosition(camera.position);
  const ahead = source.getWorldDirection(new THREE.Vector3());
  const distance = Math.max(box.getCenter(new THREE.Vector3()).sub(camera.position).dot(ahead), camera.near * 10);
  camera.up.setFromMatrixColumn(source.matrixWorld, 1);
  controls.target.copy(camera.position).addScaledVector(ahead, distance);
}

async function load(name) {
  element("state").textContent = "loading";
  const gltf = await new GLTFLoader().loadAsync(`scenes/${name}.glb`);
  await addLightmaps(gltf);
  state.root?.removeFromParent();
  state.root = gltf.scene;
  state.baked = [];
  gltf.scene.traverse((mesh) => {
    if (mesh.isMesh) state.baked.push({ mesh, material: mesh.material, plain: plainOf(mesh.material) });
  });
  scene.add(gltf.scene, sky);
  const box = new THREE.Box3().setFromObject(gltf.scene);
  frame(box);
  const eye = gltf.cameras.find((c) => c.isPerspectiveCamera);
  if (eye) follow(eye, box);
  controls.update();
  setTexels(element("texels").checked);
  setAtlas(element("atlas").checked);
  element("state").textContent = "";
}

/** Draws what is left of `split` in plain light, and the rest baked. */
function draw() {
  const [width, height] = query.get("view")?.split("x").map(Number) ?? [innerWidth, innerHeight];
  renderer.setSize(width, height);
  camera.aspect = width / height;
  camera.updateProjectionMatrix();
  renderer.setScissorTest(true);
  const split = Number(element("split").value);
  for (const isPlain of [true, false]) {
    const from = isPlain ? 0 : Math.round(split * width), to = isPlain ? Math.round(split * width) : width;
    if (from >= to) continue;
    for (const entry of state.baked) entry.mesh.material = isPlain ? entry.plain : entry.material;
    sky.visible = isPlain;
    renderer.setScissor(from, 0, to - from, height);
    renderer.render(scene, camera);
  }
  if (state.picture) {
    const side = Math.min(width, height);
    renderer.setScissor(0, 0, width, height);
    renderer.setViewport(0, 0, side, side);
    renderer.render(state.picture, new THREE.OrthographicCamera(-1, 1, 1, -1, -1, 1));
    renderer.setViewport(0, 0, width, height);
  }
}

async function start() {
  const names = await (await fetch("scenes/list.json")).json();
  for (const name of names) element("scene").add(new Option(name, name));
  const wanted = query.get("scene") ?? names[0];
  if (!names.includes(wanted)) throw new Error(`there is no scene '${wanted}': there are ${names.join(", ")}`);
  element("scene").value = wanted;
  element("texels").checked = query.has("texels");
  element("atlas").checked = query.has("atlas");
  element("split").value = query.get("split") ?? 0;
  element("scene").addEventListener("change", () => load(element("scene").value).catch(say));
  element("texels").addEventListener("change", (event) => setTexels(event.target.checked));
  element("atlas").addEventListener("change", (event) => setAtlas(event.target.checked));
  await load(element("scene").value);
  if (query.has("view")) {
    draw();
    await sendPicture(renderer.domElement);
    return;
  }
  renderer.setAnimationLoop(() => {
    controls.update();
    draw();
  });
}

/** Shows an error in the bar, which pictures do without. */
function say(error) {
  document.body.classList.remove("plain");
  element("state").textContent = String(error);
}

start().catch(say);
