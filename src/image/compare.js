// The script of a page that compares two pictures; `data` holds them (see html_page.cc).
"use strict";
const $ = id => document.getElementById(id);
const { width, height } = data;
const pictures = {}, shown = {};
let region = [0, 0, width, height]; // x0, y0, x1, y1; x1 and y1 are one past the last

async function unpack(text) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const view = new DataView(await new Response(stream).arrayBuffer());
  const table = new Float32Array(65536);
  for (let h = 0; h < 65536; ++h) {
    const exponent = h >> 10 & 31, fraction = h & 1023;
    const size = exponent === 31 ? (fraction ? NaN : Infinity)
      : exponent ? 2 ** (exponent - 25) * (1024 + fraction) : 2 ** -24 * fraction;
    table[h] = h >> 15 ? -size : size;
  }
  const out = new Float32Array(view.byteLength / 2);
  for (let i = 0; i < out.length; ++i) out[i] = table[view.getUint16(2 * i, true)];
  return out;
}

const pixel = (name, i) => [0, 1, 2].map(c => pictures[name][c * width * height + i]);
const luminance = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
const encode = x => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

function toned(rgb) {
  const gain = 2 ** +$("exposure").value, filmic = $("tone").value === "filmic";
  return rgb.map(v => {
    const x = v > 0 ? Math.min(v * gain, 1e6) : 0;
    return encode(clamp(filmic ? x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14) : x, 0, 1));
  });
}

// Signed relative error of the luminance, as glowworm compare -o draws it.
function difference(i) {
  const is = luminance(pixel("image", i)), should = luminance(pixel("reference", i));
  if (!isFinite(is) || !isFinite(should)) return [0, 255, 0];
  const error = clamp((is - should) / (Math.abs(should) + 0.1) / $("full").value, -1, 1), t = Math.abs(error);
  const full = error > 0 ? [1, 0, 0] : [0, 0, 1];
  return full.map(f => encode(0.2 * (1 - t) + f * t));
}

// Display colours of all pixels (RGBA) of "image", "reference" or "difference", for the present controls.
function colors(name) {
  const key = [$("exposure").value, $("tone").value, $("full").value].join();
  if (shown[name]?.key === key) return shown[name].out;
  const out = new Uint8ClampedArray(4 * width * height);
  for (let i = 0; i < width * height; ++i) {
    const [r, g, b] = name === "difference" ? difference(i) : toned(pixel(name, i));
    out[4 * i] = r; out[4 * i + 1] = g; out[4 * i + 2] = b; out[4 * i + 3] = 255;
  }
  shown[name] = { key, out };
  return out;
}

// Draws a region; left of the column `split` from `left`, else from `right`.
function draw(canvas, left, right, split, [x0, y0, x1, y1]) {
  canvas.width = x1 - x0;
  canvas.height = y1 - y0;
  const context = canvas.getContext("2d"), out = context.createImageData(canvas.width, canvas.height);
  const middle = clamp(split, x0, x1), row = 4 * canvas.width;
  for (let y = y0, o = 0; y < y1; ++y, o += row) {
    const at = x => 4 * (y * width + x);
    out.data.set(left.subarray(at(x0), at(middle)), o);
    out.data.set(right.subarray(at(middle), at(x1)), o + 4 * (middle - x0));
  }
  context.putImageData(out, 0, 0);
  return context;
}

function drawMain() {
  const view = $("view").value, split = Math.round($("split").value * width);
  $("stops").textContent = (+$("exposure").value).toFixed(1) + " stops";
  const slides = view === "slider";
  const left = colors(slides ? "image" : view), right = slides ? colors("reference") : left;
  const context = draw($("main"), left, right, split, [0, 0, width, height]);
  if (slides) {
    context.fillStyle = "#fff";
    context.fillRect(split - 0.5, 0, 1, height);
  }
  if (region[2] - region[0] < width || region[3] - region[1] < height) {
    context.strokeStyle = "#ff0";
    context.strokeRect(region[0] - 0.5, region[1] - 0.5, region[2] - region[0] + 1, region[3] - region[1] + 1);
  }
}

function drawZoom() {
  for (const name of ["image", "reference", "difference"]) {
    draw($("zoom-" + name), colors(name), colors(name), 0, region);
    $("zoom-" + name).style.width = "400px";
  }
}

function* pixels() {
  for (let y = region[1]; y < region[3]; ++y) for (let x = region[0]; x < region[2]; ++x) yield y * width + x;
}

function measure() {
  let count = 0, bad = 0, mse = 0, relative = 0, sumIs = 0, sumShould = 0;
  for (const i of pixels()) {
    const is = pixel("image", i), should = pixel("reference", i);
    if (![...is, ...should].every(isFinite)) { ++bad; continue; }
    for (let c = 0; c < 3; ++c) {
      const square = (is[c] - should[c]) ** 2;
      mse += square / 3;
      relative += square / (should[c] ** 2 + 0.01) / 3;
    }
    ++count; sumIs += luminance(is); sumShould += luminance(should);
  }
  const n = x => Number(x.toPrecision(5)).toString();
  const rows = [["pixels", `${region[0]},${region[1]} to ${region[2]},${region[3]}`], ["MSE", n(mse / count)],
    ["relMSE", n(relative / count)], ["relRMSE", n(Math.sqrt(relative / count))],
    ["mean luminance", n(sumIs / count)], ["reference's", n(sumShould / count)],
    ["mean ratio", n(sumIs / sumShould)], ["not finite", bad]];
  $("region").replaceChildren(...rows.map(row => {
    const line = document.createElement("tr");
    for (const text of row) line.insertCell().textContent = text;
    return line;
  }));
}

function drawHistogram() {
  const canvas = $("histogram"), context = canvas.getContext("2d"), low = -14, high = 10, bins = 120;
  const counts = { image: new Float64Array(bins), reference: new Float64Array(bins) };
  for (const i of pixels())
    for (const name in counts) {
      const stop = Math.log2(luminance(pixel(name, i)));
      if (stop >= low && stop < high) ++counts[name][Math.floor((stop - low) / (high - low) * bins)];
    }
  const w = canvas.width, h = canvas.height - 16, top = Math.max(1, ...counts.image, ...counts.reference);
  context.clearRect(0, 0, w, canvas.height);
  context.fillStyle = "#999";
  counts.image.forEach((n, b) => context.fillRect(b * w / bins, h - n / top * h, w / bins, n / top * h));
  context.strokeStyle = "#c00";
  context.beginPath();
  counts.reference.forEach((n, b) => context.lineTo((b + 0.5) * w / bins, h - n / top * h));
  context.stroke();
  context.fillStyle = "#222";
  for (let stop = low + 2; stop < high; stop += 4)
    context.fillText(`${stop > 0 ? "+" : ""}${stop}`, (stop - low) / (high - low) * w - 6, h + 12);
}

function drawAll() {
  drawMain();
  drawZoom();
}

function place(event) {
  const box = $("main").getBoundingClientRect();
  return [clamp(Math.floor((event.clientX - box.left) / box.width * width), 0, width - 1),
    clamp(Math.floor((event.clientY - box.top) / box.height * height), 0, height - 1)];
}

function choose(a, b) {
  const clicked = Math.abs(a[0] - b[0]) < 2 && Math.abs(a[1] - b[1]) < 2;
  region = clicked ? [0, 0, width, height]
    : [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[0], b[0]) + 1, Math.max(a[1], b[1]) + 1];
  drawAll();
  measure();
  drawHistogram();
}

async function start() {
  pictures.image = await unpack(data.image);
  pictures.reference = await unpack(data.reference);
  $("exposure").value = data.exposure;
  let from = null;
  const main = $("main");
  main.onpointerdown = event => { from = place(event); event.preventDefault(); };
  main.onpointerup = event => { if (from) choose(from, place(event)); from = null; };
  main.onpointermove = event => {
    const [x, y] = place(event), i = y * width + x, text = name => pixel(name, i).map(v => v.toPrecision(4)).join(" ");
    $("pixel").textContent = `${x}, ${y}: picture ${text("image")}, reference ${text("reference")}`;
  };
  for (const id of ["view", "split"]) $(id).oninput = drawMain;
  for (const id of ["exposure", "tone", "full"]) $(id).oninput = drawAll;
  choose([0, 0], [0, 0]);
  document.body.dataset.ready = "yes";
}

start();
