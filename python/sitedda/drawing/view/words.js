// Elements of a page, numbers with their units, ticks and colours.

export const DARK = matchMedia("(prefers-color-scheme: dark)");

export function element(tag, parent, text = "", name = "") {
  const node = document.createElement(tag);
  if (text) node.textContent = text;
  if (name) node.className = name;
  if (parent) parent.append(node);
  return node;
}

const PREFIXES = {
  m: [[1, "m"], [1e-3, "mm"], [1e-6, "µm"], [1e-9, "nm"]],
  "m/s": [[1, "m/s"], [1e-3, "mm/s"], [1e-6, "µm/s"]],
  Pa: [[1e9, "GPa"], [1e6, "MPa"], [1e3, "kPa"], [1, "Pa"]],
  "N/m": [[1e9, "GN/m"], [1e6, "MN/m"], [1e3, "kN/m"], [1, "N/m"]],
  "J/m": [[1e9, "GJ/m"], [1e6, "MJ/m"], [1e3, "kJ/m"], [1, "J/m"]],
};

export function inUnit(largest, unit) {
  const steps = PREFIXES[unit] || [[1, unit]];
  for (const step of steps) if (Math.abs(largest) >= step[0]) return step;
  return largest === 0 ? steps.find((step) => step[0] === 1) || steps[0] : steps[steps.length - 1];
}

export function short(value) {
  if (!isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-4 ? value.toExponential(2) : String(+value.toPrecision(4));
}

export function withUnit(value, unit) {
  const [scale, name] = inUnit(value, unit);
  return `${short(value / scale)} ${name}`;
}

/** Round numbers for about so many ticks. */
export function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count);
  if (!(raw > 0) || !isFinite(raw)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
  const found = [];
  for (let t = Math.ceil(low / step - 1e-9) * step; t <= high + 1e-9 * step; t += step) {
    found.push(Math.abs(t) < 1e-9 * step ? 0 : t);
  }
  return found;
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
