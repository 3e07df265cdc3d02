// Elements of a page, numbers with their units, ticks and colours.

export const DARK = matchMedia("(prefers-color-scheme: dark)");

export function element(tag, parent, text = "", name = "") {
  const node = document.createElement(tag);
  if (text) node.textContent = text;
  if (name) node.className = name;
  if (parent) parent.append(node);
  return node;
}

// As `UNITS` of `base/numbers.py`.
const UNITS = {
  "m": [[1, "m"], [1e-3, "mm"], [1e-6, "µm"], [1e-9, "nm"]],
  "m/s": [[1, "m/s"], [1e-3, "mm/s"], [1e-6, "µm/s"], [1e-9, "nm/s"]],
  "Pa": [[1e9, "GPa"], [1e6, "MPa"], [1e3, "kPa"], [1, "Pa"]],
  "N/m": [[1e9, "GN/m"], [1e6, "MN/m"], [1e3, "kN/m"], [1, "N/m"]],
  "J/m": [[1e9, "GJ/m"], [1e6, "MJ/m"], [1e3, "kJ/m"], [1, "J/m"]],
  "°": [[0.01, "°"], [180e-6 / Math.PI, "µrad"]],
};

/** Size and name of the unit in which a value reads well. */
export function inUnit(largest, unit) {
  const steps = UNITS[unit] || [];
  for (const step of steps) {
    if (Math.abs(largest) >= step[0]) return step[1] === unit ? [1, unit] : step;
  }
  return largest === 0 || !steps.length ? [1, unit] : steps[steps.length - 1];
}

/** A number in so many digits, as `base/numbers.py` writes it, with a true minus. */
export function short(value, digits = 4) {
  if (!isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e-3 && size < 1e6
    ? String(+value.toFixed(Math.max(0, digits - 1 - Math.floor(Math.log10(size)))))
    : value.toExponential(digits - 1).replace(/\.?0*e\+?/, "e");
  return text.replaceAll("-", "−");
}

export function withUnit(value, unit) {
  const [scale, name] = inUnit(value, unit);
  return `${short(value / scale)} ${name}`;
}

/** Round numbers between two: about so many, and three at least. */
export function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count);
  if (!(raw > 0) || !isFinite(raw)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const between = (s) => Math.floor(high / s + 1e-9) - Math.ceil(low / s - 1e-9) + 1;
  const step = [10, 5, 2, 1, 0.5, 0.2].map((m) => m * power)
    .find((s) => between(s) >= Math.max(3, 0.6 * count)) || 0.1 * power;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) found.push(k * step);
  return found;
}

/** The largest 1, 2 or 5 times a power of ten up to a value. */
export function roundBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [5, 2, 1].find((m) => m * power <= value * (1 + 1e-9));
}

/** Index of the last of ascending times that is not after a time, or 0. */
export function lastBefore(times, time) {
  let low = 0, high = times.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  return low;
}

export function variable(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

export function rgb(text) {
  const value = parseInt(text.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

export function mapped(stops, share, out) {
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const i = Math.min(Math.floor(at), stops.length - 2), t = at - i;
  for (let k = 0; k < 3; k++) out[k] = stops[i][k] + t * (stops[i + 1][k] - stops[i][k]);
  return out;
}

export function lineColor(i) {
  return variable(`--line${1 + i % 8}`);
}

const SHARE = 0.01;  // of the area: what the usual part of a scale may leave beyond it
const FAR = 1.5;     // times the usual part: a largest value that is nearer needs no part of its own
const USUAL = 0.7;   // of the colours of one sign, that the usual part has

/** Limits of a scale of values with weights, as `limits` of `quantities.py`. */
export function limits(values, weights, signed) {
  const order = [...values.keys()].filter((i) => isFinite(values[i]));
  if (!order.length) return {low: 0, high: 0, usual: 0};
  order.sort((a, b) => Math.abs(values[b]) - Math.abs(values[a]));
  const all = order.reduce((sum, i) => sum + weights[i], 0);
  let beyond = 0, k = 0;
  while (k < order.length - 1 && (beyond += weights[order[k]]) <= SHARE * all) k++;
  const usual = Math.abs(values[order[k]]), most = Math.abs(values[order[0]]);
  const low = signed ? -most : order.reduce((least, i) => Math.min(least, values[i]), 0);
  const high = signed ? most : order.reduce((least, i) => Math.max(least, values[i]), 0);
  return {low, high, usual: most > FAR * usual && usual > 0 ? usual : most};
}

/** The place of a value on a scale, 0 … 1, as `Limits.share` of `quantities.py`. */
export function share({low, high, usual}, value) {
  const most = Math.max(Math.abs(low), Math.abs(high));
  const place = (v) => {
    const size = Math.abs(v), more = (1 - USUAL) * (size - usual) / (most - usual);
    if (most <= usual) return v / (usual || 1);
    return Math.sign(v) * (size > usual ? USUAL + more : USUAL * size / usual);
  };
  return (place(value) - place(low)) / ((place(high) - place(low)) || 1);
}
