import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

const GRID_VERTEX = /* glsl */ `
  varying vec3 at;
  void main() {
    at = (modelMatrix * vec4(position, 1.0)).xyz;
    gl_Position = projectionMatrix * viewMatrix * vec4(at, 1.0);
  }`;
const GRID_FRAGMENT = /* glsl */ `
  varying vec3 at;
  uniform vec3 ink, middle;
  uniform float reach;
  float lines(vec2 p) {
    vec2 w = fwidth(p);
    vec2 d = abs(fract(p - 0.5) - 0.5) / w;
    return (1.0 - min(min(d.x, d.y), 1.0)) * clamp(1.0 - 2.0 * max(w.x, w.y), 0.0, 1.0);
  }
  void main() {
    float fade = 1.0 - smoothstep(0.35, 1.0, length(at.xz - middle.xz) / reach);
    gl_FragColor = vec4(ink, fade * max(0.10 * lines(at.xz * 2.0), 0.22 * lines(at.xz)));
  }`;

const SIDES = [0.75, -0.75, 1.5, -1.5, 2.4, -2.4, Math.PI]; // radians off the front, the preferred first

export type Theme = 'light' | 'dark';

/** Renderer, camera, light and ground. */
export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(36, 1, 0.05, 200);
  readonly controls: OrbitControls;
  readonly renderer: THREE.WebGLRenderer;
  private readonly sun = new THREE.DirectionalLight(0xfff4e6, 2.5);
  private readonly sky = new THREE.HemisphereLight(0xfffaf4, 0xb9aa98, 2.0);
  private readonly fill = new THREE.DirectionalLight(0xdfe9ff, 0.55);
  private readonly grid: THREE.Mesh<THREE.PlaneGeometry, THREE.ShaderMaterial>;
  private readonly shade: THREE.Mesh<THREE.PlaneGeometry, THREE.ShadowMaterial>;
  private readonly move = new THREE.Vector3();

  constructor(canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.renderer.toneMappingExposure = 0.95;
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.maxPolarAngle = Math.PI * 0.52;
    this.controls.minDistance = 0.6;
    this.controls.maxDistance = 40;
    this.controls.zoomSpeed = 0.8;

    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.radius = 3.5;
    this.sun.shadow.bias = -0.0006;
    this.sun.shadow.normalBias = 0.03;
    const frustum = this.sun.shadow.camera;
    frustum.left = frustum.bottom = -4.5;
    frustum.right = frustum.top = 4.5;
    frustum.near = 0.5;
    frustum.far = 20;
    this.scene.add(this.sun, this.sun.target, this.sky, this.fill, this.fill.target);

    this.grid = new THREE.Mesh(
      new THREE.PlaneGeometry(1, 1).rotateX(-Math.PI / 2),
      new THREE.ShaderMaterial({
        vertexShader: GRID_VERTEX, fragmentShader: GRID_FRAGMENT, transparent: true, depthWrite: false,
        uniforms: { ink: { value: new THREE.Color() }, middle: { value: new THREE.Vector3() }, reach: { value: 8 } },
      }));
    this.shade = new THREE.Mesh(new THREE.PlaneGeometry(1, 1).rotateX(-Math.PI / 2), new THREE.ShadowMaterial({ opacity: 0.22, depthWrite: false }));
    this.shade.receiveShadow = true;
    this.scene.add(this.grid, this.shade);
  }

  /** Empties the scene but for light and ground, and lets go of what the graphics card holds. */
  clear() {
    const kept = [this.sun, this.sun.target, this.sky, this.fill, this.fill.target, this.grid, this.shade];
    for (const object of [...this.scene.children]) {
      if (kept.includes(object as never)) continue;
      this.scene.remove(object);
      object.traverse((part) => {
        const { geometry, material } = part as THREE.Mesh;
        geometry?.dispose();
        for (const one of [material].flat()) one?.dispose();
      });
    }
    this.setLens(36);
    this.controls.maxDistance = 40;
  }

  setTheme(theme: Theme) {
    const dark = theme === 'dark';
    this.scene.background = new THREE.Color(dark ? 0x16181c : 0xf1efec);
    this.grid.material.uniforms.ink.value.set(dark ? 0xffffff : 0x3a352f);
    this.shade.material.opacity = dark ? 0.45 : 0.2;
    this.sky.intensity = dark ? 1.35 : 2.0;
    this.sky.groundColor.set(dark ? 0x6a645d : 0xb9aa98);
    this.sun.intensity = dark ? 2.2 : 2.5;
  }

  /** A grid `reach` metres about the middle, where no floor is given. */
  setGround(y: number, middle: THREE.Vector3, reach: number, visible: boolean) {
    for (const plane of [this.grid, this.shade]) {
      plane.position.set(middle.x, y, middle.z);
      plane.scale.setScalar(reach * 2);
      plane.visible = visible;
    }
    this.grid.material.uniforms.middle.value.copy(middle);
    this.grid.material.uniforms.reach.value = reach;
  }

  /**
   * Looks at `target` from a three-quarter view, near enough that a body of `radius` metres fills it: from the side of
   * `heading` from which the least is hidden.
   */
  frame(target: THREE.Vector3, radius: number, heading: number, hidden: (from: THREE.Vector3) => number = () => 0) {
    const narrow = Math.min(1, this.camera.aspect);
    const distance = radius / Math.sin((this.camera.fov * Math.PI) / 360) / Math.max(narrow, 0.5);
    this.controls.target.copy(target);
    let least = Infinity;
    for (const side of SIDES) {
      const azimuth = heading + side;
      this.move.set(0.9 * Math.sin(azimuth), 0.36, 0.9 * Math.cos(azimuth)).multiplyScalar(distance).add(target);
      const here = hidden(this.move);
      if (here < least) this.camera.position.copy(this.move);
      least = Math.min(least, here);
      if (least === 0) break;
    }
    this.controls.update();
  }

  /** Looks at `target` from `distance` metres, at angles (radians) about +Y from +Z and above the ground. */
  look(target: THREE.Vector3, distance: number, azimuth: number, elevation: number) {
    const level = distance * Math.cos(elevation);
    this.controls.target.copy(target);
    this.camera.position.set(
      target.x + level * Math.sin(azimuth), target.y + distance * Math.sin(elevation), target.z + level * Math.cos(azimuth));
    this.controls.update();
  }

  /** Orbits what the camera looks at by angles (radians), and brings it nearer by a factor. */
  orbit(across: number, up: number, factor: number) {
    const { camera, controls } = this;
    const place = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    place.theta += across;
    place.phi = Math.min(controls.maxPolarAngle, Math.max(0.05, place.phi + up));
    place.radius = Math.min(controls.maxDistance, Math.max(controls.minDistance, place.radius * factor));
    camera.position.setFromSpherical(place).add(controls.target);
    controls.update();
  }

  /** Vertical field of view in degrees. */
  setLens(fov: number) {
    this.camera.fov = fov;
    this.camera.updateProjectionMatrix();
  }

  showGround(on: boolean) {
    this.grid.visible = this.shade.visible = on;
  }

  /** Moves the camera along so that it keeps looking at `target`; by a `fraction` of the distance. */
  follow(target: THREE.Vector3, fraction: number) {
    this.move.copy(target).sub(this.controls.target).multiplyScalar(fraction);
    this.controls.target.add(this.move);
    this.camera.position.add(this.move);
  }

  lightAround(at: THREE.Vector3) {
    this.sun.target.position.copy(at);
    this.sun.position.set(at.x + 3.2, at.y + 7.5, at.z + 3.6);
    this.fill.target.position.copy(at);
    this.fill.position.set(at.x - 4, at.y + 3, at.z - 2);
  }

  /** Fits the drawing buffer to the window; returns its height in pixels. */
  resize(width: number, height: number, right: number, bottom: number): number {
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    // The middle of what the controls leave free, not of the window.
    this.camera.setViewOffset(width, height, right / 2, bottom / 2, width, height);
    this.camera.updateProjectionMatrix();
    return this.renderer.domElement.height;
  }

  render() {
    this.renderer.render(this.scene, this.camera);
  }
}
