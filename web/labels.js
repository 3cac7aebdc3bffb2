// Where the labels of a plot's points go: beside their point, none over another, the same for the same points.

const [lineHeight, gap, reach] = [16, 10, 7];  // of a line of text; from a point's middle to its text; of what a point covers

// Pixels of letters at 11.5 px, no less than those of DejaVu Sans and Verdana, the widest that 'sans-serif' usually is.
const letters = [[/[mwMW@%]/, 11.5], [/[=+<>~×]/, 9.8], [/[A-Z]/, 9.1], [/[ijl.,:;|' ]/, 4.2]];
export const widthOf = (text) => [...text].reduce((sum, letter) => sum + (letters.find(([kind]) => kind.test(letter))?.[1] ?? 7.5), 0);

const apart = (a, b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;

// Beside the point, then line by line farther up and down, on the side where there is more room first.
function* places(point, box) {
  const width = widthOf(point.text);
  const sides = point.x + gap + width <= box.right ? ['start', 'end'] : ['end', 'start'];
  for (let line = 0; line * lineHeight < box.bottom - box.top; ++line) {
    for (const dy of line === 0 ? [0] : [line * lineHeight, -line * lineHeight]) {
      for (const anchor of sides) {
        const left = anchor === 'start' ? point.x + gap : point.x - gap - width;
        const top = point.y + dy - lineHeight / 2;
        const place = {left, right: left + width, top, bottom: top + lineHeight, anchor, dy};
        if (left >= box.left && place.right <= box.right && top >= box.top && place.bottom <= box.bottom) yield place;
      }
    }
  }
}

/**
 * For each of `points` {x, y, text} where its text goes, {x, y: of the base line, anchor, dy: how far below its point}, or null where
 * the box {left, right, top, bottom} has no room left. Points are not covered while a label has another place within three lines.
 */
export function placeLabels(points, box) {
  const covered = points.map(({x, y}) => ({left: x - reach, right: x + reach, top: y - reach, bottom: y + reach}));
  const taken = [];
  return points.map((point) => {
    const free = [...places(point, box)].filter((place) => taken.every((other) => apart(place, other)));
    const clear = free.find((place) => Math.abs(place.dy) <= 3 * lineHeight && covered.every((other) => apart(place, other)));
    const place = clear ?? free[0];
    if (!place) return null;
    taken.push(place);
    return {x: place.anchor === 'start' ? place.left : place.right, y: place.bottom - 4.5, anchor: place.anchor, dy: place.dy};
  });
}
