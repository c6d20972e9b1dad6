// The page that edits a scene: the finger of the text, its stiffness along the plate, and a map of one force of unknown contact. The text can be saved.
// Directions are those that friction allows, with equal parts of the cone; the report's share counts in the same way, but over several forces and images.
function edit(root, data, ask) {
  'use strict';
  const { start, plate, add, path, CLASSES, colourOf } = finray;
  const WAIT_MS = 300; // after the last key
  const PLACES = 14, SECTORS = 9, CONE_DEG = data.cone_deg;
  const ANGLES_DEG = Array.from({ length: SECTORS }, (_, i) => Math.round(CONE_DEG * ((2 * i + 1) / SECTORS - 1)));
  const MEAN_ABSOLUTE = Math.sqrt(2 / Math.PI); // mean error of a normal error, in standard deviations
  const FARTHEST = 0.1; // largest motion of the contact under the largest force, as a share of the plate
  const [area, wrong, results] = ['.push-scene', '.push-error', '.own-results'].map((part) => document.querySelector(part));
  let state = {}, turn = 0;

  const asked = (s_mm, angle_deg, force_n, contact) => ({ push: { s_mm, angle_deg, force_n, contact, estimator: 'nonlinear', noise_mm: state.noise_mm ?? data.noise_mm, image: 1 } });

  /** Motion of the contact under a force along the normal, divided by the force, mm/N. */
  function compliance(drawing, s_mm, force_n) {
    const { bent } = ask(asked(s_mm, 0, force_n, 'unasked'));
    return bent ? Math.hypot(...add(bent.at, plate(drawing).at(s_mm), -1)) / force_n : null;
  }

  function update() {
    const drawing = ask({ finger: { scene: area.value } });
    wrong.textContent = drawing.error ?? '';
    if (drawing.error) return;
    // Under a small force the finger is linear; the largest force follows from its stiffness.
    const tiny_n = 1e-6, middle = compliance(drawing, 0.5 * drawing.front_mm, tiny_n);
    const most_n = area.value === data.scene ? data.most_n : Number(((FARTHEST * drawing.front_mm) / middle).toPrecision(2));
    state = start(root, { ...data, noise_mm: drawing.noise_mm ?? data.noise_mm, most_n, first_n: area.value === data.scene ? data.first_n : most_n / 2 }, ask, drawing, state.s_mm ? { s_mm: state.s_mm, angle_deg: state.angle_deg } : {});
    turn += 1;
    show(drawing, tiny_n, turn);
  }

  function show(drawing, tiny_n, mine) {
    const places = Array.from({ length: PLACES }, (_, i) => ((i + 1) * drawing.front_mm) / PLACES);
    const stiffness = places.map((s_mm) => 1 / compliance(drawing, s_mm, tiny_n));
    const note = html('p', { class: 'legend' }), grid = svg('g');
    const button = html('button', { type: 'button' }, 'Map this force');
    results.replaceChildren(html('h2', {}, 'Stiffness'), chart(places, stiffness, drawing.front_mm),
      html('p', { class: 'legend' }, 'A small force along the normal, divided by the motion of its contact.'), html('h2', {}, 'Map of one force'), button,
      svg('svg', { viewBox: '0 0 100 58', role: 'img', 'aria-label': 'Expected error of the force by position and direction' }, grid), note);
    note.textContent = 'Expected mean error of the sensed force, contact unknown, by position (base to tip) and direction.';
    button.addEventListener('click', () => map(drawing, places, grid, note, mine));
    map(drawing, places, grid, note, mine);
  }

  function chart(places, values, front_mm) {
    const most = Math.max(...values), x = (s_mm) => 12 + (86 * s_mm) / front_mm, y = (value) => 44 - (38 * value) / most;
    const text = (at_x, at_y, words, anchor = 'middle') => svg('text', { x: at_x, y: at_y, 'text-anchor': anchor }, words);
    return svg('svg', { viewBox: '0 0 100 54', class: 'own-chart', role: 'img', 'aria-label': 'Stiffness along the plate' },
      svg('path', { d: 'M12,4V44H98', class: 'push-scale' }), svg('path', { d: path(places.map((s_mm, i) => [x(s_mm), -y(values[i])])), class: 'own-line' }),
      ...[most, most / 2, 0].map((value) => text(11, y(value) + 1, number(value), 'end')), text(1, 3.5, 'N/mm', 'start'),
      ...[0, front_mm / 2, front_mm].map((s_mm) => text(x(s_mm), 49, number(s_mm), s_mm === front_mm ? 'end' : 'middle')), text(55, 53, 'mm from the base'));
  }

  /** Asks for one row of the map in each frame. */
  function map(drawing, places, grid, note, mine) {
    const { force_n } = state, wide = 86 / places.length, high = 44 / ANGLES_DEG.length;
    const counts = { within: 0, all: 0, refused: 0 };
    grid.replaceChildren();
    const row = (i) => {
      if (mine !== turn || i === ANGLES_DEG.length) return;
      places.forEach((s_mm, k) => {
        const { bent } = ask(asked(s_mm, ANGLES_DEG[i], force_n, 'sought')), force = bent?.sensed.force;
        const share = force && force.sigma_n !== null ? MEAN_ABSOLUTE * force.sigma_n / force_n : null, colour = colourOf(share);
        const words = !bent ? 'not carried' : share === null ? 'refused' : `${number(100 * share, 2)} %`;
        grid.append(svg('rect', { x: 12 + k * wide, y: 2 + (ANGLES_DEG.length - 1 - i) * high, width: wide, height: high, fill: colour, class: 'own-cell' },
          svg('title', {}, `${number(s_mm)} mm, ${ANGLES_DEG[i]} deg: ${words}`)));
        counts.all += bent ? 1 : 0;
        counts.refused += bent && share === null ? 1 : 0;
        counts.within += share !== null && share <= CLASSES[2][0];
      });
      grid.append(svg('text', { x: 11, y: 2 + (ANGLES_DEG.length - 0.35 - i) * high, 'text-anchor': 'end' }, `${ANGLES_DEG[i]}`));
      note.textContent = `${number(force_n)} N, contact unknown: expected error within 10 % in ${number(100 * counts.within / Math.max(counts.all, 1), 2)} % of the plate and of the directions that friction allows (up to ${number(CONE_DEG)} deg), ${counts.refused} of ${counts.all} refused. The error follows from the stated standard deviation of one image; the report's first page takes the worst of four forces. Green: within 2, 5, 10 %; amber: 25 %; red: more; grey: refused or not carried.`;
      requestAnimationFrame(() => row(i + 1));
    };
    row(0);
  }

  document.querySelector('.push-save').addEventListener('click', () => {
    const link = html('a', { href: URL.createObjectURL(new Blob([area.value], { type: 'text/plain' })), download: 'scene.toml' });
    link.click();
    URL.revokeObjectURL(link.href);
  });
  let waits = 0;
  area.addEventListener('input', () => { clearTimeout(waits); waits = setTimeout(update, WAIT_MS); });
  area.value = data.scene;
  update();
}
