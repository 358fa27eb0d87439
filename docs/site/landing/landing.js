"use strict";
/* The landing page: a wipe between two pictures, and a slider that warps a face in the page.

   KOGAO_FACES (faces.js) holds for each face a picture and, for each stored Amount, the control
   points of its displacement: cubic B-splines on nodes `spacing` px apart, in 1/`unit` px. The
   sampling is OpenCV's bicubic one (a = -0.75, positions rounded to 1/32 px), as in the program. */

function splineWeights(length, spacing) {
  // The four cubic B-spline weights of each pixel column, and the first node of the four.
  const weights = new Float64Array(4 * length), first = new Int32Array(length);
  for (let x = 0; x < length; x++) {
    const node = Math.floor(x / spacing), t = x / spacing - node, u = 1 - t;
    first[x] = node;
    weights[4 * x] = u * u * u / 6;
    weights[4 * x + 1] = (3 * t * t * t - 6 * t * t + 4) / 6;
    weights[4 * x + 2] = (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6;
    weights[4 * x + 3] = t * t * t / 6;
  }
  return { weights, first };
}

function controlPoints(face, amount) {
  // Control points at an Amount: linear between the two stored Amounts next to the value.
  const doses = face.amounts, count = face.columns * face.rows * 2;
  const phi = new Float64Array(count);
  if (amount <= 0) return phi;
  let k = 0;
  while (k < doses.length - 1 && doses[k] < amount) k++;
  const low = k ? doses[k - 1] : 0, share = (amount - low) / (doses[k] - low);
  for (let n = 0; n < count; n++) {
    const before = k ? face.fields[k - 1][n] : 0;
    phi[n] = (before + share * (face.fields[k][n] - before)) / face.unit;
  }
  return phi;
}

const STEPS = 32;
const CUBIC = (() => {
  // OpenCV's bicubic weights for 32 fractions of a pixel.
  const a = -0.75, table = new Float64Array(4 * STEPS);
  for (let k = 0; k < STEPS; k++) {
    const x = k / STEPS, y = 1 - x;
    const w0 = ((a * (x + 1) - 5 * a) * (x + 1) + 8 * a) * (x + 1) - 4 * a;
    const w1 = ((a + 2) * x - (a + 3)) * x * x + 1;
    const w2 = ((a + 2) * y - (a + 3)) * y * y + 1;
    table.set([w0, w1, w2, 1 - w0 - w1 - w2], 4 * k);
  }
  return table;
})();

function warp(face, source, amount, target) {
  // Warp RGBA `source` (width x height x 4 bytes) into `target` at an Amount in percent.
  const { width, height, columns, rows, spacing } = face;
  const phi = controlPoints(face, amount), plane = columns * rows;
  const across = splineWeights(width, spacing), down = splineWeights(height, spacing);
  const line = [new Float64Array(columns), new Float64Array(columns)];
  target.set(source);
  for (let y = 0; y < height; y++) {
    const row = down.first[y];
    for (let axis = 0; axis < 2; axis++)
      for (let i = 0; i < columns; i++) {
        let sum = 0;
        for (let l = 0; l < 4; l++)
          sum += down.weights[4 * y + l] * phi[axis * plane + (row + l) * columns + i];
        line[axis][i] = sum;
      }
    for (let x = 0; x < width; x++) {
      const i = across.first[x];
      let dx = 0, dy = 0;
      for (let k = 0; k < 4; k++) {
        const weight = across.weights[4 * x + k];
        dx += weight * line[0][i + k];
        dy += weight * line[1][i + k];
      }
      const px = Math.round((x + dx) * STEPS), py = Math.round((y + dy) * STEPS);
      if (px === x * STEPS && py === y * STEPS) continue;
      const left = Math.floor(px / STEPS), top = Math.floor(py / STEPS);
      const fx = 4 * (px - left * STEPS), fy = 4 * (py - top * STEPS);
      let red = 0, green = 0, blue = 0;
      for (let l = 0; l < 4; l++) {
        const sy = Math.min(height - 1, Math.max(0, top + l - 1)) * width;
        for (let k = 0; k < 4; k++) {
          const sx = Math.min(width - 1, Math.max(0, left + k - 1));
          const weight = CUBIC[fy + l] * CUBIC[fx + k], at = 4 * (sy + sx);
          red += weight * source[at];
          green += weight * source[at + 1];
          blue += weight * source[at + 2];
        }
      }
      const at = 4 * (y * width + x);
      target[at] = red;  // a clamped array rounds and clips
      target[at + 1] = green;
      target[at + 2] = blue;
    }
  }
}

function decodeField(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Int16Array(bytes.buffer);
}

function startSlider(root) {
  const canvas = root.querySelector("canvas"), slider = root.querySelector("input");
  const value = root.querySelector("output"), choices = root.querySelector(".choices");
  const context = canvas.getContext("2d", { willReadFrequently: true });
  let face = null, source = null, shown = null, waiting = false;

  function draw() {
    waiting = false;
    if (!source) return;
    value.textContent = `${Number(slider.value)} %`;
    warp(face, source.data, Number(slider.value), shown.data);
    context.putImageData(shown, 0, 0);
    canvas.dataset.shown = `${face.name} ${Number(slider.value)}`;  // for tests
  }
  function request() {
    if (!waiting) requestAnimationFrame(draw);
    waiting = true;
  }
  function choose(next, button) {
    for (const other of choices.children) other.setAttribute("aria-pressed", other === button);
    const image = new Image();
    image.onload = () => {
      face = next;
      canvas.width = face.width;
      canvas.height = face.height;
      canvas.setAttribute("aria-label", face.name);
      context.drawImage(image, 0, 0);
      source = context.getImageData(0, 0, face.width, face.height);
      shown = context.createImageData(face.width, face.height);
      draw();
    };
    image.src = next.picture;
  }
  for (const each of window.KOGAO_FACES) {
    each.fields = each.fields.map((text) => (typeof text === "string" ? decodeField(text) : text));
    const button = document.createElement("button"), small = document.createElement("img");
    small.src = each.picture;
    small.alt = each.name;
    button.type = "button";
    button.append(small);
    button.addEventListener("click", () => choose(each, button));
    choices.append(button);
  }
  slider.addEventListener("input", request);
  choose(window.KOGAO_FACES[0], choices.firstElementChild);
}

function startWipe(root) {
  const slider = root.querySelector("input");
  const show = () => root.style.setProperty("--cut", `${slider.value}%`);
  slider.addEventListener("input", show);
  show();
}

if (typeof document !== "undefined") {
  document.querySelectorAll(".wipe").forEach(startWipe);
  document.querySelectorAll(".try").forEach(startSlider);
} else {
  module.exports = { warp, decodeField };
}
