import * as THREE from 'three';

const VERTEX = /* glsl */ `
  attribute float value;
  uniform float size, height;
  varying float v;
  void main() {
    v = value;
    vec4 view = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * (view + vec4(0.0, 0.0, size, 0.0)); // in front of the surface they lie on
    gl_PointSize = max(1.5, size * (1.0 + 1.4 * value) * projectionMatrix[1][1] * height / (2.0 * -view.z));
  }`;

const FRAGMENT = /* glsl */ `
  uniform vec3 base;
  uniform float opacity;
  varying float v;
  vec3 ramp(float t) {
    vec3 a = vec3(0.970, 0.790, 0.290), b = vec3(0.940, 0.385, 0.175), c = vec3(0.770, 0.070, 0.245);
    return t < 0.55 ? mix(a, b, t / 0.55) : mix(b, c, (t - 0.55) / 0.45);
  }
  void main() {
    vec2 d = gl_PointCoord - 0.5;
    if (dot(d, d) > 0.25) discard;
    float on = smoothstep(0.04, 0.30, v);
    gl_FragColor = vec4(mix(base, ramp(clamp((v - 0.1) / 0.9, 0.0, 1.0)), on), mix(opacity, 0.95, on));
  }`;

/** Round points, sized in metres, each painted by a value in [0, 1]. */
export class PointSet {
  readonly object: THREE.Points;
  readonly values: Float32Array;
  private readonly attribute: THREE.BufferAttribute;
  private readonly material: THREE.ShaderMaterial;

  constructor(positions: Float32Array, size: number, opacity = 1) {
    this.values = new Float32Array(positions.length / 3);
    this.attribute = new THREE.BufferAttribute(this.values, 1).setUsage(THREE.DynamicDrawUsage);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('value', this.attribute);
    this.material = new THREE.ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      uniforms: {
        size: { value: size },
        height: { value: 800 },
        base: { value: new THREE.Vector3(0.62, 0.64, 0.67) },
        opacity: { value: opacity },
      },
    });
    this.object = new THREE.Points(geometry, this.material);
    this.object.frustumCulled = false;
  }

  /** @param height of the drawing buffer in pixels */
  setHeight(height: number) {
    this.material.uniforms.height.value = height;
  }

  changed() {
    this.attribute.needsUpdate = true;
  }
}
