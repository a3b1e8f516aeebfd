// Displays colours: half floats of exposed radiance, clamped and sRGB-encoded like the PNG files.
import * as THREE from './three/build/three.module.js';

const encoding = `
vec3 encoded(vec3 linear) {
  vec3 c = clamp(linear, 0.0, 1.0);
  return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), c));
}`;

// Values that all objects share.
export const shared = { fade: { value: 1 } };

// Vertices hold the bits of half floats: the current colours, and the previous ones from which they fade.
export function surfaceMaterial(texture, isCutOut, hasOver) {
  return new THREE.ShaderMaterial({
    side: THREE.DoubleSide,
    defines: { ...(texture && { TEXTURED: 1 }), ...(isCutOut && { CUT_OUT: 1 }), ...(hasOver && { OVER: 1 }) },
    uniforms: { fade: shared.fade, image: { value: texture }, tint: { value: 0 } },
    vertexShader: `
      attribute vec3 under, underBefore;
      varying vec3 vUnder;
      #ifdef OVER
      attribute vec3 over;
      varying vec3 vOver;
      #endif
      #ifdef TEXTURED
      varying vec2 vUv;
      #endif
      uniform float fade;
      vec3 halves(vec3 bits) {
        vec2 rg = unpackHalf2x16(uint(bits.x) | (uint(bits.y) << 16u));
        return vec3(rg, unpackHalf2x16(uint(bits.z)).x);
      }
      void main() {
        vUnder = halves(under);
        if (fade < 1.0) vUnder = mix(halves(underBefore), vUnder, fade);
        #ifdef OVER
        vOver = halves(over);
        #endif
        #ifdef TEXTURED
        vUv = uv;
        #endif
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: `
      varying vec3 vUnder;
      #ifdef OVER
      varying vec3 vOver;
      #endif
      #ifdef TEXTURED
      varying vec2 vUv;
      uniform sampler2D image;
      #endif
      uniform float tint;
      ${encoding}
      vec3 decoded(vec3 c) {
        return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(vec3(0.04045), c));
      }
      void main() {
        vec3 colour = vUnder;
        #ifdef TEXTURED
        vec4 texel = texture2D(image, vUv);
        #ifdef CUT_OUT
        if (texel.a < 0.5) discard;
        #endif
        colour *= decoded(texel.rgb);
        #endif
        #ifdef OVER
        colour += vOver;
        #endif
        gl_FragColor = vec4(mix(encoded(colour), vec3(1.0, 0.72, 0.35), tint), 1.0);
      }`,
  });
}

// Draws environments behind everything: lat-long, +z in the middle, longitude decreasing to the right.
export function backgroundMaterial() {
  return new THREE.ShaderMaterial({
    depthTest: false,
    depthWrite: false,
    uniforms: {
      first: { value: null }, second: { value: null }, share: { value: 0 }, gain: { value: 1 },
      toWorld: { value: new THREE.Matrix3() }, toLight: { value: new THREE.Matrix3() },
      corner: { value: new THREE.Vector2() },
    },
    vertexShader: `
      uniform mat3 toWorld, toLight;
      uniform vec2 corner;
      varying vec3 along;
      void main() {
        along = toLight * (toWorld * vec3(position.xy * corner, -1.0));
        gl_Position = vec4(position.xy, 1.0, 1.0);
      }`,
    fragmentShader: `
      uniform sampler2D first, second;
      uniform float share, gain;
      varying vec3 along;
      ${encoding}
      void main() {
        vec3 d = normalize(along);
        vec2 at = vec2(0.5 - atan(d.x, d.z) / 6.28318530718, 0.5 - asin(clamp(d.y, -1.0, 1.0)) / 3.14159265359);
        vec3 colour = texture2D(first, at).rgb;
        if (share > 0.0) colour = mix(colour, texture2D(second, at).rgb, share);
        gl_FragColor = vec4(encoded(colour * gain), 1.0);
      }`,
  });
}
